"""What a model's effects on instruments and control paths did to a record, undone.

A model may say that a vane is late, that two gyros are swapped, that an accelerometer sits
elsewhere, that play lies between servo and surface. Output error predicts the record with all that
in it. Whoever starts from the record instead (equation error, and what drives output error) takes
it out first, here, with the model's own values.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.dynamics.actuators import simulate_control_path
from gsapp.dynamics.atmosphere import SEA_LEVEL_DENSITY
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.model import Model
from gsapp.dynamics.signal_terms import (
    SURFACE_CHANNELS,
    PathResponse,
    PathTerms,
    Saturation,
    invert_path,
)
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.preparation_settings import PREPARATION
from gsapp.identification.smoothing import interpolate_missing
from gsapp.quantities import Block, BoolArray, FloatArray

_OUTSIDE_PREFIXES = ("control.", "sensor.")


def has_instrument_effects(model: Model | None) -> bool:
    """Return whether a model has effects on instruments or control paths."""
    return model is not None and any(one.id.startswith(_OUTSIDE_PREFIXES) for one in model.effects)


def undo_instrument_effects(
    maneuver: Maneuver, model: Model, *, keep: Collection[str] = ()
) -> Maneuver:
    """Return a maneuver with what the model says of its instruments undone.

    `model`: its values count; nothing is estimated.
    `keep`: channels whose paths somebody else predicts. Swapped channels go back in any case.

    The same object where there is nothing to undo. Samples that an effect cut off are missing.
    """
    flight_model = FlightModel(maneuver.aircraft, model)
    paths = {
        channel: path for channel, path in flight_model.sensor_terms.items() if channel not in keep
    }
    return _map_channels(_undo_swaps(maneuver, flight_model.swapped_channels), paths, invert_path)


def effective_record(maneuver: Maneuver, model: Model) -> Maneuver:
    """Return a maneuver as instruments without fault on the surfaces themselves would show it.

    Beyond `undo_instrument_effects`, the record of controls passes their paths, and the aircraft
    has its instruments where the model says that they sit.
    """
    true = undo_instrument_effects(maneuver, model)
    flight_model = FlightModel(maneuver.aircraft, model)
    controls = {
        SURFACE_CHANNELS[surface]: path for surface, path in flight_model.control_terms.items()
    }
    moved = _map_channels(true, controls, simulate_control_path)
    if not flight_model.displaced_instruments:
        return moved
    return replace(moved, aircraft=_relocate_instruments(maneuver.aircraft, flight_model))


def without_path_effects(model: Model) -> Model:
    """Return a model without its effects on instruments and control paths."""
    kept = tuple(one for one in model.effects if not one.id.startswith(_OUTSIDE_PREFIXES))
    return model.model_copy(update={"effects": kept})


def without_swaps(model: Model) -> Model:
    """Return a model in which no channels are swapped."""
    kept = tuple(one for one in model.effects if not one.id.endswith(".swapped"))
    return model.model_copy(update={"effects": kept})


def effective_records(
    maneuvers: Sequence[Maneuver], model: Model | None
) -> tuple[list[Maneuver], Model | None]:
    """Return maneuvers corrected by `effective_record`, and the model without those effects."""
    if model is None or not has_instrument_effects(model):
        return list(maneuvers), model
    return [effective_record(one, model) for one in maneuvers], without_path_effects(model)


# --- steps --------------------------------------------------------------------------------------


def _undo_swaps(maneuver: Maneuver, pairs: Sequence[tuple[str, str]]) -> Maneuver:
    """Return the maneuver with pairs of channels back in their places, the last swap first."""
    for one, other in reversed(pairs):
        turned = {one: other, other: one}
        names = tuple(turned.get(name, name) for name in maneuver.block.channels)
        block = replace(maneuver.block, channels=names)
        clipped = {turned.get(name, name): flags for name, flags in maneuver.clipped.items()}
        maneuver = replace(maneuver, block=block, clipped=clipped)
    return maneuver


def _map_channels(
    maneuver: Maneuver,
    paths: Mapping[str, PathTerms],
    walk: Callable[[PathTerms, FloatArray, float], PathResponse],
) -> Maneuver:
    """Return the maneuver with channels sent along their paths, forward or backward."""
    block = maneuver.block
    columns = [(name, path) for name, path in paths.items() if path and name in block.channels]
    if not columns:
        return maneuver
    values = block.values.copy()
    for name, path in columns:
        column = block.channels.index(name)
        values[:, column] = _propagate_channel(values[:, column], path, maneuver.dt, walk)
    edited = Block(channels=block.channels, times=block.times, values=values)
    return replace(maneuver, block=edited)


def _propagate_channel(
    samples: FloatArray,
    path: PathTerms,
    dt: float,
    walk: Callable[[PathTerms, FloatArray, float], PathResponse],
) -> FloatArray:
    """Return a channel after its path; what depends on missing samples is missing."""
    lost = ~np.isfinite(samples)
    if lost.all():
        return samples
    if walk is invert_path:
        lost |= _saturated_samples(samples, path)
    found = walk(path, interpolate_missing(samples, lost), dt)
    reach = found.tangent(lost.astype(np.float64)[:, None])[:, 0]
    return np.where(np.abs(reach) > PREPARATION.max_interpolated_share, np.nan, found.values)


def _saturated_samples(samples: FloatArray, path: PathTerms) -> BoolArray:
    """Return the samples at the end of the range that the path's last effect leaves."""
    if not path or not isinstance(path[-1][0], Saturation):
        return np.zeros(samples.size, dtype=bool)
    (limit,) = path[-1][1]
    return np.asarray(
        np.abs(samples) >= limit * (1.0 - PREPARATION.limit_tolerance), dtype=np.bool_
    )


def _relocate_instruments(aircraft: Aircraft, flight_model: FlightModel) -> Aircraft:
    """Return the aircraft with its instruments where the model says that they sit."""
    state = (1.0, *(0.0,) * 8)
    inputs = (*(0.0,) * 6, SEA_LEVEL_DENSITY, aircraft.mass.mass)
    own = flight_model.steady_states(state, inputs)
    sensors = aircraft.sensors
    moved = {}
    for name, off in flight_model.evaluate((*state, *own), inputs).position_offsets.items():
        old = getattr(sensors, name)
        position = tuple(float(p + d) for p, d in zip(old.position, off, strict=True))
        moved[name] = old.model_copy(update={"position": position})
    return aircraft.model_copy(update={"sensors": sensors.model_copy(update=moved)})

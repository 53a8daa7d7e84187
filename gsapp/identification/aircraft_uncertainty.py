"""Bounds that allow for what neither aircraft file nor record knows well.

The noise of a record says nothing of an accelerometer three centimeters from where the file puts
it, of a gyro that is late, or of a mass that was guessed. All of these bend derivatives by more
than the noise does, many without leaving a trace in the residuals: in p_dot z, for one, p_dot is as
linear in beta, p and the deflections as the side force is. The file says how well it is known
(``[accuracy]``); of what it does not say, typical values are taken. Each value is moved by its
standard deviation, the estimate is made again, and the square of the change is added to the
covariance. It is the same aircraft in every maneuver: this part of a bound does not shrink with
their number (`DerivativeEstimate.offset`).

A record with few samples a second does not say when between two of them a surface moved. A step in
an interval dt is off by dt/sqrt(12), and by so much the impulse that it gave. Each large step of a
record is moved in the same way, apart from the others.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.foundation import FlightError
from gsapp.identification.axes import Axis
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.preparation_settings import PREPARATION
from gsapp.identification.record_preparation import advance_samples
from gsapp.identification.results import Estimate
from gsapp.quantities import Block, FloatArray

_POSITIONS: dict[Axis, tuple[tuple[str, int], ...]] = {
    "lon": (("alpha_vane", 0), ("accelerometer", 0), ("accelerometer", 2)),
    "lat": (("beta_vane", 0), ("beta_vane", 2), ("accelerometer", 0), ("accelerometer", 2)),
}
"""Instruments and the axes (x, y, z) along which their position shows."""
_CHANNELS: dict[Axis, tuple[str, ...]] = {
    "lon": ("alpha", "q", "theta", "V", "an", "ax", "de"),
    "lat": ("beta", "p", "r", "phi", "ay", "da", "dr"),
}
_VANES: dict[Axis, tuple[str, ...]] = {"lon": ("alpha_vane",), "lat": ("beta_vane",)}
_ACCELERATIONS: dict[Axis, tuple[str, ...]] = {"lon": ("ax", "an"), "lat": ("ay",)}
_SURFACES: dict[Axis, tuple[str, ...]] = {"lon": ("de",), "lat": ("da", "dr")}


@dataclass(frozen=True, slots=True, kw_only=True)
class UncertainValue:
    """A value of the aircraft file, in words, and how to move it by its standard deviation."""

    title: str
    move: Callable[[Maneuver], Maneuver]
    is_shared: bool = True  # By all maneuvers.

    def advice(self, *, is_stated: bool) -> str:
        """Return how uncertain it is, and what makes smaller bounds; `is_stated`: by the file."""
        if not self.is_shared:
            return ": record at a higher rate for smaller bounds"
        source = "the aircraft file states" if is_stated else "on a typical aircraft"
        return f", as uncertain as {source}: measure it for smaller bounds"


def uncertain_values(
    aircraft: Aircraft, axis: Axis, *, compares_responses: bool
) -> tuple[UncertainValue, ...]:
    """Return what the file says of its own accuracy that matters for an axis.

    Zeros of accelerometers count where responses are compared: coefficients allow for them already.
    """
    found = [
        one for each in _single_axes(axis) for one in _of_axis(aircraft, each, compares_responses)
    ]
    if aircraft.accuracy.mass:
        found.append(UncertainValue(title="mass", move=_more_mass))
    return tuple(found)


def _single_axes(axis: Axis) -> tuple[Axis, ...]:
    return ("lon", "lat") if axis == "both" else (axis,)


def _of_axis(aircraft: Aircraft, axis: Axis, compares_responses: bool) -> Iterator[UncertainValue]:
    accuracy = aircraft.accuracy
    if accuracy.position:
        for instrument, direction in _POSITIONS[axis]:
            yield UncertainValue(
                title=f"{'xyz'[direction]} position of the {instrument.replace('_', ' ')}",
                move=partial(_moved_instrument, instrument=instrument, direction=direction),
            )
    if accuracy.upwash:
        for vane in _VANES[axis]:
            yield UncertainValue(
                title=f"upwash at the {vane.replace('_', ' ')}",
                move=partial(_more_upwash, vane=vane),
            )
    if accuracy.delay:
        for channel in _CHANNELS[axis]:
            yield UncertainValue(
                title=f"delay of {channel}", move=partial(_less_late, channel=channel)
            )
    if accuracy.accelerometer_bias and compares_responses:
        for channel in _ACCELERATIONS[axis]:
            yield UncertainValue(
                title=f"zero of {channel}", move=partial(_less_bias, channel=channel)
            )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class AircraftUncertainty:
    """What the accuracy of the aircraft file does to derivatives."""

    changes: Sequence[tuple[UncertainValue, Mapping[str, float]]]
    """What was moved by its standard deviation, and what it did to each derivative."""
    is_stated: bool  # Whether by the aircraft file.

    def added_to(self, found: Estimate) -> Estimate:
        """Return an estimate whose bounds allow for it."""
        if not self.changes or not found.free or not found.converged:
            return found
        added = np.zeros_like(found.covariance)
        shared = np.zeros(len(found.free))
        parts: dict[str, FloatArray] = {}
        advice: dict[str, str] = {}
        for moved, changes in self.changes:
            change = np.array([changes.get(name, 0.0) for name in found.free])
            added += np.outer(change, change)
            shared += moved.is_shared * change**2
            parts[moved.title] = parts.get(moved.title, 0.0) + change**2
            advice[moved.title] = moved.advice(is_stated=self.is_stated)
        covariance = found.covariance + added
        derivatives = dict(found.derivatives)
        for index, name in enumerate(found.free):
            one = derivatives[name]
            derivatives[name] = replace(
                one,
                std=float(np.sqrt(covariance[index, index])),
                offset=float(np.hypot(one.offset, np.sqrt(shared[index]))),
            )
        remarks = _largest_parts_text(found.free, parts, covariance.diagonal(), advice)
        return replace(
            found,
            derivatives=derivatives,
            covariance=covariance,
            warnings=(*found.warnings, *remarks),
        )


def aircraft_uncertainty(
    found: Estimate,
    maneuvers: Sequence[Maneuver],
    estimate: Callable[[Sequence[Maneuver]], Estimate],
    *,
    compares_responses: bool,
) -> AircraftUncertainty:
    """Return what the accuracy of the aircraft file does to the derivatives of an estimate.

    Parameters
    ----------
    maneuvers : sequence of Maneuver
        That it was made from.
    estimate : callable
        Makes it again from changed ones.
    compares_responses : bool
        Whether its method fits responses, not coefficients.
    """
    aircraft = maneuvers[0].aircraft
    values = (
        *uncertain_values(aircraft, found.axis, compares_responses=compares_responses),
        *_input_steps(maneuvers, found.axis),
    )
    changes: list[tuple[UncertainValue, Mapping[str, float]]] = []
    for one in values if found.free and found.converged else ():
        try:
            moved = estimate([one.move(maneuver) for maneuver in maneuvers])
        except FlightError:
            continue
        if moved.converged:
            change = {
                name: other - (found.value(name) or 0.0)
                for name in found.free
                if (other := moved.value(name)) is not None
            }
            changes.append((one, change))
    return AircraftUncertainty(changes=changes, is_stated=aircraft.states_accuracy)


def _largest_parts_text(
    names: Sequence[str],
    parts: Mapping[str, FloatArray],
    variances: FloatArray,
    advice: Mapping[str, str],
) -> Iterator[str]:
    """Say what to do about values that make more than half the variance of some derivatives."""
    for title, part in parts.items():
        ruled = [name for name, large in zip(names, part > 0.5 * variances, strict=True) if large]
        if ruled:
            yield f"the bounds of {', '.join(ruled)} come mostly from the {title}{advice[title]}"


# --- moves --------------------------------------------------------------------------------------


def _moved_instrument(maneuver: Maneuver, instrument: str, direction: int) -> Maneuver:
    position = list(getattr(maneuver.aircraft.sensors, instrument).position)
    position[direction] += maneuver.aircraft.accuracy.position
    return _with_sensor(maneuver, instrument, position=tuple(position))


def _more_upwash(maneuver: Maneuver, vane: str) -> Maneuver:
    upwash = getattr(maneuver.aircraft.sensors, vane).upwash
    return _with_sensor(maneuver, vane, upwash=upwash * (1.0 + maneuver.aircraft.accuracy.upwash))


def _with_sensor(maneuver: Maneuver, instrument: str, **update: object) -> Maneuver:
    sensors = maneuver.aircraft.sensors
    changed = getattr(sensors, instrument).model_copy(update=update)
    moved = sensors.model_copy(update={instrument: changed})
    return replace(maneuver, aircraft=maneuver.aircraft.model_copy(update={"sensors": moved}))


def _less_late(maneuver: Maneuver, channel: str) -> Maneuver:
    steps = maneuver.aircraft.accuracy.delay / maneuver.dt
    return _with_channel(maneuver, channel, lambda samples: advance_samples(samples, steps))


def _less_bias(maneuver: Maneuver, channel: str) -> Maneuver:
    bias = maneuver.aircraft.accuracy.accelerometer_bias
    return _with_channel(maneuver, channel, lambda samples: samples - bias)


def _with_channel(
    maneuver: Maneuver, channel: str, change: Callable[[FloatArray], FloatArray]
) -> Maneuver:
    block = maneuver.block
    names = (channel, "qbar") if channel == "V" else (channel,)
    values = block.values.copy()
    for name in names:
        if name in block:
            column = block.channels.index(name)
            values[:, column] = change(values[:, column])
    return replace(maneuver, block=Block(channels=block.channels, times=block.times, values=values))


def _input_steps(maneuvers: Sequence[Maneuver], axis: Axis) -> Iterator[UncertainValue]:
    """Return the steps of surfaces that slow records do not place in time."""
    for surface in (name for each in _single_axes(axis) for name in _SURFACES[each]):
        counts = [len(_steps(one, surface)) for one in maneuvers]
        for rank in range(max(counts)):
            yield UncertainValue(
                title=f"steps of {surface} between the samples",
                move=partial(_moved_step, surface=surface, rank=rank),
                is_shared=False,
            )


def _steps(maneuver: Maneuver, surface: str) -> list[tuple[int, float]]:
    """Return the intervals in which a surface made a step, and its size (rad); largest first.

    What goes on through several intervals is known from them: a step differs from its neighbors.
    """
    if maneuver.dt < PREPARATION.slow_sample_time or surface not in maneuver.block:
        return []
    moves = np.nan_to_num(np.diff(maneuver.block.values[:, maneuver.block.channels.index(surface)]))
    bends = np.abs(np.diff(moves, prepend=0.0, append=0.0))
    sizes = np.sign(moves) * np.minimum.reduce((np.abs(moves), bends[:-1], bends[1:]))
    largest = np.argsort(-np.abs(sizes), kind="stable")[: PREPARATION.max_steps]
    least = PREPARATION.min_step_share * abs(sizes[largest[0]]) if len(largest) else 0.0
    return [(int(index), float(sizes[index])) for index in largest if abs(sizes[index]) > least]


def _moved_step(maneuver: Maneuver, surface: str, rank: int) -> Maneuver:
    steps = _steps(maneuver, surface)
    if rank >= len(steps):
        return maneuver
    index, size = steps[rank]

    def change(samples: FloatArray) -> FloatArray:
        moved = samples.copy()
        moved[index : index + 2] += 0.5 * size / np.sqrt(12.0)
        return moved

    return _with_channel(maneuver, surface, change)


def _more_mass(maneuver: Maneuver) -> Maneuver:
    return replace(maneuver, mass=maneuver.mass * (1.0 + maneuver.aircraft.accuracy.mass))

"""Columns of parameters on signal paths: controls between record and surface, and instruments."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType

import numpy as np

from gsapp.discrepancy.filter_error.instrument_delay import delay_sensitivity, instrument_output
from gsapp.discrepancy.filter_error.motion_linearization import CONTROLS, Linearization
from gsapp.discrepancy.filter_error.sensitivity_columns import SensitivityColumn, SensitivityEntry
from gsapp.dynamics.flight_model import MODEL_INPUTS, FlightModel
from gsapp.dynamics.recorded_controls import simulate_control_path
from gsapp.dynamics.signal_terms import SURFACE_CHANNELS, PathResponse, PathTerms, invert_path
from gsapp.quantities import FloatArray

_SHARE = 1e-3
_STEPS = {"s": 1e-4, "rad": 1e-5, "rad/s": 1e-4}
"""Steps of differences by parameters of these units; else a share of the value."""


_PathFunction = Callable[[PathTerms], FloatArray]
"""What comes through a path, for any values of its effects."""


def path_columns(model: FlightModel, found: Linearization) -> dict[str, SensitivityColumn]:
    """Return the columns of all parameters on the paths of a model, by name."""
    columns: dict[str, SensitivityColumn] = {}
    record = found.record
    dt = record.dt
    for surface, terms in model.control_terms.items():
        name = SURFACE_CHANNELS[surface]
        signal = record.motion.inputs.T[MODEL_INPUTS.index(name)]
        for key, slope in _path_derivatives(
            terms, _control_path(simulate_control_path, signal, dt)
        ):
            columns[key] = (SensitivityEntry(target=name, history=slope),)
    for channel, terms in model.sensor_terms.items():
        if channel in CONTROLS:
            signal = record.motion.inputs.T[MODEL_INPUTS.index(channel)]
            for key, slope in _path_derivatives(terms, _control_path(invert_path, signal, dt)):
                columns[key] = (
                    *columns.get(key, ()),
                    SensitivityEntry(target=channel, history=slope),
                )
        if channel in record.channels:
            column = record.channels.index(channel)
            signal, rate = found.sensor_inputs[:, column], found.sensor_input_rates[:, column]
            late = delay_sensitivity(found.paths[column], signal, rate, dt)
            for key, slope in _path_derivatives(terms, _sensor_path(signal, rate, dt), late):
                old = columns.get(key, ())
                columns[key] = (*old, SensitivityEntry(target=f"channel.{channel}", history=slope))
    return columns


def _control_path(
    way: Callable[[PathTerms, FloatArray, float], PathResponse], signal: FloatArray, dt: float
) -> _PathFunction:
    """Return how a signal comes through a path of controls, or back through one."""
    return lambda path: way(path, signal, dt).values


def _sensor_path(signal: FloatArray, rate: FloatArray, dt: float) -> _PathFunction:
    """Return what instruments make of what they are exposed to."""
    return lambda path: instrument_output(path, signal, rate, dt)


def _path_derivatives(
    path: PathTerms,
    through: _PathFunction,
    known: Mapping[str, FloatArray] = MappingProxyType({}),
) -> Iterator[tuple[str, FloatArray]]:
    """Yield the derivatives of what comes through a path by its parameters.

    By differences, but for those that are known.
    """
    for place, (term, values) in enumerate(path):
        for index, item in enumerate(term.parameters):
            key = f"{term.id}.{item.name}"
            if key in known:
                yield key, known[key]
                continue
            step = _STEPS.get(item.unit, _SHARE * max(abs(values[index]), 1.0))

            def moved(by: float, place: int = place, index: int = index) -> FloatArray:
                changed = [
                    (
                        one,
                        tuple(x + by if (k, i) == (place, index) else x for i, x in enumerate(own)),
                    )
                    for k, (one, own) in enumerate(path)
                ]
                return through(tuple(changed))

            slope = (
                (moved(step) - moved(-step)) / (2.0 * step)
                if values[index] - step >= item.bounds[0]
                else (moved(step) - moved(0.0)) / step
            )
            yield key, np.asarray(slope)

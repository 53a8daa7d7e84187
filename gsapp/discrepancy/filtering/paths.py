"""Columns of parameters on signal paths: controls between record and surface, and instruments."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType

import numpy as np

from gsapp.discrepancy.filtering.columns import Column, Entry
from gsapp.discrepancy.filtering.lateness import by_lateness, shown
from gsapp.discrepancy.filtering.linearizing import CONTROLS, Linearization
from gsapp.dynamics.flight_model import INPUTS, FlightModel
from gsapp.dynamics.recorded_controls import acted
from gsapp.dynamics.signals import SURFACES, Path, Response, undo
from gsapp.quantities import FloatArray

_SHARE = 1e-3
_STEPS = {"s": 1e-4, "rad": 1e-5, "rad/s": 1e-4}
"""Steps of differences by parameters of these units; else a share of the value."""


_Walk = Callable[[Path], FloatArray]
"""What comes through a path, for any values of its effects."""


def path_columns(model: FlightModel, found: Linearization) -> dict[str, Column]:
    """Return the columns of all parameters on the paths of a model, by name."""
    columns: dict[str, Column] = {}
    record = found.record
    dt = record.dt
    for surface, terms in model.control_terms.items():
        name = SURFACES[surface]
        signal = record.motion.inputs.T[INPUTS.index(name)]
        for key, slope in _slopes(terms, _through(acted, signal, dt)):
            columns[key] = (Entry(place=name, history=slope),)
    for channel, terms in model.sensor_terms.items():
        if channel in CONTROLS:
            signal = record.motion.inputs.T[INPUTS.index(channel)]
            for key, slope in _slopes(terms, _through(undo, signal, dt)):
                columns[key] = (*columns.get(key, ()), Entry(place=channel, history=slope))
        if channel in record.channels:
            column = record.channels.index(channel)
            signal, rate = found.exposed[:, column], found.exposed_rates[:, column]
            late = by_lateness(found.paths[column], signal, rate, dt)
            for key, slope in _slopes(terms, _shown(signal, rate, dt), late):
                old = columns.get(key, ())
                columns[key] = (*old, Entry(place=f"channel.{channel}", history=slope))
    return columns


def _through(
    way: Callable[[Path, FloatArray, float], Response], signal: FloatArray, dt: float
) -> _Walk:
    """Return how a signal comes through a path of controls, or back through one."""
    return lambda path: way(path, signal, dt).values


def _shown(signal: FloatArray, rate: FloatArray, dt: float) -> _Walk:
    """Return what instruments make of what they are exposed to."""
    return lambda path: shown(path, signal, rate, dt)


def _slopes(
    path: Path,
    through: _Walk,
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

"""One maneuver of a fit: where it stands, and what its filter shows of columns and residual.

A `SensitivityColumn` is the derivative of the equations by one parameter, as histories of the
coefficient, control or channel that it enters. `filter_inputs` turns columns into what the filter
takes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from gsapp.dynamics.actuators import simulate_control_path
from gsapp.dynamics.flight_model import MODEL_INPUTS, FlightModel
from gsapp.dynamics.signal_terms import SURFACE_CHANNELS, PathResponse, PathTerms, invert_path
from gsapp.dynamics.terms import COEFFICIENTS
from gsapp.identification.filter_error.equation_jacobian import CONTROLS
from gsapp.identification.filter_error.instrument_output import delay_sensitivity, instrument_output
from gsapp.identification.filter_error.kalman import SteadyStateFilter
from gsapp.identification.filter_error.motion_linearization import (
    Linearization,
    ManeuverRecord,
    NominalMotion,
)
from gsapp.identification.filter_error.noise_model import NoiseModel
from gsapp.identification.filter_error.settings import FILTER_ERROR
from gsapp.quantities import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SensitivityEntry:
    """A history entering one place."""

    target: str
    """A coefficient (``Cm``), a control (``de``), a channel, as ``channel.q``, or ``free.<name>``:
    all that a free parameter of the equations changes, times the history."""
    history: FloatArray  # Shape (n,).


SensitivityColumn = tuple[SensitivityEntry, ...]
"""All that one parameter changes, in one maneuver."""


def filter_inputs(
    own: SteadyStateFilter, columns: Sequence[SensitivityColumn], room: int = 0
) -> tuple[FloatArray, FloatArray]:
    """Return z (n_blocks, n_channels, m) and b (n_blocks - 1, n_x, m) of `innovations`.

    The innovations of a column are what the residual's innovations hold of it for a parameter of
    1; the deviations, what the filter's prediction must be corrected by, with a minus sign. Columns
    of zeros, as many as `room` says, stand behind them: m is the number of both.
    """
    found = own.linearization
    channels = found.record.channels
    n_blocks, n_channels, n_x = own.blocks.by_state.shape
    out = np.zeros((n_blocks, n_channels + n_x, len(columns) + room))
    by_place: dict[str, list[tuple[int, FloatArray]]] = {}
    for number, column in enumerate(columns):
        for entry in column:
            by_place.setdefault(entry.target, []).append((number, entry.history))
    for place, entries in by_place.items():
        numbers = [number for number, _ in entries]
        histories = _samples(np.column_stack([history for _, history in entries]), own)
        if place.startswith("channel."):
            name = place.removeprefix("channel.")
            if name in channels:
                out[:, channels.index(name), numbers] += histories[:, :-1].mean(axis=1)
            continue
        rate, output = (_samples(one, own) for one in _target_gains(found, place))
        by_sample = (own.blocks.rate_response @ rate[:, :, :, None])[:, :, :, 0].transpose(0, 2, 1)
        by_sample[:, :n_channels, :-1] += output[:, :-1].transpose(0, 2, 1) / own.block_size
        changes = by_sample @ histories
        for part, run in _consecutive_runs(numbers):
            out[:, :, run] += changes[:, :, part]
    return out[:, :n_channels], out[:-1, n_channels:]


def _consecutive_runs(numbers: Sequence[int]) -> list[tuple[slice, slice]]:
    """Return the stretches of numbers that follow each other: where they stand, and themselves."""
    starts = [k for k, one in enumerate(numbers) if not k or one != numbers[k - 1] + 1]
    return [
        (slice(start, stop), slice(numbers[start], numbers[start] + stop - start))
        for start, stop in zip(starts, [*starts[1:], len(numbers)], strict=True)
    ]


def _samples(history: FloatArray, own: SteadyStateFilter) -> FloatArray:
    """Return the samples of each block and the one after it, (n_blocks, block + 1, ...)."""
    n_blocks, block = len(own.by_state), own.block_size
    taken = np.empty((n_blocks, block + 1, history.shape[1]))
    taken[:, :-1] = history[: n_blocks * block].reshape(n_blocks, block, -1)
    after = history[block::block][:n_blocks]
    taken[: len(after), -1] = after
    taken[len(after) :, -1] = history[-1]
    return taken


def _target_gains(found: Linearization, place: str) -> tuple[FloatArray, FloatArray]:
    """Return by how much a place enters rates (n, n_states) and channels (n, n_channels)."""
    if place.startswith("free."):
        index = found.free.index(place.removeprefix("free."))
        return found.rate_by_free[:, :, index], found.output_by_free[:, :, index]
    if place in COEFFICIENTS:
        index = COEFFICIENTS.index(place)
        return found.rate_by_coefficient[:, :, index], found.output_by_coefficient[:, :, index]
    index = CONTROLS.index(place)
    return found.rate_by_control[:, :, index], found.output_by_control[:, :, index]


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
    return lambda path: way(path, signal, dt).values


def _sensor_path(signal: FloatArray, rate: FloatArray, dt: float) -> _PathFunction:
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
            step = _STEPS.get(item.unit, FILTER_ERROR.relative_step * max(abs(values[index]), 1.0))

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


class FilteredColumns(NamedTuple):
    """Columns of a maneuver seen through its filter."""

    innovations: FloatArray
    """Shape (n_blocks, n_channels, m + n_local + 1). Whitened: the columns, the initial states, the
    residual."""
    deviations: FloatArray  # Shape (n_blocks, n_x, m + n_local + 1).
    n_initial_states: int  # Number of initial states.

    @property
    def rows(self) -> FloatArray:
        return self.innovations.reshape(-1, self.innovations.shape[2])


@dataclass(slots=True, kw_only=True, eq=False)
class ManeuverState:
    """One maneuver of a fit: where its motion stands, and what the last pass made of it."""

    record: ManeuverRecord
    flight_model: FlightModel
    motion: NominalMotion
    own_derivatives: Mapping[str, float] = field(default_factory=dict)
    """Derivatives with a value of their own here: forces of the other axis, as measured."""
    filter: SteadyStateFilter | None = None
    filtered_columns: FilteredColumns | None = None

    @property
    def current_filter(self) -> SteadyStateFilter:
        """Return its filter.

        Raises `ValueError` if the maneuver has not been linearized.
        """
        if self.filter is None:
            raise ValueError(f"maneuver {self.record.id} was not linearized yet")
        return self.filter


def filter_columns(
    own: SteadyStateFilter, columns: Sequence[SensitivityColumn], bias: FloatArray
) -> FilteredColumns:
    """Return columns, initial states and residual as a filter sees them.

    `bias`, shape (n_channels,).
    """
    rest = own.blocks.initial_state_map
    (n_x, n_local), count = rest.shape, len(columns)
    own_z, own_b, _ = own.blocks.residual(bias)
    z, b = filter_inputs(own, columns, room=n_local + 1)
    z[:, :, -1], b[:, :, -1] = own_z, own_b
    start = np.zeros((n_x, count + n_local + 1))
    start[:, count : count + n_local] = -rest * own.blocks.scales[:n_local]
    innovations, deviations = own.innovations(z, b, start)
    return FilteredColumns(
        innovations=own.whitener @ innovations, deviations=deviations, n_initial_states=n_local
    )


def predicted_motion(one: ManeuverState, moves: FloatArray, bias: FloatArray) -> NominalMotion:
    """Return the motion that the filter predicts with moved parameters.

    Parameters
    ----------
    one : ManeuverState
        With what was seen of it in the last pass, which is used up; without it nothing can move.
    moves : ndarray, shape (m,)
        Of the columns that were seen; empty where none were.
    bias : ndarray, shape (n_channels,)
    """
    own = one.current_filter
    seen = one.filtered_columns or filter_columns(own, (), bias)
    one.filtered_columns = None
    count = len(moves)
    rows = seen.rows
    residual = rows[:, -1] - rows[:, :count] @ moves
    local = np.linalg.lstsq(rows[:, count:-1], residual, rcond=None)[0]
    change = seen.deviations[:, :, -1] - seen.deviations[:, :, :-1] @ np.concatenate((moves, local))
    _, _, within = own.blocks.residual(bias)
    moved = (own.blocks.state_response @ change[:, None, :, None])[:, :, :, 0] + within
    moved = moved.reshape(-1, moved.shape[2])
    # Samples beyond the last whole block follow from the last one in it.
    rest = [moved[-1]]
    for k in range(len(moved) - 1, len(one.record) - 1):
        rest.append(own.blocks.stepwise[k] @ rest[-1] + own.blocks.defects[k])
    moved = np.vstack((moved, *rest[1:])).T
    n_states = len(one.motion.states)
    return NominalMotion(
        states=one.motion.states + moved[:n_states],
        gust=own.blocks.gust + moved[n_states : n_states + len(own.blocks.gust)],
    )


def turbulent_motion(
    one: ManeuverState, noise: NoiseModel, random: np.random.Generator
) -> NominalMotion:
    """Return the motion of a maneuver as it would be in turbulence, its filter up to date."""
    blocks, dt = one.current_filter.blocks, one.record.dt
    gusts, n_states = blocks.gusts, blocks.n_states
    steps = blocks.stepwise
    lead = round(FILTER_ERROR.turbulence_lead / dt)
    moving = gusts.entries.shape[1]
    intensity = noise.process_noise(gusts.names, gusts.entries, blocks.moment_rows)
    size, shape = np.linalg.eigh(intensity * dt)
    pushes = random.standard_normal((lead + len(steps), moving)) * np.sqrt(np.maximum(size, 0.0))
    pushes = pushes @ shape.T
    x = np.zeros(steps.shape[1])
    moved = np.zeros((len(steps) + 1, len(x)))
    for k, push in enumerate(pushes):
        x = steps[max(k - lead, 0)] @ x
        x[:moving] += push
        if k + 1 >= lead:
            moved[k + 1 - lead] = x
    return NominalMotion(
        states=one.motion.states + moved[:, :n_states].T,
        gust=moved[:, n_states : n_states + gusts.count].T,
    )

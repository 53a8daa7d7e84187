"""What parameters change: histories that enter coefficients, inputs or channels.

A `SensitivityColumn` is the derivative of the equations by one parameter, as histories of the
coefficient, control or channel that it enters. `filter_inputs` turns columns into what the filter
takes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gsapp.discrepancy.filter_error.kalman import SteadyStateFilter
from gsapp.discrepancy.filter_error.motion_linearization import CONTROLS, Linearization
from gsapp.dynamics.terms import COEFFICIENTS
from gsapp.quantities import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SensitivityEntry:
    """A history entering one place.

    Attributes
    ----------
    target : str
        A coefficient (``Cm``), a control (``de``), a channel, as ``channel.q``, or ``free.<name>``:
        all that a free parameter of the equations changes, times the history.
    history : ndarray, shape (n,)
    """

    target: str
    history: FloatArray


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

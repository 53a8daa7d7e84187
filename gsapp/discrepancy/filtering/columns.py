"""What parameters change: histories that enter coefficients, inputs or channels.

A `Column` is the derivative of the equations by one parameter, as histories of the coefficient,
control or channel that it enters. `forcing` turns columns into what the filter takes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gsapp.discrepancy.filtering.kalman import Filter
from gsapp.discrepancy.filtering.linearizing import CONTROLS, Linearization
from gsapp.dynamics.terms import COEFFICIENTS
from gsapp.quantities import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Entry:
    """A history entering one place.

    Attributes
    ----------
    place : str
        A coefficient (``Cm``), a control (``de``), a channel, as ``channel.q``, or ``free.<name>``:
        all that a free parameter of the equations changes, times the history.
    history : ndarray, shape (n,)
    """

    place: str
    history: FloatArray


Column = tuple[Entry, ...]
"""All that one parameter changes, in one maneuver."""


def forcing(own: Filter, columns: Sequence[Column]) -> tuple[FloatArray, FloatArray]:
    """Return z (n_blocks, n_channels, m) and b (n_blocks - 1, n_x, m), for `Filter.innovations`.

    The innovations of a column are what the residual's innovations hold of it for a parameter of
    1; the deviations, what the filter's prediction must be corrected by, with a minus sign.
    """
    found = own.linearization
    channels = found.record.channels
    n_blocks, _, n_x = own.by_state.shape
    z = np.zeros((n_blocks, len(channels), len(columns)))
    b = np.zeros((n_blocks, n_x, len(columns)))
    by_place: dict[str, list[tuple[int, FloatArray]]] = {}
    for number, column in enumerate(columns):
        for entry in column:
            by_place.setdefault(entry.place, []).append((number, entry.history))
    seen, carried = _reaching(own)
    for place, entries in by_place.items():
        numbers = [number for number, _ in entries]
        stacked = np.column_stack([history for _, history in entries])
        if place.startswith("channel."):
            name = place.removeprefix("channel.")
            if name in channels:
                z[:, channels.index(name), numbers] += own.means(stacked)
            continue
        rate, output = (_samples(one, own) for one in _ways(found, place))
        histories = _samples(stacked, own)
        shown = np.einsum("nsyi,nsi->nys", seen, rate)
        shown[:, :, :-1] += output[:, :-1].transpose(0, 2, 1) / own.block
        z[:, :, numbers] += shown @ histories
        b[:, :, numbers] -= np.einsum("nsxi,nsi->nxs", carried, rate) @ histories
    return z, b[:-1]


def _samples(history: FloatArray, own: Filter) -> FloatArray:
    """Return the samples of each block and the one after it, (n_blocks, block + 1, ...)."""
    starts = own.block * np.arange(len(own.by_state))
    places = starts[:, None] + np.arange(own.block + 1)
    taken: FloatArray = history[np.minimum(places, len(history) - 1)]
    return taken


def _reaching(own: Filter) -> tuple[FloatArray, FloatArray]:
    """Return what rates at each sample of a block, and at the one after it, add.

    Rates run in straight lines from sample to sample, as in the residual, where half a sample's
    delay would be seen too.

    Returns
    -------
    seen : ndarray, shape (n_blocks, block + 1, n_channels, n_states)
        To the means of the channels over the block.
    carried : ndarray, shape (n_blocks, block + 1, n_x, n_states)
        To the state at its end.
    """
    found = own.linearization
    n_states, block, dt = len(found.states), own.block, found.record.dt
    n_blocks, n_channels, n_x = own.by_state.shape
    whole = n_blocks * block
    slopes = found.by_state[:whole].reshape(n_blocks, block, n_channels, n_states)
    steps = np.zeros((whole, n_x, n_x))
    steps[: len(own.stepwise)] = own.stepwise[:whole]
    steps = steps.reshape(n_blocks, block, n_x, n_x)
    seen = np.zeros((n_blocks, block + 1, n_channels, n_states))
    carried = np.zeros((n_blocks, block + 1, n_x, n_states))
    # Backward through the block: how later channels, and its end, depend on a sample's state.
    later = np.zeros((n_blocks, n_channels, n_x))
    end = np.broadcast_to(np.eye(n_x), (n_blocks, n_x, n_x))
    carried[:, block] = 0.5 * dt * end[:, :, :n_states]
    for sample in range(block - 1, -1, -1):
        later = later @ steps[:, sample]
        end = end @ steps[:, sample]
        share = 1.0 if sample else 0.5
        seen[:, sample] = share * dt / block * later[:, :, :n_states]
        carried[:, sample] = share * dt * end[:, :, :n_states]
        if sample:
            seen[:, sample] += 0.5 * dt / block * slopes[:, sample]
        later[:, :, :n_states] += slopes[:, sample]
    return seen, carried


def _ways(found: Linearization, place: str) -> tuple[FloatArray, FloatArray]:
    """Return by how much a place enters rates (n, n_states) and channels (n, n_channels)."""
    if place.startswith("free."):
        index = found.free.index(place.removeprefix("free."))
        return found.rate_by_free[:, :, index], found.output_by_free[:, :, index]
    if place in COEFFICIENTS:
        index = COEFFICIENTS.index(place)
        return found.rate_by_coefficient[:, :, index], found.output_by_coefficient[:, :, index]
    index = CONTROLS.index(place)
    return found.rate_by_control[:, :, index], found.output_by_control[:, :, index]

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
    n_states = len(found.states)
    n_blocks, _, n_x = own.by_state.shape
    b = np.zeros((n_blocks - 1, n_x, len(columns)))
    z = np.zeros((n_blocks, len(channels), len(columns)))
    by_place: dict[str, list[tuple[int, FloatArray]]] = {}
    for number, column in enumerate(columns):
        for entry in column:
            by_place.setdefault(entry.place, []).append((number, entry.history))
    half = 0.5 * own.span
    for place, entries in by_place.items():
        numbers = [number for number, _ in entries]
        histories = own.means(np.column_stack([history for _, history in entries]))
        if place.startswith("channel."):
            name = place.removeprefix("channel.")
            if name in channels:
                z[:, channels.index(name), numbers] += histories
            continue
        rate, output = (own.means(one) for one in _ways(found, place))
        # Half of a block's change is seen in its own means; it grows in a straight line.
        seen = output + half * np.einsum("nyi,ni->ny", own.by_state[:, :, :n_states], rate)
        z[:, :, numbers] += seen[:, :, None] * histories[:, None]
        carried = half * (
            rate[:-1] + np.einsum("nij,nj->ni", own.transition[:, :n_states, :n_states], rate[:-1])
        )
        b[:, :n_states, numbers] -= carried[:, :, None] * histories[:-1, None]
    return z, b


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

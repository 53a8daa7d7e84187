"""Which frequencies a record resolves, and which of them are neighbors."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from gsapp.identification.ftr.settings import FrequencyBand
from gsapp.quantities import FloatArray

NUISANCE_COLUMNS = 4
"""Columns that trim, drift and the two ends take out of every equation."""
AVERAGED_NEIGHBORS = 2
"""Neighbors on either side that a level is averaged over."""

IndexArray = npt.NDArray[np.int64]


def resolved_frequencies(
    listened: FloatArray, band: FrequencyBand, spacing: float, count: int, p: int
) -> tuple[IndexArray, IndexArray]:
    """Return the step between the frequencies that records resolve, and the first, in steps.

    The first is zero where there are too few.

    Parameters
    ----------
    listened : ndarray, shape (U,)
        Effective length, s.
    spacing : float
        Of the frequencies transformed, Hz.
    count : int
        How many there are, zero included.
    p : int
        Derivatives of an equation.
    """
    # Less than a millisecond resolves nothing, either.
    length = np.maximum(listened, 1e-3)
    step = np.maximum(np.ceil(1.0 / (length * spacing) - 1e-3), 1.0)
    lowest = np.maximum(band.lowest, 2.0 / length)
    first = np.maximum(np.ceil(lowest / (spacing * step) - 1e-3), 1.0)
    number = (count - 1) // step + 1.0 - first
    enough = 2.0 * number >= p + NUISANCE_COLUMNS + 2
    return (
        np.where(enough, step, 1.0).astype(np.int64),
        np.where(enough, first, 0.0).astype(np.int64),
    )


def group_by_step(steps: IndexArray, firsts: IndexArray) -> list[tuple[slice, int]]:
    """Return stretches of moments with the same step between frequencies, and that step.

    Moments without frequencies go with any.
    """
    found: list[tuple[slice, int]] = []
    start, step = 0, 0
    for place, (own, first) in enumerate(zip(steps.tolist(), firsts.tolist(), strict=True)):
        if first == 0:
            continue
        if step not in (0, own):
            found.append((slice(start, place), step))
            start = place
        step = own
    return [*found, (slice(start, len(steps)), max(step, 1))]


def frequency_mask(firsts: IndexArray, count: int) -> FloatArray:
    """Return ones from the first frequency of each moment on, zero left out, (U, count - 1)."""
    from_first = np.arange(1, count) >= firsts[:, np.newaxis]
    return np.asarray(from_first * (firsts > 0)[:, np.newaxis], dtype=np.float64)


def sum_over_neighbors(values: FloatArray) -> FloatArray:
    """Return sums over each frequency and its two neighbors on either side, (U, m, e)."""
    out = values.copy()
    for reach in range(1, AVERAGED_NEIGHBORS + 1):
        out[:, reach:] += values[:, :-reach]
        out[:, :-reach] += values[:, reach:]
    return out

"""From blocks and columns to one uniform grid."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt

from gsapp.flight.settings import FLIGHT_DATA
from gsapp.quantities import Block, FloatArray

IndexArray = npt.NDArray[np.int64]


def grid_row_indices(present: IndexArray, rate: float) -> IndexArray:
    """Return the numbers of the rows of a grid that covers those present, shape (m,), in any order.

    Increasing by one, but for pauses longer than `FLIGHT_DATA.max_filled_gap`.
    """
    if not present.size:
        return present
    first, last = int(present.min()), int(present.max())
    if last - first <= 4 * present.size:
        flags = np.zeros(last - first + 1, dtype=bool)
        flags[present - first] = True
        found = np.flatnonzero(flags) + first
    else:
        found = np.unique(present)
    cuts = np.flatnonzero(np.diff(found) > FLIGHT_DATA.max_filled_gap * rate)
    firsts = found[np.concatenate(([0], cuts + 1))]
    lasts = found[np.concatenate((cuts, [found.size - 1]))]
    parts = []
    for index, (first, last) in enumerate(zip(firsts.tolist(), lasts.tolist(), strict=True)):
        before = 1 if index > 0 else 0
        after = 1 if index < firsts.size - 1 else 0
        parts.append(np.arange(first - before, last + after + 1, dtype=np.int64))
    return np.concatenate(parts)


def combine_on_grid(blocks: Iterable[Block], rate: float) -> Block:
    """Lay blocks of different channels, on the grid ``k / rate``, on one; NaN where missing.

    Channels in the order met. Successive blocks of a channel do not overlap.
    """
    channels: dict[str, int] = {}
    pieces: list[tuple[list[int], IndexArray, FloatArray]] = []
    for block in blocks:
        present = ~np.isnan(block.values)
        used = [place for place in range(present.shape[1]) if present[:, place].any()]
        if not used:
            continue
        columns = [channels.setdefault(block.channels[place], len(channels)) for place in used]
        samples = block.values if len(used) == len(block.channels) else block.values[:, used]
        filled = np.logical_or.reduce([present[:, place] for place in used])
        if not filled.all():
            samples = samples[filled]
        index = np.rint(block.times[filled] * rate).astype(np.int64)
        pieces.append((columns, index, samples))
    indices = [index for _, index, _ in pieces]
    rows = grid_row_indices(np.concatenate(indices) if indices else np.empty(0, np.int64), rate)
    values = np.full((rows.size, len(channels)), np.nan)
    for columns, index, samples in pieces:
        first, last = np.searchsorted(rows, index[[0, -1]]).tolist()
        if last - first == index.size - 1 and columns == list(range(columns[0], columns[-1] + 1)):
            values[first : last + 1, columns[0] : columns[-1] + 1] = samples
        else:
            values[np.searchsorted(rows, index)[:, np.newaxis], columns] = samples
    return Block(channels=tuple(channels), times=rows / rate, values=values)


def overlay_on_grid(blocks: Sequence[Block], rate: float) -> Block:
    """Lay blocks of a grid on one; where two have a sample, the later block's counts.

    The channels of the last block come first; NaN where none has a sample.
    """
    names = tuple(dict.fromkeys(name for block in reversed(blocks) for name in block.channels))
    indices = [np.rint(block.times * rate).astype(np.int64) for block in blocks]
    rows = grid_row_indices(np.concatenate(indices) if indices else np.empty(0, np.int64), rate)
    values = np.full((rows.size, len(names)), np.nan)
    for block, index in zip(blocks, indices, strict=True):
        places = np.searchsorted(rows, index)
        for name in block.channels:
            samples = block[name]
            there = ~np.isnan(samples)
            values[places[there], names.index(name)] = samples[there]
    return Block(channels=names, times=rows / rate, values=values)


def median_step(times: FloatArray) -> float:
    """Return the median spacing of increasing times, s; NaN for fewer than two."""
    return float(np.median(np.diff(times))) if times.size > 1 else math.nan


def find_uniform_grid(times: FloatArray) -> tuple[FloatArray, IndexArray] | None:
    """Find the even grid that times lie on, if they do.

    Times that miss the grid by no more than the rounding of their last printed digit lie on it.

    Parameters
    ----------
    times : ndarray, shape (n,)
        Increasing, s.

    Returns
    -------
    grid : ndarray, shape (m,)
        The times given, where they are even to nine digits, else the even times that they
        round; with a row for each missing sample (but see `FLIGHT_DATA.max_filled_gap`).
    index : ndarray of int64, shape (n,)
        Row of each time given in `grid`.
    None
        If the times are uneven.
    """
    if times.size < 2:
        return times, np.zeros(times.size, np.int64)
    step = median_step(times)
    counts = np.concatenate(([0], np.cumsum(np.rint(np.diff(times) / step)))).astype(np.int64)
    if np.any(np.diff(counts) < 1):
        return None
    # Least squares for the step, so that 0.017, 0.033, 0.050 is 60 Hz and not 58.8.
    centered = counts - counts.mean()
    step = float(centered @ (times - times.mean()) / (centered @ centered))
    start = float(np.mean(times - counts * step))
    miss = float(np.max(np.abs(times - (start + counts * step))))
    exact = miss <= 1e-9 * max(1.0, float(np.max(np.abs(times))))
    if not exact and miss > max(_max_rounding_error(times), 1e-3 * step):
        return None
    rows = grid_row_indices(counts, 1.0 / step)
    index: IndexArray = np.searchsorted(rows, counts).astype(np.int64)
    grid: FloatArray = np.asarray(start + rows * step, dtype=np.float64)
    if exact:
        grid[index] = times
    return grid, index


def _max_rounding_error(times: FloatArray) -> float:
    """Return the most that rounding to the printed digits can have moved the times, s."""
    for digits in range(7):
        if np.allclose(times, np.round(times, digits), rtol=0.0, atol=1e-9):
            return 0.51 * 10.0**-digits
    return 0.0

"""Samples of one channel by absolute index, with a pyramid of extremes for charts.

Beside the samples stands a pyramid of lowest and highest values over 16, 256, 4096, ... samples.
The numbers lie in a temporary file (`SpillPool`); only segments that hold samples take space.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from gsapp.quantities import FloatArray
from gsapp.session.spill_pool import SpillPool

IndexArray = npt.NDArray[np.int64]

RAW_SEGMENT = 4096
"""Samples in a segment of the samples themselves."""
_FACTOR = 16
_LEVEL_SEGMENTS = (1024, 256, 256, 256, 256)
_LEVELS = len(_LEVEL_SEGMENTS)
# Up to so many samples a plain look at the samples beats the pyramid.
_MAX_DIRECT_SAMPLES = 4096
# Cells per bin up to which bins that fall on cell edges are read without splitting any cell.
_CELLS_PER_BIN = 64
_COLUMN = np.arange(_FACTOR, dtype=np.int64)[:, None]


class SparseArray:
    """Numbers by absolute index, in segments made when first written. Unwritten reads as NaN."""

    __slots__ = ("_bases", "_pool", "_sorted", "planes", "size")

    def __init__(self, pool: SpillPool, size: int, planes: int) -> None:
        self._pool = pool
        self._bases: dict[int, int] = {}
        self._sorted: tuple[IndexArray, IndexArray] | None = None
        self.size = size
        self.planes = planes

    @property
    def segments(self) -> list[int]:
        """Return the numbers of the segments written, in increasing order."""
        return sorted(self._bases)

    def _lookup(self) -> tuple[IndexArray, IndexArray]:
        if self._sorted is None:
            keys = sorted(self._bases)
            self._sorted = (
                np.array(keys, dtype=np.int64),
                np.array([self._bases[key] for key in keys], dtype=np.int64),
            )
        return self._sorted

    def _base(self, segment: int) -> int:
        base = self._bases.get(segment)
        if base is None:
            base = self._pool.allocate(self.size * self.planes)
            self._bases[segment] = base
            self._sorted = None
        return base

    def read(self, first: int, last: int, plane: int = 0) -> FloatArray:
        size = self.size
        offset = plane * size
        segment, start = divmod(first, size)
        if start + last - first <= size:
            base = self._bases.get(segment)
            if base is None:
                return np.full(last - first, np.nan)
            begin = base + offset + start
            return self._pool.values[begin : begin + last - first].copy()
        out = np.empty(last - first)
        position = first
        while position < last:
            segment, start = divmod(position, size)
            count = min(size - start, last - position)
            place = slice(position - first, position - first + count)
            base = self._bases.get(segment)
            if base is None:
                out[place] = np.nan
            else:
                begin = base + offset + start
                out[place] = self._pool.values[begin : begin + count]
            position += count
        return out

    def write(self, first: int, values: FloatArray, plane: int = 0) -> None:
        """Put values at positions `first` and following."""
        size = self.size
        done = 0
        while done < len(values):
            segment, start = divmod(first + done, size)
            count = min(size - start, len(values) - done)
            begin = self._base(segment) + plane * size + start
            self._pool.values[begin : begin + count] = values[done : done + count]
            done += count

    def write_within(self, first: int, values: FloatArray) -> None:
        """Put values at positions that lie in one segment."""
        segment, start = divmod(first, self.size)
        begin = self._base(segment) + start
        self._pool.values[begin : begin + len(values)] = values

    def scatter(self, indices: IndexArray, values: FloatArray) -> None:
        """Put values at single positions; of several at one position the last one stays."""
        segments, inside = np.divmod(indices, self.size)
        for segment in np.unique(segments).tolist():
            chosen = segments == segment
            base = self._base(segment)
            self._pool.values[base + inside[chosen]] = values[chosen]

    def groups(self, starts: IndexArray, plane: int = 0) -> FloatArray:
        """Return 16 numbers from each of some positions that are multiples of 16.

        Returns
        -------
        ndarray, shape (16, n)
            Such a group never crosses segments. Groups lie in columns, since NumPy reduces
            columns ten times as fast as short rows.
        """
        keys, bases = self._lookup()
        if keys.size == 0:
            return np.full((_FACTOR, starts.size), np.nan)
        segments, inside = np.divmod(starts, self.size)
        slots = np.minimum(np.searchsorted(keys, segments), keys.size - 1)
        missing = keys[slots] != segments
        begins = bases[slots] + plane * self.size + inside
        out: FloatArray = self._pool.values[begins + _COLUMN]
        if missing.any():
            out[:, missing] = np.nan
        return out


class SampleTrack:
    """One channel: its samples, its pyramid, and how far the pyramid is behind the samples."""

    __slots__ = ("dirty_first", "dirty_last", "last", "levels", "next", "raw", "start")

    def __init__(self, pool: SpillPool) -> None:
        self.raw = SparseArray(pool, RAW_SEGMENT, 1)
        self.levels = [SparseArray(pool, size, 2) for size in _LEVEL_SEGMENTS]
        self.dirty_first = 0
        self.dirty_last = 0
        # First and one past the last position ever written; position and value of the latest
        # sample that is a number.
        self.start: int | None = None
        self.next: int | None = None
        self.last: tuple[int, float] | None = None

    def append(self, first: int, last: int, values: FloatArray, newest: float) -> None:
        """Take in the next samples, inside one segment, of which the last is a number.

        Nearly all samples come this way, a few at a time, for dozens of channels.
        """
        self.raw.write_within(first, values)
        if self.dirty_last == first and last - self.dirty_first < RAW_SEGMENT:
            self.dirty_last = last
        else:
            self.mark_dirty(first, last)
        self.next = last
        self.last = (last - 1, newest)

    def mark_dirty(self, first: int, last: int) -> None:
        """Note that samples ``first <= k < last`` changed."""
        if self.dirty_first == self.dirty_last:
            self.dirty_first, self.dirty_last = first, last
            return
        if first > self.dirty_last + RAW_SEGMENT or last < self.dirty_first - RAW_SEGMENT:
            # Not to rebuild everything across a gap.
            self.refresh()
            self.dirty_first, self.dirty_last = first, last
        else:
            self.dirty_first = min(self.dirty_first, first)
            self.dirty_last = max(self.dirty_last, last)
        if self.dirty_last - self.dirty_first >= RAW_SEGMENT:
            self.refresh()

    def refresh(self) -> None:
        """Bring the pyramid up to the samples."""
        first, last = self.dirty_first, self.dirty_last
        if first == last:
            return
        self.dirty_first = self.dirty_last = 0
        low = high = None
        for index, level in enumerate(self.levels):
            first //= _FACTOR
            last = -(-last // _FACTOR)
            begin, end = first * _FACTOR, last * _FACTOR
            if index == 0:
                low = high = self.raw.read(begin, end)
            else:
                below = self.levels[index - 1]
                low, high = below.read(begin, end, 0), below.read(begin, end, 1)
            level.write(first, np.fmin.reduce(low.reshape(-1, _FACTOR), axis=1), 0)
            level.write(first, np.fmax.reduce(high.reshape(-1, _FACTOR), axis=1), 1)

    def cells(self, level: int, first: int, last: int, plane: int) -> FloatArray:
        """Return cells of a level; level 0 are the samples."""
        if level == 0:
            return self.raw.read(first, last)
        return self.levels[level - 1].read(first, last, plane)

    def groups(self, level: int, starts: IndexArray, plane: int) -> FloatArray:
        """Return groups of 16 cells of a level, shape (16, n)."""
        if level == 0:
            return self.raw.groups(starts)
        return self.levels[level - 1].groups(starts, plane)

    def write(self, first: int, end: int, indices: IndexArray | None, values: FloatArray) -> bool:
        """Write samples ``first <= k < end``, or at single positions; return if any was old."""
        if indices is None:
            self.raw.write(first, values)
            self.mark_dirty(first, end)
        else:
            self.raw.scatter(indices, values)
            self._mark_scattered(indices)
        rewritten = self.next is not None and first < self.next
        self.start = first if self.start is None else min(self.start, first)
        self.next = end if self.next is None else max(self.next, end)
        self._note_last(first, indices, values)
        return rewritten

    def _mark_scattered(self, indices: IndexArray) -> None:
        """Mark stretch by stretch, so that a jump of the clock is not taken for a stretch."""
        ordered = np.unique(indices)
        cuts = np.flatnonzero(np.diff(ordered) > RAW_SEGMENT) + 1
        for stretch in np.split(ordered, cuts):
            self.mark_dirty(int(stretch[0]), int(stretch[-1]) + 1)

    def _note_last(self, first: int, indices: IndexArray | None, values: FloatArray) -> None:
        newest = float(values[-1])
        if indices is None and newest == newest:  # quicker than math.isnan
            place, value = first + len(values) - 1, newest
        else:
            numbers = np.flatnonzero(~np.isnan(values))
            if not numbers.size:
                if self.last is not None:
                    self._recheck_last()
                return
            places = numbers + first if indices is None else indices[numbers]
            # The last one given of those at the latest place.
            best = int(numbers.size - 1 - np.argmax(places[::-1]))
            place, value = int(places[best]), float(values[numbers[best]])
        if self.last is None or place >= self.last[0]:
            self.last = (place, value)
        else:
            self._recheck_last()

    def _recheck_last(self) -> None:
        """See whether the latest number was overwritten by a missing one."""
        if self.last is None:
            return
        place = self.last[0]
        value = float(self.raw.read(place, place + 1)[0])
        self.last = self.last_before(place) if math.isnan(value) else (place, value)

    def extremes(
        self, first_bin: int, last_bin: int, bin_size: int, horizon: int | None
    ) -> tuple[FloatArray, FloatArray]:
        """Return the lowest and highest sample of each bin, of those before index `horizon`."""
        if horizon is not None and last_bin * bin_size > horizon:
            return self._extremes_before(first_bin, last_bin, bin_size, horizon)
        return self._extremes(first_bin, last_bin, bin_size)

    def _extremes_before(
        self, first_bin: int, last_bin: int, bin_size: int, horizon: int
    ) -> tuple[FloatArray, FloatArray]:
        low = np.full(last_bin - first_bin, np.nan)
        high = low.copy()
        cut = horizon // bin_size
        whole = min(max(cut - first_bin, 0), low.size)
        if whole:
            low[:whole], high[:whole] = self._extremes(first_bin, first_bin + whole, bin_size)
        if first_bin <= cut < last_bin and horizon > cut * bin_size:
            low[whole], high[whole] = self._extremes_of_stretch(cut * bin_size, horizon)
        return low, high

    def _extremes(
        self, first_bin: int, last_bin: int, bin_size: int
    ) -> tuple[FloatArray, FloatArray]:
        count = last_bin - first_bin
        level = 0
        cells = bin_size
        if count * bin_size > _MAX_DIRECT_SAMPLES:
            self.refresh()
            level = _aligned_level(bin_size)
            cells = bin_size // _FACTOR**level
            if cells > _CELLS_PER_BIN and level < _LEVELS:
                edges = np.arange(first_bin, last_bin + 1, dtype=np.int64) * bin_size
                return self._extremes_of_split_bins(edges, bin_size)
        low = self.cells(level, first_bin * cells, last_bin * cells, 0)
        high = low if level == 0 else self.cells(level, first_bin * cells, last_bin * cells, 1)
        if cells == 1:
            return low, high.copy() if level == 0 else high
        return (
            np.fmin.reduce(low.reshape(count, cells), axis=1),
            np.fmax.reduce(high.reshape(count, cells), axis=1),
        )

    def _extremes_of_split_bins(
        self, edges: IndexArray, bin_size: int
    ) -> tuple[FloatArray, FloatArray]:
        """Return extremes between successive edges that cut through cells of the pyramid.

        Each bin is the whole cells inside it and, at either end, part of a cell, which is made
        of smaller cells in the same way.
        """
        level = _highest_level(bin_size)
        size = _FACTOR**level
        begins = -(-edges[:-1] // size)
        ends = edges[1:] // size
        first = int(begins[0])
        places = np.empty(2 * begins.size, dtype=np.int64)
        places[0::2] = begins - first
        places[1::2] = ends - first
        last = int(ends[-1]) + 1  # one more, since reduceat wants its last place to exist
        low = np.fmin.reduceat(self.cells(level, first, last, 0), places)[0::2]
        high = np.fmax.reduceat(self.cells(level, first, last, 1), places)[0::2]
        while level > 0:
            level -= 1
            size //= _FACTOR
            cell = edges // size
            place = cell % _FACTOR
            group = cell - place
            lows = self.groups(level, group, 0)
            highs = lows if level == 0 else self.groups(level, group, 1)
            before = place > _COLUMN
            # A cell that the edge cuts is left to the next lower level.
            after = place + (edges % size != 0) <= _COLUMN
            left_low = np.fmin.reduce(np.where(before, lows, np.nan), axis=0)
            right_low = np.fmin.reduce(np.where(after, lows, np.nan), axis=0)
            left_high = np.fmax.reduce(np.where(before, highs, np.nan), axis=0)
            right_high = np.fmax.reduce(np.where(after, highs, np.nan), axis=0)
            low = np.fmin(low, np.fmin(right_low[:-1], left_low[1:]))
            high = np.fmax(high, np.fmax(right_high[:-1], left_high[1:]))
        return low, high

    def _extremes_of_stretch(self, first: int, last: int) -> tuple[float, float]:
        """Return the extremes of one stretch ``first <= k < last``."""
        self.refresh()
        low = high = math.nan
        level = 0
        while first < last:
            # Take what does not fill a cell of the next level, then climb.
            up, down = -(-first // _FACTOR) * _FACTOR, last // _FACTOR * _FACTOR
            climb = level < _LEVELS and up < down
            parts = [(first, up), (down, last)] if climb else [(first, last)]
            for begin, end in parts:
                if begin < end:
                    low = float(np.fmin(low, np.fmin.reduce(self.cells(level, begin, end, 0))))
                    high = float(np.fmax(high, np.fmax.reduce(self.cells(level, begin, end, 1))))
            if not climb:
                break
            first, last = up // _FACTOR, down // _FACTOR
            level += 1
        return low, high

    def last_before(self, limit: int) -> tuple[int, float] | None:
        """Return place and value of the latest number before index `limit`."""
        if self.start is None:
            return None
        self.refresh()
        level, stop = 0, limit
        while True:
            # `stop` counts cells of `level`; all after it was searched.
            first = (stop - 1) // _FACTOR * _FACTOR if level < _LEVELS else None
            if first is None:
                found = self._last_at_top(stop)
                break
            cells = self.cells(level, first, stop, 0)
            numbers = np.flatnonzero(~np.isnan(cells))
            if numbers.size:
                found = first + int(numbers[-1])
                break
            stop = first // _FACTOR
            level += 1
        while found is not None and level > 0:
            level -= 1
            cells = self.cells(level, found * _FACTOR, (found + 1) * _FACTOR, 0)
            found = found * _FACTOR + int(np.flatnonzero(~np.isnan(cells))[-1])
        return None if found is None else (found, float(self.raw.read(found, found + 1)[0]))

    def _last_at_top(self, stop: int) -> int | None:
        top = self.levels[-1]
        for segment in reversed(top.segments):
            first = segment * top.size
            if first >= stop:
                continue
            cells = top.read(first, min(first + top.size, stop))
            numbers = np.flatnonzero(~np.isnan(cells))
            if numbers.size:
                return first + int(numbers[-1])
        return None


def _highest_level(bin_size: int) -> int:
    """Return the highest level of which any bin holds some whole cells, three at least."""
    level = 0
    while level < _LEVELS and 4 * _FACTOR ** (level + 1) <= bin_size:
        level += 1
    return level


def _aligned_level(bin_size: int) -> int:
    """Return the highest level whose cells fill the bins without a remainder."""
    level = 0
    while level < _LEVELS and bin_size % _FACTOR ** (level + 1) == 0:
        level += 1
    return level

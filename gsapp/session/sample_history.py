"""What was measured since the flight began, ready to be drawn at any scale.

Samples lie on one uniform grid of absolute index ``k = round(time * rate)``. Beside them stands,
for every channel, a pyramid of lowest and highest values over 16, 256, 4096, ... samples, so
that a chart column costs the same whether it stands for ten milliseconds or for ten minutes.

Everything is float64 and exact: charts and identification read the same numbers. Nothing is ever
cut. The numbers lie in a temporary file (`SpillPool`), so the memory of the process does not grow
with the flight; only stretches that hold samples take room, so a clock that jumps by years costs
nothing.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np
import numpy.typing as npt

from gsapp.foundation import UnknownNameError
from gsapp.foundation.name_suggestions import did_you_mean
from gsapp.quantities import Block, FloatArray
from gsapp.session.spill_pool import SpillPool

IndexArray = npt.NDArray[np.int64]

_FACTOR = 16
_RAW_SEGMENT = 4096
_LEVEL_SEGMENTS = (1024, 256, 256, 256, 256)
_LEVELS = len(_LEVEL_SEGMENTS)
# Up to so many samples a plain look at the samples beats the pyramid.
_MAX_DIRECT_SAMPLES = 4096
# Cells per bin up to which bins that fall on cell edges are read without splitting any cell.
_CELLS_PER_BIN = 64
_COLUMN = np.arange(_FACTOR, dtype=np.int64)[:, None]
# Positions beyond this are a broken clock, not a flight (at 1 kHz: 140,000 years).
_MAX_INDEX = 2**52


class _SparseArray:
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
        """Return a copy of positions ``first <= k < last``."""
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


class _Track:
    """One channel: its samples, its pyramid, and how far the pyramid is behind the samples."""

    __slots__ = ("dirty_first", "dirty_last", "last", "levels", "next", "raw", "start")

    def __init__(self, pool: SpillPool) -> None:
        self.raw = _SparseArray(pool, _RAW_SEGMENT, 1)
        self.levels = [_SparseArray(pool, size, 2) for size in _LEVEL_SEGMENTS]
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
        if self.dirty_last == first and last - self.dirty_first < _RAW_SEGMENT:
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
        if first > self.dirty_last + _RAW_SEGMENT or last < self.dirty_first - _RAW_SEGMENT:
            # Not to rebuild everything across a gap.
            self.refresh()
            self.dirty_first, self.dirty_last = first, last
        else:
            self.dirty_first = min(self.dirty_first, first)
            self.dirty_last = max(self.dirty_last, last)
        if self.dirty_last - self.dirty_first >= _RAW_SEGMENT:
            self.refresh()

    def refresh(self) -> None:
        """Bring the pyramid up to the samples."""
        first, last = self.dirty_first, self.dirty_last
        if first == last:
            return
        self.dirty_first = self.dirty_last = 0
        low = high = None
        for number, level in enumerate(self.levels):
            first //= _FACTOR
            last = -(-last // _FACTOR)
            begin, end = first * _FACTOR, last * _FACTOR
            if number == 0:
                low = high = self.raw.read(begin, end)
            else:
                below = self.levels[number - 1]
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


class SampleHistory:
    """Everything measured in a flight, by channel, on one grid.

    Parameters
    ----------
    channels : sequence of str
        Channels to begin with; a block may bring further ones.
    rate : float
        Samples per second of the grid, Hz.

    Attributes
    ----------
    rate : float
        Hz.
    revision : int
        Grows whenever something that may already be on screen changed: samples before the end
        of a channel were rewritten, or the `horizon` went back. What was cached is then void.
    """

    def __init__(self, channels: Sequence[str], rate: float) -> None:
        if not (rate > 0.0 and math.isfinite(rate)):
            raise ValueError(f"the rate of a history is a positive number of Hz, not {rate}")
        self.rate = float(rate)
        self.revision = 0
        self._pool = SpillPool()
        self._tracks = {channel_id: _Track(self._pool) for channel_id in channels}
        self._first: int | None = None
        self._end: int | None = None
        self._horizon: int | None = None

    # What is there

    @property
    def channels(self) -> tuple[str, ...]:
        """Return the channels, in the order in which they came."""
        return tuple(self._tracks)

    @property
    def channels_with_data(self) -> tuple[str, ...]:
        """Return the channels of which a number has come, not only the place for one.

        As `channels`, it tells of all that is held, whatever the horizon.
        """
        return tuple(name for name, track in self._tracks.items() if track.last is not None)

    def has(self, channel_id: str) -> bool:
        """Return whether anything is held of a channel."""
        return channel_id in self._tracks

    @property
    def start(self) -> float | None:
        """Return the time of the earliest row of any channel, s; None if empty.

        The vehicle's clock may have run for long by then.
        """
        return None if self._first is None else self._first / self.rate

    @property
    def end(self) -> float | None:
        """Return the time of the latest row of any channel up to the horizon, s; None if empty."""
        if self._end is None:
            return None
        last = self._end - 1
        if self._horizon is not None:
            last = min(last, self._horizon - 1)
        return last / self.rate

    @property
    def on_disk(self) -> bool:
        """Return whether the samples lie in a file, as they should, and not in memory."""
        return self._pool.on_disk

    @property
    def horizon(self) -> float | None:
        """Time up to which samples can be seen, s; None shows all.

        A replay reads ahead of its playhead. What lies after the horizon is treated by every
        method as if it had not arrived yet.
        """
        return None if self._horizon is None else (self._horizon - 1) / self.rate

    @horizon.setter
    def horizon(self, time: float | None) -> None:
        limit = None if time is None else math.floor(time * self.rate + 1e-6) + 1
        before = self._horizon
        if limit is not None and (before is None or limit < before):
            self.revision += 1
        self._horizon = limit

    @contextmanager
    def without_horizon(self) -> Iterator[None]:
        """Let what lies after the horizon be read, too, within a ``with`` block."""
        held, self._horizon = self._horizon, None
        try:
            yield
        finally:
            self._horizon = held

    def index(self, time: float) -> int:
        """Return the absolute index of the sample nearest to a time (s)."""
        return round(time * self.rate)

    def last(self, channel_id: str) -> tuple[float, float] | None:
        """Return time (s) and value (SI) of the latest sample that is a number, or None."""
        track = self._track(channel_id)
        found = track.last
        if found is not None and self._horizon is not None and found[0] >= self._horizon:
            found = self._last_before(track, self._horizon)
        return None if found is None else (found[0] / self.rate, found[1])

    def span(self, channel_id: str) -> tuple[int, int] | None:
        """Return first and one past the last index ever given for a channel, or None."""
        track = self._track(channel_id)
        if track.start is None or track.next is None:
            return None
        last = track.next if self._horizon is None else min(track.next, self._horizon)
        return (track.start, last) if last > track.start else None

    # Writing

    def append(self, block: Block) -> None:
        """Take in a block.

        Parameters
        ----------
        block : Block
            Any subset of channels, any end; times are rounded to the grid. Samples that fall on
            a place already written replace what stood there. Times that are not numbers are
            passed over.
        """
        if not len(block):
            return
        times = block.times
        count = len(times)
        scaled = times * self.rate
        first = self._position(float(scaled[0]))
        last = self._position(float(scaled[-1]))
        indices: IndexArray | None = None
        values = block.values
        if first is None or last is None or last - first != count - 1 or not _is_even(scaled):
            usable = np.isfinite(scaled) & (np.abs(scaled) < _MAX_INDEX)
            if not usable.any():
                return
            indices = np.rint(scaled[usable]).astype(np.int64)
            values = values[usable]
            first, last = int(indices.min()), int(indices.max())
        newest = values[-1].tolist()
        within = indices is None and first % _RAW_SEGMENT + count <= _RAW_SEGMENT
        for column, channel_id in enumerate(block.channels):
            track = self._tracks.get(channel_id)
            if track is None:
                track = self._tracks[channel_id] = _Track(self._pool)
            if within and first == track.next and newest[column] == newest[column]:
                track.append(first, last + 1, values[:, column], newest[column])
            else:
                self._put(track, first, last + 1, indices, values[:, column])
        self._first = first if self._first is None else min(self._first, first)
        self._end = last + 1 if self._end is None else max(self._end, last + 1)

    @staticmethod
    def _position(scaled: float) -> int | None:
        return round(scaled) if abs(scaled) < _MAX_INDEX else None

    def _put(
        self, track: _Track, first: int, end: int, indices: IndexArray | None, values: FloatArray
    ) -> None:
        if indices is None:
            track.raw.write(first, values)
            track.mark_dirty(first, end)
        else:
            track.raw.scatter(indices, values)
            self._soil_scattered(track, indices)
        if track.next is not None and first < track.next:
            self.revision += 1
        track.start = first if track.start is None else min(track.start, first)
        track.next = end if track.next is None else max(track.next, end)
        self._note_last(track, first, indices, values)

    @staticmethod
    def _soil_scattered(track: _Track, indices: IndexArray) -> None:
        """Mark stretch by stretch, so that a jump of the clock is not taken for a stretch."""
        ordered = np.unique(indices)
        cuts = np.flatnonzero(np.diff(ordered) > _RAW_SEGMENT) + 1
        for stretch in np.split(ordered, cuts):
            track.mark_dirty(int(stretch[0]), int(stretch[-1]) + 1)

    def _note_last(
        self, track: _Track, first: int, indices: IndexArray | None, values: FloatArray
    ) -> None:
        newest = float(values[-1])
        if indices is None and newest == newest:  # quicker than math.isnan
            place, value = first + len(values) - 1, newest
        else:
            numbers = np.flatnonzero(~np.isnan(values))
            if not numbers.size:
                if track.last is not None:
                    self._recheck_last(track)
                return
            places = numbers + first if indices is None else indices[numbers]
            # The last one given of those at the latest place.
            best = int(numbers.size - 1 - np.argmax(places[::-1]))
            place, value = int(places[best]), float(values[numbers[best]])
        if track.last is None or place >= track.last[0]:
            track.last = (place, value)
        else:
            self._recheck_last(track)

    def _recheck_last(self, track: _Track) -> None:
        """See whether the latest number was overwritten by a missing one."""
        if track.last is None:
            return
        place = track.last[0]
        value = float(track.raw.read(place, place + 1)[0])
        track.last = self._last_before(track, place) if math.isnan(value) else (place, value)

    # Reading

    def _track(self, channel_id: str) -> _Track:
        try:
            return self._tracks[channel_id]
        except KeyError:
            hint = did_you_mean(channel_id, self._tracks, f"it has {', '.join(self._tracks)}")
            raise UnknownNameError(f"this flight has no channel '{channel_id}'; {hint}") from None

    def samples(self, channel_id: str, first: int, last: int) -> FloatArray:
        """Return the samples at ``first <= k < last``.

        Returns
        -------
        ndarray, shape (last - first,)
            SI units, exactly as given; NaN where there is none. A copy.
        """
        track = self._track(channel_id)
        if last <= first:
            return np.empty(0)
        out = track.raw.read(first, last)
        if self._horizon is not None and last > self._horizon:
            out[max(self._horizon - first, 0) :] = np.nan
        return out

    def block(self, channel_ids: Sequence[str], start: float, stop: float) -> Block:
        """Return the rows with ``start <= time < stop`` (s) of some channels."""
        first = math.ceil(start * self.rate - 1e-6)
        return self.rows(first, math.ceil(stop * self.rate - 1e-6), channel_ids)

    def rows(self, first: int, last: int, channel_ids: Sequence[str] | None = None) -> Block:
        """Return the rows ``first <= k < last`` of some channels, or of all."""
        names = self.channels if channel_ids is None else tuple(channel_ids)
        last = max(first, last)
        columns = [self.samples(channel_id, first, last) for channel_id in names]
        return Block(
            channels=names,
            times=np.arange(first, last) / self.rate,
            values=np.column_stack(columns) if columns else np.empty((last - first, 0)),
        )

    def blocks(self) -> Iterator[Block]:
        """Yield what is held of each channel, in stretches, channel after channel."""
        for channel_id, track in self._tracks.items():
            for segment in track.raw.segments:
                first = segment * _RAW_SEGMENT
                yield self.rows(first, first + _RAW_SEGMENT, (channel_id,))

    def extremes(
        self, channel_id: str, first_bin: int, last_bin: int, bin_size: int
    ) -> tuple[FloatArray, FloatArray]:
        """Return the lowest and highest sample in each of a row of bins.

        Bin ``j`` holds the samples ``j * bin_size <= k < (j + 1) * bin_size``. The time taken
        follows the number of bins, not their size; bin sizes that are small multiples of 16,
        256, ... are the quickest.

        Parameters
        ----------
        channel_id : str
            The channel.
        first_bin, last_bin : int
            ``first_bin <= j < last_bin``.
        bin_size : int
            Samples in a bin.

        Returns
        -------
        low, high : ndarray, shape (last_bin - first_bin,)
            SI units; NaN for a bin without any number.
        """
        track = self._track(channel_id)
        if bin_size < 1:
            raise ValueError(f"a bin holds at least one sample, not {bin_size}")
        count = last_bin - first_bin
        if count <= 0:
            return np.empty(0), np.empty(0)
        if self._horizon is not None and last_bin * bin_size > self._horizon:
            return self._limited(track, first_bin, last_bin, bin_size, self._horizon)
        return self._extremes(track, first_bin, last_bin, bin_size)

    def _limited(
        self, track: _Track, first_bin: int, last_bin: int, bin_size: int, horizon: int
    ) -> tuple[FloatArray, FloatArray]:
        low = np.full(last_bin - first_bin, np.nan)
        high = low.copy()
        cut = horizon // bin_size
        whole = min(max(cut - first_bin, 0), low.size)
        if whole:
            low[:whole], high[:whole] = self._extremes(
                track, first_bin, first_bin + whole, bin_size
            )
        if first_bin <= cut < last_bin and horizon > cut * bin_size:
            low[whole], high[whole] = self._single(track, cut * bin_size, horizon)
        return low, high

    def _extremes(
        self, track: _Track, first_bin: int, last_bin: int, bin_size: int
    ) -> tuple[FloatArray, FloatArray]:
        count = last_bin - first_bin
        level = 0
        cells = bin_size
        if count * bin_size > _MAX_DIRECT_SAMPLES:
            track.refresh()
            level = _aligned_level(bin_size)
            cells = bin_size // _FACTOR**level
            if cells > _CELLS_PER_BIN and level < _LEVELS:
                edges = np.arange(first_bin, last_bin + 1, dtype=np.int64) * bin_size
                return self._split_bins(track, edges, bin_size)
        low = track.cells(level, first_bin * cells, last_bin * cells, 0)
        high = low if level == 0 else track.cells(level, first_bin * cells, last_bin * cells, 1)
        if cells == 1:
            return low, high.copy() if level == 0 else high
        return (
            np.fmin.reduce(low.reshape(count, cells), axis=1),
            np.fmax.reduce(high.reshape(count, cells), axis=1),
        )

    def _split_bins(
        self, track: _Track, edges: IndexArray, bin_size: int
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
        low = np.fmin.reduceat(track.cells(level, first, last, 0), places)[0::2]
        high = np.fmax.reduceat(track.cells(level, first, last, 1), places)[0::2]
        while level > 0:
            level -= 1
            size //= _FACTOR
            cell = edges // size
            place = cell % _FACTOR
            group = cell - place
            lows = track.groups(level, group, 0)
            highs = lows if level == 0 else track.groups(level, group, 1)
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

    @staticmethod
    def _single(track: _Track, first: int, last: int) -> tuple[float, float]:
        """Return the extremes of one stretch ``first <= k < last``."""
        track.refresh()
        low = high = math.nan
        level = 0
        while first < last:
            # Take what does not fill a cell of the next level, then climb.
            up, down = -(-first // _FACTOR) * _FACTOR, last // _FACTOR * _FACTOR
            climb = level < _LEVELS and up < down
            parts = [(first, up), (down, last)] if climb else [(first, last)]
            for begin, end in parts:
                if begin < end:
                    low = _min_number(low, track.cells(level, begin, end, 0))
                    high = _max_number(high, track.cells(level, begin, end, 1))
            if not climb:
                break
            first, last = up // _FACTOR, down // _FACTOR
            level += 1
        return low, high

    def _last_before(self, track: _Track, limit: int) -> tuple[int, float] | None:
        """Return place and value of the latest number before index `limit`."""
        if track.start is None:
            return None
        track.refresh()
        level, stop = 0, limit
        while True:
            # `stop` counts cells of `level`; all after it was searched.
            first = (stop - 1) // _FACTOR * _FACTOR if level < _LEVELS else None
            if first is None:
                found = self._last_at_top(track, stop)
                break
            cells = track.cells(level, first, stop, 0)
            numbers = np.flatnonzero(~np.isnan(cells))
            if numbers.size:
                found = first + int(numbers[-1])
                break
            stop = first // _FACTOR
            level += 1
        while found is not None and level > 0:
            level -= 1
            cells = track.cells(level, found * _FACTOR, (found + 1) * _FACTOR, 0)
            found = found * _FACTOR + int(np.flatnonzero(~np.isnan(cells))[-1])
        return None if found is None else (found, float(track.raw.read(found, found + 1)[0]))

    @staticmethod
    def _last_at_top(track: _Track, stop: int) -> int | None:
        top = track.levels[-1]
        for segment in reversed(top.segments):
            first = segment * top.size
            if first >= stop:
                continue
            cells = top.read(first, min(first + top.size, stop))
            numbers = np.flatnonzero(~np.isnan(cells))
            if numbers.size:
                return first + int(numbers[-1])
        return None

    # The end

    def release_memory(self) -> None:
        """Let go of memory that only looking back over the whole flight has filled."""
        self._pool.release_memory()

    def close(self) -> None:
        """Give the temporary file back. The history is empty afterwards."""
        self._tracks.clear()
        self._first = self._end = None
        self._pool.close()


def _is_even(scaled: FloatArray) -> bool:
    """Return whether times in samples follow one another at steps of one."""
    if scaled.size <= 2:  # the caller has compared both ends
        return True
    drift = scaled - np.arange(scaled.size)
    return bool(np.all(np.abs(drift - drift[0]) < 0.25))


def _min_number(value: float, others: FloatArray) -> float:
    """Return the lowest of a value and some others, passing over NaN."""
    return float(np.fmin(value, np.fmin.reduce(others)))


def _max_number(value: float, others: FloatArray) -> float:
    """Return the highest of a value and some others, passing over NaN."""
    return float(np.fmax(value, np.fmax.reduce(others)))

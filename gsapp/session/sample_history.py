"""What was measured since the flight began, ready to be drawn at any scale.

Samples lie on one uniform grid of absolute index ``k = round(time * rate)``, exact, in float64:
charts and identification read the same numbers. They lie in a temporary file, so the memory of the
process does not grow with the flight, and a clock that jumps by years costs nothing.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np

from gsapp.foundation import UnknownNameError
from gsapp.foundation.name_suggestions import did_you_mean
from gsapp.foundation.process_control import return_free_memory
from gsapp.quantities import Block, FloatArray
from gsapp.session.sample_track import RAW_SEGMENT, IndexArray, SampleTrack
from gsapp.session.spill_pool import SpillPool

# Positions beyond this are a broken clock, not a flight (at 1 kHz: 140,000 years).
_MAX_INDEX = 2**52


class SampleHistory:
    """Everything measured in a flight, by channel, on one grid of `rate` Hz.

    Parameters
    ----------
    channels : sequence of str
        Channels to begin with; a block may bring further ones.

    Attributes
    ----------
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
        self._tracks = {channel_id: SampleTrack(self._pool) for channel_id in channels}
        self._first: int | None = None
        self._end: int | None = None
        self._horizon: int | None = None

    # What is there

    @property
    def channels(self) -> tuple[str, ...]:
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
            found = track.last_before(self._horizon)
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
        within = indices is None and first % RAW_SEGMENT + count <= RAW_SEGMENT
        for column, channel_id in enumerate(block.channels):
            track = self._tracks.get(channel_id)
            if track is None:
                track = self._tracks[channel_id] = SampleTrack(self._pool)
            if within and first == track.next and newest[column] == newest[column]:
                track.append(first, last + 1, values[:, column], newest[column])
            elif track.write(first, last + 1, indices, values[:, column]):
                self.revision += 1
        self._first = first if self._first is None else min(self._first, first)
        self._end = last + 1 if self._end is None else max(self._end, last + 1)

    @staticmethod
    def _position(scaled: float) -> int | None:
        return round(scaled) if abs(scaled) < _MAX_INDEX else None

    # Reading

    def _track(self, channel_id: str) -> SampleTrack:
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
                first = segment * RAW_SEGMENT
                yield self.rows(first, first + RAW_SEGMENT, (channel_id,))

    def extremes(
        self, channel_id: str, first_bin: int, last_bin: int, bin_size: int
    ) -> tuple[FloatArray, FloatArray]:
        """Return the lowest and highest sample in each of a row of bins.

        Bin ``j`` holds the samples ``j * bin_size <= k < (j + 1) * bin_size``. The time taken
        follows the number of bins, not their size; bin sizes that are small multiples of 16,
        256, ... are the quickest.

        Parameters
        ----------
        first_bin, last_bin : int
            ``first_bin <= j < last_bin``.

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
        return track.extremes(first_bin, last_bin, bin_size, self._horizon)

    # The end

    def release_memory(self) -> None:
        """Give memory back: pages filled by looking back over the flight, and what was freed."""
        self._pool.release_memory()
        return_free_memory()

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

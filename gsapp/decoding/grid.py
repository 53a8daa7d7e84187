"""Samples at the vehicle's own moments, laid on the grid k / rate of flight time.

Between two samples the value is interpolated linearly (angles that go round, the shorter way;
counts and switches keep the former value). A row on a sample has exactly that sample's value. A
row is complete as soon as a sample at or after it has come.

Between samples that lie more than 2.5 sample periods apart there is nothing: NaN. The period of
a message is the lower median of its last nine intervals, the one in question included, so it
depends on the samples alone; until two intervals are known an interval of up to 2.5 s passes. A
pause longer than `LONGEST_FILL` is not filled at all: rows go on after it, and no memory is spent
on it. A sample that is not later than its predecessor (a duplicate, or one overtaken on the way)
is passed over and counted.

Where rows lie depends on the times of the samples alone and is planned message by message. The
values of all messages are then laid in one step on one matrix, since a step costs the same for a
few numbers as for hundreds, and a live link gives but a few of each message at a time.
"""

from __future__ import annotations

from bisect import bisect_left, insort
from collections import deque
from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from gsapp.quantities import FloatArray

LONGEST_FILL = 60.0
"""Seconds of a pause that are filled with NaN rows; after a longer one rows just go on."""

_WINDOW = 9
_UNKNOWN_PERIOD = 1_000_000
_TURN = 2.0 * np.pi
_TABLE_BEFORE = 200
_TABLE_AFTER = 1000
BoolArray = npt.NDArray[np.bool_]
ColumnIndex = slice | npt.NDArray[np.intp]


def columns_at(places: Sequence[int] | npt.NDArray[np.intp]) -> ColumnIndex:
    """Return columns of a matrix as an index; a slice, which is far quicker, where one does."""
    found = np.asarray(places, dtype=np.intp)
    if not found.size:
        return slice(0, 0)
    step = int(found[1] - found[0]) if found.size > 1 else 1
    if step < 1 or (np.diff(found) != step).any():
        return found
    return slice(int(found[0]), int(found[-1]) + 1, step)


class Grid:
    """The times k / rate, in whole numbers.

    Parameters
    ----------
    rate : float
        Rows per second.
    """

    __slots__ = ("_table", "_table_first", "denominator", "longest", "numerator", "rate", "step")

    def __init__(self, rate: float) -> None:
        if not 0.0 < rate <= 100_000.0:
            raise ValueError(f"a grid of {rate} rows per second is not offered; use 0.01 to 1e5")
        exact = Fraction(rate).limit_denominator(1000)
        self.rate = float(exact)
        self.numerator = exact.numerator
        self.denominator = exact.denominator
        self.step = 1_000_000 * exact.denominator
        self.longest = int(LONGEST_FILL * self.rate)
        self._table_first = 0
        self._table = np.empty(0)

    def times(self, first: int, count: int) -> FloatArray:
        """Return the times of rows `first` and following, s; read-only."""
        start = first - self._table_first
        if start < 0 or start + count > self._table.size:
            # The messages of one batch lie about the same rows.
            self._table_first = first - _TABLE_BEFORE
            self._table = self._computed(self._table_first, _TABLE_BEFORE + count + _TABLE_AFTER)
            self._table.setflags(write=False)
            start = _TABLE_BEFORE
        return self._table[start : start + count]

    def _computed(self, first: int, count: int) -> FloatArray:
        start = first * self.denominator
        stop = (first + count) * self.denominator
        return np.arange(start, stop, self.denominator, dtype=np.int64) / self.numerator

    def micros(self, first: int, count: int) -> FloatArray:
        """Return the times of rows `first` and following, us."""
        start, stop = first * self.step, (first + count) * self.step
        return np.arange(start, stop, self.step, dtype=np.int64) / self.numerator

    def at_or_after(self, time: int) -> int:
        """Return the first row at or after a time (us)."""
        return -(-time * self.numerator // self.step)


class Samples(NamedTuple):
    """Samples of one message in a batch: rows `start` to `stop` of the batch's matrix.

    Attributes
    ----------
    stream : int
        Number of the message.
    start, stop : int
        The first row, and the row after the last.
    times : sequence of int
        Flight time of each sample, us.
    nows : sequence of int
        The latest flight time of any message when the sample came, us.
    """

    stream: int
    start: int
    stop: int
    times: Sequence[int]
    nows: Sequence[int]


class Rows(NamedTuple):
    """Successive rows of one message's channels.

    Attributes
    ----------
    first : int
        Index of the first row.
    values : ndarray, shape (n, n_channels)
        NaN in gaps.
    silent : ndarray of bool, shape (n,), or None
        Where the message was silent for longer than its patience; None for nowhere.
    """

    first: int
    values: FloatArray
    silent: BoolArray | None = None

    @property
    def end(self) -> int:
        """Return the row after the last."""
        return self.first + len(self.values)

    def of(self, columns: ColumnIndex) -> Rows:
        """Return the same rows with these columns only."""
        return Rows(self.first, self.values[:, columns], self.silent)


class _Piece(NamedTuple):
    """Planned rows `start` to `stop`, of one stream, which are rows `first` on of the grid."""

    stream: int
    first: int
    start: int
    stop: int


class _Plan:
    """Rows to be laid, of all streams: each between two samples, or on one, given by their places.

    Attributes
    ----------
    before, after : list of int
        Samples before and after each row; the same twice where the row stands on it.
    weights : list of float
        Share of the sample after.
    gaps, silent : list of int
        Rows that lie in a gap; that lie in a silence.
    passed_over : list of int
        Samples that are not laid.
    pieces : list of _Piece
        Which rows are whose.
    """

    __slots__ = ("after", "before", "gaps", "passed_over", "pieces", "silent", "weights")

    def __init__(self) -> None:
        self.before: list[int] = []
        self.after: list[int] = []
        self.weights: list[float] = []
        self.gaps: list[int] = []
        self.silent: list[int] = []
        self.passed_over: list[int] = []
        self.pieces: list[_Piece] = []


class Track:
    """Plans the rows of one message as its samples come.

    Parameters
    ----------
    stream : int
        Number of the message; also the place of its last sample before a batch.
    grid : Grid
        The grid.
    width : int
        Number of channels.
    fallback : int
        Microseconds of silence after which another source counts; at least 2.5 periods.

    Attributes
    ----------
    first : tuple of int, or None
        Time of the first sample, and the flight time when it came, us.
    last : int or None
        Time of the last sample, us.
    samples, duplicates, overtaken : int
        How many samples were laid, and how many were not because they had the stamp of their
        predecessor or came after a later one.
    gaps : int
        How often samples lay further apart than the grid bridges.
    missing : ndarray of int, shape (width,)
        Samples without a number, by channel.
    """

    def __init__(self, stream: int, grid: Grid, width: int, fallback: int) -> None:
        self.duplicates = 0
        self.overtaken = 0
        self.samples = 0
        self.gaps = 0
        self.missing = np.zeros(width, dtype=np.intp)
        self.last: int | None = None
        self.first: tuple[int, int] | None = None
        self._stream = stream
        self._grid = grid
        self._longest = grid.longest * grid.step
        self._fallback = fallback
        self._next = 0
        self._intervals: deque[int] = deque()
        self._ordered: list[int] = []

    @property
    def period(self) -> int:
        """Return the sample period, us; 1 s while unknown."""
        ordered = self._ordered
        return ordered[(len(ordered) - 1) // 2] if ordered else _UNKNOWN_PERIOD

    @property
    def patience(self) -> int:
        """Return after what silence another source counts, us."""
        return max(self._fallback, self.period * 5 // 2)

    def plan(self, samples: Samples, offset: int, plan: _Plan) -> int:
        """Plan the rows that samples complete.

        Parameters
        ----------
        samples : Samples
            The next samples of this message.
        offset : int
            Place of the batch's first sample; that of this message's last sample before it is
            its number.
        plan : _Plan
            Takes the rows.

        Returns
        -------
        int
            Place of the last sample that counts.
        """
        numerator, step = self._grid.numerator, self._grid.step
        before, after, weights = plan.before, plan.after, plan.weights
        place, last, row = self._stream, self.last, self._next
        at = 0 if last is None else last * numerator
        first, start = row, len(after)
        counted = 0
        for number, (time, now) in enumerate(
            zip(samples.times, samples.nows, strict=True), offset + samples.start
        ):
            came = now if now > time else time
            former, at = at, time * numerator
            gap = silent = False
            if last is None:
                self.first = (time, came)
            elif time <= last:
                at = former
                plan.passed_over.append(number - offset)
                if time == last:
                    self.duplicates += 1
                else:
                    self.overtaken += 1
                continue
            else:
                silent = came - last > self._fallback and came - last > self.patience
                gap = self._is_gap(time - last)
            if last is None or at - former > self._longest:
                # Rows begin, or go on after a pause too long to be filled.
                if len(after) > start:
                    plan.pieces.append(_Piece(self._stream, first, start, len(after)))
                first = row = -(-at // step)
                start = len(after)
            position = row * step
            if position < at:
                laid = len(after)
                weights += [(each - former) / (at - former) for each in range(position, at, step)]
                count = len(weights) - laid
                before += [place] * count
                after += [number] * count
                row += count
                position += count * step
                if gap:
                    plan.gaps += range(laid, laid + count)
                if silent:
                    plan.silent += range(laid, laid + count)
            if position == at:
                before.append(number)
                after.append(number)
                weights.append(1.0)
                row += 1
            place, last = number, time
            counted += 1
        if len(after) > start:
            plan.pieces.append(_Piece(self._stream, first, start, len(after)))
        self.samples += counted
        self.last, self._next = last, row
        return place

    def _is_gap(self, interval: int) -> bool:
        """Take note of an interval, and return whether it is too long to bridge."""
        ordered, intervals = self._ordered, self._intervals
        if len(intervals) == _WINDOW:
            del ordered[bisect_left(ordered, intervals.popleft())]
        intervals.append(interval)
        insort(ordered, interval)
        usual = ordered[(len(ordered) - 1) // 2] if len(ordered) > 1 else _UNKNOWN_PERIOD
        gap = 2 * interval > 5 * usual
        self.gaps += gap
        return gap


class Gridder:
    """Lays the samples of several messages on the grid, as they come.

    Parameters
    ----------
    grid : Grid
        The grid.
    circular : sequence of ndarray of bool, shape (m,)
        For each message its channels that go round: angles from -pi to pi. They come out in that
        range.
    stepwise : sequence of ndarray of bool, shape (m,)
        For each message its channels that keep the former value.
    fallback : int
        Microseconds of silence after which another source counts; at least 2.5 periods.

    Attributes
    ----------
    tracks : tuple of Track
        Where each message stands.
    """

    def __init__(
        self,
        grid: Grid,
        *,
        circular: Sequence[BoolArray],
        stepwise: Sequence[BoolArray],
        fallback: int = 1_000_000,
    ) -> None:
        self._widths = [flags.size for flags in circular]
        self.tracks = tuple(
            Track(stream, grid, width, fallback) for stream, width in enumerate(self._widths)
        )
        self._circular = [columns_at(np.flatnonzero(f)) if f.any() else None for f in circular]
        self._stepwise = [columns_at(np.flatnonzero(f)) if f.any() else None for f in stepwise]
        self._last = np.full((len(self._widths), max(self._widths, default=0)), np.nan)

    def feed(self, batch: Sequence[Samples], values: FloatArray) -> list[tuple[int, Rows]]:
        """Take samples and return the rows that they complete.

        Parameters
        ----------
        batch : sequence of Samples
            Whose the samples are: each message once at most.
        values : ndarray, shape (n, width)
            The samples, none of them infinite; zeros beyond the channels of a message. As wide
            as the widest of these messages.

        Returns
        -------
        list of (int, Rows)
            Number of the message, and its rows. Usually one piece or none of each; more where
            a long pause parts them.
        """
        width = values.shape[1]
        plan = _Plan()
        streams = [samples.stream for samples in batch]
        places = [self.tracks[each.stream].plan(each, len(self._last), plan) for each in batch]
        known = np.concatenate((self._last[:, :width], values))
        self._last[streams, :width] = known.take(places, axis=0)
        self._count_missing(batch, values, plan)
        return self._laid(plan, known) if plan.pieces else []

    def _count_missing(self, batch: Sequence[Samples], values: FloatArray, plan: _Plan) -> None:
        missing = np.isnan(values)
        if np.count_nonzero(missing):
            missing[plan.passed_over] = False
            for stream, start, stop, _, _ in batch:
                counts = missing[start:stop, : self._widths[stream]].sum(axis=0)
                self.tracks[stream].missing += counts

    def _laid(self, plan: _Plan, known: FloatArray) -> list[tuple[int, Rows]]:
        """Return planned rows, each message's in memory of their own."""
        ends = known.take((plan.before, plan.after), axis=0)
        shares = np.empty((2, len(plan.weights), 1))
        shares[1, :, 0] = plan.weights
        np.subtract(1.0, shares[1], out=shares[0])
        # On a sample both ends are that sample.
        lower, upper = ends * shares
        values: FloatArray = np.add(lower, upper, out=lower)
        for stream, _, start, stop in plan.pieces:
            angles = self._circular[stream]
            if angles is not None:
                values[start:stop, angles] = _between_angles(
                    ends[0, start:stop, angles], ends[1, start:stop, angles], shares[1, start:stop]
                )
            steps = self._stepwise[stream]
            if steps is not None:
                values[start:stop, steps] = ends[0, start:stop, steps]
        if plan.gaps:
            values[plan.gaps] = np.nan
        silent: BoolArray | None = None
        if plan.silent:
            silent = np.zeros(len(values), dtype=bool)
            silent[plan.silent] = True
        laid = []
        for stream, first, start, stop in plan.pieces:
            flags = None if silent is None else silent[start:stop]
            own = values[start:stop, : self._widths[stream]].copy()
            laid.append((stream, Rows(first, own, flags)))
        return laid


def _between_angles(start: FloatArray, stop: FloatArray, share: FloatArray) -> FloatArray:
    """Return angles between others, the shorter way round, from -pi to pi."""
    turn = stop - start
    turn -= _TURN * np.rint(turn / _TURN)
    angles: FloatArray = start + share * turn
    return angles - _TURN * np.ceil(angles / _TURN - 0.5)

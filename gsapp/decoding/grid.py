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

Where rows lie depends on the times of the samples alone. Their values are computed in one of two
ways that give the same bits: number by number for the few rows that a live link gives at a time
(one step of NumPy costs as much as thirty of them), by whole matrices for many.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from fractions import Fraction
from itertools import chain
from struct import pack
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from gsapp.quantities import FloatArray

LONGEST_FILL = 60.0
"""Seconds of a pause that are filled with NaN rows; after a longer one rows just go on."""

_WINDOW = 9
_UNKNOWN_PERIOD = 1_000_000
_TURN = 2.0 * math.pi
_FEW = 200  # numbers that are quicker one by one
_TABLE_BEFORE = 200
_TABLE_AFTER = 1000
BoolArray = npt.NDArray[np.bool_]
ColumnIndex = slice | npt.NDArray[np.intp]
Numbers = Sequence[float]


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
            # All messages of a batch lie about the same rows, and so does the next batch.
            start = _TABLE_BEFORE
            self._table_first = first - start
            self._table = self._computed_times(self._table_first, start + count + _TABLE_AFTER)
            self._table.setflags(write=False)
        return self._table[start : start + count]

    def _computed_times(self, first: int, count: int) -> FloatArray:
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


class Rows:
    """Successive rows of one message's channels.

    Parameters
    ----------
    first : int
        Index of the first row.
    values : ndarray, shape (n, n_channels), or list of sequences of float
        The rows; NaN in gaps. A few rows are lists, and become an array where one is asked for.
    silent : ndarray of bool, shape (n,), or None
        Where the message was silent for longer than its patience; None for nowhere.

    Attributes
    ----------
    few : list of sequences of float, or None
        The rows as lists, if they are few.
    """

    __slots__ = ("_values", "few", "first", "silent")

    def __init__(
        self,
        first: int,
        values: FloatArray | list[Numbers],
        silent: BoolArray | None = None,
    ) -> None:
        self.first = first
        self.silent = silent
        self.few: list[Numbers] | None = None
        self._values: FloatArray | None = None
        if isinstance(values, list):
            self.few = values
        else:
            self._values = values

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.few) if self.few is not None else len(self.values)

    @property
    def values(self) -> FloatArray:
        """Return the rows, shape (n, n_channels)."""
        if self._values is None:
            self._values = np.array(self.few, dtype=np.float64)
        return self._values

    def become(self, buffer: bytes, offset: int) -> int:
        """Take the values of a few rows from a buffer; return the place after them, bytes."""
        rows = self.few or []
        shape = (len(rows), len(rows[0]))
        self._values = np.ndarray(shape, np.float64, buffer, offset)
        return offset + self._values.nbytes

    @property
    def end(self) -> int:
        """Return the row after the last."""
        return self.first + len(self)

    def of(self, columns: ColumnIndex) -> Rows:
        """Return the same rows with these columns only."""
        if self.few is not None and isinstance(columns, slice):
            return Rows(self.first, [row[columns] for row in self.few], self.silent)
        return Rows(self.first, self.values[:, columns], self.silent)

    def part(self, start: int, stop: int) -> Rows:
        """Return the rows from one index of the grid to before another."""
        part = slice(start - self.first, stop - self.first)
        return Rows(start, self.values[part] if self.few is None else self.few[part])


def pack_together(pieces: Sequence[Rows]) -> None:
    """Make arrays of rows that are lists: one buffer for all is far quicker than one for each."""
    few = [piece for piece in pieces if piece.few]
    rows = [row for piece in few for row in piece.few or ()]
    buffer = pack(f"{sum(map(len, rows))}d", *chain.from_iterable(rows))
    offset = 0
    for piece in few:
        offset = piece.become(buffer, offset)


class _Plan(NamedTuple):
    """Successive rows to be laid: each between two samples, or on one, given by their places.

    Attributes
    ----------
    first : int
        The first row.
    before, after : list of int
        Samples before and after each row; the same twice where the row stands on it.
    weights : list of float
        Share of the sample after.
    gaps, silent : list of int
        Rows, counted from the first, that lie in a gap; that lie in a silence.
    """

    first: int
    before: list[int]
    after: list[int]
    weights: list[float]
    gaps: list[int]
    silent: list[int]

    def silence(self) -> BoolArray | None:
        """Return which rows lie in a silence; None for none."""
        if not self.silent:
            return None
        flags = np.zeros(len(self.after), dtype=bool)
        flags[self.silent] = True
        return flags


class Gridder:
    """Lays the samples of one message on the grid, as they come.

    Parameters
    ----------
    grid : Grid
        The grid.
    circular : ndarray of bool, shape (m,)
        Channels that go round: angles from -pi to pi. They come out in that range.
    stepwise : ndarray of bool, shape (m,)
        Channels that keep the former value.
    fallback : int
        Microseconds of silence after which another source counts; at least 2.5 periods.

    Attributes
    ----------
    first : tuple of int, or None
        Time of the first sample, and the flight time when it came, us.
    begin : int
        The first row at or after the first sample.
    last : int or None
        Time of the last sample, us.
    samples, duplicates, overtaken : int
        How many samples were laid, and how many were not because they had the stamp of their
        predecessor or came after a later one.
    gaps : int
        How often samples lay further apart than the grid bridges.
    missing : list of int
        Samples without a number, by channel.
    """

    def __init__(
        self, grid: Grid, *, circular: BoolArray, stepwise: BoolArray, fallback: int = 1_000_000
    ) -> None:
        self.duplicates = 0
        self.overtaken = 0
        self.samples = 0
        self.gaps = 0
        self.missing = [0] * circular.size
        self.last: int | None = None
        self.first: tuple[int, int] | None = None
        self.begin = 0
        self._grid = grid
        self._longest = grid.longest * grid.step
        self._angles: list[int] = np.flatnonzero(circular).tolist()
        self._steps: list[int] = np.flatnonzero(stepwise).tolist()
        self._circular = columns_at(self._angles)
        self._stepwise = columns_at(self._steps)
        self._fallback = fallback
        self._value: FloatArray | Numbers = [math.nan] * circular.size
        self._next = 0
        self._intervals: deque[int] = deque(maxlen=_WINDOW)
        self._least = 0  # none of these intervals is shorter

    @property
    def period(self) -> int:
        """Return the sample period, us; 1 s while unknown."""
        ordered = sorted(self._intervals)
        return ordered[(len(ordered) - 1) // 2] if ordered else _UNKNOWN_PERIOD

    @property
    def patience(self) -> int:
        """Return after what silence another source counts, us."""
        return max(self._fallback, self.period * 5 // 2)

    def feed(
        self,
        times: Sequence[int],
        nows: Sequence[int],
        values: FloatArray | Sequence[Numbers],
        *,
        complete: bool = False,
    ) -> list[Rows]:
        """Take samples and return the rows that they complete.

        Parameters
        ----------
        times : sequence of int
            Flight time of each sample, us.
        nows : sequence of int
            The latest flight time of any message when the sample came, us.
        values : ndarray, shape (n, m), or sequence of sequences of float
            The samples, none of them infinite. They are kept: the caller writes to them no more.
        complete : bool
            Whether it is known that no number is missing.

        Returns
        -------
        list of Rows
            Usually one, or none; more where a long pause parts them.
        """
        plans, place, passed_over = self._plan(times, nows)
        if not place:
            return []
        if not complete:
            self._count_missing(values, passed_over)
        if isinstance(values, np.ndarray):
            known = np.empty((len(values) + 1, values.shape[1]))
            known[0], known[1:] = self._value, values
            rows = [self._laid(each, known) for each in plans if each.after]
            self._value = known[place].copy()
        else:
            former = self._value
            few = (former.tolist() if isinstance(former, np.ndarray) else former, *values)
            rows = [self._laid_singly(each, few) for each in plans if each.after]
            self._value = few[place]
        return rows

    def _plan(
        self, times: Sequence[int], nows: Sequence[int]
    ) -> tuple[list[_Plan], int, list[int]]:
        """Plan the rows that samples complete; return them, the last sample that counts, others.

        Place 0 is the last sample before these, if there is one; place 1 the first of these.
        """
        numerator, step, fallback = self._grid.numerator, self._grid.step, self._fallback
        place, last = 0, self.last
        at = 0 if last is None else last * numerator
        row = self._next
        plan = _Plan(row, [], [], [], [], [])
        plans = [plan]
        _, befores, afters, weights, gaps, silents = plan
        passed_over = []
        index = 0
        for time, now in zip(times, nows, strict=True):
            index += 1
            came = now if now > time else time
            if last is None:
                before, gap, silent = at, False, False
                self.first = (time, came)
            elif time > last:
                passed = came - last
                silent = passed > fallback and passed > self.patience
                before, gap = at, self._is_gap(time - last)
            else:
                passed_over.append(index)
                self._pass_over(repeated=time == last)
                continue
            at = time * numerator
            if last is None:
                self.begin = -(-at // step)
            if last is None or at - before > self._longest:
                # Rows begin, or go on after a pause too long to be filled.
                row = -(-at // step)
                plan = _Plan(row, [], [], [], [], [])
                plans.append(plan)
                _, befores, afters, weights, gaps, silents = plan
            position = row * step
            if position < at:
                between, start = at - before, len(afters)
                weights += [each / between for each in range(position - before, between, step)]
                stop = len(weights)
                befores += [place] * (stop - start)
                afters += [index] * (stop - start)
                if gap:
                    gaps += range(start, stop)
                if silent:
                    silents += range(start, stop)
                row += stop - start
                position = row * step
            if position == at:
                befores.append(index)
                afters.append(index)
                weights.append(1.0)
                row += 1
            place, last = index, time
        self.samples += index - len(passed_over)
        self.last = last
        self._next = row
        return plans, place, passed_over

    def _pass_over(self, *, repeated: bool) -> None:
        """Count a sample that is not later than the last one."""
        if repeated:
            self.duplicates += 1
        else:
            self.overtaken += 1

    def _count_missing(
        self, values: FloatArray | Sequence[Numbers], passed_over: Sequence[int]
    ) -> None:
        if isinstance(values, np.ndarray):
            missing = np.isnan(values)
            if np.count_nonzero(missing):
                missing[[index - 1 for index in passed_over]] = False
                counts = missing.sum(axis=0).tolist()
                self.missing = [x + y for x, y in zip(self.missing, counts, strict=True)]
            return
        for index, numbers in enumerate(values, start=1):
            if math.isnan(sum(numbers)) and index not in passed_over:
                for place, number in enumerate(numbers):
                    self.missing[place] += math.isnan(number)

    def _is_gap(self, interval: int) -> bool:
        """Take note of an interval, and return whether it is too long to bridge."""
        self._intervals.append(interval)
        if interval < self._least:
            self._least = interval
        if 2 * interval <= 5 * self._least:
            return False  # the usual case, told without the median
        if len(self._intervals) > 1:
            self._least = min(self._intervals)
        usual = self.period if len(self._intervals) > 1 else _UNKNOWN_PERIOD
        gap = 2 * interval > 5 * usual
        self.gaps += gap
        return gap

    def _laid(self, plan: _Plan, known: FloatArray) -> Rows:
        """Return planned rows between the samples known."""
        result = self._between(plan, known)
        if self._angles:
            angles = result[:, self._circular]
            result[:, self._circular] = angles - _TURN * np.ceil(angles / _TURN - 0.5)
        return Rows(plan.first, result, plan.silence())

    def _between(self, plan: _Plan, known: FloatArray) -> FloatArray:
        """Return values of planned rows. On a sample both ends are that sample."""
        start, stop = known.take(plan.before, axis=0), known.take(plan.after, axis=0)
        share = np.array(plan.weights)[:, np.newaxis]
        values: FloatArray = start * (1.0 - share)
        values += stop * share
        if self._angles:
            turn = stop[:, self._circular] - start[:, self._circular]
            turn -= _TURN * np.rint(turn / _TURN)
            values[:, self._circular] = start[:, self._circular] + share * turn
        if self._steps:
            values[:, self._stepwise] = start[:, self._stepwise]
        if plan.gaps:
            values[plan.gaps] = np.nan
        return values

    def _laid_singly(self, plan: _Plan, known: Sequence[Numbers]) -> Rows:
        """Return planned rows: `_laid`, number by number if they are few."""
        width = len(known[0])
        if len(plan.after) * width > _FEW:
            return self._laid(plan, np.array(known))
        places = list(zip(plan.before, plan.after, plan.weights, strict=True))
        rows: list[Numbers]
        if len(places) > 2 * width:
            columns = [self._column_singly(place, places, known) for place in range(width)]
            rows = list(zip(*columns, strict=True))
        else:
            rests = [1.0 - share for share in plan.weights]
            rows = [
                known[after]
                if before == after
                else [
                    x * rest + y * share for x, y in zip(known[before], known[after], strict=True)
                ]
                for (before, after, share), rest in zip(places, rests, strict=True)
            ]
            if self._angles or self._steps:
                rows = [
                    self._mended(row, known[before], known[after], share)
                    for row, (before, after, share) in zip(rows, places, strict=True)
                ]
        for gap in plan.gaps:
            rows[gap] = [math.nan] * width
        return Rows(plan.first, rows, plan.silence())

    def _mended(self, row: Numbers, start: Numbers, stop: Numbers, share: float) -> Numbers:
        """Return a row with what goes round, and what keeps its former value."""
        mended = list(row)
        for place in self._angles:
            mended[place] = _angle_between(start[place], stop[place], share)
        for place in self._steps:
            mended[place] = start[place]
        return mended

    def _column_singly(
        self, column: int, places: Sequence[tuple[int, int, float]], known: Sequence[Numbers]
    ) -> Numbers:
        numbers = [row[column] for row in known]
        if column in self._angles:
            return [
                _angle_between(numbers[before], numbers[after], share)
                for before, after, share in places
            ]
        if column in self._steps:
            return [numbers[before] for before, _, _ in places]
        return [
            numbers[before] * (1.0 - share) + numbers[after] * share
            for before, after, share in places
        ]


def _angle_between(start: float, stop: float, share: float) -> float:
    """Return an angle between two, the shorter way round, from -pi to pi.

    The steps of `Gridder._between` and `Gridder._laid` for a single number.
    """
    turn = stop - start
    if not -3.0 < turn < 3.0:
        if math.isnan(turn):
            return math.nan
        turn -= _TURN * round(turn / _TURN)
    angle = start + share * turn
    if not -3.0 < angle < 3.0:
        angle -= _TURN * math.ceil(angle / _TURN - 0.5)
    # Where NumPy subtracts a negative zero, whole numbers have a positive one.
    return angle + 0.0

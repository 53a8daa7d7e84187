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
"""

from __future__ import annotations

from bisect import bisect_left, insort
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from gsapp.quantities import FloatArray

LONGEST_FILL = 60.0
"""Seconds of a pause that are filled with NaN rows; after a longer one rows just go on."""

_WINDOW = 9
_UNKNOWN_PERIOD = 1_000_000
_TURN = 2.0 * np.pi
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]


class Grid:
    """The times k / rate, in whole numbers.

    Parameters
    ----------
    rate : float
        Rows per second.
    """

    __slots__ = ("denominator", "longest", "numerator", "rate", "step")

    def __init__(self, rate: float) -> None:
        if not 0.0 < rate <= 100_000.0:
            raise ValueError(f"a grid of {rate} rows per second is not offered; use 0.01 to 1e5")
        exact = Fraction(rate).limit_denominator(1000)
        self.rate = float(exact)
        self.numerator = exact.numerator
        self.denominator = exact.denominator
        self.step = 1_000_000 * exact.denominator
        self.longest = int(LONGEST_FILL * self.rate)

    def times(self, first: int, count: int) -> FloatArray:
        """Return the times of rows `first` and following, s."""
        rows = np.arange(first, first + count, dtype=np.int64)
        return rows * self.denominator / self.numerator

    def micros(self, first: int, count: int) -> FloatArray:
        """Return the times of rows `first` and following, us."""
        rows = np.arange(first, first + count, dtype=np.int64)
        return rows * self.step / self.numerator

    def at_or_after(self, time: int) -> int:
        """Return the first row at or after a time (us)."""
        return -(-time * self.numerator // self.step)


@dataclass(frozen=True, slots=True, eq=False)
class Rows:
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
    """

    def __init__(
        self, grid: Grid, *, circular: BoolArray, stepwise: BoolArray, fallback: int = 1_000_000
    ) -> None:
        self.duplicates = 0
        self.overtaken = 0
        self.last: int | None = None
        self.first: tuple[int, int] | None = None
        self._grid = grid
        self._circular = circular if circular.any() else None
        self._stepwise = stepwise if stepwise.any() else None
        self._fallback = fallback
        self._value: FloatArray = np.empty((0, circular.size))
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

    @property
    def next_row(self) -> int:
        """Return the row that the next sample may complete."""
        return self._next

    def feed(self, times: Sequence[int], nows: Sequence[int], values: FloatArray) -> list[Rows]:
        """Take samples and return the rows that they complete.

        Parameters
        ----------
        times : sequence of int
            Flight time of each sample, us.
        nows : sequence of int
            The latest flight time of any message when the sample came, us.
        values : ndarray, shape (n, m)
            The samples.

        Returns
        -------
        list of Rows
            Usually one, or none; more where a long pause parts them.
        """
        kept: list[int] = []
        stamps: list[int] = []
        gaps: list[bool] = []
        silences: list[bool] = []
        last = self.last
        for index, time in enumerate(times):
            if last is None:
                self.first = (time, max(nows[index], time))
                gaps.append(True)
                silences.append(False)
            elif time <= last:
                if time == last:
                    self.duplicates += 1
                else:
                    self.overtaken += 1
                continue
            else:
                interval = time - last
                patience = self.patience
                gaps.append(self._is_gap(interval))
                silences.append(max(nows[index], time) > last + patience)
            kept.append(index)
            stamps.append(time)
            last = time
        if not kept:
            return []
        if len(kept) < len(times):
            values = values[kept]
        if len(kept) == 1 and self.last is not None:
            found = self._single(stamps[0], values)
            if found is not None:
                return found
        return self._rows(stamps, gaps, silences, values)

    def _single(self, time: int, values: FloatArray) -> list[Rows] | None:
        """Take the usual sample of a live link: it completes no row, or the one it stands on.

        Returns None where `_rows` must see to it; where both could, both give the same.
        """
        step = self._grid.step
        row, rest = divmod(time * self._grid.numerator, step)
        if row >= self._next and (row > self._next or rest):
            return None
        self.last = time
        self._value = values
        if row < self._next:
            return []
        self._next = row + 1
        return [Rows(row, self._wrapped(values))]

    def _is_gap(self, interval: int) -> bool:
        """Take note of an interval, and return whether it is too long to bridge."""
        ordered, intervals = self._ordered, self._intervals
        if len(intervals) == _WINDOW:
            del ordered[bisect_left(ordered, intervals.popleft())]
        intervals.append(interval)
        insort(ordered, interval)
        if len(ordered) == 1:
            return 2 * interval > 5 * _UNKNOWN_PERIOD
        return 2 * interval > 5 * ordered[(len(ordered) - 1) // 2]

    def _rows(
        self, stamps: list[int], gaps: list[bool], silences: list[bool], values: FloatArray
    ) -> list[Rows]:
        grid = self._grid
        fresh = self.last is None
        before = [] if self.last is None else [self.last]
        if fresh:
            self._next = grid.at_or_after(stamps[0])
        self.last = stamps[-1]
        at = np.array(before + stamps, dtype=np.int64) * grid.numerator
        samples = values if fresh else np.concatenate((self._value, values))
        self._value = values[-1:]
        # Flags of the interval that ends at each sample of `at`; nothing ends at the first.
        flags = ([] if fresh else [True], [] if fresh else [False])
        gap = np.array(flags[0] + gaps)
        silent = np.array(flags[1] + silences)
        result = []
        start = 0
        longest = grid.longest * grid.step
        if int(at[-1] - at[0]) > longest:
            for place in np.flatnonzero(np.diff(at) > longest).tolist():
                result += self._piece(
                    at[start : place + 1], samples[start : place + 1], gap[start:], silent[start:]
                )
                start = place + 1
                self._next = -(-int(at[start]) // grid.step)
        return result + self._piece(at[start:], samples[start:], gap[start:], silent[start:])

    def _piece(
        self, at: IntArray, samples: FloatArray, gap: BoolArray, silent: BoolArray
    ) -> list[Rows]:
        """Complete the rows up to the last of some samples without a long pause between."""
        step = self._grid.step
        first, end = self._next, int(at[-1]) // step + 1
        if end <= first:
            return []
        self._next = end
        position = np.arange(first, end, dtype=np.int64) * step
        after = np.searchsorted(at, position, side="left")
        exact = at[after] == position
        upper = samples[after]
        hushed = silent[after] & ~exact
        quiet = hushed if hushed.any() else None
        if exact.all():
            return [Rows(first, self._wrapped(upper), quiet)]
        before = np.maximum(after - 1, 0)
        lower = samples[before]
        length = np.where(exact, step, at[after] - at[before])
        weight = ((position - at[before]) / length)[:, np.newaxis]
        values = lower * (1.0 - weight) + upper * weight
        if self._circular is not None:
            turn = upper[:, self._circular] - lower[:, self._circular]
            turn -= _TURN * np.rint(turn / _TURN)
            values[:, self._circular] = lower[:, self._circular] + weight * turn
        if self._stepwise is not None:
            values[:, self._stepwise] = lower[:, self._stepwise]
        values[gap[after]] = np.nan
        values[exact] = upper[exact]
        return [Rows(first, self._wrapped(values), quiet)]

    def _wrapped(self, values: FloatArray) -> FloatArray:
        if self._circular is None:
            return values
        wrapped = values.copy()
        angles = wrapped[:, self._circular]
        wrapped[:, self._circular] = angles - _TURN * np.ceil(angles / _TURN - 0.5)
        return wrapped

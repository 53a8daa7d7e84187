"""The grid k / rate of flight time, on which all samples are laid."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from gsapp.decoding.settings import DECODING
from gsapp.quantities import FloatArray

_TABLE_BEFORE = 200
_TABLE_AFTER = 1000
BoolArray = npt.NDArray[np.bool_]
ColumnIndex = slice | npt.NDArray[np.intp]
Numbers = Sequence[float]


def column_index(places: Sequence[int] | npt.NDArray[np.intp]) -> ColumnIndex:
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

    __slots__ = (
        "_table",
        "_table_first",
        "denominator",
        "max_filled_rows",
        "numerator",
        "rate",
        "step",
    )

    def __init__(self, rate: float) -> None:
        if not 0.01 <= rate <= 100_000.0:
            raise ValueError(f"grid rate of {rate} rows per second is not offered; use 0.01 to 1e5")
        exact = Fraction(rate).limit_denominator(1000)
        self.rate = float(exact)
        self.numerator = exact.numerator
        self.denominator = exact.denominator
        self.step = 1_000_000 * exact.denominator
        self.max_filled_rows = int(DECODING.max_filled_pause * self.rate)
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

    def times_us(self, first: int, count: int) -> FloatArray:
        """Return the times of rows `first` and following, us."""
        start, stop = first * self.step, (first + count) * self.step
        return np.arange(start, stop, self.step, dtype=np.int64) / self.numerator

    def row_at_or_after(self, time: int) -> int:
        """Return the first row at or after a time (us)."""
        return -(-time * self.numerator // self.step)

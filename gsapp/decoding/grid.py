"""The grid k / rate of flight time, its rows, and how those of many messages are laid in one go.

A live link gives a few rows of each message at a time. One step of NumPy costs as much as thirty
numbers in Python, and so does an array for each message; so the rows of all messages of a batch
are laid together, on one sheet.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from struct import pack

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
    """The times k / rate, in whole numbers, for `rate` rows per second."""

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


_NONE = np.empty((0, 0))


class GridRows:
    """Successive rows of one message's channels, from row `first` of the grid on.

    Values have the shape (n, n_channels); NaN in gaps. Those of rows on a `RowBatch` are there
    once it is laid. `silent`, shape (n,), says where the message was silent for longer than its
    patience; None for nowhere. `few` rows are so few that more is computed from them number by
    number.
    """

    __slots__ = ("few", "first", "silent", "values")

    def __init__(
        self,
        first: int,
        values: FloatArray,
        silent: BoolArray | None = None,
        few: bool = False,
    ) -> None:
        self.first = first
        self.values = values
        self.silent = silent
        self.few = few

    def __len__(self) -> int:
        return len(self.values)

    @property
    def end(self) -> int:
        return self.first + len(self.values)

    def select_columns(self, columns: ColumnIndex) -> GridRows:
        """Return the same rows with these columns only."""
        return GridRows(self.first, self.values[:, columns], self.silent, few=self.few)

    def slice_rows(self, start: int, stop: int) -> GridRows:
        """Return the rows from one index of the grid to before another."""
        part = slice(start - self.first, stop - self.first)
        return GridRows(start, self.values[part], few=self.few)


class RowBatch:
    """Rows of several messages, to be laid together.

    Each number of a row is ``start * (1 - share) + stop * share``. Who adds rows adds their
    numbers, one row after the other, to `starts`, `stops` and `shares`, and then calls `add`.
    """

    __slots__ = ("_pieces", "shares", "starts", "stops")

    def __init__(self) -> None:
        self.starts: list[float] = []
        self.stops: list[float] = []
        self.shares: list[float] = []
        self._pieces: list[tuple[GridRows, int, int]] = []

    def add(self, first: int, count: int, width: int, silent: BoolArray | None) -> GridRows:
        """Return the rows whose numbers were added last; they have none before `compute_rows`."""
        rows = GridRows(first, _NONE, silent, True)
        self._pieces.append((rows, count, width))
        return rows

    def compute_rows(self) -> None:
        """Compute all rows that were added, and begin anew."""
        if not self._pieces:
            return
        count = len(self.starts)
        # Packing is three times as quick as making arrays of lists.
        whole = np.frombuffer(pack(f"{3 * count}d", *self.starts, *self.stops, *self.shares))
        shares = whole[2 * count :]
        values = whole[:count] * (1.0 - shares)
        values += whole[count : 2 * count] * shares
        offset = 0
        for rows, length, width in self._pieces:
            rows.values = np.ndarray((length, width), np.float64, values, offset)
            offset += 8 * length * width
        for each in (self.starts, self.stops, self.shares, self._pieces):
            each.clear()

"""Successive rows of the grid, and how those of many messages are laid in one go.

A live link gives a few rows of each message at a time. One step of NumPy costs as much as thirty
numbers in Python, and so does an array for each message; so the rows of all messages of a batch
are laid together, on one sheet.
"""

from __future__ import annotations

from struct import pack

import numpy as np

from gsapp.decoding.grid import BoolArray, ColumnIndex
from gsapp.quantities import FloatArray

_NONE = np.empty((0, 0))


class GridRows:
    """Successive rows of one message's channels.

    Parameters
    ----------
    first : int
        Index of the first row.
    values : ndarray, shape (n, n_channels)
        The rows; NaN in gaps. Those of rows on a `RowBatch` are there once it is laid.
    silent : ndarray of bool, shape (n,), or None
        Where the message was silent for longer than its patience; None for nowhere.
    few : bool
        Whether they are so few that more is computed from them number by number.
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

    Each number of a row is ``start * (1 - share) + stop * share``.

    Attributes
    ----------
    starts, stops, shares : list of float
        The numbers of all rows, one row after the other. Who adds rows adds to all three alike,
        and then calls `add`.
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

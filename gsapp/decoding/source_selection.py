"""Several sources of one channel: which one counts, row by row.

The better source counts while it lives. It falls silent when flight time has gone on by more
than its patience since its last sample; the rows since then are taken from the next source, until
the better one is back. What a row holds depends on the samples and on what flight time it was
when they came, so on the record alone: a row is handed out only when nothing that may still come
could change it.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

import numpy as np

from gsapp.decoding.grid import Grid, GridRows
from gsapp.decoding.gridder import Gridder

_FOREVER = 2**62


class SourceSelector:
    """Chooses among sources of the same `width` channels, the better first.

    Their rows go to `push`. A source has `fallback` us for its first sample.
    """

    def __init__(self, grid: Grid, sources: Sequence[Gridder], width: int, fallback: int) -> None:
        self._grid = grid
        self._sources = tuple(sources)
        self._rows: list[deque[GridRows]] = [deque() for _ in sources]
        self._width = width
        self._fallback = fallback
        self._next: int | None = None
        self._start = 0
        self._begun = False

    @property
    def pending_count(self) -> int:
        return sum(map(len, self._rows))

    def push(self, source: int, rows: Sequence[GridRows]) -> None:
        """Take rows of a source, with the columns of this merger's channels only."""
        self._rows[source].extend(rows)

    def pull(self, first: int | None, now: int, *, final: bool = False) -> list[GridRows]:
        """Return the rows that are decided.

        `first` is the flight time at which the record begins, `now` the latest one of any message
        (us); `final` says that nothing more will come.
        """
        if first is None or not (final or any(self._rows)):
            return []
        if self._next is None:
            self._start = first
            self._next = self._grid.row_at_or_after(first)
        found: list[GridRows] = []
        while True:
            piece, end = self._decide(self._next, now, final=final)
            if end == self._next:
                self._forget()
                return found
            if piece is not None:
                found.append(piece)
                self._begun = True
            self._next = end

    def _forget(self) -> None:
        for rows in self._rows:
            while rows and rows[0].end <= (self._next or 0):
                rows.popleft()

    def _decide(self, row: int, now: int, *, final: bool) -> tuple[GridRows | None, int]:
        """Return the rows from `row` on that are decided alike, and the row after them."""
        limit = _FOREVER
        for number, source in enumerate(self._sources):
            rows = self._rows[number]
            while rows and rows[0].end <= row:
                rows.popleft()
            if source.first is not None and row < source.begin:
                begin = source.begin
                if source.first[1] > self._start + self._fallback:
                    limit = min(limit, begin)
                    continue
                # It came in time; before its first sample there is nothing.
                return self._nothing(row, min(limit, begin))
            if rows and rows[0].first <= row:
                piece = rows[0]
                offset = row - piece.first
                silent = piece.silent
                if silent is not None and silent[offset]:
                    limit = min(limit, row + _leading_false_count(~silent[offset:]))
                    continue
                if silent is None and not offset and piece.end <= limit:
                    return piece, piece.end
                end = piece.end if silent is None else row + _leading_false_count(silent[offset:])
                end = min(end, limit)
                return piece.slice_rows(row, end), end
            if rows:
                # A pause too long to be filled.
                limit = min(limit, rows[0].first)
                continue
            since = self._start if source.last is None else source.last
            patience = self._fallback if source.last is None else source.silence_timeout
            # At the end a source that never spoke is given up; one that did keeps its place.
            if now > since + patience or (final and source.last is None):
                continue
            return None, row
        if limit == _FOREVER:
            return None, row
        return self._nothing(row, limit)

    def _nothing(self, row: int, end: int) -> tuple[GridRows | None, int]:
        if not self._begun or end - row > self._grid.max_filled_rows:
            return None, end
        return GridRows(row, np.full((end - row, self._width), np.nan)), end


def _leading_false_count(stops: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> int:
    place = int(np.argmax(stops)) if stops.size else 0
    return place if stops.size and stops[place] else int(stops.size)

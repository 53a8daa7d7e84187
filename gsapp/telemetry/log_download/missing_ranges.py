"""Which bytes of a file are still missing."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterable


class MissingRanges:
    """Stretches of bytes that have not come, in order.

    Parameters
    ----------
    size : int
        Of the whole file.
    ranges : iterable of (int, int), optional
        First byte and the one after the last, as `ranges` gave them; all if left out.

    Raises
    ------
    ValueError
        If they lie outside the file or over each other.
    """

    def __init__(self, size: int, stretches: Iterable[tuple[int, int]] | None = None) -> None:
        given = [(0, size)] if stretches is None else [(int(a), int(b)) for a, b in stretches]
        given = [(a, b) for a, b in given if a < b]
        ends = [edge for pair in given for edge in pair]
        if ends != sorted(ends) or (ends and not 0 <= ends[0] <= ends[-1] <= size):
            raise ValueError(f"{given} are no stretches of a file of {size} bytes")
        self._starts = [a for a, _ in given]
        self._stops = [b for _, b in given]
        self.missing_bytes = sum(b - a for a, b in given)

    @property
    def ranges(self) -> tuple[tuple[int, int], ...]:
        """Return them: first byte and the one after the last."""
        return tuple(zip(self._starts, self._stops, strict=True))

    def __bool__(self) -> bool:
        return bool(self._starts)

    def mark_received(self, start: int, stop: int) -> int:
        """Note that bytes have come; return how many of them had been missing."""
        if stop <= start:
            return 0
        first = bisect_right(self._stops, start)
        last = bisect_left(self._starts, stop)
        if first >= last:
            return 0
        left = self._starts[first], min(start, self._stops[first])
        right = max(stop, self._starts[last - 1]), self._stops[last - 1]
        before = sum(self._stops[k] - self._starts[k] for k in range(first, last))
        kept = [pair for pair in (left, right) if pair[0] < pair[1]]
        self._starts[first:last] = [pair[0] for pair in kept]
        self._stops[first:last] = [pair[1] for pair in kept]
        came = before - sum(b - a for a, b in kept)
        self.missing_bytes -= came
        return came

    def is_missing_any(self, start: int, stop: int) -> bool:
        return start < stop and bisect_right(self._stops, start) < bisect_left(self._starts, stop)

    def next_range(self, position: int, most: int, join: int) -> tuple[int, int] | None:
        """Return what to ask for next: the first missing stretch at or after a position.

        Parameters
        ----------
        position : int
            From here on; from the beginning where nothing is missing beyond.
        most : int
            Bytes at once.
        join : int
            Missing stretches no farther apart than this are asked for as one.

        Returns
        -------
        tuple of int or None
            First byte and the one after the last; None where nothing is missing.
        """
        if not self._starts:
            return None
        place = bisect_right(self._stops, position)
        if place == len(self._starts):
            place, position = 0, 0
        start = max(self._starts[place], position)
        stop = self._stops[place]
        while place + 1 < len(self._starts) and self._starts[place + 1] - stop <= join:
            place += 1
            stop = self._stops[place]
        return start, min(stop, start + most)

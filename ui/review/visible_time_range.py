"""Which stretch of a flight is in sight on the time line. No Qt."""

from __future__ import annotations

_MIN_SECONDS = 0.5
"""Seconds in sight at least: some tens of samples."""
_ZOOM_MARGIN = 0.35
"""Share of a maneuver's length left free on either side when it is zoomed to."""


class VisibleTimeRange:
    """A stretch of time within a flight.

    Parameters
    ----------
    first, last : float
        Ends of the flight, s.

    Attributes
    ----------
    start, stop : float
        In sight, s.
    """

    def __init__(self, first: float = 0.0, last: float = 1.0) -> None:
        self.first, self.last = first, max(last, first + _MIN_SECONDS)
        self.start, self.stop = self.first, self.last

    @property
    def seconds(self) -> float:
        return self.stop - self.start

    @property
    def shows_all(self) -> bool:
        return self.start <= self.first and self.stop >= self.last

    def show(self, start: float, stop: float) -> None:
        """Show a stretch, held within the flight."""
        length = min(max(stop - start, _MIN_SECONDS), self.last - self.first)
        middle = (start + stop) / 2.0
        self.start = min(max(middle - length / 2.0, self.first), self.last - length)
        self.stop = self.start + length

    def show_all(self) -> None:
        self.show(self.first, self.last)

    def zoom(self, factor: float, anchor: float | None = None) -> None:
        at = (self.start + self.stop) / 2.0 if anchor is None else anchor
        length = min(max(self.seconds * factor, _MIN_SECONDS), self.last - self.first)
        share = (at - self.start) / self.seconds
        start = at - share * length
        self.show(start, start + length)

    def pan(self, seconds: float) -> None:
        """Move on, or back if negative."""
        self.show(self.start + seconds, self.stop + seconds)

    def zoom_to(self, start: float, stop: float) -> None:
        """Show a maneuver with some room on either side."""
        room = _ZOOM_MARGIN * (stop - start)
        self.show(start - room, stop + room)

    def scroll_to(self, start: float, stop: float) -> None:
        """Move as far as needed to see a stretch; zoom out where it is longer than the sight."""
        if self.start <= start and stop <= self.stop:
            return
        if stop - start > self.seconds:
            self.zoom_to(start, stop)
            return
        middle = (start + stop - self.seconds) / 2.0
        self.show(middle, middle + self.seconds)

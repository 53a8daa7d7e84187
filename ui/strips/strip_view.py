"""What part of the flight is in sight, and where the cursors stand. No Qt.

The display follows the newest sample, or is paused at a time of its own; recording knows nothing
of it. All of it is in whole columns, so that charts and cursors agree to the pixel.
"""

from __future__ import annotations

from ui.strips.pixel_columns import ColumnScale, select_column_scale

WINDOWS = (
    0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 30.0, 60.0, 120.0, 300.0, 600.0, 1200.0, 1800.0, 3600.0, 7200.0,
)  # fmt: skip
"""Seconds in sight, by step of the zoom."""

CURSORS = ("cursor", "a", "b")


class StripView:
    """The window in time, the pause, the cursors, the chart chosen.

    `rate`: samples per second, Hz. `window`: seconds wanted in sight.
    """

    def __init__(self, *, width: int = 1, rate: float = 100.0, window: float = 60.0) -> None:
        self._width = max(width, 1)
        self._rate = rate
        self._window = window
        self._scale = select_column_scale(window, self._width, rate)
        self._held: float | None = None
        self.now: float | None = None  # Newest flight time, s; None before the first sample.
        self.start: float | None = None  # Where the flight begins, s.
        # Times (s) of ``cursor``, ``a`` and ``b``, where they are set.
        self.cursors: dict[str, float] = {}
        self.selected = 0  # Number of the chart chosen.
        self.enlarged = False  # Whether that chart alone fills the display.

    # What is in sight

    @property
    def width(self) -> int:
        return self._width

    @property
    def scale(self) -> ColumnScale:
        """Return how columns lie on the samples."""
        return self._scale

    @property
    def window(self) -> float:
        """Return the seconds asked for; `seconds` are those in sight."""
        return self._window

    @property
    def seconds(self) -> float:
        """Return the seconds in sight."""
        return self._width * self._scale.seconds

    @property
    def columns(self) -> tuple[int, int]:
        """Return first and one past the last column in sight."""
        latest = self._held if self._held is not None else self.now
        last = self._scale.column(latest) + 1 if latest is not None else self._width
        return last - self._width, last

    @property
    def times(self) -> tuple[float, float]:
        """Return the flight times at both edges, s."""
        first, last = self.columns
        return self._scale.time(first), self._scale.time(last)

    @property
    def paused(self) -> bool:
        return self._held is not None

    @property
    def seconds_behind(self) -> float:
        """Return how far the right edge is behind the newest sample, s."""
        if self._held is None or self.now is None:
            return 0.0
        return max(self.now - self._held, 0.0)

    def x(self, time: float) -> int:
        """Return the column of a time, counted from the left edge; may lie outside."""
        return self._scale.column(time) - self.columns[0]

    def time(self, x: float) -> float:
        """Return the time at which column `x` from the left edge begins, s."""
        return self._scale.time(self.columns[0] + x)

    def sample_time(self, x: float) -> float:
        """Return the time of the sample nearest to column `x` from the left edge, s."""
        return round(self.time(x) * self._rate) / self._rate

    # What changes it

    def resize(self, width: int) -> None:
        self._width = max(width, 1)
        self._rescale()

    def set_window(self, seconds: float, anchor: float | None = None) -> None:
        """Show another stretch of time.

        `anchor`: time (s) that stays where it is while paused; None keeps the right edge.
        """
        place = None if anchor is None else self.x(anchor) / self._width
        self._window = min(max(seconds, WINDOWS[0]), WINDOWS[-1])
        self._rescale()
        if place is not None and anchor is not None and self._held is not None:
            self._hold(anchor + self._scale.time((1.0 - place) * self._width - 1.0))

    def zoom(self, steps: int, anchor: float | None = None) -> None:
        """Go up (in) or down (out) the list of windows."""
        smaller = [window for window in reversed(WINDOWS) if window < self._window - 1e-9]
        larger = [window for window in WINDOWS if window > self._window + 1e-9]
        choice = smaller if steps > 0 else larger
        if steps and choice:
            self.set_window(choice[min(abs(steps), len(choice)) - 1], anchor)

    def set_now(self, now: float) -> None:
        """Take a new newest time, s; one before the paused picture, as in a replay, goes on."""
        self.now = now
        if self._held is not None and self._held > now:
            self._held = None

    def pause(self) -> None:
        if self._held is None and self.now is not None:
            self._held = self.now

    def go_live(self) -> None:
        self._held = None

    def toggle_pause(self) -> None:
        if self.paused:
            self.go_live()
        else:
            self.pause()

    def scroll(self, seconds: float) -> None:
        """Move by some seconds, back if negative. Reaching the newest sample follows it again."""
        if self.now is None:
            return
        self._hold((self._held if self._held is not None else self.now) + seconds)

    def go_to(self, time: float) -> None:
        """Bring a time (s) to the middle of the display."""
        if self.now is not None:
            self._hold(time + self.seconds / 2.0)

    def go_to_start(self) -> None:
        if self.start is not None:
            self._hold(self._earliest(self.start))

    def set_cursor(self, name: str, time: float | None) -> None:
        """Set one of `CURSORS` to a time (s), or take it away with None."""
        if name not in CURSORS:
            raise ValueError(f"there is no cursor '{name}'; there are {', '.join(CURSORS)}")
        if time is None:
            self.cursors.pop(name, None)
        else:
            self.cursors[name] = round(time * self._rate) / self._rate

    def _hold(self, latest: float) -> None:
        now = self.now if self.now is not None else latest
        if latest >= now:
            self._held = None
            return
        if self.start is not None:
            # The beginning may be drawn into sight, not out of it.
            latest = max(latest, min(self._earliest(self.start), now))
        if latest >= now:
            self._held = now
            return
        self._held = latest

    def _earliest(self, start: float) -> float:
        return self._scale.time(self._scale.column(start) + self._width - 1)

    def _rescale(self) -> None:
        self._scale = select_column_scale(self._window, self._width, self._rate)

"""Pausing, scrolling and zooming strip charts, and their cursors."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from PySide6.QtCore import QObject, Signal

from ui.strips.chart_model import ChartModel


class ViewNavigator(QObject):
    """Changes which part of the flight is in sight, and the cursors."""

    rebuild_requested = Signal()  # Columns mean other times, or need other room.
    view_changed = Signal()  # Pause, time or window changed.
    cursor_moved = Signal(str, object)  # ``cursor``, ``a`` or ``b``, and its time in s or None.
    mark_requested = Signal(float)  # The user wants a mark at this flight time, s.

    def __init__(self, model: ChartModel, parent: QObject) -> None:
        super().__init__(parent)
        self._model = model

    @property
    def actions(self) -> Mapping[str, Callable[[], object]]:
        return {
            "pause": self.toggle_pause,
            "live": self.go_live,
            "earlier": partial(self._scroll_windows, -0.1),
            "later": partial(self._scroll_windows, 0.1),
            "window_earlier": partial(self._scroll_windows, -1.0),
            "window_later": partial(self._scroll_windows, 1.0),
            "start": self.go_to_start,
            "zoom_in": partial(self.zoom, 1),
            "zoom_out": partial(self.zoom, -1),
            "cursor": self.toggle_cursor,
            "cursor_earlier": partial(self.step_cursor, -1),
            "cursor_later": partial(self.step_cursor, 1),
            "cursor_far_earlier": partial(self.step_cursor, -20),
            "cursor_far_later": partial(self.step_cursor, 20),
            "set_a": partial(self._set_at_cursor, "a"),
            "set_b": partial(self._set_at_cursor, "b"),
            "mark": self.request_mark,
        }

    # View

    def toggle_pause(self) -> None:
        self._model.view.toggle_pause()
        self.view_changed.emit()

    def go_live(self) -> None:
        self._model.view.go_live()
        self.view_changed.emit()

    def go_to_start(self) -> None:
        self._model.view.go_to_start()
        self.view_changed.emit()

    def go_to(self, time: float) -> None:
        """Bring a flight time (s) to the middle."""
        self._model.view.go_to(time)
        self.view_changed.emit()

    def scroll(self, seconds: float) -> None:
        """Move by some seconds, back if negative."""
        self._model.view.scroll(seconds)
        self.view_changed.emit()

    def _scroll_windows(self, windows: float) -> None:
        self.scroll(windows * self._model.view.seconds)

    def zoom(self, steps: int, anchor: float | None = None) -> None:
        """Show less (positive) or more time, about the cursor or another time (s)."""
        view = self._model.view
        if anchor is None:
            anchor = view.cursors.get("cursor")
            if anchor is not None and not 0 <= view.x(anchor) < view.width:
                anchor = None
        view.zoom(steps, anchor)
        self.rebuild_requested.emit()
        self.view_changed.emit()

    def set_window(self, seconds: float) -> None:
        """Show at least so many seconds."""
        self._model.view.set_window(seconds)
        self.rebuild_requested.emit()
        self.view_changed.emit()

    # Cursors

    def set_cursor(self, name: str, time: float | None) -> None:
        """Set ``cursor``, ``a`` or ``b`` to a flight time (s), or remove it with None."""
        view = self._model.view
        if view.cursors.get(name) == time:
            return
        before = self._model.cursor_value_count
        view.set_cursor(name, time)
        if self._model.cursor_value_count != before:
            self.rebuild_requested.emit()
        self.cursor_moved.emit(name, view.cursors.get(name))

    def toggle_cursor(self) -> None:
        """Set the cursor to the middle of the samples in sight, or remove it."""
        if "cursor" in self._model.view.cursors:
            self.set_cursor("cursor", None)
        elif self._model.view.now is not None:
            self.set_cursor("cursor", self._model.sampled_time(0.5))

    def step_cursor(self, columns: int) -> None:
        """Move the cursor by columns, at least by one sample; it comes into sight if need be."""
        view = self._model.view
        if view.now is None:
            return
        at = view.cursors.get("cursor")
        if at is None or not 0 <= view.x(at) < view.width:
            self.set_cursor("cursor", self._model.sampled_time(0.5))
            return
        self.set_cursor("cursor", at + columns * max(view.scale.seconds, 1.0 / view.scale.rate))

    def _set_at_cursor(self, name: str) -> None:
        view = self._model.view
        if view.now is not None:
            at = view.cursors.get("cursor")
            at = min(self._model.sampled_time(1.0), view.now) if at is None else at
            self.set_cursor(name, at)

    def clear_cursors(self) -> None:
        for name in tuple(self._model.view.cursors):
            self.set_cursor(name, None)

    def request_mark(self) -> None:
        """Ask for a mark at the cursor while paused, else at the newest sample."""
        view = self._model.view
        at = view.cursors.get("cursor") if view.paused else None
        at = view.now if at is None else at
        if at is not None:
            self.mark_requested.emit(at)

"""The time line of a flight: all of it above, a part with its channels below, maneuvers on both.

Edges of maneuvers are dragged, a stretch beside them is marked to become one, and the wheel or
the keys move and zoom.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from PySide6.QtCore import QEvent, QPointF, Qt, Signal
from PySide6.QtGui import QKeyEvent, QMouseEvent, QWheelEvent

from gsapp.session.review.traces import Traces
from ui.display_style import DisplayStyle
from ui.review.timeline_painter import TimelineSpan
from ui.review.timeline_widget import TimelineWidget
from ui.shortcut_filter import ArrowKeyNavigation
from ui.widgets.wheel_scrolling import scroll_steps

_EDGE_HIT_DISTANCE = 6
"""Points beside an edge in which it is taken hold of."""
_POINTER_KEYS = {Qt.Key.Key_Left: -0.005, Qt.Key.Key_Right: 0.005}
_STEP, _ZOOM = 0.1, 0.7
"""Shares of what is in sight: moved by a key, and left by a step of the zoom."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Drag:
    """What the mouse holds: an edge (``start``, ``stop``), a ``stretch``, or the ``overview``."""

    what: str
    name: str = ""
    anchor: float = 0.0


class Timeline(TimelineWidget, ArrowKeyNavigation):
    """One flight with its maneuvers, to be worked on.

    Left and Right move, PgUp and PgDown by a whole view, Up and Down zoom, Home shows the whole
    flight; Return zooms to the chosen maneuver, Esc drops what is being dragged or marked. All
    values are read where the mouse is, or with C at a line that Left and Right move then; A begins
    a selection at that line, which grows as the line moves.
    """

    maneuver_selected = Signal(str)
    edge_dragged = Signal(str, float, float)
    edge_moved = Signal(str, float, float)
    """The edges of a maneuver (s) while one is dragged, and where it was let go."""
    drag_cancelled = Signal()
    deleted = Signal()

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__(style)
        self._drag: _Drag | None = None
        self._reads = False
        self._selection_start: float | None = None
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMouseTracking(True)

    def show_flight(self, traces: Traces | None) -> None:
        self._drag, self._reads, self._selection_start = None, False, None
        super().show_flight(traces)

    # Mouse

    def _edge_at(self, x: float) -> _Drag | None:
        scale, reach = self.scale, self._style.px(_EDGE_HIT_DISTANCE)
        ordered = sorted(self._spans, key=lambda span: span.id != self._name)
        for span in ordered:
            near = [
                (abs(scale.x(time) - x), what)
                for time, what in ((span.start, "start"), (span.stop, "stop"))
            ]
            distance, what = min(near)
            if distance <= reach:
                return _Drag(what=what, name=span.id)
        return None

    def _span_at(self, time: float) -> TimelineSpan | None:
        """Return the maneuver at a time, the shortest where several share it."""
        found = [span for span in self._spans if span.start <= time <= span.stop]
        return min(found, key=lambda span: span.stop - span.start, default=None)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        if event.button() != Qt.MouseButton.LeftButton or self._traces is None:
            super().mousePressEvent(event)
            return
        at, places = event.position(), self.regions
        if places.overview.contains(at):
            self._drag = _Drag(what="overview")
            self._choose_at(self.overview_scale.time(at.x()))
            self._center(at)
        elif places.plot.contains(at) or places.lane.contains(at):
            edge = self._edge_at(at.x())
            if edge is not None:
                self._drag = edge
                self._choose(edge.name)
            else:
                time = self.scale.time(at.x())
                self._drag = _Drag(what="stretch", anchor=time)
                self._choose_at(time)

    def _choose_at(self, time: float) -> None:
        span = self._span_at(time)
        if span is not None:
            self._choose(span.id)

    def _choose(self, name: str) -> None:
        if name != self._name:
            self._name = name
            self.update()
            self.maneuver_selected.emit(name)

    def _center(self, at: QPointF) -> None:
        if not self.view.shows_all:
            time = self.overview_scale.time(at.x())
            self.view.pan(time - (self.view.start + self.view.stop) / 2.0)
            self._redraw()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        at, drag = event.position(), self._drag
        known = self._traces is not None and self.regions.plot.contains(at)
        self._reads = False
        self.set_pointer(self.scale.time(at.x()) if known else None)
        if drag is None or not event.buttons() & Qt.MouseButton.LeftButton:
            plot = self.regions.plot
            over = plot.top() - self._style.px(20) <= at.y() <= plot.bottom()
            edge = over and self._traces is not None and self._edge_at(at.x()) is not None
            shape = Qt.CursorShape.SizeHorCursor if edge else Qt.CursorShape.ArrowCursor
            self.setCursor(shape)
            return
        if drag.what == "overview":
            self._center(at)
            return
        time = min(max(self.scale.time(at.x()), self.view.first), self.view.last)
        if drag.what == "stretch":
            if abs(self.scale.x(drag.anchor) - at.x()) > self._style.px(_EDGE_HIT_DISTANCE):
                self.mark_segment((min(drag.anchor, time), max(drag.anchor, time)))
            return
        self._drag_edge(drag, time)

    def leaveEvent(self, event: QEvent) -> None:
        super().leaveEvent(event)
        if not self._reads:
            self.set_pointer(None)

    def _drag_edge(self, drag: _Drag, time: float) -> None:
        span = next((one for one in self._spans if one.id == drag.name), None)
        if span is None:
            return
        start, stop = (time, span.stop) if drag.what == "start" else (span.start, time)
        if start < stop:
            self._held = replace(span, start=start, stop=stop)
            self.update()
            self.edge_dragged.emit(drag.name, start, stop)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        if event.button() != Qt.MouseButton.LeftButton:
            return
        drag, held = self._drag, self._held
        self._drag = self._held = None
        if drag is not None and held is not None:
            self.edge_moved.emit(held.id, held.start, held.stop)
        elif drag is not None and drag.what == "stretch":
            place = self.scale.x(drag.anchor)
            if abs(place - event.position().x()) <= self._style.px(_EDGE_HIT_DISTANCE):
                self.mark_segment(None)
        self.update()

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        if event.button() != Qt.MouseButton.LeftButton or self._traces is None:
            return
        self._drag = self._held = None
        inside = self.regions.overview.contains(event.position())
        scale = self.overview_scale if inside else self.scale
        span = self._span_at(scale.time(event.position().x()))
        if span is None:
            self.show_all()
        else:
            self._choose(span.id)
            self.zoom_to(span.start, span.stop)

    def wheelEvent(self, event: QWheelEvent) -> None:
        along, up = scroll_steps(event)
        if along:
            self.view.pan(-along * _STEP * self.view.seconds)
        elif up:
            self.view.zoom(_ZOOM**up, self.scale.time(event.position().x()))
        self._redraw()
        event.accept()

    # Keys

    def keyPressEvent(self, event: QKeyEvent) -> None:
        key, view = Qt.Key(event.key()), self.view
        moves = {
            Qt.Key.Key_Left: -_STEP, Qt.Key.Key_Right: _STEP,
            Qt.Key.Key_PageUp: -1.0, Qt.Key.Key_PageDown: 1.0,
        }  # fmt: skip
        zooms = {Qt.Key.Key_Up: _ZOOM, Qt.Key.Key_Down: 1.0 / _ZOOM}
        if key == Qt.Key.Key_C and not event.modifiers():
            self._reads, self._selection_start = not self._reads, None
            self.set_pointer((view.start + view.stop) / 2.0 if self._reads else None)
        elif self._reads and self.pointer is not None and key in _POINTER_KEYS:
            time = self.pointer + _POINTER_KEYS[key] * view.seconds
            self.set_pointer(min(max(time, view.start), view.stop))
            self._extend_selection()
        elif self._reads and key == Qt.Key.Key_A and not event.modifiers():
            self._selection_start = self.pointer
        elif key in moves:
            view.pan(moves[key] * view.seconds)
        elif key in zooms:
            view.zoom(zooms[key], self._anchor())
        elif key == Qt.Key.Key_Home:
            view.show_all()
        elif key in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            if self.chosen_span is not None:
                view.zoom_to(self.chosen_span.start, self.chosen_span.stop)
        elif key == Qt.Key.Key_Escape:
            self._cancel_drag()
        elif key in (Qt.Key.Key_Delete, Qt.Key.Key_Backspace):
            self.deleted.emit()
            return
        else:
            event.ignore()
            return
        self._redraw()

    def _extend_selection(self) -> None:
        start, stop = self._selection_start, self.pointer
        if start is not None and stop is not None:
            self.mark_segment((min(start, stop), max(start, stop)))

    def _cancel_drag(self) -> None:
        held, self._drag, self._held = self._held, None, None
        self._reads, self._selection_start = False, None
        self.set_pointer(None)
        self.mark_segment(None)
        if held is not None:
            self.drag_cancelled.emit()

    def _anchor(self) -> float | None:
        """Return the middle of the chosen maneuver if it is in sight, so that it stays there."""
        span = self.chosen_span
        if span is None:
            return None
        middle = (span.start + span.stop) / 2.0
        return middle if self.view.start <= middle <= self.view.stop else None

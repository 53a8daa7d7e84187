"""A figure on screen under mouse and keys: points are chosen, charts moved and zoomed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from PySide6.QtCore import QEvent, QPointF, QRectF, Qt, Signal
from PySide6.QtGui import QKeyEvent, QMouseEvent, QPainter, QPaintEvent, QPen, QWheelEvent

from ui.display_style import DisplayStyle
from ui.review.figure_geometry import (
    ManeuverPoint,
    Subplot,
    ViewRange,
    find_nearest_point,
    is_usable_view,
    next_point,
    pan_view,
    zoom_view,
)
from ui.review.figure_widget import FigureWidget, find_same_point
from ui.shortcut_filter import ArrowKeyNavigation
from ui.widgets.crosshair_keys import CrosshairKeys
from ui.widgets.paint_primitives import paint_readout

_HIT_RADIUS = 14
"""Points around the mouse in which a point of the figure is meant."""
_DRAG = 4
"""Points that the mouse moves before a press becomes a drag."""
_STEP, _ZOOM = 0.15, 0.8
"""Share of a chart that a key moves it by; factor of its range that a key or a notch zooms by."""
_WHEEL_STEP = 120
_TIME_ONLY_HEIGHT = 12
"""Points of height up to which a rectangle in a history means a stretch of time."""
_SHADE = 0.12
_POINT_STEP_KEYS = {
    Qt.Key.Key_Left: "left",
    Qt.Key.Key_Right: "right",
    Qt.Key.Key_Up: "up",
    Qt.Key.Key_Down: "down",
}
_PAN_KEYS = {
    Qt.Key.Key_Left: (-_STEP, 0.0),
    Qt.Key.Key_Right: (_STEP, 0.0),
    Qt.Key.Key_Up: (0.0, _STEP),
    Qt.Key.Key_Down: (0.0, -_STEP),
}
_ZOOM_KEYS = {
    Qt.Key.Key_Plus: _ZOOM,
    Qt.Key.Key_Equal: _ZOOM,
    Qt.Key.Key_Minus: 1.0 / _ZOOM,
}
_ENTER = (Qt.Key.Key_Return, Qt.Key.Key_Enter)
_SHIFT = Qt.KeyboardModifier.ShiftModifier
_CONTROL = Qt.KeyboardModifier.ControlModifier


@dataclass(slots=True, kw_only=True)
class _Press:
    """A button of the mouse that is held."""

    at: QPointF
    pane: Subplot | None
    view: ViewRange | None
    moves: bool
    dragged: bool = False


class FigureCanvas(ArrowKeyNavigation, FigureWidget):
    """A figure that answers to mouse and keys.

    The wheel zooms at the pointer (with Shift the page scrolls), a drag zooms to a rectangle, with
    Shift or the middle button it moves the chart; a double click shows everything again, or opens
    what it is on. Values stand beside the pointer.

    Arrows walk from point to point (in figures without points they move and zoom), Shift and
    arrows move the chart, plus and minus zoom, Home shows everything, Enter opens the fit,
    Space shows its chart large. C shows the values at a crosshair that arrows move then.
    """

    point_selected = Signal(str, str)
    """Name of the chart and maneuver of the point that was chosen."""
    fit_requested = Signal(str)
    subplot_opened = Signal(str)
    views_changed = Signal()

    def __init__(self, style: DisplayStyle, describe: Callable[[str, str], str]) -> None:
        super().__init__(style)
        self._describe = describe
        self.pointer: QPointF | None = None
        self._crosshair = CrosshairKeys(self)
        self._pressed: _Press | None = None
        self.setMouseTracking(True)

    # Choosing

    def _point_at(self, point: QPointF) -> ManeuverPoint | None:
        return find_nearest_point(
            self.visible_points(), point.x(), point.y(), self._style.px(_HIT_RADIUS)
        )

    def _subplot_under(self, point: QPointF) -> Subplot | None:
        return next((one for one in self.subplots if one.contains(point.x(), point.y())), None)

    def _choose_spot(self, spot: ManeuverPoint) -> None:
        pane = self.subplot_at(spot.subplot_index)
        self.current = next(
            one
            for one in self.points
            if (one.subplot_index, one.maneuver) == (spot.subplot_index, spot.maneuver)
        )
        self.subplot_index = spot.subplot_index
        self.maneuver = spot.maneuver
        name = pane.name if pane is not None else ""
        self.setAccessibleDescription(self._describe(name, spot.maneuver))
        self.point_selected.emit(name, spot.maneuver)
        self.update()

    def event(self, event: QEvent) -> bool:
        if event.type() == QEvent.Type.ShortcutOverride and isinstance(event, QKeyEvent):
            shifted = bool(event.modifiers() & _SHIFT) and Qt.Key(event.key()) in _PAN_KEYS
            plain = not event.modifiers() & _CONTROL and Qt.Key(event.key()) in _ZOOM_KEYS
            if shifted or plain:
                event.accept()
                return True
        return super().event(event)

    def text_at(self, point: QPointF) -> str:
        """Return what lies under the mouse: a point, or the values of the axes there."""
        spot, pane = self._point_at(point), self._subplot_under(point)
        if spot is not None:
            of = self.subplot_at(spot.subplot_index)
            return self._describe(of.name if of is not None else "", spot.maneuver)
        if pane is None:
            return ""
        return pane.value_text(self.view_of(pane), point.x(), point.y())

    def mousePressEvent(self, event: QMouseEvent) -> None:
        pane, spot = self._subplot_under(event.position()), self._point_at(event.position())
        if event.button() == Qt.MouseButton.RightButton and spot is not None:
            self._choose_spot(spot)
        middle = event.button() == Qt.MouseButton.MiddleButton
        if middle or event.button() == Qt.MouseButton.LeftButton:
            moves = middle or bool(event.modifiers() & _SHIFT)
            view = None if pane is None else self.view_of(pane)
            self._pressed = _Press(at=event.position(), pane=pane, view=view, moves=moves)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        self._crosshair.is_on = False
        self.pointer = event.position()
        self.update()
        press = self._pressed
        if press is None:
            at_spot = self._point_at(self.pointer) is not None
            inside = self._subplot_under(self.pointer) is not None
            shapes = Qt.CursorShape
            shape = shapes.CrossCursor if inside else shapes.ArrowCursor
            self.setCursor(shapes.PointingHandCursor if at_spot else shape)
            return
        way = self.pointer - press.at
        if press.pane is None or press.view is None:
            return
        press.dragged = press.dragged or way.manhattanLength() >= self._style.px(_DRAG)
        if press.dragged and press.moves:
            pane = press.pane
            self.setCursor(Qt.CursorShape.ClosedHandCursor)
            across = -way.x() / max(pane.right - pane.left, 1.0)
            up = way.y() / max(pane.bottom - pane.top, 1.0)
            self._show_view(pane, pan_view(press.view, across, up, only_x=pane.shares_x_axis))

    def _rectangle(self) -> QRectF | None:
        """Return the rectangle that is being drawn; of a history its time where it is flat."""
        press, pointer = self._pressed, self.pointer
        if press is None or press.pane is None or press.moves or not press.dragged:
            return None
        if pointer is None:
            return None
        pane = press.pane
        plot = QRectF(QPointF(pane.left, pane.top), QPointF(pane.right, pane.bottom))
        drawn = QRectF(press.at, pointer).normalized()
        if pane.shares_x_axis and drawn.height() < self._style.px(_TIME_ONLY_HEIGHT):
            drawn = QRectF(drawn.left(), plot.top(), drawn.width(), plot.height())
        return drawn.intersected(plot)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        self.pointer = event.position()
        box, press = self._rectangle(), self._pressed
        self._pressed = None
        self.update()
        if press is None:
            return
        pane, view = press.pane, press.view
        if pane is not None:
            self.subplot_index = pane.index
        if box is not None and pane is not None and view is not None:
            if min(box.width(), box.height()) >= self._style.px(_DRAG):
                corners = (box.left(), box.top()), (box.right(), box.bottom())
                self._show_view(pane, pane.view_in_rectangle(view, *corners))
            return
        spot = self._point_at(event.position())
        if spot is not None and not press.dragged:
            self._choose_spot(spot)

    def leaveEvent(self, event: QEvent) -> None:
        super().leaveEvent(event)
        self.pointer = self.pointer if self._crosshair.is_on else None
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        super().paintEvent(event)
        pane = None if self.pointer is None else self._subplot_under(self.pointer)
        box = self._rectangle()
        painter = QPainter(self)
        if box is not None:
            color = self._style.color("accent")
            painter.setPen(QPen(color, 1, Qt.PenStyle.DashLine))
            color.setAlphaF(_SHADE)
            painter.setBrush(color)
            painter.drawRect(box)
        elif pane is not None and self.pointer is not None and self._pressed is None:
            plot = QRectF(QPointF(pane.left, pane.top), QPointF(pane.right, pane.bottom))
            text = self.text_at(self.pointer)
            paint_readout(painter, plot, self.pointer, text, self._style)
        painter.end()

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        spot, pane = self._point_at(event.position()), self._subplot_under(event.position())
        if spot is not None:
            self.fit_requested.emit(spot.maneuver)
        elif self.views:
            self.reset_views()
        elif pane is not None and pane.name:
            self.subplot_opened.emit(pane.name)

    def wheelEvent(self, event: QWheelEvent) -> None:
        pane = self._subplot_under(event.position())
        if pane is None or event.modifiers() & _SHIFT or not event.angleDelta().y():
            event.ignore()
            return
        across, up = pane.to_fractions(event.position().x(), event.position().y())
        factor = _ZOOM ** (event.angleDelta().y() / _WHEEL_STEP)
        view = zoom_view(self.view_of(pane), across, up, factor, only_x=pane.shares_x_axis)
        self._show_view(pane, view)

    # Keys

    def keyPressEvent(self, event: QKeyEvent) -> None:
        key = Qt.Key(event.key())
        pane = self.subplot_at(self.subplot_index)
        if pane is not None and self._move_crosshair(event, pane):
            return
        if key in _POINT_STEP_KEYS and self.points and not event.modifiers() & _SHIFT:
            self._go_to_next_point(_POINT_STEP_KEYS[key])
        elif key in _PAN_KEYS and pane is not None:
            self._move(pane, *_PAN_KEYS[key])
        elif key in _ZOOM_KEYS and pane is not None:
            self._zoom(pane, _ZOOM_KEYS[key])
        elif key == Qt.Key.Key_Home:
            self.reset_views()
        elif key in _ENTER and self.maneuver:
            self.fit_requested.emit(self.maneuver)
        elif key == Qt.Key.Key_Space and pane is not None and pane.name:
            self.subplot_opened.emit(pane.name)
        else:
            event.ignore()

    def _move_crosshair(self, event: QKeyEvent, pane: Subplot) -> bool:
        plot = QRectF(QPointF(pane.left, pane.top), QPointF(pane.right, pane.bottom))
        is_crosshair, pointer = self._crosshair.move(event, plot, self.pointer)
        if is_crosshair:
            self.pointer = pointer
            self._crosshair.describe("" if pointer is None else self.text_at(pointer))
            self.update()
        return is_crosshair

    def _go_to_next_point(self, way: str) -> None:
        """Go to the next point; the first step goes to the chosen maneuver, or the first point."""
        spots = self.visible_points()
        here = None if self.current is None else find_same_point(spots, self.current)
        if here is not None:
            spot = next_point(spots, here, way)
        else:
            chosen = (one for one in spots if one.maneuver == self.maneuver)
            spot = next(chosen, None) or next_point(spots, None, way)
        if spot is not None:
            self._choose_spot(spot)

    def _move(self, pane: Subplot, across: float, up: float) -> None:
        if pane.shares_x_axis and up:
            # Of a history only the time is moved; up and down zoom it, as in all charts.
            self._zoom(pane, _ZOOM if up > 0 else 1.0 / _ZOOM)
            return
        view = pan_view(self.view_of(pane), across, up, only_x=pane.shares_x_axis)
        self._show_view(pane, view)

    def _zoom(self, pane: Subplot, factor: float) -> None:
        across = up = 0.5
        if self.current is not None and self.current.subplot_index == pane.index:
            x, y = pane.map_to_view(self.view_of(pane), self.current.x, self.current.y)
            across, up = pane.to_fractions(x, y)
        view = zoom_view(self.view_of(pane), across, up, factor, only_x=pane.shares_x_axis)
        self._show_view(pane, view)

    def _show_view(self, pane: Subplot, view: ViewRange) -> None:
        """Want another part of a chart, and the same stretch of what shares its axis."""
        if not is_usable_view(view, self.full_views.get(pane.index, view)):
            return
        for one in self.subplots:
            if one.group == pane.group:
                former = self.view_of(one)
                self.views[one.index] = view if one is pane else replace(former, x=view.x)
        self.views_changed.emit()
        self.update()

    def reset_views(self) -> None:
        if self.views:
            self.views = {}
            self.views_changed.emit()

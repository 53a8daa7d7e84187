"""A figure on screen under mouse and keys: points are chosen, charts moved and zoomed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from PySide6.QtCore import QEvent, QPointF, Qt, Signal
from PySide6.QtGui import QHelpEvent, QKeyEvent, QMouseEvent, QWheelEvent
from PySide6.QtWidgets import QToolTip

from ui.keyboard import ArrowKeys
from ui.look import Look
from ui.review.figure_geometry import Pane, Spot, View, moved, nearest, sensible, stepped, zoomed
from ui.review.figure_paper import FigurePaper, same_spot

_REACH = 14
"""Points around the mouse in which a point of the figure is meant."""
_DRAG = 4
"""Points that the mouse moves before a press becomes a drag."""
_STEP, _ZOOM = 0.15, 0.8
"""Share of a chart that a key moves it by; factor of its range that a key or a notch zooms by."""
_NOTCH = 120
_WALKS = {
    Qt.Key.Key_Left: "left",
    Qt.Key.Key_Right: "right",
    Qt.Key.Key_Up: "up",
    Qt.Key.Key_Down: "down",
}
_MOVES = {
    Qt.Key.Key_Left: (-_STEP, 0.0),
    Qt.Key.Key_Right: (_STEP, 0.0),
    Qt.Key.Key_Up: (0.0, _STEP),
    Qt.Key.Key_Down: (0.0, -_STEP),
}
_ZOOMS = {
    Qt.Key.Key_Plus: _ZOOM,
    Qt.Key.Key_Equal: _ZOOM,
    Qt.Key.Key_Minus: 1.0 / _ZOOM,
}
_ENTER = (Qt.Key.Key_Return, Qt.Key.Key_Enter)
_SHIFT = Qt.KeyboardModifier.ShiftModifier
_CONTROL = Qt.KeyboardModifier.ControlModifier


class FigureCanvas(ArrowKeys, FigurePaper):
    """A figure that answers to mouse and keys.

    Arrows walk from point to point (in figures without points they move and zoom), Shift and
    arrows move the chart, plus and minus zoom, Home shows everything, Enter opens the fit,
    Space shows its chart large.

    Parameters
    ----------
    look : Look
        Colors and sizes.
    describe : callable
        Returns what is known of a point, from the chart's name and the maneuver.

    Attributes
    ----------
    spot_chosen : Signal(str, str)
        Name of the chart and maneuver of the point that was chosen.
    opened : Signal(str)
        Maneuver whose fit is wanted.
    pane_opened : Signal(str)
        Name of a chart that is wanted large.
    views_changed : Signal
        Another part is wanted: `views`.
    wheel_free : bool
        Whether the wheel zooms by itself, since nothing is to be scrolled.
    """

    spot_chosen = Signal(str, str)
    opened = Signal(str)
    pane_opened = Signal(str)
    views_changed = Signal()

    def __init__(self, look: Look, describe: Callable[[str, str], str]) -> None:
        super().__init__(look)
        self._describe = describe
        self.wheel_free = False
        self._pressed: tuple[QPointF, Pane | None] | None = None
        self._dragged: View | None = None
        self.setMouseTracking(True)

    # Choosing

    def _at(self, point: QPointF) -> Spot | None:
        return nearest(self.shown_spots(), point.x(), point.y(), self._look.px(_REACH))

    def _pane_at(self, point: QPointF) -> Pane | None:
        return next((one for one in self.panes if one.holds(point.x(), point.y())), None)

    def _choose_spot(self, spot: Spot) -> None:
        pane = self.pane(spot.pane)
        self.current = next(
            one for one in self.spots if (one.pane, one.maneuver) == (spot.pane, spot.maneuver)
        )
        self.place = spot.pane
        self.maneuver = spot.maneuver
        name = pane.name if pane is not None else ""
        self.setAccessibleDescription(self._describe(name, spot.maneuver))
        self.spot_chosen.emit(name, spot.maneuver)
        self.update()

    def event(self, event: QEvent) -> bool:
        """Tell what a point is; keep the keys that move and zoom."""
        if isinstance(event, QHelpEvent) and event.type() == QEvent.Type.ToolTip:
            QToolTip.showText(event.globalPos(), self.words_at(QPointF(event.pos())), self)
            return True
        if event.type() == QEvent.Type.ShortcutOverride and isinstance(event, QKeyEvent):
            shifted = bool(event.modifiers() & _SHIFT) and Qt.Key(event.key()) in _MOVES
            plain = not event.modifiers() & _CONTROL and Qt.Key(event.key()) in _ZOOMS
            if shifted or plain:
                event.accept()
                return True
        return super().event(event)

    def words_at(self, point: QPointF) -> str:
        """Return what lies under the mouse: a point, or the values of the axes there."""
        spot, pane = self._at(point), self._pane_at(point)
        if spot is not None:
            of = self.pane(spot.pane)
            return self._describe(of.name if of is not None else "", spot.maneuver)
        if pane is None:
            return ""
        return pane.reading(self.view_of(pane), point.x(), point.y())

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Begin a click or a drag."""
        if event.button() == Qt.MouseButton.LeftButton:
            pane = self._pane_at(event.position())
            self._pressed = (event.position(), pane)
            self._dragged = None

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Move the chart with the mouse, or show that a point can be pressed."""
        point = event.position()
        if self._pressed is None:
            shape = Qt.CursorShape.PointingHandCursor
            self.setCursor(shape if self._at(point) is not None else Qt.CursorShape.ArrowCursor)
            return
        start, pane = self._pressed
        way = point - start
        if pane is None or (self._dragged is None and way.manhattanLength() < self._look.px(_DRAG)):
            return
        if self._dragged is None:
            self._dragged = self.view_of(pane)
            self.setCursor(Qt.CursorShape.ClosedHandCursor)
        across = -way.x() / max(pane.right - pane.left, 1.0)
        up = way.y() / max(pane.bottom - pane.top, 1.0)
        self._show_view(pane, moved(self._dragged, across, up, only_x=pane.over_time))

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """Choose what was clicked."""
        pressed, self._pressed = self._pressed, None
        if pressed is None or self._dragged is not None:
            self._dragged = None
            self.unsetCursor()
            return
        if pressed[1] is not None:
            self.place = pressed[1].place
        spot = self._at(event.position())
        if spot is not None:
            self._choose_spot(spot)

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """Open the fit of a point, or a chart large."""
        spot, pane = self._at(event.position()), self._pane_at(event.position())
        if spot is not None:
            self.opened.emit(spot.maneuver)
        elif pane is not None and pane.name:
            self.pane_opened.emit(pane.name)

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Zoom at the mouse; without Control the page scrolls where it can."""
        pane = self._pane_at(event.position())
        wanted = self.wheel_free or event.modifiers() & _CONTROL
        if pane is None or not wanted or not event.angleDelta().y():
            event.ignore()
            return
        across, up = pane.shares(event.position().x(), event.position().y())
        factor = _ZOOM ** (event.angleDelta().y() / _NOTCH)
        view = zoomed(self.view_of(pane), across, up, factor, only_x=pane.over_time)
        self._show_view(pane, view)

    # Keys

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Walk, move, zoom, open."""
        key = Qt.Key(event.key())
        pane = self.pane(self.place)
        if key in _WALKS and self.spots and not event.modifiers() & _SHIFT:
            self._walk(_WALKS[key])
        elif key in _MOVES and pane is not None:
            self._move(pane, *_MOVES[key])
        elif key in _ZOOMS and pane is not None:
            self._zoom(pane, _ZOOMS[key])
        elif key == Qt.Key.Key_Home:
            self._show_all()
        elif key in _ENTER and self.maneuver:
            self.opened.emit(self.maneuver)
        elif key == Qt.Key.Key_Space and pane is not None and pane.name:
            self.pane_opened.emit(pane.name)
        else:
            event.ignore()

    def _walk(self, way: str) -> None:
        """Go to the next point; the first step goes to the chosen maneuver, or the first point."""
        spots = self.shown_spots()
        here = None if self.current is None else same_spot(spots, self.current)
        if here is not None:
            spot = stepped(spots, here, way)
        else:
            chosen = (one for one in spots if one.maneuver == self.maneuver)
            spot = next(chosen, None) or stepped(spots, None, way)
        if spot is not None:
            self._choose_spot(spot)

    def _move(self, pane: Pane, across: float, up: float) -> None:
        if pane.over_time and up:
            # Of a history only the time is moved; up and down zoom it, as in all charts.
            self._zoom(pane, _ZOOM if up > 0 else 1.0 / _ZOOM)
            return
        view = moved(self.view_of(pane), across, up, only_x=pane.over_time)
        self._show_view(pane, view)

    def _zoom(self, pane: Pane, factor: float) -> None:
        across = up = 0.5
        if self.current is not None and self.current.pane == pane.place:
            x, y = pane.seen_as(self.view_of(pane), self.current.x, self.current.y)
            across, up = pane.shares(x, y)
        view = zoomed(self.view_of(pane), across, up, factor, only_x=pane.over_time)
        self._show_view(pane, view)

    def _show_view(self, pane: Pane, view: View) -> None:
        """Want another part of a chart, and the same stretch of what shares its axis."""
        if not sensible(view, self.whole.get(pane.place, view)):
            return
        for one in self.panes:
            if one.group == pane.group:
                former = self.view_of(one)
                self.views[one.place] = view if one is pane else replace(former, x=view.x)
        self.views_changed.emit()
        self.update()

    def _show_all(self) -> None:
        if self.views:
            self.views = {}
            self.views_changed.emit()

"""A finished figure as it stands on screen, with what is chosen in it.

What is chosen is painted over the picture, so that choosing never draws it anew. While another
view is being drawn, the old picture stands in, moved and stretched.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from PySide6.QtCore import QRectF, QSize, Qt
from PySide6.QtGui import QFocusEvent, QPainter, QPaintEvent
from PySide6.QtWidgets import QWidget

from ui.display_style import DisplayStyle
from ui.review.figure_geometry import ManeuverPoint, Subplot, ViewRange, views_match
from ui.review.figure_overlay import paint_busy, paint_message, paint_selection, paint_transformed
from ui.review.figure_renderer import RenderedFigure
from ui.widgets.paint_primitives import paint_focus_frame


class FigureWidget(QWidget):
    """Shows a `RenderedFigure`."""

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__()
        self._look = look
        self.rendered_figure: RenderedFigure | None = None
        self.views: dict[int, ViewRange] = {}
        """What charts are to show other than everything, by their place."""
        self.full_views: dict[int, ViewRange] = {}
        """What charts show when they show everything."""
        self.maneuver = ""
        self.current: ManeuverPoint | None = None
        self.subplot_index = 0
        self._waiting = ""
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)

    def show_rendered_figure(self, drawing: RenderedFigure) -> None:
        """Show a finished figure; the point that the keyboard stands on stays where it is there."""
        former = self.current
        self.rendered_figure = drawing
        if not drawing.request.views:
            self.full_views = {pane.index: pane.view for pane in drawing.subplots}
        self.current = None
        if former is not None:
            self.current = find_same_point(drawing.points, former)
        if self.subplot_index not in {one.index for one in drawing.subplots}:
            self.subplot_index = drawing.subplots[0].index if drawing.subplots else 0
        self._waiting = ""
        self.updateGeometry()
        self.update()

    def show_progress_text(self, words: str) -> None:
        self._waiting = words
        self.update()

    def select_maneuver(self, maneuver: str) -> None:
        self.maneuver = maneuver
        if self.current is not None:
            self.current = find_same_point(self.points, replace(self.current, maneuver=maneuver))
        self.update()

    def discard_views(self) -> None:
        """Show everything with the next drawing."""
        self.views = {}
        self.current = None

    def sizeHint(self) -> QSize:
        drawing = self.rendered_figure
        return QSize(drawing.width, drawing.height) if drawing is not None else QSize(0, 0)

    @property
    def subplots(self) -> tuple[Subplot, ...]:
        return self.rendered_figure.subplots if self.rendered_figure is not None else ()

    @property
    def points(self) -> tuple[ManeuverPoint, ...]:
        return self.rendered_figure.points if self.rendered_figure is not None else ()

    def subplot_at(self, place: int) -> Subplot | None:
        return next((one for one in self.subplots if one.index == place), None)

    def visible_points(self) -> tuple[ManeuverPoint, ...]:
        """Return the points where they lie on screen now, those out of sight left out."""
        if not self.views:
            return self.points
        found = []
        for one in self.points:
            pane = self.subplot_at(one.subplot_index)
            if pane is None:
                continue
            x, y = pane.map_to_view(self.view_of(pane), one.x, one.y)
            if pane.contains(x, y) or views_match(self.view_of(pane), pane.view):
                found.append(replace(one, x=x, y=y))
        return tuple(found)

    def view_of(self, pane: Subplot) -> ViewRange:
        return self.views.get(pane.index, pane.view)

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.fillRect(self.rect(), self._look.color("panel"))
        drawing = self.rendered_figure
        if drawing is not None and drawing.image is not None:
            painter.drawImage(0, 0, drawing.image)
            for pane in drawing.subplots:
                if not views_match(self.view_of(pane), pane.view):
                    paint_transformed(painter, drawing.image, pane, self.view_of(pane), self._look)
            chosen = [one for one in self.visible_points() if one.maneuver == self.maneuver]
            paint_selection(painter, chosen, self.current, self._look)
        elif drawing is not None:
            paint_message(painter, QRectF(self.rect()), drawing.message, self._look)
        if self._waiting:
            paint_busy(painter, QRectF(self.rect()), self._waiting, self._look)
        if self.hasFocus():
            paint_focus_frame(painter, self.rect(), self._look)
        painter.end()

    def focusInEvent(self, event: QFocusEvent) -> None:
        super().focusInEvent(event)
        self.update()

    def focusOutEvent(self, event: QFocusEvent) -> None:
        super().focusOutEvent(event)
        self.update()


def find_same_point(spots: Sequence[ManeuverPoint], wanted: ManeuverPoint) -> ManeuverPoint | None:
    """Return the point of the same maneuver in the same chart."""
    pair = (wanted.subplot_index, wanted.maneuver)
    return next((one for one in spots if (one.subplot_index, one.maneuver) == pair), None)

"""A finished figure as it stands on screen, with what is chosen in it.

What is chosen is painted over the picture, so that choosing never draws it anew. While another
view is being drawn, the old picture stands in, moved and stretched.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QFocusEvent, QFontMetricsF, QImage, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QWidget

from ui.display_style import DisplayStyle
from ui.review.figure_geometry import ManeuverPoint, Subplot, ViewRange, views_match
from ui.review.figure_renderer import RenderedFigure
from ui.widgets.paint_primitives import paint_focus_frame

_RING_RADIUS, _FOCUS_RADIUS = 7, 10
"""Points from a chosen point to its ring, and to that where the keyboard stands."""


def paint_selection(
    painter: QPainter,
    chosen: Sequence[ManeuverPoint],
    current: ManeuverPoint | None,
    style: DisplayStyle,
) -> None:
    """Ring the points of the chosen maneuver and write its name beside each."""
    painter.save()
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    for spot in chosen:
        here = current is not None and current.subplot_index == spot.subplot_index
        radius = style.px(_FOCUS_RADIUS if here else _RING_RADIUS)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        # A light ring within a dark one is seen on every color.
        painter.setPen(QPen(style.color("panel"), style.px(4)))
        painter.drawEllipse(QPointF(spot.x, spot.y), radius, radius)
        painter.setPen(QPen(style.color("accent"), style.px(3 if here else 2)))
        painter.drawEllipse(QPointF(spot.x, spot.y), radius, radius)
        _paint_name(painter, spot, radius, style, strong=here)
    painter.restore()


def _paint_name(
    painter: QPainter, spot: ManeuverPoint, radius: float, style: DisplayStyle, *, strong: bool
) -> None:
    font = style.font("label", strong=strong)
    metrics = QFontMetricsF(font)
    room = style.px(3)
    wide = metrics.horizontalAdvance(spot.maneuver) + 2 * room
    high = metrics.height()
    left = spot.x + radius + room
    if left + wide > painter.device().width() / painter.device().devicePixelRatioF():
        left = spot.x - radius - room - wide
    box = QRectF(left, spot.y - high / 2, wide, high)
    painter.fillRect(box, _with_alpha(style.color("panel"), 0.85))
    painter.setFont(font)
    painter.setPen(style.color("text"))
    painter.drawText(box, Qt.AlignmentFlag.AlignCenter, spot.maneuver)


def _with_alpha(color: QColor, share: float) -> QColor:
    color.setAlphaF(share)
    return color


def paint_transformed(
    painter: QPainter, image: QImage, pane: Subplot, view: ViewRange, style: DisplayStyle
) -> None:
    """Let the old picture of a chart stand in for one with another view."""
    box = QRectF(QPointF(pane.left, pane.top), QPointF(pane.right, pane.bottom))
    ratio = image.devicePixelRatio()
    source = QRectF(
        box.left() * ratio, box.top() * ratio, box.width() * ratio, box.height() * ratio
    )
    first = QPointF(*pane.map_to_view(view, pane.left, pane.top))
    last = QPointF(*pane.map_to_view(view, pane.right, pane.bottom))
    painter.save()
    painter.setClipRect(box)
    painter.fillRect(box, style.color("panel"))
    painter.drawImage(QRectF(first, last), image, source)
    painter.restore()


def paint_message(painter: QPainter, box: QRectF, text: str, style: DisplayStyle) -> None:
    """Write why there is no figure."""
    painter.setFont(style.font("body"))
    painter.setPen(style.color("text"))
    margin = style.px(32)
    inner = box.adjusted(margin, margin, -margin, -margin)
    flags = Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap
    painter.drawText(inner, int(flags), text)


def paint_busy(painter: QPainter, box: QRectF, text: str, style: DisplayStyle) -> None:
    """Say in the corner what is being done."""
    font = style.font("label", strong=True)
    metrics = QFontMetricsF(font)
    wide, high = metrics.horizontalAdvance(text) + style.px(16), metrics.height() + style.px(6)
    chip = QRectF(box.right() - wide - style.px(8), box.top() + style.px(6), wide, high)
    painter.save()
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(style.color("banner"))
    painter.drawRoundedRect(chip, style.px(4), style.px(4))
    painter.setFont(font)
    painter.setPen(style.color("banner_text"))
    painter.drawText(chip, Qt.AlignmentFlag.AlignCenter, text)
    painter.restore()


class FigureWidget(QWidget):
    """Shows a `RenderedFigure`."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        self.rendered_figure: RenderedFigure | None = None
        self.views: dict[int, ViewRange] = {}
        """What charts are to show other than everything, by their place."""
        self.full_views: dict[int, ViewRange] = {}
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

    def show_progress_text(self, text: str) -> None:
        self._waiting = text
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
        painter.fillRect(self.rect(), self._style.color("panel"))
        drawing = self.rendered_figure
        if drawing is not None and drawing.image is not None:
            painter.drawImage(0, 0, drawing.image)
            for pane in drawing.subplots:
                if not views_match(self.view_of(pane), pane.view):
                    paint_transformed(painter, drawing.image, pane, self.view_of(pane), self._style)
            chosen = [one for one in self.visible_points() if one.maneuver == self.maneuver]
            paint_selection(painter, chosen, self.current, self._style)
        elif drawing is not None:
            paint_message(painter, QRectF(self.rect()), drawing.message, self._style)
        if self._waiting:
            paint_busy(painter, QRectF(self.rect()), self._waiting, self._style)
        if self.hasFocus():
            paint_focus_frame(painter, self.rect(), self._style)
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

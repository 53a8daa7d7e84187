"""The aircraft with one surface moving live: the whole of it, and that surface close up."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QFontMetrics, QPainter, QPaintEvent, QPen, QPolygonF, QTransform
from PySide6.QtWidgets import QSizePolicy, QWidget

from ui.display_style import DisplayStyle
from ui.number_format import number_text
from ui.preflight.aircraft_figures import (
    OUTLINES_BY_VIEW,
    AircraftOutline,
    AircraftPoseFigure,
    MovingPart,
    ViewDirection,
    body_color,
    paint_body,
    paint_pose,
    to_polygon,
)
from ui.translation import tr

SurfaceKind = Literal["surface", "vane"]
_TALL_ASPECT = 0.5
"""Height over width from which the close-up stands above the whole aircraft."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SurfaceFigure:
    """What is drawn."""

    channel: str
    """The surface or vane."""
    title: str
    """Its name."""
    view: ViewDirection
    """From where its turning is seen close up."""
    kind: SurfaceKind
    """A surface behind a fixed part, or a vane on a pivot."""
    sense: int
    """1 where a positive angle turns the trailing edge down (from the side) or to the left (from
    above)."""
    ticks: tuple[float, ...]
    """Angles on the protractor, deg, ascending."""
    angle: float | None = None
    """As measured now, deg; None where it is not known."""
    target: float | None = None
    """To be set, deg."""

    @property
    def travel_end_texts(self) -> tuple[str, str]:
        """Return where the trailing edge is at the lowest and at the highest angle, in words."""
        first, second = (tr("up"), tr("down")) if self.view == "side" else (tr("right"), tr("left"))
        return (first, second) if self.sense > 0 else (second, first)

    @property
    def accessible_text(self) -> str:
        if self.angle is None:
            return tr("{title}: angle unknown").format(title=self.title)
        return tr("{title}: trailing edge {side}").format(
            title=self.title, side=self.trailing_edge_side
        )

    @property
    def trailing_edge_side(self) -> str:
        if self.angle is None:
            return tr("not known")
        if abs(self.angle) < 1.0:
            return tr("neutral")
        return self.travel_end_texts[1] if self.angle > 0 else self.travel_end_texts[0]


class SurfaceMotionView(QWidget):
    """Draws a figure; simple, large, the trailing edge named."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        self.figure: SurfaceFigure | AircraftPoseFigure | None = None
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        style.changed.connect(self._fit)
        self._fit()

    def _fit(self) -> None:
        self.setMinimumHeight(self._style.px(150))
        self.update()

    def sizeHint(self) -> QSize:
        return QSize(self._style.px(480), self._style.px(220))

    def show_figure(self, figure: SurfaceFigure | AircraftPoseFigure | None) -> None:
        """Draw another figure."""
        if figure == self.figure:
            return
        self.figure = figure
        self.setAccessibleName(tr("The aircraft") if figure is None else figure.accessible_text)
        self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        figure = self.figure
        if figure is None:
            return
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        gap = self._style.px(8)
        box = QRectF(self.rect()).adjusted(gap, gap, -gap, -gap)
        if isinstance(figure, AircraftPoseFigure):
            paint_pose(painter, box, self._style, figure)
            painter.end()
            return
        wholes, close = _arrange_views(figure, box, gap)
        for view, place in wholes:
            self._paint_whole(painter, place, OUTLINES_BY_VIEW[view], figure)
        SurfaceCloseup(self._style, figure).paint(painter, close)
        painter.end()

    def _paint_whole(
        self, painter: QPainter, box: QRectF, outline: AircraftOutline, figure: SurfaceFigure
    ) -> None:
        part = outline.parts.get(figure.channel)
        whole = QRectF(0.0, 0.0, *outline.size)
        if part is not None:
            # The ring may reach over the edge of the aircraft.
            whole = whole.united(_ring(part, outline))
        scale = min(box.width() / whole.width(), box.height() / whole.height())
        painter.save()
        painter.translate(box.center())
        painter.scale(scale, scale)
        painter.translate(-whole.center())
        paint_body(painter, self._style, outline, "muted")
        if part is not None:
            self._paint_part(painter, part, figure, outline)
        painter.restore()

    def _paint_part(
        self, painter: QPainter, part: MovingPart, figure: SurfaceFigure, outline: AircraftOutline
    ) -> None:
        style = self._style
        pen = QPen(style.color("text"), style.px(1.5))
        pen.setCosmetic(True)
        painter.setPen(pen)
        painter.setBrush(style.color("text"))
        painter.save()
        if part.rotation_visible:
            painter.translate(*part.hinge)
            painter.rotate(figure.sense * (figure.angle or 0.0))
            painter.translate(-part.hinge[0], -part.hinge[1])
        painter.drawPolygon(to_polygon(part.outline))
        painter.restore()
        ring = QPen(style.color("text"), style.px(2))
        ring.setCosmetic(True)
        painter.setPen(ring)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawEllipse(_ring(part, outline))


def _ring(part: MovingPart, outline: AircraftOutline) -> QRectF:
    """Return the circle around the part that is meant, in the units of the outline."""
    radius = 0.1 * outline.size[0]
    middle = to_polygon(part.outline).boundingRect().center()
    return QRectF(middle.x() - radius, middle.y() - radius, 2 * radius, 2 * radius)


def _arrange_views(
    figure: SurfaceFigure, box: QRectF, gap: float
) -> tuple[list[tuple[ViewDirection, QRectF]], QRectF]:
    """Return where the views of the whole aircraft go, and where the close-up goes.

    From above one sees whether it is the left or the right one, from the side how it moves.
    """
    wanted: tuple[ViewDirection, ...] = ("above", "side") if figure.view == "side" else ("above",)
    views = [view for view in wanted if figure.channel in OUTLINES_BY_VIEW[view].parts]
    if figure.view == "side" and box.height() > _TALL_ASPECT * box.width():
        strip = QRectF(box.left(), box.top() + 0.55 * box.height(), box.width(),
                       0.45 * box.height())  # fmt: skip
        close = QRectF(box.left(), box.top(), box.width(), 0.55 * box.height() - gap)
        shares = [0.42, 0.58] if len(views) == 2 else [1.0]
        end = strip.right()
    else:
        strip = box
        above = min(0.36, 0.95 * box.height() / max(box.width(), 1.0))
        shares = [above, 0.9 * (0.54 - above)] if len(views) == 2 else [0.4]
        end = box.left() + sum(shares) * box.width() + gap * len(views)
        close = QRectF(end, box.top(), box.right() - end, box.height())
    left = strip.left()
    places = []
    for view, share in zip(views, shares, strict=True):
        wide = share * box.width() - (gap if strip is not box else 0.0)
        places.append((view, QRectF(left, strip.top(), wide, strip.height())))
        left += wide + gap
    return places, close


class SurfaceCloseup:
    """One surface in section with a protractor around its hinge."""

    def __init__(self, style: DisplayStyle, figure: SurfaceFigure) -> None:
        self._style = style
        self._figure = figure
        # Where the trailing edge points in neutral: aft, that is to the right or down.
        self._aft = 0.0 if figure.view == "side" else 90.0

    @property
    def _widest(self) -> float:
        """Return the angle (deg) at both ends of the protractor."""
        return max([25.0, *(abs(tick) for tick in self._figure.ticks)]) + 6.0

    def layout(self, box: QRectF) -> tuple[QPointF, float]:
        """Return where in a box the hinge is, and how far (pixels) the protractor is from it."""
        style, figure = self._style, self._figure
        letters = style.px(52)
        # The chord lies along the box: a fixed part, the hinge, the moving part, the angles.
        along = box.width() if figure.view == "side" else box.height()
        across = box.height() if figure.view == "side" else box.width()
        fixed = 0.3 if figure.kind == "surface" else 0.08
        reach = min(
            (along - letters) / (1.0 + fixed),
            (0.5 * across - style.px(14)) / math.sin(math.radians(min(self._widest, 90.0))),
        )
        reach = max(reach, style.px(40))
        start = 0.5 * (along - (1.0 + fixed) * reach - letters) + fixed * reach
        if figure.view == "side":
            return QPointF(box.left() + start, box.center().y()), reach
        return QPointF(box.center().x(), box.top() + start), reach

    def side_boxes(self, box: QRectF) -> tuple[QRectF, QRectF]:
        """Return where the words for the lowest and the highest angle go.

        Outside the sector through which the surface and its target turn, near the hinge.
        """
        style, figure = self._style, self._figure
        hinge, reach = self.layout(box)
        letters = QFontMetrics(style.font("label", strong=True))
        wide = max(
            letters.horizontalAdvance(line)
            for line in (tr("trailing edge"), *figure.travel_end_texts)
        )
        high, gap = 2 * letters.lineSpacing(), style.px(4)
        slope = math.tan(math.radians(min(self._widest, 60.0)))
        half = self._half_chord(reach)
        if figure.view == "side":
            left = max(hinge.x() - 0.6 * wide, box.left())
            beside = max(left + wide - hinge.x(), 0.0) * slope + half + gap
            first = QRectF(left, max(hinge.y() - beside - high, box.top()), wide, high)
            second = QRectF(left, min(hinge.y() + beside, box.bottom() - high), wide, high)
        else:
            # The words end a little below the hinge.
            top = max(hinge.y() - 0.4 * high, box.top())
            beside = max(top + high - hinge.y(), 0.0) * slope + half + gap
            first = QRectF(min(hinge.x() + beside, box.right() - wide), top, wide, high)
            second = QRectF(max(hinge.x() - beside - wide, box.left()), top, wide, high)
        return (first, second) if figure.sense > 0 else (second, first)

    def moving_part(self, box: QRectF) -> QPolygonF:
        """Return the surface or vane at its angle, neutral where that is not known."""
        hinge, reach = self.layout(box)
        half, tip, long = self._half_chord(reach), 0.006 * reach, 0.9 * reach
        turn = QTransform().translate(hinge.x(), hinge.y())
        turn.rotate(self._turned(self._figure.angle or 0.0))
        return turn.map(to_polygon(((0.0, -half), (long, -tip), (long, tip), (0.0, half))))

    def paint(self, painter: QPainter, box: QRectF) -> None:
        figure = self._figure
        hinge, reach = self.layout(box)
        self._paint_scale(painter, hinge, reach)
        self._paint_sides(painter, box)
        self._paint_fixed(painter, hinge, reach)
        if figure.target is not None:
            self._paint_target(painter, hinge, reach)
        self._paint_moving(painter, box)

    def _turned(self, angle: float) -> float:
        """Return the direction on screen, deg clockwise from the right, of the trailing edge."""
        # Down is clockwise where the edge points right; left is clockwise where it points down.
        return self._aft + self._figure.sense * angle

    def _at(self, hinge: QPointF, angle: float, distance: float) -> QPointF:
        turned = math.radians(self._turned(angle))
        return hinge + QPointF(distance * math.cos(turned), distance * math.sin(turned))

    def _half_chord(self, reach: float) -> float:
        """Return half the thickness (pixels) of the moving part at the hinge."""
        return 0.09 * reach if self._figure.kind == "surface" else 0.045 * reach

    def _paint_scale(self, painter: QPainter, hinge: QPointF, reach: float) -> None:
        style, figure, widest = self._style, self._figure, self._widest
        painter.setPen(QPen(style.color("axis"), style.px(1.5)))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        square = QRectF(hinge.x() - reach, hinge.y() - reach, 2 * reach, 2 * reach)
        # Qt counts sixteenths of a degree, anticlockwise.
        start = -self._turned(figure.sense * widest) * 16
        painter.drawArc(square, round(start), round(2 * widest * 16))
        painter.setFont(style.font("label"))
        for tick in figure.ticks:
            wanted = figure.target is not None and abs(tick - figure.target) < 1e-9
            color = style.color("target" if wanted else "muted")
            painter.setPen(QPen(color, style.px(2.5 if wanted else 1.5)))
            painter.drawLine(self._at(hinge, tick, reach), self._at(hinge, tick, 1.05 * reach))
            middle = self._at(hinge, tick, 1.05 * reach + style.px(19))
            text = QRectF(middle.x() - style.px(24), middle.y() - style.px(9), style.px(48),
                           style.px(18))  # fmt: skip
            painter.drawText(text, Qt.AlignmentFlag.AlignCenter, f"{number_text(tick, 0)}°")

    def _paint_sides(self, painter: QPainter, box: QRectF) -> None:
        style = self._style
        painter.setFont(style.font("label", strong=True))
        painter.setPen(style.color("text"))
        flags = Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextDontClip
        for text, place in zip(self._figure.travel_end_texts, self.side_boxes(box), strict=True):
            painter.drawText(place, flags, tr("trailing edge\n{words}").format(words=text))

    def _paint_fixed(self, painter: QPainter, hinge: QPointF, reach: float) -> None:
        style, figure = self._style, self._figure
        painter.save()
        painter.translate(hinge)
        painter.rotate(self._aft)
        painter.setPen(QPen(style.color("muted"), style.px(1.5)))
        painter.setBrush(body_color(style))
        half = 0.09 * reach
        if figure.kind == "surface":
            painter.drawPolygon(
                to_polygon(((-0.3 * reach, -1.25 * half), (0.0, -half), (0.0, half),
                         (-0.3 * reach, 1.25 * half)))
            )  # fmt: skip
        else:
            painter.drawEllipse(QPointF(0.0, 0.0), 0.08 * reach, 0.08 * reach)
        painter.restore()

    def _paint_target(self, painter: QPainter, hinge: QPointF, reach: float) -> None:
        pen = QPen(self._style.color("target"), self._style.px(2.5))
        pen.setDashPattern([4.0, 2.5])
        painter.setPen(pen)
        target = self._figure.target or 0.0
        painter.drawLine(self._at(hinge, target, 0.1 * reach), self._at(hinge, target, reach))

    def _paint_moving(self, painter: QPainter, box: QRectF) -> None:
        style, figure = self._style, self._figure
        if figure.angle is not None:
            painter.setPen(QPen(style.color("text"), style.px(1.5)))
            painter.setBrush(style.color("text"))
        else:
            # Not known is not drawn as if it were.
            painter.setPen(QPen(style.color("muted"), style.px(1.5), Qt.PenStyle.DashLine))
            painter.setBrush(Qt.BrushStyle.BDiagPattern)
        painter.drawPolygon(self.moving_part(box))
        painter.setBrush(style.color("background"))
        painter.setPen(QPen(style.color("text"), style.px(1.5)))
        hinge, reach = self.layout(box)
        painter.drawEllipse(hinge, *[max(0.035 * reach, style.px(3))] * 2)

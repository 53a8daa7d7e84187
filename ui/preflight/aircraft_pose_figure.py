"""The whole aircraft as it is to lie, to be turned, or to be left alone; and its pitot."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPainterPath, QPen, QPolygonF

from ui.display_style import DisplayStyle, mix_colors
from ui.preflight.aircraft_outlines import (
    REAR_OUTLINE,
    SIDE_OUTLINE,
    TOP_OUTLINE,
    AircraftOutline,
    OutlinePoints,
)

PoseKind = Literal["still", "lie", "turn", "cover", "blow"]

_REST_OUTLINES: Mapping[str, tuple[AircraftOutline, float]] = MappingProxyType(
    {
        "z_down": (SIDE_OUTLINE, 0.0),
        "z_up": (SIDE_OUTLINE, 180.0),
        "x_up": (SIDE_OUTLINE, 90.0),
        "x_down": (SIDE_OUTLINE, -90.0),
        "y_up": (REAR_OUTLINE, -90.0),
        "y_down": (REAR_OUTLINE, 90.0),
    }
)
"""Views of the six positions, with the turn of each, deg clockwise."""

_TURN_OUTLINES: Mapping[str, AircraftOutline] = MappingProxyType(
    {"p": REAR_OUTLINE, "q": SIDE_OUTLINE, "r": TOP_OUTLINE}
)
"""What is seen from above the table: a positive turn is clockwise in each of these views."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AircraftPoseFigure:
    """What is drawn.

    Attributes
    ----------
    kind : {"still", "lie", "turn", "cover", "blow"}
        Left alone; laid in a position; turned on the table; pitot covered; breath into it.
    accessible_text : str
        The same for those who hear it.
    position : str
        ``z_down`` and so on, to lie in.
    axis : str
        ``p``, ``q`` or ``r``: what it is turned about.
    angle : float
        To be turned, deg, with its sign.
    turned : float
        Turned so far, deg, without its sign.
    """

    kind: PoseKind
    accessible_text: str
    position: str = "z_down"
    axis: str = "r"
    angle: float = 0.0
    turned: float = 0.0


def paint_pose(
    painter: QPainter, box: QRectF, look: DisplayStyle, figure: AircraftPoseFigure
) -> None:
    """Draw a figure into a box."""
    if figure.kind == "turn":
        _paint_turn(painter, box, look, figure)
    elif figure.kind in ("cover", "blow"):
        _paint_pitot(painter, box, look, breath=figure.kind == "blow")
    else:
        outline, turn = _REST_OUTLINES[figure.position]
        ground = box.adjusted(0, 0, 0, -look.px(14))
        _paint_outline(painter, ground, look, outline, turn)
        pen = QPen(look.color("text"), look.px(3))
        painter.setPen(pen)
        line = box.bottom() - look.px(6)
        painter.drawLine(QPointF(box.left(), line), QPointF(box.right(), line))


def _paint_outline(
    painter: QPainter,
    box: QRectF,
    look: DisplayStyle,
    outline: AircraftOutline,
    turn: float,
    *,
    fill: float = 0.9,
) -> None:
    """Draw an outline as large as it goes into a box once it is turned, deg clockwise."""
    wide, high = outline.size
    sine, cosine = abs(math.sin(math.radians(turn))), abs(math.cos(math.radians(turn)))
    if fill < 0.9:
        # On the table it turns through all angles.
        wide = high = math.hypot(*outline.size)
        sine, cosine = 0.0, 1.0
    scale = min(
        box.width() / (wide * cosine + high * sine), box.height() / (wide * sine + high * cosine)
    )
    painter.save()
    painter.translate(box.center())
    painter.rotate(turn)
    painter.scale(scale, scale)
    painter.translate(-0.5 * outline.size[0], -0.5 * outline.size[1])
    pen = QPen(look.color("text"), look.px(1.5))
    pen.setCosmetic(True)
    pen.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
    painter.setPen(pen)
    painter.setBrush(body_color(look))
    for shape in outline.shapes:
        painter.drawPolygon(to_polygon(shape))
    painter.restore()


def _paint_turn(
    painter: QPainter, box: QRectF, look: DisplayStyle, figure: AircraftPoseFigure
) -> None:
    side = min(box.width(), box.height())
    table = QRectF(0, 0, side, side).adjusted(look.px(8), look.px(8), -look.px(8), -look.px(8))
    table.moveCenter(box.center())
    painter.setPen(QPen(look.color("axis"), look.px(2)))
    painter.setBrush(look.color("panel"))
    painter.drawEllipse(table)
    sense = 1.0 if figure.angle >= 0.0 else -1.0
    inner = table.adjusted(0.1 * side, 0.1 * side, -0.1 * side, -0.1 * side)
    turned = sense * figure.turned
    _paint_outline(painter, inner, look, _TURN_OUTLINES[figure.axis], turned, fill=0.8)
    # The way that is left, with an arrow, in the color of what is wanted.
    ring = table.adjusted(look.px(6), look.px(6), -look.px(6), -look.px(6))
    pen = QPen(look.color("target"), look.px(5))
    pen.setCapStyle(Qt.PenCapStyle.FlatCap)
    painter.setPen(pen)
    painter.setBrush(Qt.BrushStyle.NoBrush)
    left = max(min(abs(figure.angle) - figure.turned, 350.0), 0.0)
    # Qt counts sixteenths of a degree, anticlockwise from the right; the turn begins at the top.
    start = 90.0 - turned
    painter.drawArc(ring, round(16 * start), round(-16 * sense * left))
    if left > 5.0:
        end = math.radians(start - sense * left)
        tip = ring.center() + QPointF(math.cos(end), -math.sin(end)) * (0.5 * ring.width())
        painter.save()
        painter.translate(tip)
        painter.rotate(-math.degrees(end) + 90.0 * sense + 90.0)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(look.color("target"))
        half = look.px(10)
        painter.drawPolygon(to_polygon(((-half, half), (half, half), (0.0, -half))))
        painter.restore()


def _paint_pitot(painter: QPainter, box: QRectF, look: DisplayStyle, *, breath: bool) -> None:
    px = look.px
    unit = min(box.width() / 14.0, box.height() / 7.0)
    painter.save()
    painter.translate(box.center())
    painter.setPen(QPen(look.color("text"), px(1.5)))
    painter.setBrush(body_color(look))
    nose = QPainterPath(QPointF(1.0 * unit, 0.0))
    nose.cubicTo(1.2 * unit, -2.0 * unit, 3.0 * unit, -2.6 * unit, 6.6 * unit, -2.8 * unit)
    nose.lineTo(6.6 * unit, 2.8 * unit)
    nose.cubicTo(3.0 * unit, 2.6 * unit, 1.2 * unit, 2.0 * unit, 1.0 * unit, 0.0)
    painter.drawPath(nose)
    painter.setBrush(look.color("text"))
    painter.drawRect(QRectF(-2.6 * unit, -0.18 * unit, 3.6 * unit, 0.36 * unit))
    painter.setPen(QPen(look.color("target"), px(3)))
    if breath:
        painter.setBrush(look.color("target"))
        for row in (-1.0, 0.0, 1.0):
            start = QPointF(-6.4 * unit, 1.1 * row * unit)
            tip = QPointF((-3.1 - 0.4 * abs(row)) * unit, 0.6 * row * unit)
            _paint_arrow(painter, start, tip, 0.2 * unit)
    else:
        painter.setBrush(Qt.BrushStyle.NoBrush)
        cover = QRectF(-3.2 * unit, -0.55 * unit, 2.6 * unit, 1.1 * unit)
        painter.drawRoundedRect(cover, 0.4 * unit, 0.4 * unit)
    painter.restore()


def _paint_arrow(painter: QPainter, start: QPointF, tip: QPointF, half: float) -> None:
    """Draw an arrow whose head is twice as long as its `half` width at either side."""
    along = tip - start
    along /= math.hypot(along.x(), along.y())
    across = QPointF(-along.y(), along.x()) * half
    neck = tip - along * (2.0 * half)
    painter.drawLine(start, neck)
    painter.drawPolygon(QPolygonF([tip, neck + across, neck - across]))


def to_polygon(points: OutlinePoints) -> QPolygonF:
    """Return points as Qt takes them."""
    return QPolygonF([QPointF(x, y) for x, y in points])


def body_color(look: DisplayStyle) -> QColor:
    """Return the fill of what does not move."""
    return mix_colors(look.theme.plot, look.theme.text, 0.14)

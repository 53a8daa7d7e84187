"""The aircraft drawn: outlines from three sides, and how it is to lie or to be turned."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPainterPath, QPen, QPolygonF

from ui.display_style import DisplayStyle, mix_colors

ViewDirection = Literal["side", "above"]
OutlinePoints = tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class MovingPart:
    """What moves, as seen in one view."""

    outline: OutlinePoints
    """Closed."""
    hinge: tuple[float, float]
    """Where it turns, and where its ring is drawn."""
    rotation_visible: bool = True
    """Whether its turning can be seen in this view."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AircraftOutline:
    """The aircraft in one view."""

    size: tuple[float, float]
    """Width and height of the box around it."""
    shapes: tuple[OutlinePoints, ...]
    """Closed outlines of what does not move, painted in this order."""
    parts: Mapping[str, MovingPart]
    """What moves, by channel."""


def _mirrored(points: OutlinePoints, about: float) -> OutlinePoints:
    return tuple((2 * about - x, y) for x, y in points)


_ELEVATOR: OutlinePoints = ((96, 18.2), (96, 20.6), (104.5, 19.6))
_AILERON: OutlinePoints = ((58.5, 27), (58.5, 29.4), (65.5, 28.6))
_RUDDER: OutlinePoints = ((96.2, 2.5), (100.6, 3.2), (100.6, 16.6), (94.6, 16.6))

SIDE_OUTLINE = AircraftOutline(
    size=(108.0, 40.0),
    shapes=(
        # Fuselage.
        (
            (7, 22.5), (8, 20.5), (11, 18.4), (16, 16.8), (22, 16.2), (78, 16.2), (92, 17),
            (100, 18.6), (100, 20), (90, 22.6), (76, 27), (68, 28.4), (20, 28.4), (12, 27.2),
            (8, 24.8),
        ),
        # Fin.
        ((78, 16.2), (90, 1.6), (96.2, 1.6), (94.6, 16.8)),
        # Tailplane and wing, as sections.
        ((84, 19.6), (86, 18.4), (96, 18.2), (96, 20.6), (86, 20.4)),
        ((38, 28.6), (41, 26.6), (50, 26), (58.5, 27), (58.5, 29.4), (42, 30.2)),
        # Engine.
        ((33, 30.6), (35, 29.8), (46, 30.2), (50, 31.6), (50, 34.6), (46, 36.2), (35, 36.6),
         (33, 35.6)),
        # Boom of the vanes.
        ((0.4, 22.2), (7.4, 22.2), (7.4, 23.2), (0.4, 23.2)),
    ),
    parts=MappingProxyType(
        {
            "elevator_left": MovingPart(outline=_ELEVATOR, hinge=(96, 19.4)),
            "elevator_right": MovingPart(outline=_ELEVATOR, hinge=(96, 19.4)),
            "aileron_left": MovingPart(outline=_AILERON, hinge=(58.5, 28.2)),
            "aileron_right": MovingPart(outline=_AILERON, hinge=(58.5, 28.2)),
            "rudder": MovingPart(outline=_RUDDER, hinge=(95.4, 9.5), rotation_visible=False),
            "alpha": MovingPart(outline=((2, 21.9), (2, 23.5), (7.6, 23.2), (7.6, 22.2)),
                          hinge=(2, 22.7)),
        }
    ),
)  # fmt: skip
"""Nose to the left, seen from its left."""

_WING: OutlinePoints = ((46, 34), (4, 57), (2.6, 60.5), (4, 62.5), (26, 56.2), (46, 54))
_TAILPLANE: OutlinePoints = ((47.4, 82), (33, 91), (32, 93.2), (33, 94.4), (48.6, 92))
_ENGINE: OutlinePoints = ((30.4, 37), (34.2, 36.6), (35, 38), (34.6, 46), (30.8, 47), (29.8, 38.4))
_AILERON_TOP: OutlinePoints = ((4.2, 60.4), (22.4, 54.6), (22.8, 57.2), (4.2, 62.6))
_ELEVATOR_TOP: OutlinePoints = ((33, 92.4), (47.6, 89.6), (48, 92.6), (33, 95))

TOP_OUTLINE = AircraftOutline(
    size=(100.0, 106.0),
    shapes=(
        _WING,
        _mirrored(_WING, 50),
        _TAILPLANE,
        _mirrored(_TAILPLANE, 50),
        _ENGINE,
        _mirrored(_ENGINE, 50),
        (
            (50, 7), (52, 8.2), (54, 12), (54.8, 18), (54.8, 70), (53.6, 84), (51.4, 97), (50, 99),
            (48.6, 97), (46.4, 84), (45.2, 70), (45.2, 18), (46, 12), (48, 8.2),
        ),
        ((49.4, 80), (50, 78.6), (50.6, 80), (50.8, 95), (49.2, 95)),
        ((49.6, 0.6), (50.4, 0.6), (50.4, 7.4), (49.6, 7.4)),
    ),
    parts=MappingProxyType(
        {
            "elevator_left": MovingPart(outline=_ELEVATOR_TOP, hinge=(41, 92),
            rotation_visible=False),
            "elevator_right": MovingPart(
                outline=_mirrored(_ELEVATOR_TOP, 50), hinge=(59, 92), rotation_visible=False
            ),
            "aileron_left": MovingPart(outline=_AILERON_TOP, hinge=(13, 58.5),
            rotation_visible=False),
            "aileron_right": MovingPart(
                outline=_mirrored(_AILERON_TOP, 50), hinge=(87, 58.5), rotation_visible=False
            ),
            "rudder": MovingPart(outline=((49.1, 95), (50.9, 95), (50.2, 104.5), (49.8, 104.5)),
                           hinge=(50, 95)),
            "beta": MovingPart(outline=((49.2, 2), (50.8, 2), (50.5, 8.4), (49.5, 8.4)),
            hinge=(50, 2)),
        }
    ),
)  # fmt: skip
"""Nose up, seen from above: the left wing is on the left."""

OUTLINES_BY_VIEW: Mapping[ViewDirection, AircraftOutline] = MappingProxyType(
    {"side": SIDE_OUTLINE, "above": TOP_OUTLINE}
)

_WING_REAR: OutlinePoints = ((54, 53), (96, 46), (97.5, 44.5), (97.5, 46.5), (54, 57))
_TAILPLANE_REAR: OutlinePoints = ((52, 45), (67, 42.6), (67.4, 43.6), (52, 47.4))

REAR_OUTLINE = AircraftOutline(
    size=(100.0, 80.0),
    shapes=(
        _WING_REAR,
        _mirrored(_WING_REAR, 50),
        ((69, 56), (72, 54.6), (75, 56), (75.6, 59), (74, 62), (70, 62), (68.4, 59)),
        ((31, 56), (28, 54.6), (25, 56), (24.4, 59), (26, 62), (30, 62), (31.6, 59)),
        ((49.2, 44), (49.6, 25), (50.4, 25), (50.8, 44)),
        ((50, 43), (54, 44.2), (56.6, 48), (56.6, 52), (54, 56), (50, 57.4), (46, 56), (43.4, 52),
         (43.4, 48), (46, 44.2)),
        _TAILPLANE_REAR,
        _mirrored(_TAILPLANE_REAR, 50),
    ),
    parts=MappingProxyType({}),
)  # fmt: skip
"""Seen from behind: the right wing is on the right."""


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
    """What is drawn."""

    kind: PoseKind
    """Left alone; laid in a position; turned on the table; pitot covered; breath into it."""
    accessible_text: str
    """The same for those who hear it."""
    position: str = "z_down"
    """``z_down`` and so on, to lie in."""
    axis: str = "r"
    """``p``, ``q`` or ``r``: what it is turned about."""
    angle: float = 0.0
    """To be turned, deg, with its sign."""
    turned: float = 0.0
    """Turned so far, deg, without its sign."""


def paint_pose(
    painter: QPainter, box: QRectF, style: DisplayStyle, figure: AircraftPoseFigure
) -> None:
    """Draw a figure into a box."""
    if figure.kind == "turn":
        _paint_turn(painter, box, style, figure)
    elif figure.kind in ("cover", "blow"):
        _paint_pitot(painter, box, style, breath=figure.kind == "blow")
    else:
        outline, turn = _REST_OUTLINES[figure.position]
        ground = box.adjusted(0, 0, 0, -style.px(14))
        _paint_outline(painter, ground, style, outline, turn)
        pen = QPen(style.color("text"), style.px(3))
        painter.setPen(pen)
        line = box.bottom() - style.px(6)
        painter.drawLine(QPointF(box.left(), line), QPointF(box.right(), line))


def _paint_outline(
    painter: QPainter,
    box: QRectF,
    style: DisplayStyle,
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
    paint_body(painter, style, outline, "text")
    painter.restore()


def paint_body(painter: QPainter, style: DisplayStyle, outline: AircraftOutline, ink: str) -> None:
    """Draw what does not move, in the units of the outline."""
    pen = QPen(style.color(ink), style.px(1.5))
    pen.setCosmetic(True)
    pen.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
    painter.setPen(pen)
    painter.setBrush(body_color(style))
    for shape in outline.shapes:
        painter.drawPolygon(to_polygon(shape))


def _paint_turn(
    painter: QPainter, box: QRectF, style: DisplayStyle, figure: AircraftPoseFigure
) -> None:
    side = min(box.width(), box.height())
    table = QRectF(0, 0, side, side).adjusted(style.px(8), style.px(8), -style.px(8), -style.px(8))
    table.moveCenter(box.center())
    painter.setPen(QPen(style.color("axis"), style.px(2)))
    painter.setBrush(style.color("panel"))
    painter.drawEllipse(table)
    sense = 1.0 if figure.angle >= 0.0 else -1.0
    inner = table.adjusted(0.1 * side, 0.1 * side, -0.1 * side, -0.1 * side)
    turned = sense * figure.turned
    _paint_outline(painter, inner, style, _TURN_OUTLINES[figure.axis], turned, fill=0.8)
    # The way that is left, with an arrow, in the color of what is wanted.
    ring = table.adjusted(style.px(6), style.px(6), -style.px(6), -style.px(6))
    pen = QPen(style.color("target"), style.px(5))
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
        painter.setBrush(style.color("target"))
        half = style.px(10)
        painter.drawPolygon(to_polygon(((-half, half), (half, half), (0.0, -half))))
        painter.restore()


def _paint_pitot(painter: QPainter, box: QRectF, style: DisplayStyle, *, breath: bool) -> None:
    px = style.px
    unit = min(box.width() / 14.0, box.height() / 7.0)
    painter.save()
    painter.translate(box.center())
    painter.setPen(QPen(style.color("text"), px(1.5)))
    painter.setBrush(body_color(style))
    nose = QPainterPath(QPointF(1.0 * unit, 0.0))
    nose.cubicTo(1.2 * unit, -2.0 * unit, 3.0 * unit, -2.6 * unit, 6.6 * unit, -2.8 * unit)
    nose.lineTo(6.6 * unit, 2.8 * unit)
    nose.cubicTo(3.0 * unit, 2.6 * unit, 1.2 * unit, 2.0 * unit, 1.0 * unit, 0.0)
    painter.drawPath(nose)
    painter.setBrush(style.color("text"))
    painter.drawRect(QRectF(-2.6 * unit, -0.18 * unit, 3.6 * unit, 0.36 * unit))
    painter.setPen(QPen(style.color("target"), px(3)))
    if breath:
        painter.setBrush(style.color("target"))
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
    along = tip - start
    along /= math.hypot(along.x(), along.y())
    across = QPointF(-along.y(), along.x()) * half
    neck = tip - along * (2.0 * half)
    painter.drawLine(start, neck)
    painter.drawPolygon(QPolygonF([tip, neck + across, neck - across]))


def to_polygon(points: OutlinePoints) -> QPolygonF:
    """Return points as Qt takes them."""
    return QPolygonF([QPointF(x, y) for x, y in points])


def body_color(style: DisplayStyle) -> QColor:
    """Return the fill of what does not move."""
    return mix_colors(style.theme.plot, style.theme.text, 0.14)

"""The shapes of the page's states: large, filled, told apart from three meters without color."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import (
    QColor,
    QPainter,
    QPainterPath,
    QPainterPathStroker,
    QPen,
    QPolygonF,
    QTransform,
)

from ui.pilot.cue_display import SignName

_SHAPE_SIZE: Final = 100.0
"""Shapes are designed on a square of so many units."""
_BANK_ANGLE: Final = 22.0
"""Degrees by which a wing is drawn low."""


def _polygon(*points: tuple[float, float]) -> QPainterPath:
    path = QPainterPath()
    path.addPolygon(QPolygonF([QPointF(x, y) for x, y in points]))
    path.closeSubpath()
    return path


def _polyline(*points: tuple[float, float], width: float = 14.0) -> QPainterPath:
    path = QPainterPath(QPointF(*points[0]))
    for x, y in points[1:]:
        path.lineTo(x, y)
    return _stroke_path(path, width)


def _stroke_path(path: QPainterPath, width: float) -> QPainterPath:
    stroker = QPainterPathStroker()
    stroker.setWidth(width)
    stroker.setCapStyle(Qt.PenCapStyle.RoundCap)
    stroker.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
    return stroker.createStroke(path).simplified()


def _disk(x: float, y: float, radius: float) -> QPainterPath:
    path = QPainterPath()
    path.addEllipse(QPointF(x, y), radius, radius)
    return path


def _up_sign() -> QPainterPath:
    return _polygon((50, 6), (92, 52), (66, 52), (66, 94), (34, 94), (34, 52), (8, 52))


def _down_sign() -> QPainterPath:
    return _polygon((50, 94), (8, 48), (34, 48), (34, 6), (66, 6), (66, 48), (92, 48))


def _rear_view_sign(bank: float) -> QPainterPath:
    """Return the aircraft seen from behind; positive bank is the right wing low."""
    path = _polyline((5, 54), (95, 54), width=13)
    path = path.united(_polyline((50, 54), (50, 26), width=10))
    path = path.united(_disk(50, 56, 14))
    turned = QTransform()
    turned.translate(50, 52)
    turned.rotate(bank)
    turned.translate(-50, -52)
    return turned.map(path)


def _turn_sign(left: bool) -> QPainterPath:
    arc = QPainterPath(QPointF(24, 94))
    arc.lineTo(24, 62)
    arc.cubicTo(24, 30, 40, 28, 62, 28)
    path = _stroke_path(arc, 16).united(_polygon((58, 2), (96, 28), (58, 54)))
    mirrored = QTransform(-1, 0, 0, 1, _SHAPE_SIZE, 0)
    return mirrored.map(path) if left else path


def _two_way_turn_sign() -> QPainterPath:
    """Return a turn to nobody knows which side: half a circle, an arrow at both ends."""
    arc = QPainterPath(QPointF(18, 72))
    arc.cubicTo(18, 10, 82, 10, 82, 72)
    left = _polygon((0, 58), (36, 58), (18, 92))
    right = _polygon((64, 58), (100, 58), (82, 92))
    return _stroke_path(arc, 15).united(left).united(right)


def _target_sign() -> QPainterPath:
    return _disk(50, 50, 40).subtracted(_disk(50, 50, 27)).united(_disk(50, 50, 13))


def _go_sign() -> QPainterPath:
    return _polygon((20, 6), (94, 50), (20, 94))


def _wind_sign() -> QPainterPath:
    path = QPainterPath()
    for top in (24.0, 50.0, 76.0):
        path.moveTo(8, top)
        path.cubicTo(22, top - 20, 36, top - 20, 50, top)
        path.cubicTo(64, top + 20, 78, top + 20, 92, top)
    return _stroke_path(path, 11)


def _hand_sign() -> QPainterPath:
    path = QPainterPath()
    for left, top in ((22.0, 22.0), (37.0, 8.0), (52.0, 6.0), (67.0, 16.0)):
        path.addRoundedRect(QRectF(left, top, 12, 56), 6, 6)
    palm = QPainterPath()
    palm.addRoundedRect(QRectF(22, 48, 57, 46), 18, 18)
    thumb = _polyline((30, 72), (10, 50), width=13)
    return path.united(palm).united(thumb).simplified()


def _stick_sign() -> QPainterPath:
    path = QPainterPath()
    path.addRoundedRect(QRectF(14, 74, 72, 20), 8, 8)
    return path.united(_polyline((50, 78), (50, 32), width=13)).united(_disk(50, 24, 18))


def _check_sign() -> QPainterPath:
    return _polyline((12, 54), (38, 82), (90, 18), width=18)


def _more_sign() -> QPainterPath:
    return _polyline((14, 50), (50, 16), (86, 50), width=15).united(
        _polyline((14, 86), (50, 52), (86, 86), width=15)
    )


def _less_sign() -> QPainterPath:
    return _polyline((14, 14), (50, 48), (86, 14), width=15).united(
        _polyline((14, 50), (50, 84), (86, 50), width=15)
    )


def _shorter_sign() -> QPainterPath:
    return (
        _polyline((10, 50), (34, 50), width=14)
        .united(_polygon((26, 26), (48, 50), (26, 74)))
        .united(_polyline((90, 50), (66, 50), width=14))
        .united(_polygon((74, 26), (52, 50), (74, 74)))
    )


def _longer_sign() -> QPainterPath:
    return (
        _polyline((22, 50), (78, 50), width=14)
        .united(_polygon((28, 22), (4, 50), (28, 78)))
        .united(_polygon((72, 22), (96, 50), (72, 78)))
    )


def _level_sign() -> QPainterPath:
    return _rear_view_sign(0.0).united(_polyline((6, 92), (94, 92), width=8))


def _cross_sign() -> QPainterPath:
    return _polyline((18, 18), (82, 82), width=18).united(_polyline((82, 18), (18, 82), width=18))


def _unknown_sign() -> QPainterPath:
    hook = QPainterPath(QPointF(28, 34))
    hook.cubicTo(28, 2, 74, 4, 72, 34)
    hook.cubicTo(70, 52, 50, 50, 50, 68)
    return _stroke_path(hook, 15).united(_disk(50, 89, 9))


def _danger_sign() -> QPainterPath:
    outer = _polygon((50, 4), (98, 92), (2, 92))
    mark = _polyline((50, 36), (50, 62), width=10).united(_disk(50, 78, 6))
    return outer.subtracted(mark)


def _land_sign() -> QPainterPath:
    arrow = _polygon((50, 76), (16, 40), (37, 40), (37, 4), (63, 4), (63, 40), (84, 40))
    return arrow.united(_polyline((8, 91), (92, 91), width=12))


_SIGN_BUILDERS: Final[dict[str, Callable[[], QPainterPath]]] = {
    "up": _up_sign,
    "down": _down_sign,
    "wing-left": lambda: _rear_view_sign(-_BANK_ANGLE),
    "wing-right": lambda: _rear_view_sign(_BANK_ANGLE),
    "turn": _two_way_turn_sign,
    "turn-left": lambda: _turn_sign(True),
    "turn-right": lambda: _turn_sign(False),
    "hold": _target_sign,
    "go": _go_sign,
    "wait": _wind_sign,
    "hand": _hand_sign,
    "stick": _stick_sign,
    "check": _check_sign,
    "more": _more_sign,
    "less": _less_sign,
    "quicker": _shorter_sign,
    "slower": _longer_sign,
    "level": _level_sign,
    "cross": _cross_sign,
    "unknown": _unknown_sign,
    "danger": _danger_sign,
    "land": _land_sign,
}
_path_cache: dict[str, QPainterPath] = {}


def paint_sign(painter: QPainter, name: SignName, box: QRectF, color: QColor) -> None:
    """Draw a shape as large as a box allows, in its middle; nothing for an empty name."""
    if not name:
        return
    if name not in _path_cache:
        _path_cache[name] = _SIGN_BUILDERS[name]()
    side = min(box.width(), box.height())
    painter.save()
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.translate(box.center().x() - side / 2, box.center().y() - side / 2)
    painter.scale(side / _SHAPE_SIZE, side / _SHAPE_SIZE)
    painter.fillPath(_path_cache[name], color)
    painter.restore()


def paint_ring(painter: QPainter, share: float, box: QRectF, color: QColor, track: QColor) -> None:
    """Draw a ring that is filled to a share, clockwise from the top."""
    side = min(box.width(), box.height())
    width = 0.1 * side
    ring = QRectF(0, 0, side - width, side - width)
    ring.moveCenter(box.center())
    painter.save()
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.setBrush(Qt.BrushStyle.NoBrush)
    painter.setPen(QPen(track, 0.4 * width))
    painter.drawEllipse(ring)
    painter.setPen(QPen(color, width, Qt.PenStyle.SolidLine, Qt.PenCapStyle.FlatCap))
    painter.drawArc(ring, 90 * 16, -round(360 * 16 * share))
    painter.restore()

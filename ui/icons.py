"""Signs drawn as lines, so that they are sharp at every size and take the color of the theme."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Literal

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QIcon, QPainter, QPainterPath, QPen, QPixmap, QPolygonF

from ui.translation import QT_TR_NOOP

IndicatorState = Literal["plain", "good", "caution", "warning", "unknown"]
STATE_TITLES = (QT_TR_NOOP("caution"), QT_TR_NOOP("warning"), QT_TR_NOOP("unknown"))
"""What a screen reader says of a state."""


def _draw_lines(path: QPainterPath, *points: tuple[float, float]) -> None:
    path.addPolygon(QPolygonF([QPointF(*point) for point in points]))


def _check(path: QPainterPath) -> None:
    path.addRoundedRect(QRectF(5, 3, 14, 18), 2, 2)
    for row in (8.0, 13.0):
        _draw_lines(path, (8, row), (9.6, row + 1.6), (12, row - 1))
        _draw_lines(path, (14, row + 0.5), (16.5, row + 0.5))
    _draw_lines(path, (8, 18), (16.5, 18))


def _strips(path: QPainterPath) -> None:
    for row, height, phase in ((6.0, 3.0, 0.0), (12.5, 2.2, 1.2), (19.0, 1.6, 2.4)):
        path.moveTo(3, row - height * math.sin(phase))
        for step in range(1, 37):
            x = 3 + step * 0.5
            fade = math.exp(-step / 18.0)
            path.lineTo(x, row - height * fade * math.sin(phase + step * 0.45))


def _pilot(path: QPainterPath) -> None:
    path.addEllipse(QRectF(3, 3, 18, 18))
    _draw_lines(path, (6, 14.5), (10, 14.5), (12, 12), (14, 14.5), (18, 14.5))
    _draw_lines(path, (12, 5.5), (12, 8))


def _review(path: QPainterPath) -> None:
    _draw_lines(path, (4, 3), (4, 20), (21, 20))
    path.moveTo(7, 16)
    path.cubicTo(10, 16, 10, 6, 13, 6)
    path.cubicTo(16, 6, 15, 13, 20, 13)
    for x, y in ((8.5, 13.0), (12.0, 8.5), (16.5, 9.5)):
        path.addEllipse(QPointF(x, y), 0.9, 0.9)


def _gap(path: QPainterPath) -> None:
    path.moveTo(3, 17)
    path.cubicTo(8, 17, 10, 7, 21, 5)
    path.moveTo(3, 20)
    path.cubicTo(9, 20, 13, 15, 21, 14)
    for x, low, high in ((11.0, 12.4, 16.6), (16.5, 8.2, 13.6)):
        _draw_lines(path, (x, low), (x, high))


def _link(path: QPainterPath) -> None:
    _draw_lines(path, (12, 21), (12, 11))
    path.addEllipse(QPointF(12, 9), 1.6, 1.6)
    for radius in (4.5, 8.0):
        box = QRectF(12 - radius, 9 - radius, 2 * radius, 2 * radius)
        for start in (-50.0, 130.0):
            path.arcMoveTo(box, start)
            path.arcTo(box, start, 100.0)


def _folder(path: QPainterPath) -> None:
    _draw_lines(path, (3, 19), (3, 6), (9, 6), (11, 8.5), (21, 8.5), (21, 19))
    path.closeSubpath()
    _draw_lines(path, (7, 15.5), (9.5, 15.5), (11, 12), (13.2, 17), (14.7, 14.5), (17, 14.5))


def _airplane(path: QPainterPath) -> None:
    right = ((12, 2.5), (13.3, 9), (21.5, 13.6), (21.5, 15.4), (13.3, 13.2), (12.9, 18.2),
             (15.6, 20.2), (15.6, 21.5), (12, 20.6))  # fmt: skip
    left = ((8.4, 21.5), (8.4, 20.2), (11.1, 18.2), (10.7, 13.2), (2.5, 15.4), (2.5, 13.6),
            (10.7, 9), (12, 2.5))  # fmt: skip
    _draw_lines(path, *right, *left)


def _play(path: QPainterPath) -> None:
    _draw_lines(path, (8, 5), (19, 12), (8, 19), (8, 5))


def _pause(path: QPainterPath) -> None:
    path.addRect(QRectF(7, 5, 3.4, 14))
    path.addRect(QRectF(13.6, 5, 3.4, 14))


def _flag(path: QPainterPath) -> None:
    _draw_lines(path, (6, 21), (6, 3.5), (18, 3.5), (15, 8), (18, 12.5), (6, 12.5))


def _panel(path: QPainterPath) -> None:
    path.addRoundedRect(QRectF(3, 4, 18, 16), 2, 2)
    _draw_lines(path, (14.5, 4), (14.5, 20))


_ICON_PATHS: dict[str, Callable[[QPainterPath], None]] = {
    "preflight": _check,
    "flight": _strips,
    "pilot": _pilot,
    "review": _review,
    "gap": _gap,
    "link": _link,
    "folder": _folder,
    "airplane": _airplane,
    "play": _play,
    "pause": _pause,
    "flag": _flag,
    "panel": _panel,
}
_FILLED = frozenset({"play", "pause"})


def paint_icon(painter: QPainter, name: str, box: QRectF, color: QColor) -> None:
    """Draw a sign into a box; signs are designed on 24 by 24."""
    path = QPainterPath()
    _ICON_PATHS[name](path)
    painter.save()
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.translate(box.topLeft())
    painter.scale(box.width() / 24.0, box.height() / 24.0)
    pen = QPen(color, 1.7)
    pen.setCapStyle(Qt.PenCapStyle.RoundCap)
    pen.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
    painter.setPen(pen)
    painter.setBrush(color if name in _FILLED else Qt.BrushStyle.NoBrush)
    painter.drawPath(path)
    painter.restore()


def create_icon(name: str, color: QColor, size: int) -> QIcon:
    """Return a sign as an icon, `size` logical pixels wide."""
    # Fine enough for screens of twice the density.
    pixmap = QPixmap(2 * size, 2 * size)
    pixmap.setDevicePixelRatio(2.0)
    pixmap.fill(Qt.GlobalColor.transparent)
    painter = QPainter(pixmap)
    paint_icon(painter, name, QRectF(0, 0, size, size), color)
    painter.end()
    return QIcon(pixmap)


def paint_indicator(painter: QPainter, state: IndicatorState, box: QRectF, color: QColor) -> None:
    """Draw the shape of a state: disk = good, triangle = caution, square = warning, ring = unknown.

    The shape tells the state without the color.
    """
    painter.save()
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(color)
    if state == "good":
        painter.drawEllipse(box.adjusted(1, 1, -1, -1))
    elif state == "caution":
        painter.drawPolygon(
            QPolygonF([QPointF(box.center().x(), box.top()), box.bottomRight(), box.bottomLeft()])
        )
    elif state == "warning":
        painter.drawRect(box.adjusted(0.5, 0.5, -0.5, -0.5))
    elif state == "unknown":
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setPen(QPen(color, 1.5, Qt.PenStyle.DotLine))
        painter.drawEllipse(box.adjusted(1.5, 1.5, -1.5, -1.5))
    painter.restore()

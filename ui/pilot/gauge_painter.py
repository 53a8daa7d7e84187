"""One gauge: number on the left, bar with the wanted band in cyan on the right."""

from __future__ import annotations

from typing import Final

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPen, QPolygonF

from ui.display_style import DisplayStyle
from ui.pilot.cue_display import Gauge
from ui.pilot.font_fitting import fit_font
from ui.pilot.page_regions import PageRegions

_ALIGN: Final = Qt.AlignmentFlag
_NUMBER_SHARE: Final = 0.36
"""Share of the width for the number."""
_MIN_FONT_SIZE: Final = 9
_MAX_TITLE_FONT_SIZE: Final = 24
"""Pixels of the letters of its title, at most; times the scale of the window."""
TITLE_SHARE: Final = 0.22
"""Share of the height for its title."""


def paint_gauge(
    painter: QPainter, look: DisplayStyle, gauge: Gauge, box: QRectF, places: PageRegions
) -> None:
    """Draw a gauge into a box."""
    high = box.height()
    left = QRectF(box.left(), box.top(), _NUMBER_SHARE * box.width(), high)
    title, number = places.split_title(left, TITLE_SHARE)
    _paint_text(
        painter, look, gauge.title, title, round(_MAX_TITLE_FONT_SIZE * look.sizes.scale), "muted"
    )
    _paint_number(painter, look, gauge, number)
    if gauge.low is None or gauge.high is None:
        return
    right = box.adjusted(left.width() + 0.02 * box.width(), 0, 0, 0)
    words = right.adjusted(0, 0, 0, -0.68 * high)
    _paint_text(painter, look, f"{gauge.target_text} {gauge.unit}", words, 400, "target", bold=True)
    track = right.adjusted(0, 0.46 * high, 0, -0.1 * high)
    _paint_track(painter, look, gauge, track)


def _paint_number(painter: QPainter, look: DisplayStyle, gauge: Gauge, box: QRectF) -> None:
    """Draw number and unit; the number's room is as wide as three figures, so nothing jitters."""
    high = box.height()
    room = QRectF(box.left(), box.top() - 0.15 * high, 0.72 * box.width(), 1.3 * high)
    widest = max(gauge.number, "000", key=len)
    painter.setPen(look.color("text"))
    painter.setFont(fit_font(widest, room, round(0.95 * high), _MIN_FONT_SIZE, bold=True))
    painter.drawText(room, _ALIGN.AlignVCenter | _ALIGN.AlignLeft, gauge.number)
    taken = painter.fontMetrics().horizontalAdvance(widest)
    unit = box.adjusted(taken + 0.03 * box.width(), 0.36 * high, 0, 0)
    _paint_text(painter, look, gauge.unit, unit, round(0.42 * high), "muted")


def _paint_track(painter: QPainter, look: DisplayStyle, gauge: Gauge, box: QRectF) -> None:
    """Draw the bar, the wanted band, and a marker where the value is."""
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(look.color("chosen"))
    painter.drawRect(box)
    low, high = _bar_position(gauge.low, box), _bar_position(gauge.high, box)
    band = QRectF(low, box.top(), high - low, box.height())
    cyan = look.color("target")
    soft = QColor(cyan)
    soft.setAlphaF(0.35)
    painter.setBrush(soft)
    painter.drawRect(band)
    painter.setPen(QPen(cyan, max(0.06 * box.height(), 2.0)))
    painter.drawLine(band.topLeft(), band.bottomLeft())
    painter.drawLine(band.topRight(), band.bottomRight())
    if gauge.marker is not None:
        _paint_marker(painter, look, gauge.marker, box)


def _paint_marker(painter: QPainter, look: DisplayStyle, at: float, box: QRectF) -> None:
    """Draw where the value is; beyond the bar it is an arrow at its end."""
    ink = look.color("text")
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(ink)
    side = 0.5 * box.height()
    if 0.0 <= at <= 1.0:
        x = _bar_position(at, box)
        thick = max(0.16 * box.height(), 4.0)
        top = box.top() - 0.22 * box.height()
        painter.drawRect(QRectF(x - thick / 2, top, thick, 1.36 * box.height()))
        return
    way = 1.0 if at > 1.0 else -1.0
    tip = box.right() if at > 1.0 else box.left()
    middle = box.center().y()
    painter.drawPolygon(
        QPolygonF(
            [
                QPointF(tip, middle),
                QPointF(tip - way * 1.4 * side, middle - side),
                QPointF(tip - way * 1.4 * side, middle + side),
            ]
        )
    )


def _bar_position(share: float | None, box: QRectF) -> float:
    return box.left() + min(max(share or 0.0, 0.0), 1.0) * box.width()


def _paint_text(
    painter: QPainter,
    look: DisplayStyle,
    words: str,
    box: QRectF,
    largest: int,
    role: str,
    *,
    bold: bool = False,
) -> None:
    painter.setPen(look.color(role))
    top = max(min(largest, round(0.9 * box.height())), _MIN_FONT_SIZE)
    painter.setFont(fit_font(words, box, top, _MIN_FONT_SIZE, bold=bold))
    painter.drawText(box, _ALIGN.AlignVCenter | _ALIGN.AlignLeft, words)

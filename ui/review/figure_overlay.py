"""What is painted over a finished figure: rings around what is chosen, words, stand-ins."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFontMetricsF, QImage, QPainter, QPen

from ui.display_style import DisplayStyle
from ui.review.figure_geometry import ManeuverPoint, Subplot, ViewRange

_RING_RADIUS, _FOCUS_RADIUS = 7, 10
"""Points from a chosen point to its ring, and to that where the keyboard stands."""


def paint_selection(
    painter: QPainter,
    chosen: Sequence[ManeuverPoint],
    current: ManeuverPoint | None,
    look: DisplayStyle,
) -> None:
    """Ring the points of the chosen maneuver and write its name beside each."""
    painter.save()
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    for spot in chosen:
        here = current is not None and current.subplot_index == spot.subplot_index
        radius = look.px(_FOCUS_RADIUS if here else _RING_RADIUS)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        # A light ring within a dark one is seen on every color.
        painter.setPen(QPen(look.color("panel"), look.px(4)))
        painter.drawEllipse(QPointF(spot.x, spot.y), radius, radius)
        painter.setPen(QPen(look.color("accent"), look.px(3 if here else 2)))
        painter.drawEllipse(QPointF(spot.x, spot.y), radius, radius)
        _paint_name(painter, spot, radius, look, strong=here)
    painter.restore()


def _paint_name(
    painter: QPainter, spot: ManeuverPoint, radius: float, look: DisplayStyle, *, strong: bool
) -> None:
    font = look.font("label", strong=strong)
    metrics = QFontMetricsF(font)
    room = look.px(3)
    wide = metrics.horizontalAdvance(spot.maneuver) + 2 * room
    high = metrics.height()
    left = spot.x + radius + room
    if left + wide > painter.device().width() / painter.device().devicePixelRatioF():
        left = spot.x - radius - room - wide
    box = QRectF(left, spot.y - high / 2, wide, high)
    painter.fillRect(box, _with_alpha(look.color("panel"), 0.85))
    painter.setFont(font)
    painter.setPen(look.color("text"))
    painter.drawText(box, Qt.AlignmentFlag.AlignCenter, spot.maneuver)


def _with_alpha(color: QColor, share: float) -> QColor:
    color.setAlphaF(share)
    return color


def paint_transformed(
    painter: QPainter, image: QImage, pane: Subplot, view: ViewRange, look: DisplayStyle
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
    painter.fillRect(box, look.color("panel"))
    painter.drawImage(QRectF(first, last), image, source)
    painter.restore()


def paint_message(painter: QPainter, box: QRectF, words: str, look: DisplayStyle) -> None:
    """Write why there is no figure."""
    painter.setFont(look.font("body"))
    painter.setPen(look.color("text"))
    margin = look.px(32)
    inner = box.adjusted(margin, margin, -margin, -margin)
    flags = Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap
    painter.drawText(inner, int(flags), words)


def paint_busy(painter: QPainter, box: QRectF, words: str, look: DisplayStyle) -> None:
    """Say in the corner what is being done."""
    font = look.font("label", strong=True)
    metrics = QFontMetricsF(font)
    wide, high = metrics.horizontalAdvance(words) + look.px(16), metrics.height() + look.px(6)
    chip = QRectF(box.right() - wide - look.px(8), box.top() + look.px(6), wide, high)
    painter.save()
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(look.color("banner"))
    painter.drawRoundedRect(chip, look.px(4), look.px(4))
    painter.setFont(font)
    painter.setPen(look.color("banner_text"))
    painter.drawText(chip, Qt.AlignmentFlag.AlignCenter, words)
    painter.restore()

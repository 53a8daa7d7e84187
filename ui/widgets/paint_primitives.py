"""Small things that the page's own controls draw alike."""

from __future__ import annotations

from PySide6.QtCore import QPointF, QRect, QRectF, QSizeF, Qt
from PySide6.QtGui import QColor, QFontMetricsF, QPainter, QPen

from ui.display_style import DisplayStyle, mix_colors
from ui.theme import Theme, contrast

_LEVEL_SHARES = (0.0, 0.10, 0.22, 0.38)
"""How far each level of the map lies from the background to the trace's blue; the last is full."""
_READOUT_ALPHA = 0.92


def paint_focus_frame(painter: QPainter, box: QRect, style: DisplayStyle) -> None:
    """Draw the frame that says where the keyboard is."""
    pen = QPen(style.color("accent"))
    pen.setWidth(2)
    painter.setPen(pen)
    painter.setBrush(Qt.BrushStyle.NoBrush)
    painter.drawRect(QRectF(box).adjusted(1, 1, -1, -1))


def paint_readout(
    painter: QPainter, plot: QRectF, at: QPointF, text: str, style: DisplayStyle
) -> None:
    """Draw the cursor of a figure in a plot, and beside it the values in a box."""
    painter.save()
    painter.setPen(QPen(style.color("muted"), 1, Qt.PenStyle.DotLine))
    painter.drawLine(QPointF(at.x(), plot.top()), QPointF(at.x(), plot.bottom()))
    painter.drawLine(QPointF(plot.left(), at.y()), QPointF(plot.right(), at.y()))
    font = style.font("label")
    metrics, gap = QFontMetricsF(font), style.px(6)
    lines = text.splitlines()
    wide = max(map(metrics.horizontalAdvance, lines), default=0.0) + 2 * gap
    box = QRectF(QPointF(), QSizeF(wide, len(lines) * metrics.lineSpacing() + gap))
    # Right of the pointer and above it; on the other side where there is no room.
    right, above = at.x() + 2 * gap, at.y() - gap - box.height()
    box.moveLeft(right if right + wide <= plot.right() else max(at.x() - 2 * gap - wide, 0.0))
    box.moveTop(above if above >= plot.top() else at.y() + 2 * gap)
    back = style.color("panel")
    back.setAlphaF(_READOUT_ALPHA)
    painter.setPen(QPen(style.color("axis"), 1))
    painter.setBrush(back)
    painter.drawRect(box)
    painter.setFont(font)
    painter.setPen(style.color("text"))
    inner = box.adjusted(gap, gap / 2, -gap, 0)
    painter.drawText(inner, Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignTop, text)
    painter.restore()


def curve_color(style: DisplayStyle, name: str) -> QColor:
    """Return the color of a curve."""
    if name in style.theme.traces or name == "previous":
        return QColor(style.theme.trace(name))
    return style.color(name)


def level_colors(theme: Theme, level: int) -> tuple[str, str]:
    """Return fill and text of a level of the map, 0 (noise) to 4, always readable."""
    full = theme.traces["blue"]
    fill = (
        full
        if level >= len(_LEVEL_SHARES)
        else mix_colors(theme.plot, full, _LEVEL_SHARES[level]).name()
    )
    text = max((theme.text, theme.background, theme.plot), key=lambda ink: contrast(fill, ink))
    return fill, text


def level_brushes(style: DisplayStyle, level: int) -> tuple[QColor, QColor]:
    """Return fill and text of a level in the look's theme."""
    fill, text = level_colors(style.theme, level)
    return QColor(fill), QColor(text)

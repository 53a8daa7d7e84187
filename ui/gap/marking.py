"""Small things that the page's own controls draw alike."""

from __future__ import annotations

from PySide6.QtCore import QRect, QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPen

from ui.look import Look, mixed
from ui.theme import Theme, contrast

_SHARES = (0.0, 0.10, 0.22, 0.38)
"""How far each level of the map lies from the background to the trace's blue; the last is full."""


def focus_frame(painter: QPainter, box: QRect, look: Look) -> None:
    """Draw the frame that says where the keyboard is."""
    pen = QPen(look.color("accent"))
    pen.setWidth(2)
    painter.setPen(pen)
    painter.setBrush(Qt.BrushStyle.NoBrush)
    painter.drawRect(QRectF(box).adjusted(1, 1, -1, -1))


def ink(look: Look, name: str) -> QColor:
    """Return the color of a curve."""
    if name in look.theme.traces or name == "previous":
        return QColor(look.theme.trace(name))
    return look.color(name)


def level_colors(theme: Theme, level: int) -> tuple[str, str]:
    """Return fill and text of a level of the map, 0 (noise) to 4, always readable."""
    full = theme.traces["blue"]
    fill = full if level >= len(_SHARES) else mixed(theme.plot, full, _SHARES[level]).name()
    text = max((theme.text, theme.background, theme.plot), key=lambda ink: contrast(fill, ink))
    return fill, text


def level_fill(look: Look, level: int) -> tuple[QColor, QColor]:
    """Return fill and text of a level in the look's theme."""
    fill, text = level_colors(look.theme, level)
    return QColor(fill), QColor(text)

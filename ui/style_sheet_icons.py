"""Small pictures for the style sheet, which takes them from files only: drawn, then written."""

from __future__ import annotations

import tempfile
from functools import cache
from pathlib import Path

from PySide6.QtCore import QPointF, Qt
from PySide6.QtGui import QColor, QImage, QPainter, QPen

from ui.display_style import DisplayStyle

_ICON_POLYLINES = {
    "arrow_down": ((5, 9), (12, 16), (19, 9)),
    "arrow_left": ((15, 5), (8, 12), (15, 19)),
    "arrow_right": ((9, 5), (16, 12), (9, 19)),
    "arrow_up": ((5, 15), (12, 8), (19, 15)),
    "check": ((5, 12.5), (10, 17.5), (19, 7)),
}


class StyleSheetIcons:
    """Writes the pictures in the colors of a theme into a folder of their own, gone at exit."""

    def __init__(self) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="gsapp-signs-")

    def paths(self, look: DisplayStyle) -> dict[str, str]:
        found: dict[str, str] = {}
        for name, points in _ICON_POLYLINES.items():
            color = look.color("background" if name == "check" else "text")
            path = Path(self._folder.name) / f"{name}-{color.name()[1:]}.png"
            if not path.exists():
                _draw(points, color).save(str(path))
            found[name] = path.as_posix()
        return found


@cache
def style_sheet_icons() -> StyleSheetIcons:
    """Return those of this process: windows of one look then have one style sheet."""
    return StyleSheetIcons()


def _draw(points: tuple[tuple[float, float], ...], color: QColor) -> QImage:
    image = QImage(48, 48, QImage.Format.Format_ARGB32_Premultiplied)
    image.fill(Qt.GlobalColor.transparent)
    painter = QPainter(image)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.scale(2, 2)
    pen = QPen(color, 2.6)
    pen.setCapStyle(Qt.PenCapStyle.RoundCap)
    pen.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
    painter.setPen(pen)
    painter.drawPolyline([QPointF(x, y) for x, y in points])
    painter.end()
    return image

"""Which parts of the charts a repaint is about."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import cast

from PySide6.QtCore import QRect
from PySide6.QtGui import QPainter, QRegion

from ui.strips.chart_geometry import PixelBox


class RepaintRegion:
    """The region of a repaint, asked part by part.

    Parameters
    ----------
    painter : QPainter
        Set up for whole pixels of the screen.
    region : QRegion
        In pixels of the design.
    density : float
        Pixels of the screen to one of the design.
    """

    def __init__(self, painter: QPainter, region: QRegion, density: float) -> None:
        self._painter = painter
        self._density = density
        # Numbers are far quicker than a question to the region for each of many small boxes.
        self._parts = [
            (part.left(), part.top(), part.right() + 1, part.bottom() + 1)
            for part in cast(Iterable[QRect], region)  # the stub has no __iter__
        ]

    def intersects(self, box: PixelBox) -> bool:
        """Return whether some of a box is to be painted."""
        # A pixel of the design that two parts share does not make both of them new.
        left, top = math.ceil(box.x / self._density), math.ceil(box.y / self._density)
        right = max(math.floor(box.right / self._density), left + 1)
        bottom = max(math.floor(box.bottom / self._density), top + 1)
        for part in self._parts:
            if left < part[2] and part[0] < right and top < part[3] and part[1] < bottom:
                return True
        return False

    def is_within(self, box: PixelBox) -> bool:
        """Return whether nothing outside of a box is to be painted."""
        left, top = box.x / self._density, box.y / self._density
        right, bottom = box.right / self._density, box.bottom / self._density
        return all(
            left <= part[0] and part[2] <= right and top <= part[1] and part[3] <= bottom
            for part in self._parts
        )

    def clip_to(self, box: PixelBox) -> bool:
        """Confine the painter to a box; return whether some of it is to be painted.

        Within a clip of several rectangles every stroke of the painter is many times as dear.
        Cut down to a part, the clip is a single one.
        """
        if not self.intersects(box):
            return False
        self._painter.setClipRect(QRect(box.x, box.y, box.width, box.height))
        return True

    def exposed_columns(self, box: PixelBox) -> tuple[int, int]:
        """Return first and one past the last column of a box to be painted, from its left edge.

        Unlike in `intersects`, the columns it shares with its neighbors count: one of them may be
        all that changed.
        """
        top, bottom = box.y / self._density, box.bottom / self._density
        spans = [
            (math.floor(part[0] * self._density), math.ceil(part[2] * self._density))
            for part in self._parts
            if part[1] < bottom and part[3] > top
        ]
        first = min((span[0] for span in spans), default=box.right) - box.x
        last = max((span[1] for span in spans), default=box.x) - box.x
        return max(first, 0), min(last, box.width)

"""The crosshair of a figure by keys."""

from __future__ import annotations

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QWidget

_STEPS = {
    Qt.Key.Key_Left: (-0.02, 0.0), Qt.Key.Key_Right: (0.02, 0.0),
    Qt.Key.Key_Up: (0.0, -0.02), Qt.Key.Key_Down: (0.0, 0.02),
}  # fmt: skip
"""Shares of width and height of the plot."""


class CrosshairKeys:
    """C shows or hides the crosshair with its values, arrows move it.

    The values become the accessible description of `figure` for that time.
    """

    def __init__(self, figure: QWidget) -> None:
        self.is_on = False  # Whether keys, not the mouse, hold the crosshair.
        self._figure = figure
        self._description = ""  # Of the figure itself.

    def describe(self, values: str) -> None:
        """Say the values at the crosshair, or what the figure shows where it is hidden."""
        self._figure.setAccessibleDescription(values if self.is_on else self._description)

    def move(
        self, event: QKeyEvent, plot: QRectF, pointer: QPointF | None
    ) -> tuple[bool, QPointF | None]:
        """Return whether a key is for the crosshair, and its position after the key."""
        key = Qt.Key(event.key())
        if event.modifiers() & ~Qt.KeyboardModifier.KeypadModifier:
            return False, pointer
        if key == Qt.Key.Key_C:
            self.is_on = not self.is_on
            if self.is_on:
                self._description = self._figure.accessibleDescription()
            return True, plot.center() if self.is_on else None
        if not self.is_on or pointer is None or key not in _STEPS:
            return False, pointer
        across, down = _STEPS[key]
        x = pointer.x() + across * plot.width()
        y = pointer.y() + down * plot.height()
        return True, QPointF(
            min(max(x, plot.left() + 1.0), plot.right() - 1.0),
            min(max(y, plot.top() + 1.0), plot.bottom() - 1.0),
        )

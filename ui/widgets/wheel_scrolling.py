"""The wheel, and two fingers on a touchpad: which way they turn, and how far."""

from __future__ import annotations

import math

from PySide6.QtCore import Qt
from PySide6.QtGui import QWheelEvent

_WHEEL_STEP = 120.0
"""Angle of one notch of a common wheel, eighths of a degree; touchpads send a few at a time."""


def scroll_steps(event: QWheelEvent) -> tuple[float, float]:
    """Return how far one scrolls along and how far up, notches; the smaller of both is none.

    Two fingers never move quite straight. Shift turns up into along.
    """
    along, up = event.angleDelta().x() / _WHEEL_STEP, event.angleDelta().y() / _WHEEL_STEP
    if abs(along) >= abs(up):
        up = 0.0
    else:
        along = 0.0
    if event.modifiers() & Qt.KeyboardModifier.ShiftModifier:
        return along or up, 0.0
    return along, up


class WheelStepCounter:
    """Adds up small turns to whole notches."""

    def __init__(self) -> None:
        self._rest = 0.0

    def add(self, notches: float) -> int:
        """Return the whole notches that are full with this turn; turning back starts anew."""
        if notches * self._rest < 0:
            self._rest = 0.0
        self._rest, full = math.modf(self._rest + notches)
        return int(full)

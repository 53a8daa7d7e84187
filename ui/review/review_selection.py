"""What is chosen in the review: one maneuver, one derivative; chosen anywhere, shown everywhere."""

from __future__ import annotations

from PySide6.QtCore import QObject, Signal


class ReviewSelection(QObject):
    """The maneuver and the derivative that are looked at; every page shows and sets them."""

    maneuver_changed = Signal(str)
    derivative_changed = Signal(str)
    """Said once for each change."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.maneuver = ""
        """Id as in a campaign, ``2:M4``; with one flight, ``M4``. Empty for none."""
        self.derivative = ""
        """``Cm_alpha``; empty for none."""

    def select_maneuver(self, maneuver: str) -> None:
        if maneuver != self.maneuver:
            self.maneuver = maneuver
            self.maneuver_changed.emit(maneuver)

    def select_derivative(self, derivative: str) -> None:
        if derivative != self.derivative:
            self.derivative = derivative
            self.derivative_changed.emit(derivative)

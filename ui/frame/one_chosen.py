"""Buttons of which one is chosen: the places of the window, the steps of a page."""

from __future__ import annotations

from PySide6.QtCore import QObject, Qt
from PySide6.QtWidgets import QAbstractButton, QButtonGroup


class OneChosen(QButtonGroup):
    """Buttons of which Tab stops at the chosen one; arrows lead to the others.

    Left to itself Qt stops at the first, and from then on at the one that had the keyboard last:
    not at the place that is on screen.
    """

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self.buttonToggled.connect(_stop_at)

    def add(self, button: QAbstractButton) -> None:
        """Add a button that is not chosen yet."""
        self.addButton(button)
        _stop_at(button, chosen=False)


def _stop_at(button: QAbstractButton, chosen: bool) -> None:
    others = button.focusPolicy() & ~Qt.FocusPolicy.TabFocus
    button.setFocusPolicy(others | Qt.FocusPolicy.TabFocus if chosen else others)

"""Buttons of which one is chosen: the places of the window, the steps of a page."""

from __future__ import annotations

from PySide6.QtCore import QObject, Qt
from PySide6.QtWidgets import QAbstractButton, QButtonGroup


class ExclusiveButtonGroup(QButtonGroup):
    """Buttons of which Tab stops at the chosen one; arrows lead to the others.

    Left to itself Qt stops at the first, and from then on at the one that had the keyboard last:
    not at the place that is on screen.
    """

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self.buttonToggled.connect(_set_tab_stop)

    def add_button(self, button: QAbstractButton) -> None:
        """Add a button that is not chosen yet."""
        self.addButton(button)
        _set_tab_stop(button, chosen=False)


def _set_tab_stop(button: QAbstractButton, chosen: bool) -> None:
    others = button.focusPolicy() & ~Qt.FocusPolicy.TabFocus
    button.setFocusPolicy(others | Qt.FocusPolicy.TabFocus if chosen else others)

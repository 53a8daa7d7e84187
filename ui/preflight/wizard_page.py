"""The calibration wizard: one big number, one action at a time, keys only."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QVBoxLayout, QWidget

from ui.desk import Desk
from ui.look import Look
from ui.pages import CenteredPage, label
from ui.preflight.prompter import Prompter, Silence
from ui.settings import SettingsStore


class WizardPage(QWidget):
    """Leads through the calibration of surfaces, vanes and instruments.

    Parameters
    ----------
    look : Look
        Colors, sizes, units.
    store : SettingsStore
        Remembers who calibrates and what is in force.
    desk : Desk
        The open flight, whose volts are watched.
    prompter : Prompter, optional
        Speaks and sounds; nobody by default.

    Attributes
    ----------
    changed : Signal
        Other actions are possible now, or another certificate is in force.
    """

    changed = Signal()

    def __init__(
        self, look: Look, store: SettingsStore, desk: Desk, prompter: Prompter | None = None
    ) -> None:
        super().__init__()
        self._look = look
        self._store = store
        self._desk = desk
        self._prompter = prompter or Silence()
        self.setAccessibleName("Calibration")
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        self._empty = CenteredPage(look, 640)
        self._empty.column.addWidget(label("Calibration", "title"))
        column.addWidget(self._empty)

    def begin(self) -> None:
        """Put the keyboard where one goes on."""
        self.setFocus()

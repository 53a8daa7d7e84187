"""What the pages of the steps have in common."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QWidget

from ui.commands import Need
from ui.look import Look

if TYPE_CHECKING:
    from ui.preflight.books import Books


class StepPage(QWidget):
    """The page of one step.

    Parameters
    ----------
    look : Look
        Colors, sizes, units.
    name : str
        For those who hear it.

    Attributes
    ----------
    changed : Signal
        Other commands are of use, or the step stands differently.
    """

    changed = Signal()

    def __init__(self, look: Look, name: str) -> None:
        super().__init__()
        self.look = look
        self.setAccessibleName(name)

    @property
    def present(self) -> tuple[Need, ...]:
        """Return what commands may act on here, beside going from step to step."""
        return ()

    @property
    def can_undo(self) -> bool:
        """Return whether there is a change to take back."""
        return False

    @property
    def can_redo(self) -> bool:
        """Return whether there is a change to make again."""
        return False

    def begin(self) -> None:
        """Put the keyboard where one goes on."""
        raise NotImplementedError

    def follow(self, books: Books) -> None:
        """Show what belongs to another flight."""
        raise NotImplementedError

    def refresh(self) -> None:
        """Show what changed beside this page; called while it is on screen."""

    def flush(self) -> None:
        """Write what is still being typed."""

    def undo(self) -> None:
        """Take back the last change made here."""

    def redo(self) -> None:
        """Make again what was taken back."""

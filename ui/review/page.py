"""What the pages of the review have in common."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QWidget

from ui.commands import Need
from ui.frame.steps import StepState
from ui.look import Look

if TYPE_CHECKING:
    from gsapp.identification.runs.outcome import Outcome

FORMER_RUNS = 4
"""Runs looked at before that are kept, to be compared with."""


class ReviewPage(QWidget):
    """One chapter of the review.

    Parameters
    ----------
    look : Look
        Colors, sizes, units.
    name : str
        For those who hear it.

    Attributes
    ----------
    changed : Signal
        Other commands are of use, or the chapter stands differently.
    """

    changed = Signal()

    def __init__(self, look: Look, name: str) -> None:
        super().__init__()
        self.look = look
        self.setAccessibleName(name)

    @property
    def handlers(self) -> Mapping[str, Callable[[], object]]:
        """Return what the commands of this page do."""
        return {}

    @property
    def present(self) -> tuple[Need, ...]:
        """Return what commands may act on here, beside going from chapter to chapter."""
        return ()

    @property
    def state(self) -> StepState:
        """Return how the chapter stands, for the row of chapters."""
        return StepState(state="plain")

    @property
    def can_undo(self) -> bool:
        """Return whether there is a change to take back."""
        return False

    @property
    def can_redo(self) -> bool:
        """Return whether there is a change to make again."""
        return False

    def undo(self) -> None:
        """Take back the last change made here."""

    def redo(self) -> None:
        """Make again what was taken back."""

    def begin(self) -> None:
        """Put the keyboard where one goes on."""
        raise NotImplementedError

    def refresh(self) -> None:
        """Show what changed on the other pages."""

    def show_open(self, path: Path | None) -> None:
        """Say which flight is open in the window; None for none."""

    def show_outcome(self, outcome: Outcome | None) -> None:
        """Show the run that is looked at; None where there is none."""

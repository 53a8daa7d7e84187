"""What the pages of places that lead from step to step have in common, and those places."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QWidget

from ui.commands import CommandRequirement
from ui.display_style import DisplayStyle


class AbstractStepPage(QWidget):
    """One step or chapter of a place.

    Parameters
    ----------
    display_style : DisplayStyle
        Colors, sizes, units.
    name : str
        For those who hear it.

    Attributes
    ----------
    changed : Signal
        Other commands are of use, or the step stands differently.
    """

    changed = Signal()

    def __init__(self, look: DisplayStyle, name: str) -> None:
        super().__init__()
        self.display_style = look
        self.setAccessibleName(name)

    @property
    def present(self) -> tuple[CommandRequirement, ...]:
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

    def undo(self) -> None:
        """Take back the last change made here."""

    def redo(self) -> None:
        """Make again what was taken back."""

    def begin(self) -> None:
        """Put the keyboard where one goes on."""
        raise NotImplementedError

    def refresh(self) -> None:
        """Show what changed beside this page."""


class MultiStepPage(QWidget):
    """A place that shows one page at a time, and whose undo is that of the page on screen."""

    @property
    def step_page(self) -> AbstractStepPage | None:
        """Return the page on screen; None where there is none that can be undone."""
        raise NotImplementedError

    @property
    def shown(self) -> bool:
        """Return whether the place is on screen, so that its keys are meant."""
        return self.isVisible()

    @property
    def can_undo(self) -> bool:
        """Return whether there is a change to take back on the page on screen."""
        page = self.step_page
        return page is not None and page.can_undo

    def undo(self) -> None:
        """Take back the last change on the page on screen."""
        page = self.step_page
        if page is not None:
            page.undo()

    def redo(self) -> None:
        """Make again what was taken back."""
        page = self.step_page
        if page is not None:
            page.redo()

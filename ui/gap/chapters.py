"""What the four steps of the story have in common."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QVBoxLayout, QWidget

from ui.gap.request import Answer
from ui.gap.selection import Selection
from ui.look import Look


class ChapterView(QWidget):
    """One step of the story.

    Parameters
    ----------
    look : Look
        Colors, sizes, units.

    Attributes
    ----------
    selected : Signal(object)
        What to look at instead, a `Selection`.
    """

    selected = Signal(object)

    def __init__(self, look: Look) -> None:
        super().__init__()
        self.look = look
        self.answer: Answer | None = None
        self.selection = Selection()
        self.column = QVBoxLayout(self)
        self.column.setContentsMargins(0, 0, 0, 0)

    def show_answer(self, answer: Answer, selection: Selection) -> None:
        """Show an answer, or another part of it."""
        self.answer, self.selection = answer, selection
        self.refresh()

    def refresh(self) -> None:
        """Draw what is chosen."""
        raise NotImplementedError

    def begin(self) -> None:
        """Put the keyboard where it is of most use."""
        raise NotImplementedError

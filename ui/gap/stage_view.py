"""What the four steps of the story have in common."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QVBoxLayout, QWidget

from ui.display_style import DisplayStyle
from ui.gap.gap_selection import GapSelection
from ui.gap.search_request import SearchResult


class StageView(QWidget):
    """One step of the story."""

    selection_requested = Signal(object)
    """What to look at instead, a `GapSelection`."""

    def __init__(self, look: DisplayStyle) -> None:
        super().__init__()
        self.look = look
        self.result: SearchResult | None = None
        self.selection = GapSelection()
        self.column = QVBoxLayout(self)
        self.column.setContentsMargins(0, 0, 0, 0)

    def show_result(self, result: SearchResult, selection: GapSelection) -> None:
        """Show a result, or another part of it."""
        self.result, self.selection = result, selection
        self.refresh()

    def refresh(self) -> None:
        raise NotImplementedError

    def begin(self) -> None:
        raise NotImplementedError

"""What the pages of the steps have in common."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ui.frame.page import Page

if TYPE_CHECKING:
    from ui.preflight.books import Books


class StepPage(Page):
    """The page of one step."""

    def follow(self, books: Books) -> None:
        """Show what belongs to another flight."""
        raise NotImplementedError

    def flush(self) -> None:
        """Write what is still being typed."""

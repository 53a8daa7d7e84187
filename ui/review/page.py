"""What the pages of the review have in common."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from ui.commands import key_text
from ui.frame.page import Page
from ui.frame.steps import StepState

if TYPE_CHECKING:
    from gsapp.identification.runs.outcome import Outcome

FORMER_RUNS = 4
"""Runs looked at before that are kept, to be compared with."""
NO_RUN = (
    f"No run is looked at yet. On the page Estimate ({key_text('Alt+2')}) run what you choose, or "
    "press Enter on a kept run;"
)
"""What to do on a page that shows a run; why goes after it."""


class ReviewPage(Page):
    """One chapter of the review."""

    @property
    def handlers(self) -> Mapping[str, Callable[[], object]]:
        """Return what the commands of this page do."""
        return {}

    @property
    def state(self) -> StepState:
        """Return how the chapter stands, for the row of chapters."""
        return StepState(state="plain")

    def show_open(self, path: Path | None) -> None:
        """Say which flight is open in the window; None for none."""

    def show_outcome(self, outcome: Outcome | None) -> None:
        """Show the run that is looked at; None where there is none."""

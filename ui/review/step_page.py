"""What the pages of the review have in common."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ui.commands import shortcut_text
from ui.translation import tr
from ui.window_frame.page_steps import StepStatus
from ui.window_frame.step_page import AbstractStepPage

if TYPE_CHECKING:
    from gsapp.identification.runs.run_execution import RunOutcome

PREVIOUS_RUN_COUNT = 4
"""Runs looked at before that are kept, to be compared with."""


def no_run_text(why: str) -> str:
    """Return what to do on a page that shows a run, and why."""
    return tr(
        "No run selected. On the Estimate page ({keys}) start an estimate, or press Enter on a "
        "saved run; {why}"
    ).format(keys=shortcut_text("Alt+2"), why=why)


class ReviewStepPage(AbstractStepPage):
    """One chapter of the review."""

    @property
    def state(self) -> StepStatus:
        """Return how the chapter stands, for the row of chapters."""
        return StepStatus(state="plain")

    def set_open_flight(self, path: Path | None) -> None:
        """Say which flight is open in the window; None for none."""

    def show_outcome(self, outcome: RunOutcome | None) -> None:
        """Show the run that is looked at; None where there is none."""

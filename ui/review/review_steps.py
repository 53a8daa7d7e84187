"""The four chapters of the review, and what all of them look at."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QAction

from ui.commands import shortcut_text
from ui.display_style import DisplayStyle
from ui.review.review_jobs import JobSubmitter
from ui.settings import SettingsStore
from ui.translation import QT_TR_NOOP, tr
from ui.window_frame.page_steps import PageStep, StepStatus
from ui.window_frame.step_page import AbstractStepPage

if TYPE_CHECKING:
    from gsapp.identification.runs.run_execution import RunOutcome

REVIEW_STEPS = (
    PageStep(
        id="maneuvers",
        title=QT_TR_NOOP("Maneuvers"),
        purpose=QT_TR_NOOP("Detected maneuvers and their limits"),
    ),
    PageStep(
        id="estimate",
        title=QT_TR_NOOP("Estimate"),
        purpose=QT_TR_NOOP("Derivatives with bounds; saved runs"),
    ),
    PageStep(
        id="figures",
        title=QT_TR_NOOP("Figures"),
        purpose=QT_TR_NOOP("Values, fits, histories, linear models"),
    ),
    PageStep(
        id="summary",
        title=QT_TR_NOOP("Summary"),
        purpose=QT_TR_NOOP("Means, outliers, files, report"),
    ),
)
"""In the order in which a crew takes them."""


class ReviewSelection(QObject):
    """The maneuver and the derivative that are looked at; every page shows and sets them."""

    maneuver_changed = Signal(str)
    derivative_changed = Signal(str)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.maneuver = ""
        """Id as in a campaign, ``2:M4``; with one flight, ``M4``. Empty for none."""
        self.derivative = ""
        """``Cm_alpha``; empty for none."""

    def select_maneuver(self, maneuver: str) -> None:
        if maneuver != self.maneuver:
            self.maneuver = maneuver
            self.maneuver_changed.emit(maneuver)

    def select_derivative(self, derivative: str) -> None:
        if derivative != self.derivative:
            self.derivative = derivative
            self.derivative_changed.emit(derivative)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ReviewContext:
    """What all chapters work with: commands, colors, settings, what is chosen, who does jobs."""

    actions: Mapping[str, QAction]
    style: DisplayStyle
    store: SettingsStore
    selection: ReviewSelection
    begin_job: JobSubmitter
    report_error: Callable[[BaseException], None]


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

    def __init__(self, context: ReviewContext, name: str) -> None:
        super().__init__(context.style, name)
        self._actions = context.actions
        self._store = context.store
        self._selection = context.selection

    @property
    def state(self) -> StepStatus:
        return StepStatus(state="plain")

    def set_open_flight(self, path: Path | None) -> None:
        """Say which flight is open in the window; None for none."""

    def show_outcome(self, outcome: RunOutcome | None) -> None:
        """Show the run that is looked at; None where there is none."""

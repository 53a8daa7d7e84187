"""The place Review: four chapters, from the maneuvers of a flight to the report of a campaign."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtGui import QAction, QShowEvent

from ui.commands import CommandRequirement
from ui.display_style import DisplayStyle
from ui.error_reporter import ErrorReporter
from ui.job_process.job_runner import JobRunner
from ui.review.job_queue import JobQueue, create_review_job_runner
from ui.review.onboard_log_controller import OnboardLogController
from ui.review.review_jobs import VirtualFlightJob
from ui.review.review_steps import (
    PREVIOUS_RUN_COUNT,
    REVIEW_STEPS,
    ReviewContext,
    ReviewSelection,
    ReviewStepPage,
)
from ui.settings import SettingsStore, recording_folder, writable_folder
from ui.translation import QT_TR_NOOP, tr
from ui.window_frame.banners import BannerStack
from ui.window_frame.step_page import JobPage, MultiStepPage

if TYPE_CHECKING:
    from gsapp.flight.flight import Flight
    from gsapp.identification.runs.run_execution import RunOutcome
    from gsapp.session.review import Review
    from ui.review.estimate_page import EstimatePage
    from ui.review.maneuvers_page import ManeuversPage


class ReviewPage(MultiStepPage[ReviewStepPage], JobPage):
    """Leads from step to step; long work goes on whatever is on screen.

    Pages are made when they are first seen: a window that only flies does without them.
    """

    prefix = "review"
    setting = "review_chapter"
    all_steps = REVIEW_STEPS
    step_list_name = QT_TR_NOOP("Steps of the review")
    step_command_prefixes = ("review_",)

    def __init__(
        self,
        actions: Mapping[str, QAction],
        style: DisplayStyle,
        store: SettingsStore,
        banners: BannerStack,
        error_reporter: ErrorReporter,
        job_runner: JobRunner | None = None,
    ) -> None:
        super().__init__(tr("Review"), actions, style, store, banners, tr("work"), "review_cancel")
        self._error_reporter = error_reporter
        self._review: Review | None = None
        self._maneuvers_page: ManeuversPage | None = None
        self._estimate_page: EstimatePage | None = None
        self._open: Path | None = None
        self.outcome: RunOutcome | None = None
        self._former: tuple[RunOutcome, ...] = ()
        self.selection = ReviewSelection(self)
        self.work = JobQueue(job_runner or create_review_job_runner(), error_reporter.report, self)
        self.onboard = OnboardLogController(
            style, store, banners, error_reporter.report, self._reviewed, self._opened, self
        )
        self.onboard.log_applied.connect(self._samples_changed)
        self.onboard.changed.connect(self.changed)
        self.work.began.connect(self._show_began)
        self.work.progressed.connect(self._show_progress)
        self.work.ended.connect(self._ended)

    @property
    def own_handlers(self) -> Mapping[str, Callable[[], object]]:
        return {
            "review_cancel": self.cancel,
            "review_trial": self.fly_virtual_flight,
            **self.onboard.handlers,
        }

    @property
    def present(self) -> tuple[CommandRequirement, ...]:
        found: list[CommandRequirement] = ["review_busy"] if self.busy else []
        found += ["review_log"] if self.onboard.work.running else []
        if self.shown and self.onboard.flight_folders:
            found.append("review_folder")
        return (*found, *super().present)

    @property
    def busy(self) -> bool:
        return self.work.running

    # Steps

    def showEvent(self, event: QShowEvent) -> None:
        # The first step opens the flights that all others look at.
        self.get_page("maneuvers")
        super().showEvent(event)

    def refresh(self) -> None:
        for name, page in self.pages.items():
            self.steps.show_state(name, page.state)

    def make_page(self, step_id: str) -> ReviewStepPage:
        page = self._make(step_id)
        page.show_outcome(self.outcome)
        page.set_open_flight(self._open)
        return page

    def _make(self, step_id: str) -> ReviewStepPage:
        context = ReviewContext(
            actions=self._actions, style=self._style, store=self._store, selection=self.selection,
            begin_job=self.work.submit, report_error=self._error_reporter.report,
        )  # fmt: skip
        if step_id == "maneuvers":
            from ui.review.maneuvers_page import ManeuversPage

            maneuvers = ManeuversPage(context, self.review)
            maneuvers.maneuvers_changed.connect(self._maneuvers_changed)
            self._maneuvers_page = maneuvers
            return maneuvers
        if step_id == "estimate":
            from ui.review.estimate_page import EstimatePage

            estimate = EstimatePage(context, self.review)
            estimate.estimated.connect(self.show_outcome)
            self._estimate_page = estimate
            return estimate
        if step_id == "figures":
            from ui.review.figures_page import FiguresPage

            figures = FiguresPage(context)
            figures.exclusion_changed.connect(self._means_changed)
            for former in self._former:
                figures.show_outcome(former)
            return figures
        from ui.review.summary_page import SummaryPage

        return SummaryPage(context)

    @property
    def review(self) -> Review:
        if self._review is None:
            from gsapp.session.review import Review

            self._review = Review()
        return self._review

    def _maneuvers_changed(self) -> None:
        if self._estimate_page is not None:
            self._estimate_page.refresh()

    def fly_virtual_flight(self) -> None:
        from ui.virtual_flight_simulation import find_virtual_flight_folder

        flights, _why = writable_folder(recording_folder(self._store.current))
        folder = find_virtual_flight_folder(flights, datetime.now().astimezone().date())
        self.work.submit(VirtualFlightJob(folder=folder), lambda _path: self.add_flights([folder]))

    def add_flights(self, flights: Sequence[Path]) -> None:
        self.go_to_step("maneuvers", begin=self.isVisible())
        self._open_flights(flights)

    def _open_flights(self, flights: Sequence[Path]) -> None:
        if self._maneuvers_page is not None:
            self._maneuvers_page.opening.open(flights)

    def _reviewed(self) -> list[Flight]:
        return [one.flight for one in self._review.flights] if self._review is not None else []

    def _opened(self) -> list[Path]:
        return [self._open] if self._open is not None else []

    def _samples_changed(self, path: Path) -> None:
        """Open a flight anew whose on-board log is another now."""
        if path.resolve() in [one.resolve() for one in self.review.paths]:
            self._open_flights([path])

    def set_open_flight(self, path: Path | None) -> None:
        self._open = path
        for page in self.pages.values():
            page.set_open_flight(path)

    def show_outcome(self, outcome: RunOutcome | None) -> None:
        former, self.outcome = self.outcome, outcome
        if former is not None and outcome is not None and former.result is not outcome.result:
            self._former = (*self._former, former)[-PREVIOUS_RUN_COUNT:]
        for page in self.pages.values():
            page.show_outcome(outcome)
        self._page_changed()

    def _means_changed(self, outcome: RunOutcome) -> None:
        self.show_outcome(outcome)
        if self._estimate_page is not None:
            self._estimate_page.run_store.update_means(outcome)

    # Work

    def _ended(self, title: str, how: str) -> None:
        self._show_ended(title, how)
        if how == "done" and not self.isVisible():
            self._banner.show_result(
                tr("{title}: done.").format(title=title), tr("Look (F4)"), self.show_requested.emit
            )

    def cancel(self) -> None:
        """Stop what runs; it may take a moment to put down what it holds."""
        self.work.cancel()
        if self.work.running:
            self._show_progress(None, tr("stopping"))

    @property
    def unfinished_work_title(self) -> tuple[str, ...]:
        return (self.work.title,) if self.work.running else ()

    def close_work(self) -> None:
        self.work.close()
        self.onboard.close()

"""The place Review: four chapters, from the maneuvers of a flight to the report of a campaign."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import Signal
from PySide6.QtGui import QAction, QHideEvent, QResizeEvent, QShowEvent
from PySide6.QtWidgets import QStackedWidget, QVBoxLayout

from ui.commands import COMMANDS, CommandRequirement
from ui.display_style import DisplayStyle
from ui.error_reporter import ErrorReporter
from ui.job_process.job_runner import JobRunner
from ui.review.job_queue import JobQueue, create_review_job_runner
from ui.review.onboard_log_controller import OnboardLogController
from ui.review.review_jobs import VirtualFlightJob
from ui.review.review_selection import ReviewSelection
from ui.review.review_steps import REVIEW_STEPS
from ui.review.step_page import PREVIOUS_RUN_COUNT, ReviewStepPage
from ui.settings import SettingsStore, recording_folder, writable_folder
from ui.window_frame.banners import BannerStack
from ui.window_frame.job_banner import JobBanner
from ui.window_frame.job_progress_panel import JobProgressPanel
from ui.window_frame.step_list import StepList
from ui.window_frame.step_page import MultiStepPage

if TYPE_CHECKING:
    from gsapp.flight.flight import Flight
    from gsapp.identification.runs.outcome import RunOutcome
    from gsapp.session.review import Review


class ReviewPage(MultiStepPage):
    """Leads from chapter to chapter; long work goes on whatever is on screen.

    Pages are made when they are first seen: a window that only flies does without them.

    Parameters
    ----------
    actions : mapping of str to QAction
        The commands.
    look : DisplayStyle
        Colors, sizes, units.
    store : SettingsStore
        Remembers flights, chapter and settings of the estimate.
    banners : BannerStack
        Tells of work while another place is on screen.
    faults : ErrorReporter
        Where errors go.
    engine : JobRunner, optional
        What does the work; a process of its own by default.

    Attributes
    ----------
    show_requested : Signal
        The user wants to see this place.
    changed : Signal
        Other commands are of use now.
    outcome : RunOutcome or None
        The run that is looked at.
    """

    show_requested = Signal()
    changed = Signal()

    def __init__(
        self,
        actions: Mapping[str, QAction],
        look: DisplayStyle,
        store: SettingsStore,
        banners: BannerStack,
        faults: ErrorReporter,
        engine: JobRunner | None = None,
    ) -> None:
        super().__init__()
        self._actions = actions
        self._look = look
        self._store = store
        self._banners = banners
        self._faults = faults
        self._banner = JobBanner(banners, self.cancel)
        self._review: Review | None = None
        self._open: Path | None = None
        self.outcome: RunOutcome | None = None
        self._former: tuple[RunOutcome, ...] = ()
        self.pages: dict[str, ReviewStepPage] = {}
        self.chapter = ""
        self.selection = ReviewSelection(self)
        self.setAccessibleName("Review")
        self.work = JobQueue(engine or create_review_job_runner(), faults.report, self)
        self.onboard = OnboardLogController(
            look, store, banners, faults.report, self._reviewed, self._opened, self
        )
        self.onboard.log_applied.connect(self._samples_changed)
        self.onboard.changed.connect(self.changed)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        self.chapters = StepList(
            actions, look, REVIEW_STEPS, prefix="review", name="Chapters of the review"
        )
        column.addWidget(self.chapters)
        self.strip = JobProgressPanel(look, actions["review_cancel"], "work")
        column.addWidget(self.strip)
        self.stack = QStackedWidget()
        column.addWidget(self.stack, 1)
        self.work.began.connect(self._began)
        self.work.progressed.connect(self._told)
        self.work.ended.connect(self._ended)

    # Commands

    @property
    def handlers(self) -> Mapping[str, Callable[[], object]]:
        """Return what the commands of this place and its pages do."""
        own = {
            f"review_{one.id}": lambda name=one.id: self.go_to_step(name) for one in REVIEW_STEPS
        }
        own |= {
            "review_cancel": self.cancel,
            "review_redo": self.redo,
            "review_trial": self.fly_virtual_flight,
        }
        own |= self.onboard.handlers
        of_pages = {
            command.id: lambda name=command.id: self._on_page(name)
            for command in COMMANDS
            if command.id.startswith("review_") and command.id not in own
        }
        return {**own, **of_pages}

    def _on_page(self, command: str) -> None:
        """Let the page on screen do it, or else the one that can."""
        shown = self.step_page
        for page in (shown, *self.pages.values()):
            if page is not None and command in page.handlers:
                page.handlers[command]()
                return

    @property
    def step_page(self) -> ReviewStepPage | None:
        """Return the page on screen."""
        return self.pages.get(self.chapter)

    @property
    def present(self) -> tuple[CommandRequirement, ...]:
        """Return what commands may act on."""
        found: list[CommandRequirement] = ["review_busy"] if self.work.running else []
        found += ["review_log"] if self.onboard.work.running else []
        page = self.step_page
        if not self.shown or page is None:
            return tuple(found)
        found.append("review")
        if self.onboard.flight_folders:
            found.append("review_folder")
        if page.can_redo:
            found.append("review_future")
        return (*found, *page.present)

    # Pages

    def showEvent(self, event: QShowEvent) -> None:
        """Make the page when it is needed; the strip tells of work from here on."""
        super().showEvent(event)
        self._banner.clear()
        # The first page opens the flights that all others look at.
        self._made("maneuvers")
        self.go_to_step(self.chapter or self._store.current.review_chapter, begin=False)

    def hideEvent(self, event: QHideEvent) -> None:
        """Tell of work that goes on in a banner."""
        super().hideEvent(event)
        if self.work.running:
            self._banner.show(self.strip.title)
        self.changed.emit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Give the room of the chapters to the page where the window is low."""
        super().resizeEvent(event)
        self.chapters.fit(self.window().height())

    def go_to_step(self, chapter: str, *, begin: bool = True) -> None:
        """Go to a chapter by its id."""
        self.stack.setCurrentWidget(self._made(chapter))
        self.chapter = chapter
        self.chapters.show_step(chapter)
        self._store.change(review_chapter=chapter)
        self._page_changed()
        if begin:
            self.begin()

    def begin(self) -> None:
        """Put the keyboard where one goes on."""
        page = self.step_page
        if page is not None:
            page.begin()

    def _made(self, chapter: str) -> ReviewStepPage:
        """Return the page of a chapter, made if it was not seen yet."""
        if chapter not in self.pages:
            page = self._make(chapter)
            page.changed.connect(self._page_changed)
            page.show_outcome(self.outcome)
            page.set_open_flight(self._open)
            self.pages[chapter] = page
            self.stack.addWidget(page)
        return self.pages[chapter]

    def _make(self, chapter: str) -> ReviewStepPage:
        """Make the page of a chapter; what it is made of is loaded with it."""
        look, store = self._look, self._store
        if chapter == "maneuvers":
            from ui.review.maneuvers_page import ManeuversPage

            maneuvers = ManeuversPage(self._actions, look, store, self.selection, self.review)
            maneuvers.maneuvers_changed.connect(self._maneuvers_changed)
            return maneuvers
        if chapter == "estimate":
            from ui.review.estimate_page import EstimatePage

            estimate = EstimatePage(
                self._actions, look, store, self.selection, self.review, self.work.submit,
                self._faults.report,
            )  # fmt: skip
            estimate.estimated.connect(self.show_outcome)
            return estimate
        if chapter == "figures":
            from ui.review.figures_page import FiguresPage

            figures = FiguresPage(self._actions, look, store, self.selection, self.work.submit)
            figures.exclusion_changed.connect(self._means_changed)
            for former in self._former:
                figures.show_outcome(former)
            return figures
        from ui.review.summary_page import SummaryPage

        return SummaryPage(self._actions, look, store, self.selection, self.work.submit)

    @property
    def review(self) -> Review:
        """Return the flights under review; made when they are first needed."""
        if self._review is None:
            from gsapp.session.review import Review

            self._review = Review()
        return self._review

    def _maneuvers_changed(self) -> None:
        """Say on the page of the estimate what a run would take now."""
        estimate = self.pages.get("estimate")
        if estimate is not None:
            estimate.refresh()

    def fly_virtual_flight(self) -> None:
        """Let the virtual aircraft fly, and review that flight."""
        from ui.virtual_flight_simulation import find_virtual_flight_folder

        flights, _why = writable_folder(recording_folder(self._store.current))
        folder = find_virtual_flight_folder(flights, datetime.now().astimezone().date())
        self.work.submit(VirtualFlightJob(folder=folder), lambda _path: self.add_flights([folder]))

    def add_flights(self, flights: Sequence[Path]) -> None:
        """Take flights under review, too, and show where they stand."""
        self.go_to_step("maneuvers", begin=self.isVisible())
        self.pages["maneuvers"].opening.open(flights)

    def _reviewed(self) -> list[Flight]:
        return [one.flight for one in self._review.flights] if self._review is not None else []

    def _opened(self) -> list[Path]:
        return [self._open] if self._open is not None else []

    def _samples_changed(self, path: Path) -> None:
        """Open a flight anew whose on-board log is another now."""
        page = self.pages.get("maneuvers")
        if page is not None and path.resolve() in [one.resolve() for one in self.review.paths]:
            page.opening.open([path])

    def _page_changed(self) -> None:
        for name, page in self.pages.items():
            self.chapters.show_state(name, page.state)
        self.changed.emit()

    def set_open_flight(self, path: Path | None) -> None:
        """Say which flight is open in the window."""
        self._open = path
        for page in self.pages.values():
            page.set_open_flight(path)

    def show_outcome(self, outcome: RunOutcome | None) -> None:
        """Look at another run, on all pages."""
        former, self.outcome = self.outcome, outcome
        if former is not None and outcome is not None and former.result is not outcome.result:
            self._former = (*self._former, former)[-PREVIOUS_RUN_COUNT:]
        for page in self.pages.values():
            page.show_outcome(outcome)
        self._page_changed()

    def _means_changed(self, outcome: RunOutcome) -> None:
        """Look at other means of the same run, and keep them with it."""
        self.show_outcome(outcome)
        estimate = self.pages.get("estimate")
        if estimate is not None:
            estimate.book.update_means(outcome)

    # Work

    def _began(self, title: str) -> None:
        self.strip.begin(title)
        if not self.isVisible():
            self._banner.show(self.strip.title)
        self.changed.emit()

    def _told(self, share: float | None, words: str) -> None:
        self.strip.set_progress(share, words)
        self._banner.set_progress(share, words)

    def _ended(self, title: str, how: str) -> None:
        self.strip.hide()
        self._banner.remove()
        if how == "cancelled":
            self._banners.show_banner("note", f"{title}: stopped.")
        elif how == "done" and not self.isVisible():
            self._banner.show_result(f"{title}: done.", "Look (F4)", self.show_requested.emit)
        self.changed.emit()

    def cancel(self) -> None:
        """Stop what runs; it may take a moment to put down what it holds."""
        self.work.cancel()
        if self.work.running:
            self._told(None, "stopping")

    @property
    def unfinished_work_title(self) -> tuple[str, ...]:
        """Return the title of the work that is not done, if there is one."""
        return (self.work.title,) if self.work.running else ()

    def close_work(self) -> None:
        """Stop everything, as the window closes."""
        self.work.close()
        self.onboard.close()

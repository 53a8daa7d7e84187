"""The place Model gap: what to search, the search that runs, and its result."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import Signal
from PySide6.QtGui import QAction, QShowEvent

from ui.background_job import BackgroundJob, JobProgress
from ui.commands import CommandRequirement
from ui.dialogs.file_dialogs import ask_save_file
from ui.display_style import DisplayStyle
from ui.error_reporter import ErrorReporter
from ui.gap.gap_search import GapSearch, create_search_job_runner
from ui.gap.gap_stages import GAP_STAGES
from ui.job_process.job_runner import JobRunner
from ui.number_format import sanitize_file_name
from ui.settings import SettingsStore, initial_dialog_folder, recording_folder, writable_folder
from ui.translation import QT_TR_NOOP, tr
from ui.undo import UndoHistory
from ui.window_frame.banners import BannerStack
from ui.window_frame.step_page import JobPage

if TYPE_CHECKING:
    from ui.gap.gap_result_view import GapResultView
    from ui.gap.search_setup_page import SearchSetupPage

_REPORT_FILTER = QT_TR_NOOP("Report (*.html);;Report (*.pdf)")
_MODEL_FILTER = QT_TR_NOOP("Model (*.toml)")
_RESULT_VIEW_MODULE = "ui.gap.gap_result_view"


class GapPage(JobPage):
    """Asks, searches, and tells.

    The pages are made when they are first seen: a window that only flies does without them.
    """

    cards_requested = Signal(tuple)
    """Test cards to fly next, of `TestCard`."""

    def __init__(
        self,
        actions: Mapping[str, QAction],
        style: DisplayStyle,
        store: SettingsStore,
        banners: BannerStack,
        error_reporter: ErrorReporter,
        job_runner: JobRunner | None = None,
    ) -> None:
        super().__init__(
            tr("Model gap"), actions, style, store, banners, tr("search"), "gap_cancel"
        )
        self._error_reporter = error_reporter
        self._open: Path | None = None
        self._trial: BackgroundJob | None = None
        self._loading: BackgroundJob | None = None
        self.setup: SearchSetupPage | None = None
        self.result_view: GapResultView | None = None
        self.search = GapSearch(
            job_runner or create_search_job_runner(), error_reporter.report, self
        )
        self.search.began.connect(lambda work: self._show_began(work.title))
        self.search.progressed.connect(self._show_progress)
        self.search.ended.connect(self._ended)
        self.search.changed.connect(self._show_search_result)
        self.search.written.connect(self._written)

    # Commands

    @property
    def handlers(self) -> Mapping[str, Callable[[], object]]:
        chapters = {
            f"gap_{chapter.id}": lambda name=chapter.id: self._with_result_view(
                lambda s: s.go_to_stage(name)
            )
            for chapter in GAP_STAGES
        }
        return {
            **chapters,
            "gap_search": self.show_setup,
            "gap_cancel": self.cancel,
            "gap_step_back": lambda: self._with_result_view(lambda s: s.move_step(-1)),
            "gap_step_on": lambda: self._with_result_view(lambda s: s.move_step(1)),
            "gap_previous_maneuver": lambda: self._with_result_view(lambda s: s.next_maneuver(-1)),
            "gap_next_maneuver": lambda: self._with_result_view(lambda s: s.next_maneuver(1)),
            "gap_accept": lambda: self._with_result_view(lambda s: s.move_step(1)),
            "gap_refuse": self.refuse_effect,
            "gap_force": self.force_effect,
            "gap_save": self.save_model,
            "gap_report": self.write_report,
            "gap_cards": self.add_cards,
        }

    def _with_result_view(self, act: Callable[[GapResultView], object]) -> None:
        if self.result_view is not None and self.search.result is not None:
            act(self.result_view)

    @property
    def is_result_shown(self) -> bool:
        """Return whether a result is on screen, so that its keys are meant."""
        return (
            self.shown
            and self.result_view is not None
            and self.stack.currentWidget() is self.result_view
        )

    @property
    def undo_history(self) -> UndoHistory | None:
        return self.search.undo_stack if self.is_result_shown and not self.busy else None

    def undo(self) -> None:
        if self.undo_history is not None:
            self.undo_history.undo()

    def redo(self) -> None:
        if self.undo_history is not None:
            self.undo_history.redo()

    @property
    def busy(self) -> bool:
        return self.search.running or (self._trial is not None and self._trial.is_running)

    @property
    def present(self) -> tuple[CommandRequirement, ...]:
        found: list[CommandRequirement] = ["search"] if self.busy else []
        result_view = self.result_view
        if result_view is None or not self.is_result_shown:
            return tuple(found)
        found.append("gap")
        if result_view.can_accept:
            found.append("gap_next")
        if self.busy:
            return tuple(found)
        found.append("gap_idle")
        if result_view.chosen_effect and not self._is_refused(result_view.chosen_effect):
            found.append("gap_effect")
        if result_view.experiment is not None:
            found.append("gap_cards")
        return tuple(found)

    def _is_refused(self, effect: str) -> bool:
        result = self.search.result
        return result is not None and effect in result.request.refused

    # Pages

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self._setup_page()
        self.changed.emit()

    def _setup_page(self) -> SearchSetupPage:
        if self.setup is None:
            from ui.gap.search_setup_page import SearchSetupPage

            self.setup = SearchSetupPage(self._style, self._store)
            self.setup.search_requested.connect(self.search.search)
            self.setup.virtual_flight_requested.connect(self.fly_virtual_flight)
            self.setup.back_requested.connect(self._show_result_view)
            self.setup.command_requested.connect(lambda name: self._actions[name].trigger())
            self.setup.set_open_flight(self._open)
            self.stack.addWidget(self.setup)
        return self.setup

    def _get_result_view(self) -> GapResultView:
        if self.result_view is None:
            from ui.gap.gap_result_view import GapResultView

            self.result_view = GapResultView(self._actions, self._style, self._store)
            self.result_view.step_changed.connect(self.changed)
            self.stack.addWidget(self.result_view)
        return self.result_view

    def set_open_flight(self, path: Path | None) -> None:
        self._open = path
        if self.setup is not None:
            self.setup.set_open_flight(path)

    def set_initial_focus(self) -> None:
        page = self.stack.currentWidget()
        if self.setup is not None and page is self.setup:
            self.setup.set_initial_focus()
        elif self.result_view is not None and page is self.result_view:
            self.result_view.set_initial_focus()

    def show_setup(self) -> None:
        self.show_requested.emit()
        page = self._setup_page()
        page.show_state(busy=self.busy, answered=self.search.result is not None)
        self.stack.setCurrentWidget(page)
        page.set_initial_focus()
        self.changed.emit()

    def add_flights(self, flights: Sequence[Path]) -> None:
        self.show_setup()
        for path in flights:
            self._setup_page().add_flight(path)

    def _show_result_view(self) -> None:
        if self.result_view is not None and self.search.result is not None:
            self.stack.setCurrentWidget(self.result_view)
            self.result_view.set_initial_focus()
            self.changed.emit()

    # The search

    def _load(self) -> None:
        """Load in a thread what the result will be drawn with, once: it takes a second."""
        if self.result_view is None and self._loading is None:
            self._loading = BackgroundJob(
                tr("Loading the page"),
                lambda _progress: importlib.import_module(_RESULT_VIEW_MODULE),
                self,
            )
            self._loading.failed.connect(self._error_reporter.report)
            self._loading.start()

    def _show_began(self, title: str) -> None:
        self._load()
        if self.setup is not None:
            self.setup.show_state(busy=True, answered=self.search.result is not None)
        super()._show_began(title)

    def _ended(self, how: str) -> None:
        if self.setup is not None:
            self.setup.show_state(busy=False, answered=self.search.result is not None)
        self._show_ended(self.search.title, how)

    def _show_search_result(self) -> None:
        result = self.search.result
        if result is None:
            return
        result_view = self._get_result_view()
        result_view.show_result(result)
        had_focus = self.isVisible()
        self.stack.setCurrentWidget(result_view)
        if had_focus:
            result_view.set_initial_focus()
        else:
            text = result.discrepancy.why or tr("The search has ended.")
            self._banner.show_result(text, tr("Look (F5)"), self.show_requested.emit)
        self.changed.emit()

    def cancel(self) -> None:
        self.search.cancel()
        if self._trial is not None:
            self._trial.cancel()

    @property
    def unfinished_work_title(self) -> tuple[str, ...]:
        return (self.search.title,) if self.search.running else ()

    def close_search(self) -> None:
        if self._trial is not None:
            self._trial.cancel()
        self.search.close()

    def fly_virtual_flight(self) -> None:
        if self.busy:
            return
        from ui.virtual_flight_simulation import (
            find_virtual_flight_folder,
            simulate_virtual_flight,
        )

        flights, _why = writable_folder(recording_folder(self._store.current))
        folder = find_virtual_flight_folder(flights, datetime.now().astimezone().date())

        def run(progress: JobProgress) -> Path:
            return simulate_virtual_flight(folder, progress)

        work = BackgroundJob(tr("Flying the virtual aircraft"), run, self)
        self._trial = work
        work.progressed.connect(self._show_progress)
        work.done.connect(self._search_trial_flight)
        work.canceled.connect(lambda: self._ended("stopped"))
        work.failed.connect(self._trial_failed)
        work.start()
        self._show_began(work.title)

    def _search_trial_flight(self, folder: Path) -> None:
        from ui.virtual_flight_simulation import BASELINE_MODEL, SIMULATED_AIRCRAFT

        self._ended("flown")
        self._setup_page().set_flight(folder, SIMULATED_AIRCRAFT, BASELINE_MODEL)

    def _trial_failed(self, error: BaseException) -> None:
        self._ended("failed")
        self._error_reporter.report(error)

    # Decisions

    def refuse_effect(self) -> None:
        result = self.search.result
        if self.result_view is None or result is None:
            return
        effect = self.result_view.chosen_effect
        if effect:
            self.search.refuse(effect, result.title(effect))

    def force_effect(self) -> None:
        result = self.search.result
        if self.result_view is None or result is None:
            return
        from ui.gap.add_and_show import ForceEffectDialog
        from ui.gap.gap_view_models import list_forceable_effects

        choices = list_forceable_effects(result, self.result_view.selection.step)
        dialog = ForceEffectDialog(self._style, choices, self)
        if dialog.exec() and dialog.selected_effect is not None:
            self.search.force(dialog.selected_effect.effect, dialog.selected_effect.title)

    def add_cards(self) -> None:
        """Ask for the deciding maneuvers among the test cards."""
        if self.result_view is not None and self.result_view.experiment is not None:
            self.cards_requested.emit(self.result_view.experiment.cards)

    # Files

    def save_model(self) -> None:
        result, result_view = self.search.result, self.result_view
        if result is None or result_view is None:
            return
        from gsapp.dynamics.model import save_model

        model = result_view.selected_model
        start = (
            initial_dialog_folder(self._store.current)
            / f"{sanitize_file_name(model.name) or 'model'}.toml"
        )
        path = ask_save_file(self, tr("Save the model"), start, tr(_MODEL_FILTER))
        if path is not None:
            written = save_model(model, path)
            self._banners.show_banner(
                "note", tr("The model is saved as {written}.").format(written=written)
            )

    def write_report(self) -> None:
        result = self.search.result
        if result is None:
            return
        name = result.request.flights[0].stem if result.request.flights else "flight"
        start = initial_dialog_folder(self._store.current) / f"{name} model gap.html"
        path = ask_save_file(self, tr("Write the report"), start, tr(_REPORT_FILTER))
        if path is not None:
            self.search.write_report(path, self._style.units)

    def _written(self, path: Path) -> None:
        from PySide6.QtCore import QUrl
        from PySide6.QtGui import QDesktopServices

        self._banners.show_banner(
            "note",
            tr("The report is written: {path}.").format(path=path),
            (tr("Open it"), lambda: QDesktopServices.openUrl(QUrl.fromLocalFile(str(path)))),
        )

"""The place Preflight: flight card, calibration, checklist and test cards, each a page."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

from PySide6.QtCore import Signal
from PySide6.QtGui import QAction, QHideEvent

from gsapp.foundation import GroundStationError
from ui.commands import shortcut_text
from ui.display_style import DisplayStyle
from ui.error_reporter import ErrorReporter
from ui.flight_controller import FlightController
from ui.preflight.preflight_steps import PREFLIGHT_STEPS, PreflightStepPage
from ui.settings import SettingsStore, next_flight_path
from ui.translation import QT_TR_NOOP, tr
from ui.window_frame.banners import BannerStack
from ui.window_frame.step_page import AbstractStepPage, MultiStepPage

if TYPE_CHECKING:
    from gsapp.flight.cards import TestCard
    from ui.preflight.preflight_model import PreflightModel
    from ui.preflight.wizard_controller import Prompter
    from ui.preflight.wizard_page import WizardPage


class PreflightPage(MultiStepPage[AbstractStepPage]):
    """Leads a crew from step to step.

    Pages and what they hold are made when they are first seen: a window that only flies does
    without them.
    """

    prefix = "preflight"
    setting = "preflight_step"
    all_steps = PREFLIGHT_STEPS
    step_list_name = QT_TR_NOOP("Steps before the flight")
    step_command_prefixes = ("checklist_", "cards_")
    flight_started = Signal()

    def __init__(
        self,
        actions: Mapping[str, QAction],
        style: DisplayStyle,
        store: SettingsStore,
        banners: BannerStack,
        error_reporter: ErrorReporter,
        controller: FlightController,
        prompter: Prompter | None = None,
    ) -> None:
        super().__init__(tr("Preflight"), actions, style, store)
        self._banners = banners
        self._error_reporter = error_reporter
        self._controller = controller
        self._prompter = prompter
        self._model: PreflightModel | None = None
        self._wizard_page: WizardPage | None = None
        controller.changed.connect(self._flight_changed)
        controller.refreshed.connect(self.refresh)

    @property
    def own_handlers(self) -> Mapping[str, Callable[[], object]]:
        return {"preflight_start": self.start_flight}

    # Steps

    def hideEvent(self, event: QHideEvent) -> None:
        self.flush()
        super().hideEvent(event)

    def go_to_step(self, step_id: str, *, begin: bool = True) -> None:
        if step_id != self.step:
            self.flush()
        super().go_to_step(step_id, begin=begin)

    def make_page(self, step_id: str) -> AbstractStepPage:
        if step_id == "calibration":
            from ui.preflight.wizard_page import WizardPage

            self._wizard_page = WizardPage(
                self._style, self._store, self._controller, self._prompter
            )
            return self._wizard_page
        page: PreflightStepPage
        if step_id == "card":
            from ui.preflight.flight_card_page import FlightCardPage

            page = FlightCardPage(self._style, self._error_reporter.report)
        elif step_id == "checklist":
            from ui.preflight.checklist_page import ChecklistPage

            page = ChecklistPage(self._style, self._actions, self._error_reporter.report)
        else:
            from ui.preflight.cards_page import CardsPage

            page = CardsPage(self._style, self._actions, self._store, self._error_reporter.report)
        page.set_model(self.model)
        return page

    @property
    def model(self) -> PreflightModel:
        """Return what the steps work on; made when it is first needed."""
        if self._model is None:
            from ui.preflight.preflight_model import PreflightModel

            self._model = PreflightModel(self._store)
            self._set_session(self._model)
        return self._model

    def _set_session(self, model: PreflightModel) -> None:
        try:
            model.set_session(self._controller.session)
        except GroundStationError as error:
            self._error_reporter.report(error)

    # What happens

    def _flight_changed(self) -> None:
        """Another flight is open, or none: its card and checklist are meant from here on."""
        if self._model is None:
            return
        self.flush()
        self._set_session(self._model)
        for page in self.pages.values():
            if isinstance(page, PreflightStepPage):
                page.set_model(self._model)
        self.refresh()
        self.changed.emit()

    def _page_changed(self) -> None:
        if self.step == "calibration":
            self.model.read_calibration()
        self._show_states()
        self.changed.emit()

    def refresh(self) -> None:
        """Show what changed beside the pages; nothing while another place is on screen."""
        if not self.shown or not self.step:
            return
        self.model.update_checklist()
        page = self.step_page
        if page is not None:
            page.refresh()
        self._show_states()

    def _show_states(self) -> None:
        for step_id, state in self.model.step_states().items():
            self.steps.show_state(step_id, state)

    def flush(self) -> None:
        """Write what is still being typed, as the window closes or another place is shown."""
        page = self.step_page
        if page is not None:
            page.flush()

    @property
    def is_practice(self) -> bool:
        return self._wizard_page is not None and self._wizard_page.practice.running

    def close_calibration(self) -> None:
        """Let go of a calibration that runs, which can be resumed, and of practice."""
        if self._wizard_page is not None:
            self._wizard_page.close_run()
            self._wizard_page.practice.stop()

    def add_cards(self, cards: Sequence[TestCard]) -> None:
        """Put test cards before all others: of the live flight, else of the next one."""
        from ui.preflight.card_set_model import CardSetModel

        session = self._controller.session
        target = self.model.cards
        if self._controller.is_replay:
            # What was flown has its cards.
            session, target = None, CardSetModel()
            target.set_flight(None, next_flight_path(self._store.path), self.model.aircraft)
        try:
            ids = target.insert_first(cards)
            if session is not None and target.cards is not None:
                session.crew_cues.set_cards(target.cards)
                session.crew_cues.select_card(ids[0])
        except GroundStationError as error:
            self._error_reporter.report(error)
            return
        for page in self.pages.values():
            if isinstance(page, PreflightStepPage):
                page.set_model(self.model)
        names = ", ".join(ids)
        if session is not None:
            text = tr("Next on the Pilot page: {names}.").format(names=names)
        else:
            text = tr("Added to the test cards of the next flight: {names}.").format(names=names)
        self._banners.show_banner("note", text)

    def start_flight(self) -> None:
        """Record that the flight begins, as the checklist stands, and go to the charts."""
        text = ""
        try:
            text = self.model.checklist.record_start()
        except GroundStationError as error:
            self._error_reporter.report(error)
        if text:
            green = self.model.checklist.state.state == "good"
            self._banners.show_banner("note" if green else "caution", text)
            self.flight_started.emit()
        else:
            self._banners.show_banner(
                "note",
                tr(
                    "No flight to start: connect the aircraft first ({keys}). "
                    "The card and the checklist go into its folder."
                ).format(keys=shortcut_text("Ctrl+L")),
            )

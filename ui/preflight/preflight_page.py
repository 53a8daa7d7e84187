"""The place Preflight: flight card, calibration, checklist and test cards, each a page."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import Signal
from PySide6.QtGui import QAction, QHideEvent, QResizeEvent, QShowEvent
from PySide6.QtWidgets import QStackedWidget, QVBoxLayout, QWidget

from gsapp.foundation import GroundStationError
from ui.commands import CommandRequirement, shortcut_text
from ui.display_style import DisplayStyle
from ui.error_reporter import ErrorReporter
from ui.flight_controller import FlightController
from ui.preflight.preflight_steps import PREFLIGHT_STEPS
from ui.preflight.step_page import PreflightStepPage
from ui.settings import SettingsStore
from ui.window_frame.banners import BannerStack
from ui.window_frame.step_list import StepList
from ui.window_frame.step_page import MultiStepPage

if TYPE_CHECKING:
    from ui.preflight.preflight_model import PreflightModel
    from ui.preflight.prompter import Prompter
    from ui.preflight.wizard_page import WizardPage


class PreflightPage(MultiStepPage):
    """Leads a crew from step to step.

    Pages and what they hold are made when they are first seen: a window that only flies does
    without them.

    Parameters
    ----------
    actions : mapping of str to QAction
        The commands.
    look : DisplayStyle
        Colors, sizes, units.
    store : SettingsStore
        Remembers the step that was looked at; beside it lies what waits for the next flight.
    banners : BannerStack
        Tells what went wrong.
    faults : ErrorReporter
        Where errors go.
    desk : FlightController
        The open flight.
    prompter : Prompter, optional
        Speaks and sounds while the crew looks at the aircraft.

    Attributes
    ----------
    changed : Signal
        Other commands are of use now.
    flight_started : Signal
        The crew says that the flight begins.
    """

    changed = Signal()
    flight_started = Signal()

    def __init__(
        self,
        actions: Mapping[str, QAction],
        look: DisplayStyle,
        store: SettingsStore,
        banners: BannerStack,
        faults: ErrorReporter,
        desk: FlightController,
        prompter: Prompter | None = None,
    ) -> None:
        super().__init__()
        self._actions = actions
        self._look = look
        self._store = store
        self._banners = banners
        self._faults = faults
        self._desk = desk
        self._prompter = prompter
        self._books: PreflightModel | None = None
        self.pages: dict[str, QWidget] = {}
        self.step = ""
        self.setAccessibleName("Preflight")
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        self.steps = StepList(
            actions, look, PREFLIGHT_STEPS, prefix="preflight", name="Steps before the flight"
        )
        column.addWidget(self.steps)
        self.stack = QStackedWidget()
        column.addWidget(self.stack, 1)
        desk.changed.connect(self._flight_changed)
        desk.refreshed.connect(self.refresh)

    # Commands

    @property
    def handlers(self) -> Mapping[str, Callable[[], object]]:
        """Return what the commands of this place do."""
        steps = {
            f"preflight_{step.id}": lambda name=step.id: self.go_to_step(name)
            for step in PREFLIGHT_STEPS
        }
        return {
            **steps,
            "preflight_start": self.start_flight,
            "preflight_redo": self.redo,
            "checklist_tick": lambda: self._on_page(lambda page: page.tick()),
            "checklist_reset": lambda: self._on_page(lambda page: page.reset()),
            "checklist_edit": lambda: self._on_page(lambda page: page.edit()),
            "cards_add": lambda: self._on_page(lambda page: page.add()),
            "cards_remove": lambda: self._on_page(lambda page: page.remove()),
            "cards_up": lambda: self._on_page(lambda page: page.move(-1)),
            "cards_down": lambda: self._on_page(lambda page: page.move(1)),
            "cards_open": lambda: self._on_page(lambda page: page.open()),
            "cards_save": lambda: self._on_page(lambda page: page.save()),
        }

    def _on_page(self, act: Callable[[Any], object]) -> None:
        """Let the page on screen do something; its commands are gray at the others."""
        act(self.pages[self.step])

    @property
    def step_page(self) -> PreflightStepPage | None:
        """Return the page on screen that is made for this place; None at the calibration."""
        page = self.pages.get(self.step)
        return page if isinstance(page, PreflightStepPage) else None

    @property
    def present(self) -> tuple[CommandRequirement, ...]:
        """Return what commands may act on."""
        if not self.shown:
            return ()
        page = self.step_page
        own = page.present if page is not None else ()
        redo: tuple[CommandRequirement, ...] = (
            ("preflight_future",) if page is not None and page.can_redo else ()
        )
        return ("preflight", *redo, *own)

    # Pages

    def showEvent(self, event: QShowEvent) -> None:
        """Make the page when it is needed."""
        super().showEvent(event)
        self.go_to_step(self.step or self._store.current.preflight_step, begin=False)

    def hideEvent(self, event: QHideEvent) -> None:
        """Write what is still being typed; other commands are of use now."""
        super().hideEvent(event)
        self.flush()
        self.changed.emit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Give the room of the steps to the page where the window is low."""
        super().resizeEvent(event)
        self.steps.fit(self.window().height())

    def go_to_step(self, step_id: str, *, begin: bool = True) -> None:
        """Go to a step by its id."""
        if step_id != self.step:
            self.flush()
        if step_id not in self.pages:
            page = self._make(step_id)
            self.pages[step_id] = page
            self.stack.addWidget(page)
        self.step = step_id
        self.stack.setCurrentWidget(self.pages[step_id])
        self.steps.show_step(step_id)
        self._store.change(preflight_step=step_id)
        self.refresh()
        if begin:
            self.begin()
        self.changed.emit()

    def begin(self) -> None:
        """Put the keyboard where one goes on."""
        if self.step:
            self.pages[self.step].begin()

    def _make(self, step_id: str) -> QWidget:
        """Make the page of a step; what it is made of is loaded with it."""
        page: WizardPage | PreflightStepPage
        if step_id == "calibration":
            from ui.preflight.wizard_page import WizardPage

            page = WizardPage(self._look, self._store, self._desk, self._prompter)
        elif step_id == "card":
            from ui.preflight.flight_card_page import FlightCardPage

            page = FlightCardPage(self._look, self._faults.report)
            page.set_model(self.model)
        elif step_id == "checklist":
            from ui.preflight.checklist_page import ChecklistPage

            page = ChecklistPage(self._look, self._actions, self._faults.report)
            page.set_model(self.model)
        else:
            from ui.preflight.cards_page import CardsPage

            page = CardsPage(self._look, self._actions, self._store, self._faults.report)
            page.set_model(self.model)
        page.changed.connect(self._page_changed)
        return page

    @property
    def model(self) -> PreflightModel:
        """Return what the steps work on; made when it is first needed."""
        if self._books is None:
            from ui.preflight.preflight_model import PreflightModel

            self._books = PreflightModel(self._store)
            self._follow(self._books)
        return self._books

    def _follow(self, books: PreflightModel) -> None:
        try:
            books.set_session(self._desk.session)
        except GroundStationError as error:
            self._faults.report(error)

    # What happens

    def _flight_changed(self) -> None:
        """Another flight is open, or none: its card and checklist are meant from here on."""
        if self._books is None:
            return
        self.flush()
        self._follow(self._books)
        for page in self.pages.values():
            if isinstance(page, PreflightStepPage):
                page.set_model(self._books)
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
        """Return whether the flight that is open is for practice."""
        page = self.pages.get("calibration")
        return page is not None and page.practice.running

    def close_calibration(self) -> None:
        """Let go of a calibration that runs, which can be resumed, and of practice."""
        page = self.pages.get("calibration")
        if page is not None:
            page.close_run()
            page.practice.stop()

    def start_flight(self) -> None:
        """Record that the flight begins, as the checklist stands, and go to the charts."""
        words = ""
        try:
            words = self.model.checklist.record_start()
        except GroundStationError as error:
            self._faults.report(error)
        if words:
            green = self.model.checklist.state.state == "good"
            self._banners.show_banner("note" if green else "caution", words)
            self.flight_started.emit()
        else:
            self._banners.show_banner(
                "note",
                "There is no flight to start: connect the aircraft first "
                f"({shortcut_text('Ctrl+L')}). The card and what was ticked go into its folder.",
            )

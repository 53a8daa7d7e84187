"""The calibration wizard: one big number, one action at a time, keys only."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, get_args

from PySide6.QtCore import QEvent, QModelIndex, Qt, QTimer
from PySide6.QtGui import QHideEvent, QKeyEvent, QKeySequence, QShowEvent
from PySide6.QtWidgets import QApplication, QLineEdit, QStackedWidget, QVBoxLayout

from calibration.plan import InstrumentKind
from calibration.wizard import CalibrationWizard, WizardAction, has_unfinished_calibration
from calibration.wizard.procedure import WizardActionKind
from calibration.wizard.state import CalibrationMode
from gsapp.foundation import GroundStationError
from gsapp.quantities import convert_text_units
from ui.display_style import DisplayStyle
from ui.flight_controller import FlightController
from ui.preflight.calibration_controller import (
    CalibrationController,
    CalibrationFolder,
    CertificatePrinter,
    current_local_time,
)
from ui.preflight.practice_bench import PracticeBench
from ui.preflight.question_bar import CalibrationQuestions, QuestionBar
from ui.preflight.wizard_calibration_panel import WizardCalibrationPanel
from ui.preflight.wizard_controller import Prompter, SilentPrompter, WizardController
from ui.preflight.wizard_panels import WizardStartPanel, WizardSummaryPanel
from ui.preflight.wizard_rows import (
    list_combined_deflections,
    list_instrument_statuses,
    list_outcomes,
)
from ui.preflight.wizard_text import (
    PRACTICE_ACTION,
    PRINT_ACTION,
    build_start_actions,
    build_wizard_actions,
)
from ui.settings import SettingsStore
from ui.translation import tr
from ui.widgets.action_button import ActionBar, ActionItem
from ui.window_frame.step_page import AbstractStepPage

if TYPE_CHECKING:
    from calibration.plan import CalibrationPlan
    from calibration.wizard import WizardView

_HAND_MOVED_KINDS: Sequence[InstrumentKind] = ("surface", "vane")
_INSTRUMENT_KINDS: Sequence[InstrumentKind] = ("gyro", "accelerometer", "pressure")
_ACTION_KINDS: Mapping[str, WizardActionKind] = {kind: kind for kind in get_args(WizardActionKind)}
_KEY_ALIASES = {Qt.Key.Key_Return: Qt.Key.Key_Space, Qt.Key.Key_Enter: Qt.Key.Key_Space}
_UNDO = QKeySequence("Ctrl+Z")
_FIT_ORDER_KEYS = {Qt.Key.Key_0: None, Qt.Key.Key_1: 1, Qt.Key.Key_2: 2, Qt.Key.Key_3: 3}
_ARROW_STEPS = {Qt.Key.Key_Up: -1, Qt.Key.Key_Down: 1}


class WizardPage(AbstractStepPage):
    """Leads through the calibration of surfaces, vanes and instruments."""

    def __init__(
        self,
        style: DisplayStyle,
        store: SettingsStore,
        controller: FlightController,
        prompter: Prompter | None = None,
    ) -> None:
        super().__init__(style, tr("Calibration"))
        self._style = style
        self._store = store
        self._controller = controller
        self._prompter = prompter or SilentPrompter()
        self._choice: int | None = None
        self._left = self._made = False
        self.practice = PracticeBench(controller)
        self._calibration = CalibrationController(controller, store, self.practice)
        self.certificate_printer = CertificatePrinter(controller)
        self.run: WizardController | None = None
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        self.start = WizardStartPanel(style)
        self.start.instruments.calibration_requested.connect(self._calibrate_guarded)
        self.start.instruments.selectionModel().selectionChanged.connect(self._show_start_offers)
        self.work = WizardCalibrationPanel(style)
        self.work.point_chosen.connect(self._choose)
        self.summary = WizardSummaryPanel(style)
        self.pages = QStackedWidget()
        for page in (self.start, self.work, self.summary):
            self.pages.addWidget(page)
        column.addWidget(self.pages, 1)
        self.action_bar = ActionBar(style)
        self.question_bar = QuestionBar(style, self.set_initial_focus, self.action_bar)
        column.addWidget(self.question_bar)
        self._questions = CalibrationQuestions(self.question_bar, lambda: style.units)
        self.action_bar.triggered.connect(self._do)
        column.addWidget(self.action_bar)
        controller.changed.connect(self._flight_changed)
        controller.refreshed.connect(self._show_live_deflections)
        style.changed.connect(self._refresh)

    # The place

    def set_initial_focus(self) -> None:
        """Put the keyboard where one goes on."""
        self.setFocus(Qt.FocusReason.OtherFocusReason)

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        if self.run is not None:
            self.run.set_active(True)
        self._refresh()

    def hideEvent(self, event: QHideEvent) -> None:
        super().hideEvent(event)
        if self.run is not None:
            self.run.set_active(False)
        self._calibration.reload_flight()

    def close_run(self) -> None:
        """Let go of the calibration at hand; it can be resumed."""
        if self.run is not None:
            self.run.set_active(False)
            self.run.close()
            self.run.deleteLater()
            self.run = None

    @property
    def folder(self) -> CalibrationFolder:
        return self._calibration.folder

    # Beginning

    def calibrate(self) -> None:
        """Begin with all surfaces and vanes; what was begun before is set aside."""
        self._begin_run(_HAND_MOVED_KINDS)

    def calibrate_instruments(self) -> None:
        """Begin with gyros, accelerometers and pressures."""
        self._begin_run(_INSTRUMENT_KINDS)

    def calibrate_instrument(self, channel: str) -> None:
        """Calibrate one instrument; the others keep their certificates.

        Accelerometers, which share their positions, are calibrated together.
        """
        self._begin(self.folder.load_plan_in_use().select_with_dependencies(channel))

    def _calibrate_guarded(self, channel: str) -> None:
        self._guarded(lambda: self.calibrate_instrument(channel))

    def start_check(self) -> None:
        """Begin the check of a minute: three settings against the certificates in force."""
        self._begin_run(_HAND_MOVED_KINDS, mode="check")

    def _begin_run(self, kinds: Sequence[InstrumentKind], mode: CalibrationMode = "full") -> None:
        self._begin(self.folder.load_plan_in_use().select_kinds(kinds), mode)

    def _begin(self, plan: CalibrationPlan, mode: CalibrationMode = "full") -> None:
        folder = self.folder
        wizard = CalibrationWizard(
            plan,
            folder.store,
            folder.journal,
            who=self.start.operator.text().strip(),
            temperature=self.start.temperature_kelvin,
            now=current_local_time,
            mode=mode,
        )
        self._start_run(wizard, folder)

    def resume(self) -> None:
        """Go on where the calibration stopped, however it stopped."""
        folder = self.folder
        self._start_run(
            CalibrationWizard.resume(folder.journal, folder.store, now=current_local_time), folder
        )

    def _start_run(self, wizard: CalibrationWizard, folder: CalibrationFolder) -> None:
        self.close_run()
        self._choice = None
        run = WizardController(
            wizard, self._controller, self._prompter, self._controller.error_reporter
        )
        run.view_changed.connect(self._show_view)
        run.certificates_changed.connect(lambda: self._certified(folder))
        self.run = run
        run.set_active(self.isVisible())
        self._show_view(run.view)
        self._prompter.say(run.view.spoken)
        self.set_initial_focus()

    def show_start(self) -> None:
        """Go back to the beginning."""
        self.close_run()
        self._calibration.reload_flight()
        self.pages.setCurrentWidget(self.start)
        self._refresh()
        self.set_initial_focus()

    def _certified(self, folder: CalibrationFolder) -> None:
        try:
            self._calibration.apply(folder)
        except GroundStationError as error:
            self._controller.error_reporter.report(error)
        if self.run is not None and self.run.view.instrument is None:
            # The last one: the live numbers are those of today from here on.
            self._calibration.reload_flight()
        self.changed.emit()

    # What is shown

    def _flight_changed(self) -> None:
        self._refresh()
        # Whoever shows the flight elsewhere may have taken the keyboard along.
        QTimer.singleShot(0, self, self._keep_keyboard)

    def _keep_keyboard(self) -> None:
        focus = QApplication.focusWidget()
        if self.isVisible() and not (focus is not None and self.isAncestorOf(focus)):
            self.set_initial_focus()

    def _show_live_deflections(self) -> None:
        if self.isVisible() and self.pages.currentWidget() is self.summary:
            heard = self.run is not None and not self.run.has_no_data
            self.summary.show_deflections(
                list_combined_deflections(
                    self._controller.history if heard else None, self._style.units
                )
            )

    def _refresh(self) -> None:
        if not self.isVisible():
            return
        if self.run is not None:
            self._show_view(self.run.view)
            return
        folder = self.folder
        try:
            standings, who = (
                list_instrument_statuses(folder.load_plan_in_use(), folder),
                folder.last_operator(),
            )
            made = bool(folder.store.in_force())
        except GroundStationError as error:
            self.start.show_statuses(())
            self.start.resume.hide()
            self.start.message.set_message(
                tr("{error}\nCorrect it, then return.").format(error=error), "warning"
            )
            self.action_bar.show_actions((PRACTICE_ACTION,))
            return
        self.start.show_statuses(standings)
        self.start.suggest_operator(who)
        self.start.show_connection(self._controller.session)
        self._left, self._made = has_unfinished_calibration(folder.journal), made
        self.start.resume.setVisible(self._left)
        self.start.resume.set_message(tr("Unfinished calibration: all steps are saved."))
        self._show_start_offers()

    def _show_start_offers(self) -> None:
        """Show what can be begun; the selected instrument first, else what was not finished."""
        if self.run is not None:
            return
        chosen = self.start.instruments.selected_channel
        plan = self.folder.load_plan_in_use().select_with_dependencies(chosen) if chosen else None
        self.action_bar.show_actions(
            build_start_actions(plan, chosen, left=self._left, made=self._made)
        )

    def _show_view(self, view: WizardView) -> None:
        if self._choice is not None and self._choice >= len(view.points):
            self._choice = None
        if view.instrument is None and view.phase in ("done", "aborted"):
            self._calibration.reload_flight()
            plan = self.folder.load_plan_in_use()
            what = tr("Calibration") if view.mode == "full" else tr("Check")
            title = (
                tr("{what} done").format(what=what)
                if view.phase == "done"
                else tr("{what} stopped").format(what=what)
            )
            self.summary.show_outcomes(title, view.prompt, list_outcomes(view, plan))
            self.pages.setCurrentWidget(self.summary)
            closing = ActionItem(id="leave", text=tr("Done"), key="Space", is_default=True)
            others = tuple(one for one in build_wizard_actions(view) if one.id in ("undo", "back"))
            paper = (PRINT_ACTION,) if self.folder.store.in_force() else ()
            self.action_bar.show_actions((closing, *paper, *others))
            return
        units = self._style.units
        view = replace(
            view,
            prompt=convert_text_units(view.prompt, units),
            message=convert_text_units(view.message, units),
        )
        self.practice.return_to_setting(view)
        self.pages.setCurrentWidget(self.work)
        catching_up = self.run is not None and self.run.catching_up
        self.work.show_view(view, self._choice, catching_up=catching_up)
        helping = (ActionItem(id="help", text=tr("Practice: set angle"), key="H"),)
        self.action_bar.show_actions(
            (
                *build_wizard_actions(view)[:1],
                *(helping if self.practice.running else ()),
                *build_wizard_actions(view)[1:],
            )
        )

    def _help(self) -> None:
        if self.run is not None:
            self.practice.assist(self.run.view)

    # What the crew does

    def _choose(self, index: int | None) -> None:
        self._choice = index
        if self.run is not None:
            self._show_view(self.run.view)

    def _step_choice(self, steps: int) -> None:
        view = self.run.view if self.run is not None else None
        if view is None or not view.points:
            return
        last = len(view.points) - 1
        start = last + 1 if self._choice is None else self._choice
        self._choose(min(max(start + steps, 0), last))

    def _do(self, name: str) -> None:
        """Do what a key or a button stands for."""
        own: Mapping[str, Callable[[], object]] = {
            "calibrate": self.calibrate,
            "again": lambda: self.calibrate_instrument(self.start.instruments.selected_channel),
            "others": self.calibrate_instruments,
            "check": self.start_check,
            "resume": self.resume,
            "leave": self.show_start,
            "practice": self.practice.start,
            "paper": lambda: self.certificate_printer.write(self.folder, self._style.units),
            "help": self._help,
        }
        if name in own:
            self._guarded(own[name])
            return
        run = self.run
        if run is None:
            return
        if self._questions.needs_question(name):
            self._questions.ask(name, run)
        elif name == "deny_sign":
            run.perform(WizardAction(kind="confirm_sign", yes=False))
        elif name in ("repeat", "delete"):
            run.perform(WizardAction(kind=_ACTION_KINDS[name], index=self._choice))
            self._choice = None
        else:
            run.perform(WizardAction(kind=_ACTION_KINDS[name]))

    def _guarded(self, act: Callable[[], object]) -> None:
        try:
            act()
        except GroundStationError as error:
            self._controller.error_reporter.report(error)

    # Keys

    def event(self, event: QEvent) -> bool:
        if (
            event.type() == QEvent.Type.ShortcutOverride
            and isinstance(event, QKeyEvent)
            and self._key_action(event) is not None
        ):
            event.accept()
            return True
        return super().event(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        field = self.focusWidget()
        if isinstance(field, QLineEdit) and event.key() in _KEY_ALIASES:
            self.set_initial_focus()
            return
        meaning = self._key_action(event)
        if meaning is None:
            super().keyPressEvent(event)
        else:
            meaning()

    def _key_action(self, event: QKeyEvent) -> Callable[[], object] | None:
        """Return what a key does now; None if it is not for this page."""
        if self.question_bar.is_open:
            return None
        key = Qt.Key(event.key())
        # On macOS the arrows are keys of the keypad.
        modifiers = event.modifiers() & ~Qt.KeyboardModifier.KeypadModifier
        plain = not modifiers
        typed = (
            QKeySequence(_KEY_ALIASES.get(key, key))
            if plain
            else QKeySequence(event.keyCombination())
        )
        for offer in self.action_bar.offers:
            undoes = offer.id == "undo" and typed == _UNDO
            if undoes or (offer.key and typed == QKeySequence(offer.key)):
                return lambda: self._do(offer.id)
        run = self.run
        if run is None:
            return self._start_key_action(key) if plain else None
        if modifiers == Qt.KeyboardModifier.ControlModifier and key in _ARROW_STEPS:
            return lambda: self.work.scroll_pages(0.8 * _ARROW_STEPS[key])
        if not plain:
            return None
        if key in _FIT_ORDER_KEYS and "choose_degree" in run.view.available_actions:
            return lambda: run.perform(
                WizardAction(kind="choose_degree", degree=_FIT_ORDER_KEYS[key])
            )
        if key in _ARROW_STEPS and self.pages.currentWidget() is self.work:
            return lambda: self._step_choice(_ARROW_STEPS[key])
        return None

    def _start_key_action(self, key: Qt.Key) -> Callable[[], object] | None:
        rows = self.start.instruments
        if key in _ARROW_STEPS:
            return lambda: rows.move_selection(_ARROW_STEPS[key])
        if key == Qt.Key.Key_Escape and rows.selected_channel:
            return self._choose_none
        return None

    def _choose_none(self) -> None:
        self.start.instruments.setCurrentIndex(QModelIndex())
        self.set_initial_focus()

"""The place Pilot: the page of the cues, its own window, the debrief, training."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from typing import Final

from PySide6.QtCore import QTimer
from PySide6.QtGui import QAction, QHideEvent, QShowEvent
from PySide6.QtWidgets import QApplication

from gsapp.excitation.announcer import Announcement
from gsapp.excitation.cues import CueSnapshot
from ui.commands import CommandRequirement, shortcut_text
from ui.display_limits import DISPLAY
from ui.display_style import DisplayStyle
from ui.error_reporter import ErrorReporter
from ui.flight_controller import FlightController
from ui.pilot.debrief_controller import DebriefController
from ui.pilot.page_state import FlightCues, PilotPageState
from ui.pilot.pilot_canvas import PilotCanvas
from ui.pilot.pilot_window import PilotWindowController
from ui.pilot.training_flight import StickKeyFilter, TrainingFlight, TrainingStatusLine
from ui.settings import SettingsStore
from ui.translation import QT_TR_NOOP, tr
from ui.voice.speech_queue import UtterancePriority
from ui.voice.voice import Voice
from ui.widgets.action_button import ActionBar, ActionItem
from ui.window_frame.step_page import WindowPage

_ACTION_LABELS: Final[Mapping[str, str]] = {
    "pilot_dismiss": QT_TR_NOOP("Dismiss"),
    "pilot_previous_card": QT_TR_NOOP("Previous card"),
    "pilot_next_card": QT_TR_NOOP("Next card"),
    "pilot_fly_card": QT_TR_NOOP("Fly this card"),
    "pilot_repeat": QT_TR_NOOP("Repeat card"),
    "pilot_any_card": QT_TR_NOOP("Best card"),
    "pilot_sticks": QT_TR_NOOP("Sticks"),
    "pilot_charts": QT_TR_NOOP("Show in charts"),
    "pilot_keep": QT_TR_NOOP("Keep"),
    "pilot_debrief": QT_TR_NOOP("Debrief"),
    "pilot_page": QT_TR_NOOP("In flight"),
    "pilot_window": QT_TR_NOOP("Separate window"),
    "pilot_train": QT_TR_NOOP("Train"),
    "mute": QT_TR_NOOP("Sound"),
}
"""Short words of the commands that have a button."""


def build_page_actions(
    actions: Mapping[str, QAction], *, debrief: bool, looking: bool, sticks: str
) -> tuple[ActionItem, ...]:
    """Return the buttons below the page: what acts now, the most wanted first."""
    # The verdict's button keeps its place without a verdict, so that no other comes under a thumb.
    shown = ["pilot_charts", "pilot_keep"] if debrief else ["pilot_dismiss"]
    if not debrief and actions["pilot_fly_card"].isEnabled():
        shown += ["pilot_previous_card", "pilot_next_card", "pilot_fly_card", "pilot_repeat",
                  "pilot_any_card"]  # fmt: skip
    if sticks:
        shown.insert(0, "pilot_sticks")
    shown.append("pilot_page" if debrief else "pilot_debrief")
    shown += ["pilot_window", "pilot_train", "mute"]
    return tuple(
        ActionItem(
            id=name,
            text=sticks if name == "pilot_sticks" else tr(_ACTION_LABELS[name]),
            # Letters are sticks while a trainee flies: the last key is no letter.
            key=shortcut_text(
                actions[name].shortcuts()[-1 if sticks and name == "mute" else 0].toString()
            ),
            is_default=name == "pilot_fly_card" and looking,
            disabled_reason="" if actions[name].isEnabled() else actions[name].toolTip(),
        )
        for name in shown
    )


_PRIORITY: Final[Mapping[str, UtterancePriority]] = {
    "note": UtterancePriority.NOTE,
    "prompt": UtterancePriority.PROMPT,
    "warning": UtterancePriority.WARNING,
}


class FlightSpeech:
    """Says what is new, and keeps everything else silent while the hands are off."""

    def __init__(self, voice: Voice) -> None:
        self._voice = voice
        self._spoken_count = 0

    def restart(self, spoken: Sequence[Announcement] = ()) -> None:
        """Begin with another flight; what was to be heard of it before is not said."""
        self._spoken_count = len(spoken)
        self._voice.set_quiet(False)

    def speak_new_cues(
        self, cues: CueSnapshot | None, spoken: Sequence[Announcement], *, aloud: bool
    ) -> None:
        """Let be heard what is new."""
        if len(spoken) < self._spoken_count:
            self._spoken_count = 0  # a replay went back
        new, self._spoken_count = spoken[self._spoken_count :], len(spoken)
        under_way = cues.input_in_progress if aloud and cues is not None else None
        self._voice.set_quiet(under_way is not None and under_way.phase == "hands-off")
        if not aloud or cues is None or cues.time is None:
            return
        for one in new:
            if cues.time - one.time > DISPLAY.max_speech_delay:
                continue
            if one.tone:
                self._voice.play_tone(one.tone)
            if one.text:
                self._voice.say(one.text, _PRIORITY[one.priority], through=True)
                if one.tone:
                    # Where there is no voice a common tone has just taken its place.
                    self._voice.play_tone(one.tone)


MIN_REFRESH_INTERVAL: Final = 0.05
"""Seconds between two looks at the cues: they are made anew so often."""


class PilotPage(WindowPage):
    """Shows, speaks, and lets the crew choose."""

    def __init__(
        self,
        actions: Mapping[str, QAction],
        style: DisplayStyle,
        store: SettingsStore,
        error_reporter: ErrorReporter,
        controller: FlightController,
        voice: Voice,
    ) -> None:
        super().__init__(tr("Pilot"), actions, style, store)
        self._controller = controller
        self.cues = FlightCues(lambda: controller.session)
        self.state = PilotPageState(self.cues)
        self.speech = FlightSpeech(voice)
        self.training = TrainingFlight(controller)
        self.own_window = PilotWindowController(self, actions, self._page_handlers, style, store)
        self.debrief = DebriefController(
            self, style, store, error_reporter, controller, self.cues,
            [actions["pilot_charts"], actions["pilot_keep"]],
        )  # fmt: skip
        self._refreshed_at = 0.0
        self._was_opened = False
        self._units = style.units
        self._present: tuple[CommandRequirement, ...] = ()
        self.canvas = PilotCanvas(style)
        self.stack.addWidget(self.canvas)
        self.help = TrainingStatusLine(style)
        self.column.addWidget(self.help)
        self.buttons = ActionBar(style)
        self.buttons.triggered.connect(lambda name: actions[name].trigger())
        self.column.addWidget(self.buttons)
        self._capture = StickKeyFilter(self.training, self.canvas)
        self.training.changed.connect(self._training_changed)
        self.own_window.changed.connect(self.refresh)
        controller.changed.connect(self._flight_changed)
        controller.frame_requested.connect(lambda _until: self._refresh_limited())
        controller.refreshed.connect(self.refresh)
        style.changed.connect(self._restyle)

    # Commands

    @property
    def handlers(self) -> Mapping[str, Callable[[], object]]:
        return {
            "pilot_page": lambda: self.show_page(debrief=False),
            "pilot_debrief": lambda: self.show_page(debrief=True),
            "pilot_window": self.own_window.toggle,
            "pilot_speak": self.toggle_speech,
            **self._page_handlers,
            "pilot_keep": self.debrief.store,
            "pilot_charts": self.debrief.show_in_charts,
            "pilot_train": self.start_training,
            "pilot_sticks": self.training.exchange_control,
        }

    @property
    def _page_handlers(self) -> Mapping[str, Callable[[], object]]:
        state = self.state

        def then_show(act: Callable[[], object]) -> Callable[[], object]:
            def acted() -> None:
                act()
                self.refresh()

            return acted

        return {
            "pilot_previous_card": then_show(lambda: state.step_card(-1)),
            "pilot_next_card": then_show(lambda: state.step_card(1)),
            "pilot_fly_card": then_show(state.select_browsed_card),
            "pilot_repeat": then_show(state.repeat_last_card),
            "pilot_any_card": then_show(state.clear_card_selection),
            "pilot_dismiss": then_show(state.dismiss_verdict),
        }

    @property
    def present(self) -> tuple[CommandRequirement, ...]:
        if not self.shown:
            return ()
        found: list[CommandRequirement] = ["pilot"]
        if self.is_debrief_shown:
            if self.debrief.page is not None and self.debrief.page.current_maneuver is not None:
                found.append("pilot_flown")
            return tuple(found)
        if self.cues.cards is not None:
            found.append("pilot_cards")
        if self.state.shown_verdict_id:
            found.append("pilot_verdict")
        if self.training.running:
            found.append("pilot_training")
        return tuple(found)

    # What the crew does

    def show_page(self, *, debrief: bool) -> None:
        if debrief:
            page = self.debrief.get_page()
            if self.stack.indexOf(page) < 0:
                self.stack.addWidget(page)
            self.stack.setCurrentWidget(page)
            self.debrief.refresh()
            self.debrief.read_trends()
        else:
            self.stack.setCurrentWidget(self.canvas)
        self.refresh()
        self.set_initial_focus()

    @property
    def is_debrief_shown(self) -> bool:
        """Return whether the debrief is on screen, or comes up with the place."""
        return self.stack.currentWidget() is not self.canvas

    def set_initial_focus(self) -> None:
        if self.is_debrief_shown:
            self.debrief.get_page().set_initial_focus()
        else:
            self.canvas.setFocus()

    def start_training(self) -> None:
        if self.training.start():
            self.show_page(debrief=False)
            self.show_requested.emit()

    def _training_changed(self) -> None:
        self.help.show_status(self.training)
        if self.training.trainee_has_control and self.is_debrief_shown:
            self.show_page(debrief=False)
        self.refresh()

    def _sticks_words(self) -> str:
        if not self.training.running:
            return ""
        return tr("You have control") if self.training.trainee_has_control else tr("I have control")

    # Speech

    @property
    def is_speech_enabled(self) -> bool:
        wish = self._store.current.flight_speech
        opened = self._was_opened or self.own_window.window is not None
        return wish == "always" or (wish == "page" and opened)

    def toggle_speech(self) -> None:
        self._store.change(flight_speech="never" if self.is_speech_enabled else "always")
        self.refresh()

    # What happens

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self._was_opened = True
        self.refresh()

    def hideEvent(self, event: QHideEvent) -> None:
        super().hideEvent(event)
        self._present = self.present

    def _update_present(self) -> None:
        present = self.present
        if present != self._present:
            self._present = present
            self.changed.emit()

    def _flight_changed(self) -> None:
        self.state.restart()
        self.speech.restart(self.cues.spoken_cues())
        self.debrief.refresh()
        self.refresh()
        # Whoever shows the flight elsewhere may have taken the keyboard along.
        QTimer.singleShot(0, self, self._keep_keyboard)

    def _keep_keyboard(self) -> None:
        focus = QApplication.focusWidget()
        if self.shown and not (focus is not None and self.isAncestorOf(focus)):
            self.set_initial_focus()

    def _restyle(self) -> None:
        if self._style.units != self._units:
            self._units = self._style.units
            self.cues.set_units(self._units)
        self.refresh()

    def _refresh_limited(self) -> None:
        """Look at the cues as soon as samples came, but not at every one."""
        if time.monotonic() - self._refreshed_at >= MIN_REFRESH_INTERVAL:
            self.refresh()

    def refresh(self) -> None:
        self._refreshed_at = time.monotonic()
        second, aloud = self.own_window.window, self.is_speech_enabled
        watched = self.shown or second is not None
        # A flight that nobody watches here costs nothing.
        cues = self.state.update() if watched or aloud else None
        # While a flight is caught up with, what is to be heard was true a while ago.
        current = self.cues.monitored_fraction() >= 1.0
        self.speech.speak_new_cues(cues, self.cues.spoken_cues(), aloud=aloud and current)
        self._actions["pilot_speak"].setChecked(aloud)
        if watched:
            sheet = self.state.build_display(self._style.units)
            self.canvas.show_display(sheet)
            if second is not None:
                second.canvas.show_display(sheet)
        if self.shown:
            if self.is_debrief_shown:
                self.debrief.refresh(None if cues is None else cues.event_count)
            self._update_present()
            self.buttons.show_actions(
                build_page_actions(
                    self._actions,
                    debrief=self.is_debrief_shown,
                    looking=self.state.is_browsing,
                    sticks=self._sticks_words(),
                )
            )

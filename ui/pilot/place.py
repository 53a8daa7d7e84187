"""The place Pilot: the page of the cues, its own window, the debrief, training."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Final

from PySide6.QtCore import QTimer, Signal
from PySide6.QtGui import QAction, QHideEvent, QShowEvent
from PySide6.QtWidgets import QApplication, QStackedWidget, QVBoxLayout, QWidget

from ui.commands import Need
from ui.desk import Desk
from ui.faults import FaultDesk
from ui.look import Look
from ui.pilot.calm import Calm
from ui.pilot.canvas import PilotCanvas
from ui.pilot.choosing import Choosing, last_card
from ui.pilot.flight_cues import FlightCues
from ui.pilot.key_capture import KeyCapture
from ui.pilot.offers import offers
from ui.pilot.reading import Reading, sheet_of
from ui.pilot.second import PilotWindow
from ui.pilot.speech import FlightSpeech
from ui.pilot.training import Training
from ui.pilot.training_line import TrainingLine
from ui.preflight.action_bar import ActionBar
from ui.settings import SettingsStore
from ui.voice.voice import Voice

if TYPE_CHECKING:
    from ui.pilot.debrief_page import DebriefPage

SOONEST: Final = 0.05
"""Seconds between two looks at the cues: they are made anew so often."""


class PilotPlace(QWidget):
    """Shows, speaks, and lets the crew choose.

    Parameters
    ----------
    actions : mapping of str to QAction
        The commands.
    look : Look
        Colors, sizes, units.
    store : SettingsStore
        Remembers the second window, and whether cues are spoken.
    faults : FaultDesk
        Where errors go.
    desk : Desk
        The open flight.
    voice : Voice
        Is heard.

    Attributes
    ----------
    changed : Signal
        Other commands are of use now.
    wanted : Signal
        The place should be on screen.
    cues : FlightCues
        What is known of the open flight.
    window_of_its_own : PilotWindow or None
        Where it is open.
    """

    changed = Signal()
    wanted = Signal()

    def __init__(
        self,
        actions: Mapping[str, QAction],
        look: Look,
        store: SettingsStore,
        faults: FaultDesk,
        desk: Desk,
        voice: Voice,
    ) -> None:
        super().__init__()
        self._actions = actions
        self._look = look
        self._store = store
        self._faults = faults
        self._desk = desk
        self.cues = FlightCues(desk)
        self.speech = FlightSpeech(voice)
        self._choosing = Choosing()
        self._calm = Calm(time.monotonic)
        self._dismissed = ""
        self._looked = 0.0
        self._was_opened = False
        self._present: tuple[Need, ...] = ()
        self.window_of_its_own: PilotWindow | None = None
        self.debrief: DebriefPage | None = None
        self.setAccessibleName("Pilot")
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        self.stack = QStackedWidget()
        self.canvas = PilotCanvas(look)
        self.stack.addWidget(self.canvas)
        column.addWidget(self.stack, 1)
        self.training = Training(desk)
        self.help = TrainingLine(look)
        column.addWidget(self.help)
        self._capture = KeyCapture(self.training, self.canvas)
        self.training.changed.connect(self._training_changed)
        self.buttons = ActionBar(look)
        self.buttons.pressed.connect(lambda name: actions[name].trigger())
        column.addWidget(self.buttons)
        desk.changed.connect(self._flight_changed)
        desk.painted.connect(lambda _until: self._samples_came())
        desk.told.connect(self.refresh)
        look.changed.connect(self.refresh)

    # Commands

    @property
    def handlers(self) -> Mapping[str, Callable[[], object]]:
        """Return what the commands of this place do."""
        return {
            "pilot_page": lambda: self.go(debrief=False),
            "pilot_debrief": lambda: self.go(debrief=True),
            "pilot_window": self.toggle_window,
            "pilot_speak": self.toggle_speech,
            **self._card_handlers,
            "pilot_dismiss": self.dismiss,
            "pilot_train": self.train,
            "pilot_sticks": self.training.exchange,
        }

    @property
    def _card_handlers(self) -> Mapping[str, Callable[[], object]]:
        return {
            "pilot_previous_card": lambda: self.step_card(-1),
            "pilot_next_card": lambda: self.step_card(1),
            "pilot_fly_card": lambda: self._choose(self._choosing.chosen(self.cues.snapshot())),
            "pilot_repeat": self.repeat,
            "pilot_any_card": lambda: self._choose(""),
        }

    @property
    def shown(self) -> bool:
        """Return whether the place is on screen, so that its keys are meant."""
        return self.isVisible()

    @property
    def present(self) -> tuple[Need, ...]:
        """Return what commands may act on."""
        if not self.shown:
            return ()
        found: list[Need] = ["pilot"]
        if self.stack.currentWidget() is self.canvas:
            if self.cues.cards is not None:
                found.append("pilot_cards")
            if self._standing_verdict():
                found.append("pilot_verdict")
            if self.training.running:
                found.append("pilot_training")
        return tuple(found)

    # What the crew does

    def go(self, *, debrief: bool) -> None:
        """Show the page of the cues, or the debrief."""
        self.stack.setCurrentWidget(self.debrief if debrief and self.debrief else self.canvas)
        self.begin()
        self.refresh()

    def begin(self) -> None:
        """Put the keyboard where one goes on."""
        self.stack.currentWidget().setFocus()

    def step_card(self, steps: int) -> None:
        """Look at another card."""
        self._choosing.step(self.cues.cards, self.cues.snapshot(), steps)
        self.refresh()

    def repeat(self) -> None:
        """Have the card of the latest maneuver flown again."""
        card = last_card(self.cues.snapshot(), self.cues.cards)
        if card:
            self._choose(card)

    def _choose(self, card_id: str) -> None:
        self._choosing.forget()
        self.cues.choose(card_id)
        self.refresh()

    def _standing_verdict(self) -> str:
        """Return the id of the maneuver whose verdict is on the page; empty for none."""
        cues = self.cues.snapshot()
        verdict = cues.fresh_verdict if cues is not None else None
        return verdict.id if verdict is not None and verdict.id != self._dismissed else ""

    def dismiss(self) -> None:
        """Put the verdict away; it stays in the debrief."""
        self._dismissed = self._standing_verdict() or self._dismissed
        self.refresh()

    # Training

    def train(self) -> None:
        """Begin a training flight, on the page."""
        self.go(debrief=False)
        self.wanted.emit()
        self.training.start()

    def _training_changed(self) -> None:
        """Show who has the sticks, and that the flight began or ended."""
        self.help.show_training(self.training)
        if self.training.flies:
            self.go(debrief=False)
        self.refresh()

    def _sticks_words(self) -> str:
        if not self.training.running:
            return ""
        return "Give it back" if self.training.flies else "I have it"

    # The second window

    def toggle_window(self) -> None:
        """Open the page in a window of its own, or close that."""
        if self.window_of_its_own is not None:
            self.window_of_its_own.close()
            return
        self.open_window()

    def open_window(self) -> None:
        """Open the page in a window of its own, on another screen if there is one."""
        names = (*self._card_handlers, "pilot_dismiss", "mute", "pilot_window")
        keys = {
            key.toString(): self._actions[name].trigger
            if name in ("mute", "pilot_window")
            else {**self._card_handlers, "pilot_dismiss": self.dismiss}[name]
            for name in names
            for key in self._actions[name].shortcuts()
        }
        made = PilotWindow(self._look, keys)
        made.closed.connect(self._window_closed)
        self.window_of_its_own = made
        made.open_beside(self.window())
        self._store.change(pilot_window=True)
        self._actions["pilot_window"].setChecked(True)
        self.refresh()

    def _window_closed(self) -> None:
        self.window_of_its_own = None
        self._store.change(pilot_window=False)
        self._actions["pilot_window"].setChecked(False)

    def close_window(self) -> None:
        """Close the second window with the main one, and remember that it was open."""
        made, self.window_of_its_own = self.window_of_its_own, None
        if made is not None:
            made.closed.disconnect()
            made.close()
            made.deleteLater()

    # Speech

    @property
    def aloud(self) -> bool:
        """Return whether cues are spoken."""
        wish = self._store.current.flight_speech
        return wish == "always" or (wish == "page" and self._was_opened)

    def toggle_speech(self) -> None:
        """Speak the cues of this flight and of those to come, or none."""
        self._store.change(flight_speech="never" if self.aloud else "always")
        self.refresh()

    # What happens

    def showEvent(self, event: QShowEvent) -> None:
        """Speak from now on: whoever opens the page flies."""
        super().showEvent(event)
        self._was_opened = True
        self.refresh()

    def hideEvent(self, event: QHideEvent) -> None:
        """Say that other commands are of use now."""
        super().hideEvent(event)
        self._tell_present()

    def _tell_present(self) -> None:
        """Say so where other commands are of use than a moment ago."""
        present = self.present
        if present != self._present:
            self._present = present
            self.changed.emit()

    def _flight_changed(self) -> None:
        """Another flight is open, or none."""
        self._choosing.forget()
        self._dismissed = ""
        self._calm = Calm(time.monotonic)
        self.speech.restart(self.cues.spoken())
        self.refresh()
        # Whoever shows the flight elsewhere may have taken the keyboard along.
        QTimer.singleShot(0, self, self._keep_keyboard)

    def _keep_keyboard(self) -> None:
        focus = QApplication.focusWidget()
        if self.shown and not (focus is not None and self.isAncestorOf(focus)):
            self.begin()

    def _samples_came(self) -> None:
        """Look at the cues as soon as samples came, but not at every one."""
        if time.monotonic() - self._looked >= SOONEST:
            self.refresh()

    def refresh(self) -> None:
        """Show and say what the cues are now."""
        self._looked = time.monotonic()
        cues = self.cues.snapshot()
        self.speech.hear(cues, self.cues.spoken(), aloud=self.aloud)
        self._actions["pilot_speak"].setChecked(self.aloud)
        pages = [self.canvas] if self.shown else []
        if self.window_of_its_own is not None:
            pages.append(self.window_of_its_own.canvas)
        if not pages:
            return
        reading = Reading(
            cues=cues,
            units=self._look.units,
            open=self.cues.is_open,
            silent=self.cues.silent(),
            dismissed=self._dismissed,
            browsed=self._choosing.browsed(self.cues.cards),
        )
        sheet = self._calm.calmed(sheet_of(reading))
        for page in pages:
            page.show_sheet(sheet)
        if self.shown:
            self._tell_present()
            self.buttons.show_offers(
                offers(self._actions, debrief=False, looking=reading.browsed is not None, sticks="")
            )

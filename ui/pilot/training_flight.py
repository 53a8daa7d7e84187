"""A training flight: the virtual aircraft flown with keys, recorded and judged like any flight."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from PySide6.QtCore import QEvent, QObject, Qt, QTimer, Signal
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QLabel, QWidget

from gsapp.flight.cards import load_cards
from gsapp.virtual.downlink.aircraft_process import TrainingProcess
from gsapp.virtual.mission import RECOVERY_PHASE, TRAINEE_PHASE, phase_announcement
from ui.commands import shortcut_text
from ui.display_style import DisplayStyle
from ui.flight_controller import FlightController
from ui.translation import QT_TR_NOOP, tr
from ui.virtual_flight_session import VIRTUAL_AIRCRAFT, VirtualFlightSession

_STICK_KEYS: Final[Mapping[Qt.Key, tuple[str, float]]] = {
    Qt.Key.Key_Down: ("pitch", 1.0),
    Qt.Key.Key_Up: ("pitch", -1.0),
    Qt.Key.Key_Right: ("roll", 1.0),
    Qt.Key.Key_Left: ("roll", -1.0),
    Qt.Key.Key_D: ("yaw", 1.0),
    Qt.Key.Key_A: ("yaw", -1.0),
}
"""Sticks: while a key is down. The stick is pulled with Down, as it is towards oneself."""
_LEVER_KEYS: Final[Mapping[Qt.Key, tuple[str, float]]] = {
    Qt.Key.Key_W: ("throttle", 0.04),
    Qt.Key.Key_S: ("throttle", -0.04),
}
"""The throttle lever moves by so much of its travel at each press, and stays."""
_TRIM_STEP: Final = 0.02
"""Share of a trim lever's travel at each press of a stick's key with Ctrl."""
_TRAVEL_KEYS: Final[Mapping[Qt.Key, float]] = {
    Qt.Key.Key_1: 0.25,
    Qt.Key.Key_2: 1.0 / 3.0,
    Qt.Key.Key_3: 0.5,
    Qt.Key.Key_4: 2.0 / 3.0,
    Qt.Key.Key_5: 1.0,
}
"""How far a key pushes its stick, as the words of the cues go: quarter, third, half ..."""
STICK_TRAVEL_TEXTS: Final[Mapping[float, str]] = {
    0.25: QT_TR_NOOP("quarter stick"),
    1.0 / 3.0: QT_TR_NOOP("third of stick"),
    0.5: QT_TR_NOOP("half stick"),
    2.0 / 3.0: QT_TR_NOOP("two thirds"),
    1.0: QT_TR_NOOP("full stick"),
}
_RATE_KEYS: Final[Mapping[Qt.Key, bool]] = {Qt.Key.Key_9: False, Qt.Key.Key_0: True}
"""Position of the rate switch."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StickPosition:
    """Where the keys push, -1 to 1; pulled, right, right are positive."""

    pitch: float = 0.0
    roll: float = 0.0
    yaw: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class StickAction:
    """What a press does once, beside pushing a stick: only what is given changes."""

    lever: tuple[str, float] | None = None
    """Axis of a lever, and the share of its travel that it moves by."""
    travel: float | None = None
    """How far keys push from now on, as a share of full stick."""
    high_rate: bool | None = None


class StickKeys:
    """The keys that are down.

    Two keys of one stick that are down together push it the way of the later one, as a thumb goes
    from one side to the other.
    """

    def __init__(self) -> None:
        self._down: list[Qt.Key] = []

    @staticmethod
    def is_stick_key(key: Qt.Key) -> bool:
        return key in _STICK_KEYS or key in _LEVER_KEYS or key in _TRAVEL_KEYS or key in _RATE_KEYS

    def press(self, key: Qt.Key, *, trim: bool, again: bool) -> StickAction | None:
        """Take a key that went down, with Ctrl that of a trim lever; return what it does once."""
        if key in _STICK_KEYS:
            axis, way = _STICK_KEYS[key]
            if trim:
                return StickAction(lever=(axis, way * _TRIM_STEP))
            if not again:
                self.release(key)
                self._down.append(key)
            return None
        if key in _LEVER_KEYS:
            return StickAction(lever=_LEVER_KEYS[key])
        if again or key not in {**_TRAVEL_KEYS, **_RATE_KEYS}:
            return None
        return StickAction(travel=_TRAVEL_KEYS.get(key), high_rate=_RATE_KEYS.get(key))

    def release(self, key: Qt.Key) -> None:
        if key in self._down:
            self._down.remove(key)

    def release_all(self) -> None:
        """Take all hands off the sticks, as when the window is left."""
        self._down.clear()

    @property
    def position(self) -> StickPosition:
        axes = dict(_STICK_KEYS[key] for key in self._down)
        return StickPosition(**axes)


_PERIOD_MS: Final = 20
"""Between two words to the sticks: 50 a second."""
_DEFAULT_TRAVEL: Final = 0.25
"""Share of full stick that a key pushes until another size is chosen."""
_TRAINEE_TEXT: Final = phase_announcement(TRAINEE_PHASE)
_RECOVERY_TEXT: Final = phase_announcement(RECOVERY_PHASE)


class TrainingFlight(QObject):
    """Flies the virtual aircraft over a link of this machine, with the keys of the page."""

    changed = Signal()
    """The sticks changed hands, or the flight began or ended."""

    def __init__(
        self, controller: FlightController, *, seed: int = 0, turbulence: float = 0.0
    ) -> None:
        super().__init__()
        self._controller = controller
        self.seed = seed
        """Same seed, same air."""
        self.turbulence = turbulence
        """Standard deviation of the gusts, m/s."""
        self.keys = StickKeys()
        self._flight = VirtualFlightSession(controller, "training", self._launch)
        self._size, self._high = _DEFAULT_TRAVEL, True
        self._flies = False
        self._timer = QTimer(self)
        self._timer.setTimerType(Qt.TimerType.PreciseTimer)
        self._timer.setInterval(_PERIOD_MS)
        self._timer.timeout.connect(self._send_sticks)
        self._flight.changed.connect(self._flight_state_changed)
        controller.refreshed.connect(self._update_control)

    @property
    def running(self) -> bool:
        return self._flight.running

    @property
    def folder(self) -> Path | None:
        return self._flight.folder

    @property
    def trainee_has_control(self) -> bool:
        return self._flies and self.running

    @property
    def settings_text(self) -> str:
        return tr("{travel}, {rate} rate").format(
            travel=tr(STICK_TRAVEL_TEXTS[self._size]), rate=tr("high") if self._high else tr("low")
        )

    def start(self) -> bool:
        """Record what the aircraft will send, and fly it then; return whether it could."""
        return self._flight.start()

    def stop(self) -> None:
        self._flight.stop()

    def _launch(self, folder: Path, port: int) -> TrainingProcess:
        """Let it fly, for its own cards where the crew has prepared none."""
        session = self._controller.session
        if session is not None and session.crew_cues.cards is None:
            session.crew_cues.set_cards(load_cards(VIRTUAL_AIRCRAFT))
        return TrainingProcess(folder, port, seed=self.seed, turbulence=self.turbulence)

    def _flight_state_changed(self) -> None:
        if self._flight.process is None:
            self._timer.stop()
            self.keys.release_all()
            self._flies = False
        self.changed.emit()

    # Who has it

    def _update_control(self) -> None:
        """Hear who has the aircraft, from what it says over the link."""
        session, aircraft = self._controller.session, self._flight.process
        if session is None or aircraft is None:
            return
        if complaint := aircraft.take_error():
            self._controller.message_posted.emit("warning", complaint)
        said = [
            event.text
            for event in session.messages()
            if event.text in (_TRAINEE_TEXT, _RECOVERY_TEXT)
        ]
        flies = bool(said) and said[-1] == _TRAINEE_TEXT
        if flies != self._flies:
            self._flies = flies
            if not flies:
                self._timer.stop()
                self.keys.release_all()
            self.changed.emit()

    def exchange_control(self) -> None:
        aircraft = self._flight.process
        if aircraft is None:
            return
        if self._flies:
            aircraft.hand_over()
            return
        aircraft.take_over()
        aircraft.set_stick_size(self._size)
        aircraft.set_rate_switch(high=self._high)
        self._timer.start()

    # Keys

    def press(self, key: Qt.Key, *, trim: bool, again: bool) -> None:
        self._do(self.keys.press(key, trim=trim, again=again))
        self._send_sticks()

    def release(self, key: Qt.Key) -> None:
        self.keys.release(key)
        self._send_sticks()

    def _do(self, doing: StickAction | None) -> None:
        aircraft = self._flight.process
        if aircraft is None or doing is None:
            return
        if doing.lever is not None:
            aircraft.move_lever(*doing.lever)
            return
        if doing.travel is not None:
            self._size = doing.travel
            aircraft.set_stick_size(doing.travel)
        if doing.high_rate is not None:
            self._high = doing.high_rate
            aircraft.set_rate_switch(high=doing.high_rate)
        self.changed.emit()

    def _send_sticks(self) -> None:
        aircraft = self._flight.process
        if aircraft is not None:
            push = self.keys.position
            aircraft.send_sticks(push.pitch, push.roll, push.yaw)


_MODIFIERS: Final = (
    Qt.KeyboardModifier.ControlModifier
    | Qt.KeyboardModifier.KeypadModifier
    | Qt.KeyboardModifier.ShiftModifier
)
"""Keys with any other one are commands, as ever."""


class StickKeyFilter(QObject):
    """Event filter of the page: keys of the sticks move them, and are no commands meanwhile."""

    def __init__(self, training: TrainingFlight, page: QWidget) -> None:
        super().__init__(page)
        self._training = training
        page.installEventFilter(self)

    def eventFilter(self, _watched: QObject, event: QEvent) -> bool:
        kind = event.type()
        if kind == QEvent.Type.FocusOut:
            self._training.keys.release_all()
        elif isinstance(event, QKeyEvent) and self._is_ours(event):
            key = Qt.Key(event.key())
            if kind == QEvent.Type.KeyPress:
                trim = bool(event.modifiers() & Qt.KeyboardModifier.ControlModifier)
                self._training.press(key, trim=trim, again=event.isAutoRepeat())
            elif kind == QEvent.Type.KeyRelease and not event.isAutoRepeat():
                self._training.release(key)
            event.accept()
            return True
        return False

    def _is_ours(self, event: QKeyEvent) -> bool:
        if not StickKeys.is_stick_key(Qt.Key(event.key())):
            return False
        # A key that went down while the trainee had it may come up later.
        released = event.type() == QEvent.Type.KeyRelease
        return released or (
            self._training.trainee_has_control and not event.modifiers() & ~_MODIFIERS
        )


_CONTROL_KEY_TEXT = shortcut_text("Ctrl+Up").removesuffix(shortcut_text("Up"))


class TrainingStatusLine(QLabel):
    """Says it; hidden without training."""

    def __init__(self, style: DisplayStyle) -> None:
        super().__init__()
        self._style = style
        self.setWordWrap(True)
        self.setAccessibleName(tr("Training"))
        self.hide()
        style.changed.connect(self._restyle)
        self._restyle()

    def _restyle(self) -> None:
        px = self._style.px
        self.setContentsMargins(px(16), px(4), px(16), px(4))

    def show_status(self, training: TrainingFlight) -> None:
        if training.trainee_has_control:
            self.setText(
                tr(
                    "You have control ({settings}) · arrows: stick (Down pulls) · A D: rudder · "
                    "W S: throttle · 1 2 3 4 5: quarter, third, half, two thirds, full · "
                    "9 0: low, high rate · {control}arrows: trim · {sound}: sound · H: give it back"
                ).format(
                    settings=training.settings_text,
                    control=_CONTROL_KEY_TEXT,
                    sound=shortcut_text("Ctrl+M"),
                )
            )
        else:
            self.setText(tr("The built-in pilot flies the pattern · H: take control"))
        self.setVisible(training.running)

"""A training flight: the virtual aircraft flown with keys, recorded and judged like any flight."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from PySide6.QtCore import QObject, Qt, QTimer, Signal

from gsapp.dynamics.pilot.handover import RECOVERING, TRAINEE
from gsapp.flight.cards import load_cards
from gsapp.foundation import GroundStationError
from gsapp.session import Session
from gsapp.telemetry.recorder_control import RecorderHandle
from gsapp.telemetry.virtual.announcing import announcement
from gsapp.telemetry.virtual.process import TrainingProcess, free_port
from ui.desk import Desk
from ui.dialogs.requests import ConnectRequest
from ui.pilot.stick_keys import SIZE_WORDS, Click, Doing, Rate, Size, StickKeys
from ui.work import Work

_AIRCRAFT: Final = "b777"
_PERIOD_MS: Final = 20
"""Between two words to the sticks: 50 a second."""
_USUAL_SIZE: Final = 0.25
"""Share of full stick that a key pushes until another size is chosen."""
_TAKEN: Final = announcement(TRAINEE)
_GIVEN: Final = announcement(RECOVERING)


class Training(QObject):
    """Flies the virtual aircraft over a link of this machine, with the keys of the page.

    Parameters
    ----------
    desk : Desk
        Records and follows it as it would an aircraft.

    Attributes
    ----------
    changed : Signal
        The sticks changed hands, or the flight began or ended.
    seed : int
        Same seed, same air.
    turbulence : float or None
        Gusts, m/s; None leaves them to the plan.
    """

    changed = Signal()

    def __init__(self, desk: Desk, *, seed: int = 0, turbulence: float | None = 0.0) -> None:
        super().__init__()
        self._desk = desk
        self.seed = seed
        self.turbulence = turbulence
        self.keys = StickKeys()
        self.folder: Path | None = None
        self._port = 0
        self._size, self._high = _USUAL_SIZE, True
        self._aircraft: TrainingProcess | None = None
        self._recorder: RecorderHandle | None = None
        self._ending: Work | None = None
        self._flies = False
        self._timer = QTimer(self)
        self._timer.setTimerType(Qt.TimerType.PreciseTimer)
        self._timer.setInterval(_PERIOD_MS)
        self._timer.timeout.connect(self._say_sticks)
        desk.changed.connect(self._opened)
        desk.told.connect(self._listen)

    @property
    def running(self) -> bool:
        """Return whether the aircraft flies and is what is open."""
        session = self._desk.session
        return (
            self._aircraft is not None
            and self._aircraft.flying()
            and session is not None
            and session.path == self.folder
        )

    @property
    def flies(self) -> bool:
        """Return whether the trainee has the aircraft."""
        return self._flies and self.running

    @property
    def settings(self) -> str:
        """Return how the keys are set, in words."""
        return f"{SIZE_WORDS[self._size]}, {'high' if self._high else 'low'} rate"

    def start(self) -> None:
        """Record what the aircraft will send, and open it; it flies when that is done."""
        self.stop()
        self._port = free_port()
        usual = self._desk.starter.next_folder()
        self.folder = usual.with_name(f"{usual.name} training")
        self._desk.starter.connect_aircraft(
            ConnectRequest(
                link=f"udpin:127.0.0.1:{self._port}",
                folder=self.folder,
                channel_map=_AIRCRAFT,
                aircraft=_AIRCRAFT,
                calibration=_AIRCRAFT,
            ),
            trial=True,
        )

    def _opened(self) -> None:
        """Let it fly when its record is open, and end it when something else is."""
        session = self._desk.session
        if session is None or session.path != self.folder:
            self.stop()
        elif self._aircraft is None and self.folder is not None:
            try:
                self._give_cards(session)
                self._recorder = session.recorder
                self._aircraft = TrainingProcess(
                    self.folder, self._port, seed=self.seed, turbulence=self.turbulence
                )
            except GroundStationError as error:
                self._desk.faults.report(error)
            self.changed.emit()

    def _give_cards(self, session: Session) -> None:
        """Let the flight be for the cards of the aircraft, where the crew has prepared none."""
        if session.cards is None:
            session.use_cards(load_cards(_AIRCRAFT))

    def stop(self) -> None:
        """End the flight, and in the background its recording."""
        self._timer.stop()
        self.keys.let_go()
        self._flies = False
        aircraft, self._aircraft = self._aircraft, None
        recorder, self._recorder = self._recorder, None
        if recorder is not None:
            self._desk.give_up(recorder)
            self._ending = Work("Ending the recording", lambda _tell: recorder.stop(), self)
            self._ending.start()
        if aircraft is not None:
            aircraft.stop()
            self.changed.emit()

    # Who has it

    def _listen(self) -> None:
        """Hear who has the aircraft, from what it says over the link."""
        session, aircraft = self._desk.session, self._aircraft
        if session is None or aircraft is None:
            return
        if complaint := aircraft.complaint():
            self._desk.said.emit("warning", complaint)
        said = [event.text for event in session.messages() if event.text in (_TAKEN, _GIVEN)]
        flies = bool(said) and said[-1] == _TAKEN
        if flies != self._flies:
            self._flies = flies
            if not flies:
                self._timer.stop()
                self.keys.let_go()
            self.changed.emit()

    def exchange(self) -> None:
        """Take the sticks, or give them back."""
        if self._aircraft is None:
            return
        if self._flies:
            self._aircraft.hand_back()
            return
        self._aircraft.take_over()
        self._aircraft.choose_size(self._size)
        self._aircraft.choose_rate(high=self._high)
        self._timer.start()

    # Keys

    def press(self, key: Qt.Key, *, trim: bool, again: bool) -> None:
        """Take a key that went down."""
        self._do(self.keys.press(key, trim=trim, again=again))
        self._say_sticks()

    def release(self, key: Qt.Key) -> None:
        """Take a key that went up."""
        self.keys.release(key)
        self._say_sticks()

    def _do(self, doing: Doing | None) -> None:
        aircraft = self._aircraft
        if aircraft is None or doing is None:
            return
        if isinstance(doing, Click):
            aircraft.click(doing.axis, doing.by)
        elif isinstance(doing, Size):
            self._size = doing.share
            aircraft.choose_size(doing.share)
            self.changed.emit()
        elif isinstance(doing, Rate):
            self._high = doing.high
            aircraft.choose_rate(high=doing.high)
            self.changed.emit()

    def _say_sticks(self) -> None:
        if self._aircraft is not None:
            push = self.keys.push
            self._aircraft.sticks(push.pitch, push.roll, push.yaw)

"""A training flight: the virtual aircraft flown with keys, recorded and judged like any flight."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from PySide6.QtCore import QObject, Qt, QTimer, Signal

from gsapp.flight.cards import load_cards
from gsapp.virtual.downlink.aircraft_process import TrainingProcess
from gsapp.virtual.downlink.flight_downlink import phase_announcement
from gsapp.virtual.mission import RECOVERY_PHASE, TRAINEE_PHASE
from ui.flight_controller import FlightController
from ui.pilot.stick_keys import (
    STICK_TRAVEL_TEXTS,
    LeverStep,
    RateSwitch,
    StickAction,
    StickKeys,
    StickTravel,
)
from ui.translation import tr
from ui.virtual_flight_session import VIRTUAL_AIRCRAFT, VirtualFlightSession

_PERIOD_MS: Final = 20
"""Between two words to the sticks: 50 a second."""
_DEFAULT_TRAVEL: Final = 0.25
"""Share of full stick that a key pushes until another size is chosen."""
_TRAINEE_TEXT: Final = phase_announcement(TRAINEE_PHASE)
_RECOVERY_TEXT: Final = phase_announcement(RECOVERY_PHASE)


class TrainingFlight(QObject):
    """Flies the virtual aircraft over a link of this machine, with the keys of the page.

    Parameters
    ----------
    controller : FlightController
        Records and follows it as it would an aircraft.

    Attributes
    ----------
    changed : Signal
        The sticks changed hands, or the flight began or ended.
    seed : int
        Same seed, same air.
    turbulence : float
        Standard deviation of the gusts, m/s.
    """

    changed = Signal()

    def __init__(
        self, controller: FlightController, *, seed: int = 0, turbulence: float = 0.0
    ) -> None:
        super().__init__()
        self._controller = controller
        self.seed = seed
        self.turbulence = turbulence
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
        """Return whether the aircraft flies and is what is open."""
        return self._flight.running

    @property
    def folder(self) -> Path | None:
        """Return the folder of the flight; None before the first."""
        return self._flight.folder

    @property
    def trainee_has_control(self) -> bool:
        """Return whether the trainee has the aircraft."""
        return self._flies and self.running

    @property
    def settings_text(self) -> str:
        """Return how the keys are set, in words."""
        return tr("{travel}, {rate} rate").format(
            travel=tr(STICK_TRAVEL_TEXTS[self._size]), rate=tr("high") if self._high else tr("low")
        )

    def start(self) -> bool:
        """Record what the aircraft will send, and open it; it flies when that is done.

        Returns
        -------
        bool
            Whether it could; otherwise it is said why not.
        """
        return self._flight.start()

    def stop(self) -> None:
        """End the flight, and in the background its recording."""
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
        """Take the sticks, or give them back."""
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
        """Take a key that went down."""
        self._do(self.keys.press(key, trim=trim, again=again))
        self._send_sticks()

    def release(self, key: Qt.Key) -> None:
        """Take a key that went up."""
        self.keys.release(key)
        self._send_sticks()

    def _do(self, doing: StickAction | None) -> None:
        aircraft = self._flight.process
        if aircraft is None or doing is None:
            return
        if isinstance(doing, LeverStep):
            aircraft.move_lever(doing.axis, doing.step)
        elif isinstance(doing, StickTravel):
            self._size = doing.share
            aircraft.set_stick_size(doing.share)
            self.changed.emit()
        elif isinstance(doing, RateSwitch):
            self._high = doing.high
            aircraft.set_rate_switch(high=doing.high)
            self.changed.emit()

    def _send_sticks(self) -> None:
        aircraft = self._flight.process
        if aircraft is not None:
            push = self.keys.position
            aircraft.send_sticks(push.pitch, push.roll, push.yaw)

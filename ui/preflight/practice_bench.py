"""Practice without an aircraft: the virtual bench on a real link, and a helper at its surfaces."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject

from gsapp.virtual.downlink.aircraft_process import BenchProcess
from ui.flight_controller import FlightController
from ui.virtual_flight_session import VirtualFlightSession

if TYPE_CHECKING:
    from calibration.wizard import WizardView

_OVERSHOOT = 4.0
"""Degrees by which a setting is passed before it is come back to."""
_SPOKEN_COMMANDS = {"pressure_zero": "pitot covered", "pressure_blow": "pitot blow"}
_MOVE_SECONDS = 1.2
"""Seconds after which volts that are steady say that the hand has arrived."""


class PracticeBench(QObject):
    """Flies nothing: a bench that sends the volts of an aircraft on the ground."""

    def __init__(self, controller: FlightController, *, seed: int = 0, speed: float = 1.0) -> None:
        super().__init__()
        # Both count when the bench is switched on.
        self.seed = seed
        self.speed = speed
        self._pending_target: tuple[str, float, float] | None = None
        self._flight = VirtualFlightSession(controller, "practice", self._launch)

    @property
    def running(self) -> bool:
        return self._flight.running

    def start(self) -> None:
        """Record what the bench will send, and open it; the bench follows when that is done."""
        self._pending_target = None
        self._flight.start()

    def stop(self) -> None:
        """Switch the bench off, and in the background end its recording."""
        self._pending_target = None
        self._flight.stop()

    def _launch(self, folder: Path, port: int) -> BenchProcess:
        return BenchProcess(folder, port, seed=self.seed, speed=self.speed)

    def assist(self, view: WizardView) -> None:
        """Do at the surface what the view asks for: move it, pass the setting, come back to it."""
        instrument, bench = view.instrument, self._flight.process
        if instrument is None or bench is None:
            return
        over = "wrong side" in view.message
        self._pending_target = None
        if view.phase == "sign":
            bench.set_angle(instrument.channel, max(instrument.settings))
        elif view.phase == "gyro_turn" and view.target is not None:
            bench.send_line(f"turn {instrument.channel} {view.target:g}")
        elif view.position is not None:
            bench.send_line(f"lie {view.position}")
        elif view.phase in _SPOKEN_COMMANDS:
            bench.send_line(_SPOKEN_COMMANDS[view.phase])
        elif view.target is not None:
            turns = over or (bool(view.remaining) and view.remaining[0].is_turning_point)
            past = {"up": -_OVERSHOOT, "down": _OVERSHOOT}.get(view.direction, 0.0)
            if turns and past:
                since = view.reading.time if view.reading is not None else 0.0
                self._pending_target = (instrument.channel, view.target, since)
                bench.set_angle(instrument.channel, view.target + past)
            else:
                bench.set_angle(instrument.channel, view.target)

    def return_to_setting(self, view: WizardView) -> None:
        """Come back to a setting once it was passed."""
        reading, bench = view.reading, self._flight.process
        if self._pending_target is None or bench is None or reading is None:
            return
        channel, target, since = self._pending_target
        if reading.state == "steady" and reading.time - since > _MOVE_SECONDS:
            self._pending_target = None
            bench.set_angle(channel, target)

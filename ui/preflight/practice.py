"""Practice without an aircraft: the virtual bench on a real link, and a helper at its surfaces."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, QTimer

from gsapp.foundation import LinkError
from gsapp.telemetry.virtual.process import BenchProcess, free_port
from ui.desk import Desk
from ui.dialogs.requests import ConnectRequest

if TYPE_CHECKING:
    from calibration.wizard import WizardView

_AIRCRAFT = "b777"
_PAST = 4.0
"""Degrees by which a setting is passed before it is come back to."""
_PAUSE_MS = 3500
"""Until the hand comes back: as long as a person takes for it."""


class Practice(QObject):
    """Flies nothing: a bench that sends the volts of an aircraft on the ground.

    Parameters
    ----------
    desk : Desk
        Records and follows it as it would an aircraft.
    seed : int
        Which aircraft it is.
    speed : float
        Of the bench, times real time.
    """

    def __init__(self, desk: Desk, *, seed: int = 0, speed: float = 1.0) -> None:
        super().__init__()
        self._desk = desk
        self._seed = seed
        self._speed = speed
        self._bench: BenchProcess | None = None
        self.folder: Path | None = None
        self._back = QTimer(self)
        self._back.setSingleShot(True)
        self._back.setInterval(round(_PAUSE_MS / speed))
        self._back.timeout.connect(self._come_back)
        self._wanted: tuple[str, float] | None = None
        self._port = 0
        desk.changed.connect(self._opened)

    @property
    def running(self) -> bool:
        """Return whether the bench runs and is what is open."""
        session = self._desk.session
        return (
            self._bench is not None
            and self._bench.flying()
            and session is not None
            and session.path == self.folder
        )

    def start(self) -> None:
        """Record what the bench will send, and open it; the bench follows when that is done."""
        self.stop()
        self._port = free_port()
        usual = self._desk.next_folder()
        self.folder = usual.with_name(f"{usual.name} practice")
        self._desk.connect_aircraft(
            ConnectRequest(
                link=f"udpin:127.0.0.1:{self._port}",
                folder=self.folder,
                channel_map=_AIRCRAFT,
                aircraft=_AIRCRAFT,
                calibration=_AIRCRAFT,
            )
        )

    def _opened(self) -> None:
        """Switch the bench on when its record is open, and off when something else is."""
        session = self._desk.session
        if session is None or session.path != self.folder:
            self.stop()
        elif self._bench is None:
            try:
                self._bench = BenchProcess(
                    self.folder, self._port, seed=self._seed, speed=self._speed
                )
            except LinkError as error:
                self._desk.faults.report(error)

    def stop(self) -> None:
        """Switch the bench off."""
        self._back.stop()
        if self._bench is not None:
            self._bench.stop()
            self._bench = None

    def help(self, view: WizardView) -> None:
        """Do at the surface what the view asks for: move it, pass the setting, come back to it."""
        instrument, bench = view.instrument, self._bench
        if instrument is None or bench is None:
            return
        if view.phase == "sign":
            bench.set_angle(instrument.channel, max(instrument.settings))
        elif view.target is not None:
            turns = bool(view.remaining) and view.remaining[0].turns
            past = {"up": -_PAST, "down": _PAST}.get(view.direction, 0.0)
            if turns and past:
                self._wanted = (instrument.channel, view.target)
                bench.set_angle(instrument.channel, view.target + past)
                self._back.start()
            else:
                bench.set_angle(instrument.channel, view.target)

    def _come_back(self) -> None:
        if self._wanted is not None and self._bench is not None:
            self._bench.set_angle(*self._wanted)
            self._wanted = None

"""What begins a live flight: the folder with all that is in force, recorders, the aircraft."""

from __future__ import annotations

import shutil
import threading
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import QObject, QTimer, Signal

from gsapp.flight.folder import FlightFolder
from gsapp.flight.folder_setup import prepare_flight_folder
from gsapp.session import Session
from gsapp.telemetry.recorder_control import RecorderHandle, find_recorders
from gsapp.virtual.downlink.aircraft_process import AircraftProcess
from ui.dialogs.flight_requests import ConnectRequest, VirtualFlightRequest
from ui.translation import tr

_POLL_SECONDS = 1.0
_TAKE_MS = 200
"""Between looks at what the thread found."""
_DISK_TIMEOUT = 0.2
"""Seconds that the window waits for the disks of recorders."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RunningRecorder:
    """A recorder found running."""

    handle: RecorderHandle  # To attach to.
    name: str  # Of the flight.
    link: str  # What it records.


@dataclass(slots=True, eq=False)
class PendingFlight:
    """What was set going for a flight that opens; undone if nobody wants it any more."""

    session: Session | None = None  # The flight.
    aircraft: AircraftProcess | None = None  # Flies for it.
    # Was started for it; None where one ran already, or none is needed.
    recorder: RecorderHandle | None = None
    folder: Path | None = None  # The flight folder, if it was made for it.
    has_next_flight_data: bool = False  # Whether the flight has what waited for the next one.

    @property
    def has_flight_folder(self) -> bool:
        """Return whether there is a flight to which what waited for the next one belongs."""
        return self.folder is None or self.folder.is_dir()

    def undo(self) -> bool:
        """End everything, and take away a folder without a record; return whether one is kept."""
        if self.session is not None:
            self.session.close()
        if self.aircraft is not None:
            self.aircraft.stop()
        ended = self.recorder is None or self.recorder.stop()
        if self.folder is None or not self.folder.is_dir():
            return False
        if not ended or FlightFolder(path=self.folder).nonempty_raw_files:
            return True
        shutil.rmtree(self.folder, ignore_errors=True)
        return False


def find_running_recorders() -> tuple[RunningRecorder, ...]:
    """Return the recorders of this user that run now, the newest first."""
    found = []
    for handle in reversed(find_recorders()):
        status = handle.status()
        link = status.link if status is not None else tr("its link")
        found.append(RunningRecorder(handle=handle, name=handle.folder.name, link=link))
    return tuple(found)


class RecorderMonitor(QObject):
    """Looks for recorders that run once a second, in a thread: no disk that hangs is waited for."""

    changed = Signal()  # Others run than before.

    def __init__(self, parent: QObject) -> None:
        super().__init__(parent)
        self.running: tuple[RunningRecorder, ...] = ()  # The newest first.
        self._over = threading.Event()
        self._asking: threading.Thread | None = None
        self._newest: tuple[RunningRecorder, ...] = ()
        self.destroyed.connect(self._over.set)
        # The thread emits no signal: this object may be deleted at that very moment.
        timer = QTimer(self)
        timer.timeout.connect(lambda: self._set_running(self._newest))
        timer.start(_TAKE_MS)
        threading.Thread(target=self._poll_recorders, name="recorders", daemon=True).start()

    def poll(self) -> tuple[RunningRecorder, ...]:
        """Return the recorders that run now; those of the last look where a disk hangs."""
        if self._asking is None or not self._asking.is_alive():
            self._asking = threading.Thread(target=self._look, name="recorders", daemon=True)
            self._asking.start()
        self._asking.join(_DISK_TIMEOUT)
        if not self._asking.is_alive():
            self._set_running(self._newest)
        return self.running

    def _look(self) -> None:
        with suppress(OSError):  # the runtime folder cannot be read
            self._newest = find_running_recorders()

    def _poll_recorders(self) -> None:
        while not self._over.wait(_POLL_SECONDS):
            self._look()

    def _set_running(self, running: tuple[RunningRecorder, ...]) -> None:
        if running != self.running:
            self.running = running
            self.changed.emit()


def prepare_requested_flight(request: ConnectRequest) -> Path:
    """Make the flight folder with copies of everything in force; see `prepare_flight_folder`."""
    return prepare_flight_folder(
        request.folder,
        name=request.title,
        aircraft=request.aircraft,
        channel_map=request.channel_map,
        calibration=request.calibration,
        source=request.link,
    ).path


def launch_virtual_aircraft(request: VirtualFlightRequest, port: int) -> AircraftProcess:
    """Let the virtual aircraft fly as asked for, sending to a UDP port of this machine."""
    return AircraftProcess(request.folder, port, request, speed=request.speed)

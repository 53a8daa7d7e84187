"""A flight without an aircraft: a virtual one on a link of this machine, recorded and opened."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Final, Generic, TypeVar

from PySide6.QtCore import QObject, Signal

from gsapp.foundation import GroundStationError
from gsapp.telemetry.recorder_control import RecorderHandle
from gsapp.virtual.downlink.aircraft_process import BackgroundCommand, find_free_udp_port
from ui.background_job import BackgroundJob
from ui.commands import shortcut_text
from ui.dialogs.flight_requests import ConnectRequest
from ui.flight_controller import FlightController
from ui.translation import tr

ProcessT = TypeVar("ProcessT", bound=BackgroundCommand)

VIRTUAL_AIRCRAFT: Final = "b777"  # The shipped aircraft that flies, with its map and certificates.


class VirtualFlightSession(QObject, Generic[ProcessT]):
    """Opens the record first, then lets the aircraft send, and ends both with it.

    `kind`: what its folder is called, with a date and a letter. `launch`: starts what sends, given
    the folder for its log and the UDP port to send to.
    """

    changed = Signal()  # It began or ended.

    def __init__(
        self, controller: FlightController, kind: str, launch: Callable[[Path, int], ProcessT]
    ) -> None:
        super().__init__()
        self._controller = controller
        self._kind = kind
        self._launch = launch
        self.folder: Path | None = None  # Of the flight; None before the first.
        self.process: ProcessT | None = None  # What sends.
        self._port = 0
        self._recorder: RecorderHandle | None = None
        self._ending: BackgroundJob | None = None
        controller.changed.connect(self._opened)

    @property
    def running(self) -> bool:
        """Return whether it sends and is what is open."""
        session = self._controller.session
        return (
            self.process is not None
            and self.process.is_running()
            and session is not None
            and session.path == self.folder
        )

    def start(self) -> bool:
        """Record what will be sent, and open it; the sending begins when that is done.

        Returns whether it could: a slip of the hand must not take the place of a flight that is
        recorded.
        """
        if self._controller.is_recording and not self.running:
            self._controller.message_posted.emit(
                "caution",
                tr(
                    "{name} is being recorded. Close it first ({keys}), then begin the {kind}."
                ).format(name=self._controller.name, keys=shortcut_text("Ctrl+W"), kind=self._kind),
            )
            return False
        self.stop()
        self._port = find_free_udp_port()
        self.folder = self._controller.flight_opener.next_flight_folder(self._kind)
        self._controller.flight_opener.connect_aircraft(
            ConnectRequest(
                link=f"udpin:127.0.0.1:{self._port}",
                folder=self.folder,
                channel_map=VIRTUAL_AIRCRAFT,
                aircraft=VIRTUAL_AIRCRAFT,
                calibration=VIRTUAL_AIRCRAFT,
            ),
            trial=True,
        )
        return True

    def _opened(self) -> None:
        """Let it send when its record is open, and end it when something else is."""
        session = self._controller.session
        if session is None or session.path != self.folder:
            self.stop()
        elif self.process is None:
            try:
                self._recorder = session.recorder
                self.process = self._launch(self.folder, self._port)
            except GroundStationError as error:
                self._controller.error_reporter.report(error)
            self.changed.emit()

    def stop(self) -> None:
        process, self.process = self.process, None
        recorder, self._recorder = self._recorder, None
        if recorder is not None:
            self._controller.recorders.release(recorder)
            self._ending = BackgroundJob(
                tr("Stopping the recording"), lambda _tell: recorder.stop(), self
            )
            self._ending.start()
        if process is not None:
            process.stop()
            self.changed.emit()

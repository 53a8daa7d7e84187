"""The recorders: what begins a live flight, that of the open flight, and others that run."""

from __future__ import annotations

import shutil
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from threading import Thread

from PySide6.QtCore import QObject, QTimer, Signal

from gsapp.flight.folder import FlightFolder
from gsapp.session import Session
from gsapp.telemetry.recorder_control import RecorderHandle, find_recorders, restart_recorder
from gsapp.telemetry.stream_server import ShareRequest, request_shares
from gsapp.virtual.downlink.aircraft_process import AircraftProcess
from ui.background_job import BackgroundJob, JobProgress
from ui.commands import shortcut_text
from ui.dialogs.flight_requests import VirtualFlightRequest
from ui.error_reporter import ErrorReporter
from ui.translation import tr

_POLL_SECONDS = 1.0
_TAKE_MS = 200  # Between looks at what the thread found.
_DISK_TIMEOUT = 0.2  # Seconds that the window waits for the disks of recorders.


@dataclass(frozen=True, slots=True, kw_only=True)
class RunningRecorder:
    """A recorder found running."""

    handle: RecorderHandle  # To attach to.
    name: str  # Of the flight.
    link: str  # What it records.
    sends_heartbeats: bool = False  # Whether its end may let the autopilot's failsafe act.


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
        found.append(
            RunningRecorder(
                handle=handle, name=handle.folder.name, link=link,
                sends_heartbeats=status is not None and status.heartbeats > 0,
            )
        )  # fmt: skip
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
        """Return the recorders that run now; those of the last time where a disk hangs."""
        if self._asking is None or not self._asking.is_alive():
            self._asking = threading.Thread(
                target=self._find_recorders, name="recorders", daemon=True
            )
            self._asking.start()
        self._asking.join(_DISK_TIMEOUT)
        if not self._asking.is_alive():
            self._set_running(self._newest)
        return self.running

    def _find_recorders(self) -> None:
        with suppress(OSError):  # the runtime folder cannot be read
            self._newest = find_running_recorders()

    def _poll_recorders(self) -> None:
        while not self._over.wait(_POLL_SECONDS):
            self._find_recorders()

    def _set_running(self, running: tuple[RunningRecorder, ...]) -> None:
        if running != self.running:
            self.running = running
            self.changed.emit()


def launch_virtual_aircraft(request: VirtualFlightRequest, port: int) -> AircraftProcess:
    """Let the virtual aircraft fly as asked for, sending to a UDP port of this machine."""
    return AircraftProcess(request.folder, port, request, speed=request.speed)


_RESTART_SECONDS, _MAX_RESTARTS = 60.0, 3
"""A recorder that stopped unexpectedly is restarted at most so often within this time."""
_RESTART_PAUSE = 3.0  # s between restarts: the state on disk is older until then.
_SHARE_SECONDS, _SHARE_PAUSE = 5.0, 0.1
"""For a recorder to share with other addresses, and between looks at whether it does."""
_STOP_SECONDS = 11.0
"""For a recorder to stop as the window closes; it is given 10 s to write what came."""


class RecorderController(QObject):
    """Lists and stops recorders."""

    changed = Signal()  # Others run than before.
    # A `BackgroundJob` begins; what to say when it is done, empty for nothing.
    job_started = Signal(object, str)
    message_posted = Signal(str, str)  # Level and sentence of a banner.

    def __init__(
        self,
        open_session: Callable[[], Session | None],
        error_reporter: ErrorReporter,
        parent: QObject,
    ) -> None:
        super().__init__(parent)
        # The virtual aircraft that sends to the recorder of the open flight.
        self.aircraft: AircraftProcess | None = None
        self._open_session = open_session
        self._error_reporter = error_reporter
        self._left: list[RecorderHandle] = []
        self._restarts: list[float] = []  # Times of restarts, s.
        self._is_restarting = False
        self.is_stop_requested = False  # Whether the crew ended the recording of the open flight.
        self._monitor = RecorderMonitor(self)
        self._monitor.changed.connect(self.changed)

    @property
    def current(self) -> RecorderHandle | None:
        session = self._open_session()
        return None if session is None else session.recorder

    def poll(self) -> tuple[RunningRecorder, ...]:
        """Return the recorders that run now, the newest first; not that of the open flight."""
        return self._without_open_flight(self._monitor.poll())

    @property
    def others(self) -> tuple[RunningRecorder, ...]:
        """Return the recorders that ran a moment ago, but that of the open flight."""
        return self._without_open_flight(self._monitor.running)

    def _without_open_flight(
        self, running: tuple[RunningRecorder, ...]
    ) -> tuple[RunningRecorder, ...]:
        session = self._open_session()
        folder = session.path.absolute() if session is not None else None
        return tuple(found for found in running if found.handle.folder != folder)

    @property
    def left_running(self) -> tuple[RunningRecorder, ...]:
        """Return the recorders of flights that were open here, are not now, and still record."""
        return tuple(found for found in self.poll() if found.handle in self._left)

    def leave(self, recorder: RecorderHandle | None) -> None:
        """Remember the recorder of a flight that is closed here and goes on recording."""
        if recorder is not None and recorder not in self._left:
            self._left.append(recorder)

    def announce_left(self, recorder: RecorderHandle | None) -> None:
        """Say that a recorder still records, if it does."""
        if recorder is not None and recorder in [left.handle for left in self.left_running]:
            keys = shortcut_text("Ctrl+R")
            text = tr("{name}: still recording. {keys} reattaches.").format(
                name=recorder.folder.name, keys=keys
            )
            self.message_posted.emit("note", text)

    def release(self, recorder: RecorderHandle) -> None:
        """Forget a recorder that somebody else stops."""
        self._left = [left for left in self._left if left != recorder]

    def restart_failed(self, session: Session) -> None:
        """Restart the recorder of the open flight; give up if it stops again and again."""
        now = time.monotonic()
        self._restarts = [one for one in self._restarts if one > now - _RESTART_SECONDS]
        if self._is_restarting or self.is_stop_requested or len(self._restarts) >= _MAX_RESTARTS:
            return
        if self._restarts and now < self._restarts[-1] + _RESTART_PAUSE:
            return
        self._restarts.append(now)
        self._is_restarting = True
        text = tr(
            "{name}: the recorder stopped unexpectedly and was restarted. The data in between are "
            "missing."
        )

        def report(_recorder: RecorderHandle) -> None:
            self._is_restarting = False
            self.message_posted.emit("warning", text.format(name=session.name))

        def fail(error: Exception) -> None:
            self._is_restarting = False
            self._error_reporter.report(error)

        job = BackgroundJob(
            tr("Restarting the recorder"), lambda _: restart_recorder(session.path), self
        )
        job.done.connect(report)
        job.failed.connect(fail)
        job.start()

    def stop_recording(self) -> None:
        """Stop recording the open flight in the background; what arrived is written first."""
        recorder, aircraft = self.current, self.aircraft
        if recorder is None:
            return
        self.is_stop_requested = True

        def stop(_progress: JobProgress) -> bool:
            if aircraft is not None:
                aircraft.stop()
            return recorder.stop()

        def report(stopped: bool) -> None:
            if not stopped:
                self.message_posted.emit(
                    "warning",
                    tr(
                        "The recorder (process {pid}) is still writing data. Try again in a moment."
                    ).format(pid=recorder.pid),
                )

        job = BackgroundJob(tr("Stopping the recording"), stop, self)
        job.done.connect(report)
        job.failed.connect(self._error_reporter.report)
        self.job_started.emit(job, "")
        job.start()

    def share(self, request: ShareRequest) -> None:
        """Share the open flight with these addresses alone; say which of them cannot be used."""
        recorder = self.current
        if recorder is None:
            text = tr("Not shared: {why}").format(why=tr("this flight is not being recorded."))
            self.message_posted.emit("caution", text)
            return

        def ask(_progress: JobProgress) -> list[str]:
            request_shares(recorder.folder, request)
            deadline = time.monotonic() + _SHARE_SECONDS
            while time.monotonic() < deadline:
                status = recorder.status()
                shares = [] if status is None else status.shares
                if tuple(share.link for share in shares) == request.links:
                    return [share.error for share in shares if share.error]
                time.sleep(_SHARE_PAUSE)
            return [tr("The recorder does not respond.")]

        def report(errors: list[str]) -> None:
            for error in errors:
                self.message_posted.emit("caution", tr("Not shared: {why}").format(why=error))

        job = BackgroundJob(tr("Sharing the flight"), ask, self)
        job.done.connect(report)
        job.failed.connect(self._error_reporter.report)
        job.start()

    def stop_recording_and_wait(self) -> None:
        """Stop recording the open flight and wait for it, as the window closes."""
        self.is_stop_requested = True
        if self.aircraft is not None:
            self.aircraft.stop()
        if self.current is not None:
            self.stop_and_wait(self.current)

    @staticmethod
    def stop_and_wait(*recorders: RecorderHandle) -> None:
        """Stop recorders and wait for them, though not for a disk that hangs."""
        threads = [Thread(target=one.stop, name="stopping", daemon=True) for one in recorders]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(_STOP_SECONDS)

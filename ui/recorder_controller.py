"""The recorders: that of the open flight, and others that run."""

from __future__ import annotations

from collections.abc import Callable
from threading import Thread

from PySide6.QtCore import QObject, Signal

from gsapp.session import Session
from gsapp.telemetry.recorder_control import RecorderHandle
from gsapp.virtual.downlink.aircraft_process import AircraftProcess
from ui.background_job import BackgroundJob, JobProgress
from ui.commands import shortcut_text
from ui.error_reporter import ErrorReporter
from ui.recording_setup import RecorderMonitor, RunningRecorder
from ui.translation import tr

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
    def left_running(self) -> tuple[RecorderHandle, ...]:
        """Return the recorders of flights that were open here, are not now, and still record."""
        running = [found.handle for found in self.poll()]
        return tuple(left for left in self._left if left in running)

    def leave(self, recorder: RecorderHandle | None) -> None:
        """Remember the recorder of a flight that is closed here and goes on recording."""
        if recorder is not None and recorder not in self._left:
            self._left.append(recorder)

    def announce_left(self, recorder: RecorderHandle | None) -> None:
        """Say that a recorder still records, if it does."""
        if recorder is not None and recorder in self.left_running:
            keys = shortcut_text("Ctrl+R")
            text = tr("{name}: still recording. {keys} reattaches.").format(
                name=recorder.folder.name, keys=keys
            )
            self.message_posted.emit("note", text)

    def release(self, recorder: RecorderHandle) -> None:
        """Forget a recorder that somebody else stops."""
        self._left = [left for left in self._left if left != recorder]

    def stop_recording(self) -> None:
        """Stop recording the open flight in the background; what arrived is written first."""
        recorder, aircraft = self.current, self.aircraft
        if recorder is None:
            return

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

    def stop_recording_and_wait(self) -> None:
        """Stop recording the open flight and wait for it, as the window closes."""
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

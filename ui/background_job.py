"""Long work in a thread of its own, with progress, time left, and a cancel that cancels."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

from PySide6.QtCore import QObject, Qt, QTimer, Signal

from ui.number_format import duration_text
from ui.translation import tr

_REPORT_SECONDS = 0.05
"""A work that reports more often than this would drown the window in signals."""
_CANCEL_TIMEOUT_MS = 2000  # After which a work that was asked to stop is not waited for any more.


class JobCanceledError(Exception):
    """The user asked the work to stop. Not an error."""


class JobProgress:
    """How a work says where it stands; called from its thread.

    `tell`: receives share done (None = unknown) and what is being done.
    """

    def __init__(self, tell: Callable[[float | None, str], None]) -> None:
        self._report = tell
        self._cancelled = threading.Event()

    def cancel(self) -> None:
        """Ask the work to stop at its next report."""
        self._cancelled.set()

    @property
    def is_canceled(self) -> bool:
        return self._cancelled.is_set()

    def __call__(self, share: float | None, doing: str) -> None:
        """Report; raises `JobCanceledError` if the user does not want it any more."""
        if self._cancelled.is_set():
            raise JobCanceledError
        self._report(share, doing)


class BackgroundJob(QObject):
    """One piece of work in a thread, which is gone from the window once its end was told.

    Who keeps it may still ask whether it runs, and may cancel it.

    `function`: called in the thread with a `JobProgress`; its result is handed to `done`.
    `may_hang`: whether it may wait for a disk that never answers: after `cancel` it is left to
    itself.
    """

    progressed = Signal(object, str)  # Share done or None, and a sentence with the time left.
    done = Signal(object)  # The result.
    failed = Signal(object)  # The exception.
    canceled = Signal()  # It stopped because it was asked to.
    discarded = Signal(object)  # A result that came after that, for those who must undo it.
    _ended = Signal(object, object)

    def __init__(
        self,
        title: str,
        function: Callable[[JobProgress], Any],
        parent: QObject | None = None,
        *,
        may_hang: bool = False,
    ) -> None:
        super().__init__(parent)
        self.title = title
        self._may_hang = may_hang
        self.is_running = False
        self._function = function
        self._progress = JobProgress(self._report_progress)
        self._thread: threading.Thread | None = None
        self._started = 0.0
        self._reported_at = 0.0
        self._abandoned = False
        self._ended.connect(self._finish, Qt.ConnectionType.QueuedConnection)

    def start(self) -> None:
        self.is_running = True
        self._started = time.monotonic()
        self._thread = threading.Thread(target=self._run, name=self.title, daemon=True)
        self._thread.start()

    def cancel(self) -> None:
        """Ask it to stop; its result, should it still come, is dropped."""
        self._progress.cancel()
        if self._may_hang:
            QTimer.singleShot(_CANCEL_TIMEOUT_MS, self, self._abandon)

    def _abandon(self) -> None:
        if self.is_running:
            self.is_running = False
            self._abandoned = True
            self.canceled.emit()

    def wait(self, seconds: float) -> None:
        """Wait for its thread, so long at most; what it leads to is told afterwards."""
        if self._thread is not None:
            self._thread.join(seconds)

    def _run(self) -> None:
        try:
            result = self._function(self._progress)
        except BaseException as error:
            self._emit_end(None, error)
        else:
            self._emit_end(result, None)

    def _emit_end(self, result: object, error: BaseException | None) -> None:
        try:
            self._ended.emit(result, error)
        except RuntimeError:
            # The window was closed meanwhile and this object with it.
            return

    def _report_progress(self, share: float | None, doing: str) -> None:
        now = time.monotonic()
        if now - self._reported_at < _REPORT_SECONDS:
            return
        self._reported_at = now
        sentence = doing
        elapsed = now - self._started
        if share is not None and share > 0.02 and elapsed > 0.5:
            sentence = tr("{doing} · {duration} left").format(
                doing=doing, duration=duration_text(elapsed * (1.0 - share) / share)
            )
        self.progressed.emit(share, sentence)

    def _finish(self, result: object, error: BaseException | None) -> None:
        self.is_running = False
        if self._abandoned:
            if error is None:
                self.discarded.emit(result)
        elif isinstance(error, JobCanceledError) or (self._progress.is_canceled and error is None):
            if error is None:
                self.discarded.emit(result)
            self.canceled.emit()
        elif error is not None:
            self.failed.emit(error)
        else:
            self.done.emit(result)
        # What it was made with and told to may hold a whole flight.
        self.deleteLater()

"""Long work in a thread of its own, with progress, time left, and a cancel that cancels."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from functools import cache, partial
from typing import Any

from PySide6.QtCore import QObject, Qt, QTimer, Signal
from shiboken6 import isValid

from gsapp.flight.readers.reader_process import observe_reading
from ui.number_format import duration_text
from ui.translation import tr

_REPORT_SECONDS = 0.05
"""A work that reports more often than this would drown the window in signals."""
_CANCEL_TIMEOUT_MS = 2000  # After which a work that was asked to stop is not waited for any more.


_END_TIMEOUT = 1.0  # Seconds for a thread whose work has ended.


class JobCanceledError(Exception):
    """The user asked the work to stop. Not an error."""


class _WindowThread(QObject):
    """Calls functions in the thread of the window, for any other thread.

    A thread that emitted a signal of its job would do so while the window deletes the job. This
    object is never deleted.
    """

    requested = Signal(object)

    def __init__(self) -> None:
        super().__init__()
        self.requested.connect(self._call, Qt.ConnectionType.QueuedConnection)

    def _call(self, function: Callable[[], object]) -> None:
        function()


_window_thread = cache(_WindowThread)


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
        self._window_thread = _window_thread()

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
            with observe_reading(self._progress):
                result = self._function(self._progress)
        except BaseException as error:
            end = partial(self._finish, None, error)
        else:
            end = partial(self._finish, result, None)
        self._window_thread.requested.emit(end)

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
        self._window_thread.requested.emit(partial(self._show_progress, share, sentence))

    def _show_progress(self, share: float | None, sentence: str) -> None:
        if isValid(self):
            self.progressed.emit(share, sentence)

    def _finish(self, result: object, error: BaseException | None) -> None:
        # The last reference must go in this thread.
        self.wait(_END_TIMEOUT)
        self.is_running = False
        if not isValid(self):  # The window was closed meanwhile, and this object with it.
            return
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
        # What it was made with and told to may hold a whole flight. What it was told to may be all
        # that holds its parent, which would delete it once more.
        self.setParent(None)
        self.deleteLater()

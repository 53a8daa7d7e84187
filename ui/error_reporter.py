"""Errors in slots become a sentence on the screen and an entry in the log, never silence."""

from __future__ import annotations

import logging
import logging.handlers
import sys
import threading
import traceback
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from types import TracebackType

from PySide6.QtCore import QObject, Qt, Signal

from gsapp.foundation import GroundStationError
from ui.commands import shortcut_text
from ui.translation import tr

log = logging.getLogger("ui.error_reporter")


@dataclass(frozen=True, slots=True, kw_only=True)
class ErrorReport:
    """An error as shown and as kept."""

    message: str  # For the screen.
    details: str  # For the log and the clipboard: the whole trace.
    # Whether the program raised it on purpose; a mistake of the program otherwise.
    is_expected: bool
    # Whether a flight could not be opened, which nobody minds once another one is.
    is_opening_error: bool = False


def create_error_report(error: BaseException) -> ErrorReport:
    """Return the fault for an exception."""
    details = "".join(traceback.format_exception(error))
    if isinstance(error, GroundStationError):
        return ErrorReport(message=str(error), details=details, is_expected=True)
    if isinstance(error, OSError) and error.strerror:
        where = f"{error.filename}: " if error.filename else ""
        return ErrorReport(
            message=tr("{where}{strerror}. Check that the path exists and its permissions.").format(
                where=where, strerror=error.strerror
            ),
            details=details,
            is_expected=True,
        )
    text = str(error).splitlines()[0] if str(error) else tr("no details")
    return ErrorReport(
        message=(
            tr(
                "Internal error ({name}: {words}). Recording is not affected. "
                "{keys} copies the details for a report."
            ).format(name=type(error).__name__, words=text, keys=shortcut_text("Ctrl+Shift+C"))
        ),
        details=details,
        is_expected=False,
    )


class ErrorReporter(QObject):
    """Receives every uncaught exception, from any thread, and hands it to the window."""

    error_reported = Signal(object)  # Emitted in the thread of the window.
    _arrived = Signal(object)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.last_report: ErrorReport | None = None  # The newest, for the clipboard.
        self._former: tuple[Callable[..., object], Callable[..., object]] | None = None
        # Queued: a slot that fails while painting must not open a banner inside the painting.
        self._arrived.connect(self._deliver, Qt.ConnectionType.QueuedConnection)

    def install(self) -> None:
        """Take over `sys.excepthook` and that of threads."""
        if self._former is None:
            self._former = (sys.excepthook, threading.excepthook)
            sys.excepthook = self._hook
            threading.excepthook = self._thread_hook

    def remove(self) -> None:
        """Give the hooks back."""
        if self._former is not None:
            sys.excepthook, threading.excepthook = self._former
            self._former = None

    def report(self, error: BaseException, *, opening: bool = False) -> None:
        """Log an error and show it; `opening` if a flight could not be opened for it."""
        fault = replace(create_error_report(error), is_opening_error=opening)
        (log.warning if fault.is_expected else log.error)("%s", fault.details)
        self._arrived.emit(fault)

    def _deliver(self, fault: ErrorReport) -> None:
        self.last_report = fault
        self.error_reported.emit(fault)

    def _hook(
        self, kind: type[BaseException], error: BaseException, trace: TracebackType | None
    ) -> None:
        if issubclass(kind, KeyboardInterrupt):
            sys.__excepthook__(kind, error, trace)
            return
        self.report(error.with_traceback(trace))

    def _thread_hook(self, arguments: threading.ExceptHookArgs) -> None:
        if arguments.exc_value is not None and not issubclass(arguments.exc_type, SystemExit):
            self.report(arguments.exc_value)


class _RotatingLog(logging.handlers.RotatingFileHandler):
    """A log that grows on where it cannot be turned over.

    Windows renames no file that another window has open, too: every line from there on would be
    lost, and with each try one of the former logs.
    """

    def doRollover(self) -> None:
        if self.stream is not None:
            self.stream.close()
            self.stream = None
        try:
            # To its own name: nothing happens, unless it is refused.
            Path(self.baseFilename).rename(self.baseFilename)
        except OSError:
            self.stream = self._open()
        else:
            super().doRollover()


def start_logging(path: Path) -> None:
    """Write the program's log to a file, turned over at 1 MB; a disk that refuses is let be."""
    root = logging.getLogger()
    wanted = str(path.absolute())
    if any(getattr(handler, "baseFilename", "") == wanted for handler in root.handlers):
        return
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handler = _RotatingLog(path, maxBytes=1_000_000, backupCount=3, encoding="utf-8")
    except OSError as error:
        log.warning("no log file: %s", error)
        return
    handler.setFormatter(
        logging.Formatter("%(asctime)s %(levelname)s %(name)s: %(message)s", "%Y-%m-%d %H:%M:%S")
    )
    root.addHandler(handler)
    if root.level > logging.INFO or root.level == logging.NOTSET:
        root.setLevel(logging.INFO)

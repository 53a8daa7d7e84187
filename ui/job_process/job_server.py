"""The side of the process: it does one job after the other and says how far it is. No Qt.

The window sends a job and receives reports until one of them ends it. Stopping is asked for by an
event that both share; a process that does not obey is ended by the window.
"""

from __future__ import annotations

import contextlib
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any, Literal, Protocol

from gsapp.flight.readers.reader_process import observe_reading
from gsapp.foundation import GroundStationError
from gsapp.foundation.process_control import lower_priority

JobProgressCallback = Callable[[float | None, str], object]
"""Receives the share done (None: unknown) and what is being done; may raise to stop the work."""


class StopEvent(Protocol):
    """An event of another process."""

    def is_set(self) -> bool:
        """Return whether stopping was asked for."""


class JobHandler(Protocol):
    """What does the jobs, and keeps what the next may need."""

    def do(self, job: Any) -> object:
        """Do one job and return its result."""


@dataclass(frozen=True, slots=True, kw_only=True)
class JobReport:
    """How far a job is, or how it ended."""

    kind: Literal["doing", "done", "failed", "stopped"]
    share: float | None = None  # Of the work, 0 to 1; None where nobody knows.
    text: str = ""  # What is being done, or why it failed.
    is_expected: bool = True  # Whether it failed for a reason the program knows.
    details: str = ""  # For the log.
    result: object = None  # What came of the job.


class JobStoppedError(Exception):
    """The window asked to stop."""


def serve_jobs(
    connection: Connection, stop: StopEvent, make: Callable[[JobProgressCallback], JobHandler]
) -> None:
    """Do jobs until the window hangs up.

    `make`: makes the bench; what it is given says how far a job is, and raises `JobStoppedError`
    where the window does not want it any more.
    """
    # The charts come first on a machine with few cores.
    lower_priority(5)

    def tell(share: float | None, text: str) -> None:
        if stop.is_set():
            raise JobStoppedError
        connection.send(JobReport(kind="doing", share=share, text=text))

    bench = make(tell)
    with contextlib.suppress(EOFError, OSError):
        while True:
            job = connection.recv()
            try:
                with observe_reading(tell):
                    result = bench.do(job)
                told = JobReport(kind="done", share=1.0, result=result)
            except JobStoppedError:
                told = JobReport(kind="stopped")
            except Exception as error:  # every failure is told in the window
                told = _failure(error)
            connection.send(told)


def _failure(error: Exception) -> JobReport:
    return JobReport(
        kind="failed",
        text=str(error) or type(error).__name__,
        is_expected=isinstance(error, (GroundStationError, OSError)),
        details="".join(traceback.format_exception(error)),
    )

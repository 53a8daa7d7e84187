"""The side of the window: a process that does jobs, is stopped, and is missed when it dies."""

from __future__ import annotations

import contextlib
import multiprocessing
import threading
import time
from collections.abc import Callable
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from multiprocessing.synchronize import Event
from typing import Any, Protocol

from gsapp.foundation import GroundStationError
from ui.background_job import JobCanceledError
from ui.job_process.job_server import JobProgressCallback, JobReport
from ui.translation import tr

_STOP_TIMEOUT = 2.0  # Seconds that the process has to stop by itself before it is ended.
_POLL_SECONDS = 0.05  # Seconds between two looks at whether the job is still wanted.


class JobError(GroundStationError):
    """A job that came to nothing, in one sentence."""


class JobRunner(Protocol):
    """What does the jobs."""

    def do(self, job: Any, tell: JobProgressCallback) -> Any:
        """Do a job; called in a thread. `tell` raises `JobCanceledError` to stop it."""

    def close(self) -> None:
        """Give everything back."""


class ProcessJobRunner:
    """Does the jobs in a process of its own, so that neither stream nor charts wait for it.

    `serve`: what the process does: called with its end of the pipe and the event that stops a job.
    `name`: what it does: ``search``. `remedy`: what to try where it died.
    """

    def __init__(
        self, serve: Callable[[Connection, Event], None], *, name: str, remedy: str
    ) -> None:
        self._serve = serve
        self._name = name
        self._remedy = remedy
        self._context = multiprocessing.get_context("spawn")
        self._process: BaseProcess | None = None
        self._connection: Connection | None = None
        # Made with the first process: it costs the window's start a helper process.
        self._stop: Event | None = None
        self._lock = threading.Lock()

    @property
    def pid(self) -> int | None:
        return self._process.pid if self._process is not None else None

    def do(self, job: Any, tell: JobProgressCallback) -> Any:
        """Hand a job to the process and wait for it; see `JobRunner.do`.

        Raises `JobError` if the job failed for a reason that the program knows, or the process
        died. Raises `RuntimeError` if it failed for another. Raises `JobCanceledError` if it was
        stopped.
        """
        with self._lock:
            connection = self._begin()
            share: float | None = 0.0
            text = tr("starting")
            try:
                if self._stop is not None:
                    self._stop.clear()
                connection.send(job)
                while True:
                    tell(share, text)
                    if not self._has_message(connection):
                        continue
                    told = connection.recv()
                    if told.kind == "doing":
                        share, text = told.share, tr(told.text)
                    else:
                        return _result(told)
            except JobCanceledError:
                self._stop_job(connection)
                raise
            except (EOFError, OSError) as error:
                code = self._ended()
                raise JobError(
                    tr(
                        "the {name} ended without a message (exit code {code}): probably out "
                        "of memory; {remedy}"
                    ).format(name=self._name, code=code, remedy=self._remedy)
                ) from error

    def _begin(self) -> Connection:
        if self._process is not None and self._process.is_alive() and self._connection is not None:
            return self._connection
        self._end()
        ours, theirs = self._context.Pipe()
        self._stop = self._context.Event()
        self._process = self._context.Process(
            target=self._serve, args=(theirs, self._stop), name=self._name, daemon=True
        )
        self._process.start()
        theirs.close()
        self._connection = ours
        return ours

    def _has_message(self, connection: Connection) -> bool:
        if connection.poll(_POLL_SECONDS):
            return True
        # On Windows the pipe of a process that dies before it took its end does not break.
        alive = self._process is not None and self._process.is_alive()
        if not alive and not connection.poll():
            raise EOFError
        return False

    def _stop_job(self, connection: Connection) -> None:
        """Let the process stop the job and keep what it prepared; end it if it does not obey."""
        if self._stop is not None:
            self._stop.set()
        end = time.monotonic() + _STOP_TIMEOUT
        with contextlib.suppress(EOFError, OSError):
            while time.monotonic() < end:
                if connection.poll(_POLL_SECONDS) and connection.recv().kind != "doing":
                    return
        self._end()

    def _ended(self) -> int | None:
        code = None
        if self._process is not None:
            self._process.join(1.0)
            code = self._process.exitcode
        self._end()
        return code

    def _end(self) -> None:
        connection, self._connection = self._connection, None
        process, self._process = self._process, None
        if connection is not None:
            connection.close()
        if process is not None:
            process.terminate()
            process.join(2.0)

    def close(self) -> None:
        """End the process; a job that is not wanted any more stops before, and tidies up."""
        if self._lock.acquire(timeout=_STOP_TIMEOUT + 1.0):
            try:
                self._end()
            finally:
                self._lock.release()
        elif (process := self._process) is not None:
            # A thread that waits for it sees that it hung up.
            process.terminate()
            process.join(2.0)


def _result(told: JobReport) -> object:
    if told.kind == "stopped":
        raise JobCanceledError
    if told.kind == "failed" or told.result is None:
        error = JobError(told.text) if told.is_expected else RuntimeError(told.text)
        error.add_note(told.details)
        raise error
    return told.result

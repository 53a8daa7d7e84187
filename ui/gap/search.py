"""Runs searches behind the window and keeps their answers; decisions can be taken back."""

from __future__ import annotations

import contextlib
import multiprocessing
import threading
import time
from collections.abc import Callable
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from multiprocessing.synchronize import Event
from pathlib import Path
from typing import Protocol

from PySide6.QtCore import QObject, Signal

from ui.gap.request import Answer, Decisions, GapRequest, SearchError, Tell
from ui.gap.worker import Job, ReportJob, SearchJob, Told, serve
from ui.work import CancelledError, Progress, Work

_OBEYS = 2.0
"""Seconds that the process has to stop by itself before it is ended."""
_LOOKS = 0.05
_KEPT = 8
"""Answers kept for going back."""


class Engine(Protocol):
    """What does the jobs."""

    def do(self, job: Job, tell: Tell) -> Answer | Path:
        """Do a job; called in a thread. `tell` raises `CancelledError` to stop it."""

    def close(self) -> None:
        """Give everything back."""


class ProcessEngine:
    """Does the jobs in a process of its own, so that neither stream nor charts wait for it."""

    def __init__(self) -> None:
        self._context = multiprocessing.get_context("spawn")
        self._process: BaseProcess | None = None
        self._connection: Connection | None = None
        # Made with the first process: it costs the window's start a helper process.
        self._stop: Event | None = None
        self._lock = threading.Lock()

    @property
    def pid(self) -> int | None:
        """Return the id of the process; None while there is none."""
        return self._process.pid if self._process is not None else None

    def do(self, job: Job, tell: Tell) -> Answer | Path:
        """Hand a job to the process and wait for it; see `Engine.do`."""
        with self._lock:
            connection = self._begin()
            share: float | None = 0.0
            words = "starting"
            try:
                if self._stop is not None:
                    self._stop.clear()
                connection.send(job)
                while True:
                    tell(share, words)
                    if not connection.poll(_LOOKS):
                        continue
                    told = connection.recv()
                    if told.kind == "doing":
                        share, words = told.share, told.words
                    else:
                        return _result(told)
            except CancelledError:
                self._halt(connection)
                raise
            except (EOFError, OSError) as error:
                code = self._ended()
                raise SearchError(
                    f"the search ended without a word (exit code {code}): most likely the memory "
                    "was full; try fewer flights at once"
                ) from error

    def _begin(self) -> Connection:
        if self._process is not None and self._process.is_alive() and self._connection is not None:
            return self._connection
        self._end()
        ours, theirs = self._context.Pipe()
        self._stop = self._context.Event()
        self._process = self._context.Process(
            target=serve, args=(theirs, self._stop), name="search for missing effects", daemon=True
        )
        self._process.start()
        theirs.close()
        self._connection = ours
        return ours

    def _halt(self, connection: Connection) -> None:
        """Let the process stop the job and keep what it prepared; end it if it does not obey."""
        if self._stop is not None:
            self._stop.set()
        end = time.monotonic() + _OBEYS
        with contextlib.suppress(EOFError, OSError):
            while time.monotonic() < end:
                if connection.poll(_LOOKS) and connection.recv().kind != "doing":
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
        """End the process."""
        process = self._process
        if process is not None:
            # A thread that waits for it sees that it hung up.
            process.terminate()
            process.join(2.0)


def _result(told: Told) -> Answer | Path:
    if told.kind == "stopped":
        raise CancelledError
    if told.kind == "failed" or told.result is None:
        error = SearchError(told.words) if told.expected else RuntimeError(told.words)
        error.add_note(told.details)
        raise error
    return told.result


class GapSearch(QObject):
    """The search of the window: at most one runs; the answer stays until another one comes.

    Parameters
    ----------
    engine : Engine
        Does the work.

    Attributes
    ----------
    began : Signal(object)
        A `Work` begins: a search, or a report being written.
    progressed : Signal(object, str)
        Share done or None, and what is being done with the time left.
    ended : Signal(str)
        The work ended: ``found``, ``written``, ``cancelled`` or ``failed``.
    changed : Signal
        There is another answer.
    written : Signal(object)
        The path of a report.
    """

    began = Signal(object)
    progressed = Signal(object, str)
    ended = Signal(str)
    changed = Signal()
    written = Signal(object)

    def __init__(
        self,
        engine: Engine,
        report_error: Callable[[BaseException], None],
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self._engine = engine
        self._report_error = report_error
        self._work: Work | None = None
        self.answer: Answer | None = None
        self._past: list[Answer] = []
        self._future: list[Answer] = []

    @property
    def running(self) -> bool:
        """Return whether something is being done."""
        return self._work is not None and self._work.running

    @property
    def title(self) -> str:
        """Return what is being done, or was last."""
        return self._work.title if self._work is not None else ""

    @property
    def can_undo(self) -> bool:
        """Return whether a decision can be taken back."""
        return bool(self._past) and not self.running

    @property
    def can_redo(self) -> bool:
        """Return whether a decision taken back can be taken again."""
        return bool(self._future) and not self.running

    def search(self, request: GapRequest) -> None:
        """Search flights from the beginning."""
        self._look(request, Decisions(), "Searching for missing effects")

    def refuse(self, effect: str, title: str) -> None:
        """Search again without an effect."""
        if self.answer is not None:
            decisions = self.answer.decisions.refuse(effect)
            self._look(self.answer.request, decisions, f"Searching without “{title}”")

    def force(self, effect: str, title: str) -> None:
        """Search again with an effect in the model, whatever its evidence."""
        if self.answer is not None:
            decisions = self.answer.decisions.force(effect)
            self._look(self.answer.request, decisions, f"Searching with “{title}”")

    def undo(self) -> None:
        """Take the last decision back."""
        if self.can_undo and self.answer is not None:
            self._future.append(self.answer)
            self.answer = self._past.pop()
            self.changed.emit()

    def redo(self) -> None:
        """Take a decision again that was taken back."""
        if self.can_redo and self.answer is not None:
            self._past.append(self.answer)
            self.answer = self._future.pop()
            self.changed.emit()

    def write_report(self, path: Path, units: str) -> None:
        """Write the report of the answer in the background, in ``US`` or ``SI`` units."""
        answer = self.answer
        if answer is None or self.running:
            return
        job = ReportJob(answer=answer, path=path, units=units)
        self._start(f"Writing {path.name}", job, self._report_done)

    def cancel(self) -> None:
        """Stop what runs; what was known before stays."""
        if self._work is not None:
            self._work.cancel()

    def close(self) -> None:
        """Stop everything, as the window closes."""
        self.cancel()
        self._engine.close()

    def _look(self, request: GapRequest, decisions: Decisions, title: str) -> None:
        if self.running:
            return
        self._start(title, SearchJob(request=request, decisions=decisions), self._found)

    def _start(self, title: str, job: Job, done: Callable[[object], None]) -> None:
        def run(progress: Progress) -> Answer | Path:
            return self._engine.do(job, progress)

        work = Work(title, run, self)
        self._work = work
        work.progressed.connect(self.progressed)
        work.done.connect(done)
        work.cancelled.connect(lambda: self.ended.emit("cancelled"))
        work.failed.connect(self._failed)
        work.start()
        self.began.emit(work)

    def _found(self, answer: object) -> None:
        if not isinstance(answer, Answer):
            return
        former = self.answer
        if former is not None and former.request == answer.request:
            self._past = [*self._past, former][-_KEPT:]
        else:
            self._past = []
        self._future = []
        self.answer = answer
        self.ended.emit("found")
        self.changed.emit()

    def _report_done(self, path: object) -> None:
        self.ended.emit("written")
        self.written.emit(path)

    def _failed(self, error: BaseException) -> None:
        self.ended.emit("failed")
        self._report_error(error)

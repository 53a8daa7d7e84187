"""The files of an open flight, read and written in a thread: a disk that hangs stops nobody else.

Results are handed over whole, and no lock is held while the thread waits for the disk.
"""

from __future__ import annotations

import json
import logging
import math
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from pathlib import Path
from threading import Event as Flag
from threading import Thread
from typing import TypeVar

from gsapp.flight.events import Event, EventLog
from gsapp.flight.raw_files.record_files import RawRecord
from gsapp.foundation import FlightError
from gsapp.session.monitor_settings import MONITORS

T = TypeVar("T")

_PIECE, _MOST_AHEAD = 1024, 8192
"""Records read at a time, and at most before somebody takes them."""

_ROUNDS = 20
"""Readings that a gap between updates must hold to count: with fewer the thread stopped, too, and
some of them may be from before the gap."""

log = logging.getLogger(__name__)


class FileWorker:
    """Does what waits for the disk of one flight, one thing after the other, in a thread."""

    def __init__(self) -> None:
        self._jobs: deque[tuple[Callable[[], object], Future[object]]] = deque()
        self._tasks: list[_Task] = []
        self._wake = Flag()
        self._round_ended: float | None = None
        self._rounds = self._seen_rounds = self._fresh_round = 0
        self._updated = math.inf
        self.is_closed = False

    @property
    def seconds_waiting(self) -> float:
        """Return the seconds since everything was read last: large where the disk hangs."""
        return 0.0 if self._round_ended is None else time.monotonic() - self._round_ended

    def check_update_gap(self) -> bool:
        """Return whether what was read is from before a gap between updates, as after a suspend.

        To be called at every update. After a gap everything is read again. A disk that hangs is
        not waited for.
        """
        now, former = time.monotonic(), self._updated
        needed = self._seen_rounds + _ROUNDS
        if now - former > MONITORS.max_update_gap and self._rounds < needed:
            self._round_ended, self._fresh_round = now, needed
        self._updated, self._seen_rounds = now, self._rounds
        return self._rounds < self._fresh_round and self.seconds_waiting < MONITORS.disk_timeout

    def repeat(self, task: Callable[[], object], every: float = 0.0) -> None:
        """Let something be done every so many seconds, from the start on."""
        self._tasks.append(_Task(task, every))

    def poll_periodically(self, read: Callable[[], T], every: float) -> Callable[[], T]:
        """Read something now and every so many seconds; return what gives the newest result."""
        newest = read()

        def renew() -> None:
            nonlocal newest
            newest = read()

        self.repeat(renew, every)
        return lambda: newest

    def start(self) -> None:
        self._round_ended = time.monotonic()
        Thread(target=self._run, name="flight files", daemon=True).start()

    def submit(self, job: Callable[[], object]) -> Future[object]:
        """Let something be done next, and wait a moment for it, but not for a disk that hangs."""
        future: Future[object] = Future()
        self._jobs.append((job, future))
        self._wake.set()
        with suppress(TimeoutError):
            future.exception(
                MONITORS.file_wait if self.seconds_waiting < MONITORS.file_wait else 0.0
            )
        return future

    def run_job(self, job: Callable[[], object]) -> None:
        """Let something be done next; raise what fails at once, and log what fails late."""
        future = self.submit(job)
        if future.done():
            future.result()
        else:
            future.add_done_callback(_log_failure)

    def close(self) -> None:
        """End once everything that was asked for is done."""
        self.is_closed = True
        self._wake.set()

    def _run(self) -> None:
        while True:
            self._wake.clear()
            is_last = self.is_closed
            while self._jobs:
                job, future = self._jobs.popleft()
                try:
                    future.set_result(job())
                except Exception as error:
                    future.set_exception(error)
            if is_last:
                return
            for task in self._tasks:
                task.run()
            self._round_ended = time.monotonic()
            self._rounds += 1
            self._wake.wait(MONITORS.file_interval)


def _log_failure(future: Future[object]) -> None:
    if (error := future.exception()) is not None:
        log.error("a flight file was not written", exc_info=error)


class _Task:
    def __init__(self, function: Callable[[], object], every: float) -> None:
        self._function = function
        self._every = every
        self._due = 0.0

    def run(self) -> None:
        now = time.monotonic()
        if now < self._due:
            return
        self._due = now + self._every
        try:
            self._function()
        except Exception:
            self._due = now + MONITORS.file_retry
            log.exception("a flight file cannot be read")


class RecordBuffer:
    """Records read ahead in a thread.

    Parameters
    ----------
    poll : callable
        Gives at most so many of the next records.
    has_grown : callable or None
        Returns whether that would find anything after the end was reached; called by the thread.
        None for a record that does not grow.
    progress : callable
        Gives the share of the records read, 0 to 1; called by the thread.

    Attributes
    ----------
    is_waiting : bool
        Whether the last `poll` gave fewer than it was asked for, and more is being read.
    """

    def __init__(
        self,
        worker: FileWorker,
        poll: Callable[[int], list[RawRecord]],
        has_grown: Callable[[], bool] | None,
        progress: Callable[[], float],
    ) -> None:
        self._poll = poll
        self._grew = has_grown
        self._progress = progress
        self._records: deque[RawRecord] = deque()
        self._at_end = False
        self._share = 0.0
        self._error: Exception | None = None
        self.is_waiting = False
        worker.repeat(self._read_news)
        if has_grown is not None:
            # A file may fail without a change of its size.
            worker.repeat(self._read, MONITORS.file_reread)

    def _read_news(self) -> None:
        if not self._at_end or (self._grew is not None and self._grew()):
            self._read()

    def _read(self) -> None:
        """Read what came, as far as there is room for it."""
        try:
            while self._error is None and len(self._records) < _MOST_AHEAD:
                records = self._poll(_PIECE)
                self._records.extend(records)
                self._share = self._progress()
                self._at_end = len(records) < _PIECE
                if self._at_end:
                    return
        except Exception as error:
            self._error = error  # whoever takes the records is told

    def poll(self, limit: int) -> list[RawRecord]:
        """Take at most so many of the records that were read.

        Raises
        ------
        FlightError
            If a file cannot be read.
        """
        error, self._error = self._error, None
        if error is not None:
            raise error
        at_end = self._at_end  # before: what comes meanwhile is still there the next time
        taken = [self._records.popleft() for _ in range(min(limit, len(self._records)))]
        self.is_waiting = len(taken) < limit and not at_end
        return taken

    def has_grown(self) -> bool:
        """Return whether there is something to take."""
        return bool(self._records) or self._error is not None

    @property
    def progress(self) -> float:
        """Return the share of the records read, 0 to 1."""
        return self._share


class BackgroundEventLog(EventLog):
    """An events file that is read and written in a thread.

    What a disk that hangs does not take is written when it answers. Until then `poll` gives it
    back to this window alone.
    """

    def __init__(self, path: Path, worker: FileWorker) -> None:
        super().__init__(path)
        self._worker = worker
        self._arrived: deque[Event] = deque()
        self._late: list[tuple[Event, Future[object]]] = []
        self._own: list[Event] = []  # late, and still to be given back
        self._error: FlightError | None = None
        self._read()
        worker.repeat(self._read, MONITORS.file_reread)

    def _read(self) -> None:
        try:
            self._arrived.extend(super().poll())
        except FlightError as error:
            self._error = error

    def write_line(self, event: Event, line: str) -> None:
        def write() -> None:
            super(BackgroundEventLog, self).write_line(event, line)
            self._read()

        future = self._worker.submit(write)
        if not future.done():
            own = Event.from_json(json.loads(line))
            self._own.append(own)
            self._late.append((own, future))
        elif (error := future.exception()) is not None:
            raise error

    def refresh(self) -> None:
        self._worker.submit(self._read)

    def poll(self) -> list[Event]:
        error, self._error = self._error, None
        if error is not None:
            raise error
        found, self._own = self._own, []
        for event in [self._arrived.popleft() for _ in range(len(self._arrived))]:
            late = next((one for one in self._late if one[0] == event), None)
            if late is None:
                found.append(event)
            else:
                self._late.remove(late)  # given back before
        for late in [one for one in self._late if one[1].done()]:
            if isinstance(failure := late[1].exception(), FlightError):
                self._late.remove(late)
                self._error = failure
        return found

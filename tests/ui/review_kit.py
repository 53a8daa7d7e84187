"""What the tests of the review share: two short flights, and the work done in this process."""

import threading
import time
from collections.abc import Callable
from typing import Any

from gsapp.identification.campaign import CanceledError
from tests.identification.runs_kit import write_flights
from ui.background_job import JobCanceledError
from ui.job_process.job_server import JobProgressCallback
from ui.review.review_jobs import ReviewJobHandler

__all__ = ["ThreadEngine", "write_flights"]


class ThreadEngine:
    """The bench of the process, at work in a thread: spawning a process takes seconds.

    While `hold` is cleared, a job that reports waits there until it is stopped.
    """

    def __init__(self) -> None:
        self.jobs: list[Any] = []
        self.hold = threading.Event()
        self.hold.set()
        self.closed = False
        self._tell: JobProgressCallback = lambda _share, _words: None
        self._bench = ReviewJobHandler(self._told)

    def _told(self, share: float | None, text: str) -> None:
        self._tell(share, text)
        while not self.hold.is_set():
            time.sleep(0.005)
            self._tell(share, text)

    def do(self, job: Any, tell: Callable[[float | None, str], object]) -> object:
        self.jobs.append(job)
        self._tell = tell
        try:
            return self._bench.do(job)
        except CanceledError as error:
            raise JobCanceledError from error

    def close(self) -> None:
        self.closed = True
        self.hold.set()

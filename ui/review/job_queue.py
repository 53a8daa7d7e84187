"""The jobs of the review, one after the other, with progress, Stop, and nothing that comes late."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

from PySide6.QtCore import QObject, Signal

from ui.background_job import BackgroundJob, JobCanceledError, JobProgress
from ui.job_process.job_runner import JobRunner, ProcessJobRunner
from ui.review.review_worker import serve_review_jobs
from ui.translation import tr


def create_review_job_runner() -> ProcessJobRunner:
    """Return the process of the review; it begins with its first job."""
    return ProcessJobRunner(serve_review_jobs, name=tr("work"), remedy=tr("use fewer flights"))


class RunnableJob(Protocol):
    """Anything that a job runner does."""

    @property
    def title(self) -> str:
        """Return what is being done, in words."""


DoneCallback = Callable[[object], None]
FailedCallback = Callable[[BaseException], None]


@dataclass(slots=True, kw_only=True)
class _QueuedJob:
    """A job with those who want its result, or to know why there is none."""

    job: RunnableJob
    done: list[DoneCallback] = field(default_factory=list)
    failed: list[FailedCallback] = field(default_factory=list)


class JobQueue(QObject):
    """Does jobs in the order in which they are asked for; at most one runs."""

    began = Signal(str)
    progressed = Signal(object, str)
    """Share done or None, and what is being done with the time left."""
    ended = Signal(str, str)
    """Title of the job, and ``done``, ``cancelled`` or ``failed``."""

    def __init__(
        self, job_runner: JobRunner, report_error: FailedCallback, parent: QObject | None = None
    ) -> None:
        super().__init__(parent)
        self._job_runner = job_runner
        self._report_error = report_error
        self._job: BackgroundJob | None = None
        self._now: _QueuedJob | None = None
        self._waiting: list[_QueuedJob] = []

    @property
    def running(self) -> bool:
        return self._job is not None

    @property
    def title(self) -> str:
        """Return what is being done; empty for nothing."""
        return self._job.title if self._job is not None else ""

    def submit(
        self, job: RunnableJob, done: DoneCallback, *, failed: FailedCallback | None = None
    ) -> None:
        """Begin a job, or let it wait; see `ui.review.review_jobs.JobSubmitter`."""
        known = [self._now, *self._waiting]
        asked = next((one for one in known if one is not None and one.job == job), None)
        if asked is None:
            asked = _QueuedJob(job=job)
            self._waiting.append(asked)
        asked.done.append(done)
        if failed is not None:
            asked.failed.append(failed)
        self._next()

    def cancel(self) -> None:
        """Stop the job that runs, and do none of those that wait."""
        waiting, self._waiting = self._waiting, []
        if self._job is not None:
            self._job.cancel()
        for one in waiting:
            _notify_all(one.failed, JobCanceledError())

    def close(self) -> None:
        """Stop everything, as the window closes; nobody is told any more."""
        self._waiting = []
        if self._now is not None:
            self._now.done, self._now.failed = [], []
        if self._job is not None:
            self._job.cancel()
        self._job_runner.close()

    def _next(self) -> None:
        if self._job is not None or not self._waiting:
            return
        asked = self._waiting.pop(0)

        def run(progress: JobProgress) -> object:
            return self._job_runner.do(asked.job, progress)

        work = BackgroundJob(asked.job.title, run, self)
        self._job, self._now = work, asked
        work.progressed.connect(self.progressed)
        work.done.connect(lambda result: self._end("done", asked.done, result))
        work.canceled.connect(lambda: self._end("cancelled", asked.failed, JobCanceledError()))
        work.failed.connect(lambda error: self._failed(asked, error))
        work.start()
        self.began.emit(work.title)

    def _failed(self, asked: _QueuedJob, error: BaseException) -> None:
        self._report_error(error)
        self._end("failed", asked.failed, error)

    def _end(self, how: str, listeners: Sequence[Callable[[Any], None]], what: object) -> None:
        """Say how the job at hand ended, tell those who asked, and go on with the next."""
        title = self.title
        self._job = self._now = None
        self.ended.emit(title, how)
        _notify_all(listeners, what)
        self._next()


def _notify_all(listeners: Sequence[Callable[[Any], None]], what: object) -> None:
    for one in tuple(listeners):
        one(what)

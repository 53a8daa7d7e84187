"""The jobs of the review, one after the other, and what figures have worked out by them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

from PySide6.QtCore import QObject, Signal

from ui.background_job import BackgroundJob, JobCanceledError, JobProgress
from ui.job_process.job_runner import JobRunner, ProcessJobRunner
from ui.review.review_jobs import (
    FtrHistoryJob,
    JobSubmitter,
    LinearModelsJob,
    ReviewJob,
    serve_review_jobs,
)
from ui.translation import QT_TR_NOOP, tr

if TYPE_CHECKING:
    from gsapp.identification.runs.run_execution import RunOutcome
    from gsapp.identification.summary.campaign_linear_models import LinearModelValidation
    from gsapp.report.ftr_histories import FlightEstimateHistory


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
        title = self.title
        self._job = self._now = None
        self.ended.emit(title, how)
        _notify_all(listeners, what)
        self._next()


def _notify_all(listeners: Sequence[Callable[[Any], None]], what: object) -> None:
    for one in tuple(listeners):
        one(what)


_PROGRESS_TEXTS = {
    "ftr_histories": QT_TR_NOOP("Computing FTR over the flights, from take-off…"),
    "comparison": QT_TR_NOOP("Fitting linear models and validating them on held-out maneuvers…"),
}


def _input_key(outcome: RunOutcome) -> tuple[object, ...]:
    """Return what FTR listens to: which flights, read how, and the sums of their files."""
    asked = outcome.request
    return asked.flights, asked.aircraft, asked.calibration, asked.channel_map, outcome.inputs


class FigureComputations(QObject):
    """Has things worked out when a figure first asks for them, once for each run."""

    changed = Signal()

    def __init__(self, begin_job: JobSubmitter, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._begin_job = begin_job
        self._outcome: RunOutcome | None = None
        self._asked: set[str] = set()
        self._refused: dict[str, str] = {}
        self.ftr_histories: tuple[FlightEstimateHistory, ...] | None = None
        self.comparison: LinearModelValidation | None = None

    def reset(self, outcome: RunOutcome) -> None:
        """Look at another run; what was heard over the same flights is kept."""
        if self._outcome is None or _input_key(self._outcome) != _input_key(outcome):
            self.ftr_histories = None
        self.comparison = None
        self._outcome = outcome
        self._asked.clear()
        self._refused.clear()

    def allow_retry(self) -> None:
        """Let what was stopped or failed be asked for once more."""
        self._asked -= self._refused.keys()
        self._refused.clear()

    def request(self, what: str, outcome: RunOutcome) -> str:
        """Have something worked out; return what is being done, or why it was not, in words."""
        if what in self._refused:
            return self._refused[what]
        if what not in self._asked:
            self._asked.add(what)
            job: ReviewJob = (
                FtrHistoryJob(request=outcome.request)
                if what == "ftr_histories"
                else LinearModelsJob(outcome=outcome)
            )
            run = self._outcome
            self._begin_job(
                job,
                lambda result: self._done(what, run, result),
                failed=lambda error: self._failed(what, run, error),
            )
        return self._refused.get(what) or tr(_PROGRESS_TEXTS[what])

    def _done(self, what: str, run: RunOutcome | None, result: object) -> None:
        # Another run is looked at meanwhile: this one came too late.
        if run is self._outcome:
            setattr(self, what, result)
            self._asked.discard(what)
            self.changed.emit()

    def _failed(self, what: str, run: RunOutcome | None, error: BaseException) -> None:
        if run is self._outcome:
            why = tr("stopped") if isinstance(error, JobCanceledError) else str(error)
            self._refused[what] = tr(
                "Not computed: {why}. Choose this figure again to retry."
            ).format(why=why)
            self.changed.emit()

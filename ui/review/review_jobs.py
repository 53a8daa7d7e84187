"""What the review has done for it in a process of its own, and that process. No Qt."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from gsapp.foundation import GroundStationError
from ui.job_process.job_server import JobProgressCallback, StopEvent, serve_jobs
from ui.translation import QT_TR_NOOP, tr
from ui.virtual_flight_simulation import simulate_virtual_flight

if TYPE_CHECKING:
    from gsapp.identification.runs.inputs import FlightCache
    from gsapp.identification.runs.request import RunRequest
    from gsapp.identification.runs.run_comparison import RepeatedRun
    from gsapp.identification.runs.run_execution import RunOutcome
    from gsapp.identification.summary.campaign_linear_models import LinearModelValidation
    from gsapp.report.ftr_histories import FlightEstimateHistory

NOT_STORED_TEXT = "the run is not saved"
"""Begins the remark of an outcome that the catalog did not take."""


@dataclass(frozen=True, slots=True, kw_only=True)
class EstimateJob:
    """Estimate, and keep the run in a catalog; the result is an `RunOutcome`.

    What cannot be kept is an outcome all the same: without a number, with a remark.
    """

    request: RunRequest
    catalog: Path | None = None
    """None keeps nothing."""

    @property
    def title(self) -> str:
        return (
            tr("Estimating {label}").format(label=self.request.label)
            if self.request.label
            else tr("Estimating")
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class RepeatJob:
    """Do a kept run again from what it was asked for; the result is a `RepeatedRun`."""

    catalog: Path
    number: int

    @property
    def title(self) -> str:
        return tr("Repeating run {number}").format(number=self.number)


@dataclass(frozen=True, slots=True, kw_only=True)
class FtrHistoryJob:
    """Compute FTR over the flights of a request: a tuple of `FlightEstimateHistory`."""

    request: RunRequest

    @property
    def title(self) -> str:
        return tr("Computing FTR over the flights")


@dataclass(frozen=True, slots=True, kw_only=True)
class LinearModelsJob:
    """Hold linear models against flight; the result is a `LinearModelValidation`."""

    outcome: RunOutcome
    validate: tuple[Path, ...] = ()
    """Flights kept out of the fits; empty lets the comparison choose."""

    @property
    def title(self) -> str:
        return tr("Comparing linear models with flight")


@dataclass(frozen=True, slots=True, kw_only=True)
class RunReportJob:
    """Write the report of an outcome; the result is the path written."""

    outcome: RunOutcome
    path: Path
    """HTML, PDF or a folder."""
    units: str = "US"
    ftr_histories: tuple[FlightEstimateHistory, ...] | None = None
    linear: LinearModelValidation | None = None
    """What came of a `FtrHistoryJob` and a `LinearModelsJob` of the same outcome; done for the
    report where not given."""

    @property
    def title(self) -> str:
        return tr("Writing {name}").format(name=self.path.name)


@dataclass(frozen=True, slots=True, kw_only=True)
class VirtualFlightJob:
    """Let the virtual aircraft fly a flight to try the review on; the result is its folder."""

    folder: Path

    @property
    def title(self) -> str:
        return tr("Flying the virtual aircraft")


ReviewJob = (
    EstimateJob | RepeatJob | FtrHistoryJob | LinearModelsJob | RunReportJob | VirtualFlightJob
)


class JobSubmitter(Protocol):
    """How a page has something done: jobs are done one after the other, in the order asked."""

    def __call__(
        self,
        job: ReviewJob,
        done: Callable[[object], None],
        *,
        failed: Callable[[BaseException], None] | None = None,
    ) -> None:
        """Begin a job after those before it; one that is asked for twice is done once.

        `failed` receives why there is no result, `ui.background_job.JobCanceledError` where it was
        stopped. The window tells of errors in any case.
        """


_READ_SHARE, _FIT_SHARE = 0.2, 0.98
"""Shares of the bar when the flights are read, and when all is fitted."""


def serve_review_jobs(connection: Connection, stop: StopEvent) -> None:
    """Do jobs until the window hangs up; see `ui.job_process.job_server.serve_jobs`."""
    serve_jobs(connection, stop, ReviewJobHandler)


class ReviewJobHandler:
    """Does jobs one after the other and keeps the flights for the next."""

    def __init__(self, tell: JobProgressCallback) -> None:
        self._report_progress = tell
        self._flight_cache: FlightCache | None = None

    def do(self, job: ReviewJob) -> object:
        match job:
            case EstimateJob():
                return self._estimate(job)
            case RepeatJob():
                return self._repeat(job)
            case FtrHistoryJob():
                return self._compute_ftr_histories(job)
            case LinearModelsJob():
                return self._compare(job)
            case RunReportJob():
                return self._report(job)
            case VirtualFlightJob():
                return simulate_virtual_flight(job.folder, self._report_progress, hide="")

    @property
    def flights(self) -> FlightCache:
        if self._flight_cache is None:
            from gsapp.identification.runs.inputs import FlightCache

            self._flight_cache = FlightCache()
        return self._flight_cache

    def _estimate(self, job: EstimateJob) -> RunOutcome:
        from gsapp.flight.catalog import Catalog
        from gsapp.identification.runs.run_execution import execute_run
        from gsapp.identification.runs.run_store import save_run

        outcome = execute_run(
            job.request,
            flights=self.flights,
            doing=_ReadProgress(self._report_progress, len(job.request.flights)),
            progress=self._report_fit,
        )
        if job.catalog is None:
            return outcome
        self._report_progress(_FIT_SHARE, QT_TR_NOOP("saving the run"))
        try:
            job.catalog.parent.mkdir(parents=True, exist_ok=True)
            with Catalog(job.catalog) as catalog:
                return replace(outcome, number=save_run(catalog, outcome))
        except (GroundStationError, OSError) as error:
            # What was estimated is there all the same.
            return replace(outcome, remarks=(*outcome.remarks, f"{NOT_STORED_TEXT}: {error}"))

    def _repeat(self, job: RepeatJob) -> RepeatedRun:
        from gsapp.flight.catalog import Catalog
        from gsapp.identification.runs.run_comparison import repeat_run

        with Catalog(job.catalog) as catalog:
            return repeat_run(
                catalog,
                job.number,
                flights=self.flights,
                doing=_ReadProgress(self._report_progress, 1),
                progress=self._report_fit,
            )

    def _compute_ftr_histories(self, job: FtrHistoryJob) -> tuple[FlightEstimateHistory, ...]:
        from gsapp.identification.runs.inputs import flight_open_requests
        from gsapp.report.ftr_histories import compute_ftr_histories

        openings = flight_open_requests(job.request)
        reading = _ReadProgress(self._report_progress, len(openings))
        opened = [self.flights.open(one, doing=reading).opened for one in openings]
        listening = _ReadProgress(
            self._report_progress, len(openings), since=_READ_SHARE, until=1.0, each=1
        )
        return compute_ftr_histories(
            [(one.flight, one.aircraft) for one in opened], most=None, doing=listening
        )

    def _compare(self, job: LinearModelsJob) -> LinearModelValidation:
        from gsapp.report.linear_text import compare_linear_models

        return compare_linear_models(
            job.outcome, job.validate, flights=self.flights, progress=self._report_step
        )

    def _report(self, job: RunReportJob) -> Path:
        from gsapp.flight.info import local_timestamp
        from gsapp.report.campaign_report import write_campaign_report

        written = write_campaign_report(
            job.outcome,
            job.path,
            units="SI" if job.units == "SI" else "US",
            written=local_timestamp(),
            ftr_histories=job.ftr_histories,
            linear=job.linear,
            flights=self.flights,
            progress=self._report_step,
        )
        return written[0] if len(written) == 1 else job.path

    def _report_fit(self, done: int, total: int, what: str) -> bool:
        share = done / total if total else 1.0
        self._report_progress(
            _READ_SHARE + (_FIT_SHARE - _READ_SHARE) * share,
            what or QT_TR_NOOP("computing the summary"),
        )
        return True

    def _report_step(self, done: int, total: int, what: str) -> bool:
        self._report_progress(done / total if total else 1.0, what)
        return True


class _ReadProgress:
    """Tells of flights that are read, each in steps: it is opened, maneuvers are looked for."""

    def __init__(
        self,
        tell: JobProgressCallback,
        flights: int,
        *,
        since: float = 0.0,
        until: float = _READ_SHARE,
        each: int = 2,
    ) -> None:
        self._report_progress = tell
        self._steps = max(flights * each, 1)
        self._from, self._room = since, until - since
        self._done = 0

    def __call__(self, words: str) -> None:
        self._report_progress(self._from + self._room * min(self._done / self._steps, 1.0), words)
        self._done += 1

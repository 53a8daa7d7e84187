"""The process of the review: it keeps the opened flights for the runs that follow. No Qt."""

from __future__ import annotations

from dataclasses import replace
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING

from gsapp.foundation import GroundStationError
from ui.job_process.job_server import JobProgressCallback, StopEvent, serve_jobs
from ui.review.review_jobs import (
    NOT_STORED_TEXT,
    EstimateJob,
    FtrHistoryJob,
    LinearModelsJob,
    RepeatJob,
    ReviewJob,
    RunReportJob,
    VirtualFlightJob,
)
from ui.translation import QT_TR_NOOP
from ui.virtual_flight_simulation import simulate_virtual_flight

if TYPE_CHECKING:
    from gsapp.identification.runs.inputs import FlightCache
    from gsapp.identification.runs.run_comparison import RepeatedRun
    from gsapp.identification.runs.run_execution import RunOutcome
    from gsapp.report.ftr_histories import FlightEstimateHistory
    from gsapp.report.linear_report import LinearModelValidation

_READ_SHARE, _FIT_SHARE = 0.2, 0.98
"""Shares of the bar when the flights are read, and when all is fitted."""


def serve_review_jobs(connection: Connection, stop: StopEvent) -> None:
    """Do jobs until the window hangs up; see `ui.job_process.job_server.serve_jobs`."""
    serve_jobs(connection, stop, ReviewJobHandler)


class ReviewJobHandler:
    """Does jobs one after the other and keeps the flights for the next.

    Parameters
    ----------
    tell : callable
        Says how far the job is; raises where the window does not want it any more.
    """

    def __init__(self, tell: JobProgressCallback) -> None:
        self._report_progress = tell
        self._flight_cache: FlightCache | None = None

    def do(self, job: ReviewJob) -> object:
        """Do one job and return its result."""
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
        """Return the flights that are open."""
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
        from gsapp.report.linear_report import compare_linear_models

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
    """Tells of flights that are read; of each, what is done in so many steps.

    Parameters
    ----------
    tell : callable
    flights : int
    since, until : float
        Share of the bar.
    each : int
        Steps of a flight: it is opened, then its maneuvers are looked for.
    """

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

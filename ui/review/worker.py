"""The process of the review: it keeps the opened flights for the runs that follow. No Qt."""

from __future__ import annotations

from dataclasses import replace
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING

from gsapp.foundation import GroundStationError
from ui.gap.trial import fly_trial
from ui.process.serving import Stop, Tell, serve_jobs
from ui.review.jobs import (
    NOT_KEPT,
    EstimateJob,
    HearJob,
    Job,
    LinearJob,
    RepeatJob,
    ReportJob,
    TrialJob,
)

if TYPE_CHECKING:
    from gsapp.identification.runs.outcome import Outcome
    from gsapp.identification.runs.repeating import Repeated
    from gsapp.identification.runs.shelf import FlightShelf
    from gsapp.report.hearing import Heard
    from gsapp.report.linear_report import LinearComparison

_READ, _FITTED = 0.2, 0.98
"""Shares of the bar when the flights are read, and when all is fitted."""


def serve(connection: Connection, stop: Stop) -> None:
    """Do jobs until the window hangs up; see `ui.process.serving.serve_jobs`."""
    serve_jobs(connection, stop, ReviewBench)


class ReviewBench:
    """Does jobs one after the other and keeps the flights for the next.

    Parameters
    ----------
    tell : callable
        Says how far the job is; raises where the window does not want it any more.
    """

    def __init__(self, tell: Tell) -> None:
        self._tell = tell
        self._shelf: FlightShelf | None = None

    def do(self, job: Job) -> object:
        """Do one job and return its result."""
        match job:
            case EstimateJob():
                return self._estimate(job)
            case RepeatJob():
                return self._repeat(job)
            case HearJob():
                return self._hear(job)
            case LinearJob():
                return self._compare(job)
            case ReportJob():
                return self._report(job)
            case TrialJob():
                return fly_trial(job.folder, self._tell, hide="")

    @property
    def flights(self) -> FlightShelf:
        """Return the flights that are open."""
        if self._shelf is None:
            from gsapp.identification.runs.shelf import FlightShelf

            self._shelf = FlightShelf()
        return self._shelf

    def _estimate(self, job: EstimateJob) -> Outcome:
        from gsapp.flight.catalog import Catalog
        from gsapp.identification.runs.keeping import keep
        from gsapp.identification.runs.running import run

        outcome = run(
            job.request,
            flights=self.flights,
            doing=_Reading(self._tell, len(job.request.flights)),
            progress=self._fitting,
        )
        if job.catalog is None:
            return outcome
        self._tell(_FITTED, "keeping the run")
        try:
            job.catalog.parent.mkdir(parents=True, exist_ok=True)
            with Catalog(job.catalog) as catalog:
                return replace(outcome, number=keep(catalog, outcome))
        except (GroundStationError, OSError) as error:
            # What was estimated is there all the same.
            return replace(outcome, remarks=(*outcome.remarks, f"{NOT_KEPT}: {error}"))

    def _repeat(self, job: RepeatJob) -> Repeated:
        from gsapp.flight.catalog import Catalog
        from gsapp.identification.runs.repeating import repeat

        with Catalog(job.catalog) as catalog:
            return repeat(
                catalog,
                job.number,
                flights=self.flights,
                doing=_Reading(self._tell, 1),
                progress=self._fitting,
            )

    def _hear(self, job: HearJob) -> tuple[Heard, ...]:
        from gsapp.identification.runs.inputs import openings_of
        from gsapp.report.hearing import hear

        openings = openings_of(job.request)
        reading = _Reading(self._tell, len(openings))
        opened = [self.flights.open(one, doing=reading).opened for one in openings]
        listening = _Reading(self._tell, len(openings), since=_READ, until=1.0, each=1)
        return hear([(one.flight, one.aircraft) for one in opened], most=None, doing=listening)

    def _compare(self, job: LinearJob) -> LinearComparison:
        from gsapp.report.linear_report import compare_linear_models

        return compare_linear_models(
            job.outcome, job.validate, flights=self.flights, progress=self._stepping
        )

    def _report(self, job: ReportJob) -> Path:
        from gsapp.flight.info import now
        from gsapp.report.campaign_writing import write_campaign_report

        written = write_campaign_report(
            job.outcome,
            job.path,
            units="SI" if job.units == "SI" else "US",
            written=now(),
            heard=job.heard,
            linear=job.linear,
            flights=self.flights,
            progress=self._stepping,
        )
        return written[0] if len(written) == 1 else job.path

    def _fitting(self, done: int, total: int, what: str) -> bool:
        share = done / total if total else 1.0
        self._tell(_READ + (_FITTED - _READ) * share, what or "summing up")
        return True

    def _stepping(self, done: int, total: int, what: str) -> bool:
        self._tell(done / total if total else 1.0, what)
        return True


class _Reading:
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
        tell: Tell,
        flights: int,
        *,
        since: float = 0.0,
        until: float = _READ,
        each: int = 2,
    ) -> None:
        self._tell = tell
        self._steps = max(flights * each, 1)
        self._from, self._room = since, until - since
        self._done = 0

    def __call__(self, words: str) -> None:
        self._tell(self._from + self._room * min(self._done / self._steps, 1.0), words)
        self._done += 1

"""The process that searches: it keeps the prepared flights, to look again quickly. No Qt."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from gsapp.discrepancy.settings import (
    DiscrepancySettings,
    SearchProgress,
    SearchProgressCallback,
    SearchStoppedError,
)
from gsapp.foundation import GroundStationError
from ui.gap.search_request import EffectInfo, GapRequest, SearchResult
from ui.job_process.job_server import JobProgressCallback, JobStoppedError, StopEvent, serve_jobs
from ui.translation import QT_TR_NOOP

if TYPE_CHECKING:
    from gsapp.aircraft import Aircraft
    from gsapp.discrepancy.results import DiscrepancyResult
    from gsapp.dynamics.model import Model
    from gsapp.identification.maneuver import Maneuver

_READ_SHARE = 0.15
"""Share of the bar that reading the flights takes."""


class PreparedSearch(Protocol):
    """A prepared search; see `gsapp.discrepancy.investigation.Investigation`."""

    def run(
        self, settings: DiscrepancySettings, *, progress: SearchProgressCallback | None = None
    ) -> DiscrepancyResult:
        """Search, and return the result."""


PrepareSearch = Callable[[Sequence["Maneuver"], "Aircraft", "Model | None"], PreparedSearch]


@dataclass(frozen=True, slots=True, kw_only=True)
class GapReportJob:
    """Write the report of a result, its channels in ``US`` or ``SI`` units."""

    result: SearchResult
    path: Path
    units: str = "US"


GapJob = GapRequest | GapReportJob


def serve_gap_jobs(
    connection: Connection, stop: StopEvent, prepare: PrepareSearch | None = None
) -> None:
    """Do jobs until the window hangs up; see `ui.job_process.job_server.serve_jobs`.

    Parameters
    ----------
    connection : Connection
        Jobs come in, `Told` goes out.
    stop : StopEvent
        Set by the window to stop the job at hand.
    prepare : callable, optional
        Makes a search of maneuvers, aircraft and model; that of `gsapp.discrepancy` by default.
    """
    serve_jobs(
        connection, stop, lambda tell: GapJobHandler(tell, prepare or _prepare_investigation)
    )


def _prepare_investigation(
    maneuvers: Sequence[Maneuver], aircraft: Aircraft, model: Model | None
) -> PreparedSearch:
    """Return the program's own search."""
    from gsapp.discrepancy.investigation import Investigation

    return Investigation(maneuvers, aircraft, model)


class GapJobHandler:
    """Does jobs one after the other and keeps what the next may need.

    Parameters
    ----------
    tell : callable
        Says how far the job is; raises where the window does not want it any more.
    prepare : callable
        Makes a search.
    """

    def __init__(self, tell: JobProgressCallback, prepare: PrepareSearch) -> None:
        self._report_progress = tell
        self._prepare = prepare
        self._request: GapRequest | None = None
        self._search: PreparedSearch | None = None
        self._remarks: tuple[str, ...] = ()
        self._notes: Mapping[str, EffectInfo] = {}
        self._kinds: Mapping[str, str] = {}
        self._aircraft = ""

    def do(self, job: GapJob) -> SearchResult | Path:
        """Do one job and return its result."""
        if isinstance(job, GapReportJob):
            return self._write(job)
        return self._look(job)

    def _look(self, request: GapRequest) -> SearchResult:
        if self._search is None or self._request != request.undecided:
            self._search = None
            self._search = self._read(request)
            self._request = request.undecided

        def step(progress: SearchProgress) -> bool:
            self._report_progress(
                _READ_SHARE + (1.0 - _READ_SHARE) * progress.share, progress.activity
            )
            return True

        try:
            found = self._search.run(request, progress=step)
        except SearchStoppedError as error:
            raise JobStoppedError from error
        return SearchResult(
            request=request,
            discrepancy=found,
            effect_infos=self._notes,
            remarks=self._remarks,
            kinds=self._kinds,
            aircraft=self._aircraft,
        )

    def _read(self, request: GapRequest) -> PreparedSearch:
        """Open the flights, cut their maneuvers, and prepare the search."""
        from gsapp.identification.maneuver import open_flights_with_maneuvers

        steps = 2 * len(request.flights) + 2
        done = 0

        def doing(words: str) -> None:
            nonlocal done
            self._report_progress(_READ_SHARE * done / steps, words)
            done += 1

        doing(QT_TR_NOOP("starting"))
        flown = open_flights_with_maneuvers(request.flights, request, doing=doing)
        maneuvers = [one for flight in flown for one in flight.maneuvers]
        if not maneuvers:
            names = ", ".join(path.name for path in request.flights)
            raise GroundStationError(
                f"no maneuvers were found in {names}: fly doublets of elevator, aileron and "
                "rudder from trim, each followed by two seconds hands off"
            )
        several = len(flown) > 1
        self._remarks = tuple(
            f"{one.flight.name}: {remark}" if several else remark
            for one in flown
            for remark in one.remarks
        )
        self._kinds = {
            one.id: " ".join(filter(None, ("+".join(one.inputs), one.kind))) for one in maneuvers
        }
        self._aircraft = flown[0].aircraft.name
        doing(QT_TR_NOOP("preparing the maneuvers"))
        model = _load_model(request.model) if request.model else None
        search = self._prepare(maneuvers, flown[0].aircraft, model)
        self._notes = load_effect_infos()
        return search

    def _write(self, job: GapReportJob) -> Path:
        self._report_progress(None, QT_TR_NOOP("drawing the figures"))
        return write_gap_report(job)


def _load_model(name: str) -> Model:
    from gsapp.dynamics.model import load_model

    return load_model(name)


def write_gap_report(job: GapReportJob) -> Path:
    """Write the report of a result, with the files that it was made from.

    Raises
    ------
    GroundStationError
        If the file's ending is none that a report can have.
    OSError
        If the file cannot be written.
    """
    from gsapp.flight.info import local_timestamp
    from gsapp.report import discrepancy_report
    from gsapp.report.discrepancy_provenance import search_provenance

    result, request = job.result, job.result.request
    provenance = search_provenance(request.flights, request)
    written = discrepancy_report.write_discrepancy_report(
        result.discrepancy,
        job.path,
        aircraft=result.aircraft,
        provenance=provenance,
        units="SI" if job.units == "SI" else "US",
        written=local_timestamp(),
    )
    return written[0] if written else job.path


def load_effect_infos() -> dict[str, EffectInfo]:
    """Return what the catalog says of every effect, by id."""
    from gsapp.discrepancy.effect_catalog import all_effects

    return {
        record.id: EffectInfo(
            effect=record.id,
            title=record.title,
            equation=record.equation,
            mistaken_for=tuple(record.mistaken_for),
            distinguished_by=record.separated_by,
            remedy=record.remedy,
            units={one.name: one.unit for one in record.parameters},
        )
        for record in all_effects()
        if not record.disturbance
    }

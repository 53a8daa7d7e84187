"""The process that searches: it keeps the prepared flights, to look again quickly. No Qt."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from gsapp.foundation import GroundStationError
from ui.gap.request import Answer, Decisions, EffectNote, GapRequest
from ui.process.serving import Stop, StoppedError, Tell, serve_jobs

if TYPE_CHECKING:
    from gsapp.aircraft import Aircraft
    from gsapp.discrepancy.results import Discrepancy
    from gsapp.discrepancy.settings import Callback, DiscrepancySettings
    from gsapp.dynamics.model import Model
    from gsapp.identification.maneuver import Maneuver

_READING = 0.15
"""Share of the bar that reading the flights takes."""


class Search(Protocol):
    """A prepared search; see `gsapp.discrepancy.workflow.Investigation`."""

    def run(
        self, settings: DiscrepancySettings, *, progress: Callback | None = None
    ) -> Discrepancy:
        """Search, and return the answer."""


Prepare = Callable[[Sequence["Maneuver"], "Aircraft", "Model | None"], Search]


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchJob:
    """Search these flights with these decisions."""

    request: GapRequest
    decisions: Decisions


@dataclass(frozen=True, slots=True, kw_only=True)
class ReportJob:
    """Write the report of an answer, its channels in ``US`` or ``SI`` units."""

    answer: Answer
    path: Path
    units: str = "US"


Job = SearchJob | ReportJob


def serve(connection: Connection, stop: Stop, prepare: Prepare | None = None) -> None:
    """Do jobs until the window hangs up; see `ui.process.serving.serve_jobs`.

    Parameters
    ----------
    connection : Connection
        Jobs come in, `Told` goes out.
    stop : Stop
        Set by the window to stop the job at hand.
    prepare : callable, optional
        Makes a search of maneuvers, aircraft and model; that of `gsapp.discrepancy` by default.
    """
    serve_jobs(connection, stop, lambda tell: Bench(tell, prepare or _investigation))


def _investigation(
    maneuvers: Sequence[Maneuver], aircraft: Aircraft, model: Model | None
) -> Search:
    """Return the program's own search."""
    from gsapp.discrepancy.workflow import Investigation

    return Investigation(maneuvers, aircraft, model)


class Bench:
    """Does jobs one after the other and keeps what the next may need.

    Parameters
    ----------
    tell : callable
        Says how far the job is; raises where the window does not want it any more.
    prepare : callable
        Makes a search.
    """

    def __init__(self, tell: Tell, prepare: Prepare) -> None:
        self._tell = tell
        self._prepare = prepare
        self._request: GapRequest | None = None
        self._search: Search | None = None
        self._remarks: tuple[str, ...] = ()
        self._notes: Mapping[str, EffectNote] = {}
        self._kinds: Mapping[str, str] = {}
        self._aircraft = ""

    def do(self, job: Job) -> Answer | Path:
        """Do one job and return its result."""
        if isinstance(job, ReportJob):
            return self._write(job)
        return self._look(job)

    def _look(self, job: SearchJob) -> Answer:
        from gsapp.discrepancy.settings import (
            DiscrepancySettings,
            Progress,
            SearchStoppedError,
        )

        if self._search is None or self._request != job.request:
            self._search = None
            self._search = self._read(job.request)
            self._request = job.request

        def step(progress: Progress) -> bool:
            self._tell(_READING + (1.0 - _READING) * progress.share, progress.doing)
            return True

        settings = DiscrepancySettings(
            model=None if not job.request.model else _model(job.request.model),
            refused=job.decisions.refused,
            forced=job.decisions.forced,
            check_instruments=True,
        )
        try:
            found = self._search.run(settings, progress=step)
        except SearchStoppedError as error:
            raise StoppedError from error
        return Answer(
            request=job.request,
            decisions=job.decisions,
            discrepancy=found,
            notes=self._notes,
            remarks=self._remarks,
            kinds=self._kinds,
            aircraft=self._aircraft,
        )

    def _read(self, request: GapRequest) -> Search:
        """Open the flights, cut their maneuvers, and prepare the search."""
        from gsapp.identification.flights import flown_flights

        steps = 2 * len(request.flights) + 2
        done = 0

        def doing(words: str) -> None:
            nonlocal done
            self._tell(_READING * done / steps, words)
            done += 1

        doing("starting")
        flown = flown_flights(
            request.flights,
            aircraft=request.aircraft or None,
            channel_map=request.channel_map or None,
            doing=doing,
        )
        maneuvers = [one for flight in flown for one in flight.maneuvers]
        if not maneuvers:
            names = ", ".join(path.name for path in request.flights)
            raise GroundStationError(
                f"no maneuvers were found in {names}: fly doublets of elevator, aileron and "
                "rudder from trim, each left alone for two seconds or more"
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
        doing("preparing the maneuvers")
        model = _model(request.model) if request.model else None
        search = self._prepare(maneuvers, flown[0].aircraft, model)
        self._notes = effect_notes()
        return search

    def _write(self, job: ReportJob) -> Path:
        self._tell(None, "drawing the figures")
        return write_report(job)


def _model(name: str) -> Model:
    from gsapp.dynamics.model import load_model

    return load_model(name)


def write_report(job: ReportJob) -> Path:
    """Write the report of an answer, with the files that it was made from.

    Raises
    ------
    GroundStationError
        If the file's ending is none that a report can have.
    OSError
        If the file cannot be written.
    """
    from gsapp.discrepancy.settings import DiscrepancySettings
    from gsapp.flight.info import now
    from gsapp.report import discrepancy_report
    from gsapp.report.discrepancy_inputs import search_provenance

    answer, request = job.answer, job.answer.request
    provenance = search_provenance(
        request.flights,
        DiscrepancySettings(refused=answer.decisions.refused, forced=answer.decisions.forced),
        aircraft=request.aircraft or None,
        model=request.model or None,
        channel_map=request.channel_map or None,
    )
    written = discrepancy_report.write_report(
        answer.discrepancy,
        job.path,
        aircraft=answer.aircraft,
        provenance=provenance,
        units="SI" if job.units == "SI" else "US",
        written=now(),
    )
    return written[0] if written else job.path


def effect_notes() -> dict[str, EffectNote]:
    """Return what the catalog says of every effect, by id."""
    from gsapp.discrepancy.catalog import catalog

    return {
        record.id: EffectNote(
            effect=record.id,
            title=record.title,
            equation=record.equation,
            mistaken_for=tuple(record.mistaken_for),
            told_apart=record.separated_by,
            remedy=record.remedy,
            units={one.name: one.unit for one in record.parameters},
        )
        for record in catalog()
        if not record.disturbance
    }

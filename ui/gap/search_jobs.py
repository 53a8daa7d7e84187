"""What a search is asked for and what comes back, and the process that searches. No Qt."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
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
from ui.job_process.job_server import JobProgressCallback, JobStoppedError, StopEvent, serve_jobs
from ui.translation import QT_TR_NOOP, tr

if TYPE_CHECKING:
    from gsapp.aircraft import Aircraft
    from gsapp.discrepancy.results import DiscrepancyResult
    from gsapp.dynamics.model import Model
    from gsapp.identification.maneuver import Maneuver


class GapRequest(DiscrepancySettings):
    """Flights to search, and the settings, with what the crew decided about effects."""

    flights: tuple[Path, ...]
    check_instruments: bool = True

    @property
    def text(self) -> str:
        """Return what is searched: ``flight 3 and 2 more · model b777``."""
        names = [path.name for path in self.flights]
        more = tr(" and {count} more").format(count=len(names) - 1) if len(names) > 1 else ""
        model = (
            tr("model {stem}").format(stem=Path(self.model).stem)
            if self.model
            else tr("baseline fitted here")
        )
        return f"{names[0]}{more} · {model}" if names else model

    @property
    def undecided(self) -> GapRequest:
        return self.with_changes(refused=(), forced=())

    def refuse(self, effect: str) -> GapRequest:
        """Return the request with that effect refused, and no longer forced."""
        kept = tuple(known for known in self.forced if known != effect)
        others = tuple(known for known in self.refused if known != effect)
        return self.with_changes(refused=(*others, effect), forced=kept)

    def force(self, effect: str) -> GapRequest:
        """Return the request with that effect forced, and no longer refused."""
        kept = tuple(known for known in self.refused if known != effect)
        others = tuple(known for known in self.forced if known != effect)
        return self.with_changes(refused=kept, forced=(*others, effect))


@dataclass(frozen=True, slots=True, kw_only=True)
class EffectInfo:
    """What the catalog says of an effect."""

    effect: str
    title: str
    equation: str = ""
    mistaken_for: tuple[str, ...] = ()
    """Ids of effects that it is taken for, or words."""
    distinguished_by: str = ""
    remedy: str = ""
    """The measurement on the ground that settles it; empty where flying does."""
    units: Mapping[str, str]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SearchResult:
    """What a search gave."""

    request: GapRequest
    discrepancy: DiscrepancyResult
    effect_infos: Mapping[str, EffectInfo]
    remarks: tuple[str, ...] = ()
    """About the flights: maneuvers left out, channels missing."""
    kinds: Mapping[str, str] = field(default_factory=dict)
    """Surfaces and shape of each maneuver, ``de doublet``, by its id."""
    aircraft: str = ""

    def continues(self, former: SearchResult) -> bool:
        """Return whether only decisions lie between a former answer and this one."""
        return self.request.undecided == former.request.undecided

    def title(self, effect: str) -> str:
        """Return an effect in a field engineer's words; its id where nobody knows any."""
        note = self.effect_infos.get(effect)
        if note is not None and note.title:
            return note.title
        for found in self.discrepancy.effects:
            if found.effect == effect:
                return found.title
        for step in self.discrepancy.steps:
            for candidate in step.ranking:
                if candidate.effect == effect:
                    return candidate.title
        return effect


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
    """Do jobs until the window hangs up; `prepare` makes a search, by default the program's own."""
    serve_jobs(
        connection, stop, lambda tell: GapJobHandler(tell, prepare or _prepare_investigation)
    )


def _prepare_investigation(
    maneuvers: Sequence[Maneuver], aircraft: Aircraft, model: Model | None
) -> PreparedSearch:
    from gsapp.discrepancy.investigation import Investigation

    return Investigation(maneuvers, aircraft, model)


class GapJobHandler:
    """Does jobs one after the other and keeps what the next may need."""

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
        if isinstance(job, GapReportJob):
            return self._write(job)
        return self._search_flights(job)

    def _search_flights(self, request: GapRequest) -> SearchResult:
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
        from gsapp.dynamics.model import load_model
        from gsapp.identification.maneuver import open_flights_with_maneuvers

        steps = 2 * len(request.flights) + 2
        done = 0

        def doing(text: str) -> None:
            nonlocal done
            self._report_progress(_READ_SHARE * done / steps, text)
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
        model = load_model(request.model) if request.model else None
        search = self._prepare(maneuvers, flown[0].aircraft, model)
        self._notes = load_effect_infos()
        return search

    def _write(self, job: GapReportJob) -> Path:
        """Write the report of a result, with the files that it was made from."""
        from gsapp.flight.info import local_timestamp
        from gsapp.report import discrepancy_report
        from gsapp.report.provenance import search_provenance

        self._report_progress(None, QT_TR_NOOP("drawing the figures"))
        result, request = job.result, job.result.request
        written = discrepancy_report.write_discrepancy_report(
            result.discrepancy,
            job.path,
            aircraft=result.aircraft,
            provenance=search_provenance(request.flights, request),
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

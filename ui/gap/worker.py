"""The process that searches: it keeps the prepared flights, so that a second look is quick. No Qt.

The window sends a job and receives reports until one of them ends it. Stopping is asked for by an
event that both share; a process that does not obey is ended by the window.
"""

from __future__ import annotations

import contextlib
import os
import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING, Literal, Protocol

from gsapp.foundation import GroundStationError
from ui.gap.request import Answer, Decisions, EffectNote, GapRequest

if TYPE_CHECKING:
    from gsapp.aircraft import Aircraft
    from gsapp.discrepancy.results import Discrepancy
    from gsapp.discrepancy.settings import Callback, DiscrepancySettings
    from gsapp.dynamics.model import Model
    from gsapp.identification.maneuver import Maneuver

_READING = 0.15
"""Share of the bar that reading the flights takes."""


class Stop(Protocol):
    """An event of another process."""

    def is_set(self) -> bool:
        """Return whether stopping was asked for."""


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


@dataclass(frozen=True, slots=True, kw_only=True)
class Told:
    """How far a job is, or how it ended.

    Attributes
    ----------
    kind : {"doing", "done", "failed", "stopped"}
    share : float or None
        Of the work, 0 to 1; None where nobody knows.
    words : str
        What is being done, or why it failed.
    expected : bool
        Whether it failed for a reason the program knows.
    details : str
        For the log.
    result : Answer, Path or None
    """

    kind: Literal["doing", "done", "failed", "stopped"]
    share: float | None = None
    words: str = ""
    expected: bool = True
    details: str = ""
    result: Answer | Path | None = None


class StoppedError(Exception):
    """The window asked to stop."""


def serve(connection: Connection, stop: Stop, prepare: Prepare | None = None) -> None:
    """Do jobs until the window hangs up.

    Parameters
    ----------
    connection : Connection
        Jobs come in, `Told` goes out.
    stop : Stop
        Set by the window to stop the job at hand.
    prepare : callable, optional
        Makes a search of maneuvers, aircraft and model; that of `gsapp.discrepancy` by default.
    """
    with contextlib.suppress(AttributeError, OSError):
        # The charts come first on a machine with few cores.
        os.nice(5)
    bench = Bench(connection, stop, prepare or _investigation)
    with contextlib.suppress(EOFError, OSError):
        while True:
            job = connection.recv()
            try:
                told = Told(kind="done", share=1.0, result=bench.do(job))
            except StoppedError:
                told = Told(kind="stopped")
            except Exception as error:  # every failure is told in the window
                told = _failure(error)
            connection.send(told)


def _failure(error: Exception) -> Told:
    if type(error).__name__ == "SearchStoppedError":
        return Told(kind="stopped")
    known = isinstance(error, (GroundStationError, OSError))
    return Told(
        kind="failed",
        words=str(error) or type(error).__name__,
        expected=known,
        details="".join(traceback.format_exception(error)),
    )


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
    connection : Connection
        Where progress is told.
    stop : Stop
        Whether to stop.
    prepare : callable
        Makes a search.
    """

    def __init__(self, connection: Connection, stop: Stop, prepare: Prepare) -> None:
        self._connection = connection
        self._stop = stop
        self._prepare = prepare
        self._request: GapRequest | None = None
        self._search: Search | None = None
        self._remarks: tuple[str, ...] = ()
        self._notes: Mapping[str, EffectNote] = {}
        self._kinds: Mapping[str, str] = {}
        self._aircraft = ""

    def tell(self, share: float | None, words: str) -> None:
        """Say how far the job is; raises if the window does not want it any more."""
        if self._stop.is_set():
            raise StoppedError
        self._connection.send(Told(kind="doing", share=share, words=words))

    def do(self, job: Job) -> Answer | Path:
        """Do one job and return its result."""
        if isinstance(job, ReportJob):
            return self._write(job)
        return self._look(job)

    def _look(self, job: SearchJob) -> Answer:
        from gsapp.discrepancy.settings import DiscrepancySettings, Progress

        if self._search is None or self._request != job.request:
            self._search = None
            self._search = self._read(job.request)
            self._request = job.request

        def step(progress: Progress) -> bool:
            self.tell(_READING + (1.0 - _READING) * progress.share, progress.doing)
            return True

        found = self._search.run(
            DiscrepancySettings(
                model=None if not job.request.model else _model(job.request.model),
                refused=job.decisions.refused,
                forced=job.decisions.forced,
                check_instruments=True,
            ),
            progress=step,
        )
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
            self.tell(_READING * done / steps, words)
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
        self.tell(None, "drawing the figures")
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

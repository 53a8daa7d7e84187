"""The report on a run, written: one function for the command and for the button."""

from __future__ import annotations

from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from typing import Final

from gsapp.identification.campaign import CanceledError, Step
from gsapp.identification.runs.inputs import openings_of
from gsapp.identification.runs.outcome import Outcome
from gsapp.identification.runs.shelf import FlightShelf
from gsapp.report.document import Tell
from gsapp.report.estimate_files import campaign_files
from gsapp.report.estimate_report import Reported, Units, estimate_document
from gsapp.report.hearing import MOST_HEARD, Heard, hear
from gsapp.report.linear_report import LinearComparison, compare_linear_models
from gsapp.report.writing import check_place, is_folder, write_document

_WHOLE: Final = 100
"""Parts into which all of the work is divided for those who watch it."""
_HEARING, _LINEAR, _DRAWING = (0, 25), (25, 45), (45, 100)
"""First and last part of listening to flights, of linear models, and of drawing."""


def write_campaign_report(
    outcome: Outcome,
    out: Path,
    *,
    units: Units = "US",
    written: datetime | None = None,
    heard: tuple[Heard, ...] | None = None,
    linear: LinearComparison | None = None,
    flights: FlightShelf | None = None,
    progress: Step | None = None,
) -> tuple[Path, ...]:
    """Write the report on a run.

    The same outcome gives the same page to the last byte, but for the line of the date.

    Parameters
    ----------
    outcome : Outcome
    out : Path
        A folder for the report, its pictures and the results as files; or one ``.html`` or
        ``.pdf``.
    units : {"US", "SI"}
        Of pictures and tables.
    written : datetime, optional
        Stands in the line of the date; without it there is no such line.
    heard : tuple of Heard, optional
        What FTR formed over the flights; it listens to them where it is not given.
    linear : LinearComparison, optional
        Linear models against flight; compared where they are not given.
    flights : FlightShelf, optional
        Flights that are open already.
    progress : callable, optional
        Told of parts done, parts in all, and what is next; returning False stops.

    Returns
    -------
    tuple of Path
        The files written; each whole or not at all.

    Raises
    ------
    GroundStationError
        If the file has another ending, or a flight cannot be opened any more.
    CanceledError
        If `progress` returned False; nothing is written then.
    OSError
        If the disk refuses.
    """
    check_place(out)
    shelf = FlightShelf() if flights is None else flights
    if heard is None:
        tell = _within(_HEARING, progress)
        tell(0.0, "listening to whole flights")
        heard = _heard(outcome, shelf, tell)
    if linear is None:
        tell = _within(_LINEAR, progress)
        tell(0.0, "comparing linear models")
        linear = compare_linear_models(outcome, flights=shelf, progress=_step(tell))
    tell = _within(_DRAWING, progress)
    tell(0.0, "drawing the figures")
    document = estimate_document(
        Reported(outcome=outcome, heard=heard, linear=linear), units=units, written=written
    )
    beside = campaign_files(outcome, linear) if is_folder(out) else {}
    return write_document(document, out, beside=beside, tell=tell)


def _heard(outcome: Outcome, shelf: FlightShelf, tell: Tell) -> tuple[Heard, ...]:
    openings = openings_of(outcome.request)[:MOST_HEARD]
    found: list[Heard] = []
    for number, opening in enumerate(openings):
        tell(number / len(openings), f"reading {opening.path.name}")
        one = shelf.open(opening).opened
        tell((number + 0.5) / len(openings), f"listening to {one.flight.name}")
        found += hear([(one.flight, one.aircraft)])
    return tuple(found)


def _within(parts: tuple[int, int], progress: Step | None) -> Tell:
    """Return what tells of a share of some parts of the work."""
    first, last = parts

    def tell(share: float, words: str) -> None:
        if progress is None:
            return
        done = round(first + share * (last - first))
        if progress(done, _WHOLE, words) is False:
            raise CanceledError("stopped; nothing was written")

    return tell


def _step(tell: Tell) -> Callable[[int, int, str], bool]:
    """Return what tells of steps done as of a share."""

    def step(done: int, total: int, words: str) -> bool:
        tell(done / total if total else 1.0, f"comparing linear models: {words}".rstrip(": "))
        return True

    return step

"""The report on a run, written: one function for the command and for the button."""

from __future__ import annotations

from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from typing import Final

from gsapp.identification.campaign import CampaignProgressCallback, CanceledError
from gsapp.identification.runs.inputs import FlightCache, flight_open_requests
from gsapp.identification.runs.run_execution import RunOutcome
from gsapp.identification.summary.campaign_linear_models import LinearModelValidation
from gsapp.report.document import ReportProgress
from gsapp.report.document_writer import check_report_path, is_folder_report, write_document
from gsapp.report.estimate_export import campaign_files
from gsapp.report.estimate_report import CampaignReportData, ReportUnits, estimate_document
from gsapp.report.ftr_histories import FlightEstimateHistory, compute_ftr_histories
from gsapp.report.linear_text import compare_linear_models
from gsapp.report.settings import REPORT

_PROGRESS_STEPS: Final = 100
"""Parts into which all of the work is divided for those who watch it."""
_FTR_SHARE, _LINEAR_SHARE, _DRAWING_SHARE = (0, 25), (25, 45), (45, 100)
"""First and last part of listening to flights, of linear models, and of drawing."""


def write_campaign_report(
    outcome: RunOutcome,
    out: Path,
    *,
    units: ReportUnits = "US",
    written: datetime | None = None,
    ftr_histories: tuple[FlightEstimateHistory, ...] | None = None,
    linear: LinearModelValidation | None = None,
    flights: FlightCache | None = None,
    progress: CampaignProgressCallback | None = None,
) -> tuple[Path, ...]:
    """Write the report on a run.

    The same outcome gives the same page to the last byte, but for the line of the date.

    Parameters
    ----------
    out : Path
        A folder for the report, its pictures and the results as files; or one ``.html`` or
        ``.pdf``.
    written : datetime, optional
        Stands in the line of the date; without it there is no such line.
    ftr_histories : tuple of FlightEstimateHistory, optional
        What FTR formed over the flights; it listens to them where it is not given.
    linear : LinearModelValidation, optional
        Linear models against flight; compared where they are not given.
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
    check_report_path(out)
    flight_cache = FlightCache() if flights is None else flights
    if ftr_histories is None:
        tell = _scaled_progress(_FTR_SHARE, progress)
        tell(0.0, "computing FTR over the flights")
        ftr_histories = _flight_ftr_histories(outcome, flight_cache, tell)
    if linear is None:
        tell = _scaled_progress(_LINEAR_SHARE, progress)
        tell(0.0, "comparing linear models")
        linear = compare_linear_models(outcome, flights=flight_cache, progress=_step(tell))
    tell = _scaled_progress(_DRAWING_SHARE, progress)
    tell(0.0, "drawing the figures")
    document = estimate_document(
        CampaignReportData(outcome=outcome, ftr_histories=ftr_histories, linear=linear),
        units=units,
        written=written,
    )
    beside = campaign_files(outcome, linear) if is_folder_report(out) else {}
    return write_document(document, out, beside=beside, tell=tell)


def _flight_ftr_histories(
    outcome: RunOutcome, flight_cache: FlightCache, tell: ReportProgress
) -> tuple[FlightEstimateHistory, ...]:
    openings = flight_open_requests(outcome.request)[: REPORT.max_ftr_flights]
    found: list[FlightEstimateHistory] = []
    for index, opening in enumerate(openings):
        tell(index / len(openings), f"reading {opening.path.name}")
        one = flight_cache.open(opening).opened
        tell((index + 0.5) / len(openings), f"computing FTR over {one.flight.name}")
        found += compute_ftr_histories([(one.flight, one.aircraft)])
    return tuple(found)


def _scaled_progress(
    parts: tuple[int, int], progress: CampaignProgressCallback | None
) -> ReportProgress:
    """Return what tells of a share of some parts of the work."""
    first, last = parts

    def tell(share: float, text: str) -> None:
        if progress is None:
            return
        done = round(first + share * (last - first))
        if progress(done, _PROGRESS_STEPS, text) is False:
            raise CanceledError("stopped; nothing was written")

    return tell


def _step(tell: ReportProgress) -> Callable[[int, int, str], bool]:
    """Return what tells of steps done as of a share."""

    def step(done: int, total: int, text: str) -> bool:
        tell(done / total if total else 1.0, f"comparing linear models: {text}".rstrip(": "))
        return True

    return step

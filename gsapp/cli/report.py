"""``gsapp report``: from flights to a report that can be defended, in one command."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from gsapp.identification.campaign import CampaignResult
    from gsapp.identification.flights import FlownFlight
    from gsapp.report.estimate_report import Heard

_AXES = {"lon": "longitudinal", "lat": "lateral"}
_MOST_HEARD = 4
"""Flights that FTR listens to for the report: one picture each."""
_FILES = frozenset({".csv", ".tlog", ".mat", ".parquet"})
"""Flights that are one file and need no map to be read."""


def run(
    *,
    flights: Sequence[Path],
    out: Path,
    aircraft: str | None = None,
    method: Literal["ml", "ee", "ftr"] = "ml",
    axis: Literal["lon", "lat", "both"] = "both",
    weights: str | None = None,
    model: str | None = None,
    joint: bool = False,
    maneuver: Sequence[str] = (),
    every_grade: bool = False,
    units: Literal["US", "SI"] = "US",
    dated: bool = True,
    channel_map: str | None = None,
    calibration: str | None = None,
) -> None:
    """Estimate, and write the report.

    Parameters
    ----------
    flights : sequence of Path
        Flights, or folders that hold some.
    out : Path
        A folder for the report, its pictures and the results as files; or one ``.html`` or
        ``.pdf``.
    aircraft, weights, model, channel_map, calibration : str, optional
        As for ``gsapp estimate``.
    method : {"ml", "ee", "ftr"}
    axis : {"lon", "lat", "both"}
    joint : bool
    maneuver : sequence of str
    every_grade : bool
    units : {"US", "SI"}
        Of pictures and tables.
    dated : bool
        Whether the report says when it was written.

    Raises
    ------
    GroundStationError
        If a file or name is wrong, or no maneuver gives anything.
    """
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    from gsapp.cli._maneuvers import flown_flights
    from gsapp.dynamics.model import load_model
    from gsapp.flight.info import now
    from gsapp.identification.campaign import CampaignSettings, run_campaign
    from gsapp.identification.maximum_likelihood import MLSettings
    from gsapp.identification.summary import summarize_campaign
    from gsapp.identification.summary.linear import linear_models
    from gsapp.identification.weights import load_weights
    from gsapp.report.estimate_files import write_files
    from gsapp.report.estimate_inputs import campaign_provenance
    from gsapp.report.estimate_report import Reported, estimate_document
    from gsapp.report.estimate_words import headline, wild_words
    from gsapp.report.writing import check_place, write_document

    check_place(out)
    console = Console()
    paths = flights_in(flights)
    known = None if model is None else load_model(model)
    loaded = None if weights is None else load_weights(weights)
    flown = flown_flights(
        paths, aircraft=aircraft, channel_map=channel_map, calibration=calibration,
        given=maneuver, every_grade=every_grade, console=console,
    )  # fmt: skip
    settings = CampaignSettings(
        method=method,
        axis=axis,
        weights=None
        if loaded is None
        else {one.flight.name: loaded.for_flight(one.flight.name) for one in flown},
        likelihood=MLSettings(axis="lon", model=known),
        joint=joint,
    )
    columns = (TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task("estimating", total=None)

        def step(done: int, total: int, what: str) -> None:
            bar.update(task, completed=done, total=total, description=what or "done")

        result = run_campaign(
            [one for flight in flown for one in flight.maneuvers], settings, progress=step
        )
    _check(result)
    summary = summarize_campaign(result)
    models, why_not = linear_models(result, summary)
    with console.status("listening to whole flights") as status:
        heard, unheard = _heard(flown)
        status.update("drawing")
        reported = Reported(
            aircraft=flown[0].aircraft.name,
            result=result,
            summary=summary,
            known={} if known is None else known.derivatives,
            heard=heard,
            modes={_AXES[name]: one.modes() for name, one in models.items()},
            remarks=(*_read(flown), *why_not, *unheard),
            provenance=campaign_provenance(
                paths, settings, aircraft=aircraft, model=model, weights=weights,
                channel_map=channel_map, calibration=calibration, maneuvers=maneuver,
                every_grade=every_grade,
            ),
        )  # fmt: skip
        document = estimate_document(reported, units=units, written=now() if dated else None)
        written = write_document(document, out)
        if out.is_dir():
            written += write_files(out, result, summary, models, aircraft=reported.aircraft)
    console.print(headline(summary, result), highlight=False, soft_wrap=True)
    for sentence in wild_words(summary):
        console.print(sentence, style="yellow", highlight=False, markup=False, soft_wrap=True)
    place = out if out.is_dir() else written[0]
    console.print(f"written to {place}", highlight=False, markup=False, soft_wrap=True)


def flights_in(paths: Sequence[Path]) -> tuple[Path, ...]:
    """Return the flights among some paths, and those in folders that are no flight themselves.

    Raises
    ------
    FlightError
        If a folder holds none.
    """
    from gsapp.flight.folder import is_flight_folder
    from gsapp.foundation import FlightError

    found: list[Path] = []
    for path in paths:
        if not path.is_dir() or is_flight_folder(path):
            found.append(path)
            continue
        inside = sorted(
            one
            for one in path.iterdir()
            if (one.is_dir() and is_flight_folder(one)) or one.suffix.casefold() in _FILES
        )
        if not inside:
            raise FlightError(
                f"the folder {path} holds no flight; give a flight folder, a file, or a folder "
                "with flights in it"
            )
        found += inside
    return tuple(found)


def _read(flown: Sequence[FlownFlight]) -> tuple[str, ...]:
    """Return what reading the flights had to say, each sentence once."""
    return tuple(
        dict.fromkeys(f"{one.flight.name}: {remark}" for one in flown for remark in one.remarks)
    )


def _check(result: CampaignResult) -> None:
    from gsapp.foundation import FlightError

    failures = [one.failure for one in result.results if one.estimate is None]
    if len(failures) == len(result.results):
        raise FlightError(f"no maneuver could be fitted: {failures[0]}")


def _heard(flown: Sequence[FlownFlight]) -> tuple[tuple[Heard, ...], tuple[str, ...]]:
    """Return what FTR would have formed in the air, and why not where it would not."""
    from gsapp.foundation import FlightError
    from gsapp.identification.ftr.whole import listen_to
    from gsapp.report.estimate_report import Heard

    found, remarks = [], []
    for one in flown[:_MOST_HEARD]:
        try:
            ftr = listen_to(one.flight, one.aircraft)
        except FlightError as error:
            remarks.append(f"{one.flight.name}: FTR did not listen: {error}")
            continue
        found.append(
            Heard(
                flight=one.flight.name,
                histories={name: ftr.history(name) for name in ftr.names},
            )
        )
    return tuple(found), tuple(remarks)

"""``gsapp report``: from flights to a report that can be defended, in one command."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from gsapp.identification.campaign import CampaignResult

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
    validate: Sequence[Path] = (),
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
    validate : sequence of Path
        Flights among them that linear models are judged on, and not fitted on.

    Raises
    ------
    GroundStationError
        If a file or name is wrong, or no maneuver gives anything.
    """
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    from gsapp.flight.info import now
    from gsapp.identification.campaign import CampaignSettings
    from gsapp.identification.runs.request import RunRequest
    from gsapp.identification.runs.running import run as estimate
    from gsapp.identification.runs.shelf import FlightShelf
    from gsapp.report.campaign_writing import write_campaign_report
    from gsapp.report.estimate_words import headline, wild_words
    from gsapp.report.linear_words import compare_linear_models, kept_out_numbers
    from gsapp.report.writing import check_place

    check_place(out)
    console = Console()
    paths = flights_in(flights)
    kept_out_numbers(paths, validate)
    request = RunRequest(
        flights=paths,
        settings=CampaignSettings(method=method, axis=axis, joint=joint),
        aircraft=aircraft or "",
        calibration=calibration or "",
        channel_map=channel_map or "",
        given=tuple(maneuver),
        every_grade=every_grade,
        weights=weights or "",
        model=model or "",
    )
    shelf = FlightShelf()
    columns = (TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task("reading", total=None)

        def step(done: int, total: int, what: str) -> None:
            bar.update(task, completed=done, total=total, description=what or "done")

        outcome = estimate(
            request,
            flights=shelf,
            doing=lambda words: bar.update(task, total=None, description=words),
            progress=step,
        )
        _check(outcome.result)
        linear = None
        if validate:
            linear = compare_linear_models(outcome, validate, progress=step)
        written = write_campaign_report(
            outcome, out, units=units, written=now() if dated else None, linear=linear,
            flights=shelf, progress=step,
        )  # fmt: skip
    console.print(headline(outcome.summary, outcome.result), highlight=False, soft_wrap=True)
    for sentence in wild_words(outcome.summary):
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


def _check(result: CampaignResult) -> None:
    from gsapp.foundation import FlightError

    failures = [one.failure for one in result.results if one.estimate is None]
    if len(failures) == len(result.results):
        raise FlightError(f"no maneuver could be fitted: {failures[0]}")

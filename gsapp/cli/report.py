"""``gsapp report``: from flights to a report that can be defended, in one command."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from gsapp.cli._options import UNITS
from gsapp.cli._screen import say

if TYPE_CHECKING:
    from gsapp.identification.campaign import Step
    from gsapp.identification.runs.choosing import Doing
    from gsapp.identification.runs.outcome import Outcome


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
    as_found: bool = False,
    dated: bool = True,
    channel_map: str | None = None,
    calibration: str | None = None,
    validate: Sequence[Path] = (),
    json: Path | None = None,
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
    as_found : bool
        Leave out what was changed by hand.
    dated : bool
        Whether the report says when it was written.
    validate : sequence of Path
        Flights among them that linear models are judged on, and not fitted on.
    json : Path, optional
        Where the estimates and the names of what was written go, for programs.

    Raises
    ------
    GroundStationError
        If a file or name is wrong, or no maneuver gives anything.
    """
    from gsapp.cli._calls import check_windows, wrong_call
    from gsapp.cli._results import on_screen, outcome_content, result_text, write_result
    from gsapp.cli._running import check_fitted, with_bar
    from gsapp.cli._screen import Screen
    from gsapp.cli._targets import check_flights
    from gsapp.flight.info import now
    from gsapp.identification.campaign import CampaignSettings
    from gsapp.identification.runs.request import RunRequest
    from gsapp.identification.runs.running import run as estimate
    from gsapp.identification.runs.shelf import FlightShelf
    from gsapp.report.campaign_writing import write_campaign_report
    from gsapp.report.estimate_words import headline, wild_words
    from gsapp.report.linear_words import compare_linear_models, kept_out_numbers
    from gsapp.report.writing import check_place

    with wrong_call():
        check_place(out)
    console = Screen(stderr=on_screen(json))
    paths = flights_in(flights)
    check_flights(paths)  # one may be named beside the folder that holds it
    check_windows(maneuver, paths)
    with wrong_call():
        kept_out_numbers(paths, validate)
    request = RunRequest(
        flights=paths,
        settings=CampaignSettings(method=method, axis=axis, joint=joint),
        aircraft=aircraft or "",
        calibration=calibration or "",
        channel_map=channel_map or "",
        given=tuple(maneuver),
        every_grade=every_grade,
        as_found=as_found,
        weights=weights or "",
        model=model or "",
    )
    shelf = FlightShelf()

    def work(doing: Doing, step: Step) -> tuple[Outcome, tuple[Path, ...]]:
        outcome = estimate(request, flights=shelf, doing=doing, progress=step)
        check_fitted(outcome)
        linear = None
        if validate:
            linear = compare_linear_models(outcome, validate, flights=shelf, progress=step)
        written = write_campaign_report(
            outcome, out, units=UNITS.get(), written=now() if dated else None, linear=linear,
            flights=shelf, progress=step,
        )  # fmt: skip
        return outcome, written

    outcome, written = with_bar(console, work)
    if json is not None:
        content = outcome_content(outcome, shelf) | {"written": [str(one) for one in written]}
        write_result(json, result_text(content))
    say(console, headline(outcome.summary, outcome.result))
    for sentence in wild_words(outcome.summary):
        say(console, sentence, "yellow")
    place = out if out.is_dir() else written[0]
    console.print(f"written to {place}", highlight=False, soft_wrap=True)


def flights_in(paths: Sequence[Path]) -> tuple[Path, ...]:
    """Return the flights among some paths, and those in folders that are no flight themselves.

    Raises
    ------
    FlightError
        If a folder holds none.
    """
    from gsapp.flight.folder import is_flight_folder
    from gsapp.flight.loading import LOG_ENDINGS
    from gsapp.foundation import FlightError
    from gsapp.foundation.files import files_of

    found: list[Path] = []
    for path in paths:
        if not path.is_dir() or is_flight_folder(path):
            found.append(path)
            continue
        inside = [
            one
            for one in files_of(path)
            if (one.is_dir() and is_flight_folder(one)) or one.suffix.casefold() in LOG_ENDINGS
        ]
        if not inside:
            raise FlightError(
                f"the folder {path} holds no flight; give a flight folder, a file, or a folder "
                "with flights in it"
            )
        found += inside
    return tuple(found)

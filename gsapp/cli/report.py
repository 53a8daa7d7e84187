"""``gsapp report``: from flights to a report that can be defended, in one command."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gsapp.cli._commands import ESTIMATE_SETTINGS, takes_settings
from gsapp.cli._options import DISPLAY_UNITS, Dated, JsonFile, On, Units, open_workers

if TYPE_CHECKING:
    from gsapp.identification.campaign import CampaignProgressCallback
    from gsapp.identification.maneuver import StatusCallback
    from gsapp.identification.runs.run_execution import RunOutcome


@takes_settings(
    ESTIMATE_SETTINGS, "aircraft", "method", "axis", "weights", "model", "joint",
    "maneuver_windows", "every_grade", "as_found", "channel_map", "calibration",
)  # fmt: skip
def report(
    flights: Annotated[
        list[Path],
        typer.Argument(
            metavar="FLIGHT|DIR",
            readable=False,
            help="Flights, or folders with flights",
            show_default=False,
        ),
    ],
    out: Annotated[
        Path,
        typer.Option(
            metavar="FILE",
            readable=False,
            help=".html or .pdf file; or a folder for both plus figures and results (CSV, "
            "MATLAB, JSON, models)",
        ),
    ],
    validate: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="FLIGHT",
            readable=False,
            help="Flight to validate linear models on; repeatable; default: the last",
        ),
    ] = None,
    on: On = None,
    units: Units = "us",  # noqa: ARG001  acts in its callback
    dated: Dated = True,
    json: JsonFile = None,
    **settings: Any,
) -> None:
    """Write the report on one flight or a campaign.

    It gives derivatives that can be defended.

    Example: gsapp report flights/e --aircraft b777 --out "flight E.pdf"

    Example: gsapp report flights --model b777 --out results

    Example: gsapp report flights --on local --out campaign.html
    """
    from gsapp.cli._console import PlainConsole, is_stdout, write_json
    from gsapp.cli._usage_errors import as_usage_error, check_distinct_flights, check_windows
    from gsapp.flight.flight_loader import find_flights
    from gsapp.flight.info import local_timestamp
    from gsapp.identification.runs.inputs import FlightCache
    from gsapp.identification.runs.request import RunRequest
    from gsapp.identification.runs.run_execution import check_fitted
    from gsapp.identification.runs.run_execution import execute_run as estimate
    from gsapp.report.campaign_report import write_campaign_report
    from gsapp.report.document_writer import check_report_path
    from gsapp.report.estimate_export import outcome_json
    from gsapp.report.estimate_text import estimate_headline, outlier_maneuver_text
    from gsapp.report.linear_text import compare_linear_models, validation_flight_numbers

    with as_usage_error():
        check_report_path(out)
    console = PlainConsole(stderr=is_stdout(json))
    paths = find_flights(flights)
    check_distinct_flights(paths)  # one may be named beside the folder that holds it
    with as_usage_error():
        request = RunRequest(flights=paths, **settings)
        validation_flight_numbers(paths, validate or ())
    check_windows(request.maneuver_windows, paths)
    flight_cache = FlightCache()

    def work(
        doing: StatusCallback, step: CampaignProgressCallback
    ) -> tuple[RunOutcome, tuple[Path, ...]]:
        outcome = estimate(request, flights=flight_cache, doing=doing, progress=step, pool=pool)
        check_fitted(outcome)
        linear = None
        if validate:
            linear = compare_linear_models(outcome, validate, flights=flight_cache, progress=step)
        written = write_campaign_report(
            outcome, out, units=DISPLAY_UNITS.get(), written=local_timestamp() if dated else None,
            linear=linear,
            flights=flight_cache, progress=step,
        )  # fmt: skip
        return outcome, written

    with open_workers(on) as pool:
        outcome, written = console.run_with_progress_bar(work)
    if json is not None:
        content = outcome_json(outcome) | {"written": [str(one) for one in written]}
        write_json(json, content)
    console.print_sentence(estimate_headline(outcome.summary, outcome.result))
    for sentence in outlier_maneuver_text(outcome.summary):
        console.print_sentence(sentence, "yellow")
    place = out if out.is_dir() else written[0]
    console.print(f"written to {place}", soft_wrap=True)

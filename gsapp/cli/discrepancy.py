"""``gsapp discrepancy``: find where model and flight disagree, name it, add it, show it shrink."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gsapp.cli._commands import takes_settings
from gsapp.cli._options import DISPLAY_UNITS, JsonFile, On, Units, open_workers

if TYPE_CHECKING:
    from gsapp.cli._console import PlainConsole
    from gsapp.discrepancy.results import DiscrepancyResult
    from gsapp.discrepancy.settings import DiscrepancySettings, SearchProgress
    from gsapp.identification.maneuver import FlightWithManeuvers


@takes_settings("gsapp.discrepancy.settings:DiscrepancySettings")
def discrepancy(
    flights: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="FLIGHT",
            readable=False,
            help="Flight folders, .tlog, .bin, .log, .ulg, .csv, .asc, .mat, .parquet",
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            readable=False,
            metavar="DIR",
            help="Folder for the revised model, report.html, report.pdf, figures, "
            "discrepancy.json; cards.toml with the maneuver that decides, if any",
        ),
    ] = None,
    list_: Annotated[bool, typer.Option("--list", help="List the effects and exit")] = False,
    catalog: Annotated[bool, typer.Option("--catalog", hidden=True)] = False,
    draw: Annotated[
        list[str] | None,
        typer.Option(
            metavar="MANEUVER",
            help="Plot all channels of this maneuver in the report; repeatable; default: worst "
            "held-out maneuver",
        ),
    ] = None,
    on: On = None,
    units: Units = "us",  # noqa: ARG001  acts in its callback
    json: JsonFile = None,
    **settings: Any,
) -> None:
    """Name and add the effect that a model lacks.

    Find where simulation and flight disagree, name the effect, add it, show the gap shrink.

    Example: gsapp discrepancy flights/a flights/b --aircraft b777 --model b777 --out missing

    Example: gsapp discrepancy flights/a --out missing --refuse aero.Cm.speed
    --held-out 3 --held-out 7

    Example: gsapp discrepancy --list
    """
    if list_ or catalog:
        from gsapp.cli._effect_catalog_text import list_effects

        list_effects(json)
        return
    if not flights or out is None:
        raise typer.BadParameter("give FLIGHT... and --out DIR, or --list")
    from gsapp.cli._console import PlainConsole, is_stdout, write_json
    from gsapp.cli._discrepancy_text import print_discrepancy
    from gsapp.cli._flight_text import print_aircraft_warnings
    from gsapp.cli._usage_errors import as_usage_error, check_windows
    from gsapp.discrepancy.flight_search import check_effects
    from gsapp.discrepancy.results import discrepancy_json
    from gsapp.discrepancy.settings import DiscrepancySettings
    from gsapp.report.discrepancy_folder import (
        MODEL_FILE,
        check_output_folder,
        write_discrepancy_folder,
    )
    from gsapp.report.provenance import search_provenance

    console = PlainConsole(stderr=is_stdout(json))
    check_output_folder(out)
    with as_usage_error():
        request = DiscrepancySettings(check_instruments=True, **settings)
        check_effects(request)
    check_windows(request.maneuver_windows, flights)
    flown, found = _search(console, flights, request, draw or (), on)
    provenance = search_provenance(flights, request)
    with console.status("writing the report"):
        write_discrepancy_folder(
            found, out, aircraft=flown[0].aircraft.name, provenance=provenance, draw=draw or (),
            units=DISPLAY_UNITS.get(),
        )  # fmt: skip
    write_json(json, discrepancy_json(found, model=out / MODEL_FILE))
    print_aircraft_warnings(console, [flown[0].file_aircraft])
    for one in flown:
        for remark in one.remarks:
            if remark not in one.flight.calibration_remarks:  # stands among the warnings
                console.print_sentence(f"{one.flight.name}: {remark}", "yellow")
    print_discrepancy(console, found)
    cards = "" if found.experiment is None else ", the test cards"
    console.print(f"The model{cards}, the report and its figures are in {out}", soft_wrap=True)


def _search(
    console: PlainConsole,
    flights: Sequence[Path],
    settings: DiscrepancySettings,
    draw: Sequence[str],
    on: str | None,
) -> tuple[tuple[FlightWithManeuvers, ...], DiscrepancyResult]:
    from rich.progress import TaskProgressColumn, TimeRemainingColumn

    from gsapp.discrepancy.flight_search import search_flights

    columns = (TaskProgressColumn(), TimeRemainingColumn())
    with (
        open_workers(on) as pool,
        console.progress(*columns, disable=not console.is_terminal) as bar,
    ):
        task = bar.add_task("preparing", total=1.0)

        def doing(text: str) -> None:
            bar.update(task, description=text)

        def show(done: SearchProgress) -> None:
            bar.update(task, completed=done.share, description=done.activity)

        return search_flights(flights, settings, draw=draw, doing=doing, progress=show, pool=pool)

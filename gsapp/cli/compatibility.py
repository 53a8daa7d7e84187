"""``gsapp compatibility``: the instruments of a flight against one another."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gsapp.cli._commands import MANEUVER_SETTINGS, takes_settings
from gsapp.cli._options import DISPLAY_UNITS, FlightPaths, JsonFile, On, Units, open_workers

if TYPE_CHECKING:
    from gsapp.cli._console import PlainConsole
    from gsapp.flight.maneuver_settings import ManeuverSettings
    from gsapp.identification.compatibility import CompatibilityResult
    from gsapp.identification.compatibility.settings import CompatibilitySettings


@takes_settings(
    MANEUVER_SETTINGS, "aircraft", "maneuver_windows", "as_found", "channel_map", "calibration"
)
def compatibility(
    flights: FlightPaths,
    error: Annotated[
        list[str] | None,
        typer.Option(
            "--error",
            metavar="ID.KIND",
            help="Also estimate this error, such as q.scale or V.delay; repeatable",
        ),
    ] = None,
    free: Annotated[list[str] | None, typer.Option("--free", hidden=True)] = None,
    on: On = None,
    catalog: Annotated[
        Path | None,
        typer.Option(
            readable=False,
            metavar="FILE",
            help="Check each flight alone, and store its instrument errors in this catalog",
        ),
    ] = None,
    units: Units = "us",  # noqa: ARG001  acts in its callback
    json: JsonFile = None,
    **settings: Any,
) -> None:
    """Check the instruments against one another.

    No aerodynamic model is needed.

    Rates, accelerations, flow angles and speed must follow from one motion: bias, scale factor
    and delay of each instrument, reversed axes, redundant sensors that disagree.

    With --catalog, 'gsapp catalog FILE changes' finds a vane that drifts from flight to flight.

    Example: gsapp compatibility flights/2026-05-12-a --aircraft b777

    Example: gsapp compatibility flights/* --on local --catalog fleet.sqlite
    """
    from gsapp.cli._console import PlainConsole, is_stdout, write_json
    from gsapp.cli._flight_text import print_calibration
    from gsapp.cli._usage_errors import as_usage_error, check_catalog, check_windows
    from gsapp.flight.flight import calibration_json
    from gsapp.flight.maneuver_settings import ManeuverSettings
    from gsapp.flight.maneuvers import uncalibrated_text
    from gsapp.identification.compatibility.flight_check import (
        check_flights,
        compatibility_json,
        settings_with_errors,
    )

    console = PlainConsole(stderr=is_stdout(json))
    given = ManeuverSettings(**settings)
    check_windows(given.maneuver_windows, flights)
    with as_usage_error():
        checked = settings_with_errors((*(error or ()), *(free or ())))
    if catalog is not None:
        if given.maneuver_windows:
            raise typer.BadParameter("--maneuver belongs to one check of all flights, no --catalog")
        check_catalog(catalog, given.calibration or None)
        _check_each(console, flights, given, checked, on, catalog, json)
        return
    with open_workers(on) as pool, console.status("reading") as status:
        flown, result = check_flights(flights, given, checked, doing=status.update, pool=pool)
    if json is not None:
        content = compatibility_json(result)
        content["calibration"] = calibration_json(one.flight for one in flown)
        write_json(json, content)
    print_calibration(console, (one.flight for one in flown))
    _describe(console, result)
    for one in flown:
        for text in one.remarks if given.maneuver_windows else ():
            if text not in one.flight.remarks:  # told already
                console.print_sentence(text, "yellow")
    for one in () if result.parameters else flown:
        for text in uncalibrated_text(one.flight):
            console.print_sentence(f"{one.flight.name}: {text}")


def _check_each(
    console: PlainConsole,
    flights: Sequence[Path],
    given: ManeuverSettings,
    checked: CompatibilitySettings,
    on: str | None,
    catalog: Path,
    json: Path | None,
) -> None:
    """Check each flight alone and store its errors as soon as they are there."""
    from gsapp.cli._console import write_json
    from gsapp.flight.catalog import Catalog
    from gsapp.foundation import FlightError
    from gsapp.identification.compatibility.flight_check import (
        check_each_flight,
        compatibility_json,
        store_check,
    )
    from gsapp.identification.compatibility.results import format_error_with_bound
    from gsapp.quantities import convert_text_units

    content: list[dict[str, Any]] = []
    table = console.create_table("instrument errors", ("flight", "error", "value", "bound"))
    lost = []
    with (
        Catalog(catalog) as store,
        open_workers(on) as pool,
        console.status("reading") as status,
    ):
        checks = check_each_flight(flights, given, checked, doing=status.update, pool=pool)
        for path, found in zip(flights, checks, strict=True):
            if isinstance(found, str):
                lost.append(f"{path.name}: {found}")
                content.append({"flight": path.name, "failure": found})
                continue
            store_check(store, found)
            own = {**compatibility_json(found.result), "calibration": found.calibration}
            content.append({"flight": found.entry.name, **own})
            for name, one in found.result.parameters.items():
                if one.value is not None and one.std is not None:
                    texts = format_error_with_bound(name, one.value, one.std)
                    shown = (convert_text_units(text, DISPLAY_UNITS.get()) for text in texts)
                    table.add_row(found.entry.name, name, *shown)
    write_json(json, content)
    console.print_unwrapped(table)
    for check in content:
        if not check.get("consistent", True):
            console.print_sentence(f"{check['flight']}: {check['summary']}", "bold red")
    for text in lost:
        console.print_sentence(text, "bold red")
    console.print(f"written to {catalog}", soft_wrap=True)
    if lost:
        raise FlightError(f"the instruments of {len(lost)} of {len(flights)} flights: no result")


def _describe(console: PlainConsole, result: CompatibilityResult) -> None:

    from gsapp.identification.compatibility.results import format_error_with_bound
    from gsapp.quantities import convert_text_units

    if result.parameters:
        table = console.create_table(
            f"instrument errors, from maneuver {', '.join(result.maneuvers)}",
            ("", "value", "bound", ""),
            right=("value", "bound"),
        )
        for name, one in result.parameters.items():
            if one.value is None or one.std is None:
                table.add_row(name, one.status.replace("-", " "), "", one.why)
            else:
                value, std = (
                    convert_text_units(text, DISPLAY_UNITS.get())
                    for text in format_error_with_bound(name, one.value, one.std)
                )
                table.add_row(name, value, std, "")
        console.print_unwrapped(table)
    open_signs = [name for name, sign in result.signs.items() if sign == "not-observable"]
    if open_signs:
        console.print_sentence(f"signs not observable in these maneuvers: {', '.join(open_signs)}")
    for sentence in result.warnings:
        if sentence not in result.summary:
            console.print_sentence(sentence, "yellow")
    style = "green" if result.consistent and result.parameters else "bold red"
    console.print_sentence(result.summary, style)

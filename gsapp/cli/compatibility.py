"""``gsapp compatibility``: the instruments of a flight against one another."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from gsapp.cli._commands import MANEUVER_SETTINGS, takes_settings
from gsapp.cli._options import DISPLAY_UNITS, FlightPaths, JsonFile, On, Units, open_workers

if TYPE_CHECKING:
    from gsapp.cli._console import PlainConsole
    from gsapp.identification.compatibility import CompatibilityResult


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
    units: Units = "us",  # noqa: ARG001  acts in its callback
    json: JsonFile = None,
    **settings: Any,
) -> None:
    """Check the instruments against one another.

    No aerodynamic model is needed.

    Rates, accelerations, flow angles and speed must follow from one motion: bias, scale factor
    and delay of each instrument, reversed axes, redundant sensors that disagree.

    Example: gsapp compatibility flights/2026-05-12-a --aircraft b777
    """
    from gsapp.cli._console import PlainConsole, is_stdout, write_json
    from gsapp.cli._flight_text import print_calibration
    from gsapp.cli._usage_errors import as_usage_error, check_windows
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

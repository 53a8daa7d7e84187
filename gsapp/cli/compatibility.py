"""``gsapp compatibility``: the instruments of a flight against one another."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gsapp.cli._commands import MANEUVER_SETTINGS, takes_settings
from gsapp.cli._options import DISPLAY_UNITS, FlightPaths, JsonFile, Units

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
    from gsapp.cli._flight_text import calibration_json, load_flown_flights, print_calibration
    from gsapp.cli._usage_errors import as_usage_error, check_windows
    from gsapp.flight.maneuver_settings import ManeuverSettings
    from gsapp.flight.maneuvers import uncalibrated_text
    from gsapp.foundation import FlightError
    from gsapp.identification.compatibility import (
        DEFAULT_FREE_ERRORS,
        CompatibilitySettings,
        check_compatibility,
    )
    from gsapp.identification.maneuver import no_maneuvers_text

    console = PlainConsole(stderr=is_stdout(json))
    given = ManeuverSettings(every_grade=True, **settings)
    check_windows(given.maneuver_windows, flights)
    with as_usage_error():
        checked = CompatibilitySettings(
            free=tuple(dict.fromkeys((*DEFAULT_FREE_ERRORS, *(error or ()), *(free or ()))))
        )
    flown = load_flown_flights(flights, given, console)
    maneuvers = [one for flight in flown for one in flight.maneuvers]
    if not maneuvers:
        raise FlightError(
            f"no maneuver to check instruments by: {no_maneuvers_text(flown)}; name a window of "
            "the flight with --maneuver START:STOP"
        )
    with console.status("comparing instruments"):
        result = check_compatibility(maneuvers, settings=checked)
    if json is not None:
        content = _content(result)
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


def _content(result: CompatibilityResult) -> dict[str, Any]:
    from dataclasses import asdict

    content = {
        "maneuvers": result.maneuvers,
        "consistent": result.consistent,
        "summary": result.summary,
        "parameters": {name: asdict(one) for name, one in result.parameters.items()},
        "signs": result.signs,
        "verdicts": [{**asdict(one), "seen_in": one.seen_in or None} for one in result.verdicts],
        "comparisons": [asdict(one) for one in result.comparisons],
        "fit": {
            name: {key: getattr(one, key) for key in ("rms", "rms_over_range_pct", "r2", "theil")}
            for name, one in result.fit.items()
        },
        "noise": result.noise,
        "gust": result.gust,
        "remedies": result.remedies,
        "converged": result.converged,
        "warnings": result.warnings,
    }
    return {name: _finite(value) for name, value in content.items()}


def _finite(value: Any) -> Any:
    """Return a value for JSON: null for what is not finite."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {name: _finite(one) for name, one in value.items()}
    return [_finite(one) for one in value] if isinstance(value, (list, tuple)) else value


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

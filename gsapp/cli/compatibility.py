"""``gsapp compatibility``: the instruments of a flight against one another."""

from __future__ import annotations

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
    from gsapp.identification.maneuver_extraction import no_maneuvers_text

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
        for words in one.remarks if given.maneuver_windows else ():
            if words not in one.flight.remarks:  # told already
                console.print_sentence(words, "yellow")
    for one in () if result.parameters else flown:
        for words in uncalibrated_text(one.flight):
            console.print_sentence(f"{one.flight.name}: {words}")


def _content(result: CompatibilityResult) -> dict[str, Any]:
    import math

    def number(value: float | None) -> float | None:
        return value if value is not None and math.isfinite(value) else None

    return {
        "maneuvers": list(result.maneuvers),
        "consistent": result.consistent,
        "summary": result.summary,
        "parameters": {
            name: {
                "value": number(one.value),
                "std": number(one.std),
                "nominal": one.nominal,
                "status": one.status,
                "why": one.why,
            }
            for name, one in result.parameters.items()
        },
        "signs": dict(result.signs),
        "verdicts": [
            {
                "kind": one.kind,
                "channels": list(one.channels),
                "sentence": one.sentence,
                "value": number(one.value),
                "std": number(one.std),
                "before": number(one.before),
                "after": number(one.after),
                "seen_in": one.seen_in or None,
            }
            for one in result.verdicts
        ],
        "comparisons": [
            {
                "reference": one.reference,
                "other": one.other,
                "bias": number(one.bias),
                "scale": number(one.scale),
                "delay": number(one.delay),
                "noise": None if one.noise is None else list(one.noise),
                "difference": number(one.difference),
                "agree": one.agree,
                "sentence": one.sentence,
            }
            for one in result.comparisons
        ],
        "fit": {
            name: {
                "rms": number(one.rms),
                "rms_over_range_pct": number(one.rms_over_range_pct),
                "r2": number(one.r2),
                "theil": number(one.theil),
            }
            for name, one in result.fit.items()
        },
        "noise": {name: number(size) for name, size in result.noise.items()},
        "gust": {name: number(size) for name, size in result.gust.items()},
        "remedies": list(result.remedies),
        "converged": result.converged,
        "warnings": list(result.warnings),
    }


def _describe(console: PlainConsole, result: CompatibilityResult) -> None:

    from gsapp.identification.compatibility.instrument_text import format_error_with_bound
    from gsapp.quantities import convert_text_units

    if result.parameters:
        table = console.create_table(
            f"instrument errors, from maneuver {', '.join(result.maneuvers)}",
            ("", "value", "bound", ""),
            right=("value", "bound"),
        )
        for name, one in result.parameters.items():
            if one.value is None or one.std is None:
                table.add_row(name, "not observable", "", one.why)
            else:
                value, std = (
                    convert_text_units(words, DISPLAY_UNITS.get())
                    for words in format_error_with_bound(name, one.value, one.std)
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

"""``gsapp compatibility``: the instruments of a flight against one another."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gsapp.cli._console import print_sentence
from gsapp.cli._options import DISPLAY_UNITS
from gsapp.cli._tables import print_unwrapped

if TYPE_CHECKING:
    from rich.console import Console

    from gsapp.identification.compatibility import CompatibilityResult


def run(
    *,
    flights: Sequence[Path],
    free: Sequence[str] = (),
    json: Path | None = None,
    **settings: Any,
) -> None:
    """Check the instruments over the maneuvers of some flights, all taken together.

    Parameters
    ----------
    flights : sequence of Path
    free : sequence of str
        Errors to be estimated beside the usual ones: ``q.scale``.
    json : Path, optional
        Where the result for programs goes.
    **settings
        Fields of `gsapp.flight.maneuver_settings.ManeuverSettings`.

    Raises
    ------
    GroundStationError
        If a flight cannot be read, holds no maneuver, or an error has an unknown name.
    """
    from gsapp.cli._console import PlainConsole
    from gsapp.cli._flight_text import calibration_json, print_calibration
    from gsapp.cli._flown_flights import load_flown_flights
    from gsapp.cli._json_output import format_json, is_stdout, write_json
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
        checked = CompatibilitySettings(free=tuple(dict.fromkeys((*DEFAULT_FREE_ERRORS, *free))))
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
        write_json(json, format_json(content))
    print_calibration(console, (one.flight for one in flown))
    _describe(console, result)
    for one in flown:
        for words in one.remarks if given.maneuver_windows else ():
            if words not in one.flight.remarks:  # told already
                print_sentence(console, words, "yellow")
    for one in () if result.parameters else flown:
        for words in uncalibrated_text(one.flight):
            print_sentence(console, f"{one.flight.name}: {words}")


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


def _describe(console: Console, result: CompatibilityResult) -> None:
    from rich import box
    from rich.table import Table

    from gsapp.identification.compatibility.results import format_error_with_bound
    from gsapp.quantities import convert_text_units

    if result.parameters:
        table = Table(
            title=f"instrument errors, from maneuver {', '.join(result.maneuvers)}",
            title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False,
        )  # fmt: skip
        for heading in ("", "value", "bound", ""):
            table.add_column(heading, justify="right" if heading else "left")
        for name, one in result.parameters.items():
            if one.value is None or one.std is None:
                table.add_row(name, "not observable", "", one.why)
            else:
                value, std = (
                    convert_text_units(words, DISPLAY_UNITS.get())
                    for words in format_error_with_bound(name, one.value, one.std)
                )
                table.add_row(name, value, std, "")
        print_unwrapped(console, table)
    open_signs = [name for name, sign in result.signs.items() if sign == "not-observable"]
    if open_signs:
        print_sentence(console, f"signs not observable in these maneuvers: {', '.join(open_signs)}")
    for sentence in result.warnings:
        if sentence not in result.summary:
            print_sentence(console, sentence, "yellow")
    style = "green" if result.consistent and result.parameters else "bold red"
    print_sentence(console, result.summary, style)

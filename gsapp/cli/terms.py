"""``gsapp terms``: which terms each coefficient needs, by what the flights can prove."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gsapp.cli._console import print_sentence
from gsapp.cli._tables import print_unwrapped

if TYPE_CHECKING:
    from rich.console import Console

    from gsapp.identification.equation_error.stepwise_regression import TermSelection
    from gsapp.identification.maneuver import Maneuver

_AXES = {
    "CN": "lon", "CA": "lon", "Cm": "lon", "CY": "lat", "Cl": "lat", "Cn": "lat",
}  # fmt: skip


def run(
    *,
    flights: Sequence[Path],
    coefficient: Sequence[str] = (),
    model: str | None = None,
    json: Path | None = None,
    **settings: Any,
) -> None:
    """Choose the terms of coefficients, stepwise, over the maneuvers of some flights together.

    Parameters
    ----------
    flights : sequence of Path
    coefficient : sequence of str
        Of CN, CA, CY, Cl, Cm, Cn; all that were excited where none is named.
    model : str, optional
        Name or path; its effects are taken as known.
    json : Path, optional
        Where the result for programs goes.
    **settings
        Fields of `gsapp.flight.maneuver_settings.ManeuverSettings`.

    Raises
    ------
    GroundStationError
        If a flight cannot be read, or no coefficient can be had.
    """
    from gsapp.cli._aircraft_text import print_aircraft_warnings
    from gsapp.cli._console import PlainConsole
    from gsapp.cli._flown_flights import load_flown_flights
    from gsapp.cli._json_output import format_json, is_stdout, write_json
    from gsapp.cli._usage_errors import CommandUsageError, check_windows
    from gsapp.dynamics.model import load_model
    from gsapp.flight.maneuver_settings import ManeuverSettings
    from gsapp.foundation import FlightError
    from gsapp.foundation.name_suggestions import did_you_mean
    from gsapp.identification.equation_error.stepwise_regression import select_terms
    from gsapp.identification.maneuver import no_maneuvers_text

    unknown = [name for name in coefficient if name not in _AXES]
    if unknown:
        hint = did_you_mean(unknown[0], _AXES, f"there are {', '.join(_AXES)}")
        raise CommandUsageError(f"there is no coefficient '{unknown[0]}'; {hint}")
    given = ManeuverSettings(**settings)
    check_windows(given.maneuver_windows, flights)
    console = PlainConsole(stderr=is_stdout(json))
    known = None if model is None else load_model(model)
    flown = load_flown_flights(flights, given, console)
    every = [one for flight in flown for one in flight.maneuvers]
    if not every:
        raise FlightError(f"no maneuver to choose terms by: {no_maneuvers_text(flown)}")
    found: list[TermSelection] = []
    reasons = [one.assumed_aircraft_text for one in flown if one.assumed_aircraft_text]
    for name in coefficient or _AXES:
        own = _moving(every, name)
        if not own:
            reasons.append(f"{name}: no maneuver moved a surface that shows it")
            continue
        with console.status(f"choosing the terms of {name}"):
            try:
                found.append(select_terms(own, name, model=known))
            except FlightError as error:
                reasons.append(str(error))
    if not found:
        raise FlightError(f"no terms can be chosen: {'; '.join(reasons)}")
    if json is not None:
        content = {"coefficients": {one.coefficient: _content(one) for one in found}}
        write_json(json, format_json({**content, "remarks": reasons}))
    print_aircraft_warnings(console, (one.file_aircraft for one in flown))
    for one in found:
        _describe(console, one)
    for sentence in reasons:
        print_sentence(console, sentence, "yellow")


def _moving(maneuvers: Sequence[Maneuver], coefficient: str) -> list[Maneuver]:
    """Return the maneuvers whose input shows a coefficient."""
    from gsapp.identification.axes import AXIS_SURFACES

    surfaces = set(AXIS_SURFACES["lon" if _AXES[coefficient] == "lon" else "lat"])
    return [one for one in maneuvers if surfaces & set(one.inputs)]


def _content(one: TermSelection) -> dict[str, Any]:
    return {
        "terms": {name: {"value": value, "std": std} for name, (value, std) in one.values.items()},
        "beyond_linear": list(one.beyond_linear),
        "unexcited": list(one.unexcited),
        "r2": one.r2,
        "steps": [
            {
                "action": step.action, "term": step.term, "partial_f": step.partial_f,
                "r2": step.r2, "press": step.press, "alike": list(step.equivalent_terms),
                "why": step.why,
            }
            for step in one.steps
        ],
    }  # fmt: skip


def _describe(console: Console, one: TermSelection) -> None:
    from rich import box
    from rich.table import Table

    table = Table(
        title=f"{one.coefficient}: R2 {one.r2:z.4f}", title_justify="left", box=box.SIMPLE_HEAD,
        pad_edge=False,
    )  # fmt: skip
    for name in ("term", "value", "bound", ""):
        table.add_column(name, justify="left" if name in ("term", "") else "right")
    for name, (value, std) in one.values.items():
        beyond = "beyond the linear build-up" if name in one.beyond_linear else ""
        table.add_row(name, f"{value:z.4g}", f"{std:z.2g}", beyond)
    print_unwrapped(console, table)
    for step in one.steps:
        print_sentence(console, f"  {step.action} {step.term}: {step.why}")
    if one.unexcited:
        print_sentence(console, f"  not excited: {', '.join(one.unexcited)}")

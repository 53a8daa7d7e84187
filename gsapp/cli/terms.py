"""``gsapp terms``: which terms each coefficient needs, by what the flights can prove."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gsapp.cli._commands import MANEUVER_SETTINGS, takes_settings
from gsapp.cli._options import FlightPaths, JsonFile, Units

if TYPE_CHECKING:
    from gsapp.cli._console import PlainConsole
    from gsapp.identification.equation_error.stepwise_regression import TermSelection
    from gsapp.identification.maneuver import Maneuver

_AXES = {
    "CN": "lon", "CA": "lon", "Cm": "lon", "CY": "lat", "Cl": "lat", "Cn": "lat",
}  # fmt: skip


@takes_settings(MANEUVER_SETTINGS, "aircraft", "maneuver_windows", "channel_map", "calibration")
def terms(
    flights: FlightPaths,
    coefficient: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="CN, CA, CY, Cl, Cm or Cn; repeatable; all by default"),
    ] = None,
    model: Annotated[
        str | None, typer.Option(metavar="FILE", help="Model whose effects are known")
    ] = None,
    units: Units = "us",  # noqa: ARG001  acts in its callback
    json: JsonFile = None,
    **settings: Any,
) -> None:
    """Choose the terms that each coefficient needs.

    They are linear ones, effects, and products without a name.

    Equation error, stepwise: a term enters if it is proven and predicts stretches of the record
    that were left out; it goes again if later ones make it superfluous.

    Example: gsapp terms flights/a flights/b --coefficient Cm --aircraft b777
    """
    from gsapp.cli._console import PlainConsole, is_stdout, write_json
    from gsapp.cli._flight_text import load_flown_flights, print_aircraft_warnings
    from gsapp.cli._usage_errors import CommandUsageError, check_windows
    from gsapp.dynamics.model import load_model
    from gsapp.flight.maneuver_settings import ManeuverSettings
    from gsapp.foundation import FlightError
    from gsapp.foundation.name_suggestions import did_you_mean
    from gsapp.identification.channel_faults import sign_warnings
    from gsapp.identification.equation_error.stepwise_regression import select_terms
    from gsapp.identification.maneuver import no_maneuvers_text

    unknown = [name for name in coefficient or () if name not in _AXES]
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
    slopes = {name: value for one in found for name, value in one.slopes.items()}
    reasons += sign_warnings(slopes)
    content = {one.coefficient: _content(one) for one in found}
    write_json(json, {"coefficients": content, "remarks": reasons})
    print_aircraft_warnings(console, (one.file_aircraft for one in flown))
    for one in found:
        _describe(console, one)
    for sentence in reasons:
        console.print_sentence(sentence, "yellow")


def _moving(maneuvers: Sequence[Maneuver], coefficient: str) -> list[Maneuver]:
    """Return the maneuvers whose input shows a coefficient."""
    from gsapp.identification.axes import AXIS_SURFACES

    surfaces = set(AXIS_SURFACES["lon" if _AXES[coefficient] == "lon" else "lat"])
    return [one for one in maneuvers if surfaces & set(one.inputs)]


def _content(one: TermSelection) -> dict[str, Any]:
    return {
        "terms": {name: {"value": value, "std": std} for name, (value, std) in one.values.items()},
        "beyond_linear": list(one.beyond_linear),
        "shapes": {name: dict(shape) for name, shape in one.shapes.items()},
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


def _shape_text(shape: Mapping[str, float]) -> str:
    """Return the numbers of a stall's shape, angles in degrees."""
    from gsapp.quantities.constants import DEGREE

    return ", ".join(
        f"alpha_star {value / DEGREE:.3g} deg"
        if name == "alpha_star"
        else f"{name} {value:.3g}{' s' if name.startswith('tau') else ''}"
        for name, value in shape.items()
    )


def _describe(console: PlainConsole, one: TermSelection) -> None:
    table = console.create_table(
        f"{one.coefficient}: R2 {one.r2:z.4f}",
        ("term", "value", "bound", ""),
        right=("value", "bound"),
    )
    for name, (value, std) in one.values.items():
        beyond = "beyond the linear build-up" if name in one.beyond_linear else ""
        table.add_row(name, f"{value:z.4g}", f"{std:z.2g}", beyond)
    console.print_unwrapped(table)
    for name, shape in one.shapes.items():
        console.print_sentence(f"  {name}: {_shape_text(shape)}")
    for step in one.steps:
        console.print_sentence(f"  {step.action} {step.term}: {step.why}")
    if one.unexcited:
        console.print_sentence(f"  not excited: {', '.join(one.unexcited)}")

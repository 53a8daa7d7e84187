"""``gsapp inertia``: moments of inertia from pendulum swings."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from gsapp.cli._options import DISPLAY_UNITS, JsonFile


def inertia(
    swings: Annotated[
        Path,
        typer.Argument(metavar="SWINGS.toml", readable=False, help="Times and distances of swings"),
    ],
    unit: Annotated[str, typer.Option(help="Units on the screen")] = "slug ft^2",
    json: JsonFile = None,
) -> None:
    """Find moments of inertia from pendulum swings.

    Each comes with its uncertainty.

    Example: gsapp inertia swings.toml --unit "kg m^2"
    """
    from rich.table import Table

    from gsapp.aircraft.swings import compute_inertia, load_swings
    from gsapp.cli._console import PlainConsole, is_stdout, write_json
    from gsapp.cli._usage_errors import as_usage_error
    from gsapp.quantities import units

    with as_usage_error():
        scale = units.to_si(1.0, unit, "inertia")
        DISPLAY_UNITS.set("SI" if units.normalize_unit(unit, "inertia") == "kg*m^2" else "US")
    result = compute_inertia(load_swings(swings))
    if json is not None:
        content = {
            "mass": result.mass,
            "inertia": {
                name: {"value": one.value, "std": one.std} for name, one in result.values.items()
            },
            "parts": {name: part._asdict() for name, part in result.parts.items()},
            "shares": {name: dict(share) for name, share in result.shares.items()},
            "warnings": list(result.warnings),
        }
        write_json(json, content)
        if is_stdout(json):
            return
    console = PlainConsole()
    table = Table("", f"value, {unit}", "std", "std, %", "largest source of uncertainty")
    for name, one in result.values.items():
        share = result.shares[name]
        largest = max(share, key=lambda key: share[key]) if share else "none stated"
        percent = f"{100.0 * one.std / abs(one.value):z.1f}" if one.value else ""
        text = f"{largest} ({100.0 * share[largest]:z.0f} %)" if share else largest
        table.add_row(name, f"{one.value / scale:z.3f}", f"{one.std / scale:z.3f}", percent, text)
    console.print_unwrapped(table)
    parts = Table("", "full period", "cradle", "to the CG, with air", title=f"Made of, {unit}")
    for name, part in result.parts.items():
        title = "about the vertical, nose up" if name == "vertical" else name
        parts.add_row(
            title, *(f"{one / scale:z.3f}" for one in (part.whole, part.cradle, part.transfer))
        )
    console.print_unwrapped(parts)
    console.print("For the aircraft file:\n\n[mass]")
    for name, one in result.values.items():
        console.print(f'{name} = "{one.value / scale:z.4g} {unit}"')
    for warning in result.warnings:
        console.print_sentence(f"note: {warning}")

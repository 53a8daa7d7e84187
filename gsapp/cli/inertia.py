"""``gsapp inertia``: moments of inertia from pendulum swings."""

from __future__ import annotations

import json as json_module
from pathlib import Path

from rich.table import Table

from gsapp.cli._console import PlainConsole, print_sentence
from gsapp.cli._options import DISPLAY_UNITS
from gsapp.cli._tables import print_unwrapped


def run(*, swings: Path, json: Path | None = None, unit: str = "slug ft^2") -> None:
    """Evaluate a file of swings.

    Parameters
    ----------
    swings : Path
        TOML; see `gsapp.aircraft.swings.Swings`.
    json : Path, optional
        Where the result for programs goes.
    unit : str
        Of the values on the screen.

    Raises
    ------
    GroundStationError
        If the file holds mistakes.
    """
    from gsapp.aircraft.swings import compute_inertia, load_swings
    from gsapp.cli._json_output import is_stdout, write_json
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
        write_json(json, json_module.dumps(content, indent=1) + "\n")
        if is_stdout(json):
            return
    console = PlainConsole()
    table = Table("", f"value, {unit}", "std", "std, %", "largest source of uncertainty")
    for name, one in result.values.items():
        share = result.shares[name]
        largest = max(share, key=lambda key: share[key]) if share else "none stated"
        percent = f"{100.0 * one.std / abs(one.value):z.1f}" if one.value else ""
        words = f"{largest} ({100.0 * share[largest]:z.0f} %)" if share else largest
        table.add_row(name, f"{one.value / scale:z.3f}", f"{one.std / scale:z.3f}", percent, words)
    print_unwrapped(console, table)
    parts = Table("", "full period", "cradle", "to the CG, with air", title=f"Made of, {unit}")
    for name, part in result.parts.items():
        title = "about the vertical, nose up" if name == "vertical" else name
        parts.add_row(
            title, *(f"{one / scale:z.3f}" for one in (part.whole, part.cradle, part.transfer))
        )
    print_unwrapped(console, parts)
    console.print("For the aircraft file:\n\n[mass]", highlight=False)
    for name, one in result.values.items():
        console.print(f'{name} = "{one.value / scale:z.4g} {unit}"', highlight=False)
    for warning in result.warnings:
        print_sentence(console, f"note: {warning}")

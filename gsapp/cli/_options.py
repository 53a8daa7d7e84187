"""Arguments and options that commands share.

A word means the same in all commands; `tests/cli/test_words.py` holds them to it.
"""

from __future__ import annotations

from contextvars import ContextVar
from pathlib import Path
from typing import Annotated, Final, Literal

import typer

# `readable=False`: what cannot be read is told by the command, in one sentence, with exit code 1.
FlightPath = Annotated[
    Path,
    typer.Argument(
        metavar="FLIGHT",
        readable=False,
        help="Flight folder, .tlog, .bin, .log, .ulg, .csv, .asc, .mat, .parquet",
    ),
]
JsonFile = Annotated[
    Path | None,
    typer.Option(
        "--json",
        metavar="FILE",
        readable=False,
        help="Write the result as JSON; - for standard output",
    ),
]
DISPLAY_UNITS: Final[ContextVar[Literal["US", "SI"]]] = ContextVar("units", default="US")
"""System of units of all that a command prints."""


def _print_in(chosen: Literal["us", "si", "base"]) -> str:
    DISPLAY_UNITS.set("US" if chosen == "us" else "SI")
    return chosen


Units = Annotated[
    Literal["us", "si"],
    typer.Option(
        case_sensitive=False, callback=_print_in, help="us: ft/s, deg, g; si: m/s, deg, g"
    ),
]
FileUnits = Annotated[
    Literal["us", "si", "base"],
    typer.Option(
        case_sensitive=False,
        callback=_print_in,
        help="us: ft/s, deg, g; si: m/s, deg, g; base: m/s, rad, m/s^2",
    ),
]
FlightPaths = Annotated[
    list[Path],
    typer.Argument(
        metavar="FLIGHT",
        readable=False,
        help="Flight folders, .tlog, .bin, .log, .ulg, .csv, .asc, .mat, .parquet",
    ),
]
Dated = Annotated[bool, typer.Option("--date/--no-date", help="Include the date")]
CatalogFile = Annotated[
    Path | None,
    typer.Option(
        "--catalog", readable=False, metavar="FILE", help="Save the results in this catalog"
    ),
]

"""Arguments and options that commands share.

A word means the same in all commands; `tests/cli/test_words.py` holds them to it.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, Literal

import typer

if TYPE_CHECKING:
    from gsapp.foundation.executors import WorkerPool

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


def _check_address(address: str | None) -> str | None:
    from gsapp.foundation import GroundStationError
    from gsapp.foundation.executors import WorkerPool

    try:
        if address is not None:
            WorkerPool(address)
    except GroundStationError as error:
        raise typer.BadParameter(str(error)) from error
    return address


On = Annotated[
    str | None,
    typer.Option(
        "--on",
        metavar="WORKERS",
        callback=_check_address,
        help="Run on several processes: local, local:4 of this computer, dask://HOST:8786 or "
        "dask://local:4; the numbers are the same",
    ),
]


@contextmanager
def open_workers(address: str | None) -> Iterator[WorkerPool | None]:
    """Give the workers of an address while this lasts; None where there is no address."""
    from gsapp.foundation.executors import WorkerPool

    if address is None:
        yield None
        return
    with WorkerPool(address) as pool:
        yield pool

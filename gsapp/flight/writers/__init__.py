"""Writing flights: Flight CSV, MATLAB, Parquet."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from gsapp.flight.writers.column_units import ColumnUnits, ProgressCallback, UnitSystem
from gsapp.flight.writers.flight_csv import write_flight_csv
from gsapp.flight.writers.matlab import write_mat
from gsapp.flight.writers.parquet import write_parquet
from gsapp.foundation import UnknownNameError
from gsapp.quantities import Block

WRITERS: Mapping[str, Callable[[Path | str, Block, str, ProgressCallback | None], Path]] = {
    "csv": write_flight_csv,
    "mat": write_mat,
    "parquet": write_parquet,
}
"""Every format by its name."""


def write_block(
    path: Path | str, block: Block, to: str, units: str = "us", told: ProgressCallback | None = None
) -> Path:
    """Write a block in a format, atomically.

    Parameters
    ----------
    to : {"csv", "mat", "parquet"}
        The format.
    units : {"us", "si", "base"}
        Units of the columns.
    told : callable, optional
        Receives the share that is written, several times. What it raises ends the writing, and
        leaves no file behind.

    Raises
    ------
    UnknownNameError
        If there is no such format or system of units.
    FlightError
        If the file cannot be written.
    """
    check_format(to)
    return WRITERS[to](path, block, units, told)


def check_format(to: str) -> None:
    """Raise `UnknownNameError` unless there is a format of that name."""
    if to not in WRITERS:
        raise UnknownNameError(
            f"flights are not written as '{to}'; use one of: {', '.join(WRITERS)}"
        )


__all__ = [
    "WRITERS",
    "ColumnUnits",
    "ProgressCallback",
    "UnitSystem",
    "check_format",
    "write_block",
    "write_flight_csv",
    "write_mat",
    "write_parquet",
]

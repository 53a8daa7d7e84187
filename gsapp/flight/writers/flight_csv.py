"""Writing Flight CSV."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from gsapp.flight.atomic_files import atomic_flight_file
from gsapp.flight.writers.column_units import ColumnUnits, ProgressCallback
from gsapp.quantities import Block, FloatArray

_ROWS_AT_ONCE = 4096
# Two digits fewer than a double can hold: those that converting there and back may shake.
_CONVERTED_DIGITS = 15


def write_flight_csv(
    path: Path | str, block: Block, system: str = "us", told: ProgressCallback | None = None
) -> Path:
    """Write a block as Flight CSV, atomically.

    Values in SI, and times, are written with as many digits as bring back the very same number;
    converted ones with 15 digits, so that 1.2 deg does not become 1.2000000000000002. Missing
    samples are empty cells.

    Parameters
    ----------
    system : {"us", "si", "base"}
        Units of the columns.
    told : callable, optional
        See `gsapp.flight.writers.write_block`.

    Raises
    ------
    FlightError
        If the file cannot be written.
    """
    layout = ColumnUnits.from_channels(block.channels, system)
    header = ["time [s]"] + [
        f"{name} [{unit}]" for name, unit in zip(layout.channels, layout.units, strict=True)
    ]
    with (
        atomic_flight_file(path) as temporary,
        temporary.open("w", encoding="utf-8", newline="\n") as stream,
    ):
        stream.write(",".join(header) + "\n")
        for start in range(0, len(block), _ROWS_AT_ONCE):
            rows = slice(start, start + _ROWS_AT_ONCE)
            columns: list[Iterator[str]] = [map(repr, block.times[rows].tolist())]
            columns.extend(
                _cells(
                    layout.convert_column(place, block.values[rows, place]),
                    layout.is_unconverted(place),
                )
                for place in range(len(layout.channels))
            )
            stream.writelines(",".join(row) + "\n" for row in zip(*columns, strict=True))
            if told is not None:
                told(min(rows.stop / len(block), 1.0))
    return Path(path)


def _cells(values: FloatArray, exact: bool) -> Iterator[str]:
    missing = np.isnan(values).tolist()
    if exact:
        return ("" if gone else repr(v) for v, gone in zip(values.tolist(), missing, strict=True))
    form = f"%.{_CONVERTED_DIGITS}g"
    return ("" if gone else form % v for v, gone in zip(values.tolist(), missing, strict=True))

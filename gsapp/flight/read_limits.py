"""How much memory the numbers of one file may take; a damaged file may claim any amount."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Final

import numpy as np

from gsapp.flight.settings import FLIGHT_DATA, READER_PROCESS
from gsapp.foundation import FlightError
from gsapp.quantities import FloatArray

LIMIT_VARIABLE: Final = "GSAPP_READ_LIMIT_MB"
"""Environment variable: megabytes that the numbers of one file may take."""
MEGABYTE: Final = 1 << 20
NUMBER_BYTES: Final = 8
"""Of a number in a flight."""


def read_limit(size: int) -> int:
    """Return how many bytes the numbers of a file of `size` bytes may take."""
    text = os.environ.get(LIMIT_VARIABLE, "")
    megabytes = int(text) if text.isdecimal() and len(text) < 9 else READER_PROCESS.limit_mb
    return max(megabytes * MEGABYTE, READER_PROCESS.size_ratio * size)


def check_read_size(path: Path, needed: int, limit: int) -> None:
    """Raise `FlightError` where the numbers of a file take more bytes than the limit."""
    if needed > limit:
        megabytes = -(-needed // MEGABYTE)
        raise FlightError(
            f"{path} unpacks to {megabytes:,} MB or more, which a damaged file may claim; to read "
            f"it, set the environment variable {LIMIT_VARIABLE} to {megabytes} or more, or cut it "
            "into several files"
        )


def count_grid_rows(times: FloatArray, rate: float) -> float:
    """Return about how many rows of a grid increasing times (s) lie on, long pauses left out."""
    filled = np.clip(np.diff(times), 0.0, FLIGHT_DATA.max_filled_gap)
    return float(filled.sum()) * rate + times.size


def check_grid_size(path: Path, numbers: float, rate: float, records: int = 0) -> None:
    """Raise `FlightError` if a file needs more values on a grid (Hz) than memory holds.

    Or far more than its number of `records`, if known, explains.
    """
    needed = numbers * NUMBER_BYTES
    usual = max(records * FLIGHT_DATA.usual_values_per_record, FLIGHT_DATA.min_sparse_values)
    if records and numbers < usual:
        return  # A long flight with records throughout.
    limit = read_limit(path.stat().st_size if path.is_file() else 0)
    if records and LIMIT_VARIABLE not in os.environ:
        limit = min(limit, round(records * FLIGHT_DATA.max_values_per_record * NUMBER_BYTES))
    if needed > limit:
        megabytes = int(needed) // MEGABYTE + 1
        raise FlightError(
            f"{path} takes {megabytes:,} MB at {rate:g} samples per second: its samples are too "
            "far apart or some times are wrong; correct the times, choose a lower rate, or set "
            f"the environment variable {LIMIT_VARIABLE} to {megabytes} or more"
        )

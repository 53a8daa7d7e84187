"""Fields of the messages of a flight: which there are, and any of them at its own times."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from gsapp.decoding.raw_channels import mavlink_numbers
from gsapp.flight.flight_loader import (
    TABLE_SUFFIXES,
    frame_message,
    load_flight,
    read_onboard_log,
)
from gsapp.flight.folder import FlightFolder
from gsapp.flight.raw_files import read_nonempty_tlog
from gsapp.flight.readers.log_mapping import log_numbers
from gsapp.foundation import FlightError
from gsapp.quantities import FloatArray


def may_hold_messages(path: Path) -> bool:
    """Return whether a flight, by its name, may be more than a table."""
    return path.suffix.casefold() not in TABLE_SUFFIXES


def list_raw_fields(path: Path) -> tuple[str, ...]:
    """Return the numbers in the messages of a flight by the names of their raw channels, sorted.

    Tables, whose columns are channels, have none.
    """
    files = [path]
    if path.is_dir():
        folder = FlightFolder.open(path)
        onboard = folder.onboard_log()
        files = [*folder.nonempty_raw_files, *([onboard] if onboard is not None else [])]
    found: dict[str, None] = {}
    for file in files:
        if file.suffix.casefold() == ".tlog":
            frames = (one.data for one in read_nonempty_tlog(file) if one.kind == "frame")
            entries = mavlink_numbers({frame_message(frame) for frame in frames})
        else:
            log = read_onboard_log(file)
            entries = [] if log is None else log_numbers(log)
        found |= dict.fromkeys(entry.channel for entry in entries)
    return tuple(sorted(found))


def load_raw_field(path: Path, name: str) -> tuple[FloatArray, FloatArray]:
    """Return times (s) and numbers of one of `list_raw_fields`, shapes (n,).

    Raise FlightError if no sample of it can be placed in time.
    """
    block = load_flight(path, raw=[name], native=True).block
    known = np.isfinite(block[name]) if name in block else np.zeros(len(block), bool)
    if not known.any():
        raise FlightError(f"{path.name} has no sample of '{name}' with a time")
    return block.times[known], block[name][known]

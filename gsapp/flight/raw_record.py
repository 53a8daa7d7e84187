"""What the raw files of a flight hold, one record at a time."""

from __future__ import annotations

from typing import Literal, NamedTuple


class RawRecord(NamedTuple):
    """One record of a raw file."""

    stamp_us: int
    """Host time of arrival, microseconds since 1970 (UTC)."""
    kind: Literal["frame", "line", "residue"]
    """From ``raw.tlog``, ``raw.txt`` or ``residue.bin``."""
    data: bytes
    """A whole MAVLink frame, a text line without its end, or stray bytes."""

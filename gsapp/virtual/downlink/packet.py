"""What leaves the box at one tick."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Packet:
    """What leaves the box at one tick."""

    time: float  # s since the box was switched on.
    stamp_us: int  # The box's time of day, microseconds since 1970.
    live_frames: tuple[bytes, ...]  # Frames for the link.
    onboard_frames: tuple[bytes, ...]  # Frames for the on-board log; empty where there is none.
    phase: str  # What the pilot is doing.

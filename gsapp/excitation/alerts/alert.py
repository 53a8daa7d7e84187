"""One thing that calls for attention."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum


class AlertLevel(IntEnum):
    """How urgent something is."""

    CAUTION = 1
    WARNING = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Alert:
    """One thing that stands."""

    key: str
    """What it is about: ``nose``, ``alpha``, ``gyro.q``, ``stall``, ``fence``, ``clip.r`` ..."""
    level: AlertLevel
    since: float
    """Flight time, s."""
    text: str
    """A sentence to be read, with what to do."""
    spoken_text: str
    """A few words to be heard: "nose sensors lost: land"."""
    channels: tuple[str, ...] = ()
    """Channels that are not to be trusted while it stands."""

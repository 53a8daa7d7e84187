"""What is taken while calibrating: one reading after the other."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal

from gsapp.foundation import GroundStationError

Direction = Literal["up", "down", "single"]

DIRECTION_TEXT: Final[Mapping[Direction, str]] = {
    "up": "increasing", "down": "decreasing", "single": "",
}  # fmt: skip
"""How a direction reads on every page, in print and in messages; files hold ``up`` and ``down``.

An increasing value may be a trailing edge that moves down, left or up: the sign of the channel says
which.
"""


class CalibrationError(GroundStationError, ValueError):
    """Points from which no usable curve can be drawn."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CalibrationPoint:
    """One reading taken while calibrating."""

    volts: float
    """Voltage read, V."""
    value: float
    """What the instrument was set to, in the unit of the certificate."""
    direction: Direction = "single"
    """``up`` where the value was increasing as it was reached, ``down`` where it was decreasing;
    ``single`` where it was not noted."""
    noise: float = 0.0
    """Standard deviation of single samples meanwhile, V; 0 where it was not noted."""

"""What is taken while calibrating: one reading after the other."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from gsapp.foundation import GroundStationError

Direction = Literal["up", "down", "single"]


class CalibrationError(GroundStationError, ValueError):
    """Points from which no usable curve can be drawn."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CalibrationPoint:
    """One reading taken while calibrating.

    Attributes
    ----------
    volts : float
        Voltage read, V.
    value : float
        What the instrument was set to, in the unit of the certificate.
    direction : {"up", "down", "single"}
        Whether the value was reached from below or from above; ``single`` where it was not noted.
    noise : float
        Standard deviation of single samples meanwhile, V; 0 where it was not noted.
    """

    volts: float
    value: float
    direction: Direction = "single"
    noise: float = 0.0

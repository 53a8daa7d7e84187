"""Names of the instruments, and amounts, as a crew says them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from gsapp.quantities import channel, from_si

INSTRUMENT_TITLES: Final[Mapping[str, str]] = {
    "alpha": "alpha vane",
    "beta": "beta vane",
    "V": "airspeed",
    "p": "roll gyro",
    "q": "pitch gyro",
    "r": "yaw gyro",
    "ax": "longitudinal accelerometer",
    "ay": "lateral accelerometer",
    "an": "normal accelerometer",
}


def format_amount(name: str, value: float, system: str) -> str:
    """Return a value (SI) in whole units of its channel, ``US`` or ``SI``: "400 ft"."""
    spec = channel(name)
    unit = spec.display_unit(system)
    return f"{from_si(value, unit, spec.quantity):.0f} {unit}"

"""Names of the instruments as a crew says them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

TITLES: Final[Mapping[str, str]] = {
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

"""Which units a file is written in."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

from gsapp.foundation import UnknownNameError
from gsapp.quantities import FloatArray, channel, from_si

UnitSystem = Literal["us", "si", "base"]
"""``us``: deg, ft/s, g, lbf/ft^2, as flight-test reports use them; ``si``: deg, m/s, g, kPa, what
the window shows as SI; ``base``: rad, m/s, m/s^2, Pa, K, bit for bit as held inside."""

ProgressCallback = Callable[[float], object]
"""Receives the share of a file that is written; may raise to end the writing."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ColumnUnits:
    """Columns of a file: channel ids and the unit of each."""

    channels: tuple[str, ...]
    """Without time, which every file has first, in s."""
    units: tuple[str, ...]
    """As long as `channels`."""

    @staticmethod
    def from_channels(channels: Sequence[str], system: str) -> ColumnUnits:
        """Lay out channels in a system of units.

        Raises
        ------
        UnknownNameError
            If there is no such system.
        """
        if system not in get_args(UnitSystem):
            raise UnknownNameError(
                f"no system of units is called '{system}'; use one of: us, si, base"
            )
        return ColumnUnits(
            channels=tuple(channels), units=tuple(_unit(name, system) for name in channels)
        )

    def convert_column(self, place: int, values: FloatArray) -> FloatArray:
        """Convert SI values of the column at `place` to its unit."""
        return from_si(values, self.units[place], channel(self.channels[place]).quantity)

    def is_unconverted(self, place: int) -> bool:
        """Return whether the column holds the values as they are inside, unconverted."""
        return self.units[place] == channel(self.channels[place]).unit


def _unit(channel_id: str, system: str) -> str:
    spec = channel(channel_id)
    # A ratio is written as such, 0 to 1; percent is for the screen.
    if system == "base" or spec.quantity == "ratio":
        return spec.unit
    return spec.us_display if system == "us" else spec.si_display

"""How long the flight can still last: time, fuel, battery.

What stands below a fixed figure is the affair of `gsapp.session.limits` (battery and receiver in
``files/b777.toml``). Here is what they cannot say: that the time agreed on is nearly over, and that
the battery, at the rate at which it sinks, will not last as long as the flight.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from gsapp.excitation.dangers.danger import Urgency
from gsapp.excitation.dangers.frames import FRAME, Frame
from gsapp.excitation.dangers.standing import Finding


@dataclass(frozen=True, slots=True, kw_only=True)
class Endurance:
    """What a flight may take.

    Attributes
    ----------
    flight_time : float
        From take-off to landing, s; about seven minutes are flown on one filling (table 6.2.4).
    reserve : float
        s; as long before the end the crew is told to land.
    battery_empty : float
        V; the recorder stops below.
    fuel_reserve : float
        Share of what there was at take-off.
    """

    flight_time: float = 420.0
    reserve: float = 60.0
    battery_empty: float = 10.5
    fuel_reserve: float = 0.2


_SLOPE_FRAMES: Final = 240
"""Frames, a minute, over which the battery's sinking is taken."""
_LEAST_SINK: Final = 1e-4
"""V/s; less is noise and no forecast."""


class EnduranceRoom:
    """Watches what runs out.

    Parameters
    ----------
    endurance : Endurance
    """

    def __init__(self, endurance: Endurance) -> None:
        self._endurance = endurance
        self.restart()

    def restart(self) -> None:
        """Forget everything."""
        self._battery: list[float] = []
        self._fuel_full = math.nan

    def judge(self, frame: Frame) -> list[Finding]:
        """Return what runs out."""
        if not frame.airborne:
            return []
        return [*self._time(frame), *self._power(frame), *self._fuel(frame)]

    def _time(self, frame: Frame) -> list[Finding]:
        left = self._endurance.flight_time - frame.flown
        if left <= 0.0:
            return [
                Finding(
                    key="time",
                    urgency=Urgency.WARNING,
                    words=f"The flight time of {self._endurance.flight_time / 60.0:.0f} min is "
                    "over; land",
                    spoken="time is over: land",
                )
            ]
        if left <= self._endurance.reserve:
            return [
                Finding(
                    key="time",
                    urgency=Urgency.CAUTION,
                    words=f"{self._endurance.reserve:.0f} s are left of the flight time of "
                    f"{self._endurance.flight_time / 60.0:.0f} min; land",
                    spoken="time: land",
                )
            ]
        return []

    def _power(self, frame: Frame) -> list[Finding]:
        battery = frame.mean("battery")
        if math.isnan(battery):
            return []
        self._battery = [*self._battery[1 - _SLOPE_FRAMES :], battery]
        half = len(self._battery) // 2
        if len(self._battery) < _SLOPE_FRAMES:
            return []
        early = sum(self._battery[:half]) / half
        late = sum(self._battery[half:]) / (len(self._battery) - half)
        sink = (early - late) / (half * FRAME)
        if sink < _LEAST_SINK:
            return []
        left = (late - self._endurance.battery_empty) / sink - 0.5 * half * FRAME
        needed = self._endurance.reserve
        if left > needed:
            return []
        return [
            Finding(
                key="battery",
                urgency=Urgency.WARNING,
                words=f"The battery sinks by {60.0 * sink:.1f} V a minute and is empty within "
                f"{needed:.0f} s; land",
                spoken="battery: land",
            )
        ]

    def _fuel(self, frame: Frame) -> list[Finding]:
        fuel = frame.mean("fuel")
        if math.isnan(fuel):
            return []
        if not fuel <= self._fuel_full:
            self._fuel_full = fuel
        if self._fuel_full <= 0.0 or fuel > self._endurance.fuel_reserve * self._fuel_full:
            return []
        return [
            Finding(
                key="fuel",
                urgency=Urgency.WARNING,
                words=f"{100.0 * fuel / self._fuel_full:.0f} % of the fuel is left; land",
                spoken="fuel: land",
            )
        ]

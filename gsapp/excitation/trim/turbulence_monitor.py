"""How restless the aircraft is about its steady motion, and how strong gusts are by that.

Of each channel the power about the straight line of a second is known at every tick. Three such
seconds end to end say how restless it is now, five whether that lasts.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from typing import Final

from gsapp.aircraft import Aircraft
from gsapp.dynamics.atmosphere import SEA_LEVEL_DENSITY
from gsapp.excitation.trim.settings import TRIM
from gsapp.excitation.trim.trim_cue import TrimTolerances

TURBULENCE_CHANNELS: Final = ("p", "q", "r", "an", "alpha", "beta")
"""Channels by which unrest is judged."""


_LIFT: Final = TURBULENCE_CHANNELS.index("an")
_ALPHA: Final = TURBULENCE_CHANNELS.index("alpha")


class TurbulenceMonitor:
    """Follows unrest tick by tick.

    Parameters
    ----------
    aircraft : Aircraft or None
        Mass and wing area turn accelerations into gusts.
    second : int
        Ticks of the window in which the powers were taken.

    Attributes
    ----------
    tolerance_ratio : float
        Of the most restless channel, root mean square over its tolerance; NaN where no channel
        tells.
    is_lasting : bool
        Whether it has been restless for some seconds.
    gust_strength : float or None
        m/s.
    """

    def __init__(self, aircraft: Aircraft | None, tolerances: TrimTolerances, second: int) -> None:
        self._loading = (
            None
            if aircraft is None
            else 2.0 * aircraft.mass.mass / (aircraft.geometry.wing_area * TRIM.lift_slope)
        )
        self._second = second
        self._now = max(1, round(tolerances.turbulence_time / tolerances.averaging_time))
        self._limits = (
            tolerances.roll_rate_rms,
            tolerances.pitch_rate_rms,
            tolerances.yaw_rate_rms,
            tolerances.an_rms,
            tolerances.alpha_rms,
            tolerances.beta_rms,
        )
        self._floor = [0.0] * len(TURBULENCE_CHANNELS)
        self._ground = 0
        self.restart()

    def restart(self) -> None:
        """Forget the motion; what was learned on the ground stays."""
        self._past: deque[Sequence[float]] = deque(
            maxlen=(TRIM.window_count - 1) * self._second + 1
        )
        self.tolerance_ratio, self.worst_channel, self.is_lasting = math.nan, "", False
        self.gust_strength: float | None = None

    def learn_ground_noise(self, powers: Sequence[float]) -> None:
        """Take in what is to be seen of a standing aircraft: noise and vibration."""
        self._ground += 1
        self._floor = [
            floor + (power - floor) / self._ground if power == power else floor
            for floor, power in zip(self._floor, powers, strict=True)
        ]

    def step(self, powers: Sequence[float], speed: float) -> None:
        """Go on by one tick.

        Parameters
        ----------
        powers : sequence of float
            Of `TURBULENCE_CHANNELS`, SI squared; NaN where missing.
        """
        self._past.append(self._with_alpha(powers, speed))
        seconds = [self._past[place] for place in range(len(self._past) - 1, -1, -self._second)]
        self.tolerance_ratio, self.worst_channel, self.is_lasting = math.nan, "", False
        for place, limit in enumerate(self._limits):
            floor = self._floor[place]
            clean = [max(one[place] - floor, 0.0) for one in seconds if one[place] == one[place]]
            recent = clean[: self._now]
            if not recent:
                continue
            share = math.sqrt(sum(recent) / len(recent)) / limit
            if not share <= self.tolerance_ratio:
                self.tolerance_ratio, self.worst_channel = share, TURBULENCE_CHANNELS[place]
                self.is_lasting = (
                    len(clean) >= TRIM.window_count
                    and min(clean) > (TRIM.lasting_share * limit) ** 2
                )
        self.gust_strength = self._gusts(seconds, speed)

    def _with_alpha(self, powers: Sequence[float], speed: float) -> Sequence[float]:
        """Put what the lift tells of alpha in place of a vane that is not there."""
        if (
            powers[_ALPHA] == powers[_ALPHA]
            or self._loading is None
            or not speed > TRIM.min_gust_speed
        ):
            return powers
        lift = max(powers[_LIFT] - self._floor[_LIFT], 0.0)
        told = lift * (self._loading / (SEA_LEVEL_DENSITY * speed * speed)) ** 2
        return (*powers[:_ALPHA], told, *powers[_ALPHA + 1 :])

    def _gusts(self, seconds: list[Sequence[float]], speed: float) -> float | None:
        alpha = [one[_ALPHA] for one in seconds if one[_ALPHA] == one[_ALPHA]]
        if not alpha or not speed > TRIM.min_gust_speed:
            return None
        bump = max(sum(alpha) / len(alpha) - self._floor[_ALPHA], 0.0)
        return TRIM.gust_ratio * speed * math.sqrt(bump)

"""The air at the field, the cover of the pitot, and a breath into it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gsapp.quantities import FloatArray
from gsapp.virtual.bench.operator_motion import PitotBreath

_HALF_DENSITY = 0.6
"""kg/m^3."""
_BREATHING_IN = 0.5


@dataclass(frozen=True, slots=True, kw_only=True)
class BenchWeather:
    """The air at the field: static pressure, Pa, and temperature, K."""

    pressure: float
    temperature: float

    @classmethod
    def sample(cls, random: np.random.Generator) -> BenchWeather:
        """Draw the weather of a day."""
        return cls(
            pressure=float(random.uniform(96e3, 102e3)),
            temperature=float(random.uniform(278.0, 306.0)),
        )


class Pitot:
    """What the pitot feels: a light gusty wind, nothing under its cover, or a breath.

    Parameters
    ----------
    gust_phases : ndarray, shape (3,)
        Of the gusts, rad.
    """

    def __init__(self, gust_phases: FloatArray) -> None:
        self._phases = gust_phases
        self._breath: PitotBreath | None = None
        self.covered = False

    def blow(self, hands: np.random.Generator, now: float) -> float:
        """Have somebody take the cover off and blow; return when it is over, s."""
        self.covered = False
        self._breath = PitotBreath(
            begin=now + _BREATHING_IN,
            seconds=float(hands.uniform(1.0, 1.8)),
            peak=float(hands.uniform(500.0, 2200.0)),
        )
        return self._breath.end

    def is_blowing(self, now: float) -> bool:
        """Return whether somebody is at it."""
        return self._breath is not None and self._breath.end > now

    def pressure(self, times: FloatArray) -> FloatArray:
        """Return the dynamic pressure, Pa, shape (n,)."""
        a, b, c = self._phases
        wind = 2.0 + 0.9 * np.sin(0.6 * times + a) + 0.6 * np.sin(1.9 * times + b)
        wind = wind + 0.4 * np.sin(4.3 * times + c)
        felt = np.zeros(times.size) if self.covered else _HALF_DENSITY * wind * np.abs(wind)
        if self._breath is not None:
            felt = felt + self._breath.pressure(times)
        return np.asarray(felt)

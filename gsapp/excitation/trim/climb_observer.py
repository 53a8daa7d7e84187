"""The rate of climb now, from a height that comes late and from accelerations that do not.

Height is read half a second late and with the noise of a static pressure. So it is followed where
it is, and accelerations carry the rate of climb on to the present.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Final

from gsapp.excitation.flight_rows import SLOW_CHANNEL_DELAY
from gsapp.excitation.trim.two_state_filter import TwoStateKalmanFilter

_START: Final = (10.0, 5.0)
"""Standard deviations of height (m) and rate of climb (m/s) before anything was seen."""
_HEIGHT: Final = 0.5
"""Standard deviation of the mean height of a tick, m: static pressure with its noise."""
_RATE: Final = 0.5
"""The same of a measured rate of climb, m/s."""
_LIFTED: Final = 0.1**2
"""What the integrated acceleration adds, (m/s)^2 a second: attitude is known to a degree or two."""
_ASTRAY: Final = 15.0
"""A height farther than this from where it should be, m, is a fault or a new beginning."""
_ASTRAY_FOR: Final = 0.5
"""Seconds of such heights that are a new beginning."""
_MISSING_FOR: Final = 2.0
"""Seconds without height and without rate of climb after which nothing is told."""


class ClimbObserver:
    """Follows the rate of climb tick by tick.

    Parameters
    ----------
    dt : float
        Between ticks, s.

    Attributes
    ----------
    climb : float
        m/s; NaN where nothing tells it.
    """

    def __init__(self, dt: float) -> None:
        self._dt = dt
        self._lag = round(SLOW_CHANNEL_DELAY / dt)
        self.restart()

    def restart(self) -> None:
        """Forget everything."""
        self._filter: TwoStateKalmanFilter | None = None
        self._lifts: deque[float] = deque([0.0] * self._lag, maxlen=self._lag)
        self._unseen = self._astray = 0.0
        self.climb = math.nan

    def step(self, height: float, climb_rate: float, lift: float) -> None:
        """Go on by one tick.

        Parameters
        ----------
        height, climb_rate : float
            As they were `SLOW_CHANNEL_DELAY` ago, m and m/s; NaN, as what follows, where missing.
        lift : float
            Acceleration upwards now, m/s^2.
        """
        dt = self._dt
        before = self._lifts[0]
        self._lifts.append(lift if lift == lift else 0.0)
        missing = height != height and climb_rate != climb_rate
        self._unseen = self._unseen + dt if missing else 0.0
        if self._filter is None:
            if not missing:
                self._filter = TwoStateKalmanFilter(
                    (height if height == height else 0.0, 0.0), _START
                )
            return
        state = self._filter
        if self._unseen > _MISSING_FOR:
            self.restart()
            return
        state.predict(
            (state.first + dt * state.second, state.second + dt * before),
            (dt, 0.0),
            (0.0, dt * _LIFTED),
        )
        self._astray = self._astray + dt if abs(height - state.first) > _ASTRAY else 0.0
        if self._astray > _ASTRAY_FOR:
            state = self._filter = TwoStateKalmanFilter((height, state.second), _START)
        elif height == height and not self._astray:
            state.update_first(height, _HEIGHT**2)
        elif climb_rate == climb_rate:
            state.update_second(climb_rate, _RATE**2)
        self.climb = state.second + dt * sum(self._lifts)

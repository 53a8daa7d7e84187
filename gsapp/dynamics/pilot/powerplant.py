"""Two ducted fans: throttle that lags, fan speeds, fuel that burns off."""

from __future__ import annotations

import math

from gsapp.aircraft import Aircraft

_FT = 0.3048
_UNLOADING = 0.3
"""Share by which the fans turn faster at 120 ft/s: 19,000 rpm on the ground, 25,000 in the air."""
_SPIN_DOWN = 1.2
"""Time constant of a fan that starts or runs down, s."""


class Powerplant:
    """The engines.

    Parameters
    ----------
    aircraft : Aircraft
        Lag, fan speeds, fuel flow.
    imbalance : float
        Share by which the left fan turns faster than the right one.
    dt : float
        Step, s.
    """

    def __init__(self, aircraft: Aircraft, imbalance: float, dt: float) -> None:
        self._aircraft = aircraft
        self._imbalance = imbalance
        self._dt = dt
        lag = aircraft.propulsion.lag
        self._share = 1.0 if lag <= 0.0 else 1.0 - math.exp(-dt / lag)
        self._turning = 0.0
        self.lever = 0.0
        """Where the throttle servo stands, 0 to 1."""
        self.throttle = 0.0
        """As the engines follow it, 0 to 1."""
        self.burned = 0.0
        """Fuel burned, kg."""
        self.speeds: tuple[float, float] = (0.0, 0.0)
        """Of the left and right fan, rad/s."""

    def advance(self, lever: float, *, running: bool, speed: float) -> None:
        """Go on by one step at an airspeed, m/s."""
        propulsion, mass = self._aircraft.propulsion, self._aircraft.mass
        self.lever = lever
        fuel_left = mass.fuel > self.burned or mass.fuel == 0.0
        running = running and fuel_left
        self.throttle += self._share * ((lever if running else 0.0) - self.throttle)
        target = 1.0 if running else 0.0
        self._turning += (1.0 - math.exp(-self._dt / _SPIN_DOWN)) * (target - self._turning)
        span = propulsion.rpm_full - propulsion.rpm_idle
        fan = (propulsion.rpm_idle + span * self.throttle) * self._turning
        fan *= 1.0 + _UNLOADING * min(speed / (120.0 * _FT), 1.0)
        self.speeds = (
            fan * (1.0 + 0.5 * self._imbalance),
            fan * (1.0 - 0.5 * self._imbalance),
        )
        if running:
            flow = mass.fuel_flow_idle + self.throttle * (
                mass.fuel_flow_full - mass.fuel_flow_idle
            )
            self.burned += flow * self._dt

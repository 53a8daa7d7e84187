"""Standard atmosphere, wind, and Dryden turbulence.

The atmosphere follows the day: ground temperature and pressure read at the field replace the
standard ones, the lapse rate stays. SI throughout.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gsapp.dynamics.arithmetic import Value
from gsapp.dynamics.signal_terms import lag_weights
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import FOOT, GRAVITY

SEA_LEVEL_DENSITY = 1.225
SEA_LEVEL_PRESSURE = 101325.0
SEA_LEVEL_TEMPERATURE = 288.15
LAPSE_RATE = 0.0065
GAS_CONSTANT = 287.05287
HEAT_CAPACITY_RATIO = 1.4

_EXPONENT = GRAVITY / (GAS_CONSTANT * LAPSE_RATE)


class AirState(NamedTuple):
    """State of the air at one height, or at many."""

    density: Value  # kg/m^3.
    pressure: Value  # Pa.
    temperature: Value  # K.


@dataclass(frozen=True, slots=True, kw_only=True)
class Atmosphere:
    """The troposphere of the day, below 11 km."""

    ground_altitude: float = 0.0  # Height of the field above sea level, m.
    ground_temperature: float | None = None
    """Read at the field, K; None takes the standard one for that height."""
    ground_pressure: float | None = None
    """Read at the field (not reduced to sea level), Pa; None takes the standard one."""

    def temperature(self, altitude: Value) -> Value:
        """Return the temperature (K) at a geometric altitude above sea level (m)."""
        ground = self.ground_temperature
        if ground is None:
            ground = SEA_LEVEL_TEMPERATURE - LAPSE_RATE * self.ground_altitude
        return ground - LAPSE_RATE * (altitude - self.ground_altitude)

    def pressure(self, altitude: Value) -> Value:
        """Return the pressure (Pa) at a geometric altitude above sea level (m)."""
        pressure = self.ground_pressure
        if pressure is None:
            pressure = float(pressure_at(self.ground_altitude))
        ground = self.temperature(self.ground_altitude)
        ratio = self.temperature(altitude) / ground
        return pressure * ratio**_EXPONENT

    def density(self, altitude: Value) -> Value:
        """Return the density (kg/m^3) at a geometric altitude above sea level (m)."""
        return self.pressure(altitude) / (GAS_CONSTANT * self.temperature(altitude))

    def at(self, altitude: Value) -> AirState:
        temperature = self.temperature(altitude)
        pressure = self.pressure(altitude)
        return AirState(
            density=pressure / (GAS_CONSTANT * temperature),
            pressure=pressure,
            temperature=temperature,
        )


def speed_of_sound(temperature: float) -> float:
    """Return the speed of sound (m/s) in air of a temperature (K)."""
    return math.sqrt(HEAT_CAPACITY_RATIO * GAS_CONSTANT * temperature)


def viscosity(temperature: float) -> float:
    """Return the dynamic viscosity (kg/(m s)) of air of a temperature (K).

    Sutherland's law with the constants of the U.S. Standard Atmosphere, 1976.
    """
    return 1.458e-6 * temperature * math.sqrt(temperature) / (temperature + 110.4)


def pressure_at(altitude: Value) -> Value:
    """Return the pressure (Pa) of the standard day at a pressure altitude (m)."""
    return SEA_LEVEL_PRESSURE * (1.0 - LAPSE_RATE * altitude / SEA_LEVEL_TEMPERATURE) ** _EXPONENT


def pressure_altitude(pressure: Value) -> Value:
    """Return the pressure altitude (m) at a static pressure (Pa): inverse of `pressure_at`."""
    ratio = (pressure / SEA_LEVEL_PRESSURE) ** (1.0 / _EXPONENT)
    return SEA_LEVEL_TEMPERATURE / LAPSE_RATE * (1.0 - ratio)


@dataclass(frozen=True, slots=True, kw_only=True)
class Wind:
    """Steady wind, as the velocity of the air over the ground."""

    north: float = 0.0
    east: float = 0.0
    down: float = 0.0
    """Velocity of the air at `reference_height`, m/s. A wind *from* the north has north < 0."""
    shear: float = 0.0
    """Exponent of the power law with height; 0 is the same wind at every height, 0.14 is usual over
    grass."""
    reference_height: float = 10.0  # m above the ground.

    def at(self, height: float) -> tuple[float, float, float]:
        """Return the velocity of the air (north, east, down; m/s) at a height (m) above ground."""
        if self.shear == 0.0:
            return self.north, self.east, self.down
        factor = (max(height, 0.5) / self.reference_height) ** self.shear
        return factor * self.north, factor * self.east, self.down


class DrydenTurbulence:
    """Dryden turbulence along the flight path, stepped exactly for any step and speed.

    The longitudinal gust is a first-order process with the time constant L/V, the lateral and
    vertical ones have the Dryden second-order shape (1 + sqrt(3) T s)/(1 + T s)^2, T = L/V. Each is
    discretized with its exact transition and covariance, so that the variance is sigma^2 at every
    step length and stays so while the speed changes. Standard deviations (u, v, w) are in m/s,
    scale lengths in m; the default is that of low flight over a field.

    With a `span` (m) there are rotational gusts, too (MIL-F-8785C, 3.7.2.2): p a first-order
    process, q and r the slopes of w and v along the path, smoothed over that span.
    """

    def __init__(
        self,
        sigma: tuple[float, float, float] | float,
        *,
        scale: tuple[float, float, float] = (500.0 * FOOT, 250.0 * FOOT, 100.0 * FOOT),
        span: float | None = None,
        seed: int = 0,
    ) -> None:
        self.sigma = (sigma, sigma, sigma) if isinstance(sigma, (int, float)) else tuple(sigma)
        self.scale = tuple(scale)
        self._random = np.random.default_rng(seed)
        start = self._random.standard_normal(5)
        # Stationary covariance of both second-order states is 1/4.
        self._u = float(start[0])
        self._v = (0.5 * float(start[1]), 0.5 * float(start[2]))
        self._w = (0.5 * float(start[3]), 0.5 * float(start[4]))
        self.span = span
        # A stream of its own: the gusts along the axes are the same with a span and without.
        self._roll_random = np.random.default_rng((seed, 1))
        self._roll = float(self._roll_random.standard_normal())
        self._smooth = self.gust[1:]
        self._rates = (0.0, 0.0)

    @property
    def gust(self) -> tuple[float, float, float]:
        """Return the gust now: velocity of the air along body x, y, z, m/s."""
        root3 = math.sqrt(3.0)
        return (
            self.sigma[0] * self._u,
            self.sigma[1] * (self._v[0] + root3 * self._v[1]),
            self.sigma[2] * (self._w[0] + root3 * self._w[1]),
        )

    @property
    def rotation(self) -> tuple[float, float, float]:
        """Return the rotation of the air now about body x, y, z, rad/s; zero without a span."""
        if self.span is None:
            return 0.0, 0.0, 0.0
        length = self.scale[2]
        # The integral of the one-sided spectrum of p.
        share = 0.1 * math.pi**2 / (length * self.span)
        share *= (math.pi * length / (4.0 * self.span)) ** (1.0 / 3.0)
        return (self.sigma[2] * math.sqrt(share) * self._roll, *self._rates)

    def advance(self, dt: float, V: float) -> tuple[float, float, float]:
        """Go on by `dt` (s) at the airspeed `V` (m/s) and return the gust there."""
        distance, before = max(V, 1.0) * dt, self.gust
        noise = self._random.standard_normal(5)
        decay = math.exp(-distance / self.scale[0])
        self._u = decay * self._u + math.sqrt(1.0 - decay * decay) * float(noise[0])
        self._v = _second_order(self._v, distance / self.scale[1], noise[1], noise[2])
        self._w = _second_order(self._w, distance / self.scale[2], noise[3], noise[4])
        if self.span is not None:
            self._rotate(distance, self.span, before)
        return self.gust

    def _rotate(self, distance: float, span: float, before: tuple[float, float, float]) -> None:
        """Go on by `distance` (m) from where the gust was `before`."""
        noise = float(self._roll_random.standard_normal())
        decay = math.exp(-distance * math.pi / (4.0 * span))
        self._roll = decay * self._roll + math.sqrt(1.0 - decay * decay) * noise
        smooth, rates = [], []
        for share, old, new, last in zip(
            (3.0, 4.0), before[1:], self.gust[1:], self._smooth, strict=True
        ):
            length = share * span / math.pi
            kept, earlier, later = lag_weights(length, distance)
            smooth.append(kept * last + earlier * old + later * new)
            rates.append((new - smooth[-1]) / length)
        self._smooth = (smooth[0], smooth[1])
        # Air that turns with q moves up (w < 0) ahead, with r to the right (v > 0).
        self._rates = (-rates[1], rates[0])

    def series(self, count: int, dt: float, V: float) -> FloatArray:
        """Return `count` successive gusts, shape (count, 3), m/s."""
        return np.array([self.advance(dt, V) for _ in range(count)]).reshape(count, 3)


def _second_order(
    state: tuple[float, float], a: float, one: float, two: float
) -> tuple[float, float]:
    """Advance x'' + 2 x' + x = white noise by `a` time constants (x, x'), covariance I/4."""
    decay = math.exp(-a)
    f11, f12 = decay * (1.0 + a), decay * a
    f21, f22 = -decay * a, decay * (1.0 - a)
    q11 = 0.25 * (1.0 - f11 * f11 - f12 * f12)
    q12 = -0.25 * (f11 * f21 + f12 * f22)
    q22 = 0.25 * (1.0 - f21 * f21 - f22 * f22)
    # q11 is of third order in a: for small steps the rounding may leave it below zero.
    l22 = math.sqrt(max(q22, 0.0))
    l12 = q12 / l22 if l22 > 0.0 else 0.0
    l11 = math.sqrt(max(q11 - l12 * l12, 0.0))
    x, y = state
    return (
        f11 * x + f12 * y + l12 * float(one) + l11 * float(two),
        f21 * x + f22 * y + l22 * float(one),
    )

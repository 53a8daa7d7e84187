"""What the pilot sees from beside the runway.

The pilot's world is laid out along the runway: `along` in the direction of take-off, `across`
towards the side of the pattern, turns towards the pattern positive. So one pilot flies left and
right patterns alike. Nothing is seen exactly, nothing at once, and airspeed not at all: it is
guessed from the motion over the ground.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from gsapp.virtual.flight_plan import FieldConditions, FlightPlan
from gsapp.virtual.settings import VIRTUAL


@dataclass(frozen=True, slots=True, kw_only=True)
class AircraftState:
    """Where the aircraft really is and how it moves: SI, radians."""

    time: float  # s since the box was switched on.
    phi: float
    theta: float
    psi: float
    """Attitude."""
    p: float
    q: float
    r: float
    """Body rates."""
    north: float
    east: float
    height: float
    """From the middle of the runway; `height` of the wheels above it."""
    velocity_north: float
    velocity_east: float
    climb_rate: float
    """Over the ground."""
    airspeed: float  # True airspeed.
    on_ground: bool  # Whether a main wheel carries weight.


@dataclass(frozen=True, slots=True, kw_only=True)
class PilotView:
    """What the pilot believes, `PilotLimits.delay` late; in the pilot's frame."""

    time: float  # Now, s.
    bank: float
    pitch: float
    """Attitude, rad; bank positive towards the pattern."""
    roll_rate: float
    pitch_rate: float
    """rad/s."""
    course: float  # Direction of motion from that of take-off, rad, in (-pi, pi].
    along: float
    across: float
    height: float
    """Position, m."""
    climb: float  # Rate of climb, m/s.
    path: float  # Angle of the flight path, rad.
    speed: float  # Airspeed guessed, m/s.
    ground_speed: float  # m/s.
    on_ground: bool


class RunwayFrame:
    """The pilot's frame on the field; the side of the pattern is ``left`` or ``right``."""

    def __init__(self, conditions: FieldConditions, side: str) -> None:
        self.heading = conditions.runway_heading
        self.sign = 1.0 if side == "right" else -1.0
        self._cos, self._sin = math.cos(self.heading), math.sin(self.heading)

    def to_runway(self, north: float, east: float) -> tuple[float, float]:
        """Return (along, across) of a place, m."""
        return (
            north * self._cos + east * self._sin,
            self.sign * (east * self._cos - north * self._sin),
        )

    def to_north_east(self, along: float, across: float) -> tuple[float, float]:
        """Return (north, east) of a place, m."""
        right = self.sign * across
        return (
            along * self._cos - right * self._sin,
            along * self._sin + right * self._cos,
        )

    def course(self, psi: float) -> float:
        """Return a heading as seen from the direction of take-off, rad in (-pi, pi]."""
        return self.sign * math.remainder(psi - self.heading, 2.0 * math.pi)


class _PerceptionError:
    """An error that drifts smoothly: two lags in series, unit variance."""

    def __init__(self, random: np.random.Generator, time_constant: float, dt: float) -> None:
        self._random = random
        self._decay = math.exp(-2.0 * dt / time_constant)
        # Two equal lags pass half of the variance on.
        self._drive = math.sqrt(2.0 * (1.0 - self._decay**2))
        self._rough = math.sqrt(2.0) * float(random.standard_normal())
        self.value = float(random.standard_normal())

    def advance(self) -> float:
        self._rough = self._decay * self._rough + self._drive * float(
            self._random.standard_normal()
        )
        self.value = self._decay * self.value + (1.0 - self._decay) * self._rough
        return self.value


class PilotPerception:
    """Turns the situation into the pilot's view every `dt` s: late, drifting, worse far away."""

    def __init__(
        self, plan: FlightPlan, runway: RunwayFrame, random: np.random.Generator, dt: float
    ) -> None:
        self._human = plan.human
        self._runway = runway
        self._late: deque[AircraftState] = deque(maxlen=1 + round(plan.human.delay / dt))
        self._bank = _PerceptionError(random, 1.5, dt)
        self._pitch = _PerceptionError(random, 2.0, dt)
        self._along = _PerceptionError(random, 3.0, dt)
        self._across = _PerceptionError(random, 3.0, dt)
        self._height = _PerceptionError(random, 3.0, dt)
        self._climb = _PerceptionError(random, 2.0, dt)
        self._speed = _PerceptionError(random, 12.0, dt)

    def perceive(self, situation: AircraftState) -> PilotView:
        self._late.append(situation)
        seen = self._late[0]
        human, sign = self._human, self._runway.sign
        along, across = self._runway.to_runway(seen.north, seen.east)
        distance = math.hypot(along, across - VIRTUAL.pilot_position_across, seen.height)
        blur = human.distance_error * distance
        # A model at arm's length is judged to a hand's breadth, its attitude to a degree.
        clarity = min(1.0, 0.2 + distance / 150.0)
        ground_speed = math.hypot(seen.velocity_north, seen.velocity_east)
        climb = seen.climb_rate + 0.2 * blur * self._climb.advance()
        course = (
            math.atan2(seen.velocity_east, seen.velocity_north) if ground_speed > 2.0 else seen.psi
        )
        path = math.atan2(climb, max(ground_speed, 5.0))
        pitch = seen.theta + human.pitch_error * clarity * self._pitch.advance()
        guess = seen.airspeed + human.speed_error * clarity * self._speed.advance()
        # A nose far above the path says "slow", whatever the motion over the ground says.
        hanging = max(pitch - path - VIRTUAL.hanging_angle, 0.0)
        return PilotView(
            time=situation.time,
            bank=sign * seen.phi + human.bank_error * clarity * self._bank.advance(),
            pitch=pitch,
            roll_rate=sign * seen.p,
            pitch_rate=seen.q * math.cos(seen.phi) - seen.r * math.sin(seen.phi),
            course=self._runway.course(course),
            along=along + blur * self._along.advance(),
            across=across + blur * self._across.advance(),
            height=seen.height + 0.5 * blur * self._height.advance(),
            climb=climb,
            path=path,
            speed=max(guess if seen.on_ground else guess - 50.0 * hanging, 0.0),
            ground_speed=ground_speed,
            on_ground=seen.on_ground,
        )

"""What a person does to the aircraft: sets surfaces, lays it down, turns its table, blows.

All of it takes the time that a person takes. Movements are functions of time; only tremor is a
process, and it runs on from sample to sample.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from calibration.inertial.accelerometers import Position, specific_force
from gsapp.foundation import FlightError
from gsapp.quantities import FloatArray
from gsapp.virtual.bench.bench_instruments import GYROS
from gsapp.virtual.settings import VIRTUAL


def _smooth(share: FloatArray) -> FloatArray:
    s = np.clip(share, 0.0, 1.0)
    return np.asarray(s**3 * (10.0 - 15.0 * s + 6.0 * s * s))


def _smooth_rate(share: FloatArray) -> FloatArray:
    s = np.clip(share, 0.0, 1.0)
    return np.asarray(30.0 * s * s * (1.0 - s) ** 2)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Movement:
    begin: float
    seconds: float
    """s."""

    @property
    def end(self) -> float:
        return self.begin + self.seconds


@dataclass(frozen=True, slots=True, kw_only=True)
class SurfaceMovement(_Movement):
    """A surface brought to an angle, always from the side it comes from."""

    start: float
    target: float
    """deg."""

    @classmethod
    def create(cls, begin: float, start: float, target: float) -> SurfaceMovement:
        """Return a movement that takes as long as a hand needs."""
        seconds = math.ceil(100.0 * (1.2 + abs(target - start) / VIRTUAL.surface_rate)) / 100.0
        return cls(begin=begin, seconds=seconds, start=start, target=target)

    @property
    def final_angle(self) -> float:
        """Return where the surface is from the end on, to the last bit of `angles`, deg."""
        return self.start + (self.target - self.start)

    def angles(self, times: FloatArray) -> FloatArray:
        """Return where the surface is, deg, shape (n,)."""
        share = (times - self.begin) / self.seconds
        # Most of the way at once, then slowly up to the mark: never past it, for the way back
        # would take up the play from the other side.
        way = 0.92 * _smooth(share / 0.65) + 0.08 * _smooth((share - 0.5) / 0.5)
        return np.asarray(self.start + (self.target - self.start) * way)

    def tremor_gain(self, times: FloatArray) -> FloatArray:
        """Return how much of the hand's tremor the surface feels, 0 to 1, shape (n,).

        Less and less as it comes to the angle, where the hand lets go.
        """
        share = (times - self.begin) / self.seconds
        return np.asarray(1.0 - _smooth((share - 0.6) / 0.4))


class OperatorTremor:
    """The unrest of a hand, deg: a resonance about eight times a second, shaken by noise."""

    def __init__(self, dt: float) -> None:
        # y[k] = a y[k-1] + b y[k-2] + noise, of unit size for a noise of size `gain`.
        self._a = (
            2.0 * VIRTUAL.tremor_decay * math.cos(2.0 * math.pi * VIRTUAL.tremor_frequency * dt)
        )
        self._b = -(VIRTUAL.tremor_decay**2)
        a, b = self._a, self._b
        self._gain = VIRTUAL.tremor_std * math.sqrt(
            (1.0 + b) * ((1.0 - b) ** 2 - a * a) / (1.0 - b)
        )
        self._last = (0.0, 0.0)

    def __call__(self, white: FloatArray) -> FloatArray:
        """Return the tremor (n,) that white noise of unit size (n,) makes."""
        last, before = self._last
        unrest = np.empty(white.size)
        for index, shake in enumerate((self._gain * white).tolist()):
            last, before = self._a * last + self._b * before + shake, last
            unrest[index] = last
        self._last = (last, before)
        return unrest


@dataclass(frozen=True, slots=True, kw_only=True)
class AttitudeMovement(_Movement):
    """The aircraft brought from one attitude to another."""

    start: tuple[float, float, float]
    target: tuple[float, float, float]
    """Unit vector that points up, in body axes (x forward, y right, z down)."""

    def motion(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the upward direction (n, 3) and the body rates (n, 3), deg/s."""
        a, b = np.array(self.start), np.array(self.target)
        between = math.acos(float(np.clip(a @ b, -1.0, 1.0)))
        axis = np.cross(a, b)
        if np.linalg.norm(axis) < 1e-6:
            # On its back: over the axis that is level and least concerned.
            axis = np.cross(a, np.eye(3)[int(np.argmin(np.abs(a)))])
        axis /= np.linalg.norm(axis)
        share = (times - self.begin) / self.seconds
        angle = between * _smooth(share)
        side = np.cross(axis, a)
        up = np.cos(angle)[:, None] * a + np.sin(angle)[:, None] * side
        # A direction fixed in the world turns backwards as seen from the body.
        rate = -np.degrees(between) * _smooth_rate(share) / self.seconds
        return up, rate[:, None] * axis


@dataclass(frozen=True, slots=True, kw_only=True)
class TableRotation(_Movement):
    """The table turned through an angle."""

    angle: float  # deg, right-handed about the body axis that is upright.
    axis: int  # That axis: 0, 1, 2 for x, y, z.
    ripple: float  # Share by which the rate of the hand goes up and down.

    def rates(self, times: FloatArray) -> FloatArray:
        """Return the rate of the table, deg/s, shape (n,); it adds up to the angle exactly."""
        share = np.clip((times - self.begin) / self.seconds, 0.0, 1.0)
        lifting = 1.0 - np.cos(2.0 * np.pi * share)
        # Odd about the middle: the waves leave the sum alone.
        waves = self.ripple * lifting * np.sin(10.0 * np.pi * share)
        return np.asarray(self.angle / self.seconds * (lifting + waves))


@dataclass(frozen=True, slots=True, kw_only=True)
class PitotBreath(_Movement):
    """A breath into the pitot."""

    peak: float  # Pa.

    def pressure(self, times: FloatArray) -> FloatArray:
        """Return the pressure, Pa, shape (n,)."""
        share = (times - self.begin) / self.seconds
        return np.asarray(self.peak * _smooth(share / 0.2) * _smooth((1.0 - share) / 0.25))


TURN_POSITIONS: Mapping[str, Position] = {"p": "x_down", "q": "y_up", "r": "z_down"}
"""How the aircraft lies on the table to turn about each axis."""

Direction = tuple[float, float, float]


class BenchAttitude:
    """The aircraft between the hands that lay and turn it, one movement after the other.

    How exactly they do it comes from the random numbers of `hands`.
    """

    def __init__(self, hands: np.random.Generator) -> None:
        self._hands = hands
        self._up = _up_direction("z_down")
        self._motions: deque[AttitudeMovement | TableRotation] = deque()

    @property
    def up_direction(self) -> Direction:
        """Return the direction that points up once all movements are done, in body axes."""
        for motion in reversed(self._motions):
            if isinstance(motion, AttitudeMovement):
                return motion.target
        return self._up

    @property
    def busy(self) -> bool:
        return bool(self._motions)

    def move_to_position(self, position: Position, now: float) -> float:
        """Have it laid in a position; return when it will be, s."""
        up = _up_direction(position)
        leaning = self._hands.normal(0.0, math.radians(VIRTUAL.positioning_std), 3)
        direction = np.array(up) + np.where(np.abs(up) > 0.5, 0.0, leaning)
        direction /= np.linalg.norm(direction)
        laying = AttitudeMovement(
            begin=self._free_at(now),
            seconds=VIRTUAL.laying_time,
            start=self.up_direction,
            target=(float(direction[0]), float(direction[1]), float(direction[2])),
        )
        self._motions.append(laying)
        return laying.end

    def rotate(self, channel: str, angle: float, seconds: float | None, now: float) -> float:
        """Have it turned about the axis of a gyro; return when it will be, s.

        Raise FlightError if it is no axis, or the turn takes no time.
        """
        if channel not in GYROS:
            raise FlightError(f"'{channel}' is not a turn axis; choose p, q or r")
        if seconds is not None and not seconds > 0.0:
            raise FlightError(f"a turn cannot take {seconds:g} s; give more than 0 s")
        axis = GYROS.index(channel)
        if abs(self.up_direction[axis]) < 0.9:
            self.move_to_position(TURN_POSITIONS[channel], now)
        marks = float(self._hands.normal(0.0, VIRTUAL.table_turn_std * math.sqrt(2.0)))
        turning = TableRotation(
            begin=self._free_at(now) + VIRTUAL.rest_before_turn,
            seconds=seconds or max(abs(angle) / VIRTUAL.table_turn_rate, VIRTUAL.min_turn_time),
            angle=angle + marks,
            axis=axis,
            ripple=float(self._hands.uniform(-0.2, 0.2)),
        )
        self._motions.append(turning)
        return turning.end

    def motion(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return specific force ax, ay, an (g) and rates p, q, r (deg/s), shape (n, 3) each.

        Times (s), shape (n,), come after those of the call before.
        """
        up = np.tile(self._up, (times.size, 1))
        rates = np.zeros((times.size, 3))
        while self._motions and times.size:
            motion = self._motions[0]
            # From its beginning on; after its end it stands still at what it has reached.
            after = times >= motion.begin
            if isinstance(motion, AttitudeMovement):
                ups, spins = motion.motion(times)
                up[after], rates[after] = ups[after], rates[after] + spins[after]
            else:
                sense = math.copysign(1.0, self._up[motion.axis])
                turning = sense * motion.rates(times)[:, None] * np.array(self._up)
                rates += np.where(after[:, None], turning, 0.0)
            if motion.end > times[-1]:
                break
            self._motions.popleft()
            if isinstance(motion, AttitudeMovement):
                self._up = motion.target
        return up * np.array([1.0, 1.0, -1.0]), rates

    def _free_at(self, now: float) -> float:
        return self._motions[-1].end if self._motions else now


def _up_direction(position: Position) -> Direction:
    force = specific_force(position)
    return force["ax"], force["ay"], -force["an"]

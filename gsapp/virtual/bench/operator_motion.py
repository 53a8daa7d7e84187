"""What a person does to the aircraft: sets surfaces, lays it down, turns its table, blows.

All of it takes the time that a person takes. Movements are functions of time; only tremor is a
process, and it runs on from sample to sample.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gsapp.quantities import FloatArray
from gsapp.virtual.settings import VIRTUAL


def _smooth(share: FloatArray) -> FloatArray:
    s = np.clip(share, 0.0, 1.0)
    return np.asarray(s**3 * (10.0 - 15.0 * s + 6.0 * s * s))


def _smooth_rate(share: FloatArray) -> FloatArray:
    s = np.clip(share, 0.0, 1.0)
    return np.asarray(30.0 * s * s * (1.0 - s) ** 2)


@dataclass(frozen=True, slots=True, kw_only=True)
class SurfaceMovement:
    """A surface brought to an angle, always from the side it comes from."""

    begin: float
    seconds: float
    """s."""
    start: float
    target: float
    """deg."""

    @classmethod
    def create(cls, begin: float, start: float, target: float) -> SurfaceMovement:
        """Return a movement that takes as long as a hand needs."""
        seconds = math.ceil(100.0 * (1.2 + abs(target - start) / VIRTUAL.surface_rate)) / 100.0
        return cls(begin=begin, seconds=seconds, start=start, target=target)

    @property
    def end(self) -> float:
        return self.begin + self.seconds

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
class AttitudeMovement:
    """The aircraft brought from one attitude to another."""

    begin: float
    seconds: float
    """s."""
    start: tuple[float, float, float]
    target: tuple[float, float, float]
    """Unit vector that points up, in body axes (x forward, y right, z down)."""

    @property
    def end(self) -> float:
        return self.begin + self.seconds

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
class TableRotation:
    """The table turned through an angle."""

    begin: float
    seconds: float
    """s."""
    angle: float  # deg, right-handed about the body axis that is upright.
    axis: int  # That axis: 0, 1, 2 for x, y, z.
    ripple: float  # Share by which the rate of the hand goes up and down.

    @property
    def end(self) -> float:
        return self.begin + self.seconds

    def rates(self, times: FloatArray) -> FloatArray:
        """Return the rate of the table, deg/s, shape (n,); it adds up to the angle exactly."""
        share = np.clip((times - self.begin) / self.seconds, 0.0, 1.0)
        lifting = 1.0 - np.cos(2.0 * np.pi * share)
        # Odd about the middle: the waves leave the sum alone.
        waves = self.ripple * lifting * np.sin(10.0 * np.pi * share)
        return np.asarray(self.angle / self.seconds * (lifting + waves))


@dataclass(frozen=True, slots=True, kw_only=True)
class PitotBreath:
    """A breath into the pitot."""

    begin: float
    seconds: float
    """s."""
    peak: float  # Pa.

    @property
    def end(self) -> float:
        return self.begin + self.seconds

    def pressure(self, times: FloatArray) -> FloatArray:
        """Return the pressure, Pa, shape (n,)."""
        share = (times - self.begin) / self.seconds
        return np.asarray(self.peak * _smooth(share / 0.2) * _smooth((1.0 - share) / 0.25))

"""Whether the aircraft flies; and what its gyros show while it stands, which is their zero."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.flight.maneuvers.airborne_detection import FRAME_DURATION, AirborneDetector
from gsapp.flight.maneuvers.signals import SIGNAL_COLUMNS, SIGNALS
from gsapp.quantities.constants import DEGREE

_FLOWN: Final = ("p", "q", "r", "V", "altitude")
_FEWEST_FRAMES: Final = 6
"""Frames of standing still that tell a zero."""
_SURE_FRAMES: Final = 4
"""Frames after which an aircraft that does not seem to fly is said to be on the ground: a record
may begin, or go on after a gap, in the air."""
_LARGEST_ZERO: Final = 5.0 * DEGREE
"""What is more, rad/s, is motion or a broken gyro."""
_SLOW: Final = 12.0
"""Airspeed below which no aircraft of this kind flies, m/s, where no aircraft file tells."""


class GroundMonitor:
    """Follows one flight tick by tick.

    Parameters
    ----------
    aircraft : Aircraft or None
        Without one an airspeed decides, and without that all counts as flown.
    dt : float
        Between ticks, s.

    Attributes
    ----------
    airborne, standing : bool
        Flies; stands still on the ground.
    on_ground : bool
        Is not airborne, and was looked at for long enough to say so.
    zero_offsets : tuple of float
        Of p, q, r, rad/s: to be taken off what they show.
    """

    def __init__(self, aircraft: Aircraft | None, dt: float) -> None:
        self._watch = None if aircraft is None else AirborneDetector(aircraft)
        self._length = round(FRAME_DURATION / dt)
        self._frame: list[tuple[float, ...]] = []
        self._frames = 0
        self._still = np.zeros(3)
        self._still_frames = np.zeros(3, dtype=np.int64)
        self.airborne = False
        self.on_ground = False
        self.standing = False
        self.zero_offsets = (0.0, 0.0, 0.0)

    def step(self, values: tuple[float, ...]) -> None:
        """Go on by one tick: p, q, r (rad/s), V (m/s), altitude (m); NaN where missing."""
        self._frame.append(values)
        if len(self._frame) < self._length:
            return
        means = [_mean(column) for column in zip(*self._frame, strict=True)]
        self._frame.clear()
        self._frames += 1
        self._decide(means)
        self.on_ground = not self.airborne and self._frames >= _SURE_FRAMES

    def _decide(self, means: list[float]) -> None:
        if self._watch is None:
            self.airborne = not means[3] < _SLOW
            self.standing = False
            return
        row = np.full(len(SIGNALS), np.nan)
        row[[SIGNAL_COLUMNS[name] for name in _FLOWN]] = means
        self._watch.add(self._frames * FRAME_DURATION, row)
        self.airborne = self._watch.airborne
        self.standing = not self.airborne and bool(self._watch.is_stationary)
        if self.standing:
            self._learn(means[:3])

    def _learn(self, rates: list[float]) -> None:
        there = np.abs(rates) < _LARGEST_ZERO
        self._still += np.where(there, rates, 0.0)
        self._still_frames += there
        known = self._still_frames >= _FEWEST_FRAMES
        p, q, r = np.where(known, self._still / np.maximum(self._still_frames, 1), 0.0).tolist()
        self.zero_offsets = (p, q, r)


def _mean(values: tuple[float, ...]) -> float:
    known = [value for value in values if math.isfinite(value)]
    return sum(known) / len(known) if known else math.nan

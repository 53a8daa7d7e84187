"""Whether the aircraft flies, frame by frame, from whatever tells it.

With airspeed: faster than it could fly slower, with hysteresis. Without it (a flight may lose its
air data altogether): from the slow part of the rates, which stays near zero on wheels whatever the
sticks do, and from altitude above the place where it stood.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.dynamics.atmosphere import SEA_LEVEL_DENSITY
from gsapp.flight.maneuvers.settings import DETECTION
from gsapp.flight.maneuvers.signals import SIGNAL_COLUMNS
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import GRAVITY


class AirborneDetector:
    """Follows one flight: whether it is airborne, since when, and what told it, in words.

    `since` is ``-inf`` for a record that begins in the present state; `is_stationary` is whether
    the airspeed says that it does not even roll, None where it does not tell.
    """

    def __init__(self, aircraft: Aircraft) -> None:
        self._speed = _SpeedCriterion(flying_speed(aircraft))
        self._motion = _MotionCriterion()
        self.airborne = False
        self.since = -math.inf
        self.criterion = "nothing"
        self.is_stationary: bool | None = None
        self._first = True
        self._still_since = math.nan
        self._rolling = DETECTION.standing_speed_ratio * flying_speed(aircraft)

    def add(self, time: float, means: FloatArray) -> None:
        """Take in the first time of a frame and the means of its signals."""
        speed = float(means[SIGNAL_COLUMNS["V"]])
        self._motion.add(means)
        self._speed.add(speed, moving=self._motion.turning)
        if math.isfinite(speed) and not self._speed.distrusted:
            flies, self.criterion = self._speed.flies, "airspeed"
            self.is_stationary = speed < self._rolling
        else:
            flies, self.criterion = self._motion.flies, self._motion.told_by
            self.is_stationary = None
            if self._speed.distrusted:
                self.criterion += (
                    " (the airspeed stays below flying speed while the aircraft rolls and pitches)"
                )
        by_motion = self.is_stationary is None
        self._still_since = (
            time - (self._motion.still - 1) * DETECTION.frame_duration if by_motion else math.nan
        )
        if flies != self.airborne:
            self.airborne = flies
            # Stillness is believed late, and was there long before.
            self.since = time if flies or not by_motion else self._still_since
            if self._first:
                self.since = -math.inf
        self._first = False

    @property
    def possible_landing_time(self) -> float | None:
        """Return when a landing seems to have been, s, that the record's end left undecided."""
        long_enough = self._motion.still >= DETECTION.still_frames_at_end and self._motion.low
        if self.airborne and self.is_stationary is None and self.since > -math.inf and long_enough:
            return self._still_since
        return None


class _SpeedCriterion:
    """Flies above one airspeed, has landed below another."""

    def __init__(self, flying_speed: float) -> None:
        self._flying_speed = flying_speed
        self._against = DETECTION.frames_to_change
        self._contradicted = 0
        self.flies = False

    @property
    def distrusted(self) -> bool:
        return self._contradicted >= DETECTION.frames_to_reject_airspeed

    def add(self, speed: float, *, moving: bool) -> None:
        if not math.isfinite(speed):
            return
        if self.distrusted:
            return
        if self.flies:
            self._contradicted = 0
        elif moving:
            self._contradicted += 1
        wanted = (
            speed
            > (DETECTION.landing_speed_ratio if self.flies else DETECTION.takeoff_speed_ratio)
            * self._flying_speed
        )
        self._against = 0 if wanted == self.flies else self._against + 1
        if self._against >= DETECTION.frames_to_change:
            self.flies, self._against = wanted, 0


class _MotionCriterion:
    """Flies when it rolls and pitches, or has climbed; has landed when long still and low."""

    def __init__(self) -> None:
        self._active: deque[bool] = deque(maxlen=DETECTION.airborne_rate_window)
        self._standing: list[float] = []
        self._ground: float | None = None
        self.still = 0
        self.low = True
        self.flies = False
        self.told_by = "nothing"

    @property
    def turning(self) -> bool:
        return bool(self._active) and self._active[-1]

    def add(self, means: FloatArray) -> None:
        altitude = float(means[SIGNAL_COLUMNS["altitude"]])
        rates = [abs(float(means[SIGNAL_COLUMNS[name]])) for name in ("p", "q")]
        known = [rate for rate in rates if math.isfinite(rate)]
        self._active.append(max(known, default=0.0) > DETECTION.airborne_rate)
        if not known and not math.isfinite(altitude):
            if not self.still and self.told_by == "nothing":
                # Nothing tells flight from ground: all counts as flown.
                self.flies = True
            return
        turning = max(known, default=0.0)
        self.still = self.still + 1 if turning < DETECTION.still_rate else 0
        height = self._height(altitude, turning)
        self.low = height is None or height < DETECTION.max_ground_height
        self.told_by = (
            " and ".join(
                name
                for name, there in (("rates", bool(known)), ("altitude", height is not None))
                if there
            )
            or "altitude"
        )
        if not self.flies:
            climbed = height is not None and height > DETECTION.min_climb
            self.flies = climbed or sum(self._active) >= DETECTION.min_airborne_rate_frames
        elif self.still >= DETECTION.still_frames_to_land and self.low:
            self.flies = False
            self._active.clear()

    def _height(self, altitude: float, turning: float) -> float | None:
        """Return the height above where it stood, m; None before it has stood anywhere."""
        if not math.isfinite(altitude):
            return None
        if self._ground is None and not self.flies:
            self._standing = [*self._standing, altitude] if turning < DETECTION.still_rate else []
            if len(self._standing) >= DETECTION.ground_altitude_frames:
                self._ground = float(np.median(self._standing))
        return None if self._ground is None else altitude - self._ground


def flying_speed(aircraft: Aircraft) -> float:
    """Return the airspeed (m/s) below which an aircraft does not fly."""
    if aircraft.limits.stall_speed > 0.0:
        return aircraft.limits.stall_speed
    weight = aircraft.mass.mass * GRAVITY
    area = aircraft.geometry.wing_area
    return math.sqrt(2.0 * weight / (SEA_LEVEL_DENSITY * area * DETECTION.max_lift_coefficient))

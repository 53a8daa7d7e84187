"""The straight legs of the pattern: whether this is one, and how many seconds of it are left.

A pilot turns where he turned the lap before. So each turn is kept with the place where it began
and with the length of the leg before it, by the direction of that leg. Where the aircraft is tells
how far it is to go; without a position the length of earlier legs does.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Final

from gsapp.excitation.settings import CUES, TRIM

_DOUBT: Final = {"position": 0.5, "turns": 1.5, "": 0.0}
"""Seconds by which pilots turn earlier than in the laps before, by what tells the end of a leg."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Leg:
    """A leg that was flown: by turn history, and over the ground where that is known."""

    heading: float
    length: float
    track: float
    north: float
    east: float


class LegMonitor:
    """Follows turns and legs tick by tick.

    `time_left` of the leg is None in a turn and where nothing tells; `source` is ``position``,
    ``turns`` or empty.
    """

    def __init__(self, dt: float) -> None:
        self._dt = dt
        self.restart()

    def restart(self) -> None:
        self._legs: deque[_Leg] = deque(maxlen=TRIM.max_legs)
        self._heading = 0.0
        self._turned = 0.0
        self._straight_for = 0.0
        self._on_leg = False
        self._leg_heading = 0.0
        self._began: _Leg | None = None
        self._places: deque[tuple[float, float]] = deque(
            maxlen=round(TRIM.position_memory / self._dt)
        )
        self.is_turning = False
        self.time_left: float | None = None
        self.source = ""
        self._laps = 0

    def step(self, rate: float, mean_rate: float, bank: float, north: float, east: float) -> None:
        """Go on by one tick; NaN where missing.

        Turn rate in this tick and over the last moments; position as it was
        `CUES.slow_channel_delay` ago.
        """
        if math.isfinite(rate):
            self._heading += rate * self._dt
        self._places.append((north, east))
        size = abs(mean_rate) if math.isfinite(mean_rate) else 0.0
        if self.is_turning:
            self._turned += rate * self._dt if math.isfinite(rate) else 0.0
            if abs(self._turned) > TRIM.min_pattern_turn and self._began is not None:
                self._keep(self._began)
            if size < TRIM.straight_rate:
                self._leave_turn()
        elif size > TRIM.turn_rate and not math.copysign(1.0, mean_rate) * bank < TRIM.turn_bank:
            self._enter_turn()
        if not self.is_turning or self._began is not None:
            self._straight_for += self._dt
        self._tell()

    @property
    def time_uncertainty(self) -> float:
        """Return how much earlier the turn may well come, s."""
        return _DOUBT[self.source] + (TRIM.single_lap_margin if self._laps == 1 else 0.0)

    def _enter_turn(self) -> None:
        self.is_turning, self._turned = True, 0.0
        north, east, track, speed = self._ground()
        # The leg ended here, if this becomes a turn of the pattern.
        ahead = (CUES.slow_channel_delay - TRIM.roll_in_time) * speed
        self._began = _Leg(
            heading=self._leg_heading,
            length=self._straight_for - TRIM.roll_in_time,
            track=track,
            north=north + ahead * math.cos(track),
            east=east + ahead * math.sin(track),
        )

    def _keep(self, leg: _Leg) -> None:
        if self._on_leg:
            self._legs.append(leg)
        self._began, self._on_leg = None, True

    def _leave_turn(self) -> None:
        self.is_turning = False
        if self._began is None:
            self._straight_for, self._leg_heading = 0.0, self._heading
        self._began = None

    def _tell(self) -> None:
        self.time_left, self.source, self._laps = None, "", 0
        if self.is_turning or not self._on_leg:
            return
        north, east, track, speed = self._ground()
        if speed > TRIM.min_ground_speed:
            alike = [
                leg
                for leg in self._legs
                if _angle_between(leg.track, track) < TRIM.same_track_tolerance
            ]
            ahead = [
                (leg.north - north) * math.cos(track) + (leg.east - east) * math.sin(track)
                for leg in alike[-TRIM.laps :]
            ]
            if ahead:
                self.time_left, self.source = (
                    min(ahead) / speed - CUES.slow_channel_delay,
                    "position",
                )
                self._laps = len(ahead)
        if self.time_left is None:
            same = [
                leg
                for leg in self._legs
                if _angle_between(leg.heading, self._leg_heading) < TRIM.same_track_tolerance
            ]
            lengths = [leg.length for leg in (same or list(self._legs))[-TRIM.laps :]]
            if lengths:
                self.time_left, self.source = min(lengths) - self._straight_for, "turns"
                self._laps = len(lengths)
        if self.time_left is not None and self.time_left < -TRIM.max_overrun:
            self.time_left, self.source = None, ""

    def _ground(self) -> tuple[float, float, float, float]:
        """Return the last position known (m), track (rad) and ground speed (m/s); NaN for none."""
        known = [(k, place) for k, place in enumerate(self._places) if math.isfinite(sum(place))]
        if len(known) < 2 or known[-1][0] < len(self._places) - 2:
            return math.nan, math.nan, math.nan, math.nan
        (first, (n0, e0)), (last, (n1, e1)) = known[0], known[-1]
        seconds = (last - first) * self._dt
        return n1, e1, math.atan2(e1 - e0, n1 - n0), math.hypot(n1 - n0, e1 - e0) / seconds


def _angle_between(one: float, other: float) -> float:
    apart = one - other
    return abs(math.remainder(apart, 2.0 * math.pi)) if math.isfinite(apart) else math.nan

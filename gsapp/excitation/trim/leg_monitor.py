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

from gsapp.excitation.flight_rows import SLOW_CHANNEL_DELAY
from gsapp.quantities.constants import DEGREE

TURN_RATE_LIMIT: Final = 8.0 * DEGREE
"""A mean turn rate beyond this, rad/s, is a turn; 45 deg of bank turn at 18 deg/s."""
STRAIGHT_RATE_LIMIT: Final = 5.0 * DEGREE
"""Below this, rad/s, a turn is over."""
TURN_BANK_LIMIT: Final = 12.0 * DEGREE
"""A turn is flown with more bank, rad; what yaws with less is the answer to a rudder."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LegMonitorSettings:
    """Settings of `LegMonitor`, checked by `tests/bench/trim_cue.py`."""

    rolling_in: float = 0.7
    """Seconds from the first bank to a mean turn rate of `TURN_RATE_LIMIT`."""
    pattern_turn: float = 60.0 * DEGREE
    """What turns less is a correction on the same leg, rad."""
    same_track_tolerance: float = 45.0 * DEGREE
    """Legs whose directions differ less are the same leg of the pattern, rad."""
    kept: int = 12
    """Legs remembered: three laps of four."""
    latest: int = 3
    """Laps by which the end of a leg is told."""
    one_lap: float = 1.0
    """Seconds more while one lap alone tells."""
    overrun: float = 3.0
    """A leg longer than this beyond its end, s, is flown to another plan."""
    memory: float = 1.5
    """Seconds of positions kept."""
    slowest: float = 5.0
    """Ground speed below which a position tells no direction, m/s."""


_SETTINGS: Final = LegMonitorSettings()


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

    Parameters
    ----------
    dt : float
        Between ticks, s.

    Attributes
    ----------
    time_left : float or None
        Seconds of the leg that are left; None in a turn and where nothing tells.
    source : str
        ``position``, ``turns`` or empty.
    """

    def __init__(self, dt: float) -> None:
        self._dt = dt
        self.restart()

    def restart(self) -> None:
        """Forget all legs."""
        self._legs: deque[_Leg] = deque(maxlen=_SETTINGS.kept)
        self._heading = 0.0
        self._turned = 0.0
        self._straight_for = 0.0
        self._on_leg = False
        self._leg_heading = 0.0
        self._began: _Leg | None = None
        self._places: deque[tuple[float, float]] = deque(maxlen=round(_SETTINGS.memory / self._dt))
        self.is_turning = False
        self.time_left: float | None = None
        self.source = ""
        self._laps = 0

    def step(self, rate: float, mean_rate: float, bank: float, north: float, east: float) -> None:
        """Go on by one tick.

        Parameters
        ----------
        rate, mean_rate : float
            Turn rate in this tick and over the last moments, rad/s; NaN where missing.
        bank : float
            rad; NaN where unknown.
        north, east : float
            Position as it was `SLOW_CHANNEL_DELAY` ago, m; NaN where missing.
        """
        if math.isfinite(rate):
            self._heading += rate * self._dt
        self._places.append((north, east))
        size = abs(mean_rate) if math.isfinite(mean_rate) else 0.0
        if self.is_turning:
            self._turned += rate * self._dt if math.isfinite(rate) else 0.0
            if abs(self._turned) > _SETTINGS.pattern_turn and self._began is not None:
                self._keep(self._began)
            if size < STRAIGHT_RATE_LIMIT:
                self._leave_turn()
        elif size > TURN_RATE_LIMIT and not math.copysign(1.0, mean_rate) * bank < TURN_BANK_LIMIT:
            self._enter_turn()
        if not self.is_turning or self._began is not None:
            self._straight_for += self._dt
        self._tell()

    @property
    def time_uncertainty(self) -> float:
        """Return how much earlier the turn may well come, s."""
        return _DOUBT[self.source] + (_SETTINGS.one_lap if self._laps == 1 else 0.0)

    def _enter_turn(self) -> None:
        self.is_turning, self._turned = True, 0.0
        north, east, track, speed = self._ground()
        # The leg ended here, if this becomes a turn of the pattern.
        ahead = (SLOW_CHANNEL_DELAY - _SETTINGS.rolling_in) * speed
        self._began = _Leg(
            heading=self._leg_heading,
            length=self._straight_for - _SETTINGS.rolling_in,
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
        if speed > _SETTINGS.slowest:
            alike = [
                leg
                for leg in self._legs
                if _angle_between(leg.track, track) < _SETTINGS.same_track_tolerance
            ]
            ahead = [
                (leg.north - north) * math.cos(track) + (leg.east - east) * math.sin(track)
                for leg in alike[-_SETTINGS.latest :]
            ]
            if ahead:
                self.time_left, self.source = min(ahead) / speed - SLOW_CHANNEL_DELAY, "position"
                self._laps = len(ahead)
        if self.time_left is None:
            same = [
                leg
                for leg in self._legs
                if _angle_between(leg.heading, self._leg_heading) < _SETTINGS.same_track_tolerance
            ]
            lengths = [leg.length for leg in (same or list(self._legs))[-_SETTINGS.latest :]]
            if lengths:
                self.time_left, self.source = min(lengths) - self._straight_for, "turns"
                self._laps = len(lengths)
        if self.time_left is not None and self.time_left < -_SETTINGS.overrun:
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

"""The space in which the aircraft may fly, and when it is about to leave it."""

from __future__ import annotations

import math
from pathlib import Path

from pydantic import Field, model_validator

from gsapp.excitation.alerts.alert import Alert, caution, format_amount, warning
from gsapp.excitation.alerts.row_frames import FlightFrame
from gsapp.excitation.settings import ALERTS
from gsapp.foundation import StrictModel, read_toml
from gsapp.quantities.constants import EARTH_RADIUS
from gsapp.quantities.fields import Angle, Length, Time


class Geofence(StrictModel):
    """A cylinder about the field.

    The usual one suits flying by eye: a model of nine feet can no longer be told from its back at
    half a mile, and 120 m above the ground is where other traffic may be.
    """

    latitude: Angle | None = None
    longitude: Angle | None = None
    """Of its center, rad; without them the place where it was seen first: where it stood before the
    take-off."""
    radius: Length = Field(default=800.0, gt=0.0)
    """m."""
    ceiling: Length = Field(default=120.0, gt=0.0)
    """Above the field, m."""
    floor: Length | None = None
    """Above the field, m; None where there is none. With flaps out it does not count."""
    ahead: Time = Field(default=4.0, ge=0.0)
    """How far ahead is looked, s."""

    @model_validator(mode="after")
    def _hangs_together(self) -> Geofence:
        if (self.latitude is None) != (self.longitude is None):
            raise ValueError("'latitude' and 'longitude' belong together; give both, or neither")
        if self.floor is not None and self.floor >= self.ceiling:
            raise ValueError("the floor is above the ceiling; swap 'floor' and 'ceiling'")
        return self


def load_geofence(path: Path) -> Geofence:
    """Read a fence from a TOML file."""
    return read_toml(path, Geofence)


class GeofenceMonitor:
    """Watches place and height."""

    def __init__(self, fence: Geofence) -> None:
        self._fence = fence
        self.restart()

    def restart(self) -> None:
        """Forget where the aircraft took off."""
        self._home: tuple[float, float] | None = None
        self._above_floor = False
        self._heights: list[tuple[float, float]] = []
        self._climbs: list[float] = []

    def evaluate(self, frame: FlightFrame, system: str = "US") -> list[Alert]:
        """Return what of the fence is left, or soon will be, in units ``US`` or ``SI``."""
        return [*self._around(frame, system), *self._above(frame, system)]

    def _around(self, frame: FlightFrame, system: str) -> list[Alert]:
        place = self._place(frame)
        if place is None or not frame.airborne:
            return []  # a place is taken note of even so
        north, east = place
        distance = math.hypot(north, east)
        speed, track = frame.last("ground_speed"), frame.last("track")
        coming = distance
        if math.isfinite(speed) and math.isfinite(track):
            way = speed * self._fence.ahead
            coming = math.hypot(north + way * math.cos(track), east + way * math.sin(track))
        radius = self._fence.radius
        if distance > radius:
            away, allowed = (format_amount("north", size, system) for size in (distance, radius))
            text = f"Outside the fence: {away} away, {allowed} allowed; turn back"
            return [warning("fence.side", text, "outside the fence: turn back")]
        if coming > radius:
            text = f"Leaving the fence within {self._fence.ahead:.0f} s; turn"
            return [caution("fence.side", text, "fence: turn")]
        return []

    def _place(self, frame: FlightFrame) -> tuple[float, float] | None:
        """Return north and east of the center, m; None where no position tells."""
        latitude, longitude = frame.last("latitude"), frame.last("longitude")
        if math.isfinite(latitude) and math.isfinite(longitude):
            place = EARTH_RADIUS * latitude, EARTH_RADIUS * longitude * math.cos(latitude)
        else:
            place = frame.last("north"), frame.last("east")
            if not math.isfinite(place[0] + place[1]):
                return None
            latitude = math.nan
        center = self._fence.latitude, self._fence.longitude
        if center[0] is not None and center[1] is not None:
            if math.isnan(latitude):
                return None  # of a center on the map a place beside it tells nothing
            home = EARTH_RADIUS * center[0], EARTH_RADIUS * center[1] * math.cos(latitude)
        else:
            if self._home is None:
                self._home = place
            home = self._home
        return place[0] - home[0], place[1] - home[1]

    def _above(self, frame: FlightFrame, system: str) -> list[Alert]:
        height, fence = frame.height, self._fence
        if not frame.airborne or math.isnan(height):
            self._heights, self._climbs = [], []
            return []
        climb = self._climb(frame)
        coming = height + fence.ahead * climb
        ceiling = format_amount("height", fence.ceiling, system)
        if height > fence.ceiling:
            now = format_amount("height", height, system)
            text = f"Too high: {now}, {ceiling} allowed; descend"
            return [warning("fence.top", text, "too high: descend")]
        if coming > fence.ceiling:
            text = f"Through the ceiling of {ceiling} within {fence.ahead:.0f} s; level off"
            return [caution("fence.top", text, "ceiling: level off")]
        lands = frame.mean("flap") > ALERTS.landing_flap
        return [] if lands else self._below(height, coming, system)

    def _below(self, height: float, coming: float, system: str) -> list[Alert]:
        floor = self._fence.floor
        if floor is None:
            return []
        self._above_floor = self._above_floor or height > floor + ALERTS.floor_margin
        if not self._above_floor or min(height, coming) >= floor:
            return []
        least = f"the floor of {format_amount('height', floor, system)}; climb"
        if height < floor:
            return [warning("fence.floor", f"Below {least}", "too low: climb")]
        return [caution("fence.floor", f"About to sink below {least}", "too low: climb")]

    def _climb(self, frame: FlightFrame) -> float:
        """Return the rate of climb over the last seconds, m/s."""
        rate = frame.mean("climb_rate")
        self._heights = [
            (time, height)
            for time, height in self._heights
            if frame.time - time < ALERTS.climb_time
        ]
        self._heights.append((frame.time, frame.height))
        if rate == rate:
            # The pull of an input is over before it leads anywhere.
            self._climbs = [*self._climbs[1 - ALERTS.climb_frames :], rate]
            return min(self._climbs, key=abs) if len(self._climbs) == ALERTS.climb_frames else 0.0
        (first, low), (last, high) = self._heights[0], self._heights[-1]
        return (high - low) / (last - first) if last - first > 0.5 * ALERTS.climb_time else 0.0

"""What is plotted besides samples over time: power density of a channel, track over the ground."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from gsapp.flight.map_tiles import GroundArea
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import EARTH_RADIUS

_MIN_SAMPLES = 16
_SEGMENTS = 8  # Half overlapped, of which a power density is the mean.

TrackSource = Literal["position", "ground speed", "airspeed"]
TRACK_CHANNELS: Final[Mapping[TrackSource, tuple[tuple[str, ...], ...]]] = {
    "position": (("latitude", "longitude"), ("north", "east")),
    "ground speed": (("ground_speed", "track"),),
    "airspeed": (("V", "psi"), ("Vc", "psi")),
}
"""Channels that give a track, best first."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundOrigin:
    """Where a track begins; north and east are measured on the sphere from here."""

    latitude: float  # rad
    longitude: float  # rad

    def place(
        self, latitude: FloatArray | float, longitude: FloatArray | float
    ) -> tuple[FloatArray, FloatArray]:
        """Return north and east, m, of places near it, rad."""
        turn = np.remainder(longitude - self.longitude + np.pi, 2.0 * np.pi) - np.pi
        return (
            np.asarray(EARTH_RADIUS * (latitude - self.latitude)),
            np.asarray(EARTH_RADIUS * np.cos(self.latitude) * turn),
        )

    def area(self, west: float, south: float, east: float, north: float) -> GroundArea:
        """Return the ground of a rectangle of east and north, m."""
        along = EARTH_RADIUS * np.cos(self.latitude)
        return GroundArea(
            south=float(self.latitude + south / EARTH_RADIUS),
            west=float(self.longitude + west / along),
            north=float(self.latitude + north / EARTH_RADIUS),
            east=float(self.longitude + east / along),
        )

    def rectangle(self, area: GroundArea) -> tuple[float, float, float, float]:
        """Return west, south, east and north edges, m: the inverse of `area`."""
        south, west = self.place(area.south, area.west)
        north, east = self.place(area.north, area.east)
        return float(west), float(south), float(east), float(north)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GroundTrack:
    """Path over the ground from where the samples begin."""

    north: FloatArray
    """Distance north, shape (n,), m; NaN where not known."""
    east: FloatArray
    """Distance east, shape (n,), m."""
    source: TrackSource
    """Position, or dead reckoning by speed over the ground, or by airspeed without wind."""
    origin: GroundOrigin | None = None
    """Where on the ground it begins; None where not known."""


def power_density(values: FloatArray, rate: float) -> tuple[FloatArray, FloatArray]:
    """Return the one-sided power spectral density of evenly spaced samples.

    Welch's method (IEEE Trans. Audio Electroacoust. 15, 1967) with Hann windows, over the longest
    stretch without a missing sample; each segment is freed from its straight line.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Samples; NaN where missing.
    rate : float
        Samples per second, Hz.

    Returns
    -------
    frequencies : ndarray, shape (m,)
        Above 0 to half the rate, Hz.
    density : ndarray, shape (m,)
        Square of the unit of the samples, per Hz. Both are empty for fewer than 16 samples.
    """
    from scipy.signal import welch  # heavy, and of no use until a spectrum is shown

    present = np.concatenate(([False], np.isfinite(values), [False]))
    edges = np.flatnonzero(np.diff(present))
    starts, stops = edges[::2], edges[1::2]
    if not starts.size:
        return np.empty(0), np.empty(0)
    longest = int(np.argmax(stops - starts))
    stretch = values[starts[longest] : stops[longest]]
    if stretch.size < _MIN_SAMPLES:
        return np.empty(0), np.empty(0)
    length = max(stretch.size // (_SEGMENTS + 1), _MIN_SAMPLES // 2) * 2  # even: to half the rate
    frequencies, density = welch(stretch, rate, nperseg=length, detrend="linear")
    return frequencies[1:], density[1:]


def ground_track(samples: Mapping[str, FloatArray], rate: float) -> GroundTrack | None:
    """Return the track of evenly spaced samples, by the best channels that hold any.

    Parameters
    ----------
    samples : mapping of str to ndarray, shape (n,)
        SI units, by channel; NaN where missing. See `TRACK_CHANNELS`.
    rate : float
        Samples per second, Hz.

    Returns
    -------
    GroundTrack or None
        None where no channels give a track.
    """
    for source, choices in TRACK_CHANNELS.items():
        for first, second in choices:
            if first not in samples or second not in samples:
                continue
            a, b = samples[first], samples[second]
            known = np.flatnonzero(np.isfinite(a) & np.isfinite(b))
            if not known.size:
                continue
            origin = None
            if source != "position":
                north, east = _dead_reckon(a, b, rate)
            elif first == "north":
                north, east = a - a[known[0]], b - b[known[0]]
            else:
                origin = GroundOrigin(latitude=float(a[known[0]]), longitude=float(b[known[0]]))
                north, east = origin.place(a, b)
            return GroundTrack(north=north, east=east, source=source, origin=origin)
    return None


def _dead_reckon(
    speed: FloatArray, heading: FloatArray, rate: float
) -> tuple[FloatArray, FloatArray]:
    """Return north and east, m, by speed, m/s, and heading, rad; a gap is flown as it began."""
    known = np.isfinite(speed) & np.isfinite(heading)
    last = np.maximum.accumulate(np.where(known, np.arange(known.size), -1))
    held = np.maximum(last, int(np.argmax(known)))
    step = np.where(last >= 0, speed[held], 0.0) / rate
    return np.cumsum(step * np.cos(heading[held])), np.cumsum(step * np.sin(heading[held]))

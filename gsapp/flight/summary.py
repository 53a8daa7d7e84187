"""What a recorded flight holds, in numbers: the JSON of ``gsapp replay --headless``."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.decoding.pipeline import ChannelSource
from gsapp.flight.events import Event
from gsapp.flight.flight import Flight, FrameCounts
from gsapp.flight.maneuvers import collect_maneuvers
from gsapp.flight.read_settings import DEFAULT_AIRCRAFT
from gsapp.flight.settings import FLIGHT_DATA
from gsapp.foundation import FlightError
from gsapp.quantities import CIRCULAR_CHANNELS, FloatArray, base_id


def summarize_flight(flight: Flight, aircraft: Aircraft | None = None) -> dict[str, Any]:
    """Sum up a flight.

    Parameters
    ----------
    aircraft : Aircraft, optional
        That flew it, for what its maneuvers are judged by; ``b777`` where nobody knows.

    Returns
    -------
    dict
        ``{"duration", "channels": {id: {"count", "rate", "min", "max", "mean", "gaps", "source",
        "measured", "calibrated"}}, "calibration": {"certificates": {id: {"stamp", "who"}},
        "given", "instead_of_own", "uncalibrated", "beyond": {id: samples}}, "onboard": {"file",
        "in_place", "why", "channels", "clock": {"offset", "offset_std", "drift", "drift_std",
        ...}}, "frames": {"good", "damaged", "unknown", "lost", "lines", "bad_lines"},
        "events", "cues", "maneuvers"}``. SI units; None
        where there is nothing to tell: `calibrated` of what needs no certificate, `given` where
        the flight's own were used.
    """
    frames = flight.frames
    return {
        "duration": round(flight.duration, 6),
        "channels": {
            name: {
                **channel_statistics(
                    flight.block.times,
                    flight.block[name],
                    circular=base_id(name) in CIRCULAR_CHANNELS,
                ),
                **_arrived_samples(flight, name),
                **_source(flight, name),
            }
            for name in flight.block.channels
        },
        "calibration": flight.calibration_json(),
        "onboard": flight.onboard.to_json() if flight.onboard else None,
        "frames": {name: getattr(frames, name, None) for name in FrameCounts.__slots__},
        "events": events_json(flight.events),
        "cues": [],
        "maneuvers": _maneuvers(flight, aircraft),
    }


def events_json(events: Iterable[Event]) -> list[dict[str, Any]]:
    """Return events for programs; a host time that nobody knows is None."""
    return [{**event.to_json(), "host_time_us": event.host_time_us or None} for event in events]


def _maneuvers(flight: Flight, aircraft: Aircraft | None) -> list[dict[str, Any]]:
    if flight.native:
        return []
    try:
        found = collect_maneuvers(flight, aircraft or load_aircraft(DEFAULT_AIRCRAFT)).maneuvers
    except FlightError:
        # A flight without surfaces holds no maneuver that could be seen.
        return []
    return [maneuver.to_json() for maneuver in found]


def channel_statistics(
    times: FloatArray, values: FloatArray, *, circular: bool = False
) -> dict[str, Any]:
    """Sum up one channel: times and values of shape (n,), NaN where missing.

    ``count`` of samples; ``rate`` by their median spacing, Hz; ``min``, ``max``, ``mean`` (of
    angles that are `circular`, 179 and -179 deg, 180 deg); ``gaps``, the times that it was missing
    for more than `FLIGHT_DATA.max_gap_periods` of its own periods between two samples.
    """
    present = ~np.isnan(values)
    samples = values[present]
    if not samples.size:
        return {"count": 0, "rate": None, "min": None, "max": None, "mean": None, "gaps": 0}
    spacings = np.diff(times[present])
    period = float(np.median(spacings)) if spacings.size else math.nan
    return {
        "count": int(samples.size),
        "rate": round(1.0 / period, 6) if period > 0.0 else None,
        "min": float(samples.min()),
        "max": float(samples.max()),
        "mean": _mean_angle(samples) if circular else float(samples.mean()),
        "gaps": int(np.count_nonzero(spacings > FLIGHT_DATA.max_gap_periods * period)),
    }


def _mean_angle(angles: FloatArray) -> float:
    middle = math.atan2(float(np.sin(angles).mean()), float(np.cos(angles).mean()))
    apart = (angles - middle + math.pi) % math.tau - math.pi
    return math.remainder(middle + float(apart.mean()), math.tau)


def _arrived_samples(flight: Flight, name: str) -> dict[str, Any]:
    """Return what arrived, where it was counted: the grid has more rows than slow messages."""
    source = flight.sources.get(name)
    if source is None or source.samples is None:
        return {}
    return {"count": source.samples, "rate": source.rate, "gaps": source.gaps}


def _source(flight: Flight, name: str) -> dict[str, Any]:
    source = flight.sources.get(name)
    return {
        "source": source.source if source else None,
        "measured": source.kind == "measured" if source else None,
        "calibrated": _calibrated(source) if source else None,
    }


def _calibrated(source: ChannelSource) -> bool | None:
    if source.uncalibrated_channel:
        return False
    return True if source.calibrated else None

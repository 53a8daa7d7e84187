"""Instruments that clip, stand still, or showed nothing at all over a maneuver: not measured.

A vane with a broken wire stands at one end for the whole maneuver. What the others measured is
worth as much as if it had never been mounted. A potentiometer that is stuck still passes a
converter, and its volts are corrected by a supply that is measured too: the last digits go on
flickering. What lives has noise of its own, which reaches from end to end over several standard
deviations within some dozen samples. So what moves by less than one of them shows neither the
aircraft nor itself.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.flight.maneuvers.settings import DETECTION
from gsapp.flight.maneuvers.signals import SURFACE_PAIRS, SURFACES
from gsapp.quantities import BoolArray, FloatArray


def clipping_ranges(aircraft: Aircraft) -> dict[str, tuple[float, float]]:
    """Return the range (SI) of the instrument behind each channel that may clip."""
    return {name: one.range for name, one in aircraft.sensors.by_channel.items()}


def is_at_range_limit(samples: FloatArray, limits: tuple[float, float]) -> BoolArray:
    """Return which samples lie within 1 % of the range's width from either end."""
    low, high = limits
    margin = DETECTION.range_margin * (high - low)
    with np.errstate(invalid="ignore"):
        return np.asarray((samples <= low + margin) | (samples >= high - margin), dtype=np.bool_)


def sensor_noise(aircraft: Aircraft) -> dict[str, float]:
    """Return the noise (standard deviation, SI) of vanes, gyros and surfaces; or zero."""
    sensors = aircraft.sensors
    surfaces = (
        "de",
        "da",
        "dr",
        "rudder",
        *(half for pair in SURFACE_PAIRS for half in pair),
    )
    return {
        **{name: sensors.by_channel[name].noise for name in ("alpha", "beta", "p", "q", "r")},
        **dict.fromkeys(surfaces, sensors.surfaces.noise),
    }


def is_stuck(samples: FloatArray, noise: float = 0.0) -> bool:
    """Return whether samples, some dozen of them, move by less than their instrument's noise.

    Where its standard deviation is not known (zero), only what is the same to the last bit stands
    still.
    """
    return bool(
        np.ptp(samples) <= max(noise, DETECTION.same_value_tolerance * float(np.abs(samples).max()))
    )


AIRSPEED: Final = ("V", "Vc", "qbar", "dynamic_pressure")
"""Channels that all come from the one probe."""


def find_dead_instruments(
    samples: Callable[[str], FloatArray], aircraft: Aircraft
) -> dict[str, tuple[str, ...]]:
    """Return the instruments that were dead over a maneuver: in words, and their channels.

    ``{"alpha": ("alpha",), "airspeed": AIRSPEED}``. `samples` gives those of a channel within the
    maneuver, SI; empty or NaN where missing.
    """
    found: dict[str, tuple[str, ...]] = {}
    for name, limits in clipping_ranges(aircraft).items():
        values = _finite_samples(samples(name))
        if (
            values.size >= DETECTION.min_clipped_samples
            and is_at_range_limit(values, limits).mean() >= DETECTION.dead_share
        ):
            found[name] = (name,)
    for name, (low, high) in _surface_travels(aircraft).items():
        values = _finite_samples(samples(name))
        beyond = DETECTION.beyond_travel_share * (high - low)
        gone = (values < low - beyond) | (values > high + beyond)
        if values.size >= DETECTION.min_clipped_samples and gone.mean() >= DETECTION.dead_share:
            found[name] = (name,)
    speed = _finite_samples(samples("V"))
    if (
        speed.size >= DETECTION.min_clipped_samples
        and float(speed.max()) < DETECTION.min_speed_ratio * aircraft.limits.stall_speed
    ):
        found["airspeed"] = AIRSPEED
    pressure = _finite_samples(samples("dynamic_pressure"))
    if pressure.size >= DETECTION.min_clipped_samples and is_stuck(pressure):
        # No maneuver is flown at one speed to the last bit: the tube is blocked, the sensor stuck.
        found["airspeed"] = AIRSPEED
    return {**found, **_find_stuck_sensors(samples, sensor_noise(aircraft))}


def _find_stuck_sensors(
    samples: Callable[[str], FloatArray], noise: Mapping[str, float]
) -> dict[str, tuple[str, ...]]:
    """Return what moves by less than its own noise, and halves of surfaces that stay behind.

    What is the same to the last bit may be a motion that there was not; what to make of it is for
    those to say who know what was moved.
    """
    found: dict[str, tuple[str, ...]] = {}
    for name in ("alpha", "beta", "p", "q", "r"):
        values = _finite_samples(samples(name))
        if (
            values.size >= DETECTION.min_stuck_samples
            and is_stuck(values, noise[name])
            and not is_stuck(values)
        ):
            found[name] = (name,)
    for halves, surfaces in SURFACE_PAIRS.items():
        shown = [_finite_samples(samples(name)) for name in halves]
        for name, own, other in zip(halves, shown, shown[::-1], strict=True):
            if (
                min(own.size, other.size) >= DETECTION.min_stuck_samples
                and is_stuck(own, noise[name])
                and np.ptp(other) > DETECTION.partner_movement
            ):
                found[name] = (name, *surfaces)
    return found


def _surface_travels(aircraft: Aircraft) -> dict[str, tuple[float, float]]:
    """Return how far each surface goes, rad."""
    return {name: getattr(aircraft.controls, name).travel for name in SURFACES}


def dead_instruments_text(instruments: dict[str, tuple[str, ...]]) -> str:
    """Return a sentence on what was dead; empty for nothing."""
    if not instruments:
        return ""
    *first, last = instruments
    listed = f"{', '.join(first)} and {last}" if first else last
    return (
        f"{listed} {'were' if first else 'was'} faulty (clipped, out of range or constant): "
        "treated as not measured"
    )


def _finite_samples(values: FloatArray) -> FloatArray:
    return values[np.isfinite(values)]

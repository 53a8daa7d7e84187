"""Instruments that show nothing new over a maneuver.

A potentiometer that is stuck still passes a converter, and its volts are corrected by a supply that
is measured too: the last digits go on flickering. What lives has noise of its own, which reaches
from end to end over several standard deviations within some dozen samples. So what moves by less
than one of them shows neither the aircraft nor itself.
"""

from __future__ import annotations

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.flight.maneuvers.settings import DETECTION
from gsapp.flight.maneuvers.signals import SURFACE_HALVES
from gsapp.quantities import FloatArray


def sensor_noise(aircraft: Aircraft) -> dict[str, float]:
    """Return the noise (standard deviation, SI) of vanes, gyros and surfaces; or zero."""
    sensors = aircraft.sensors
    surfaces = (
        "de",
        "da",
        "dr",
        "rudder",
        *(half for pair in SURFACE_HALVES.values() for half in pair),
    )
    return {
        **{name: sensors.by_channel[name].noise for name in ("alpha", "beta", "p", "q", "r")},
        **dict.fromkeys(surfaces, sensors.surfaces.noise),
    }


def is_stuck(samples: FloatArray, noise: float = 0.0) -> bool:
    """Return whether samples move by less than the noise of their own instrument.

    Parameters
    ----------
    samples : ndarray, shape (n,)
        Those that are there, some dozen at least.
    noise : float
        Standard deviation; zero where it is not known: then only what is the same to the last bit
        stands still.
    """
    return bool(
        np.ptp(samples) <= max(noise, DETECTION.same_value_tolerance * float(np.abs(samples).max()))
    )

"""Samples at the ends of the instruments' ranges."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from gsapp.aircraft import Aircraft
from gsapp.flight.maneuvers.settings import DETECTION
from gsapp.quantities import FloatArray

BoolArray = npt.NDArray[np.bool_]


def clipping_ranges(aircraft: Aircraft) -> dict[str, tuple[float, float]]:
    """Return the range (SI) of the instrument behind each channel that may clip."""
    return {name: one.range for name, one in aircraft.sensors.by_channel.items()}


def is_at_range_limit(samples: FloatArray, limits: tuple[float, float]) -> BoolArray:
    """Return which samples lie within 1 % of the range's width from either end."""
    low, high = limits
    margin = DETECTION.range_margin * (high - low)
    with np.errstate(invalid="ignore"):
        return np.asarray((samples <= low + margin) | (samples >= high - margin), dtype=np.bool_)

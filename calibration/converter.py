"""The converter in the aircraft's box: what it makes of the volts of every instrument."""

from __future__ import annotations

import numpy as np

from gsapp.quantities import BoolArray, FloatArray

BITS = 12
FULL_SCALE = 5.0
"""V."""
STEP = FULL_SCALE / 2**BITS
"""One count, V."""


def converted(volts: FloatArray) -> FloatArray:
    """Return volts as the converter tells them: multiples of `STEP` from 0 to below 5 V."""
    counts = np.clip(np.round(volts / STEP), 0, 2**BITS - 1)
    return np.asarray(counts * STEP, dtype=np.float64)


def at_an_end(volts: FloatArray) -> BoolArray:
    """Return which volts, as converted, stand so near an end that the truth may lie beyond it."""
    return np.asarray((volts <= 1.5 * STEP) | (volts >= FULL_SCALE - 2.5 * STEP))

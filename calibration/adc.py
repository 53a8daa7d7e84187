"""The converter in the aircraft's box: what it makes of the volts of every instrument."""

from __future__ import annotations

import numpy as np

from gsapp.quantities import BoolArray, FloatArray

ADC_BITS = 12
ADC_FULL_SCALE = 5.0
"""V."""
ADC_RESOLUTION = ADC_FULL_SCALE / 2**ADC_BITS
"""One count, V."""


def quantize(volts: FloatArray) -> FloatArray:
    """Return volts rounded to multiples of `ADC_RESOLUTION`, from 0 to below 5 V."""
    counts = np.clip(np.round(volts / ADC_RESOLUTION), 0, 2**ADC_BITS - 1)
    return np.asarray(counts * ADC_RESOLUTION, dtype=np.float64)


def is_clipped(volts: FloatArray) -> BoolArray:
    """Return which volts, as converted, stand so near an end that the truth may lie beyond it."""
    return np.asarray(
        (volts <= 1.5 * ADC_RESOLUTION) | (volts >= ADC_FULL_SCALE - 2.5 * ADC_RESOLUTION)
    )

"""Continuous gusts of the Dryden form at low altitude (MIL-HDBK-1797), by digital filters.

Written for the blind cases: not the program's own turbulence.
"""

import math

import numpy as np
from scipy.signal import bilinear, lfilter

from gsapp.quantities import FloatArray
from tests.discrepancy.blind.engine import STEPS_PER_SECOND
from tests.discrepancy.blind.jsbsim_aircraft import ALTITUDE, FOOT

_GROUND = 200.0
"""Height of the field, m: maneuvers are flown 100 m above it."""


def lengths(rms: float) -> tuple[float, float, float]:
    height = (ALTITUDE - _GROUND) / FOOT
    shape = 0.177 + 0.000823 * height
    return height / shape**1.2 * FOOT, height * FOOT, rms / shape**0.4


def dryden(rms: float, V: float, count: int, seed: tuple[int, ...]) -> FloatArray:
    """Return motion of the air along, across and down, m/s, shape (count, 3).

    Parameters
    ----------
    rms : float
        Of the vertical gust, m/s; horizontal gusts are larger, as near the ground.
    V : float
        Airspeed at which the gusts are crossed, m/s.
    count : int
        Steps of JSBSim.
    seed : tuple of int
    """
    random = np.random.default_rng(seed)
    long, tall, wide = lengths(rms)
    past = 60 * STEPS_PER_SECOND
    noise = random.standard_normal((3, count + past)) * math.sqrt(STEPS_PER_SECOND)

    def first(x: FloatArray) -> FloatArray:
        tau = long / V
        gain = wide * math.sqrt(2.0 * tau)
        return np.asarray(lfilter(*bilinear([gain], [tau, 1.0], STEPS_PER_SECOND), x))

    def second(x: FloatArray, size: float, length: float) -> FloatArray:
        tau = length / V
        gain = size * math.sqrt(tau)
        above = [gain * math.sqrt(3.0) * tau, gain]
        return np.asarray(
            lfilter(*bilinear(above, [tau * tau, 2.0 * tau, 1.0], STEPS_PER_SECOND), x)
        )

    rows = (first(noise[0]), second(noise[1], wide, long), second(noise[2], rms, tall))
    return np.stack([row[past:] for row in rows], axis=-1)

"""A certificate held against the potentiometer that it was made from."""

import numpy as np

from calibration import Certificate
from gsapp.quantities.constants import DEGREE
from gsapp.virtual.bench import Potentiometer

SUPPLY = 4.9
"""Of the potentiometers on the day that angles are read, V."""


def within(certificate: Certificate, truth: Potentiometer, random: np.random.Generator) -> float:
    low, high = (certificate.points[at].value for at in (0, len(certificate.points) // 2))
    angles = random.uniform(0.95 * low, 0.95 * high, 400)
    shafts = angles + truth.play * (random.integers(0, 2, angles.size) - 0.5)
    volts = truth.volts(shafts, SUPPLY)
    errors = np.abs(certificate.evaluate(volts, SUPPLY) / DEGREE - angles)
    return float(np.mean(errors <= certificate.uncertainty(volts, SUPPLY) / DEGREE))

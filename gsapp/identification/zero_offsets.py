"""What the zeros of accelerometers leave open in the constants of the force coefficients.

However long a record is, no mean of a force tells the zero of its accelerometer from CN_0, CA_0 and
CY_0. The same instrument flies in every maneuver, so this part of a bound does not shrink with
their number.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from gsapp.identification.maneuver import Maneuver
from gsapp.identification.preparation_settings import PREPARATION
from gsapp.identification.results import Estimate
from gsapp.quantities import FloatArray

_CONSTANT_TERMS: Final = ("CN_0", "CA_0", "CY_0")


def constant_term_offsets(
    maneuvers: Sequence[Maneuver],
    qbars: Sequence[FloatArray],
    zero: float = PREPARATION.accelerometer_offset,
) -> dict[str, float]:
    """Return what zeros leave open in the constants, by name.

    `qbars`, shape (n,): dynamic pressure in each of them, Pa.
    `zero`: uncertain acceleration along each force, m/s^2.
    """
    # The same instrument flew in all of them: a mean is no better.
    per_acceleration = float(
        np.mean(
            [
                one.mass / (one.aircraft.geometry.wing_area * float(np.mean(qbar)))
                for one, qbar in zip(maneuvers, qbars, strict=True)
            ]
        )
    )
    return dict.fromkeys(_CONSTANT_TERMS, zero * per_acceleration)


def add_offset_uncertainty(estimate: Estimate, offsets: Mapping[str, float]) -> Estimate:
    """Return an estimate whose bounds of constants include `constant_term_offsets`."""
    derivatives, covariance = dict(estimate.derivatives), np.array(estimate.covariance)
    for name, offset in offsets.items():
        if name not in estimate.free:
            continue
        place = estimate.free.index(name)
        covariance[place, place] += offset**2
        derivatives[name] = replace(
            derivatives[name], std=float(np.sqrt(covariance[place, place])), offset=offset
        )
    return replace(estimate, derivatives=derivatives, covariance=covariance)

r"""Accelerometers that stand to one side of where the aircraft file says.

At y to the right of the CG they show :math:`a_n - (\dot p + q r) y`, :math:`a_x - (\dot r - p q) y`
and :math:`a_y - (p^2 + r^2) y` (`gsapp.dynamics.sensors.accelerations_at`). An aircraft that is its
own mirror image has no force of that kind: rolling one way or the other changes normal and axial
force alike and the side force by its sign, and the terms of y do the opposite. So each of the three
coefficients, less its linear derivatives, tells y without the other two. How far ahead or below the
accelerometers stand is not told: free derivatives of the same coefficient follow it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from gsapp.dynamics.buildup import linear_variables
from gsapp.foundation import FlightError
from gsapp.identification.coefficients import smooth_coefficients
from gsapp.identification.compatibility import InstrumentError, correct_instruments
from gsapp.identification.compatibility.instrument_error import ACCELEROMETER
from gsapp.identification.compatibility.settings import COMPATIBILITY
from gsapp.identification.equation_error.equations import (
    FORCE_COEFFICIENTS,
    CoefficientCache,
    build_equation,
)
from gsapp.identification.equation_error.regression import Equation, solve_equation
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.motion import measured_motion


@dataclass(frozen=True, slots=True, kw_only=True)
class AccelerometerPositionSettings:
    """Engineering choices; sigmas are standard deviations."""

    max_maneuvers: int = 8  # Those with most rolling.
    min_channels: int = 2  # Coefficients that must show it ...
    channel_sigmas: float = 3.0  # ... each by this much, and within this of the mean ...
    scale_tolerance: float = 0.1  # ... or within this share of it: accelerometers have scales.


ACCELEROMETER_POSITION: Final = AccelerometerPositionSettings()


def find_lateral_offset(maneuvers: Sequence[Maneuver]) -> tuple[InstrumentError, ...]:
    """Return how far to the right accelerometers stand, if it is beyond chance and matters.

    The aircraft file's position is the a-priori value. At least two force coefficients must agree:
    one of them alone may have a term of its own that looks like it, as aileron deflections that do
    not match.

    Parameters
    ----------
    maneuvers : sequence of Maneuver
        Of one aircraft.

    Returns
    -------
    tuple of InstrumentError
        One, or none.
    """
    chosen = _most_rolling(maneuvers)
    try:
        found = [_distance_shown(coefficient, chosen) for coefficient in FORCE_COEFFICIENTS]
    except FlightError:
        return ()
    shown = np.array([one for one in found if one is not None])
    if len(shown) < ACCELEROMETER_POSITION.min_channels:
        return ()
    values, stds = shown.T
    span = maneuvers[0].aircraft.geometry.span
    prior = 1.0 / (COMPATIBILITY.plausible_position * span) ** 2
    # A channel whose scale is off is off by a share of y, however narrow its own bound.
    clear = np.abs(values) > ACCELEROMETER_POSITION.channel_sigmas * stds
    allowed = np.hypot(stds, ACCELEROMETER_POSITION.scale_tolerance * np.abs(values))
    weights = 1.0 / allowed**2
    information = float(weights.sum()) + prior
    y = float(weights @ values) / information
    misfit = (values - y) / allowed
    std = float(np.sqrt(max(1.0, misfit @ misfit / (len(values) - 1)) / information))
    excess = abs(y) - COMPATIBILITY.tolerable_position * span
    if (
        clear.sum() < ACCELEROMETER_POSITION.min_channels
        or np.abs(misfit).max() > ACCELEROMETER_POSITION.channel_sigmas
        or excess < COMPATIBILITY.position_sigmas * std
    ):
        return ()
    ahead, beside, below = maneuvers[0].aircraft.sensors.accelerometer.position
    return (
        InstrumentError(
            channel=ACCELEROMETER,
            kind="position",
            value=y,
            std=std,
            position=(ahead, beside + y, below),
        ),
    )


def _most_rolling(maneuvers: Sequence[Maneuver]) -> list[Maneuver]:
    """Return the maneuvers with most rolling, in their order."""
    power = [float(np.nan_to_num(np.nanvar(one.samples("p")))) if one.has("p") else 0.0
             for one in maneuvers]  # fmt: skip
    most = np.argsort(power)[-ACCELEROMETER_POSITION.max_maneuvers :]
    return [maneuvers[index] for index in sorted(most) if power[index] > 0.0]


def _distance_shown(coefficient: str, maneuvers: Sequence[Maneuver]) -> tuple[float, float] | None:
    """Return the distance to the right (m) that one coefficient shows, with its bound."""
    names = [f"{coefficient}_{suffix}" for suffix in ("0", *linear_variables(coefficient))]
    one_meter = InstrumentError(
        channel=ACCELEROMETER, kind="position", value=1.0, std=0.0, position=(0.0, 1.0, 0.0)
    )

    def build(flown: Sequence[Maneuver]) -> Equation | None:
        motions = [measured_motion(one) for one in flown]
        found = smooth_coefficients(flown, motions)
        return build_equation(coefficient, names, {}, found, CoefficientCache()).equation

    plain = build(maneuvers)
    moved = build([correct_instruments(one, [one_meter]) for one in maneuvers])
    if plain is None or moved is None:
        return None
    # Coefficients are linear in the position.
    X = np.column_stack((plain.X, plain.y - moved.y))
    solution = solve_equation(
        replace(
            plain, X=X, Z=X, names=(*plain.names, ACCELEROMETER), noise=np.pad(plain.noise, (0, 1))
        )
    )
    return float(solution.values[-1]), float(solution.std[-1])

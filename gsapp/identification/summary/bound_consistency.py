"""How far values scatter beyond their bounds, and what that says of the bounds."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.stats import chi2

from gsapp.quantities import FloatArray
from gsapp.quantities.constants import MAD_TO_STD


@dataclass(frozen=True, slots=True, kw_only=True)
class BoundConsistency:
    """Scatter against bounds."""

    ratio: float  # Scatter over what the bounds promise; 1 if they are honest.
    p_value: float
    """Chance of at least so large a ratio, were they honest and the derivative the same in all
    maneuvers."""
    between_maneuver_std: float
    """Standard deviation from maneuver to maneuver that the bounds do not explain, per radian
    (Paule and Mandel's estimate); 0 if they explain all."""


def assess_bound_consistency(values: FloatArray, stds: FloatArray) -> BoundConsistency | None:
    """Return how values scatter against their bounds, shapes (n,); None for fewer than three."""
    if values.size < 3:
        return None
    squares = _weighted_squares(values, stds, 0.0)
    freedom = values.size - 1
    return BoundConsistency(
        ratio=math.sqrt(squares / freedom),
        p_value=float(chi2.sf(squares, freedom)),
        between_maneuver_std=_paule_mandel_std(values, stds),
    )


def _weighted_squares(values: FloatArray, stds: FloatArray, between: float) -> float:
    """Return the sum of squared deviations from the weighted mean, in units of their variance."""
    weights = 1.0 / (stds**2 + between**2)
    mean = weights @ values / weights.sum()
    return float(weights @ (values - mean) ** 2)


def _paule_mandel_std(values: FloatArray, stds: FloatArray) -> float:
    freedom = values.size - 1
    if _weighted_squares(values, stds, 0.0) <= freedom:
        return 0.0
    most = 2.0 * float(np.ptp(values))
    return float(
        brentq(lambda tau: _weighted_squares(values, stds, tau) - freedom, 0.0, most, rtol=1e-6)
    )


def robust_center(values: FloatArray, stds: FloatArray) -> tuple[float, float]:
    """Return a center and a spread between maneuvers that a few wild values do not move.

    `values` and `stds`, shape (n,).

    Returns
    -------
    center, between : float
        Weighted median, and the standard deviation beyond the bounds by the median of absolute
        deviations.
    """
    order = np.argsort(values)
    heaped = np.cumsum(1.0 / stds[order])
    center = float(values[order][np.searchsorted(heaped, 0.5 * heaped[-1])])
    spread = MAD_TO_STD * float(np.median(np.abs(values - center)))
    return center, math.sqrt(max(spread**2 - float(np.median(stds)) ** 2, 0.0))

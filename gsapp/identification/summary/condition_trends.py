"""Whether a derivative changes with speed, angle of attack or sideslip over a campaign."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.stats import t as student

from gsapp.identification.summary.bound_consistency import assess_bound_consistency
from gsapp.identification.summary.derivative_points import (
    CONDITIONS,
    DerivativePoint,
    values_and_stds,
)
from gsapp.identification.summary.settings import SUMMARY
from gsapp.quantities import BoolArray, FloatArray
from gsapp.quantities.constants import DEGREE

_MIN_SPREAD: Final = {"V": 2.0, "alpha": 0.7 * DEGREE, "beta": 0.7 * DEGREE}
"""Standard deviation of a condition (SI) below which the campaign was flown at one and the same."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ConditionTrend:
    """A trend of one derivative."""

    condition: str  # Channel: ``V``, ``alpha``, ``beta``.
    slope: float
    std: float
    """Per radian and SI unit of the condition."""
    p_value: float  # Of this trend by itself, without a look at how many were tried.
    is_significant: bool = False
    """Whether it stands with all trends of the campaign looked at (Holm)."""


def fit_condition_trends(points: tuple[DerivativePoint, ...]) -> tuple[ConditionTrend, ...]:
    """Return the trend of a derivative with each condition that changed over the campaign.

    A weighted straight line; what values scatter beyond their bounds counts as noise.
    """
    found = []
    for name in CONDITIONS:
        chosen = tuple(one for one in points if name in one.conditions)
        x = np.array([one.conditions[name] for one in chosen])
        if len(chosen) < SUMMARY.min_trend_points or float(x.std(ddof=1)) < _MIN_SPREAD[name]:
            continue
        found.append(_fit_trend(name, x, *values_and_stds(chosen)))
    return tuple(found)


def _fit_trend(name: str, x: FloatArray, values: FloatArray, stds: FloatArray) -> ConditionTrend:
    weights = 1.0 / stds**2
    slope, spread, squares = _weighted_line(x, values, weights)
    freedom = values.size - 2
    if squares > freedom:
        # The scatter about the line itself is what its slope is as sure as.
        told = assess_bound_consistency(values - slope * x, stds)
        between = 0.0 if told is None else told.between_maneuver_std
        slope, spread, squares = _weighted_line(x, values, 1.0 / (stds**2 + between**2))
    spread *= math.sqrt(max(squares / freedom, 1.0))
    p_value = 2.0 * float(student.sf(abs(slope) / spread, freedom))
    return ConditionTrend(condition=name, slope=slope, std=spread, p_value=p_value)


def _weighted_line(
    x: FloatArray, values: FloatArray, weights: FloatArray
) -> tuple[float, float, float]:
    """Return slope, its standard deviation, and the weighted sum of squares about the line."""
    center = weights @ x / weights.sum()
    mean = weights @ values / weights.sum()
    information = float(weights @ (x - center) ** 2)
    slope = float(weights @ ((x - center) * (values - mean))) / information
    left = values - mean - slope * (x - center)
    return slope, 1.0 / math.sqrt(information), float(weights @ left**2)


def holm_significant(p_values: FloatArray) -> BoolArray:
    """Return which of many trends stand, shape (n,): Holm's procedure at 1 %."""
    stands = np.zeros(p_values.size, dtype=np.bool_)
    for rank, place in enumerate(np.argsort(p_values)):
        if p_values[place] > SUMMARY.trend_significance / (p_values.size - rank):
            break
        stands[place] = True
    return stands

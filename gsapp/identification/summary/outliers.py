"""Values that lie farther off than chance and bounds allow, and what may have done it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.stats import norm

from gsapp.identification.campaign import ManeuverResult
from gsapp.identification.statistics import CORRELATION_WARNING_PREFIX
from gsapp.identification.summary.bound_consistency import robust_center
from gsapp.identification.summary.derivative_points import (
    CONDITIONS,
    DerivativePoint,
    values_and_stds,
)
from gsapp.identification.summary.settings import SUMMARY
from gsapp.quantities import name_in_text
from gsapp.quantities.constants import DEGREE

_MIN_CONDITION_DISTANCE: Final = {"V": 3.0, "alpha": 2.0 * DEGREE, "beta": 4.0 * DEGREE}
"""How far from all others a maneuver's conditions must lie to be named (SI)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Outlier:
    """One value that is left out of the mean."""

    point: DerivativePoint
    sigmas: float
    """How far it lies from the others, signed: in standard deviations of its own bound and the
    spread between maneuvers together."""
    reasons: tuple[str, ...]  # What may have done it, in words; never empty.


def detect_outliers(points: tuple[DerivativePoint, ...], count: int) -> dict[int, float]:
    """Return which of the points lie too far off.

    `points`: of one derivative.
    `count`: points of all derivatives of the campaign: the more, the farther one strays by chance.

    Returns
    -------
    dict of int to float
        Place among the points to signed distance in standard deviations.
    """
    if len(points) < SUMMARY.min_points:
        return {}
    values, stds = values_and_stds(points)
    center, between = robust_center(values, stds)
    distance = (values - center) / np.hypot(stds, between)
    limit = max(
        SUMMARY.min_outlier_sigmas,
        float(norm.isf(0.5 * SUMMARY.outlier_significance / max(count, 1))),
    )
    return {int(k): float(distance[k]) for k in np.flatnonzero(np.abs(distance) > limit)}


def outlier_reasons(
    point: DerivativePoint, others: Sequence[DerivativePoint], result: ManeuverResult | None
) -> tuple[str, ...]:
    """Return what may have made a value wild, in words."""
    found = [*_condition_reasons(point, others), *_bound_reasons(point, others)]
    if result is not None:
        found += _fit_reasons(result)
    return tuple(found) or ("no cause found in its fit or conditions; inspect the maneuver",)


def _condition_reasons(point: DerivativePoint, others: Sequence[DerivativePoint]) -> list[str]:
    found = []
    for name in CONDITIONS:
        known = [one.conditions[name] for one in others if name in one.conditions]
        own = point.conditions.get(name)
        if own is None or not known:
            continue
        if own > max(known) + _MIN_CONDITION_DISTANCE[name]:
            found.append(f"flown at a higher {name_in_text(name)} than all others")
        elif own < min(known) - _MIN_CONDITION_DISTANCE[name]:
            found.append(f"flown at a lower {name_in_text(name)} than all others")
    return found


def _bound_reasons(point: DerivativePoint, others: Sequence[DerivativePoint]) -> list[str]:
    usual = float(np.median([one.std for one in others])) if others else 0.0
    if usual and point.std > SUMMARY.wide_bound_ratio * usual:
        return [f"its bound is {point.std / usual:.0f} times the usual one: weakly excited"]
    return []


def _fit_reasons(result: ManeuverResult) -> list[str]:
    estimate, maneuver = result.estimate, result.maneuver
    found = []
    clipped = [name for name, flags in maneuver.clipped.items() if flags.any()]
    if clipped:
        found.append(f"{', '.join(clipped)} was at the end of the instrument's range")
    if estimate is None:
        return found
    poor = [name for name, one in estimate.fit.items() if one.r2 < SUMMARY.poor_fit]
    if poor:
        found.append(f"the fit does not follow {', '.join(poor)}")
    found += [text for text in estimate.warnings if "gust" in text or "turbulence" in text]
    found += [text for text in estimate.warnings if text.startswith(CORRELATION_WARNING_PREFIX)]
    return found

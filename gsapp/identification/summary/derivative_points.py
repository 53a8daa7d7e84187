"""Each value that a maneuver gave a derivative, with the conditions that it was flown at."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from gsapp.identification.campaign import CampaignResult, ManeuverResult
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.summary.settings import SUMMARY
from gsapp.quantities import FloatArray

CONDITIONS: Final = ("V", "alpha", "beta")
"""Channels whose means before the input are a maneuver's conditions."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DerivativePoint:
    """One value of one derivative."""

    maneuver: str  # Its id.
    flight: str
    number: int  # Of the maneuver among all, from 1.
    value: float
    std: float
    """Per radian; the honest bound."""
    offset: float  # The part of `std` that all points have in common.
    conditions: Mapping[str, float]
    """Means before the input (SI) of those of `CONDITIONS` that were measured."""


def collect_points(
    result: CampaignResult, *, converged: bool = True
) -> dict[str, tuple[DerivativePoint, ...]]:
    """Return the points of each derivative that some maneuver earned, in order of maneuvers.

    `converged`: of the fits that converged, or of those that did not.
    """
    found: dict[str, list[DerivativePoint]] = {}
    for number, one in enumerate(result.results, start=1):
        if one.estimate is None or one.estimate.converged != converged:
            continue
        conditions = mean_conditions(one.maneuver)
        for name, (value, std, offset) in _estimated_values(one).items():
            point = DerivativePoint(
                maneuver=one.maneuver.id,
                flight=one.maneuver.flight,
                number=number,
                value=value,
                std=std,
                offset=offset,
                conditions=conditions,
            )
            found.setdefault(name, []).append(point)
    return {name: tuple(points) for name, points in found.items()}


def _estimated_values(one: ManeuverResult) -> dict[str, tuple[float, float, float]]:
    estimate = one.estimate
    if estimate is None:
        return {}
    return {
        name: (found.value, found.std, found.offset)
        for name, found in estimate.derivatives.items()
        if found.status == "estimated" and found.value is not None and found.std
    }


def mean_conditions(maneuver: Maneuver) -> dict[str, float]:
    """Return the means (SI) before the input, of what was measured."""
    early = maneuver.block.times <= maneuver.t_start + SUMMARY.trim_duration
    found = {}
    for name in CONDITIONS:
        samples = maneuver.samples(name)[early]
        samples = samples[np.isfinite(samples)]
        if samples.size:
            found[name] = float(samples.mean())
    return found


def values_and_stds(points: tuple[DerivativePoint, ...]) -> tuple[FloatArray, FloatArray]:
    """Return values and bounds, each of shape (n,)."""
    return np.array([one.value for one in points]), np.array([one.std for one in points])

"""How a campaign is estimated, and what it gives: estimates, the means over all, joint fits."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from pydantic import Field, NonNegativeFloat

from gsapp.dynamics.model import Model
from gsapp.identification.estimate_settings import EstimateSettings
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.results import Estimate
from gsapp.identification.statistics.settings import STATISTICS
from gsapp.quantities import FloatArray


class CampaignSettings(EstimateSettings):
    """The settings of a campaign, which no longer depend on a file."""

    known_model: Model | None = Field(
        None, description="Content of `model`: its values and effects are taken as known."
    )
    response_weights: Mapping[str, Mapping[str, NonNegativeFloat]] | None = Field(
        None,
        description="Content of `weights`: of the responses (SI), by name of the flight; '' for "
        "all others.",
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class CampaignValue:
    """One derivative over a campaign."""

    mean: float  # Weighted by inverse variance.
    std: float
    """Standard error of the mean; what comes from the zero of an instrument does not shrink with
    the number of maneuvers."""
    scatter: float | None  # Sample deviation; None for one value.
    n: int


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ManeuverResult:
    """What became of one maneuver."""

    maneuver: Maneuver
    estimate: Estimate | None  # None where it failed.
    failure: str = ""  # Why, in words.
    equation_error_estimate: Estimate | None = None
    """By equation error, of the same derivatives: where maximum likelihood found gusts in the
    residuals. It takes the air as the vanes felt it, and gusts do it little harm."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CampaignResult:
    """Results of all maneuvers, in their order."""

    settings: CampaignSettings
    results: tuple[ManeuverResult, ...]
    values: Mapping[str, CampaignValue]  # Of the derivatives that at least one maneuver earned.
    joint: tuple[Estimate, ...] = ()  # One for each axis, if asked for.
    remarks: tuple[str, ...] = ()
    """Maneuvers left out, aircraft that flew with another mass or CG than their file's, failures of
    joint fits."""


def campaign_values(estimates: Sequence[Estimate | None]) -> dict[str, CampaignValue]:
    """Return the means over the estimates that converged, by derivative."""
    collected: dict[str, list[tuple[float, float, float]]] = {}
    for estimate in estimates:
        if estimate is None or not estimate.converged:
            continue
        for name, one in estimate.derivatives.items():
            if one.status == "estimated" and one.value is not None and one.std:
                collected.setdefault(name, []).append((one.value, one.std, one.offset))
    return {name: weighted_mean(*np.array(found).T) for name, found in collected.items()}


def weighted_mean(values: FloatArray, stds: FloatArray, offsets: FloatArray) -> CampaignValue:
    """Return the weighted mean of values.

    `values`, `stds`, `offsets`, shape (n,): with their bounds, and the part of each bound that all
    have in common.
    """
    own = np.maximum(stds**2 - offsets**2, STATISTICS.min_own_variance_share * stds**2)
    weights = 1.0 / own
    weights /= weights.sum()
    return CampaignValue(
        mean=float(weights @ values),
        std=math.sqrt(float(weights**2 @ own) + float(weights @ offsets) ** 2),
        scatter=float(np.std(values, ddof=1)) if len(values) > 1 else None,
        n=len(values),
    )

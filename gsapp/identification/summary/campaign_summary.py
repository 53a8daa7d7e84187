"""The summary of a campaign, derivative by derivative."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

import numpy as np

from gsapp.dynamics.buildup import derivative_names
from gsapp.identification.campaign import (
    CampaignResult,
    CampaignValue,
    ManeuverResult,
    weighted_mean,
)
from gsapp.identification.summary.bound_consistency import (
    BoundConsistency,
    assess_bound_consistency,
)
from gsapp.identification.summary.condition_trends import (
    ConditionTrend,
    fit_condition_trends,
    holm_significant,
)
from gsapp.identification.summary.derivative_points import (
    DerivativePoint,
    collect_points,
    values_and_stds,
)
from gsapp.identification.summary.outliers import Outlier, detect_outliers, outlier_reasons
from gsapp.identification.summary.settings import SUMMARY


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DerivativeSummary:
    """One derivative over a campaign."""

    name: str
    points: tuple[DerivativePoint, ...]  # All of them, in order of maneuvers.
    outliers: tuple[Outlier, ...]  # Those left out of `value`.
    value: CampaignValue
    """Mean of the points that stand, each weighted by its own bound and what they scatter beyond
    bounds from maneuver to maneuver (`BoundConsistency.between`) together; so is its bound."""
    bound_consistency: BoundConsistency | None
    """Their scatter against their bounds; None for fewer than three, and for constants whose bounds
    hold the zero of an instrument."""
    trends: tuple[ConditionTrend, ...]
    excluded: tuple[DerivativePoint, ...] = ()  # Those left out by hand.
    nonconverged_points: tuple[DerivativePoint, ...] = ()
    """Where fits that did not converge stood when they stopped; not among `points`."""

    @property
    def between_maneuver_std(self) -> float:
        """Return the standard deviation from maneuver to maneuver beyond the bounds, per radian."""
        return (
            0.0 if self.bound_consistency is None else self.bound_consistency.between_maneuver_std
        )

    def bound(self, point: DerivativePoint) -> float:
        """Return the bound of a point with what differs between maneuvers in it, per radian."""
        return math.hypot(point.std, self.between_maneuver_std)

    @property
    def included_points(self) -> tuple[DerivativePoint, ...]:
        out = {one.point.maneuver for one in self.outliers}
        out.update(one.maneuver for one in self.excluded)
        return tuple(one for one in self.points if one.maneuver not in out)


@dataclass(frozen=True, slots=True, kw_only=True)
class OutlyingManeuver:
    """A maneuver whose values lie far off in several derivatives."""

    maneuver: str
    derivatives: tuple[str, ...]
    derivative_count: int  # Derivatives that it gave in all.
    fits_well: bool
    """Whether its fit is good all the same: then it is its data or its conditions that differ."""
    reasons: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CampaignSummary:
    """A campaign."""

    derivatives: Mapping[str, DerivativeSummary]  # In the order of the build-up.
    outlying_maneuvers: tuple[OutlyingManeuver, ...]  # The worst first.
    bounds_ratio: float | None
    """Scatter over bounds of all derivatives together: the median of their ratios. 1 if the bounds
    are honest; None where nothing was flown three times."""
    excluded_maneuvers: frozenset[str] = frozenset()  # Maneuvers left out by hand.


def summarize_campaign(result: CampaignResult, *, without: Collection[str] = ()) -> CampaignSummary:
    """Return means, honesty of bounds, outliers and trends of a campaign.

    `without`: maneuvers left out by hand: their points are kept in sight and count for nothing. A
    derivative that no other maneuver gave is left out with them.
    """
    points = collect_points(result)
    order = {name: place for place, name in enumerate(derivative_names())}
    names = sorted(points, key=lambda name: order.get(name, len(order)))
    by_id = {one.maneuver.id: one for one in result.results}
    out = frozenset(without)
    count = sum(one.maneuver not in out for found in points.values() for one in found)
    found = {
        name: _summarize(name, points[name], count, by_id, out)
        for name in names
        if any(one.maneuver not in out for one in points[name])
    }
    unfit = collect_points(result, converged=False)
    found = {
        name: replace(one, nonconverged_points=unfit.get(name, ())) for name, one in found.items()
    }
    found = _with_significant_trends(found)
    ratios = [
        one.bound_consistency.ratio for one in found.values() if one.bound_consistency is not None
    ]
    return CampaignSummary(
        derivatives=found,
        outlying_maneuvers=_outlying_maneuvers(found, by_id),
        bounds_ratio=float(np.median(ratios)) if ratios else None,
        excluded_maneuvers=out.intersection(by_id),
    )


def _with_significant_trends(
    found: Mapping[str, DerivativeSummary],
) -> dict[str, DerivativeSummary]:
    """Return the summaries with each trend judged beside all others."""
    stand = iter(
        holm_significant(
            np.array([trend.p_value for one in found.values() for trend in one.trends])
        ).tolist()
    )
    return {
        name: replace(
            one, trends=tuple(replace(trend, is_significant=next(stand)) for trend in one.trends)
        )
        for name, one in found.items()
    }


def _summarize(
    name: str,
    every: tuple[DerivativePoint, ...],
    count: int,
    results: Mapping[str, ManeuverResult],
    without: frozenset[str],
) -> DerivativeSummary:
    points = tuple(one for one in every if one.maneuver not in without)
    off = detect_outliers(points, count)
    kept = tuple(one for place, one in enumerate(points) if place not in off)
    values, stds = values_and_stds(kept)
    offsets = np.array([one.offset for one in kept])
    # What all have in common does not scatter, and an instrument's zero may be another tomorrow.
    told = None if offsets.any() else assess_bound_consistency(values, stds)
    between = 0.0 if told is None else told.between_maneuver_std
    return DerivativeSummary(
        name=name,
        points=every,
        outliers=tuple(
            Outlier(
                point=points[place],
                sigmas=sigmas,
                reasons=outlier_reasons(points[place], kept, results.get(points[place].maneuver)),
            )
            for place, sigmas in off.items()
        ),
        value=weighted_mean(values, np.hypot(stds, between), offsets),
        bound_consistency=told,
        trends=fit_condition_trends(kept),
        excluded=tuple(one for one in every if one.maneuver in without),
    )


def _outlying_maneuvers(
    derivatives: Mapping[str, DerivativeSummary], results: Mapping[str, ManeuverResult]
) -> tuple[OutlyingManeuver, ...]:
    off: dict[str, dict[str, Outlier]] = {}
    given: dict[str, int] = {}
    for name, one in derivatives.items():
        for point in one.points:
            given[point.maneuver] = given.get(point.maneuver, 0) + 1
        for outlier in one.outliers:
            off.setdefault(outlier.point.maneuver, {})[name] = outlier
    found = []
    for maneuver, outliers in off.items():
        of = given[maneuver]
        if len(outliers) < SUMMARY.min_outliers or len(outliers) < SUMMARY.min_outlier_share * of:
            continue
        estimate = results[maneuver].estimate
        fits = () if estimate is None else tuple(estimate.fit.values())
        found.append(
            OutlyingManeuver(
                maneuver=maneuver,
                derivatives=tuple(outliers),
                derivative_count=of,
                fits_well=bool(fits) and min(fit.r2 for fit in fits) > SUMMARY.good_fit,
                reasons=tuple(
                    dict.fromkeys(text for one in outliers.values() for text in one.reasons)
                ),
            )
        )
    return tuple(sorted(found, key=lambda one: -len(one.derivatives) / one.derivative_count))

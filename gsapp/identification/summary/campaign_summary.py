"""A campaign, derivative by derivative: points, means, scatter over bounds, outliers, trends."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy.optimize import brentq
from scipy.stats import chi2, norm
from scipy.stats import t as student

from gsapp.dynamics.buildup import derivative_names
from gsapp.identification.campaign import (
    CampaignResult,
    CampaignValue,
    ManeuverResult,
    weighted_mean,
)
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.statistics import CORRELATION_WARNING_PREFIX
from gsapp.identification.summary.method_comparison import MethodComparison, compare_method_means
from gsapp.identification.summary.settings import SUMMARY
from gsapp.quantities import BoolArray, FloatArray, name_in_text
from gsapp.quantities.constants import DEGREE, MAD_TO_STD


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
        between_maneuver_std=paule_mandel_std(values, stds),
    )


def _weighted_squares(values: FloatArray, stds: FloatArray, between: float) -> float:
    """Return the sum of squared deviations from the weighted mean, in units of their variance."""
    weights = 1.0 / (stds**2 + between**2)
    mean = weights @ values / weights.sum()
    return float(weights @ (values - mean) ** 2)


def paule_mandel_std(values: FloatArray, stds: FloatArray) -> float:
    """Return the standard deviation between values beyond their bounds, shapes (n,), n > 1.

    Paule and Mandel's estimate; 0 where the bounds explain all.
    """
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
    random_std: float
    """The part that scatters. All of `std` for a constant: the zero of an instrument, which its
    offset comes from, may be another tomorrow."""
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
                random_std=std if name.endswith("_0") else math.sqrt(max(std**2 - offset**2, 0.0)),
                conditions=conditions,
            )
            found.setdefault(name, []).append(point)
    return {name: tuple(points) for name, points in found.items()}


def _estimated_values(one: ManeuverResult) -> dict[str, tuple[float, float, float]]:
    estimate = one.estimate
    if estimate is None:
        return {}
    return {
        name: (value, std, estimate.derivatives[name].offset)
        for name, (value, std) in estimate.estimated.items()
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
    """Return values and what they may scatter, each of shape (n,)."""
    return np.array([one.value for one in points]), np.array([one.random_std for one in points])


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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DerivativeSummary:
    """One derivative over a campaign."""

    name: str
    points: tuple[DerivativePoint, ...]  # All of them, in order of maneuvers.
    outliers: tuple[Outlier, ...]  # Those left out of `value`.
    value: CampaignValue
    """Mean of the points that stand, each weighted by its own bound and what they scatter beyond
    bounds from maneuver to maneuver (`BoundConsistency.between`) together. Its bound covers that
    scatter, and methods that contradict one another."""
    bound_consistency: BoundConsistency | None
    """Their scatter against their bounds; None for fewer than three, and for constants whose bounds
    hold the zero of an instrument."""
    trends: tuple[ConditionTrend, ...]
    comparison: MethodComparison | None = None  # The mean by each method.
    excluded: tuple[DerivativePoint, ...] = ()  # Those left out by hand.
    nonconverged_points: tuple[DerivativePoint, ...] = ()
    """Where fits that did not converge stood when they stopped; not among `points`."""

    @property
    def between_maneuver_std(self) -> float:
        """Return the standard deviation from maneuver to maneuver beyond the bounds, per radian."""
        return (
            0.0 if self.bound_consistency is None else self.bound_consistency.between_maneuver_std
        )

    @property
    def point_disagreement(self) -> float:
        """Return what maneuvers and methods disagree beyond their bounds, per radian.

        Of a single value; that of the mean is in `value`.
        """
        of_methods = 0.0 if self.comparison is None else self.comparison.disagreement
        return math.hypot(self.between_maneuver_std, of_methods)

    def bound(self, point: DerivativePoint) -> float:
        """Return the bound of a point with `point_disagreement` in it, per radian."""
        return math.hypot(point.std, self.point_disagreement)

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
    order = {name: index for index, name in enumerate(derivative_names())}
    names = sorted(points, key=lambda name: order.get(name, len(order)))
    by_id = {one.maneuver.id: one for one in result.results}
    out = frozenset(without)
    count = sum(one.maneuver not in out for found in points.values() for one in found)
    included = [one for one in result.results if one.maneuver.id not in out]
    methods = {one.name: one for one in compare_method_means(included)}
    found = {
        name: _summarize(name, points[name], count, by_id, out, methods.get(name))
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
    methods: MethodComparison | None,
) -> DerivativeSummary:
    points = tuple(one for one in every if one.maneuver not in without)
    off = detect_outliers(points, count)
    kept = tuple(one for place, one in enumerate(points) if place not in off)
    values, random_stds = values_and_stds(kept)
    stds, offsets = np.array([(one.std, one.offset) for one in kept]).T
    told = None
    if not (name.endswith("_0") and offsets.any()):
        told = assess_bound_consistency(values, random_stds)
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
        value=_with_disagreement(
            weighted_mean(values, stds, offsets, between),
            weighted_mean(values, stds, offsets).std,
            0.0 if methods is None else methods.disagreement,
        ),
        bound_consistency=told,
        trends=fit_condition_trends(kept),
        comparison=methods,
        excluded=tuple(one for one in every if one.maneuver in without),
    )


def _with_disagreement(value: CampaignValue, noise: float, of_methods: float) -> CampaignValue:
    """Return a mean whose bound covers, beside noise, maneuvers and methods that disagree."""
    of_maneuvers = math.sqrt(max(value.std**2 - noise**2, 0.0))
    return replace(
        value,
        std=math.hypot(value.std, of_methods),
        disagreement=math.hypot(of_maneuvers, of_methods),
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

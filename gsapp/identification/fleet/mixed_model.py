"""Linear mixed model: a value against conditions, with random effects between airframes.

    y = X beta + Z u + f + e

X holds a one and the conditions, Z the one and the first condition, u ~ N(0, G) an airframe's own
intercept and slope, f ~ N(0, tau^2) what all values of a flight have in common, and
e ~ N(0, s^2 + sigma^2) the bound s of the value and what maneuvers scatter beyond it. The variances
G, tau^2 and sigma^2 are estimated by restricted maximum likelihood (REML; Pinheiro and Bates,
Mixed-Effects Models in S and S-PLUS, 2000, chapter 2).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.stats import t as student_t

from gsapp.foundation import FlightError
from gsapp.identification.fleet.settings import FLEET
from gsapp.quantities import FloatArray

IntArray = NDArray[np.int64]
_LEAST_STD: Final = FLEET.least_std_share


@dataclass(frozen=True, slots=True, kw_only=True)
class EffectEstimate:
    """A number with its standard error and confidence interval."""

    value: float
    std: float
    low: float
    high: float
    freedom: float  # Degrees of freedom of the interval.
    p_value: float  # Chance of at least so large a value, were it zero.


@dataclass(frozen=True, slots=True, kw_only=True)
class GroupLine:
    """An airframe's own line, drawn toward that of the fleet as far as it is uncertain."""

    intercept: float  # At the reference.
    intercept_std: float
    slope: float | None  # Of the first condition; None without one.
    slope_std: float | None
    n: int


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MixedModelFit:
    """A fitted model."""

    reference: Mapping[str, float]  # Mean of each condition, where the intercept holds.
    intercept: EffectEstimate
    slopes: Mapping[str, EffectEstimate]  # By condition, per unit of it.
    groups: Mapping[str, GroupLine]
    intercept_std: float  # Between groups.
    slope_std: float | None  # Between groups; None where all have the same slope.
    correlation: float | None  # Of a group's intercept and slope.
    flight_std: float | None  # Between flights; None where none has two values.
    residual_std: float  # Of maneuvers, beyond their bounds.
    log_likelihood: float  # Restricted.
    converged: bool
    n: int
    flights: int


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Problem:
    """Values sorted by group and flight; the last column of `products` is that of y with y."""

    products: FloatArray  # Shape (n, q, q) of the rows of (X, y).
    variances: FloatArray  # Squared bounds, shape (n,).
    flight_starts: IntArray
    group_starts: IntArray  # Among the flights.
    has_slope: bool
    has_flights: bool
    has_groups: bool
    between: tuple[bool, ...]  # Of each condition: the same in all values of a group.

    def covariance_factor(self, theta: FloatArray) -> FloatArray:
        """Return L of G = L L', shape (r, r); r is 1 without random slopes."""
        if not self.has_groups:
            return np.zeros((1, 1))
        if not self.has_slope:
            return np.array([[theta[0]]])
        return np.array([[theta[0], 0.0], [theta[1], theta[2]]])

    def group_products(self, theta: FloatArray) -> tuple[FloatArray, float]:
        """Return (X, y)' V0^-1 (X, y) of each group, shape (m, q, q), and log |V0|.

        V0 is the covariance without the effects between groups.
        """
        tau, sigma = theta[-2], theta[-1]
        weights = 1.0 / (self.variances + sigma**2)
        by_flight = np.add.reduceat(weights[:, None, None] * self.products, self.flight_starts)
        logarithm = -float(np.log(weights).sum())
        if tau > 0.0:
            sums = by_flight[:, 0, :]  # the first column of X is one
            share = tau**2 / (1.0 + tau**2 * by_flight[:, 0, 0])
            logarithm += float(np.log1p(tau**2 * by_flight[:, 0, 0]).sum())
            by_flight = by_flight - share[:, None, None] * sums[:, :, None] * sums[:, None, :]
        return np.add.reduceat(by_flight, self.group_starts), logarithm

    def criterion(self, theta: FloatArray) -> float:
        """Return minus twice the restricted log-likelihood, without its constant."""
        per_group, logarithm = self.group_products(theta)
        factor = self.covariance_factor(theta)
        r = len(factor)
        inner = np.eye(r) + factor.T @ per_group[:, :r, :r] @ factor
        right = factor.T @ per_group[:, :r, :]
        logarithm += float(np.linalg.slogdet(inner)[1].sum())
        whole = (per_group - right.transpose(0, 2, 1) @ np.linalg.solve(inner, right)).sum(axis=0)
        A, b, c = whole[:-1, :-1], whole[:-1, -1], whole[-1, -1]
        sign, of_fixed = np.linalg.slogdet(A)
        if sign <= 0.0:
            return math.inf
        return logarithm + float(of_fixed) + float(c - b @ np.linalg.solve(A, b))


def fit_mixed_model(
    values: FloatArray,
    stds: FloatArray,
    conditions: Mapping[str, FloatArray],
    groups: Sequence[str],
    flights: Sequence[str],
) -> MixedModelFit:
    """Fit the model.

    Parameters
    ----------
    values, stds : ndarray, shape (n,)
        With their bounds, which may be zero.
    conditions : mapping of str to ndarray, shape (n,)
        The first one has slopes that differ between groups, where the groups allow it.
    groups, flights : sequence of str, length n

    Raises
    ------
    FlightError
        If there are fewer than two values more than conditions, or a condition is constant.
    """
    order = sorted(range(len(values)), key=lambda place: (groups[place], flights[place]))
    y, s = values[order], stds[order]
    group = np.array([groups[place] for place in order], dtype=object)
    flight = np.array([f"{groups[place]}\0{flights[place]}" for place in order], dtype=object)
    x = {name: column[order] for name, column in conditions.items()}
    _check(y, x)
    scale = float(np.std(y)) or float(np.max(np.abs(y))) or 1.0
    center = float(np.mean(y))
    spans = {name: float(np.std(column)) for name, column in x.items()}
    means = {name: float(np.mean(column)) for name, column in x.items()}
    rows = np.column_stack(
        [
            np.ones(len(y)),
            *((column - means[name]) / spans[name] for name, column in x.items()),
            (y - center) / scale,
        ]
    )
    flight_starts = _starts(flight)
    group_names = list(dict.fromkeys(group))
    problem = _Problem(
        products=rows[:, :, None] * rows[:, None, :],
        variances=(s / scale) ** 2,
        flight_starts=flight_starts,
        group_starts=_starts(group[flight_starts]),
        has_groups=len(group_names) > 1,
        has_slope=bool(x) and _slopes_differ(next(iter(x.values())), group),
        between=tuple(_is_constant_within(column, group) for column in x.values()),
        has_flights=len(flight_starts) < len(y) and len(flight_starts) > len(group_names),
    )
    theta, converged = _minimize(problem)
    return _result(
        problem, theta, converged,
        names=group_names, counts=[int(np.sum(group == name)) for name in group_names],
        means=means, spans=spans, center=center, scale=scale,
    )  # fmt: skip


def _check(y: FloatArray, x: Mapping[str, FloatArray]) -> None:
    if len(y) < len(x) + 3:
        raise FlightError(
            f"{len(y)} values are too few for a trend against {len(x)} conditions; at least "
            f"{len(x) + 3} are needed"
        )
    for name, column in x.items():
        if np.ptp(column) <= 1e-9 * float(np.max(np.abs(column))):
            raise FlightError(f"{name} is the same in all values; a trend needs different ones")
    whole = np.column_stack([np.ones(len(y)), *x.values()])
    whole = whole / np.linalg.norm(whole, axis=0)
    if np.linalg.cond(whole - np.pad(whole[:, 1:].mean(axis=0), (1, 0))) > 1e6:
        raise FlightError(
            f"{', '.join(x)} change together in all values; choose one of these conditions"
        )


def _starts(labels: NDArray[np.object_]) -> IntArray:
    return np.flatnonzero(np.r_[True, labels[1:] != labels[:-1]])


def _is_constant_within(x: FloatArray, group: NDArray[np.object_]) -> bool:
    tolerance = 1e-9 * float(np.max(np.abs(x)))
    return all(np.ptp(x[group == name]) <= tolerance for name in dict.fromkeys(group))


def _slopes_differ(x: FloatArray, group: NDArray[np.object_]) -> bool:
    """Return whether enough groups show a slope of their own."""
    tolerance = 1e-9 * float(np.max(np.abs(x)))
    able = sum(
        np.sum(np.diff(np.sort(x[group == name])) > tolerance) + 1 >= FLEET.min_slope_points
        for name in dict.fromkeys(group)
    )
    return bool(able >= FLEET.min_slope_groups)


def _minimize(problem: _Problem) -> tuple[FloatArray, bool]:
    """Return the standard deviations that minimize the criterion, and whether a minimum was met."""
    count = 3 if problem.has_slope else 1
    most = FLEET.most_std_share
    bounds = [(0.0, most if problem.has_groups else 0.0)] * count
    if problem.has_slope:
        bounds[1] = (-most, most)
    # Values without bounds that scatter by nothing would have infinite weights.
    least = 0.0 if problem.variances.min() > _LEAST_STD**2 else _LEAST_STD
    bounds += [(0.0, most if problem.has_flights else 0.0), (least, most)]
    found: list[Any] = []
    # A standard deviation of zero is stationary: the search begins away from it, at several, until
    # two give the same.
    for between, within in ((0.5, 0.5), (0.1, 0.5), (0.5, 0.1), (0.1, 0.1)):
        start = np.array([*[between, 0.0, between][:count], between, within])
        start = np.where([high == 0.0 for _, high in bounds], 0.0, start)
        found.append(
            minimize(
                problem.criterion, start, method="L-BFGS-B", bounds=bounds,
                options={"ftol": 1e-12, "gtol": 1e-6, "maxiter": 500},
            )
        )  # fmt: skip
        first, second = sorted([*(one.fun for one in found), math.inf])[:2]
        if second - first < FLEET.likelihood_tolerance:
            break
    best = min(found, key=lambda one: float(one.fun))
    return np.asarray(best.x), bool(second - first < FLEET.likelihood_tolerance)


def _result(
    problem: _Problem,
    theta: FloatArray,
    converged: bool,
    *,
    names: Sequence[str],
    counts: Sequence[int],
    means: Mapping[str, float],
    spans: Mapping[str, float],
    center: float,
    scale: float,
) -> MixedModelFit:
    """Return the fit in the units of the values.

    By Henderson's equations, with u = L v, v ~ N(0, I): G may be singular.
    """
    per_group, _ = problem.group_products(theta)
    factor = problem.covariance_factor(theta)
    r, m, fixed = len(factor), len(names), per_group.shape[1] - 1
    size = fixed + r * m
    matrix, right = np.zeros((size, size)), np.zeros(size)
    matrix[:fixed, :fixed] = per_group[:, :-1, :-1].sum(axis=0)
    right[:fixed] = per_group[:, :-1, -1].sum(axis=0)
    for place, own in enumerate(per_group):
        part = slice(fixed + r * place, fixed + r * (place + 1))
        matrix[part, part] = np.eye(r) + factor.T @ own[:r, :r] @ factor
        matrix[part, :fixed] = factor.T @ own[:r, :-1]
        matrix[:fixed, part] = matrix[part, :fixed].T
        right[part] = factor.T @ own[:r, -1]
    covariance = np.linalg.inv(matrix)
    solution = covariance @ right
    units = scale / np.array([1.0, *spans.values()])
    flights = len(problem.flight_starts)
    freedom = _freedom(problem, m, flights, fixed, sum(counts))
    effects = [
        _effect(
            solution[place] * units[place] + (center if place == 0 else 0.0),
            math.sqrt(covariance[place, place]) * units[place],
            freedom[place],
        )
        for place in range(fixed)
    ]
    groups = {}
    for place, name in enumerate(names):
        pick = np.zeros((min(fixed, 2), size))
        pick[:, : min(fixed, 2)] = np.eye(min(fixed, 2))
        pick[:r, fixed + r * place : fixed + r * (place + 1)] = factor
        line = pick @ solution * units[: len(pick)]
        line_std = np.sqrt(np.diag(pick @ covariance @ pick.T)) * units[: len(pick)]
        groups[name] = GroupLine(
            intercept=float(line[0]) + center,
            intercept_std=float(line_std[0]),
            slope=float(line[1]) if len(line) > 1 else None,
            slope_std=float(line_std[1]) if len(line) > 1 else None,
            n=counts[place],
        )
    spread = factor @ factor.T
    own_slope = r == 2
    joint = math.sqrt(spread[0, 0] * spread[1, 1]) if own_slope else 0.0
    return MixedModelFit(
        reference=means,
        intercept=effects[0],
        slopes=dict(zip(spans, effects[1:], strict=True)),
        groups=groups,
        intercept_std=scale * math.sqrt(spread[0, 0]),
        slope_std=float(units[1]) * math.sqrt(spread[1, 1]) if own_slope else None,
        correlation=spread[0, 1] / joint if joint > 0.0 else None,
        flight_std=scale * float(theta[-2]) if problem.has_flights else None,
        residual_std=scale * float(theta[-1]),
        log_likelihood=-0.5
        * (problem.criterion(theta) + (sum(counts) - fixed) * math.log(2 * math.pi))
        - (sum(counts) - fixed) * math.log(scale)
        + float(np.log(units[1:] / scale).sum()),
        converged=converged,
        n=sum(counts),
        flights=flights,
    )


def _freedom(problem: _Problem, groups: int, flights: int, fixed: int, n: int) -> list[float]:
    """Return the degrees of freedom of the intercept and of each slope.

    By containment: as many as there are units in which an effect varies, less those that are spent.
    """
    within = float(max((flights if problem.has_flights else n) - groups - fixed + 1, 1))
    if not problem.has_groups:
        return [within] * fixed
    between = float(max(groups - 1 - sum(problem.between), 1))
    slopes = [between if constant else within for constant in problem.between]
    if problem.has_slope:
        slopes[0] = between
    return [between, *slopes]


def _effect(value: float, std: float, freedom: float) -> EffectEstimate:
    half = float(student_t.ppf(0.5 + 0.5 * FLEET.confidence, freedom)) * std
    return EffectEstimate(
        value=float(value),
        std=float(std),
        low=float(value - half),
        high=float(value + half),
        freedom=freedom,
        p_value=float(2.0 * student_t.sf(abs(value) / std, freedom)) if std > 0.0 else 0.0,
    )

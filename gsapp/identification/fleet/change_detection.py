"""Changes over time: a step or the onset of a drift in the values of flights, found and dated.

Whether there is a change is decided by permutation: of all steps and all onsets, the largest share
of the weighted scatter that one explains is compared with what it explains when the flights are
shuffled (Antoch and Huskova, Statistics & Probability Letters 53, 2001). It holds for any
distribution of values that do not depend on their order. When it was follows from the posterior
probability of all steps and onsets, each moment being as likely as another beforehand; level,
size and scatter are integrated out with flat priors.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from gsapp.identification.fleet.settings import FLEET
from gsapp.identification.summary.campaign_summary import paule_mandel_std
from gsapp.quantities import FloatArray

ChangeKind = Literal["step", "drift", "step-or-drift", "none", "unknown"]
_BATCH = 50
"""Permutations that are evaluated together."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Change:
    """What became of a value over time."""

    kind: ChangeKind  # ``unknown``: too few flights.
    p_value: float | None = None
    """Chance of at least so clear a change, were the flights in any order."""
    n: int = 0  # Flights.
    time: float | None = None  # Of a step, or the onset of a drift; the most likely one.
    earliest: float | None = None
    latest: float | None = None
    """Between these it lies with `FLEET.date_probability`."""
    step_probability: float | None = None  # That it is a step, rather than a drift.
    size: float | None = None
    """Of a step; of a drift per unit of time. None where it is open which of them. Means over all
    moments that are possible, as are the next three."""
    size_std: float | None = None
    before: float | None = None  # Mean of the flights before.
    now: float | None = None  # At the last flight.
    now_std: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Explained:
    """Of each step and each onset, what it explains; last axis: by the flight that it follows."""

    step: FloatArray
    drift: FloatArray
    total: FloatArray  # Weighted squares about the mean.

    @property
    def best_share(self) -> FloatArray:
        """Return the largest share of the total that any of them explains."""
        best = np.maximum(self.step.max(axis=-1), self.drift.max(axis=-1))
        return np.asarray(best / self.total)


def detect_change(
    times: FloatArray, values: FloatArray, stds: FloatArray, *, series: int = 1, seed: int = 0
) -> Change:
    """Find a change in values of flights, and when it was.

    Parameters
    ----------
    times : ndarray, shape (n,)
        Of the flights, in any unit, in order.
    values, stds : ndarray, shape (n,)
        With their bounds.
    series : int
        How many series are searched together: the chance of any false change among all of them is
        `FLEET.change_significance`.
    seed : int
        Of the permutations.
    """
    n = len(times)
    if n < FLEET.min_flights or times[-1] <= times[0]:
        return Change(kind="unknown", n=n)
    weights = 1.0 / (stds**2 + paule_mandel_std(values, stds) ** 2)
    clock = (times - times[0]) / (times[-1] - times[0])
    y = values - float(weights @ values / weights.sum())
    found = _explained(clock, y, weights)
    level = FLEET.change_significance / series
    p_value = _p_value(clock, y, weights, float(found.best_share), level, seed)
    if p_value > level:
        return Change(kind="none", p_value=p_value, n=n)
    return replace(_dated(times, y, weights, found, values - y), p_value=p_value)


def _p_value(
    clock: FloatArray, y: FloatArray, weights: FloatArray, share: float, level: float, seed: int
) -> float:
    """Return the chance of at least this share in shuffled flights.

    Permutations end once enough of them reach the share (Besag and Clifford, Biometrika 78, 1991).
    """
    random = np.random.default_rng(seed)
    count = int(min(max(FLEET.permutations, math.ceil(20.0 / level)), FLEET.max_permutations))
    identity = np.arange(len(y))
    larger = 0
    for start in range(0, count, _BATCH):
        order = random.permuted(np.tile(identity, (min(_BATCH, count - start), 1)), axis=1)
        reached = _explained(clock, y[order], weights[order]).best_share >= share * (1.0 - 1e-12)
        if larger + reached.sum() >= FLEET.enough_permutations:
            last = np.flatnonzero(reached)[FLEET.enough_permutations - larger - 1]
            return float(FLEET.enough_permutations / (start + last + 1))
        larger += int(reached.sum())
    return (1 + larger) / (1 + count)


def _explained(clock: FloatArray, y: FloatArray, weights: FloatArray) -> _Explained:
    """Return what steps and drifts explain; y, weights of shape (..., n), clock of shape (n,).

    A step is after each flight but the last ones, an onset at each.
    """

    def later(samples: FloatArray) -> FloatArray:
        """Return sums over the flights after each one."""
        sums = np.cumsum(samples[..., ::-1], axis=-1)[..., ::-1]
        return sums - samples

    total_weight = weights.sum(axis=-1, keepdims=True)
    wy = weights * y
    sum_y = wy.sum(axis=-1, keepdims=True)
    w0, wy0 = later(weights), later(wy)
    w1, w2, wy1 = later(weights * clock), later(weights * clock**2), later(wy * clock)
    total = (wy * y).sum(axis=-1) - (sum_y**2 / total_weight)[..., 0]

    def gain(c: FloatArray, cc: FloatArray, cy: FloatArray) -> FloatArray:
        spread = cc - c**2 / total_weight
        return np.where(
            spread > 1e-9 * cc,
            (cy - c * sum_y / total_weight) ** 2 / np.maximum(spread, 1e-300),
            0.0,
        )

    step = gain(w0, w0, wy0)
    drift = gain(w1 - clock * w0, w2 - 2.0 * clock * w1 + clock**2 * w0, wy1 - clock * wy0)
    side = FLEET.min_side_flights
    n = y.shape[-1]
    step[..., : side - 1] = step[..., n - side :] = 0.0
    drift[..., n - side :] = 0.0
    return _Explained(step=step, drift=drift, total=total)


def _dated(
    times: FloatArray, y: FloatArray, weights: FloatArray, found: _Explained, mean: FloatArray
) -> Change:
    n = len(times)
    gaps = np.diff(times, append=times[-1])
    around = 0.5 * (gaps + np.concatenate(([0.0], gaps[:-1])))
    with np.errstate(divide="ignore"):
        logs = np.stack(
            [
                np.where(gain > 0.0, np.log(prior), -np.inf)
                - 0.5 * (n - 2) * np.log(np.maximum(found.total - gain, 1e-12 * found.total))
                for gain, prior in ((found.step, gaps), (found.drift, around))
            ]
        )
    posterior = np.exp(logs - logs.max())
    posterior /= posterior.sum()
    is_step = float(posterior[0].sum())
    if max(is_step, 1.0 - is_step) < FLEET.kind_probability:
        kind: ChangeKind = "step-or-drift"
    else:
        kind = "step" if is_step >= FLEET.kind_probability else "drift"
        posterior[1 if kind == "step" else 0] = 0.0
        posterior /= posterior.sum()
    chosen, place = np.unravel_index(int(posterior.argmax()), posterior.shape)
    starts, ends = _credible(posterior)
    sizes = _sizes(times, y, weights, posterior)
    return Change(
        kind=kind,
        n=n,
        time=float(0.5 * (times[place] + times[place + 1]) if chosen == 0 else times[place]),
        earliest=float(times[starts]),
        latest=float(times[min(ends, n - 1)]),
        step_probability=is_step,
        size=None if kind == "step-or-drift" else sizes["size"][0],
        size_std=None if kind == "step-or-drift" else sizes["size"][1],
        before=sizes["before"][0] + float(mean[0]),
        now=sizes["now"][0] + float(mean[0]),
        now_std=sizes["now"][1],
    )


def _sizes(
    times: FloatArray, y: FloatArray, weights: FloatArray, posterior: FloatArray
) -> dict[str, tuple[float, float]]:
    """Return size, value before and now with standard deviations, over all moments that count."""
    n = len(times)
    found, shares = [], []
    for kind, place in np.argwhere(posterior > FLEET.least_probability * posterior.max()):
        after = np.arange(n) > place
        column = after.astype(float) if kind == 0 else np.maximum(times - times[place], 0.0)
        design = np.column_stack([np.ones(n), column])
        normal = np.linalg.inv(design.T @ (weights[:, None] * design))
        solution = normal @ design.T @ (weights * y)
        normal *= float(weights @ (y - design @ solution) ** 2) / (n - 3)
        # Size, value before, value at the last flight.
        pick = np.array([[0.0, 1.0], [1.0, 0.0], design[-1]])
        found.append((pick @ solution, np.diag(pick @ normal @ pick.T)))
        shares.append(posterior[kind, place])
    share = np.array(shares) / np.sum(shares)
    values, variances = (np.array(part) for part in zip(*found, strict=True))
    means = share @ values
    stds = np.sqrt(share @ (variances + (values - means) ** 2))
    names = ("size", "before", "now")
    return {
        name: (float(one), float(std)) for name, one, std in zip(names, means, stds, strict=True)
    }


def _credible(posterior: FloatArray) -> tuple[int, int]:
    """Return the flights between which the change lies: the most probable moments together."""
    flat = posterior.ravel()
    order = np.argsort(-flat)
    count = int(np.searchsorted(np.cumsum(flat[order]), FLEET.date_probability)) + 1
    kinds, places = np.unravel_index(order[:count], posterior.shape)
    # A step lies between a flight and the next; an onset at a flight stands for the time around it.
    first = np.where(kinds == 0, places, np.maximum(places - 1, 0))
    return int(first.min()), int(places.max()) + 1

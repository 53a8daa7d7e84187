"""What the crew sees of the derivatives while they form. Nothing is drawn here."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from gsapp.dynamics.model import Model
from gsapp.identification.campaign import CampaignResult, CampaignValue
from gsapp.identification.ftr.estimates import EstimateHistory, LiveEstimate
from gsapp.quantities import FloatArray
from gsapp.session.monitor_settings import MONITORS


@dataclass(frozen=True, slots=True, kw_only=True)
class FittedPoint:
    """What one maneuver gave by maximum likelihood, in gusts by filter error."""

    maneuver: str
    time: float
    value: float
    std: float
    """Per radian."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class EstimateRow:
    """One derivative as it stands."""

    name: str
    value: float | None
    std: float | None
    """By FTR, per radian; None while unknown."""
    progress: float
    """0 to 1: how much of the excitation that is asked for there has been."""
    why: str
    """Why it is unknown, in words; empty once it is earned."""
    times: FloatArray
    values: FloatArray
    """Shape (n,). FTR's history: s, per radian; NaN while unknown."""
    points: tuple[FittedPoint, ...] = ()
    mean: CampaignValue | None = None
    methods: tuple[str, ...] = ()
    """Ids of the methods of the fits: in gusts filter error takes the place of ML."""
    prior: float | None = None
    """Before the flight; None without a model."""
    change_text: str = ""
    """What the last maneuver changed, in words: "9 % to 6 %", "new"; empty for nothing."""

    @property
    def percent(self) -> float | None:
        """Return the bound in percent of the value, of the best there is; None while unknown."""
        best = self.best
        if best is None or best[0] == 0.0:
            return None
        return 100.0 * best[1] / abs(best[0])

    @property
    def best(self) -> tuple[float, float] | None:
        """Return value and bound to go by: of the fits if there are any, else FTR's."""
        if self.mean is not None:
            return self.mean.mean, self.mean.std
        return None if self.value is None or self.std is None else (self.value, self.std)


def build_estimate_rows(
    live: Mapping[str, LiveEstimate],
    histories: Mapping[str, EstimateHistory],
    fits: CampaignResult,
    model: Model | None,
    *,
    since: float | None = None,
) -> tuple[EstimateRow, ...]:
    """Return the derivatives in the order of the build-up; biases (``_0``) are left out.

    Parameters
    ----------
    since : float, optional
        Flight time before the last maneuver, s: what it changed is said.
    """
    rows = []
    points, methods = _fitted_points(fits)
    for name, one in live.items():
        if name.endswith("_0"):
            continue
        history = histories.get(name)
        empty = np.empty(0)
        rows.append(
            EstimateRow(
                name=name,
                value=one.value,
                std=one.std,
                progress=one.progress,
                why="" if one.value is not None else one.why,
                times=empty if history is None else history.times,
                values=empty if history is None else history.values,
                points=points.get(name, ()),
                mean=fits.values.get(name),
                methods=methods.get(name, ()),
                prior=None if model is None else model.derivatives.get(name),
                change_text=""
                if history is None or since is None
                else bound_change_text(history, since),
            )
        )
    return tuple(rows)


@lru_cache(maxsize=1)
def _fitted_points(
    fits: CampaignResult,
) -> tuple[Mapping[str, tuple[FittedPoint, ...]], Mapping[str, tuple[str, ...]]]:
    """Return what each maneuver gave, and by which methods, by derivative."""
    points: dict[str, list[FittedPoint]] = {}
    methods: dict[str, dict[str, None]] = {}
    for one in fits.results:
        if one.estimate is None:
            continue
        for name, (value, std) in one.estimate.estimated.items():
            methods.setdefault(name, {})[one.estimate.method] = None
            points.setdefault(name, []).append(
                FittedPoint(maneuver=one.maneuver.id, time=one.maneuver.t_end, value=value, std=std)
            )
    return (
        {name: tuple(own) for name, own in points.items()},
        {name: tuple(own) for name, own in methods.items()},
    )


def bound_change_text(history: EstimateHistory, since: float) -> str:
    """Return what happened to a bound since a time (s), in words; empty for nothing."""
    earned = np.isfinite(history.values)
    if not earned.any() or not earned[-1]:
        return ""
    before = int(np.searchsorted(history.times, since, side="right")) - 1
    if before < 0 or not earned[before]:
        return "new"
    old, new = (
        100.0 * abs(float(history.stds[place] / history.values[place])) for place in (before, -1)
    )
    if abs(old - new) < MONITORS.min_reported_change * old:
        return ""
    return f"{old:.0f} % to {new:.0f} %" if old >= 9.5 else f"{old:.1f} % to {new:.1f} %"

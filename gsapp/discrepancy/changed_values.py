"""Derivatives of a given model that the flights contradict."""

from __future__ import annotations

import numpy as np
from scipy.stats import chi2, norm

from gsapp.discrepancy.results import ChangedValue
from gsapp.dynamics.buildup import derivative_names
from gsapp.dynamics.model import Model
from gsapp.identification.filter_error.filter_error_fit import FilterErrorFit

_FALSE_ALARM = 0.003
_MIN_RELATIVE_CHANGE = 0.01
"""Differences below this share of a value are within what any model is good for."""


def find_changed_values(model: Model | None, fit: FilterErrorFit) -> dict[str, ChangedValue]:
    """Return the derivatives that moved beyond their bounds, all together significantly.

    Empty where no model was given: a fitted one cannot be wrong in its values.
    """
    if model is None:
        return {}
    names = [name for name in fit.free if name in derivative_names()]
    if not names:
        return {}
    information = fit.information().with_priors(fit.priors())
    every = (*fit.free, *fit.bias_names())
    _, covariance = information.solution(every)
    places = [every.index(name) for name in names]
    own = covariance[np.ix_(places, places)]
    after = np.array([fit.values[name] for name in names])
    before = np.array([model.derivative(name) for name in names])
    own = own + np.diag((_MIN_RELATIVE_CHANGE * before) ** 2)
    moved = after - before
    together = float(moved @ np.linalg.solve(own, moved))
    if chi2.sf(together, len(names)) > _FALSE_ALARM:
        return {}
    std = np.sqrt(own.diagonal())
    least = float(norm.isf(0.5 * _FALSE_ALARM / len(names)))
    return {
        name: ChangedValue(before=float(old), after=float(new), std=float(bound))
        for name, old, new, bound in zip(names, before, after, std, strict=True)
        if abs(new - old) > least * bound
    }

"""Measured coefficients of a maneuver beside what derivatives make of them.

Equation error and FTR integrate nothing: what they follow are force and moment coefficients, not
responses. Both sides pass the same filter.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from gsapp.dynamics.buildup import linear_variables
from gsapp.dynamics.terms import COEFFICIENTS
from gsapp.identification.coefficients import Coefficients
from gsapp.identification.results import ResponseHistory
from gsapp.quantities import BoolArray, FloatArray


def coefficient_history(
    found: Coefficients, values: Mapping[str, float], free_courses: Mapping[str, int]
) -> ResponseHistory | None:
    """Return coefficients as measured, and as derivatives compute them from measured motion.

    Parameters
    ----------
    found : Coefficients
        Of one maneuver.
    values : mapping of str to float
        Derivatives, per radian.
    free_courses : mapping of str to int
        Coefficients to show; each with the degree of the polynomial in time that is taken from its
        measurement because the method leaves it open: -1 none, 0 a constant, 2 a slow drift.

    Returns
    -------
    ResponseHistory or None
        `channels` are coefficients; no numbers in `measured` where a sample did not count. None
        where no sample of any of them counts.
    """
    shown: list[str] = []
    measured: list[FloatArray] = []
    computed: list[FloatArray] = []
    for name in COEFFICIENTS:
        if name not in free_courses:
            continue
        reads = {
            suffix: variable
            for suffix, variable in linear_variables(name).items()
            if values.get(f"{name}_{suffix}")
        }
        counts = found.valid_samples(name)
        for variable in reads.values():
            counts = counts & found.variable_valid[variable]
        if not counts.any():
            continue
        total = np.full(found.times.size, values.get(f"{name}_0", 0.0))
        if reads:
            slopes = np.array([values[f"{name}_{suffix}"] for suffix in reads])
            total = total + found.smoothed_variables(tuple(reads.values())) @ slopes
        given = np.where(counts, found.value(name), np.nan)
        shown.append(name)
        measured.append(given)
        computed.append(
            total + _polynomial_trend(found.times, given - total, counts, free_courses[name])
        )
    if not shown:
        return None
    return ResponseHistory(
        maneuver=found.maneuver,
        times=found.times,
        channels=tuple(shown),
        measured=np.column_stack(measured),
        computed=np.column_stack(computed),
    )


def _polynomial_trend(
    times: FloatArray, left: FloatArray, counts: BoolArray, degree: int
) -> FloatArray:
    """Return the polynomial of a degree through what is left where it counts, shape (n,)."""
    if degree < 0:
        return np.zeros(times.size)
    span = max(float(times[-1] - times[0]), 1e-9)
    columns = np.vander((times - times[0]) / span, degree + 1)
    solution = np.linalg.lstsq(columns[counts], left[counts], rcond=None)[0]
    return np.asarray(columns @ solution, dtype=np.float64)

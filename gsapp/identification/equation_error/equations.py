"""From coefficients to an equation that can be solved, and what cannot be earned from it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.linalg import block_diag

from gsapp.dynamics.buildup import LONGITUDINAL_VARIABLES, linear_variables
from gsapp.identification.coefficients import Coefficients
from gsapp.identification.equation_error.regression import (
    EQUATION_ERROR,
    Equation,
    ManeuverRows,
    Regression,
    collinear_columns,
)
from gsapp.identification.results import DerivativeEstimate, ResponseFit
from gsapp.identification.smoothing import contiguous_slices
from gsapp.identification.statistics import response_fit
from gsapp.quantities import FloatArray, name_in_text


def simulate_instruments(states: FloatArray, surfaces: FloatArray) -> FloatArray | None:
    """Return what the surfaces make of the states, shape (n, n_states), or None.

    A model from row to row, x' = A x + B u + B' u' + c, is fitted to the stretch, and run with the
    surfaces alone from the first row.

    `states`, shape (n, n_states).
    `surfaces`, shape (n, n_surfaces).

    None where the stretch is too short or the model grows beyond bounds.
    """
    count, order = states.shape
    past = np.column_stack((states[:-1], surfaces[:-1], surfaces[1:], np.ones(count - 1)))
    if count < EQUATION_ERROR.rows_per_column * past.shape[1]:
        return None
    scale = np.maximum(np.linalg.norm(past, axis=0), 1e-300)
    solution = np.linalg.lstsq(past / scale, states[1:], rcond=1e-10)[0] / scale[:, None]
    A = np.ascontiguousarray(solution[:order].T)
    growth = float(np.abs(np.linalg.eigvals(A)).max())
    if growth**count > EQUATION_ERROR.max_growth:
        return None
    drive = past[:, order:] @ solution[order:]
    out = np.empty_like(states)
    now = states[0]
    out[0] = now
    for index in range(count - 1):
        now = A @ now + drive[index]
        out[index + 1] = now
    return out


DRIFT_PREFIX = "drift."
"""Columns for offset and drift of instruments begin so."""
FORCE_COEFFICIENTS = ("CN", "CA", "CY")
"""Coefficients that the bias of an accelerometer shifts, by another amount each day."""
_SURFACES = ("de", "da", "dr")


@dataclass(frozen=True, slots=True, eq=False)
class CoefficientCache:
    """What the coefficients of a motion share."""

    instruments: dict[tuple[int, int, int, bool], FloatArray | None] = field(default_factory=dict)
    """By maneuver, first and last sample, and whether longitudinal."""
    noise: dict[tuple[int, bool], FloatArray] = field(default_factory=dict)
    """Covariance of bias and regressors, by maneuver and whether longitudinal."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class EquationResult:
    """An equation, or why there is none."""

    equation: Equation | None
    unestimated: Mapping[str, DerivativeEstimate] = field(default_factory=dict)
    """Derivatives without a number."""
    remarks: tuple[str, ...] = ()


def build_equation(
    coefficient: str,
    names: Sequence[str],
    fixed: Mapping[str, float],
    found: Sequence[Coefficients],
    cache: CoefficientCache,
) -> EquationResult:
    """Stack the maneuvers into one equation for a coefficient.

    Parameters
    ----------
    names : sequence of str
        Derivatives wanted, bias first if at all.
    fixed : mapping of str to float
        Derivatives held.
    found : sequence of Coefficients
        Smoothed alike.
    cache : CoefficientCache
        To be handed on from coefficient to coefficient.
    """
    suffixes = [name.partition("_")[2] for name in names]
    needed = [suffix for suffix in suffixes if suffix != "0"]
    lacking = {
        index: why
        for index, one in enumerate(found)
        if (why := _missing_channels_text(coefficient, needed, one))
    }
    remarks = tuple(
        f"maneuver {found[index].maneuver} is not used for {coefficient}: {why}"
        for index, why in lacking.items()
    )
    if len(lacking) == len(found):
        return EquationResult(
            equation=None, unestimated=_estimates_without_value(names, found, lacking[0])
        )
    used = [one for index, one in enumerate(found) if index not in lacking]
    stacked = _stack_maneuvers(coefficient, names, fixed, used, cache)
    length = stacked.y.size * stacked.dt
    if length < EQUATION_ERROR.min_duration or stacked.y.size < 3 * len(names):
        why = (
            f"only {length:.1f} s of the record are usable"
            if length
            else "no window is long enough between missing and clipped samples"
        )
        return EquationResult(
            equation=None, unestimated=_unknown_estimates(names, why), remarks=remarks
        )
    unearned = _unexcited(stacked, used)
    angles = {suffix for suffix in needed for one in used if suffix in one.integrated}
    bias = f"{coefficient}_0"
    if angles and bias in names:
        why = f"the offset of the integrated {name_in_text(angles.pop())} is not known"
        unearned[bias] = DerivativeEstimate(value=None, status="unknown", why=why)
    keep = [
        index for index, name in enumerate(stacked.names) if name not in unearned or name == bias
    ]
    if all(name == bias for name in names if name not in unearned) and unearned:
        why = "nothing moved"
        return EquationResult(
            equation=None,
            unestimated={**_unknown_estimates(names, why), **unearned},
            remarks=remarks,
        )
    reduced = stacked.select_columns(keep)
    twins = {
        name: tuple(other for other in partners if not other.startswith(DRIFT_PREFIX))
        for name, partners in collinear_columns(reduced).items()
        if name != bias or name not in unearned
    }
    for name, partners in twins.items():
        others = " and ".join(partners) or "a drift"
        unearned[name] = DerivativeEstimate(
            value=None,
            status="not-identifiable",
            confounded_with=partners,
            why=f"not distinguishable from {others} in this motion",
        )
    dropped = _redundant_columns(twins)
    keep = [index for index, name in enumerate(reduced.names) if name not in dropped]
    return EquationResult(
        equation=reduced.select_columns(keep), unestimated=unearned, remarks=remarks
    )


def response_fit_of_equation(equation: Equation, solution: Regression) -> ResponseFit:
    """Return how well the solution follows the smoothed coefficient."""
    return response_fit(equation.y, equation.y - solution.residuals)


def _missing_channels_text(coefficient: str, needed: Sequence[str], one: Coefficients) -> str:
    if coefficient in one.missing:
        return one.missing[coefficient]
    absent = [
        name_in_text(name)
        for name in needed
        if name not in one.measured and name not in one.integrated
    ]
    if not absent:
        return ""
    return f"{' and '.join(absent)} {'was' if len(absent) == 1 else 'were'} not measured"


def _estimates_without_value(
    names: Sequence[str], found: Sequence[Coefficients], why: str
) -> dict[str, DerivativeEstimate]:
    """Say of every derivative whether its own variable is lacking or another one's."""
    unearned = {}
    for name in names:
        suffix = name.partition("_")[2]
        own = suffix != "0" and not any(suffix in one.measured for one in found)
        reason = (
            f"{name_in_text(suffix)} was not measured"
            if own
            else f"it cannot be estimated alone: {why}"
        )
        unearned[name] = DerivativeEstimate(value=None, status="unknown", why=reason)
    return unearned


def _unknown_estimates(names: Sequence[str], why: str) -> dict[str, DerivativeEstimate]:
    return {name: DerivativeEstimate(value=None, status="unknown", why=why) for name in names}


def _stack_maneuvers(
    coefficient: str,
    names: Sequence[str],
    fixed: Mapping[str, float],
    used: Sequence[Coefficients],
    cache: CoefficientCache,
) -> Equation:
    reads = linear_variables(coefficient)
    longitudinal = reads is LONGITUDINAL_VARIABLES
    order = ("0", *reads)
    suffixes = [name.partition("_")[2] for name in names]
    smoothing = used[0].smoother
    stride = smoothing.stride
    moving = [suffix for suffix in reads if suffix not in _SURFACES]
    surfaces = [suffix for suffix in reads if suffix in _SURFACES]
    ys: list[FloatArray] = []
    Xs: list[FloatArray] = []
    Zs: list[FloatArray] = []
    stretches: list[ManeuverRows] = []
    noise = np.zeros((len(names), len(names)))
    drifts: list[FloatArray] = []
    drifting = any(suffix in one.integrated for suffix in suffixes for one in used)
    at = 0
    for number, one in enumerate(used):
        columns = dict(zip(reads, one.smoothed_variables(tuple(reads.values())).T, strict=True))
        columns["0"] = np.ones(one.times.size)
        y = one.values[:, one.column(coefficient)]
        for name, value in fixed.items():
            head, _, suffix = name.partition("_")
            if head == coefficient and value != 0.0:
                y = y - value * columns[suffix]
        good = one.valid_samples(coefficient)
        for suffix in suffixes:
            if suffix != "0":
                good = good & one.variable_valid[reads[suffix]]
        rows = 0
        segments = []
        parts_taken = []
        for part in contiguous_slices(good):
            taken = slice(part.start, part.stop, stride)
            Xs.append(np.column_stack([columns[suffix][taken] for suffix in suffixes]))
            ys.append(y[taken])
            parts_taken.append(taken)
            where = (number, part.start, part.stop, longitudinal)
            if where not in cache.instruments:
                cache.instruments[where] = simulate_instruments(
                    np.column_stack([columns[suffix][taken] for suffix in moving]),
                    np.column_stack([columns[suffix][taken] for suffix in surfaces]),
                )
            Zs.append(_instrument_columns(Xs[-1], suffixes, moving, cache.instruments[where]))
            segments.append(slice(rows, rows + ys[-1].size))
            rows += ys[-1].size
        drifts.append(_drift_columns(one.times, parts_taken, needs_drift=drifting))
        if rows:
            stretches.append(ManeuverRows(rows=slice(at, at + rows), segments=tuple(segments)))
        at += rows
        key = (number, longitudinal)
        if key not in cache.noise:
            cache.noise[key] = np.pad(one.noise(tuple(reads.values())), ((1, 0), (1, 0)))
        places = [order.index(suffix) for suffix in suffixes]
        noise += rows * cache.noise[key][np.ix_(places, places)]
    empty = np.empty((0, len(names)))
    drift = block_diag(*drifts)
    # The bias of the first maneuver is the common one.
    drift = drift[:, 1:] if drifting and "0" in suffixes else drift
    if not drifting and coefficient in FORCE_COEFFICIENTS and "0" in suffixes:
        drift = maneuver_offset_columns(stretches)
    spare = drift.shape[1]
    return Equation(
        y=np.concatenate(ys) if ys else np.empty(0),
        X=np.column_stack((np.concatenate(Xs), drift)) if Xs else empty,
        Z=np.column_stack((np.concatenate(Zs), drift)) if Zs else empty,
        names=(*names, *(f"{DRIFT_PREFIX}{index}" for index in range(spare))),
        maneuver_rows=tuple(stretches),
        dt=stride * smoothing.dt,
        stride=stride,
        noise=np.pad(noise / max(at, 1), (0, spare)),
    )


def maneuver_offset_columns(stretches: Sequence[ManeuverRows]) -> FloatArray:
    """Return the columns that give each maneuver an offset of its own, n_maneuvers - 1 of them.

    The offsets add up to zero, so that the bias beside them is their mean.
    """
    columns = np.zeros((sum(one.rows.stop - one.rows.start for one in stretches), len(stretches)))
    for index, one in enumerate(stretches):
        columns[one.rows, index] = 1.0
    return np.asarray(columns[:, :-1] - columns[:, -1:], dtype=np.float64)


def _drift_columns(times: FloatArray, parts: Sequence[slice], *, needs_drift: bool) -> FloatArray:
    """Return offset, ramp and parabola over the rows of a maneuver, or no column."""
    rows = np.concatenate([times[part] for part in parts]) if parts else np.empty(0)
    if not needs_drift or not rows.size:
        return np.empty((rows.size, 0))
    ramp = (rows - rows[0]) / max(float(rows[-1] - rows[0]), 1e-9)
    return np.vander(ramp, EQUATION_ERROR.drift_degree + 1, increasing=True)


def _instrument_columns(
    X: FloatArray, suffixes: Sequence[str], moving: Sequence[str], found: FloatArray | None
) -> FloatArray:
    """Return the regressors with their states replaced by what the surfaces make of them."""
    if found is None:
        return X
    out = X.copy()
    for column, suffix in enumerate(suffixes):
        if suffix in moving:
            out[:, column] = found[:, moving.index(suffix)]
    return out


def _unexcited(stacked: Equation, used: Sequence[Coefficients]) -> dict[str, DerivativeEstimate]:
    """Return the derivatives whose variable has hardly moved."""
    found = {}
    for index, name in enumerate(stacked.names):
        suffix = name.partition("_")[2]
        if suffix == "0" or name.startswith(DRIFT_PREFIX):
            continue
        spread = float(np.std(stacked.X[:, index]))
        noise = float(np.sqrt(stacked.noise[index, index]))
        least = excitation_threshold(suffix, used[0])
        if spread < max(least, EQUATION_ERROR.min_signal_to_noise * noise):
            found[name] = DerivativeEstimate(
                value=None,
                status="unknown",
                why=f"the {name_in_text(suffix)} hardly moved: {spread / least:.2g} times the "
                "required minimum"
                if spread < least
                else f"the {name_in_text(suffix)} did not exceed its noise",
            )
    return found


def excitation_threshold(suffix: str, one: Coefficients) -> float:
    """Return the standard deviation of a regressor below which nothing has moved."""
    if suffix not in ("p", "q", "r"):
        return EQUATION_ERROR.min_angle_std
    # p b/2V for the least p, at the mean speed.
    hat, rate = one.variables[f"{suffix}_hat"], one.variables[suffix]
    return (
        EQUATION_ERROR.min_rate_std
        * float(np.linalg.norm(hat))
        / max(float(np.linalg.norm(rate)), 1e-12)
    )


def _redundant_columns(twins: Mapping[str, tuple[str, ...]]) -> set[str]:
    """Return one less than every group of twins, so that the rest can be solved."""
    dropped: set[str] = set()
    for name, partners in twins.items():
        if not dropped.intersection(partners):
            dropped.add(name)
    return dropped

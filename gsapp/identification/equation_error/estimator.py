"""Derivatives by equation error: every coefficient regressed on what the build-up multiplies.

Vanes and surfaces may come late against the gyros. A filter before the converter on all channels
but the rates (notes, section 2), or a servo taken for its surface, shifts one side of the moment
equations in time. Half a sample at 100 Hz bends damping and control derivatives by 5 to 8 %, far
beyond their bounds, and the fit looks perfect. The shift itself is seen well: to first order it
adds tau (sum of slope times rate of the regressor), one more column.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from gsapp.dynamics.buildup import linear_variables
from gsapp.dynamics.model import Model
from gsapp.foundation import FlightError
from gsapp.identification.axes import (
    AXIS_COEFFICIENTS,
    AXIS_SURFACES,
    Axis,
    axis_derivatives,
    free_derivatives,
)
from gsapp.identification.channel_faults import check_estimate_support, remove_stuck_channels
from gsapp.identification.coefficient_histories import coefficient_history
from gsapp.identification.coefficients import Coefficients, smooth_coefficients
from gsapp.identification.equation_error.equations import (
    DRIFT_PREFIX,
    CoefficientCache,
    build_equation,
    excitation_threshold,
    response_fit_of_equation,
)
from gsapp.identification.equation_error.regression import (
    EQUATION_ERROR,
    Equation,
    ManeuverRows,
    Regression,
    instrument_inflation,
    solve_equation,
)
from gsapp.identification.estimate_corrections import add_offset_uncertainty, constant_term_offsets
from gsapp.identification.instrument_effects import effective_records
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.motion import MeasuredMotion, measured_motion
from gsapp.identification.results import DerivativeEstimate, Estimate, ResponseFit
from gsapp.quantities import FloatArray, name_in_text


def estimate(
    maneuvers: Sequence[Maneuver],
    axis: Axis,
    *,
    free: Sequence[str] | None = None,
    held: Mapping[str, float] | None = None,
    stand_ins: Mapping[str, float] | None = None,
    model: Model | None = None,
    cutoff: float | None = None,
    motions: Sequence[MeasuredMotion] | None = None,
    delays: Mapping[str, float] | Literal["estimate"] | None = None,
) -> Estimate:
    """Estimate derivatives from one maneuver, or from several in one stacked regression.

    Parameters
    ----------
    free : sequence of str, optional
        Derivatives to estimate; by default those of tables 6.2.5 and 6.2.6 for the surfaces moved
        as the input. The share of another surface that moved beside is then fitted, not reported.
    held : mapping of str to float, optional
        Derivatives held at a value.
    stand_ins : mapping of str to float, optional
        As in `gsapp.identification.motion.measured_motion`.
    model : Model, optional
        Derivatives that are not free take its values; its effects are taken as known.
    cutoff : float, optional
        Of the smoothing, Hz; by default chosen from the data.
    motions : sequence of MeasuredMotion, optional
        If they are known already, one for each maneuver.
    delays : mapping of str to float or "estimate", optional
        How late channels come, as in `gsapp.identification.coefficients.reconstruct_coefficients`;
        an empty mapping says that none does. By default a delay that shows is warned of.
        ``"estimate"`` finds how late vanes and surfaces come against the gyros
        (`gsapp.identification.equation_error.estimator`), undoes what is proven, and widens
        the bounds by what is not known of it.

    Returns
    -------
    Estimate
        `fit` is by coefficient (``CN`` ...), and so are the `histories` of a single maneuver. What
        was not earned has no number and says why.

    Raises
    ------
    FlightError
        If there is no maneuver, or the airspeed is missing and nothing can stand in for it.
    """
    if not maneuvers:
        raise FlightError("no maneuver to estimate from; name at least one")
    if motions is not None:
        return _from_motions(
            maneuvers, axis, motions, free=free, held=held, model=model, cutoff=cutoff,
            delays=delays,
        )  # fmt: skip
    whole, remarks = remove_stuck_channels(maneuvers, axis)
    records, left = effective_records(whole, model)
    motions = [measured_motion(maneuver, stand_ins=stand_ins) for maneuver in records]
    found = _from_motions(
        records, axis, motions, free=free, held=held, model=left, cutoff=cutoff, delays=delays
    )
    return check_estimate_support(found, whole, stand_ins or {}, remarks)


def _from_motions(
    maneuvers: Sequence[Maneuver],
    axis: Axis,
    motions: Sequence[MeasuredMotion],
    *,
    free: Sequence[str] | None,
    held: Mapping[str, float] | None,
    model: Model | None,
    cutoff: float | None,
    delays: Mapping[str, float] | Literal["estimate"] | None,
) -> Estimate:
    known = delays if isinstance(delays, Mapping) else {}
    found = smooth_coefficients(maneuvers, motions, model=model, cutoff=cutoff, delays=known)
    inputs = {name for maneuver in maneuvers for name in maneuver.inputs}
    # Delays that the caller knows are believed.
    shift = (
        None if isinstance(delays, Mapping) else estimate_relative_delay(found, axis, tuple(inputs))
    )
    proven = shift is not None and abs(shift[0]) > max(
        EQUATION_ERROR.significant_sigmas * shift[1], EQUATION_ERROR.min_shift
    )
    plain = _estimate_from_coefficients(found, maneuvers, axis, free=free, held=held, model=model)
    if shift is None or not proven:
        return plain
    text = (
        f"vanes and surfaces come {1e3 * shift[0]:.1f} +- {1e3 * shift[1]:.1f} ms "
        f"{'late' if shift[0] > 0.0 else 'early'} against the gyros"
    )
    if delays != "estimate":
        bent = f"{text}: moment derivatives are biased, which no bound includes"
        return replace(plain, warnings=(*plain.warnings, bent))
    late = dict.fromkeys(DELAYED_CHANNELS, shift[0])
    right = smooth_coefficients(maneuvers, motions, model=model, cutoff=cutoff, delays=late)
    better = _estimate_from_coefficients(right, maneuvers, axis, free=free, held=held, model=model)
    return _widen_bounds(better, plain, shift, f"{text}, which is corrected")


def _widen_bounds(
    better: Estimate, plain: Estimate, shift: tuple[float, float], told: str
) -> Estimate:
    """Return the estimate with the uncertainty of the shift in its bounds."""
    slopes = np.zeros(len(better.free))
    for index, name in enumerate(better.free):
        now, before = better.value(name), plain.value(name)
        if now is not None and before is not None:
            slopes[index] = (now - before) / shift[0]
    covariance = better.covariance + shift[1] ** 2 * np.outer(slopes, slopes)
    derivatives = dict(better.derivatives)
    for index, name in enumerate(better.free):
        wider = float(np.sqrt(covariance[index, index]))
        derivatives[name] = replace(derivatives[name], std=wider)
    return replace(
        better,
        derivatives=derivatives,
        covariance=covariance,
        nuisance={f"{one}.shift.surfaces": shift for one in better.maneuvers},
        warnings=(*better.warnings, told),
    )


def _estimate_from_coefficients(
    found: Sequence[Coefficients],
    maneuvers: Sequence[Maneuver],
    axis: Axis,
    *,
    free: Sequence[str] | None,
    held: Mapping[str, float] | None,
    model: Model | None,
) -> Estimate:
    inputs = {name for maneuver in maneuvers for name in maneuver.inputs}
    wanted = free_derivatives(axis, inputs) if free is None else tuple(free)
    fixed = {} if model is None else {name: model.derivative(name) for name in model.derivatives}
    fixed = {name: value for name, value in fixed.items() if name not in wanted}
    fixed.update(held or {})
    derivatives = {
        name: DerivativeEstimate(value=fixed[name], status="held")
        if name in fixed
        else DerivativeEstimate(value=None, status="unknown", why="not free")
        for name in axis_derivatives(axis)
    }
    # Left out of the equation, a surface that the pilot moved all the same would bend the rest.
    beside = [] if free is not None else _secondary_input_derivatives(axis, wanted, fixed, found)
    warnings = [remark for one in found for remark in one.remarks]
    if beside:
        surfaces = dict.fromkeys(name_in_text(name.partition("_")[2]) for name in beside)
        warnings.append(
            f"the {' and the '.join(surfaces)} also moved, but not as the input; its effect is "
            "also fitted"
        )
    blocks: list[Regression] = []
    fits: dict[str, ResponseFit] = {}
    poor: list[str] = []
    cache = CoefficientCache()
    fitted = dict(fixed)
    courses: dict[str, int] = {}
    for coefficient in AXIS_COEFFICIENTS[axis]:
        names = [f"{coefficient}_{suffix}" for suffix in ("0", *linear_variables(coefficient))]
        names = [name for name in names if name in (*wanted, *beside) and name not in fixed]
        if not names:
            continue
        formed = build_equation(coefficient, names, fixed, found, cache)
        derivatives.update(formed.unestimated)
        warnings += formed.remarks
        if formed.equation is None:
            continue
        solution, weak = _solve_with_instruments(formed.equation)
        if weak:
            poor.append(coefficient)
        fits[coefficient] = response_fit_of_equation(formed.equation, solution)
        blocks.append(solution)
        fitted.update(zip(solution.names, solution.values.tolist(), strict=True))
        courses[coefficient] = -1
        if any(name.startswith(DRIFT_PREFIX) for name in solution.names):
            courses[coefficient] = EQUATION_ERROR.drift_degree
        for index, name in enumerate(solution.names):
            if name in derivatives and name not in formed.unestimated:
                derivatives[name] = DerivativeEstimate(
                    value=float(solution.values[index]),
                    std=float(solution.std[index]),
                    cramer_rao=float(np.sqrt(solution.white_covariance[index, index])),
                )
    if poor:
        warnings.append(
            f"the surfaces explain too little of the motion behind {', '.join(poor)} (gusts?) "
            "for the regressor noise; estimates may be biased low"
        )
    for name in beside:
        why = "not free; its effect was also fitted"
        derivatives[name] = DerivativeEstimate(value=None, status="unknown", why=why)
    names_free, covariance = _join_covariances(blocks, derivatives)
    # Maneuvers fitted together have offsets of their own; each is drawn with its own fit.
    shown = coefficient_history(found[0], fitted, courses) if len(found) == 1 else None
    estimated = Estimate(
        method="ee",
        axis=axis,
        maneuvers=tuple(maneuver.id for maneuver in maneuvers),
        derivatives=derivatives,
        free=names_free,
        covariance=covariance,
        fit=fits,
        histories=() if shown is None else (shown,),
        iterations=1,
        converged=bool(names_free),
        warnings=tuple(dict.fromkeys(warnings)),
        message="solved directly" if names_free else "no derivative could be estimated",
    )
    qbars = [one.variables["qbar"] for one in found]
    return add_offset_uncertainty(estimated, constant_term_offsets(maneuvers, qbars))


def _secondary_input_derivatives(
    axis: Axis,
    wanted: Sequence[str],
    fixed: Mapping[str, float],
    found: Sequence[Coefficients],
) -> list[str]:
    """Return the derivatives, not wanted, of surfaces that were measured and moved."""
    moved = [
        surface
        for surface in AXIS_SURFACES[axis]
        if all(surface in one.measured for one in found)
        and any(
            np.std(one.variables[surface]) > excitation_threshold(surface, one) for one in found
        )
    ]
    return [
        name
        for name in axis_derivatives(axis)
        if name.partition("_")[2] in moved and name not in wanted and name not in fixed
    ]


def _solve_with_instruments(equation: Equation) -> tuple[Regression, bool]:
    """Solve with instruments where they are strong enough, else by least squares.

    Also return whether they were too weak.
    """
    if (equation.Z == equation.X).all():
        return solve_equation(equation), False
    if instrument_inflation(equation) > EQUATION_ERROR.weak_instrument_inflation:
        return solve_equation(equation.with_ordinary_least_squares), True
    return solve_equation(equation), False


def _join_covariances(
    blocks: Sequence[Regression], derivatives: Mapping[str, DerivativeEstimate]
) -> tuple[tuple[str, ...], np.ndarray[tuple[int, int], np.dtype[np.float64]]]:
    """Return names and covariance of all that was estimated."""
    names: list[str] = []
    parts = []
    for block in blocks:
        kept = [
            index
            for index, name in enumerate(block.names)
            if name in derivatives and derivatives[name].status == "estimated"
        ]
        names += [block.names[index] for index in kept]
        parts.append(block.covariance[np.ix_(kept, kept)])
    covariance = np.zeros((len(names), len(names)))
    at = 0
    for part in parts:
        covariance[at : at + len(part), at : at + len(part)] = part
        at += len(part)
    return tuple(names), covariance


DELAYED_CHANNELS = ("V", "alpha", "beta", "de", "da", "dr", "ax", "ay", "an")
"""Channels that pass the filter; p, q, r do not."""
_MOMENTS: Mapping[Axis, tuple[str, ...]] = {
    "lon": ("Cm",),
    "lat": ("Cl", "Cn"),
    "both": ("Cm", "Cl", "Cn"),
}


def estimate_relative_delay(
    found: Sequence[Coefficients], axis: Axis, inputs: Sequence[str]
) -> tuple[float, float] | None:
    """Return how late vanes and surfaces come against the gyros, s, and its bound.

    `found`: of the maneuvers, smoothed alike, with the delays known so far undone.
    `inputs`: surfaces that were moved.

    Mean over the moments of the axis, by inverse variance. None where no moment tells.
    """
    shifts = []
    for coefficient in _MOMENTS[axis]:
        names = [
            f"{coefficient}_{suffix}"
            for suffix in ("0", *linear_variables(coefficient))
            if suffix not in ("de", "da", "dr") or suffix in inputs
        ]
        equation = build_equation(coefficient, names, {}, found, CoefficientCache()).equation
        if equation is not None:
            shifts.append(_estimate_shift(equation))
    shifts = [(value, std) for value, std in shifts if np.isfinite(std) and std > 0.0]
    if not shifts:
        return None
    weights = np.array([1.0 / std**2 for _, std in shifts])
    values = np.array([value for value, _ in shifts])
    mean = float(weights @ values / weights.sum())
    # Moments that disagree know less than each claims.
    spread = float(weights @ (values - mean) ** 2) / max(len(shifts) - 1, 1)
    return mean, float(np.sqrt(max(1.0, spread) / weights.sum()))


def _estimate_shift(equation: Equation) -> tuple[float, float]:
    """Return the shift and its bound from one equation."""
    late = [
        index
        for index, name in enumerate(equation.names)
        if name.partition("_")[2] in ("alpha", "beta", "de", "da", "dr")
    ]
    theta = solve_equation(equation).values
    for _ in range(2):
        columns = [
            _differentiate_columns(matrix[:, late], equation.maneuver_rows, equation.dt)
            @ theta[late]
            for matrix in (equation.X, equation.Z)
        ]
        width = len(equation.names)
        wider = replace(
            equation,
            X=np.column_stack((equation.X, columns[0])),
            Z=np.column_stack((equation.Z, columns[1])),
            names=(*equation.names, "shift"),
            noise=np.pad(equation.noise, (0, 1)),
        )
        try:
            solution = solve_equation(wider)
        except np.linalg.LinAlgError:
            return 0.0, np.inf
        theta = solution.values[:width]
    return float(solution.values[-1]), float(solution.std[-1])


def _differentiate_columns(
    columns: FloatArray, stretches: Sequence[ManeuverRows], dt: float
) -> FloatArray:
    """Return the derivatives of smoothed columns, stretch by stretch."""
    out = np.zeros_like(columns)
    for stretch in stretches:
        own = columns[stretch.rows]
        for part in stretch.segments:
            if part.stop - part.start > 2:
                out[stretch.rows][part] = np.gradient(own[part], dt, axis=0, edge_order=2)
    return out


def estimate_start_values(
    maneuvers: Sequence[Maneuver],
    free: Sequence[str],
    *,
    held: Mapping[str, float] | None = None,
    stand_ins: Mapping[str, float] | None = None,
    model: Model | None = None,
    motions: Sequence[MeasuredMotion] | None = None,
) -> dict[str, float]:
    """Return numbers to start from, by derivative, in a millisecond or two.

    Plain least squares without bounds. What cannot be told apart is shared out; what was not
    measured or has not moved is left out. `estimate` is the one to believe.

    `free`: derivatives.
    `held`, `stand_ins`, `model`, `motions`: as in `gsapp.identification.equation_error.estimator`.
    """
    found = smooth_coefficients(
        maneuvers,
        stand_ins=stand_ins,
        model=model,
        cutoff=EQUATION_ERROR.start_value_cutoff,
        motions=motions,
    )
    fixed = {} if model is None else dict(model.derivatives)
    fixed = {name: value for name, value in fixed.items() if name not in free}
    fixed.update(held or {})
    start: dict[str, float] = {}
    columns = [_regressor_columns(one) for one in found]
    for coefficient in dict.fromkeys(name.partition("_")[0] for name in free):
        names = [name for name in free if name.startswith(f"{coefficient}_")]
        pieces = [
            _regression_rows(one, table, coefficient, names, fixed)
            for one, table in zip(found, columns, strict=True)
            if coefficient not in one.missing
        ]
        if not pieces:
            continue
        X = np.concatenate([piece[0] for piece in pieces])
        y = np.concatenate([piece[1] for piece in pieces])
        if len(y) < len(names):
            continue
        moved = [
            index
            for index, name in enumerate(names)
            if X[:, index].any()
            and (
                name.endswith("_0") or X[:, index].std() > excitation_threshold(name[3:], found[0])
            )
        ]
        scale = np.maximum(np.linalg.norm(X[:, moved], axis=0), 1e-300)
        solution = (
            np.linalg.lstsq(X[:, moved] / scale, y, rcond=EQUATION_ERROR.singular_value_cutoff)[0]
            / scale
        )
        start.update(zip([names[index] for index in moved], solution.tolist(), strict=True))
    return start


def _regressor_columns(one: Coefficients) -> dict[str, FloatArray]:
    suffixes = {**linear_variables("Cm"), **linear_variables("Cn")}
    smoothed = one.smoothed_variables(tuple(suffixes.values()))[:: one.smoother.stride]
    table = dict(zip(suffixes, smoothed.T, strict=True))
    table["0"] = np.ones(len(smoothed))
    return table


def _regression_rows(
    one: Coefficients,
    table: Mapping[str, FloatArray],
    coefficient: str,
    names: Sequence[str],
    fixed: Mapping[str, float],
) -> tuple[FloatArray, FloatArray]:
    stride = one.smoother.stride
    y = one.values[::stride, one.column(coefficient)]
    good = one.valid_samples(coefficient)[::stride]
    for name, value in fixed.items():
        head, _, suffix = name.partition("_")
        if head == coefficient and value != 0.0:
            y = y - value * table[suffix]
    reads = linear_variables(coefficient)
    suffixes = [name.partition("_")[2] for name in names]
    for suffix in suffixes:
        if suffix != "0":
            good = good & one.variable_valid[reads[suffix]][::stride]
    X = np.column_stack([table[suffix] for suffix in suffixes])
    if not one.integrated.isdisjoint(suffixes):
        # An integrated angle has an offset and a drift: they are taken out of both sides.
        ramp = np.linspace(-1.0, 1.0, y.size)
        drift = np.linalg.qr(np.column_stack((np.ones(y.size), ramp, ramp * ramp))[good])[0]
        both = np.column_stack((X, y))[good]
        both = both - drift @ (drift.T @ both)
        return both[:, :-1], both[:, -1]
    return X[good], y[good]

"""Three linear models, judged on a flight that none of them saw: section 7.4 of the source.

Models are fitted on the maneuvers of one flight, or several, and driven by the measured inputs of
another from its first to its last maneuver, without correction. What counts is the RMS error of
each variable over the range of the measured one.

Batch least squares takes states that are measured (7.2.1)-(7.2.11): both sides of x' = A x + B u
pass the same zero-phase filter; every stretch has a constant of its own, since its trim is not the
next one's.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import linalg, signal

from gsapp.aircraft import Aircraft
from gsapp.dynamics.linearization import LinearModel
from gsapp.dynamics.sensors import Vector
from gsapp.foundation import FlightError
from gsapp.identification.linear_models.derivative_conversion import (
    SteadyCondition,
    lateral_model,
    longitudinal_model,
    solve_steady_flight,
)
from gsapp.identification.linear_models.signals import (
    LINEAR_MODELS,
    DiscreteModel,
    InputOutputRecord,
    LinearAxis,
    LinearModelSignals,
    all_linear_model_signals,
    discretize,
    linear_model_signals,
)
from gsapp.identification.linear_models.subspace import (
    identify_subspace_model,
    refine_by_prediction_error,
)
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.motion import measured_motion
from gsapp.identification.smoothing import build_smoother, select_cutoff
from gsapp.identification.statistics import response_fit
from gsapp.quantities import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BatchLeastSquaresResult:
    """A model with the uncertainty of its entries."""

    model: LinearModel  # Outputs are those of the signals.
    A_std: FloatArray
    B_std: FloatArray
    C_std: FloatArray
    D_std: FloatArray
    """Square roots of the diagonal of (7.2.7), with the effective number of samples that the filter
    leaves."""


def batch_least_squares(stretches: Sequence[LinearModelSignals]) -> BatchLeastSquaresResult:
    """Fit a model to measured states, inputs and outputs.

    `stretches`: each without a gap; states, inputs and outputs alike in all.

    Raises `FlightError` if there are fewer samples than unknowns, or an input never moves.
    """
    first = stretches[0]
    dt = first.dt
    cutoff = max(select_cutoff(one.states, dt) for one in stretches)
    filtering = build_smoother(dt, cutoff)
    n, m = first.states.shape[1], first.inputs.shape[1]
    left, right = [], []
    for one in stretches:
        known = filtering.valid_samples(np.zeros(len(one), dtype=bool))
        rates = filtering.smooth(filtering.differentiate(one.states))[known]
        beside = filtering.smooth(
            filtering.simpson_average(np.hstack([one.states, one.inputs, one.outputs]))
        )[known]
        # A constant of each stretch is taken out with its mean values.
        beside = beside - beside.mean(axis=0)
        right.append(beside[:, : n + m])
        left.append(np.hstack([rates - rates.mean(axis=0), beside[:, n + m :]]))
    X, Y = np.vstack(right), np.vstack(left)
    # Samples that the filter made alike count as one.
    effective = len(X) / filtering.stride
    if effective < 2 * (n + m) + len(stretches):
        raise FlightError(
            f"{len(X)} samples are too few for least squares with {n + m} unknowns in each row; "
            "give longer maneuvers, or more of them"
        )
    spread = X.std(axis=0)
    still = [name for name, s in zip((*first.state_names, *first.input_names), spread, strict=True)
             if not s > 0.0]  # fmt: skip
    if still:
        raise FlightError(
            f"{', '.join(still)} does not move in these maneuvers; give maneuvers with that input"
        )
    solution, _, rank, _ = linalg.lstsq(X, Y)
    if rank < n + m:
        names = ", ".join((*first.state_names, *first.input_names))
        raise FlightError(
            f"some of {names} move together in these maneuvers; their effects cannot be "
            "separated; give other or more maneuvers"
        )
    errors = Y - X @ solution
    mse = np.sum(errors**2, axis=0) / (len(X) * (1.0 - (n + m) / effective))
    inverse = np.linalg.inv(X.T @ X).diagonal() * len(X) / effective
    table, std = solution.T, np.sqrt(np.outer(mse, inverse))
    return BatchLeastSquaresResult(
        model=LinearModel(
            states=first.state_names,
            inputs=first.input_names,
            outputs=first.output_names,
            A=table[:n, :n], B=table[:n, n:], C=table[n:, :n], D=table[n:, n:],
        ),
        A_std=std[:n, :n], B_std=std[:n, n:], C_std=std[n:, :n], D_std=std[n:, n:],
    )  # fmt: skip


DRAG_DERIVATIVES = ("CA_0", "CA_alpha")
"""Without these nothing is known of how speed changes."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class EvaluatedModel:
    """One linear model and how it did."""

    model: LinearModel  # Continuous, SI.
    rms_over_range_pct: Mapping[str, float]
    """Over the whole of the flight it was judged on, by output."""
    by_maneuver_pct: Mapping[str, float]
    """The same over its maneuvers alone, each with a level and a start of its own."""
    remarks: tuple[str, ...] = ()


def mean_condition(
    maneuvers: Sequence[Maneuver], stand_ins: Mapping[str, float] | None = None
) -> SteadyCondition:
    """Return the steady condition that maneuvers have in common.

    Speed and density are means over the maneuvers, as dynamic pressure acts in them; angle of
    attack and elevator those of their first moments.

    `stand_ins`: as in `gsapp.identification.motion.measured_motion`.
    """
    rows = []
    for maneuver in maneuvers:
        motion = measured_motion(maneuver, stand_ins=stand_ins)
        first = slice(0, max(1, round(0.3 / maneuver.dt)))
        V, rho = motion.state("V").mean(), motion.input("rho").mean()
        alpha, de = motion.state("alpha")[first].mean(), motion.input("de")[first].mean()
        rows.append((V, alpha, de, rho, maneuver.mass))
    V, alpha, de, rho, mass = (float(value) for value in np.mean(rows, axis=0))
    return SteadyCondition(U1=V, alpha1=alpha, de1=de, rho=rho, mass=mass)


def with_accelerometer_outputs(model: LinearModel, position: Vector) -> LinearModel:
    """Return the model with an and ay as an accelerometer at a place shows them.

    To first order in the motion a_n grows by x q', a_y by x r' - z p'.
    """
    x, _, z = position
    C, D = model.C.copy(), model.D.copy()
    for output, arms in (("an", {"q": x}), ("ay", {"r": x, "p": -z})):
        if output not in model.outputs:
            continue
        row = model.outputs.index(output)
        for state, arm in arms.items():
            if state in model.states:
                C[row] += arm * model.A[model.states.index(state)]
                D[row] += arm * model.B[model.states.index(state)]
    return replace(model, C=C, D=D)


def model_from_derivatives(
    aircraft: Aircraft,
    condition: SteadyCondition,
    axis: LinearAxis,
    derivatives: Mapping[str, float],
) -> LinearModel:
    """Return the linear model of derivatives (maximum likelihood, say), accelerometer in place.

    Speed and pitch angle are held where drag is not known: what damps the phugoid would be missing.
    """
    known = all(name in derivatives for name in DRAG_DERIVATIVES)
    steady, completed = condition, derivatives
    if known:
        steady, completed = solve_steady_flight(aircraft, condition, derivatives)
    if axis == "lat":
        model = lateral_model(aircraft, steady, completed)
    else:
        model = longitudinal_model(aircraft, steady, completed)
        if not known:
            model = without_slow_states(model)
    return with_accelerometer_outputs(model, aircraft.sensors.accelerometer.position)


def without_slow_states(model: LinearModel) -> LinearModel:
    """Return a model with speed and pitch angle held.

    Over minutes the pilot flies the path; a model that flies it open loop only drifts. The
    source's own longitudinal matrix has an empty column for V.
    """
    kept = [k for k, name in enumerate(model.states) if name not in ("V", "theta")]
    return replace(
        model,
        states=tuple(model.states[k] for k in kept),
        A=model.A[np.ix_(kept, kept)],
        B=model.B[kept],
        C=model.C[:, kept],
    )


def subspace_model(
    stretches: Sequence[LinearModelSignals], *, order: int | None
) -> tuple[DiscreteModel, tuple[str, ...]]:
    """Return the model of subspace start and prediction error, with remarks."""
    dt = stretches[0].dt
    step = max(1, round(1.0 / (LINEAR_MODELS.subspace_rate * dt)))
    records = [_decimate_signals(one, step) for one in stretches]
    start = identify_subspace_model(records, dt * step, order=order)
    refined = refine_by_prediction_error(records, start.model, start.initial_states)
    remarks = [f"order {start.order}" + ("" if order else ", chosen from the data")]
    if not refined.converged:
        remarks.append("the refinement did not converge")
    return refined.model, tuple(remarks)


def evaluate_linear_models(
    fitted: Sequence[Maneuver],
    judged: Sequence[Maneuver],
    whole: Maneuver,
    axis: LinearAxis,
    derivatives: Mapping[str, float],
    *,
    order: int | None,
) -> dict[str, EvaluatedModel]:
    """Fit the three models and judge them.

    Parameters
    ----------
    fitted : sequence of Maneuver
        What they are fitted on.
    judged : sequence of Maneuver
        Maneuvers of the other flight.
    whole : Maneuver
        All of the other flight from its first to its last maneuver.
    derivatives : mapping of str to float
        Means of the maximum likelihood estimates over `fitted`.
    order : int, optional
        Of the subspace model; None lets the data choose.

    Returns
    -------
    dict
        ``bls``, ``subspace``, ``ml``.

    Raises
    ------
    FlightError
        If a channel is missing, or the maneuvers are too few or too short.
    """
    dt = whole.dt
    models = fit_models(fitted, axis, derivatives, order=order)
    flight = linear_model_signals(whole, axis)
    parts = [one for maneuver in judged for one in linear_model_signals(maneuver, axis)]
    return {
        name: EvaluatedModel(
            model=one.model,
            rms_over_range_pct=_output_errors(one.discretized(dt), flight, own_start=False),
            by_maneuver_pct=_output_errors(one.discretized(dt), parts, own_start=True),
            remarks=one.remarks,
        )
        for name, one in models.items()
    }


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FittedModel:
    """A linear model as it is reported and as it is driven."""

    model: LinearModel  # Continuous, SI, all states.
    simulated_model: LinearModel  # What is simulated: without the states that a pilot flies.
    remarks: tuple[str, ...] = ()

    def discretized(self, dt: float) -> DiscreteModel:
        """Return the model at a sample time (s)."""
        return discretize(self.simulated_model, dt)


def fit_models(
    fitted: Sequence[Maneuver],
    axis: LinearAxis,
    derivatives: Mapping[str, float],
    *,
    order: int | None,
) -> dict[str, FittedModel]:
    """Fit the three models.

    `derivatives`: means of the maximum likelihood estimates over `fitted`.
    `order`: of the subspace model; None lets the data choose.

    ``bls``, ``subspace``, ``ml``.

    Raises `FlightError` if a channel is missing, or the maneuvers are too few or too short.
    """
    if not fitted:
        raise FlightError("there is no maneuver to fit a linear model on")
    stretches = all_linear_model_signals(fitted, axis)
    inputs, outputs = stretches[0].input_names, stretches[0].output_names
    found, remarks = subspace_model(stretches, order=order)
    condition = mean_condition(fitted)
    continuous = replace(
        found.to_continuous(inputs, outputs), operating_point=condition.operating_point
    )
    derived = model_from_derivatives(fitted[0].aircraft, condition, axis, derivatives)
    derived = _select_outputs(derived, outputs)
    least = replace(batch_least_squares(stretches).model, operating_point=condition.operating_point)
    return {
        "bls": FittedModel(model=least, simulated_model=least),
        "subspace": FittedModel(model=continuous, simulated_model=continuous, remarks=remarks),
        "ml": FittedModel(model=derived, simulated_model=without_slow_states(derived)),
    }


def _select_outputs(model: LinearModel, outputs: Sequence[str]) -> LinearModel:
    rows = [model.outputs.index(name) for name in outputs]
    return replace(model, outputs=tuple(outputs), C=model.C[rows], D=model.D[rows])


def _decimate_signals(one: LinearModelSignals, step: int) -> InputOutputRecord:
    """Return a stretch about its mean, filtered both ways before samples are left out."""
    signals = np.hstack([one.inputs, one.outputs])
    # About its trim instead, an error of the trim would look like a state that integrates.
    signals = signals - signals.mean(axis=0)
    if step > 1:
        sections = signal.butter(4, 0.8 / step, output="sos")
        signals = signal.sosfiltfilt(sections, signals, axis=0)[::step]
    width = one.inputs.shape[1]
    return InputOutputRecord(inputs=signals[:, :width], outputs=signals[:, width:])


def simulate_outputs(
    model: DiscreteModel, one: LinearModelSignals, *, own_start: bool
) -> FloatArray:
    """Return the outputs that a model computes from the measured inputs of a stretch.

    `own_start`: whether the level and the motion that the stretch began with are given; else the
    level alone.

    Shape (n, n_outputs). Not finite where the model runs away.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        y = model.simulate(one.inputs - one.inputs.mean(axis=0))
        missed = one.outputs - y
        # Outputs differ by a constant: the level that the model does not know.
        return y + (_free_response(model, missed) if own_start else missed.mean(axis=0))


def _output_errors(
    model: DiscreteModel, stretches: Sequence[LinearModelSignals], *, own_start: bool
) -> dict[str, float]:
    """Return RMS over range by output, percent; infinite where the model runs away."""
    if not stretches:
        return {}
    z = np.vstack([one.outputs for one in stretches])
    y = np.vstack([simulate_outputs(model, one, own_start=own_start) for one in stretches])
    return errors_over_range(z, y, stretches[0].output_names)


def errors_over_range(z: FloatArray, y: FloatArray, names: Sequence[str]) -> dict[str, float]:
    """Return RMS error over range (percent) of each column; infinite where y is not finite.

    `z` and `y`, shape (n, number of names): measured and computed.
    """
    found = {}
    for column, name in enumerate(names):
        bad = not np.isfinite(y[:, column]).all()
        fit = response_fit(z[:, column], np.nan_to_num(y[:, column]))
        found[name] = math.inf if bad else fit.rms_over_range_pct
    return found


def _free_response(model: DiscreteModel, missed: FloatArray) -> FloatArray:
    """Return the level and the motion from a start of its own that make up for most, (n, p).

    Few maneuvers begin in trim; what a maneuver began with is not the model's error.
    """
    count, width = missed.shape
    still = np.zeros((count, model.B.shape[1]))
    columns = [model.simulate(still, start).ravel() for start in np.eye(model.order)]
    columns += [np.tile(level, count) for level in np.eye(width)]
    table = np.column_stack(columns)
    # Outputs of different size count alike.
    scale = np.tile(1.0 / np.maximum(missed.std(axis=0), 1e-12), count)
    if not np.isfinite(table).all() or not np.isfinite(missed).all():
        return np.full(missed.shape, np.nan)
    solved = np.linalg.lstsq(table * scale[:, None], missed.ravel() * scale, rcond=None)[0]
    return np.asarray((table @ solved).reshape(missed.shape), dtype=np.float64)

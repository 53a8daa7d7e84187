"""Lays out a fit: what is free, which samples count, where a maneuver splits."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from gsapp.dynamics.equations import POLAR_STATES
from gsapp.dynamics.flight_model import MODEL_INPUTS, FlightModel
from gsapp.dynamics.model import Model
from gsapp.dynamics.propulsion import thrust
from gsapp.dynamics.signal_terms import INPUT_CHANNELS, PathTerms, SignalTerm
from gsapp.foundation import FlightError, UnknownNameError
from gsapp.foundation.name_suggestions import did_you_mean
from gsapp.identification.axes import (
    AXIS_COEFFICIENTS,
    AXIS_RESPONSES,
    AXIS_STATES,
    AXIS_SURFACES,
    DEFAULT_BIASES,
    axis_derivatives,
    free_derivatives,
)
from gsapp.identification.channel_faults import check_sample_count
from gsapp.identification.coefficients import flight_model_without_aero
from gsapp.identification.instrument_effects import (
    has_instrument_effects,
    undo_instrument_effects,
    without_swaps,
)
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.maximum_likelihood.axis_kernels import build_axis_kernel
from gsapp.identification.maximum_likelihood.kernels import GeneralKernel, Kernel
from gsapp.identification.maximum_likelihood.problem import (
    EstimationProblem,
    GlobalParameters,
    ManeuverProblem,
    ManeuverSegment,
    path_parameter_names,
)
from gsapp.identification.maximum_likelihood.settings import ML_ALGORITHM, MLSettings
from gsapp.identification.maximum_likelihood.trajectory_solver import (
    TrajectorySolver,
    build_segment_forcing,
)
from gsapp.identification.motion import MeasuredMotion, measured_motion
from gsapp.identification.smoothing import build_smoother, contiguous_slices
from gsapp.quantities import BoolArray, FloatArray
from gsapp.quantities.constants import GRAVITY


def build_problem(
    maneuvers: Sequence[Maneuver],
    settings: MLSettings,
    *,
    piece: float | None = None,
    motions: Sequence[MeasuredMotion] | None = None,
) -> EstimationProblem:
    """Lay out a fit.

    `piece`: cut every segment into pieces of this length, s, each started from measurement.
    `motions`: if they are known already.

    Raises `FlightError` if nothing can be fitted; it says what is missing.
    """
    if not maneuvers:
        raise FlightError("no maneuver to estimate from; name at least one")
    for maneuver in maneuvers:
        _check_maneuver(maneuver)
    model = settings.model or Model()
    if has_instrument_effects(model):
        # Responses and surfaces are predicted with what is wrong with their instruments; what
        # else drives the equations must be right.
        predicted = (*(settings.responses or AXIS_RESPONSES[settings.axis]), *INPUT_CHANNELS)
        maneuvers = [undo_instrument_effects(one, model, keep=predicted) for one in maneuvers]
        model = without_swaps(model)
    if motions is None:
        motions = [measured_motion(one, stand_ins=settings.stand_ins) for one in maneuvers]
    wanted = _requested_derivatives(maneuvers, settings)
    unmoved = {
        **_unexcited_derivatives(maneuvers, motions, settings, wanted),
        **_unseen_derivatives(maneuvers, settings, wanted),
    }
    flight_models: dict[int, FlightModel] = {}
    for maneuver in maneuvers:
        key = id(maneuver.aircraft)
        if key not in flight_models:
            flight_models[key] = (
                flight_model_without_aero(maneuver.aircraft)
                if settings.model is None
                else FlightModel(maneuver.aircraft, model)
            )
    names = _global_parameters(
        next(iter(flight_models.values())),
        [name for name in wanted if name not in unmoved],
        settings,
    )
    parts = tuple(
        _build_maneuver_problem(
            maneuver, motion, flight_models[id(maneuver.aircraft)], names, settings, piece
        )
        for maneuver, motion in zip(maneuvers, motions, strict=True)
    )
    remarks = tuple(dict.fromkeys(remark for part in parts for remark in part.remarks))
    return EstimationProblem(names=names, parts=parts, unexcited=unmoved, remarks=remarks)


# --- what is free -------------------------------------------------------------------------------


def _check_maneuver(maneuver: Maneuver) -> None:
    where = f"maneuver {maneuver.id} of '{maneuver.flight}'"
    if not (math.isfinite(maneuver.mass) and maneuver.mass > 0.0):
        raise FlightError(
            f"{where} has a mass of {maneuver.mass:g} kg; write the take-off weight into "
            "flight.toml or the aircraft file"
        )
    check_sample_count(maneuver)


def _requested_derivatives(maneuvers: Sequence[Maneuver], settings: MLSettings) -> tuple[str, ...]:
    inputs = {name for maneuver in maneuvers for name in maneuver.inputs}
    if settings.free is not None:
        wanted = settings.free
        known = axis_derivatives("both")
        unknown = [name for name in wanted if name not in known]
        if unknown:
            hint = did_you_mean(unknown[0], known, "parameters of effects belong in free_effects")
            raise UnknownNameError(f"'{unknown[0]}' is not a derivative; {hint}")
    else:
        wanted = free_derivatives(settings.axis, inputs)
    return tuple(name for name in wanted if name not in settings.held)


def _unexcited_derivatives(
    maneuvers: Sequence[Maneuver],
    motions: Sequence[MeasuredMotion],
    settings: MLSettings,
    wanted: Sequence[str],
) -> dict[str, str]:
    """Return the derivatives of surfaces that did not move, each with why."""
    found = {}
    for surface in AXIS_SURFACES[settings.axis]:
        names = [name for name in wanted if name.endswith(f"_{surface}")]
        if not names or any(
            _is_excited(motion.input(surface)) and surface in motion.measured for motion in motions
        ):
            continue
        why = (
            f"{surface} does not move in "
            f"{'this maneuver' if len(maneuvers) == 1 else 'any of these maneuvers'}"
        )
        if not any(surface in motion.measured for motion in motions):
            why = f"{surface} was not measured"
        found.update(dict.fromkeys(names, why))
    return found


def _unseen_derivatives(
    maneuvers: Sequence[Maneuver], settings: MLSettings, wanted: Sequence[str]
) -> dict[str, str]:
    """Return the derivatives that no response shows, each with why.

    The force along x moves the angle of attack by its sine only: all but the same as a little
    normal force, which it would take along.
    """
    weights = settings.joint_weights or {}
    shown = any(
        "ax" in _responses(one, settings, weights.get(one.id, settings.weights))[0]
        or "V" in _states(one, settings)[0]
        for one in maneuvers
    )
    if shown:
        return {}
    why = "no response shows the force along x: a_x is not among them; held as measured or in trim"
    return {name: why for name in wanted if name.startswith("CA_")}


def _is_excited(signal: FloatArray) -> bool:
    """Return whether a signal holds more than white noise and drift below 0.05 degrees."""
    span = float(np.ptp(signal))
    if span < 1e-3:
        return False
    # Second differences hold six times the variance of white noise, and little of motion.
    bends = np.diff(signal, 2)
    noise = float(np.sqrt(np.mean(bends * bends) / 6.0)) if bends.size else 0.0
    width = max(1, signal.size // 50)
    smooth = np.convolve(signal, np.full(width, 1.0 / width), mode="valid")
    return float(np.ptp(smooth)) > max(
        1e-3, ML_ALGORITHM.min_peak_to_noise * noise / math.sqrt(width)
    )


def _global_parameters(
    model: FlightModel, wanted: Sequence[str], settings: MLSettings
) -> GlobalParameters:
    paths = [name for group in model.control_terms.values() for name in path_parameter_names(group)]
    sensors: list[str] = []
    for channel, group in model.sensor_terms.items():
        # What a surface's sensor does acts on the input, as a control path does.
        (paths if channel in INPUT_CHANNELS else sensors).extend(path_parameter_names(group))
    # An effect on a box stands with each of its channels.
    paths, sensors = list(dict.fromkeys(paths)), list(dict.fromkeys(sensors))
    known = (*model.parameter_names, *paths, *sensors)
    for name in (*settings.free_effects, *settings.held, *settings.start):
        if name not in known:
            raise UnknownNameError(
                f"neither the linear build-up nor the model '{model.model.name}' has a parameter "
                f"'{name}'; effects are named <effect id>.<parameter>"
            )
    free = {*wanted, *(name for name in settings.free_effects if name not in settings.held)}
    return GlobalParameters(
        equations=tuple(name for name in model.parameter_names if name in free),
        paths=tuple(name for name in paths if name in free),
        sensors=tuple(name for name in sensors if name in free),
    )


# --- one maneuver -------------------------------------------------------------------------------


def _build_maneuver_problem(
    maneuver: Maneuver,
    motion: MeasuredMotion,
    model: FlightModel,
    names: GlobalParameters,
    settings: MLSettings,
    piece: float | None,
) -> ManeuverProblem:
    remarks = list(motion.remarks)
    weights = (settings.joint_weights or {}).get(maneuver.id, settings.weights)
    responses, dropped = _responses(maneuver, settings, weights)
    remarks += dropped
    if not responses:
        raise FlightError(
            f"maneuver {maneuver.id} of '{maneuver.flight}' has no response to fit: "
            f"{'; '.join(dropped) or 'all are switched off'}"
        )
    states, added = _states(maneuver, settings)
    remarks += added
    parts, cuts = _segments(maneuver, motion, settings, piece)
    remarks += cuts
    lost = _missing_input_samples(motion, settings)
    if "V" not in states:
        motion = _with_smoothed_airspeed(motion, maneuver.dt, _airspeed_cutoff(settings, names))
    base = _base_parameters(maneuver, motion, model, names, settings)
    kernel = _kernel(model, settings, states, responses, names)
    engine = TrajectorySolver(kernel, settings.integration)

    measured = np.array([maneuver.samples(name) for name in responses])
    counted = np.isfinite(measured) & ~lost
    if not counted.any(axis=1).all():
        empty = ", ".join(
            name for name, row in zip(responses, counted, strict=True) if not row.any()
        )
        raise FlightError(
            f"maneuver {maneuver.id} of '{maneuver.flight}': no sample of {empty} counts, because "
            "inputs are missing wherever it was measured; widen the cut or switch it off"
        )
    held_attitude = [
        name for name in states if name in ("phi", "theta") and name not in motion.measured
    ]
    initial = tuple(
        row
        for row, name in enumerate(states)
        if settings.initial_states and name not in held_attitude and piece is None
    )
    biases, scales, shifts = (
        tuple(responses.index(name) for name in chosen if name in responses)
        for chosen in (
            DEFAULT_BIASES[settings.axis] if settings.biases is None else settings.biases,
            settings.scale_factors,
            settings.time_shifts,
        )
    )
    problem = ManeuverProblem(
        maneuver=maneuver,
        dt=maneuver.dt,
        motion=motion,
        model=model,
        trajectory_solver=engine,
        names=names,
        base=base,
        parameter_indices=[model.parameter_names.index(name) for name in names.equations],
        responses=responses,
        segments=[],
        weights=weights,
        local_names=(),
        local_start=np.empty(0),
        initial=initial,
        fixed_initial=[],
        biases=biases,
        scales=scales,
        shifts=shifts,
        remarks=tuple(remarks),
        control_paths=_held_paths(model.control_terms, settings),
        sensor_paths=_held_paths(model.sensor_terms, settings),
    )
    inputs, by_path = problem.effective_inputs(_model_start_values(names, model, settings))
    rows = [POLAR_STATES.index(name) for name in states]
    for part in parts:
        drives = build_segment_forcing(
            kernel,
            motion.states.T[:, part],
            inputs[:, part],
            by_path[:, :, part] if names.paths else None,
            base,
        )
        guess = motion.states.T[rows][:, part]
        extra = len(kernel.state_names) - len(rows)
        if extra:
            full = list(motion.states.T[:, part])
            settled = model.steady_states(full, list(inputs[:, part]))
            guess = np.vstack([guess, *(np.broadcast_to(x, guess.shape[1:]) for x in settled)])
        problem.segments.append(
            ManeuverSegment(
                sample_slice=part,
                measured=np.where(counted[:, part], np.nan_to_num(measured[:, part]), 0.0),
                valid=counted[:, part],
                complete=bool(counted[:, part].all()),
                forcing=drives,
                x=np.ascontiguousarray(guess),
            )
        )
        first = guess[: len(rows), : ML_ALGORITHM.initial_state_samples].mean(axis=1)
        for row, name in enumerate(states):
            if name in held_attitude:
                first[row] = guess[row, 0]
        problem.fixed_initial.append(first)
    _name_locals(problem, states)
    return problem


def _name_locals(problem: ManeuverProblem, states: Sequence[str]) -> None:
    names, start = [], []
    for index, first in enumerate(problem.fixed_initial):
        tail = f".{index + 1}" if index else ""
        for row in problem.initial:
            names.append(f"{problem.id}.initial.{states[row]}{tail}")
            start.append(float(first[row]))
    for kind, rows, neutral in (
        ("bias", problem.biases, 0.0),
        ("scale", problem.scales, 1.0),
        ("shift", problem.shifts, 0.0),
    ):
        names += [f"{problem.id}.{kind}.{problem.responses[row]}" for row in rows]
        start += [neutral] * len(rows)
    problem.local_names = tuple(names)
    problem.local_start = np.array(start)


def _model_start_values(
    names: GlobalParameters, model: FlightModel, settings: MLSettings
) -> FloatArray:
    known = model_parameter_values(model)
    known.update(settings.start)
    return np.array([known[name] for name in names.all], dtype=np.float64)


def model_parameter_values(model: FlightModel) -> dict[str, float]:
    """Return the values of all parameters in a model, paths included, by name."""
    known = dict(zip(model.parameter_names, model.defaults, strict=True))
    for group in (*model.control_terms.values(), *model.sensor_terms.values()):
        for term, values in group:
            for item, value in zip(term.parameters, values, strict=True):
                known[f"{term.id}.{item.name}"] = value
    return known


def _held_paths(paths: Mapping[str, PathTerms], settings: MLSettings) -> dict[str, PathTerms]:
    """Return paths with the values that the settings hold."""

    def held(term: SignalTerm, values: tuple[float, ...]) -> tuple[float, ...]:
        return tuple(
            settings.held.get(f"{term.id}.{item.name}", value)
            for item, value in zip(term.parameters, values, strict=True)
        )

    return {
        name: tuple((term, held(term, values)) for term, values in path)
        for name, path in paths.items()
    }


def _kernel(
    model: FlightModel,
    settings: MLSettings,
    states: tuple[str, ...],
    responses: tuple[str, ...],
    names: GlobalParameters,
) -> Kernel:
    if not names.paths:
        lean = build_axis_kernel(model, settings.axis, states, responses, names.equations)
        if lean is not None:
            return lean
    return GeneralKernel(model, states, responses, names.equations, names.paths)


def _states(maneuver: Maneuver, settings: MLSettings) -> tuple[tuple[str, ...], list[str]]:
    left = settings.measured_inputs
    if settings.states is not None:
        kept = [name for name in POLAR_STATES if name in settings.states and name not in left]
        return tuple(kept), []
    usual = tuple(name for name in AXIS_STATES[settings.axis] if name not in left)
    missing = [name for name in ("phi", "theta") if not maneuver.has(name) and name not in usual]
    # Longitudinal motion hardly depends on bank, lateral motion hardly on pitch.
    asked = {"lon": ("theta",), "lat": ("phi",), "both": ()}[settings.axis]
    joined = [name for name in missing if name in asked and name not in left]
    remarks = [f"{name} was not measured; it is computed with the other states" for name in joined]
    return (*usual, *joined), remarks


def _responses(
    maneuver: Maneuver, settings: MLSettings, weights: Mapping[str, float] | None
) -> tuple[tuple[str, ...], list[str]]:
    kept, remarks = [], []
    integrated, _ = _states(maneuver, settings)
    for name in settings.responses or AXIS_RESPONSES[settings.axis]:
        if name in POLAR_STATES and name not in integrated:
            # As a response it would be compared with itself.
            remarks.append(f"{name} is a measured input and is excluded from the responses")
            continue
        samples = maneuver.samples(name)
        finite = samples[np.isfinite(samples)]
        if weights is not None and not weights.get(name, 0.0) > 0.0:
            continue
        if not finite.size:
            remarks.append(f"{name} was not measured and is excluded from the responses")
        elif not np.ptp(finite) > 0.0:
            remarks.append(
                f"{name} stays at {float(finite[0]):g} throughout (a stuck sensor?) and is "
                "excluded from the responses"
            )
        else:
            kept.append(name)
    return tuple(kept), remarks


def _base_parameters(
    maneuver: Maneuver,
    motion: MeasuredMotion,
    model: FlightModel,
    names: GlobalParameters,
    settings: MLSettings,
) -> FloatArray:
    """Return all parameters of the equations: the model's, those held, forces as measured.

    The force coefficients of the other axis enter the flow angles' equations. Unless somebody
    gave them, they are fitted to the measured accelerations.
    """
    values = np.array(model.defaults, dtype=np.float64)
    given = {*settings.held, *model.model.derivatives, *names.equations}
    own = AXIS_COEFFICIENTS[settings.axis]
    for coefficient in ("CN", "CA", "CY"):
        known = any(name.startswith(f"{coefficient}_") for name in given)
        # Of the own axis only the force along x is held, where no response shows it.
        if known or (coefficient in own and coefficient != "CA"):
            continue
        bias, slope = _measured_force(coefficient, maneuver, motion)
        first = model.parameter_names.index(f"{coefficient}_0")
        values[first : first + 2] = bias, slope
    for name, value in settings.held.items():
        if name in model.parameter_names:
            values[model.parameter_names.index(name)] = value
    return values


def _measured_force(
    coefficient: str, maneuver: Maneuver, motion: MeasuredMotion
) -> tuple[float, float]:
    """Return bias and slope (by alpha, or beta) of a force coefficient as the accelerometer saw."""
    aircraft = maneuver.aircraft
    qS = motion.qbar * aircraft.geometry.wing_area
    mass = motion.input("mass")
    channel = {"CN": "an", "CA": "ax", "CY": "ay"}[coefficient]
    shown = maneuver.samples(channel)
    phi, theta = motion.state("phi"), motion.state("theta")
    good = np.isfinite(shown)
    if not good.any():
        # Steady flight in trim.
        level = np.cos(theta) / np.cos(phi) if coefficient == "CN" else np.zeros_like(theta)
        shown, good = GRAVITY * level, np.ones(shown.size, dtype=bool)
    if coefficient == "CA":
        V, rho, throttle = motion.state("V"), motion.input("rho"), motion.input("throttle")
        value = (thrust(aircraft, throttle, rho, V) - mass * shown) / qS
    else:
        value = mass * shown / qS
    flow = motion.state("beta" if coefficient == "CY" else "alpha")[good]
    about = flow.mean()
    spread = float(((flow - about) ** 2).sum())
    mean = float(value[good].mean())
    if spread < 1e-6 * good.sum():
        return mean, 0.0
    slope = float(((flow - about) * (value[good] - mean)).sum()) / spread
    return mean - slope * float(about), slope


def _airspeed_cutoff(settings: MLSettings, names: GlobalParameters) -> float:
    if settings.airspeed_cutoff is not None:
        return settings.airspeed_cutoff
    shifts = settings.time_shifts or any(name.endswith(".delay") for name in names.sensors)
    return ML_ALGORITHM.airspeed_cutoff if shifts else math.inf


def _with_smoothed_airspeed(motion: MeasuredMotion, dt: float, cutoff: float) -> MeasuredMotion:
    """Return the motion with airspeed and density low-passed, no lag, from gap to gap in time."""
    if math.isinf(cutoff):
        return motion
    filtering = build_smoother(dt, cutoff)
    reach = filtering.half_width
    states, inputs = motion.states.copy(), motion.inputs.copy()
    speed, density = POLAR_STATES.index("V"), MODEL_INPUTS.index("rho")
    breaks = np.flatnonzero(np.diff(motion.times) > 2.5 * dt) + 1
    for first, last in pairwise((0, *breaks.tolist(), len(states))):
        if last - first <= reach:
            continue
        signals = np.column_stack((states[first:last, speed], inputs[first:last, density]))
        # Point reflection at the ends keeps slopes there.
        before = 2.0 * signals[0] - signals[reach:0:-1]
        after = 2.0 * signals[-1] - signals[-2 : -reach - 2 : -1]
        smooth = filtering.smooth(np.concatenate((before, signals, after)))[reach:-reach]
        states[first:last, speed] = smooth[:, 0]
        inputs[first:last, density] = smooth[:, 1]
    return replace(motion, states=states, inputs=inputs)


def _missing_input_samples(motion: MeasuredMotion, settings: MLSettings) -> BoolArray:
    """Return the samples at which an input that matters was missing, shape (n,)."""
    matters = {"lon": (), "lat": ("alpha", "q"), "both": ()}[settings.axis]
    lost = np.zeros(len(motion.times), dtype=bool)
    for name in (*AXIS_SURFACES[settings.axis], *matters):
        if name in motion.interpolated:
            lost |= motion.interpolated[name]
    return lost


def _segments(
    maneuver: Maneuver, motion: MeasuredMotion, settings: MLSettings, piece: float | None
) -> tuple[list[slice], list[str]]:
    """Return the stretches without a gap in time or in an input of the axis."""
    times, dt = motion.times, maneuver.dt
    good = np.ones(times.size, dtype=bool)
    remarks = []
    for surface in AXIS_SURFACES[settings.axis]:
        for gap in (
            contiguous_slices(motion.interpolated[surface])
            if surface in motion.interpolated
            else ()
        ):
            if (gap.stop - gap.start) * dt > ML_ALGORITHM.max_input_gap:
                good[gap] = False
                remarks.append(
                    f"{surface} is missing from {times[gap.start]:.2f} to "
                    f"{times[gap.stop - 1]:.2f} s; the fit continues after it with new initial "
                    "states"
                )
    breaks = np.flatnonzero(np.diff(times) > 2.5 * dt) + 1
    parts = []
    for run in contiguous_slices(good):
        edges = [run.start, *(int(b) for b in breaks if run.start < b < run.stop), run.stop]
        parts += [slice(a, b) for a, b in pairwise(edges)]
    if breaks.size:
        remarks.append(f"{breaks.size} gap(s) in time split maneuver {maneuver.id}")
    kept = [
        part for part in parts if (part.stop - part.start) * dt >= ML_ALGORITHM.min_segment_duration
    ]
    if not kept:
        raise FlightError(
            f"maneuver {maneuver.id} of '{maneuver.flight}' has no stretch of "
            f"{ML_ALGORITHM.min_segment_duration:g} s without a gap in "
            f"{' or '.join(AXIS_SURFACES[settings.axis])}; "
            "widen the cut"
        )
    if piece is not None:
        length = max(10, round(piece / dt))
        kept = [
            slice(start, min(start + length, part.stop))
            for part in kept
            for start in range(part.start, part.stop - length // 2, length)
        ]
    return kept, remarks

"""From maneuvers to a solution: start values, the fit, and what to do when the model diverges."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from gsapp.foundation import FlightError
from gsapp.identification import equation_error
from gsapp.identification.channel_faults import suspicious_signs, unmeasured_surfaces
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.maximum_likelihood.problem import EstimationProblem
from gsapp.identification.maximum_likelihood.problem_builder import (
    build_problem,
    model_parameter_values,
)
from gsapp.identification.maximum_likelihood.settings import (
    ML_ALGORITHM,
    FitProgressCallback,
    MLSettings,
)
from gsapp.identification.maximum_likelihood.solution import MLSolution, build_solution
from gsapp.identification.maximum_likelihood.solver import DivergedError, Solver, SolverResult
from gsapp.identification.memory_allocator import retain_freed_memory
from gsapp.identification.results import ResponseHistory
from gsapp.quantities import FloatArray

TYPICAL_DERIVATIVES: Mapping[str, float] = {
    "CN_alpha": 4.5,
    "CN_q": 5.0,
    "CN_de": 0.4,
    "CA_0": 0.04,
    "Cm_alpha": -0.5,
    "Cm_q": -15.0,
    "Cm_de": -1.0,
    "CY_beta": -0.6,
    "CY_r": 0.3,
    "CY_dr": 0.15,
    "Cl_beta": -0.1,
    "Cl_p": -0.5,
    "Cl_r": 0.15,
    "Cl_da": 0.2,
    "Cn_beta": 0.1,
    "Cn_p": -0.05,
    "Cn_r": -0.2,
    "Cn_da": 0.0,
    "Cn_dr": -0.08,
}
"""A usual aircraft: starts what neither the data nor the user can start."""


def fit(
    maneuvers: Sequence[Maneuver],
    settings: MLSettings,
    *,
    progress: FitProgressCallback | None = None,
    values_only: bool = False,
) -> MLSolution:
    """Fit one maneuver, or several together, and keep everything; arguments as `estimate`."""
    if not maneuvers:
        raise FlightError("no maneuver to estimate from; name at least one")
    retain_freed_memory()
    problem = build_problem(maneuvers, settings)
    solver = Solver(problem, settings, progress)
    _check_sample_count(problem, solver)
    solved = _solve_or_restart(maneuvers, settings, problem, solver)
    solution = build_solution(problem, solver, solved, settings, values_only=values_only)
    if values_only:
        return solution
    signs = suspicious_signs(solution.estimate)
    unseen = any(
        True
        for maneuver in maneuvers
        for _ in unmeasured_surfaces(maneuver, settings.axis, settings.stand_ins)
    )
    if solution.fits_badly and not unseen:
        # A reversed channel bends the whole fit; equation error shows where it sits.
        signs = _equation_error_sign_warnings(maneuvers, settings, problem) or signs
    warnings = tuple(dict.fromkeys((*signs, *solution.estimate.warnings)))
    return replace(solution, estimate=replace(solution.estimate, warnings=warnings))


def _solve_or_restart(
    maneuvers: Sequence[Maneuver],
    settings: MLSettings,
    problem: EstimationProblem,
    solver: Solver,
) -> SolverResult:
    if settings.start.keys() >= set(_linear_derivatives(problem)):
        # Nothing is left that equation error could start.
        with contextlib.suppress(DivergedError):
            return solver.solve(initial_unknowns(problem, settings, {}))
    quick = equation_error_values(maneuvers, settings, problem)
    unbiased = settings.with_changes(start={})
    for chosen, values in ((settings, quick), (unbiased, quick), (unbiased, {})):
        try:
            return solver.solve(initial_unknowns(problem, chosen, values))
        except DivergedError:
            continue
    return _fit_in_pieces(maneuvers, settings, problem, solver, quick)


def _linear_derivatives(problem: EstimationProblem) -> list[str]:
    return [name for name in problem.names.equations if "." not in name]


def equation_error_values(
    maneuvers: Sequence[Maneuver], settings: MLSettings, problem: EstimationProblem
) -> Mapping[str, float]:
    """Return start values by equation error; none where it fails."""
    try:
        return equation_error.estimate_start_values(
            maneuvers,
            _linear_derivatives(problem),
            held=settings.held,
            stand_ins=settings.stand_ins,
            model=settings.model,
            motions=[part.motion for part in problem.parts],
        )
    except FlightError:
        return {}


def initial_unknowns(
    problem: EstimationProblem, settings: MLSettings, found: Mapping[str, float]
) -> FloatArray:
    """Return the unknowns to start from.

    Those of the settings come first, then equation error, the model file, a usual aircraft.
    """
    model = problem.parts[0].model
    known = model_parameter_values(model)
    given = {*model.model.derivatives} if settings.model is not None else set()
    shared = []
    for name in problem.names.all:
        value = settings.start.get(name, found.get(name))
        if value is None:
            usual = "." not in name and name not in given
            value = TYPICAL_DERIVATIVES.get(name, 0.0) if usual else known[name]
        shared.append(value)
    local = [part.local_start for part in problem.parts]
    return np.concatenate((np.array(shared, dtype=np.float64), *local))


def _check_sample_count(problem: EstimationProblem, solver: Solver) -> None:
    unknowns = problem.unknowns
    samples = solver.samples
    if samples < ML_ALGORITHM.min_samples_per_unknown * len(unknowns):
        raise FlightError(
            f"{samples} samples count, too few for {len(unknowns)} unknowns; widen the cut, or "
            "hold some derivatives"
        )


def _fit_in_pieces(
    maneuvers: Sequence[Maneuver],
    settings: MLSettings,
    problem: EstimationProblem,
    solver: Solver,
    quick: Mapping[str, float],
) -> SolverResult:
    """Fit pieces short enough not to diverge, each started from measurement; then the whole."""
    unbiased = settings.with_changes(start={})
    start = initial_unknowns(problem, unbiased, quick)
    count = len(problem.names.all)
    shared, local = start[:count], start[count:]
    for growth in (1.0, 2.0, 4.0):
        pieces = build_problem(
            maneuvers,
            settings,
            piece=growth * settings.restart,
            motions=[part.motion for part in problem.parts],
        )
        own = np.concatenate([part.local_start for part in pieces.parts])
        try:
            solved = Solver(pieces, settings).solve(np.concatenate((shared, own)))
        except DivergedError:
            break
        shared = solved.point.unknowns[:count]
        try:
            return solver.solve(np.concatenate((shared, local)))
        except DivergedError:
            continue
    signs = _equation_error_sign_warnings(maneuvers, settings, problem)
    why = "; ".join(signs) or "its derivatives give a strongly unstable aircraft"
    raise FlightError(
        f"the model diverges over maneuver {', '.join(part.id for part in problem.parts)}: {why}; "
        "check signs and calibration, give start values, or use equation error"
    )


def _equation_error_sign_warnings(
    maneuvers: Sequence[Maneuver], settings: MLSettings, problem: EstimationProblem
) -> tuple[str, ...]:
    """Return what looks reversed to equation error, which does not integrate."""
    try:
        found = equation_error.estimate(
            maneuvers,
            settings.axis,
            free=_linear_derivatives(problem),
            held=settings.held,
            stand_ins=settings.stand_ins,
            model=settings.model,
            motions=[part.motion for part in problem.parts],
        )
    except (FlightError, np.linalg.LinAlgError):
        return ()
    return suspicious_signs(found)


def simulate(
    maneuver: Maneuver,
    values: Mapping[str, float],
    settings: MLSettings,
    *,
    nuisance: Mapping[str, float] | None = None,
    fit_nuisance: bool = False,
) -> ResponseHistory:
    """Compute the responses of a maneuver with given parameters.

    Parameters
    ----------
    values : mapping of str to float
        Derivatives and parameters of effects; what is left out takes the model's value.
    settings : MLSettings
        Axis, states, responses, model, integration and stand-ins.
    nuisance : mapping of str to float, optional
        Initial states, biases, scale factors, time shifts by their names in `Estimate.nuisance`.
        By default the motion starts as measured, with no bias.
    fit_nuisance : bool
        Fit those that `nuisance` leaves out, with all parameters held: a prediction is then not
        judged by the noise of its first sample.

    Raises
    ------
    FlightError
        If the motion diverges.
    """
    held = settings.with_changes(
        free=(), free_effects=(), start={}, held={**settings.held, **values}
    )
    problem = build_problem([maneuver], held)
    part = problem.parts[0]
    unknowns = part.local_start.copy()
    for name, value in (nuisance or {}).items():
        if name in part.local_names:
            unknowns[part.local_names.index(name)] = value
    solver = Solver(problem, settings)
    if fit_nuisance and unknowns.size:
        solver.solve(unknowns)
    else:
        if solver.evaluate(unknowns) is None:
            raise DivergedError(
                f"the computed motion of maneuver {maneuver.id} diverges with these parameters"
            )
        part.accept_trial()
    measured = [np.where(one.valid, one.measured, np.nan) for one in part.segments]
    return ResponseHistory(
        maneuver=maneuver.id,
        times=np.concatenate([part.motion.times[one.sample_slice] for one in part.segments]),
        channels=part.responses,
        measured=np.concatenate(measured, axis=1).T,
        computed=np.concatenate([np.asarray(one.y) for one in part.segments], axis=1).T,
    )

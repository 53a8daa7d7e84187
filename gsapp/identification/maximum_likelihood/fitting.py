"""From maneuvers to a solution: start values, the fit, and what to do when the model diverges."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from gsapp.foundation import FlightError
from gsapp.identification import equation_error
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.maximum_likelihood.layout import known_values, lay_out
from gsapp.identification.maximum_likelihood.problem import Problem
from gsapp.identification.maximum_likelihood.settings import Callback, MLSettings
from gsapp.identification.maximum_likelihood.solution import Solution, conclude
from gsapp.identification.maximum_likelihood.solver import DivergedError, Solved, Solver
from gsapp.identification.memory import keep_memory
from gsapp.identification.results import ResponseHistory
from gsapp.identification.signs import suspicious_signs
from gsapp.identification.stuck import unseen_surfaces
from gsapp.quantities import FloatArray

USUAL: Mapping[str, float] = {
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
    maneuvers: Sequence[Maneuver], settings: MLSettings, *, progress: Callback | None = None
) -> Solution:
    """Fit one maneuver, or several together, and keep everything; arguments as `estimate`."""
    if not maneuvers:
        raise FlightError("there is no maneuver to estimate from; name at least one")
    keep_memory()
    problem = lay_out(maneuvers, settings)
    solver = Solver(problem, settings, progress)
    _check_size(problem, solver)
    quick = _by_equation_error(maneuvers, settings, problem)
    solved = _solved(maneuvers, settings, problem, solver, quick)
    solution = conclude(problem, solver, solved, settings)
    signs = suspicious_signs(solution.estimate)
    unseen = any(
        True
        for maneuver in maneuvers
        for _ in unseen_surfaces(maneuver, settings.axis, settings.stand_ins)
    )
    if solution.fits_badly and not unseen:
        # A reversed channel bends the whole fit; equation error shows where it sits.
        signs = _signs_by_equation_error(maneuvers, settings, problem) or signs
    warnings = tuple(dict.fromkeys((*signs, *solution.estimate.warnings)))
    return replace(solution, estimate=replace(solution.estimate, warnings=warnings))


def _solved(
    maneuvers: Sequence[Maneuver],
    settings: MLSettings,
    problem: Problem,
    solver: Solver,
    quick: Mapping[str, float],
) -> Solved:
    unbiased = replace(settings, start={})
    for chosen, values in ((settings, quick), (unbiased, quick), (unbiased, {})):
        try:
            return solver.solve(start_values(problem, chosen, values))
        except DivergedError:
            continue
    return _in_pieces(maneuvers, settings, problem, solver, quick)


def _linear(problem: Problem) -> list[str]:
    return [name for name in problem.names.equations if "." not in name]


def _by_equation_error(
    maneuvers: Sequence[Maneuver], settings: MLSettings, problem: Problem
) -> Mapping[str, float]:
    try:
        return equation_error.start_values(
            maneuvers,
            _linear(problem),
            held=settings.held,
            stand_ins=settings.stand_ins,
            model=settings.model,
            motions=[part.motion for part in problem.parts],
        )
    except FlightError:
        return {}


def start_values(problem: Problem, settings: MLSettings, found: Mapping[str, float]) -> FloatArray:
    """Return the unknowns to start from.

    Those of the settings come first, then equation error, the model file, a usual aircraft.
    """
    model = problem.parts[0].model
    known = known_values(model)
    given = {*model.model.derivatives} if settings.model is not None else set()
    shared = []
    for name in problem.names.all:
        value = settings.start.get(name, found.get(name))
        if value is None:
            usual = "." not in name and name not in given
            value = USUAL.get(name, 0.0) if usual else known[name]
        shared.append(value)
    local = [part.local_start for part in problem.parts]
    return np.concatenate((np.array(shared, dtype=np.float64), *local))


def _check_size(problem: Problem, solver: Solver) -> None:
    unknowns = problem.unknowns
    samples = solver.samples
    if samples < 4 * len(unknowns):
        raise FlightError(
            f"{samples} samples count, too few for {len(unknowns)} unknowns; widen the cut, or "
            "hold some derivatives"
        )


def _in_pieces(
    maneuvers: Sequence[Maneuver],
    settings: MLSettings,
    problem: Problem,
    solver: Solver,
    quick: Mapping[str, float],
) -> Solved:
    """Fit pieces short enough not to diverge, each started from measurement; then the whole."""
    unbiased = replace(settings, start={})
    start = start_values(problem, unbiased, quick)
    count = len(problem.names.all)
    shared, local = start[:count], start[count:]
    for growth in (1.0, 2.0, 4.0):
        pieces = lay_out(
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
    signs = _signs_by_equation_error(maneuvers, settings, problem)
    why = "; ".join(signs) or "its derivatives make an aircraft that is far from stable"
    raise FlightError(
        f"the model diverges over maneuver {', '.join(part.id for part in problem.parts)}: {why}; "
        "check signs and calibration, give start values, or use equation error"
    )


def _signs_by_equation_error(
    maneuvers: Sequence[Maneuver], settings: MLSettings, problem: Problem
) -> tuple[str, ...]:
    """Return what looks reversed to equation error, which does not integrate."""
    try:
        found = equation_error.estimate(
            maneuvers,
            settings.axis,
            free=_linear(problem),
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
    maneuver : Maneuver
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
    held = replace(settings, free=(), free_effects=(), start={}, held={**settings.held, **values})
    problem = lay_out([maneuver], held)
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
        part.accept()
    measured = [np.where(one.counted, one.measured, np.nan) for one in part.segments]
    return ResponseHistory(
        maneuver=maneuver.id,
        times=np.concatenate([part.motion.times[one.part] for one in part.segments]),
        channels=part.responses,
        measured=np.concatenate(measured, axis=1).T,
        computed=np.concatenate([np.asarray(one.y) for one in part.segments], axis=1).T,
    )

"""What a fit leaves behind: residuals, sensitivities, bounds, and the estimate made from them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gsapp.identification.axes import axis_derivatives
from gsapp.identification.channel_faults import (
    unmeasured_surfaces,
    unmeasured_surfaces_text,
    withhold_values,
)
from gsapp.identification.maximum_likelihood.problem import EstimationProblem, ManeuverProblem
from gsapp.identification.maximum_likelihood.settings import ML_ALGORITHM, MLSettings
from gsapp.identification.maximum_likelihood.solver import Solver, SolverResult, prior_warnings
from gsapp.identification.results import DerivativeEstimate, Estimate, ResponseFit, ResponseHistory
from gsapp.identification.statistics import (
    Identifiability,
    ParameterVerdict,
    TurbulenceDetection,
    Whiteness,
    assess_identifiability,
    correlation_warning,
    detect_turbulence,
    evaluate_whiteness,
    joint_covariance,
    response_fit,
)
from gsapp.identification.statistics import ManeuverFitData as BoundsPart
from gsapp.identification.statistics.bounds import invert_information
from gsapp.identification.statistics.influence import influence_warnings, response_influences
from gsapp.quantities import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ManeuverResiduals:
    """One maneuver of a solution."""

    maneuver: str
    times: FloatArray  # Shape (n,). s; only samples of its segments.
    responses: tuple[str, ...]
    measured: FloatArray
    computed: FloatArray
    """Shape (n, n_responses). NaN in `measured` where a sample does not count."""
    weights: FloatArray
    """Shape (n_responses, n_responses). W: the inverse of the noise covariance; where the user gave
    weights, those, scaled to the noise there is."""
    segments: tuple[slice, ...]  # Stretches of contiguous samples.
    sensitivities: FloatArray  # Shape (n, n_responses, n_columns).
    columns: np.ndarray[tuple[int], np.dtype[np.intp]]
    """Shape (n_columns,). Where each column stands among the solution's `names`."""
    whiteness: tuple[Whiteness, ...]  # Of the residuals of each response.

    @property
    def residuals(self) -> FloatArray:
        """Return measured minus computed, NaN where a sample does not count."""
        return self.measured - self.computed

    @property
    def bounds_part(self) -> BoundsPart:
        """Return what bounds are made from."""
        return BoundsPart(
            S=self.sensitivities,
            v=self.residuals,
            W=self.weights,
            columns=self.columns,
            segments=None if len(self.segments) == 1 else self.segments,
        )


def detect_gusts(one: ManeuverProblem, part: ManeuverResiduals) -> list[TurbulenceDetection]:
    """Return the gusts that the residuals of a maneuver show."""
    sensors = one.maneuver.aircraft.sensors
    found = detect_turbulence(
        dict(zip(part.responses, part.residuals.T, strict=True)),
        dt=one.dt,
        V=float(one.motion.state("V").mean()),
        alpha=float(one.motion.state("alpha").mean()),
        arms=(sensors.alpha_vane.position[0], sensors.beta_vane.position[0]),
        segments=None if len(part.segments) == 1 else part.segments,
    )
    return [gust for gust in found if gust.detected]


def color_warnings(part: ManeuverResiduals) -> list[str]:
    """Return which residuals of a maneuver are far from white, in a sentence."""
    colored = _colored_responses(part)
    if not colored:
        return []
    text = ", ".join(f"{name} ({inflation:.0f} times)" for name, inflation in colored.items())
    found = [
        f"the residuals of {text} in maneuver {part.maneuver} are colored (excess power at low "
        "frequency); the bounds account for it"
    ]
    followed = {name: _averaged_r2(part, part.responses.index(name)) for name in colored}
    missed = [
        f"{name} (R2 {share:.2f})"
        for name, share in followed.items()
        if share < ML_ALGORITHM.min_response_r2
    ]
    if missed:
        found.append(
            f"the model does not follow {', '.join(missed)} in maneuver {part.maneuver}, which "
            "no bound includes: first rule out gusts, a wrong unit or sign of an instrument "
            "('gsapp compatibility') and wrong values in the aircraft file"
        )
    return found


def _averaged_r2(part: ManeuverResiduals, column: int) -> float:
    """Return R2 of a response, measured and computed averaged against their noise."""
    rows = max(
        1, round(ML_ALGORITHM.r2_averaging * (len(part.times) - 1) / float(np.ptp(part.times)))
    )
    starts = np.arange(0, len(part.times), rows)
    counted = np.isfinite(part.measured[:, column])
    counts = np.maximum(np.add.reduceat(counted.astype(np.float64), starts), 1.0)
    measured, computed = (
        np.add.reduceat(np.where(counted, samples[:, column], 0.0), starts) / counts
        for samples in (part.measured, part.computed)
    )
    known = np.add.reduceat(counted, starts) > 0
    return response_fit(measured[known], computed[known]).r2


def unmeasured_input_warning(
    one: ManeuverProblem, part: ManeuverResiduals, settings: MLSettings
) -> str:
    """Return that a surface moved which nobody saw, or nothing.

    A surface without a record, or with a stuck one, is taken as still. Where it was not, its
    share goes into the derivatives of all others, with bounds that know nothing of it.
    """
    colored = _colored_responses(part)
    unseen = dict(unmeasured_surfaces(one.maneuver, settings.axis, settings.stand_ins))
    if not colored or not unseen:
        return ""
    return unmeasured_surfaces_text(
        unseen, f"and the residuals of {', '.join(colored)} contain unexplained motion"
    )


def _colored_responses(part: ManeuverResiduals) -> dict[str, float]:
    """Return the responses with residuals far from white, with the inflation of each."""
    return {
        name: test.inflation
        for name, test in zip(part.responses, part.whiteness, strict=True)
        if not test.white and test.inflation > ML_ALGORITHM.colored_power_ratio
    }


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MLSolution:
    """A finished fit with all that bounds, tests and predictions need."""

    settings: MLSettings
    names: tuple[str, ...]
    """All unknowns: derivatives, parameters of effects, then initial states, biases, scale factors
    and time shifts of each maneuver."""
    values: FloatArray  # Shape (n_names,).
    information: FloatArray  # Shape (n_names, n_names). sum S'WS, plus W2.
    covariance: FloatArray
    cramer_rao: FloatArray
    """Shape (n_names, n_names). Honest, and uncorrected. Infinite variances where the data do not
    see a parameter."""
    parts: tuple[ManeuverResiduals, ...]
    estimate: Estimate

    @property
    def fits_badly(self) -> bool:
        """Return whether the residuals of some response are far from noise."""
        return any(
            not test.white and test.inflation > ML_ALGORITHM.bad_fit_power_ratio
            for part in self.parts
            for test in part.whiteness
        )

    def value(self, name: str) -> float:
        """Return any unknown by its name."""
        return float(self.values[self.names.index(name)])


def build_solution(
    problem: EstimationProblem,
    solver: Solver,
    solved: SolverResult,
    settings: MLSettings,
    *,
    values_only: bool = False,
) -> MLSolution:
    """Make the solution of a solved problem; with `values_only`, uncorrected bounds suffice."""
    weights = solver.weights(solved.point)
    parts = tuple(
        _maneuver_residuals(problem, index, solved, weights[index])
        for index in range(len(problem.parts))
    )
    names = problem.unknowns
    H = solved.information
    plain = invert_information(H)
    prior = np.zeros_like(H)
    for name, (_, std) in settings.priors.items():
        if name in names:
            prior[names.index(name), names.index(name)] = 1.0 / std**2
    data = [part.bounds_part for part in parts]
    if values_only or settings.bound_factor is not None:
        honest = (settings.bound_factor or 1.0) ** 2 * plain
    else:
        honest = joint_covariance(
            data, len(names), lags=settings.lags, prior=prior if settings.priors else None
        )
    estimate = _estimate(problem, solved, parts, H, honest, plain, settings)
    if estimate.converged and settings.noise == "diagonal" and not values_only:
        estimate = _with_influences(estimate, parts, names, prior)
    return MLSolution(
        settings=settings,
        names=names,
        values=solved.point.unknowns,
        information=H,
        covariance=honest,
        cramer_rao=plain,
        parts=parts,
        estimate=estimate,
    )


def _with_influences(
    estimate: Estimate,
    parts: Sequence[ManeuverResiduals],
    names: Sequence[str],
    prior: FloatArray,
) -> Estimate:
    """Return an estimate that says which responses contradict the others."""
    bounds = {
        name: (names.index(name), one.std)
        for name, one in estimate.derivatives.items()
        if one.std and not name.endswith("_0")
    }
    # Without a_x the axial force is held, unless the airspeed is a state.
    axial = [index for index, name in enumerate(names) if name.startswith("CA_")]
    alone = {} if any(".initial.V" in name for name in names) else {"ax": axial}
    found = response_influences(
        [(part.responses, part.bounds_part) for part in parts], bounds, len(names), prior, alone
    )
    return replace(
        estimate, influences=found, warnings=(*estimate.warnings, *influence_warnings(found))
    )


def _maneuver_residuals(
    problem: EstimationProblem, index: int, solved: SolverResult, weights: FloatArray
) -> ManeuverResiduals:
    one = problem.parts[index]
    measured, computed, segments = [], [], []
    start = 0
    for segment in one.segments:
        measured.append(np.where(segment.valid, segment.measured, np.nan))
        computed.append(np.asarray(segment.y))
        segments.append(slice(start, start + segment.measured.shape[1]))
        start = segments[-1].stop
    shown, expected = np.concatenate(measured, axis=1).T, np.concatenate(computed, axis=1).T
    return ManeuverResiduals(
        maneuver=one.id,
        times=np.concatenate([one.motion.times[segment.sample_slice] for segment in one.segments]),
        responses=one.responses,
        measured=shown,
        computed=expected,
        weights=weights,
        segments=tuple(segments),
        sensitivities=np.ascontiguousarray(
            np.concatenate(solved.sensitivities[index], axis=2).transpose(2, 0, 1)
        ),
        columns=np.r_[0 : len(problem.names.all), problem.unknown_indices(index)],
        whiteness=evaluate_whiteness(
            shown - expected, None if len(segments) == 1 else segments, dt=one.dt
        ),
    )


# --- the estimate -------------------------------------------------------------------------------


def _estimate(
    problem: EstimationProblem,
    solved: SolverResult,
    parts: Sequence[ManeuverResiduals],
    H: FloatArray,
    honest: FloatArray,
    plain: FloatArray,
    settings: MLSettings,
) -> Estimate:
    names = problem.unknowns
    shared = problem.names.all
    verdicts = assess_identifiability(H, names, covariance=honest, inverted=plain)
    derivatives: dict[str, DerivativeEstimate] = {}
    first = problem.parts[0]
    held = dict(zip(first.model.parameter_names, first.base, strict=True))
    for name in dict.fromkeys((*axis_derivatives(settings.axis), *shared)):
        if name in problem.unexcited:
            derivatives[name] = DerivativeEstimate(
                value=None, status="unknown", why=problem.unexcited[name]
            )
        elif name not in shared:
            derivatives[name] = DerivativeEstimate(value=float(held[name]), status="held")
        else:
            derivatives[name] = _derivative_estimate(
                name, shared.index(name), solved, honest, plain, verdicts[name]
            )
    free = tuple(name for name in shared if derivatives[name].status == "estimated")
    rows = [shared.index(name) for name in free]
    local = range(len(shared), len(names))
    nuisance = {
        names[row]: (float(solved.point.unknowns[row]), float(np.sqrt(max(honest[row, row], 0.0))))
        for row in local
    }
    found = Estimate(
        method="ml",
        axis=settings.axis,
        maneuvers=tuple(part.maneuver for part in parts),
        derivatives=derivatives,
        free=free,
        covariance=honest[np.ix_(rows, rows)],
        nuisance=nuisance,
        fit=_fits(parts),
        histories=tuple(
            ResponseHistory(
                maneuver=part.maneuver,
                times=part.times,
                channels=part.responses,
                measured=part.measured,
                computed=part.computed,
            )
            for part in parts
        ),
        iterations=solved.iterations,
        converged=solved.converged,
        message=solved.message,
    )
    warnings = [*problem.remarks, *prior_warnings(problem, settings.priors)]
    warnings += _correlation_warnings(verdicts, shared)
    gusty = []
    unseen = ""
    for one, part in zip(problem.parts, parts, strict=True):
        gusts = detect_gusts(one, part)
        warnings += [f"maneuver {part.maneuver}: {gust.warning}" for gust in gusts]
        warnings += color_warnings(part)
        if gusts:
            gusty.append(part.maneuver)
        unseen = unseen or unmeasured_input_warning(one, part, settings)
    found = replace(found, warnings=tuple(dict.fromkeys(warnings)), gusty_maneuvers=tuple(gusty))
    return withhold_values(found, unseen) if unseen else found


def _correlation_warnings(verdicts: Identifiability, shared: Sequence[str]) -> list[str]:
    """Return a sentence on the strongly correlated derivatives, biases left out."""
    pairs = [
        (one, other, correlation)
        for one, other, correlation in verdicts.correlated
        if one in shared and other in shared and not (one + other).count("_0")
    ]
    return [correlation_warning(pairs)] if pairs else []


def _derivative_estimate(
    name: str,
    place: int,
    solved: SolverResult,
    honest: FloatArray,
    plain: FloatArray,
    verdict: ParameterVerdict,
) -> DerivativeEstimate:
    if not solved.converged:
        return DerivativeEstimate(
            value=None, status="unknown", why=f"the fit did not converge: {solved.message}"
        )
    if verdict.status != "estimated":
        return DerivativeEstimate(
            value=None,
            status=verdict.status,
            confounded_with=verdict.confounded_with,
            why=verdict.why,
        )
    std, bound = float(np.sqrt(honest[place, place])), float(np.sqrt(plain[place, place]))
    if not (np.isfinite(std) and np.isfinite(bound)):
        return DerivativeEstimate(
            value=None,
            status="unknown",
            why=f"the responses do not depend on {name} in this maneuver",
        )
    return DerivativeEstimate(value=float(solved.point.unknowns[place]), std=std, cramer_rao=bound)


def _fits(parts: Sequence[ManeuverResiduals]) -> dict[str, ResponseFit]:
    found = {}
    for name in dict.fromkeys(name for part in parts for name in part.responses):
        with_it = [part for part in parts if name in part.responses]
        measured, computed = (
            np.concatenate([getattr(part, what)[:, part.responses.index(name)] for part in with_it])
            for what in ("measured", "computed")
        )
        found[name] = response_fit(measured, computed)
    return found

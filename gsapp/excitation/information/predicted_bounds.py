"""The bounds that an estimate will report for a maneuver, from its information matrix.

In calm air maximum likelihood reports them, in gusts filter error, which takes its place there.

At known parameters no iteration is needed: one pass over the equations gives the motion and its
sensitivities, and with the noise of the responses the bounds follow. Layout, equations and
statistics are those of the fit itself, so that what is expected here is what it reports. The
motion follows from the input alone; what the responses showed is not looked at.
"""

from __future__ import annotations

from collections.abc import Collection, Generator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.dynamics.model import Model
from gsapp.excitation.information.information_matrix import (
    ManeuverInformation,
    marginalize_information,
)
from gsapp.excitation.settings import INFORMATION
from gsapp.foundation import FlightError
from gsapp.identification.axes import AXIS_RESPONSES, Axis, axis_derivatives, free_derivatives
from gsapp.identification.campaign import secondary_input_derivatives
from gsapp.identification.filter_error.estimator import (
    FilterErrorSolution,
    predict_stepwise,
    solve_stepwise,
)
from gsapp.identification.filter_error.noise_model import NoiseModel
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.maximum_likelihood import MLSettings, MLSolution
from gsapp.identification.maximum_likelihood.problem import EstimationProblem
from gsapp.identification.maximum_likelihood.problem_builder import build_problem
from gsapp.identification.maximum_likelihood.solution import build_solution
from gsapp.identification.maximum_likelihood.solver import Solver
from gsapp.identification.statistics import ManeuverFitData as BoundsPart
from gsapp.identification.statistics import (
    covariance_for_known_noise,
    information_matrix,
    noise_autocovariance,
)
from gsapp.identification.statistics.bounds import invert_information
from gsapp.identification.statistics.correlation import STATISTICS, default_lags
from gsapp.quantities import FloatArray

_USUAL_NOISE: Final = {
    **dict.fromkeys(("alpha", "beta"), INFORMATION.vane_noise),
    **dict.fromkeys(("p", "q", "r"), INFORMATION.gyro_noise),
    **dict.fromkeys(("ax", "ay", "an"), INFORMATION.accelerometer_noise),
}
"""Noise of instruments of which the aircraft file says nothing."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ResponseNoise:
    """Noise of some responses, as residuals show it."""

    responses: tuple[str, ...]
    rate: float
    """Samples per second."""
    autocovariance: FloatArray
    """Shape (2 Lg + 1, n_responses, n_responses). Autocovariance, SI; the middle one is that of lag
    0."""
    duration: float
    """Length of the stretches that it was heard in, s; 0 where it is assumed."""

    @property
    def variances(self) -> FloatArray:
        """Return the variance of each response, shape (n_responses,)."""
        return np.asarray(self.autocovariance[len(self.autocovariance) // 2].diagonal())

    def select(self, responses: Sequence[str]) -> ResponseNoise:
        """Return the noise of some of the responses, in this order."""
        places = [self.responses.index(name) for name in responses]
        return ResponseNoise(
            responses=tuple(responses),
            rate=self.rate,
            autocovariance=np.ascontiguousarray(self.autocovariance[:, places][:, :, places]),
            duration=self.duration,
        )

    def autocovariance_to(self, count: int) -> FloatArray:
        """Return the autocovariance to at most so many lags."""
        middle = len(self.autocovariance) // 2
        reach = min(count, middle)
        return self.autocovariance[middle - reach : middle + reach + 1]


def assumed_noise(aircraft: Aircraft, responses: Sequence[str], rate: float) -> ResponseNoise:
    """Return white noise as strong as the aircraft file says of its instruments.

    That is what there is before anything was heard in flight: gusts are not in it.
    """
    stated = aircraft.sensors.noise_in_flight
    stds = [stated[name] or _USUAL_NOISE[name] for name in responses]
    lagged = np.zeros((2 * STATISTICS.max_lags + 1, len(stds), len(stds)))
    lagged[STATISTICS.max_lags] = np.diag(np.square(stds))
    return ResponseNoise(responses=tuple(responses), rate=rate, autocovariance=lagged, duration=0.0)


def pool_noise(heard: Sequence[ResponseNoise]) -> ResponseNoise:
    """Return the mean over stretches of the same responses, each by its length.

    Far lags come from those stretches that were long enough to show them.
    """
    reach = max(len(one.autocovariance) // 2 for one in heard)
    total = np.zeros_like(max(heard, key=lambda one: len(one.autocovariance)).autocovariance)
    weights = np.zeros(2 * reach + 1)
    for one in heard:
        own = len(one.autocovariance) // 2
        part = slice(reach - own, reach + own + 1)
        total[part] += one.duration * one.autocovariance
        weights[part] += one.duration
    return ResponseNoise(
        responses=heard[0].responses,
        rate=heard[0].rate,
        autocovariance=total / weights[:, None, None],
        duration=float(weights[reach]),
    )


def create_fit_settings(maneuver: Maneuver, axis: Axis, model: Model) -> MLSettings:
    """Return how the maneuver will be fitted after the flight: what is free, what is held.

    Tables 6.2.5 and 6.2.6, and what moved beside the input; the rest is held at the model's.
    Effects of the model are left out: they hardly change what the bounds are.
    """
    free = free_derivatives(axis, maneuver.inputs)
    free = (*free, *secondary_input_derivatives((maneuver,), axis, free))
    held = {name: model.derivative(name) for name in axis_derivatives(axis) if name not in free}
    return MLSettings(axis=axis, free=free, held=held, max_iterations=INFORMATION.max_iterations)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ManeuverSensitivities:
    """How the responses of one maneuver depend on the unknowns of its fit."""

    names: tuple[str, ...]
    """All unknowns, the free derivatives first."""
    free_count: int
    """How many those are."""
    responses: tuple[str, ...]
    S: FloatArray
    """Shape (n, n_responses, n_unknowns). Zero where a sample does not count."""
    residuals: FloatArray
    """Shape (n, n_responses). Responses measured less those at the known parameters; of a flown
    maneuver they tell its own noise. Zero where a sample does not count."""
    segments: tuple[slice, ...]
    """Stretches of contiguous samples."""
    rate: float
    """Samples per second."""

    def estimate_noise(self) -> ResponseNoise:
        """Return the noise of the maneuver itself: what the best straight step leaves over.

        A fit goes such steps until nothing changes any more; here one is enough, since only the
        noise is asked for.
        """
        rest = self.residuals
        for _ in range(INFORMATION.weight_iterations):
            W = np.diag(1.0 / np.maximum(np.mean(rest * rest, axis=0), INFORMATION.min_variance))
            side = np.einsum("krm,kr->m", self.S, self.residuals @ W)
            rest = self.residuals - self.S @ (_pseudo_inverse(information_matrix(self.S, W)) @ side)
        one = BoundsPart(
            S=self.S, v=rest, W=W, segments=None if len(self.segments) == 1 else self.segments
        )
        return ResponseNoise(
            responses=self.responses,
            rate=self.rate,
            autocovariance=noise_autocovariance(one),
            duration=len(rest) / self.rate,
        )

    def information(self, noise: ResponseNoise) -> ManeuverInformation:
        """Return the information under this noise, at the maneuver's own rate."""
        heard = noise.select(self.responses)
        W = np.diag(1.0 / heard.variances)
        covariance = covariance_for_known_noise(
            self.S,
            W,
            heard.autocovariance_to(default_lags(len(self.S))),
            segments=None if len(self.segments) == 1 else self.segments,
        )
        return marginalize_information(
            self.names[: self.free_count], self.names, information_matrix(self.S, W), covariance
        )


def compute_sensitivities(
    maneuver: Maneuver, axis: Axis, model: Model, responses: Collection[str] | None = None
) -> ManeuverSensitivities:
    """Return the sensitivities of a maneuver with this input at known parameters.

    Flown or planned: its surfaces, and the air data and attitude that come with them; by default of
    all responses of the axis. `FlightError` if nothing can be fitted, or the model diverges.
    """
    settings = create_fit_settings(maneuver, axis, model)
    if responses is not None:
        kept = tuple(name for name in AXIS_RESPONSES[axis] if name in responses)
        settings = settings.with_changes(responses=kept)
    problem = build_problem([maneuver], settings)
    solver = Solver(problem, settings)
    point = solver.evaluate(initial_unknowns(problem, model))
    if point is None:
        raise FlightError(f"the motion of maneuver {maneuver.id} diverges with the model's values")
    (part,) = problem.parts
    part.accept_trial()
    _, _, found = solver.linearize(point)
    S = np.concatenate(found[0], axis=2).transpose(2, 0, 1)
    (residuals,) = point.residuals
    slices, first = [], 0
    for segment in part.segments:
        slices.append(slice(first, first + segment.measured.shape[1]))
        first = slices[-1].stop
    return ManeuverSensitivities(
        names=problem.unknowns,
        free_count=len(problem.names.all),
        responses=part.responses,
        S=np.ascontiguousarray(S),
        residuals=np.concatenate(residuals, axis=1).T,
        segments=tuple(slices),
        rate=1.0 / maneuver.dt,
    )


def _pseudo_inverse(H: FloatArray) -> FloatArray:
    found = invert_information(H)
    lost = ~np.isfinite(found.diagonal())
    found[lost] = found[:, lost] = 0.0
    return found


def predict_information(
    maneuver: Maneuver, axis: Axis, model: Model, noise: ResponseNoise
) -> ManeuverInformation:
    """Return the information that a maneuver with this input will bring under this noise.

    Arguments and errors as in `compute_sensitivities`.
    """
    return compute_sensitivities(maneuver, axis, model, noise.responses).information(noise)


def initial_unknowns(problem: EstimationProblem, model: Model) -> FloatArray:
    """Return the unknowns with derivatives as known, initial states as measured, no bias."""
    shared = [model.derivative(name) for name in problem.names.all]
    return np.concatenate((shared, *(part.local_start for part in problem.parts)))


def fit_maximum_likelihood(maneuver: Maneuver, axis: Axis, model: Model) -> MLSolution:
    """Fit a maneuver by maximum likelihood from known parameters on; it takes a few rounds."""
    settings = create_fit_settings(maneuver, axis, model)
    problem = build_problem([maneuver], settings)
    solver = Solver(problem, settings)
    return build_solution(problem, solver, solver.solve(initial_unknowns(problem, model)), settings)


def fit_filter_error(
    maneuver: Maneuver, axis: Axis, model: Model
) -> Generator[None, None, FilterErrorSolution]:
    """Fit a maneuver by filter error, in steps, as it will be fitted after the flight."""
    return solve_stepwise([maneuver], create_fit_settings(maneuver, axis, model))


def predict_in_gusts(
    maneuver: Maneuver,
    axis: Axis,
    model: Model,
    noise: NoiseModel,
    *,
    seed: int | None = None,
) -> Generator[None, None, ManeuverInformation]:
    """Find the information that filter error will find in a maneuver in gusts, in steps.

    `noise`: gusts and instruments. `seed`: of the gusts that a planned maneuver meets. Errors as in
    `compute_sensitivities`.
    """
    settings = create_fit_settings(maneuver, axis, model)
    known = {name: model.derivative(name) for name in axis_derivatives(axis)}
    random = None if seed is None else np.random.default_rng(seed)
    return information_from_fit(
        (yield from predict_stepwise(maneuver, settings.with_changes(start=known), noise, random))
    )


def information_from_fit(solution: MLSolution | FilterErrorSolution) -> ManeuverInformation:
    """Return what a fit brought, as its honest covariance says."""
    derivatives = tuple(solution.estimate.derivatives)
    return marginalize_information(
        derivatives, solution.names, solution.information, solution.covariance
    )


def noise_from_residuals(solution: MLSolution, rate: float) -> ResponseNoise:
    """Return the noise behind the residuals of a fit of one maneuver."""
    (part,) = solution.parts
    one = BoundsPart(
        S=part.sensitivities,
        v=part.residuals,
        W=part.weights,
        segments=None if len(part.segments) == 1 else part.segments,
    )
    return ResponseNoise(
        responses=part.responses,
        rate=rate,
        autocovariance=noise_autocovariance(one),
        duration=len(part.times) / rate,
    )


def noise_from_quiet_segment(stretch: Maneuver, axis: Axis, model: Model) -> ResponseNoise:
    """Return the noise of a stretch of flight without an input.

    What little the pilot steers there is explained by the model, bent as far as it must.
    """
    free = axis_derivatives(axis)
    settings = MLSettings(
        axis=axis, free=free, priors=_priors(free, model), max_iterations=INFORMATION.max_iterations
    )
    problem = build_problem([stretch], settings)
    solver = Solver(problem, settings)
    solution = build_solution(
        problem, solver, solver.solve(initial_unknowns(problem, model)), settings
    )
    return noise_from_residuals(solution, 1.0 / stretch.dt)


def _priors(names: tuple[str, ...], model: Model) -> Mapping[str, tuple[float, float]]:
    found = {}
    for name in names:
        value = model.derivative(name)
        found[name] = value, max(INFORMATION.prior_share * abs(value), INFORMATION.min_prior)
    return found

"""Gauss-Newton with step halving and a Levenberg-Marquardt fallback on a laid-out problem.

With weights W1 given, J = 1/2 sum v'W1 v (5.1.4 without 1/(nt nz)) is minimized. Without, the
noise covariance R is estimated from the residuals along with the parameters, and what is minimized
is the likelihood with R put in, 1/2 sum_k nt ln R_kk; its gradient is that of the weighted sum with
W1 = R^-1. A-priori values add 1/2 (xi - xi0)' W2 (xi - xi0).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gsapp.foundation import FlightError
from gsapp.identification.maximum_likelihood.problem import EstimationProblem, ManeuverProblem
from gsapp.identification.maximum_likelihood.settings import (
    ML_ALGORITHM,
    FitProgress,
    FitProgressCallback,
    MLSettings,
)
from gsapp.quantities import FloatArray


class DivergedError(FlightError):
    """The model leaves all bounds before a fit could begin."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FitPoint:
    """Where a fit stands."""

    unknowns: FloatArray  # Shape (n_unknowns,).
    residuals: list[list[FloatArray]]  # By maneuver and segment, shape (n_responses, n).
    noise: list[FloatArray]
    """Covariance of the residuals, by maneuver, shape (n_responses, n_responses); diagonal unless
    the settings ask for all of it."""
    cost: float  # What is minimized.


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SolverResult:
    """Where a fit ended."""

    point: FitPoint
    information: FloatArray
    """Shape (n_unknowns, n_unknowns). sum S'WS + W2 of the last linearization."""
    sensitivities: list[list[FloatArray]]
    """By maneuver and segment, shape (n_responses, n_global + n_local, n)."""
    iterations: int
    converged: bool
    message: str  # Why it ended, in words.


class Solver:
    """Minimizes the cost of a problem."""

    def __init__(
        self,
        problem: EstimationProblem,
        settings: MLSettings,
        progress: FitProgressCallback | None = None,
    ) -> None:
        self.problem = problem
        self._settings = settings
        self._progress = progress
        self._shared = len(problem.names.all)
        self._counts = [
            sum((segment.valid.sum(axis=1) for segment in part.segments), np.zeros(1))
            for part in problem.parts
        ]
        self._floors = [_noise_floors(part) for part in problem.parts]
        names = problem.unknowns
        self._prior_places = [names.index(name) for name in settings.priors if name in names]
        chosen = [settings.priors[names[place]] for place in self._prior_places]
        self._prior_values = np.array([value for value, _ in chosen])
        self._prior_weights = np.array([1.0 / std**2 for _, std in chosen])

    @property
    def samples(self) -> int:
        """Return the number of instants at which some response counts."""
        return int(sum(float(count.max()) for count in self._counts))

    # --- cost -----------------------------------------------------------------------------------

    def evaluate(self, unknowns: FloatArray, before: FloatArray | None = None) -> FitPoint | None:
        """Return the point at these unknowns; None where the model diverges.

        `unknowns`, shape (n_unknowns,).
        `before`, shape (n_unknowns,): unknowns at the last accepted point, whose sensitivities
        predict the trajectories.
        """
        shared = unknowns[: self._shared]
        residuals: list[list[FloatArray]] = []
        for index, part in enumerate(self.problem.parts):
            own = self.problem.unknown_indices(index)
            moved = None
            if before is not None:
                change = unknowns - before
                moved = np.concatenate((change[: self._shared], change[own]))
            found = part.evaluate_residuals(shared, unknowns[own], moved)
            if found is None:
                return None
            residuals.append(found)
        noise = [self._noise(index, found) for index, found in enumerate(residuals)]
        return FitPoint(
            unknowns=unknowns,
            residuals=residuals,
            noise=noise,
            cost=self._cost(unknowns, noise),
        )

    def _noise(self, index: int, residuals: Sequence[FloatArray]) -> FloatArray:
        """Return the covariance of a maneuver's residuals; samples that do not count are zero."""
        count, floor = self._counts[index], self._floors[index]
        found: FloatArray
        if self._settings.noise == "diagonal" or self.problem.parts[index].weights is not None:
            sums = sum((np.einsum("rn,rn->r", v, v) for v in residuals), np.zeros(1))
            found = np.diag(np.maximum(sums / count, floor))
        else:
            products = sum((v @ v.T for v in residuals), np.zeros((1, 1)))
            found = products / np.sqrt(count * count[:, None]) + np.diag(floor)
        return found

    def weights(self, point: FitPoint) -> list[FloatArray]:
        """Return W of each maneuver, shape (n_responses, n_responses).

        Weights given by the user are scaled so that the weighted residuals have a mean square of
        1: the parameters do not feel it, and a-priori values keep their meaning.
        """
        found: list[FloatArray] = []
        for index, part in enumerate(self.problem.parts):
            W: FloatArray
            if part.weights is None:
                W = np.asarray(np.linalg.inv(point.noise[index]), dtype=np.float64)
            else:
                W = np.diag(self._given(part) / self._scale(point))
            found.append(W)
        return found

    def _given(self, part: ManeuverProblem) -> FloatArray:
        assert part.weights is not None  # noqa: S101 - for the type checker
        return np.array([part.weights[name] for name in part.responses])

    def _scale(self, point: FitPoint) -> float:
        """Return the mean square of the residuals times the weights given."""
        total, count = 0.0, 0.0
        for index, part in enumerate(self.problem.parts):
            if part.weights is not None:
                noise = point.noise[index].diagonal()
                weighted = self._given(part) * noise * self._counts[index]
                total += float(weighted.sum())
                count += float(self._counts[index].sum())
        return max(total / max(count, 1.0), 1e-300)

    def _cost(self, unknowns: FloatArray, noise: Sequence[FloatArray]) -> float:
        cost, given, given_count = 0.0, 0.0, 0.0
        for index, part in enumerate(self.problem.parts):
            count = self._counts[index]
            if part.weights is None:
                cost += 0.5 * float((count * np.log(noise[index].diagonal())).sum())
                if self._settings.noise == "full":
                    scale = 1.0 / np.sqrt(noise[index].diagonal())
                    correlation = noise[index] * scale * scale[:, None]
                    cost += 0.5 * float(count.mean() * np.linalg.slogdet(correlation)[1])
            else:
                given += float((self._given(part) * noise[index].diagonal() * count).sum())
                given_count += float(count.sum())
        if given_count:
            # One common scale of the noise, put in likewise: monotonous in the weighted sum.
            cost += 0.5 * given_count * math.log(max(given / given_count, 1e-300))
        if self._prior_places:
            away = unknowns[self._prior_places] - self._prior_values
            cost += 0.5 * float((self._prior_weights * away * away).sum())
        return cost

    # --- equations ------------------------------------------------------------------------------

    def linearize(self, point: FitPoint) -> tuple[FloatArray, FloatArray, list[list[FloatArray]]]:
        """Return Hessian, gradient (of minus the cost), and the sensitivities at a point."""
        size = point.unknowns.size
        H, g = np.zeros((size, size)), np.zeros(size)
        shared = point.unknowns[: self._shared]
        weights = self.weights(point)
        everything = []
        for index, part in enumerate(self.problem.parts):
            own = self.problem.unknown_indices(index)
            parts = part.sensitivities(shared, point.unknowns[own])
            everything.append(parts)
            block, side = _normal_equations(parts, point.residuals[index], weights[index])
            place = np.r_[0 : self._shared, own]
            H[np.ix_(place, place)] += block
            g[place] += side
        if self._prior_places:
            away = point.unknowns[self._prior_places] - self._prior_values
            H[self._prior_places, self._prior_places] += self._prior_weights
            g[self._prior_places] -= self._prior_weights * away
        return H, g, everything

    def solve(self, start: FloatArray) -> SolverResult:
        """Minimize the cost from a start.

        Raises `DivergedError` if the model diverges at the start.
        """
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            return self._solve(start)

    def _solve(self, start: FloatArray) -> SolverResult:
        point = self.evaluate(start)
        if point is None:
            raise DivergedError("the model diverges with its start values")
        self._accept()
        total = sum(float(count.sum()) for count in self._counts)
        first = point.cost
        message, converged = "stopped after max_iterations without converging", False
        iteration, last = 0, math.inf
        while True:
            iteration += 1
            H, g, sensitivities = self.linearize(point)
            step, promise = _step(H, g, 0.0)
            change = 2.0 * promise / total
            if change < self._settings.tolerance or (
                change < ML_ALGORITHM.cost_rounding and change > 0.5 * last
            ):
                after = self.evaluate(point.unknowns + step, point.unknowns)
                if after is not None:
                    point = after
                    self._accept()
                converged, message = True, f"converged in {iteration} iterations"
                break
            last = change
            if iteration > self._settings.max_iterations:
                if change < ML_ALGORITHM.acceptable_tolerance:
                    converged, message = True, f"converged slowly, {iteration - 1} iterations"
                break
            after = self._descend(point, H, g, step, blindly=change < ML_ALGORITHM.cost_rounding)
            if after is None:
                # No direction lowers the cost: a minimum, as far as rounding lets one see.
                converged = change < ML_ALGORITHM.acceptable_tolerance
                message = (
                    f"converged in {iteration} iterations, to rounding"
                    if converged
                    else "stopped: no step lowers the cost, but it is not a minimum"
                )
                break
            point = after
            self._accept()
            cost = math.exp(min(2.0 * (point.cost - first) / total, 0.0))
            if self._progress is not None:
                report = FitProgress(iteration=iteration, cost=cost, change=change)
                if self._progress(report) is False:
                    message = f"interrupted after {iteration} iterations"
                    break
        return SolverResult(
            point=point,
            information=H,
            sensitivities=sensitivities,
            iterations=iteration,
            converged=converged,
            message=message,
        )

    def _accept(self) -> None:
        for part in self.problem.parts:
            part.accept_trial()

    def _descend(
        self, point: FitPoint, H: FloatArray, g: FloatArray, step: FloatArray, *, blindly: bool
    ) -> FitPoint | None:
        """Return a point of lower cost: halved Gauss-Newton steps, then damped ones."""
        if blindly:
            return self.evaluate(point.unknowns + step, point.unknowns)
        for halving in range(ML_ALGORITHM.max_halvings):
            after = self.evaluate(point.unknowns + 0.5**halving * step, point.unknowns)
            if after is not None and after.cost < point.cost:
                return after
        for damping in ML_ALGORITHM.dampings:
            damped, _ = _step(H, g, damping)
            after = self.evaluate(point.unknowns + damped, point.unknowns)
            if after is not None and after.cost < point.cost:
                return after
        return None


def _step(H: FloatArray, g: FloatArray, damping: float) -> tuple[FloatArray, float]:
    """Return the step and the decrease that it promises; directions without data stay.

    H is scaled by its diagonal, so that damping and rounding mean the same for all parameters.
    """
    diagonal = H.diagonal()
    scale = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    values, vectors = np.linalg.eigh(H * scale * scale[:, None])
    good = values > ML_ALGORITHM.eigenvalue_tolerance * max(float(values[-1]), 1e-300)
    along = vectors.T @ (g * scale)
    taken = np.where(good, along / np.where(good, values + damping, 1.0), 0.0)
    step: FloatArray = scale * (vectors @ taken)
    return step, 0.5 * float(along @ taken)


def _normal_equations(
    sensitivities: Sequence[FloatArray], residuals: Sequence[FloatArray], weights: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return sum S'WS and sum S'Wv of one maneuver."""
    width = sensitivities[0].shape[1]
    H, g = np.zeros((width, width)), np.zeros(width)
    root = np.linalg.cholesky(weights)
    diagonal = not np.count_nonzero(root - np.diag(root.diagonal()))
    for S, v in zip(sensitivities, residuals, strict=True):
        sides = weights @ v
        whitened = S if diagonal else np.tensordot(root.T, S, axes=1)
        # Products small enough for BLAS to stay on one thread: starting others takes longer.
        length = max(1, int(ML_ALGORITHM.single_thread_size / max(width, 1) ** 2))
        for row in range(len(S)):
            g += S[row] @ sides[row]
            scale = weights[row, row] if diagonal else 1.0
            for first in range(0, v.shape[1], length):
                piece = whitened[row, :, first : first + length]
                H += scale * (piece @ piece.T)
    return H, g


def _noise_floors(part: ManeuverProblem) -> FloatArray:
    measured = np.concatenate([segment.measured for segment in part.segments], axis=1)
    floors: FloatArray = np.maximum(
        (ML_ALGORITHM.noise_floor * np.abs(measured).max(axis=1)) ** 2, 1e-300
    )
    return floors


def prior_warnings(
    problem: EstimationProblem, priors: Mapping[str, tuple[float, float]]
) -> tuple[str, ...]:
    """Return a sentence for each a-priori value of something that is not free."""
    names = problem.unknowns
    return tuple(
        f"the prior of {name} is not used: not free in this fit"
        for name in priors
        if name not in names
    )

"""The shape of a stall from measured coefficients: regression that is not linear in four numbers.

For any shape (abruptness, angle of attack, time constants) the size of the stall and the linear
terms beside it follow by linear least squares; only the shape is searched (variable projection:
Golub, Pereyra, Inverse Problems 19, 2003). No motion is simulated, so that it finds its way from
afar, where a fit of simulated motion would run away.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.linalg import block_diag
from scipy.optimize import least_squares

from gsapp.dynamics.buildup import linear_variables
from gsapp.dynamics.effect_terms import STALL_SHAPE, StallTerm
from gsapp.identification.coefficients import Coefficients
from gsapp.identification.equation_error.equations import FORCE_COEFFICIENTS
from gsapp.identification.equation_error.regression import EQUATION_ERROR
from gsapp.identification.smoothing import contiguous_slices
from gsapp.quantities import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class StallShape:
    """The shape of a stall that fits one coefficient best."""

    values: Mapping[str, float]  # Of the parameters in `STALL_SHAPE`.
    explained: float  # Share of what the linear terms leave, 0 to 1.


def _history(
    term: StallTerm, reads: Sequence[FloatArray], shape: Mapping[str, float], dt: float
) -> FloatArray:
    parameters = (1.0, *(shape[name] for name in STALL_SHAPE))
    return np.asarray(term.value(reads, term.states_along(reads, parameters, dt), parameters))


def fit_stall_shape(
    term: StallTerm, found: Sequence[Coefficients], alpha_linear: float
) -> StallShape | None:
    """Return the shape of the stall that explains most beside the linear terms.

    `found` are smoothed alike; `alpha_linear` is the end of the linear range, rad. None if the
    coefficient cannot be had, no angle of attack is beyond that range, or no shape within its
    bounds explains anything.
    """
    problem = _ShapeProblem.build(term, found)
    if problem is None:
        return None
    # As `gsapp.discrepancy.search_checks.highest_alpha`: noise reaches further.
    top = max(float(np.percentile(reads[0], 99.0)) for reads in problem.reads)
    if top < alpha_linear:
        return None
    angles = np.linspace(alpha_linear, top, EQUATION_ERROR.stall_angles)
    starts = product(EQUATION_ERROR.stall_abruptness, angles, EQUATION_ERROR.stall_time_constants)
    sums = [
        (float(np.sum(problem.residuals(start) ** 2)), start)
        for start in (
            (np.log(a1), float(angle), np.log(tau), 0.5 * tau) for a1, angle, tau in starts
        )
    ]
    _, best = min(sums)
    low, high = problem.bounds
    inside = np.clip(best, low + 1e-6, high - 1e-6)
    solution = least_squares(
        problem.residuals, inside, bounds=(low, high), x_scale=EQUATION_ERROR.stall_scales
    )
    explained = 1.0 - 2.0 * float(solution.cost) / problem.total
    if not explained > 0.0:
        return None
    return StallShape(values=_shape(solution.x), explained=explained)


def _shape(x: Sequence[float]) -> dict[str, float]:
    return {
        "a1": float(np.exp(x[0])),
        "alpha_star": float(x[1]),
        "tau1": float(np.exp(x[2])),
        "tau2": float(x[3]),
    }


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _ShapeProblem:
    """A coefficient freed of its linear terms, and what a stall reads."""

    term: StallTerm
    reads: tuple[tuple[FloatArray, ...], ...]  # By maneuver, each of shape (n,).
    taken: tuple[FloatArray, ...]  # By maneuver, samples that count.
    dt: float
    basis: FloatArray  # Shape (m, k). Orthonormal, of the linear terms.
    left: FloatArray  # Shape (m,). The coefficient less its linear terms.

    @classmethod
    def build(cls, term: StallTerm, found: Sequence[Coefficients]) -> _ShapeProblem | None:
        name = term.target
        variables = tuple(linear_variables(name).values())
        reads, taken, rows, ys = [], [], [], []
        for one in found:
            if name in one.missing or not {"alpha", "V"} <= one.measured:
                continue
            good = one.valid_samples(name)
            for variable in variables:
                good = good & one.variable_valid[variable]
            parts = [
                np.arange(part.start, part.stop, one.smoother.stride)
                for part in contiguous_slices(good)
            ]
            if not parts:
                continue
            taken.append(np.concatenate(parts))
            reads.append(tuple(one.smoothed_variables(term.reads).T))
            rows.append(one.smoothed_variables(variables)[taken[-1]])
            ys.append(one.values[taken[-1], one.column(name)])
        if not ys:
            return None
        ones = [np.ones((len(y), 1)) for y in ys]
        # Zeros of accelerometers differ from maneuver to maneuver.
        levels = block_diag(*ones) if name in FORCE_COEFFICIENTS else np.concatenate(ones)
        basis, _ = np.linalg.qr(np.column_stack((levels, np.concatenate(rows))))
        y = np.concatenate(ys)
        return cls(
            term=term,
            reads=tuple(reads),
            taken=tuple(taken),
            dt=found[0].smoother.dt,
            basis=basis,
            left=y - basis @ (basis.T @ y),
        )

    @property
    def total(self) -> float:
        return float(self.left @ self.left)

    @property
    def bounds(self) -> tuple[FloatArray, FloatArray]:
        limits = {item.name: item.bounds for item in self.term.parameters}
        rows = [np.log(limits["a1"]), limits["alpha_star"], np.log(limits["tau1"]), limits["tau2"]]
        low, high = np.array(rows).T
        return low, high

    def residuals(self, x: Sequence[float]) -> FloatArray:
        """Return what is left with the best size of a stall of this shape, shape (m,)."""
        shape = _shape(x)
        column = np.concatenate(
            [
                _history(self.term, reads, shape, self.dt)[taken]
                for reads, taken in zip(self.reads, self.taken, strict=True)
            ]
        )
        column = column - self.basis @ (self.basis.T @ column)
        low, high = self.term.parameters[0].bounds
        size = float(column @ self.left) / max(float(column @ column), 1e-300)
        return np.asarray(self.left - np.clip(size, low, high) * column, dtype=np.float64)

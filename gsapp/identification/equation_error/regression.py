"""Linear regression of one coefficient that noise in its regressors does not bend.

Least squares shrinks a slope by the share of noise in its regressor (0.1 deg of white vane noise
costs nothing, colored noise of that size 4 % of CN_alpha). White noise can be measured at high
frequencies and taken out of X'X. Colored noise cannot; but no noise of the instruments is in the
motion that the surfaces alone explain: states simulated from the surface deflections by a model
of a few states fitted to the record. With these as instruments, Z'X takes the place of X'X.

With P = Z (Z'Z)^-1 Z'X the estimate is that of a regression on P, so its bounds are those of
`gsapp.identification.statistics`, colored residuals believed. A derivative that cannot be told
apart from another is left out; what it would have made of the others is added to their bounds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from gsapp.identification.statistics import ManeuverFitData, joint_covariance
from gsapp.identification.statistics.identifiability import withheld_std
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import DEGREE


@dataclass(frozen=True, slots=True, kw_only=True)
class EquationErrorSettings:
    """Engineering choices unless a source is named."""

    # Equations.
    rows_per_column: int = 8  # Rows that a stretch must have for each number of its model.
    max_growth: float = 10.0  # By which an unstable model may grow within a stretch.
    drift_degree: int = 2  # Of the polynomial for drift of integrated flow angles.
    min_angle_std: float = 0.1 * DEGREE  # Smaller deviations are no motion: rad ...
    min_rate_std: float = 0.3 * DEGREE  # ... and rad/s.
    min_signal_to_noise: float = 2.0  # Standard deviation over noise: moved beyond.
    min_duration: float = 1.0  # s of usable record below which nothing is estimated.
    significant_sigmas: float = 3.0  # Bounds from which a time shift is proven ...
    min_shift: float = 1e-3  # ... and the least shift that does harm, s.
    weak_instrument_inflation: float = 1.7  # Of bounds: worse than the noise.

    # Regression.
    max_correlation_time: float = 2.0  # s, of the autocovariance of residuals.
    min_regressor_to_noise: float = 3.0  # Of a regressor, given the others.
    max_inflation: float = 1e7  # Of a variance by collinearity, where no noise is known.
    start_value_cutoff: float = 5.0  # Hz; a start value needs no better choice.
    singular_value_cutoff: float = 1e-3  # Of the largest one: smaller stay near zero.

    # Stepwise regression.
    f_to_enter: float = 20.0  # Partial F at which a term enters ...
    f_to_remove: float = 12.0  # ... and below which it leaves.
    press_segment_duration: float = 0.6  # Length of the stretches that PRESS leaves out, s.
    max_cosine: float = 0.9  # Of what is new in two candidates: hardly told apart.
    max_candidates: int = 3  # Candidates tried in a round before it gives up.

    # Shape of a stall: sizes from which the search for it starts, and its scales.
    stall_angles: int = 4  # From the end of the linear range to the highest angle flown.
    stall_abruptness: tuple[float, ...] = (12.0, 30.0)  # Per radian.
    stall_time_constants: tuple[float, ...] = (0.1, 0.5)  # s.
    stall_scales: tuple[float, ...] = (0.3, 0.02, 0.5, 0.1)  # log a1, rad, log tau1, s.


EQUATION_ERROR: Final = EquationErrorSettings()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ManeuverRows:
    """The rows of one maneuver in an equation."""

    rows: slice
    segments: tuple[slice, ...]  # Unbroken stretches, counted from the first row of the maneuver.


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Equation:
    """y = X theta + e, sampled often enough and no more."""

    y: FloatArray  # Shape (n,).
    X: FloatArray  # Shape (n, k). Filtered as y.
    Z: FloatArray  # Shape (n, k). Instruments; X itself for least squares.
    names: tuple[str, ...]  # Of the columns.
    maneuver_rows: tuple[ManeuverRows, ...]  # One for each maneuver.
    dt: float  # Between rows, s.
    stride: int  # Samples of the record for each row.
    noise: FloatArray
    """Shape (k, k). Covariance, per row, of white measurement noise in the columns of X."""
    withheld: FloatArray = field(default_factory=lambda: np.empty((0, 0)))
    """Shape (n, w). Columns left out whose parameters are not zero, each times the standard
    deviation of its parameter."""

    def select_columns(self, columns: Sequence[int]) -> Equation:
        """Return the equation with these columns only; derivatives left out are withheld."""
        chosen = list(columns)
        left = [index for index in range(len(self.names)) if index not in chosen]
        stds = np.array([withheld_std(self.names[index]) for index in left])
        known = self.withheld.reshape(len(self.y), -1)
        # The constant is that of the flight as it was: the mean of what is withheld belongs to it.
        moved = self.X[:, left] - self.X[:, left].sum(axis=0) / max(len(self.X), 1)
        return replace(
            self,
            withheld=np.column_stack((known, (moved * stds)[:, stds > 0.0])),
            X=self.X[:, chosen],
            Z=self.Z[:, chosen],
            names=tuple(self.names[index] for index in chosen),
            noise=self.noise[np.ix_(chosen, chosen)],
        )

    @property
    def with_ordinary_least_squares(self) -> Equation:
        return replace(self, Z=self.X)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Regression:
    """The solution of an `Equation`."""

    names: tuple[str, ...]
    values: FloatArray  # Shape (k,).
    covariance: FloatArray
    """Shape (k, k). Colored residuals believed, and what the columns withheld may have done."""
    white_covariance: FloatArray
    """Shape (k, k). Every sample of the record taken as independent: the uncorrected bound."""
    residuals: FloatArray  # Shape (n,).

    @property
    def std(self) -> FloatArray:
        found: FloatArray = np.sqrt(np.maximum(np.diag(self.covariance), 0.0))
        return found


def solve_parameters(
    equation: Equation, weights: FloatArray | None = None
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the parameters, shape (k,), and P, shape (n, k), of the equation.

    Also what the columns withheld make of the parameters, shape (k, w).

    `weights`, shape (n,): one over the standard deviation of each row.
    """
    X, Z = equation.X, equation.Z
    y = np.column_stack((equation.y, equation.withheld.reshape(len(X), -1)))
    rows = float(len(y))
    if weights is not None:
        X, Z, y = (one * weights[:, None] for one in (X, Z, y))
        rows = float(weights @ weights)
    # Only a column that is its own instrument has the noise of X in Z'X.
    own = (equation.Z == equation.X).all(axis=0)
    noise = np.where(own[:, None] & own, equation.noise, 0.0) * rows
    scale = np.sqrt(np.maximum(np.einsum("ij,ij->j", Z, Z), 1e-300))
    basis, corner = np.linalg.qr(Z / scale)
    mixed = basis.T @ X - np.linalg.solve(corner.T, noise / scale[:, None])
    found = np.linalg.solve(mixed, basis.T @ y)
    theta = np.asarray(found, dtype=np.float64)
    return theta[:, 0], np.asarray(basis @ mixed, dtype=np.float64), theta[:, 1:]


def instrument_inflation(equation: Equation) -> float:
    """Return by what factor instruments widen the bounds, the median over the parameters.

    Infinite where the instruments leave the equation without a solution.
    """
    _, projected, _ = solve_parameters(equation)
    wide, narrow = (
        np.diag(np.linalg.pinv(columns.T @ columns, rcond=1e-14, hermitian=True))
        for columns in (projected, equation.X)
    )
    if not (np.isfinite(wide).all() and (wide > 0.0).all() and (narrow > 0.0).all()):
        return float("inf")
    return float(np.median(np.sqrt(wide / narrow)))


def solve_equation(equation: Equation) -> Regression:
    """Solve an equation; maneuvers count by the size of their own residuals."""
    theta, projected, taken = solve_parameters(equation)
    residuals = equation.y - equation.X @ theta
    sizes = _residual_rms(residuals, equation.maneuver_rows)
    if len(sizes) > 1 and sizes.min() > 0.0:
        weights = np.concatenate(
            [
                np.full(stretch.rows.stop - stretch.rows.start, 1.0 / size)
                for stretch, size in zip(equation.maneuver_rows, sizes, strict=True)
            ]
        )
        theta, projected, taken = solve_parameters(equation, weights)
        projected = projected / weights[:, None]
        residuals = equation.y - equation.X @ theta
        sizes = _residual_rms(residuals, equation.maneuver_rows)
    width = theta.size
    scale = np.maximum(np.linalg.norm(projected, axis=0), 1e-300)
    floor = max(float(sizes.max()), 1e-300) * 1e-9
    parts = []
    information = np.zeros((width, width))
    for stretch, size in zip(equation.maneuver_rows, sizes, strict=True):
        S = projected[stretch.rows, None, :] / scale
        W = np.array([[1.0 / max(float(size), floor) ** 2]])
        parts.append(
            ManeuverFitData(S=S, v=residuals[stretch.rows, None], W=W, segments=stretch.segments)
        )
        information += W[0, 0] * S[:, 0].T @ S[:, 0]
    covariance = joint_covariance(parts, width, lags=_correlation_lags(equation))
    white = np.linalg.pinv(information, hermitian=True) / equation.stride
    unscale = 1.0 / scale[:, None] / scale
    return Regression(
        names=equation.names,
        values=theta,
        covariance=covariance * unscale + taken @ taken.T,
        white_covariance=white * unscale,
        residuals=residuals,
    )


def _residual_rms(residuals: FloatArray, stretches: Sequence[ManeuverRows]) -> FloatArray:
    return np.array([np.sqrt(np.mean(residuals[one.rows] ** 2)) for one in stretches])


def _correlation_lags(equation: Equation) -> int:
    longest = max(
        (part.stop - part.start for one in equation.maneuver_rows for part in one.segments),
        default=1,
    )
    return max(1, min(round(EQUATION_ERROR.max_correlation_time / equation.dt), longest // 4))


def collinear_columns(equation: Equation) -> dict[str, tuple[str, ...]]:
    """Return the parameters that the data cannot tell apart, each with its partners.

    What is left of a regressor after the others explain it must stand out of the noise that is
    left of it; else the regression would share out noise.
    """
    X = equation.X
    scale = np.sqrt(np.maximum(np.einsum("ij,ij->j", X, X), 1e-300))
    scaled = X / scale
    noise = len(X) * equation.noise / scale[:, None] / scale
    left = list(range(len(scale)))
    found: dict[str, tuple[str, ...]] = {}
    while len(left) > 1:
        inverse = np.linalg.pinv(scaled[:, left].T @ scaled[:, left], rcond=1e-14, hermitian=True)
        alone = 1.0 / np.maximum(np.diag(inverse), 1e-300)
        weights = inverse / np.diag(inverse)
        own = np.einsum("ij,ik,kj->j", weights, noise[np.ix_(left, left)], weights)
        ratio = alone / np.maximum(
            EQUATION_ERROR.min_regressor_to_noise * own, 1.0 / EQUATION_ERROR.max_inflation
        )
        worst = int(np.argmin(ratio))
        if ratio[worst] >= 1.0:
            break
        share = np.abs(weights[:, worst])
        share[worst] = 0.0
        partners = [left[index] for index in np.flatnonzero(share > 0.5 * share.max())]
        names = tuple(equation.names[index] for index in partners)
        name = equation.names[left[worst]]
        found[name] = names
        for partner in names:
            found[partner] = tuple(dict.fromkeys((*found.get(partner, ()), name)))
        left.pop(worst)
    return found

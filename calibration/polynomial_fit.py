"""The curve through calibration points: value = c0 + c1 v + c2 v^2 + c3 v^3 + s h / 2, v in volts.

A surface drags its potentiometer along through the play of its linkage: on the way up the
potentiometer is behind by half the play (s = +1), on the way down ahead by as much (s = -1). The
width h of the loop is one unknown beside the coefficients of the curve, found from all points
together; the largest distance between two noisy branches would grow with every point taken.

Where the movement turns back the play is still being crossed, unless the setting is passed first
and then come back to: the point taken upward at the lowest setting and the one taken downward at
the highest may lie anywhere between the branches. They count as noted where they agree with the
others, which is tested; otherwise, like points whose direction was not noted, they lie midway
(s = 0) but for +-h/2, and weigh accordingly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from calibration.points import CalibrationError, CalibrationPoint
from calibration.settings import CALIBRATION
from gsapp.quantities import BoolArray, FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CalibrationReadings:
    """Points as arrays, with the branch of each."""

    volts: FloatArray
    values: FloatArray
    """Shape (n,)."""
    side: FloatArray
    """Shape (n,). s: +1 upward branch, -1 downward, 0 where it cannot be told."""
    settings: FloatArray
    """Shape (n,). Number of the setting of each point; settings ascend."""
    two_sided: bool
    """Whether both branches were measured, so that h can be found."""
    noise: float = 0.0
    """Standard deviation of single samples, V, over the points where it was noted; 0 otherwise."""

    @classmethod
    def from_points(cls, points: Sequence[CalibrationPoint]) -> CalibrationReadings:
        """Return the readings of points in any order."""
        volts = np.array([point.volts for point in points], dtype=np.float64)
        values = np.array([point.value for point in points], dtype=np.float64)
        said = np.array([{"up": 1.0, "down": -1.0}.get(point.direction, 0.0) for point in points])
        sweep = max(int(np.count_nonzero(said == side)) for side in (-1.0, 0.0, 1.0))
        settings = cluster_settings(values, sweep)
        turning = ((said > 0.0) & (settings == settings.min())) | (
            (said < 0.0) & (settings == settings.max())
        )
        side = said
        if (
            turning.any()
            and _turn_point_p_value(volts, values, said, turning)
            < CALIBRATION.turn_point_significance
        ):
            side = np.where(turning, 0.0, said)
        two_sided = bool(np.any(side > 0.0) and np.any(side < 0.0))
        noted = [point.noise**2 for point in points if point.noise > 0.0]
        return cls(
            volts=volts,
            values=values,
            side=side,
            settings=settings,
            two_sided=two_sided,
            noise=float(np.sqrt(np.mean(noted))) if noted else 0.0,
        )

    def __len__(self) -> int:
        return self.volts.size

    def subset(self, chosen: BoolArray) -> CalibrationReadings:
        """Return some of the points; each keeps its branch and its setting."""
        side = self.side[chosen]
        return CalibrationReadings(
            volts=self.volts[chosen],
            values=self.values[chosen],
            side=side,
            settings=self.settings[chosen],
            two_sided=bool(np.any(side > 0.0) and np.any(side < 0.0)),
        )


def _turn_point_p_value(
    volts: FloatArray, values: FloatArray, said: FloatArray, turning: BoolArray
) -> float:
    """Return the chance that points at the turns differ so much from the branches by scatter alone.

    An F test: by how much leaving them out lessens the squares. 1 where too few others are left.
    """
    known = ~turning & (said != 0.0)
    middle, half = float(volts.mean()), float(np.ptp(volts)) or 1.0

    def squares(chosen: BoolArray, degree: int) -> float:
        x = (volts[chosen] - middle) / half
        design = np.column_stack([np.vander(x, degree + 1), said[chosen]])
        solution = np.linalg.lstsq(design, values[chosen], rcond=None)[0]
        return float(np.sum((values[chosen] - design @ solution) ** 2))

    both = np.any(said[known] > 0.0) and np.any(said[known] < 0.0)
    degree = min(3, int(np.count_nonzero(known)) - 5, np.unique(volts[known]).size - 1)
    freedom = int(np.count_nonzero(known)) - degree - 2
    if not both or degree < 1:
        return 1.0
    apart = int(np.count_nonzero(turning))
    without = squares(known, degree)
    more = squares(known | turning, degree) - without
    if without <= 1e-12 * float(np.var(values)):
        return 1.0 if more <= 1e-9 * float(np.var(values)) else 0.0
    # The F distribution of two by `freedom`; of one, it is a little strict.
    return float((1.0 + more / without * (2.0 / max(apart, 2))) ** (-0.5 * freedom))


def cluster_settings(values: FloatArray, sweep: int) -> FloatArray:
    """Return the number of the setting that each value belongs to, ascending.

    Parameters
    ----------
    values : ndarray, shape (n,)
        As set, in any order.
    sweep : int
        Points of one pass over the range.

    Returns
    -------
    ndarray, shape (n,)
        Whole numbers from 0.
    """
    different = np.unique(values)
    gaps = np.diff(different)
    spacing = float(np.ptp(values)) / max(sweep - 1, 1)
    numbers = np.concatenate([[0.0], np.cumsum(gaps > CALIBRATION.same_setting_share * spacing)])
    return np.asarray(numbers[np.searchsorted(different, values)], dtype=np.float64)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class HysteresisFit:
    """A curve midway between the branches, and their distance."""

    degree: int
    center: float
    half_range: float
    """Of the voltages, V: the curve is a polynomial of x = (volts - middle) / half."""
    parameters: FloatArray
    """Shape (degree + 1,) or (degree + 2,). Coefficients of x, ascending; then h where both
    branches were measured."""
    covariance: FloatArray
    """Shape (m, m). Of the parameters, for points that scatter by 1."""
    scatter: float
    """Standard deviation of one setting about its branch, in the unit of the values; NaN where the
    points leave no freedom to tell."""
    degrees_of_freedom: float
    """Degrees of freedom behind `scatter`."""
    weights: FloatArray
    """Shape (n,). Of the points; 1 for those on a known branch."""
    residuals: FloatArray
    """Shape (n,). Value minus curve, where the branch is known minus s h / 2, too."""

    def spend_degree_of_freedom(self) -> HysteresisFit:
        """Return the same curve with one freedom spent: on choosing it among others."""
        if not self.degrees_of_freedom > 2.0:
            return self
        grown = self.scatter * float(
            np.sqrt(self.degrees_of_freedom / (self.degrees_of_freedom - 1.0))
        )
        return replace(self, degrees_of_freedom=self.degrees_of_freedom - 1.0, scatter=grown)

    @property
    def hysteresis(self) -> float | None:
        """Return h, in the unit of the values; negative where the volts lead."""
        return float(self.parameters[-1]) if self.parameters.size > self.degree + 1 else None

    @property
    def hysteresis_std(self) -> float | None:
        if self.hysteresis is None:
            return None
        return self.scatter * float(np.sqrt(self.covariance[-1, -1]))

    def design_matrix(self, volts: FloatArray, side: FloatArray | float = 0.0) -> FloatArray:
        """Return what multiplies the parameters at volts, shape (n,) -> (n, m)."""
        x = (volts - self.center) / self.half_range
        powers = np.vander(x, self.degree + 1, increasing=True)
        if self.hysteresis is None:
            return powers
        return np.column_stack([powers, 0.5 * np.broadcast_to(side, x.shape)])

    def value(self, volts: FloatArray, side: FloatArray | float = 0.0) -> FloatArray:
        """Return the value at volts on a branch; 0 is the curve midway."""
        result: FloatArray = self.design_matrix(volts, side) @ self.parameters
        return result

    @property
    def coefficients(self) -> tuple[float, ...]:
        """Return the curve midway in ascending powers of volts."""
        domain = [self.center - self.half_range, self.center + self.half_range]
        curve = np.polynomial.Polynomial(self.parameters[: self.degree + 1], domain=domain)
        converted = curve.convert().coef
        result = np.zeros(self.degree + 1)
        result[: converted.size] = converted
        return tuple(float(c) for c in result)

    def variance(self, volts: FloatArray, side: FloatArray | float = 0.0) -> FloatArray:
        """Return the variance of the curve, or of a branch, at volts, shape (n,)."""
        rows = self.design_matrix(volts, side)
        return np.asarray(self.scatter**2 * np.einsum("ni,ij,nj->n", rows, self.covariance, rows))


def fit_with_hysteresis(
    readings: CalibrationReadings, degree: int, *, setting_error: float | None = None
) -> HysteresisFit:
    """Fit a curve of a degree, and the width of the loop where both branches were measured.

    Parameters
    ----------
    readings : CalibrationReadings
        At least ``degree + 1`` different voltages.
    setting_error : float, optional
        Standard deviation of one setting as known beforehand, in the unit of the values; counts
        as much as four points.
    """
    low, high = float(readings.volts.min()), float(readings.volts.max())
    middle, half = 0.5 * (low + high), 0.5 * (high - low) or 1.0
    x = (readings.volts - middle) / half
    columns = [np.vander(x, degree + 1, increasing=True)]
    if readings.two_sided:
        columns.append(0.5 * readings.side[:, None])
    design = np.column_stack(columns)
    known = readings.side != 0.0
    weights = np.ones(len(readings))
    prior = (
        (0.0, 0.0)
        if setting_error is None
        else (CALIBRATION.prior_degrees_of_freedom, setting_error)
    )
    if readings.two_sided and not known.all():
        weights[~known] = 1e-4
    for _ in range(6 if readings.two_sided and not known.all() else 1):
        root = np.sqrt(weights)
        solution = np.linalg.lstsq(design * root[:, None], readings.values * root, rcond=None)[0]
        residuals = readings.values - design @ solution
        freedom = float(weights.sum()) - design.shape[1]
        square = float(np.sum(weights * residuals**2))
        total = max(freedom, 0.0) + prior[0]
        if total > 1e-3:
            scatter = float(np.sqrt((square + prior[0] * prior[1] ** 2) / total))
        else:
            scatter = float("nan")
        if readings.two_sided:
            apart = 0.25 * float(solution[-1]) ** 2
            share = scatter**2 / (scatter**2 + apart) if scatter**2 + apart > 0.0 else 1e-4
            weights = np.where(known, 1.0, max(share, 1e-4) if np.isfinite(share) else 1e-4)
    gram = (design * weights[:, None]).T @ design
    return HysteresisFit(
        degree=degree,
        center=middle,
        half_range=half,
        parameters=np.asarray(solution, dtype=np.float64),
        covariance=np.asarray(np.linalg.pinv(gram), dtype=np.float64),
        scatter=scatter,
        degrees_of_freedom=total,
        weights=weights,
        residuals=residuals,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class PolynomialFit:
    """A polynomial in volts and how well it represents the points."""

    coefficients: tuple[float, ...]
    """Ascending powers of volts, in the unit of the values per V^n."""
    residuals: tuple[float, ...]
    """Value minus curve, for each point."""
    rms: float
    max_residual: float
    """Root mean square (with the degrees of freedom left) and largest absolute residual."""
    hysteresis: float
    """Distance between the upward and the downward branch, in the unit of the values, by
    `calibration.polynomial_fit`; 0 where only one direction was measured."""


def evaluate_polynomial(coefficients: Sequence[float], volts: FloatArray) -> FloatArray:
    """Evaluate ascending coefficients at volts, any shape, by Horner's rule."""
    result = np.full_like(volts, coefficients[-1])
    for coefficient in reversed(coefficients[:-1]):
        result = result * volts + coefficient
    return result


def turning_points(coefficients: Sequence[float], low: float, high: float) -> tuple[float, ...]:
    """Return the volts strictly inside (low, high) at which the curve turns back."""
    slope = np.polynomial.Polynomial(np.asarray(coefficients)).deriv().trim()
    if slope.degree() == 0:
        return ()
    roots = slope.roots()
    real = roots[np.abs(np.imag(roots)) < 1e-12].real
    inside = real[(real > low) & (real < high)]
    # A saddle touches zero slope without turning back; it cannot be inverted well either.
    return tuple(float(root) for root in np.sort(inside))


def validate_readings(points: Sequence[CalibrationPoint], degree: int) -> CalibrationReadings:
    """Return points as arrays if a curve of the degree can be drawn through them."""
    if not 1 <= degree <= CALIBRATION.max_degree:
        raise CalibrationError(
            f"a calibration curve of degree {degree} is not supported; use 1, 2 or 3"
        )
    different = np.unique([point.volts for point in points]).size
    if different <= degree:
        raise CalibrationError(
            f"a curve of degree {degree} needs at least {degree + 1} different voltages, "
            f"and there are {different}; take more points or lower the degree"
        )
    readings = CalibrationReadings.from_points(points)
    if readings.values.min() == readings.values.max():
        raise CalibrationError("all points have the same value; move the instrument between them")
    return readings


def invertible_mean_curve(
    branch_fit: HysteresisFit, readings: CalibrationReadings
) -> PolynomialFit:
    """Return the curve midway between branches, if it can be inverted.

    Raises
    ------
    CalibrationError
        If it turns back within the voltages measured.
    """
    coefficients = branch_fit.coefficients
    turning = turning_points(coefficients, float(readings.volts.min()), float(readings.volts.max()))
    if turning:
        raise CalibrationError(
            f"the curve turns back at {turning[0]:.3f} V; one voltage would have two values; "
            "check the points there, or lower the degree"
        )
    residuals = readings.values - evaluate_polynomial(coefficients, readings.volts)
    freedom = max(len(readings) - len(coefficients), 1)
    return PolynomialFit(
        coefficients=coefficients,
        residuals=tuple(float(r) for r in residuals),
        rms=float(np.sqrt(np.sum(residuals**2) / freedom)),
        max_residual=float(np.max(np.abs(residuals))),
        hysteresis=abs(branch_fit.hysteresis or 0.0),
    )

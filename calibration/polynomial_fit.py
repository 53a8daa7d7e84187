"""The curve through calibration points: value = c0 + c1 v + c2 v^2 + c3 v^3, v in volts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calibration.hysteresis_fit import CalibrationReadings, HysteresisFit, fit_with_hysteresis
from calibration.points import CalibrationError, CalibrationPoint, Direction
from gsapp.quantities import FloatArray

FIT_ORDER_TITLES = {1: "straight line", 2: "quadratic", 3: "cubic"}
MAX_DEGREE = max(FIT_ORDER_TITLES)


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
    `calibration.hysteresis_fit`; 0 where only one direction was measured."""


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


def fit_points(points: Sequence[CalibrationPoint], degree: int) -> PolynomialFit:
    """Draw a polynomial through calibration points by least squares.

    Parameters
    ----------
    points : sequence of CalibrationPoint
        At least ``degree + 1`` different voltages.
    degree : int
        1 to 3.

    Returns
    -------
    PolynomialFit
        The curve; midway between the branches where both directions were measured.

    Raises
    ------
    CalibrationError
        If there are too few different voltages, or the curve turns back within them, so that
        one voltage would not tell one value.
    """
    readings = validate_readings(points, degree)
    return invertible_mean_curve(fit_with_hysteresis(readings, degree), readings)


def validate_readings(points: Sequence[CalibrationPoint], degree: int) -> CalibrationReadings:
    """Return points as arrays if a curve of the degree can be drawn through them.

    Raises
    ------
    CalibrationError
        If not; the sentence says why.
    """
    if not 1 <= degree <= MAX_DEGREE:
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


__all__ = [
    "FIT_ORDER_TITLES",
    "MAX_DEGREE",
    "CalibrationError",
    "CalibrationPoint",
    "Direction",
    "PolynomialFit",
    "evaluate_polynomial",
    "fit_points",
    "invertible_mean_curve",
    "turning_points",
    "validate_readings",
]

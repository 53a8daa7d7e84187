"""The curve through calibration points: value = c0 + c1 v + c2 v^2 + c3 v^3, v in volts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from gsapp.foundation import GroundStationError
from gsapp.quantities import FloatArray

Direction = Literal["up", "down", "single"]
MAX_DEGREE = 3


class CalibrationError(GroundStationError, ValueError):
    """Points from which no usable curve can be drawn."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CalibrationPoint:
    """One reading taken while calibrating.

    Attributes
    ----------
    volts : float
        Voltage read, V.
    value : float
        What the instrument was set to, in the unit of the certificate.
    direction : {"up", "down", "single"}
        Whether the value was reached from below or from above; ``single`` where it was not noted.
    """

    volts: float
    value: float
    direction: Direction = "single"


@dataclass(frozen=True, slots=True, kw_only=True)
class Fit:
    """A polynomial in volts and how well it represents the points.

    Attributes
    ----------
    coefficients : tuple of float
        Ascending powers of volts, in the unit of the values per V^n.
    residuals : tuple of float
        Value minus curve, for each point.
    rms, maximum : float
        Root mean square (with the degrees of freedom left) and largest absolute residual.
    hysteresis : float
        Largest distance between the upward and the downward branch, in the unit of the values;
        0 where only one direction was measured.
    """

    coefficients: tuple[float, ...]
    residuals: tuple[float, ...]
    rms: float
    maximum: float
    hysteresis: float


def polynomial(coefficients: Sequence[float], volts: FloatArray) -> FloatArray:
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


def fit_points(points: Sequence[CalibrationPoint], degree: int) -> Fit:
    """Draw a polynomial through calibration points by least squares.

    Parameters
    ----------
    points : sequence of CalibrationPoint
        At least ``degree + 1`` different voltages.
    degree : int
        1 to 3.

    Returns
    -------
    Fit
        The curve; it lies midway between the branches where both directions were measured alike.

    Raises
    ------
    CalibrationError
        If there are too few different voltages, or the curve turns back within them, so that
        one voltage would not tell one value.
    """
    if not 1 <= degree <= MAX_DEGREE:
        raise CalibrationError(
            f"a calibration curve of degree {degree} is not offered; use 1, 2 or 3"
        )
    volts = np.array([point.volts for point in points], dtype=np.float64)
    values = np.array([point.value for point in points], dtype=np.float64)
    different = np.unique(volts).size
    if different <= degree:
        raise CalibrationError(
            f"a curve of degree {degree} needs at least {degree + 1} different voltages, "
            f"and there are {different}; take more points or lower the degree"
        )
    # Fitted about the middle of the range: powers of raw volts are nearly dependent.
    domain = (float(volts.min()), float(volts.max()))
    curve = np.polynomial.Polynomial.fit(volts, values, degree, domain=domain)
    coefficients = np.zeros(degree + 1)
    converted = curve.convert().coef
    coefficients[: converted.size] = converted
    turning = turning_points(coefficients.tolist(), *domain)
    if turning:
        raise CalibrationError(
            f"the curve turns back at {turning[0]:.3f} V, so that one voltage would mean two "
            "values; check the points there, or lower the degree"
        )
    if coefficients[1:].any() is np.False_ or values.min() == values.max():
        raise CalibrationError("all points have the same value; move the instrument between them")
    residuals = values - polynomial(coefficients.tolist(), volts)
    freedom = max(volts.size - degree - 1, 1)
    return Fit(
        coefficients=tuple(float(c) for c in coefficients),
        residuals=tuple(float(r) for r in residuals),
        rms=float(np.sqrt(np.sum(residuals**2) / freedom)),
        maximum=float(np.max(np.abs(residuals))),
        hysteresis=_hysteresis(points, volts, residuals),
    )


def _hysteresis(
    points: Sequence[CalibrationPoint], volts: FloatArray, residuals: FloatArray
) -> float:
    """Return the largest distance between the branches where both were measured."""
    branches = []
    for direction in ("up", "down"):
        chosen = np.array([point.direction == direction for point in points], dtype=bool)
        if np.count_nonzero(chosen) < 2:
            return 0.0
        order = np.argsort(volts[chosen], kind="stable")
        branches.append((volts[chosen][order], residuals[chosen][order]))
    (up_v, up_r), (down_v, down_r) = branches
    low, high = max(up_v[0], down_v[0]), min(up_v[-1], down_v[-1])
    if low > high:
        return 0.0
    places = np.union1d(up_v, down_v)
    places = places[(places >= low) & (places <= high)]
    distance = np.interp(places, up_v, up_r) - np.interp(places, down_v, down_r)
    return float(np.max(np.abs(distance))) if places.size else 0.0

"""A new calibration against a former one, and a few points against the one in force.

Values set are held against what the former curve shows at the volts read: what remains is a shift
of zero and a change of slope, d = zero + slope * shown, found by least squares. Both count only
beyond what the scatter of the points and the uncertainty of the former curve explain.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from calibration.certificate import Certificate
from calibration.points import CalibrationError, CalibrationPoint
from calibration.polynomial_fit import CalibrationReadings, HysteresisFit, fit_with_hysteresis
from calibration.quality import student_t_95
from calibration.settings import CALIBRATION
from gsapp.foundation import StrictModel
from gsapp.quantities import FloatArray, channel, from_si


class Shift(StrictModel):
    """Zero and slope of values against a certificate, with 95 % half widths."""

    zero: float
    """Value now minus value by the certificate, at zero (or at the middle of the range, where zero
    is not in it), in the unit of the certificate."""
    zero_uncertainty: float
    slope: float
    """Relative: 0.01 where the value now changes by 1 % more for the same volts."""
    slope_uncertainty: float


class Drift(Shift):
    """How far an instrument has moved from a former certificate."""

    significant: bool
    """Whether zero or slope moved by more than points taken like these explain (99 %)."""
    sentence: str
    """For the person at the screen."""


class CheckResult(Shift):
    """What a few points say of the certificate in force."""

    largest: float
    """Largest distance of a point from the certificate, its branch allowed for, in the unit."""
    off: tuple[float, ...]
    """How far each point lies off the certificate, its branch allowed for, in the unit and in their
    order."""
    passed: bool
    """Whether the certificate still holds."""
    sentence: str
    """For the person at the screen."""


def compute_drift(new: Certificate, former: Certificate) -> Drift:
    """Return how far an instrument moved between two certificates.

    Parameters
    ----------
    former : Certificate
        Of the same channel. Its uncertainty counts where it holds its points.

    Raises
    ------
    CalibrationError
        If they are of different channels or units, or the new one holds too few points.
    """
    if (new.channel, new.unit) != (former.channel, former.unit):
        raise CalibrationError(
            f"a certificate of {new.channel} in {new.unit} cannot be compared with one of "
            f"{former.channel} in {former.unit}; give a former one of the same channel and unit"
        )
    ratio = 1.0
    if new.ratiometric and former.ratiometric and new.excitation_voltage:
        ratio = (former.excitation_voltage or new.excitation_voltage) / new.excitation_voltage
    points = [replace(point, volts=point.volts * ratio) for point in new.points]
    shift, significant, _ = _fit_shift(former, points)
    verdict = "more than the points explain" if significant else "within the uncertainty"
    text = f"since {former.stamp:%Y-%m-%d %H:%M} {_shift_text(shift, former)}, {verdict}"
    return Drift(**shift.model_dump(), significant=significant, sentence=text)


def check_certificate(certificate: Certificate, points: Sequence[CalibrationPoint]) -> CheckResult:
    """Hold a few points, usually three, against the certificate in force.

    Parameters
    ----------
    points : sequence of CalibrationPoint
        In its unit, volts referred to its supply; at two settings or more.

    Raises
    ------
    CalibrationError
        If the points are at fewer than two settings.
    """
    shift, significant, largest = _fit_shift(certificate, points)
    text = _shift_text(shift, certificate)
    return CheckResult(
        **shift.model_dump(),
        largest=largest,
        off=tuple(_branch_residuals(certificate, CalibrationReadings.from_points(points)).tolist()),
        passed=not significant,
        sentence=(
            f"{text}; certificate invalid, calibrate again"
            if significant
            else f"certificate valid: {text}, within the uncertainty"
        ),
    )


def has_hysteresis(certificate: Certificate) -> bool:
    """Return whether a certificate tells how far the way up and the way down are apart.

    Then it does not matter from which side a setting is come to, as long as that is known.
    """
    return (
        certificate.hysteresis > 0.0
        or CalibrationReadings.from_points(certificate.points).two_sided
    )


def _fit_shift(
    reference: Certificate, points: Sequence[CalibrationPoint]
) -> tuple[Shift, bool, float]:
    """Fit d = zero + slope (shown - pivot), and half the growth of the loop where both are met.

    Return the shift, whether it is significant, and the largest distance of a point.
    """
    # SciPy's special functions take a third of a second to import; no window waits for them.
    from scipy.special import fdtrc

    curve = _branch_fit(reference)
    readings = _readings_in_range(reference, points)
    volts, side = readings.volts, readings.side
    shown = _indicated_values(reference, volts)
    pivot = _pivot(shown)
    width = reference.hysteresis
    apart = _branch_residuals(reference, readings)
    columns = [np.ones(volts.size), shown - pivot]
    if readings.two_sided and len(readings) > 4:
        columns.append(0.5 * side)
    design = np.column_stack(columns)
    unknown = 0.25 * width**2 * (side == 0.0)
    scatter, freedom = _pooled_scatter(design, apart, curve, unknown)
    alone = scatter**2 + unknown
    noise = np.diag(alone)
    if curve is not None:
        rows = curve.design_matrix(volts, side)
        noise = noise + scatter**2 * rows @ curve.covariance @ rows.T
    root = 1.0 / np.sqrt(np.maximum(alone, 1e-300))
    solve = np.linalg.pinv(design * root[:, None]) * root
    found = solve @ apart
    covariance = (solve @ noise @ solve.T)[:2, :2]
    std = np.sqrt(np.diag(covariance))
    factor = student_t_95(freedom)
    square = float(found[:2] @ np.linalg.pinv(covariance) @ found[:2])
    shift = Shift(
        zero=float(found[0]),
        zero_uncertainty=float(std[0] * factor),
        slope=float(found[1]),
        slope_uncertainty=float(std[1] * factor),
    )
    significant = bool(fdtrc(2.0, freedom, 0.5 * square) < CALIBRATION.drift_significance)
    return shift, significant, float(np.max(np.abs(apart)))


def _indicated_values(certificate: Certificate, volts: FloatArray) -> FloatArray:
    quantity = channel(certificate.channel).quantity
    return np.asarray(from_si(certificate.evaluate(volts), certificate.unit, quantity))


def _branch_residuals(certificate: Certificate, readings: CalibrationReadings) -> FloatArray:
    branch = 0.5 * readings.side * certificate.hysteresis
    return np.asarray(readings.values - _indicated_values(certificate, readings.volts) - branch)


def _pooled_scatter(
    design: FloatArray, apart: FloatArray, curve: HysteresisFit | None, unknown: FloatArray
) -> tuple[float, float]:
    """Return the scatter of a setting and its freedom, from both sets of points together."""
    weights = 1.0 / (1.0 + unknown / max(float(np.var(apart)), 1e-300))
    root = np.sqrt(weights)
    solution = np.linalg.lstsq(design * root[:, None], apart * root, rcond=None)[0]
    square = float(np.sum(weights * (apart - design @ solution) ** 2))
    freedom = max(float(weights.sum()) - design.shape[1], 0.0)
    if curve is not None and np.isfinite(curve.scatter):
        square += curve.degrees_of_freedom * curve.scatter**2
        freedom += curve.degrees_of_freedom
    if freedom <= 0.0:
        raise CalibrationError(
            "two points without an earlier scatter cannot show a shift; take a third setting"
        )
    return float(np.sqrt(square / freedom)), freedom


def _branch_fit(certificate: Certificate) -> HysteresisFit | None:
    if np.unique([point.volts for point in certificate.points]).size <= certificate.degree:
        return None
    return fit_with_hysteresis(
        CalibrationReadings.from_points(certificate.points), certificate.degree
    )


def _readings_in_range(
    reference: Certificate, points: Sequence[CalibrationPoint]
) -> CalibrationReadings:
    """Return the points that the reference's range reaches, give or take a tenth of it."""
    low, high = reference.range
    reach = 0.1 * (high - low)
    chosen = [point for point in points if low - reach <= point.volts <= high + reach]
    if len({point.value for point in chosen}) < 2:
        raise CalibrationError(
            f"{len(chosen)} of {len(points)} points are within the certificate's range of "
            f"{low:.2f} to {high:.2f} V, and points at two settings are needed; take more"
        )
    return CalibrationReadings.from_points(chosen)


def _pivot(shown: FloatArray) -> float:
    low, high = float(shown.min()), float(shown.max())
    return 0.0 if low <= 0.0 <= high else 0.5 * (low + high)


def _shift_text(shift: Shift, certificate: Certificate) -> str:
    # Adding zero takes the sign from a rounded -0.
    zero, slope = round(shift.zero, 2) + 0.0, round(100.0 * shift.slope, 1) + 0.0
    return (
        f"the zero moved by {zero:+.2f} +- {shift.zero_uncertainty:.2f} {certificate.unit} "
        f"and the slope by {slope:+.1f} +- {100.0 * shift.slope_uncertainty:.1f} %"
    )

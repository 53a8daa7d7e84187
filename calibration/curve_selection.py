"""Which curve the points deserve: straight, quadratic or cubic, by predicting what was left out.

One setting after the other is left out with all its points and predicted by a curve through the
others; a higher degree must predict better to be taken. A curve bent after the errors of its points
fails at that, above all at the ends.
"""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime

import numpy as np

from calibration.adc import ADC_RESOLUTION
from calibration.certificate import Certificate
from calibration.points import CalibrationError, CalibrationPoint
from calibration.polynomial_fit import (
    CalibrationReadings,
    HysteresisFit,
    fit_with_hysteresis,
    invertible_mean_curve,
    validate_readings,
)
from calibration.quality import Calibration, assess_quality
from calibration.settings import CALIBRATION
from gsapp.quantities import BoolArray, FloatArray


def fit_calibration(
    points: Sequence[CalibrationPoint],
    *,
    degree: int | None = None,
    travel: tuple[float, float] | None = None,
    setting_error: float | None = None,
    resolution: float = ADC_RESOLUTION,
) -> Calibration:
    """Draw a curve through calibration points and judge it.

    Parameters
    ----------
    points : sequence of CalibrationPoint
        In any order; all in one unit, all volts referred to one supply.
    degree : int, optional
        1 to 3; without it the points decide.
    travel : tuple of float, optional
        Of the surface, in the unit of the values.
    setting_error : float, optional
        Standard deviation of one setting as known beforehand, in the unit of the values: about
        0.15 deg for a protractor read to half a degree. Without it the points alone tell.
    resolution : float, optional
        Smallest step of the volts, or of what stands for them.

    Returns
    -------
    Calibration
        Its outliers are pointed out, not left out: they are for the person to repeat or delete.

    Raises
    ------
    CalibrationError
        If no curve that can be inverted goes through the points.
    """
    readings = validate_readings(points, degree or 1)
    outliers = find_outliers(readings, setting_error=setting_error)
    clean = np.ones(len(readings), dtype=bool)
    clean[list(outliers)] = False
    losses = {
        tried: float(np.sqrt(np.mean(errors**2)))
        for tried, errors in _cross_validation_errors(readings.subset(clean)).items()
    }
    chosen = degree or _select_degree(losses)
    while True:
        try:
            branch_fit = fit_with_hysteresis(readings, chosen, setting_error=setting_error)
            fit = invertible_mean_curve(branch_fit, readings)
            break
        except CalibrationError:
            # A degree that was asked for is refused; one that was chosen gives way.
            if degree is not None or chosen == 1:
                raise
            chosen -= 1
    if degree is None and len(losses) > 1:
        branch_fit = branch_fit.spend_degree_of_freedom()
    quality = assess_quality(
        fit,
        readings,
        branch_fit,
        rivals=_competing_fits(readings, losses, chosen, setting_error),
        travel=travel,
        count=resolution,
        outliers=outliers,
    )
    return Calibration(fit=fit, quality=quality, losses=losses, branch_fit=branch_fit)


def create_certificate(
    calibration: Calibration,
    points: Sequence[CalibrationPoint],
    *,
    channel_id: str,
    unit: str,
    who: str,
    stamp: datetime,
    excitation_voltage: float | None = None,
    ratiometric: bool = False,
    temperature: float | None = None,
    instrument: str = "",
    notes: str = "",
    signal_unit: str = "V",
) -> Certificate:
    """Write down a calibration as the certificate of an instrument."""
    volts = [point.volts for point in points]
    return Certificate(
        channel=channel_id,
        unit=unit,
        coefficients=calibration.fit.coefficients,
        range=(min(volts), max(volts)),
        who=who,
        stamp=stamp.replace(microsecond=0),
        points=tuple(points),
        hysteresis=calibration.fit.hysteresis,
        rms_residual=calibration.fit.rms,
        max_residual=calibration.fit.max_residual,
        excitation_voltage=excitation_voltage,
        ratiometric=ratiometric,
        temperature=temperature,
        instrument=instrument,
        notes=notes,
        quality=calibration.quality,
        signal_unit=signal_unit,
    )


def find_outliers(
    readings: CalibrationReadings, *, setting_error: float | None = None
) -> tuple[int, ...]:
    """Return the points that do not fit the others, worst first.

    The point farthest from the curve of the others is set aside, then the next, up to a quarter of
    all; from the last one back, those count whose distance chance alone would reach in one
    calibration of fifty. So two that are wrong alike do not hide each other (Rosner's
    generalized test).
    """
    aside: list[int] = []
    outlying = 0
    kept = np.ones(len(readings), dtype=bool)
    while len(aside) < len(readings) // 4:
        rest = readings.subset(kept)
        degrees = [
            d for d in range(1, CALIBRATION.max_degree + 1) if np.unique(rest.volts).size >= d + 4
        ]
        farthest = [_find_worst_outlier(rest, degree, setting_error) for degree in degrees]
        if not farthest:
            break
        # By the curve that leaves the others the least scatter.
        _, excess, place = min(farthest)
        index = int(np.flatnonzero(kept)[place])
        aside.append(index)
        kept[index] = False
        if excess > 1.0:
            outlying = len(aside)
    return tuple(aside[:outlying])


def _find_worst_outlier(
    readings: CalibrationReadings, degree: int, setting_error: float | None
) -> tuple[float, float, int]:
    """Return the point farthest from the curve of the others.

    By the leverages of one fit through all: leaving a point out moves the curve there by
    ``residual * leverage / (1 - leverage)``.

    Returns
    -------
    tuple of float, float, int
        Scatter of the others; distance over what chance allows; index of the point.
    """
    # SciPy's special functions take a third of a second to import; no window waits for them.
    from scipy.special import stdtrit

    fit = fit_with_hysteresis(readings, degree, setting_error=setting_error)
    freedom = fit.degrees_of_freedom - 1.0
    if freedom < 2.0:
        return np.inf, 0.0, 0
    rows = fit.design_matrix(readings.volts, readings.side)
    leverage = fit.weights * np.einsum("ni,ij,nj->n", rows, fit.covariance, rows)
    kept = np.maximum(1.0 - leverage, 1e-9)
    gone = fit.weights * fit.residuals**2 / kept
    scatter = np.sqrt(np.maximum(fit.degrees_of_freedom * fit.scatter**2 - gone, 0.0) / freedom)
    index = int(np.argmax(np.where(leverage < 0.999, gone, 0.0)))
    allowed = float(stdtrit(freedom, 1.0 - 0.5 * CALIBRATION.outlier_significance / len(readings)))
    # Rounding is no outlier: without any scatter there is nothing to compare with.
    least = max(float(scatter[index]), 1e-9 * float(np.ptp(readings.values)))
    return least, float(np.sqrt(gone[index])) / (allowed * least), index


def _cross_validation_errors(readings: CalibrationReadings) -> dict[int, FloatArray]:
    """Return by degree the errors of predicting each setting from the others, shape (settings,)."""
    numbers = np.unique(readings.settings)
    errors: dict[int, FloatArray] = {}
    for degree in range(1, CALIBRATION.max_degree + 1):
        # With a freedom left, so that passing through every point proves nothing.
        if numbers.size < degree + 2:
            break
        fit = fit_with_hysteresis(readings, degree)
        errors[degree] = np.array(
            [_prediction_error(readings, fit, readings.settings == number) for number in numbers]
        )
    return errors


def _prediction_error(
    readings: CalibrationReadings, fit: HysteresisFit, left_out: BoolArray
) -> float:
    """Return by how much the mean of some points is missed by a curve through the others."""
    rows = fit.design_matrix(readings.volts, readings.side)
    root = np.sqrt(fit.weights)
    solution = np.linalg.lstsq(
        (rows * root[:, None])[~left_out], (readings.values * root)[~left_out], rcond=None
    )[0]
    errors = readings.values - rows @ solution
    return float(np.average(errors[left_out], weights=fit.weights[left_out]))


def _select_degree(losses: dict[int, float]) -> int:
    """Return the degree that predicts best; a higher one only where it gains something."""
    best = 1
    for degree, loss in losses.items():
        if loss < CALIBRATION.max_loss_ratio * losses[best]:
            best = degree
    return best


def _competing_fits(
    readings: CalibrationReadings,
    losses: dict[int, float],
    chosen: int,
    setting_error: float | None,
) -> list[tuple[float, HysteresisFit]]:
    """Return the other degrees with their shares, by how nearly as good they predict.

    The share goes with the likelihood of the prediction errors, loss^-settings.
    """
    if chosen not in losses:
        return []
    count = np.unique(readings.settings).size
    least = max(min(losses.values()), 1e-12)
    odds = {degree: (max(loss, 1e-12) / least) ** -count for degree, loss in losses.items()}
    total = sum(odds.values())
    return [
        (odds[degree] / total, fit_with_hysteresis(readings, degree, setting_error=setting_error))
        for degree in losses
        if degree != chosen
    ]

"""Which curve the points deserve: straight, quadratic or cubic, by predicting what was left out.

One setting after the other is left out with all its points and predicted by a curve through the
others; a higher degree must predict better to be taken. A curve bent after the errors of its points
fails at that, above all at the ends.
"""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime

import numpy as np

from calibration.branches import BranchFit, Readings, fit_branches
from calibration.certificate import Certificate
from calibration.fit import MAX_DEGREE, checked_readings, curve_of
from calibration.points import CalibrationError, CalibrationPoint
from calibration.quality import Calibration, assess
from gsapp.quantities import BoolArray, FloatArray

OUTLIER_CHANCE = 0.01
"""How often points without any outlier have one pointed out."""


def calibrate(
    points: Sequence[CalibrationPoint],
    *,
    degree: int | None = None,
    travel: tuple[float, float] | None = None,
    max_degree: int = MAX_DEGREE,
    bits: int = 12,
    full_scale: float = 5.0,
    setting_error: float | None = None,
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
    max_degree : int
        The highest that may be chosen.
    bits, full_scale : int, float
        Of the converter; full scale in V.
    setting_error : float, optional
        Standard deviation of one setting as known beforehand, in the unit of the values: about
        0.15 deg for a protractor read to half a degree. Without it the points alone tell.

    Returns
    -------
    Calibration
        Its outliers are pointed out, not left out: they are for the person to repeat or delete.

    Raises
    ------
    CalibrationError
        If no curve that can be inverted goes through the points.
    """
    readings = checked_readings(points, degree or 1)
    outliers = find_outliers(readings, setting_error=setting_error)
    clean = np.ones(len(readings), dtype=bool)
    clean[list(outliers)] = False
    losses = {
        tried: float(np.sqrt(np.mean(errors**2)))
        for tried, errors in _left_out(readings.only(clean), max_degree).items()
    }
    chosen = degree or _choice(readings.only(clean), max_degree)
    while True:
        try:
            branch_fit = fit_branches(readings, chosen, setting_error=setting_error)
            fit = curve_of(branch_fit, readings)
            break
        except CalibrationError:
            # A degree that was asked for is refused; one that was chosen gives way.
            if degree is not None or chosen == 1:
                raise
            chosen -= 1
    quality = assess(
        fit, readings, branch_fit, travel=travel, count=full_scale / 2**bits, outliers=outliers
    )
    return Calibration(fit=fit, quality=quality, losses=losses, branch_fit=branch_fit)


def certify(
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
) -> Certificate:
    """Write down a calibration as the certificate of an instrument.

    Parameters
    ----------
    calibration : Calibration
        From `calibrate`.
    points : sequence of CalibrationPoint
        The points that it was drawn through.
    channel_id, unit, who, stamp, excitation_voltage, ratiometric, temperature, instrument, notes
        As in `Certificate`.

    Returns
    -------
    Certificate
    """
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
        max_residual=calibration.fit.maximum,
        excitation_voltage=excitation_voltage,
        ratiometric=ratiometric,
        temperature=temperature,
        instrument=instrument,
        notes=notes,
        quality=calibration.quality,
    )


def find_outliers(readings: Readings, *, setting_error: float | None = None) -> tuple[int, ...]:
    """Return the points that do not fit the others, worst first.

    Each point is held against a curve through the others, in units of what such a difference
    varies by; the worst is set aside where chance alone would do that in one calibration of a
    hundred, and the rest are tried again. The curve is the one that the rest deserve.

    Returns
    -------
    tuple of int
        Indices; at most a quarter of the points.
    """
    found: list[int] = []
    kept = np.ones(len(readings), dtype=bool)
    while len(found) < len(readings) // 4:
        indices = np.flatnonzero(kept)
        rest = readings.only(kept)
        # The lowest degree by which some point is no outlier makes it none.
        worst: tuple[float, int] | None = None
        for degree in range(1, MAX_DEGREE + 1):
            if np.unique(rest.volts).size < degree + 4:
                break
            excess = _deleted_residuals(rest, degree, setting_error)
            place = int(np.argmax(excess))
            if worst is None or excess[place] < worst[0]:
                worst = float(excess[place]), int(indices[place])
        if worst is None or worst[0] <= 1.0:
            break
        found.append(worst[1])
        kept[worst[1]] = False
    return tuple(found)


def _deleted_residuals(readings: Readings, degree: int, setting_error: float | None) -> FloatArray:
    """Return how far each point is from the curve of the others, over what chance allows."""
    from scipy.special import stdtrit

    result = np.zeros(len(readings))
    for index in range(len(readings)):
        others = np.arange(len(readings)) != index
        fit = fit_branches(readings.only(others), degree, setting_error=setting_error)
        if not np.isfinite(fit.scatter) or fit.freedom < 2.0:
            continue
        volts, side = readings.volts[index : index + 1], readings.side[index]
        apart = float(abs(readings.values[index] - fit.value(volts, side)[0]))
        if side == 0.0:
            apart = max(apart - 0.5 * abs(fit.hysteresis or 0.0), 0.0)
        spread = float(np.sqrt(fit.variance(volts, side)[0] + fit.scatter**2))
        chance = OUTLIER_CHANCE / len(readings)
        allowed = float(stdtrit(fit.freedom, 1.0 - 0.5 * chance)) * spread
        result[index] = apart / allowed if allowed > 0.0 else 0.0
    return result


def _left_out(readings: Readings, max_degree: int) -> dict[int, FloatArray]:
    """Return by degree the errors of predicting each setting from the others, shape (settings,)."""
    numbers = np.unique(readings.settings)
    errors: dict[int, FloatArray] = {}
    for degree in range(1, max_degree + 1):
        # With a freedom left, so that passing through every point proves nothing.
        if numbers.size < degree + 2:
            break
        errors[degree] = np.array(
            [_prediction_error(readings, readings.settings == number, degree) for number in numbers]
        )
    return errors


def _prediction_error(readings: Readings, left_out: BoolArray, degree: int) -> float:
    fit: BranchFit = fit_branches(readings.only(~left_out), degree)
    group = readings.only(left_out)
    errors = group.values - fit.value(group.volts, group.side)
    known = group.side != 0.0
    # A point between the branches tells of the curve only what those beside it cannot.
    chosen = errors[known] if known.any() else errors
    return float(np.mean(chosen))


def _choice(readings: Readings, max_degree: int) -> int:
    """Return the degree that predicts best; a higher one only where it is clearly better."""
    errors = _left_out(readings, max_degree)
    best = 1
    for degree in errors:
        gain = errors[best] ** 2 - errors[degree] ** 2
        if float(np.mean(gain)) > float(np.std(gain, ddof=1)) / np.sqrt(gain.size):
            best = degree
    return best

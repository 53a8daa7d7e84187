"""Calibrations for programs: SI units, volts; absent = None."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from calibration.drift import Drift
from calibration.points_calibration import PointsCalibration
from calibration.quality import CalibrationQuality
from gsapp.quantities import channel, to_si


def certificate_json(found: PointsCalibration, out: Path) -> dict[str, Any]:
    """Return what a file of points gave; `out` is the certificate written."""
    certificate, made = found.certificate, found.calibration
    _, si = si_converters(certificate.channel, certificate.unit)
    quality = made.quality
    return {
        "certificate": str(out),
        "channel": certificate.channel,
        "unit": channel(certificate.channel).unit,
        "degree": made.degree,
        "coefficients": list(certificate.si_coefficients),
        "range": list(certificate.range),
        "losses": {str(degree): si(loss) for degree, loss in made.losses.items()},
        "quality": quality_json(quality, certificate.channel, certificate.unit),
        "residuals": [si(residual) for residual in made.fit.residuals],
        "outliers": list(quality.outliers),
        "former": [
            {"certificate": str(path), **drift_json(drift, certificate.channel, certificate.unit)}
            for path, drift in found.drifts
        ],
        "remarks": list(found.remarks),
    }


def si_converters(
    channel_id: str, unit: str
) -> tuple[Callable[[float], float], Callable[[float | None], float | None]]:
    """Return what makes a value, and what makes a difference of values, SI.

    Parameters
    ----------
    channel_id, unit : str
        Of the certificate.
    """
    quantity = channel(channel_id).quantity
    offset = to_si(0.0, unit, quantity)
    factor = to_si(1.0, unit, quantity) - offset

    def value(number: float) -> float:
        return number * factor + offset

    def difference(number: float | None) -> float | None:
        return None if number is None else number * factor

    return value, difference


def quality_json(quality: CalibrationQuality, channel_id: str, unit: str) -> dict[str, Any]:
    """Return the figures of a calibration for programs: SI, volts; absent = null."""
    value, si = si_converters(channel_id, unit)
    return {
        "rms": si(quality.rms),
        "maximum": si(quality.max_residual),
        "linearity": si(quality.linearity),
        "scatter": si(quality.scatter),
        "hysteresis": si(quality.hysteresis),
        "hysteresis_uncertainty": si(quality.hysteresis_uncertainty),
        "return_to_zero": si(quality.return_to_zero),
        "resolution": si(quality.resolution),
        "covered": [value(end) for end in quality.covered],
        "coverage": quality.coverage,
        "uncertainty": {
            "volts": list(quality.uncertainty_volts),
            "half_width": [si(width) for width in quality.half_widths],
        },
    }


def drift_json(drift: Drift, channel_id: str, unit: str) -> dict[str, Any]:
    """Return how far an instrument moved, for programs: zero in SI, slope relative."""
    _, si = si_converters(channel_id, unit)
    return {
        "zero": si(drift.zero),
        "zero_uncertainty": si(drift.zero_uncertainty),
        "slope": drift.slope,
        "slope_uncertainty": drift.slope_uncertainty,
        "significant": drift.significant,
    }

"""Volts to engineering units: points, fits, hysteresis, certificates."""

from calibration.certificate import Certificate
from calibration.fit import Fit, fit_points
from calibration.points import CalibrationError, CalibrationPoint
from calibration.reading import (
    certificate_content,
    certificate_files,
    load_certificate,
    load_certificates,
    shipped_sets,
    write_certificate,
)

__all__ = [
    "CalibrationError",
    "CalibrationPoint",
    "Certificate",
    "Fit",
    "certificate_content",
    "certificate_files",
    "fit_points",
    "load_certificate",
    "load_certificates",
    "shipped_sets",
    "write_certificate",
]

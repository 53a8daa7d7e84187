"""Volts to engineering units: points, fits, hysteresis, certificates."""

from calibration.certificate import Certificate
from calibration.certificate_toml import (
    certificate_content,
    certificate_paths,
    load_certificate,
    load_certificates,
    shipped_certificate_sets,
    write_certificate,
)
from calibration.points import CalibrationError, CalibrationPoint

__all__ = [
    "CalibrationError",
    "CalibrationPoint",
    "Certificate",
    "certificate_content",
    "certificate_paths",
    "load_certificate",
    "load_certificates",
    "shipped_certificate_sets",
    "write_certificate",
]

"""Straight instruments: certificates from zero and sensitivity, and the figures of the factory.

With x = (v - z) / k the half width of the value that one sample v tells is

    u^2 = (u_z / k)^2 + (x u_k / k)^2 + (1.96 s / k)^2 + (step / 2 k)^2,

u_z and u_k being half widths at 95 %, s the standard deviation of a sample.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import cache
from types import MappingProxyType
from typing import Literal

import numpy as np

from calibration.adc import ADC_RESOLUTION
from calibration.certificate import Certificate
from calibration.certificate_toml import load_certificates
from calibration.points import CalibrationPoint
from calibration.quality import CalibrationQuality
from calibration.settings import CALIBRATION
from gsapp.quantities import FloatArray, channel, from_si, to_si


@dataclass(frozen=True, slots=True, kw_only=True)
class StraightLineCalibration:
    """What was found of an instrument."""

    zero: float
    zero_uncertainty: float
    """V; half width at 95 %."""
    sensitivity: float
    sensitivity_uncertainty: float
    """V per unit; half width at 95 %."""
    noise: float
    """Standard deviation of a sample, V."""
    range: tuple[float, float]
    """Volts between which it holds; widened where a point lies outside."""

    def value(self, volts: FloatArray) -> FloatArray:
        """Return what volts stand for."""
        return np.asarray((volts - self.zero) / self.sensitivity)

    def half_width(self, volts: FloatArray) -> FloatArray:
        """Return the half width at 95 % of what one sample tells."""
        parts = [
            np.full(volts.shape, self.zero_uncertainty),
            self.value(volts) * self.sensitivity_uncertainty,
            np.full(volts.shape, 1.96 * self.noise),
            np.full(volts.shape, 0.5 * ADC_RESOLUTION),
        ]
        return np.asarray(np.linalg.norm(parts, axis=0) / abs(self.sensitivity))

    def certificate(
        self,
        channel: str,
        unit: str,
        points: Sequence[CalibrationPoint],
        *,
        who: str,
        stamp: datetime,
        temperature: float | None,
        instrument: str,
        notes: str,
    ) -> Certificate:
        """Return the certificate; parameters as in `Certificate`."""
        volts = np.array([point.volts for point in points])
        values = np.array([point.value for point in points])
        residuals = values - self.value(volts)
        low, high = min(self.range[0], *volts), max(self.range[1], *volts)
        places = np.linspace(low, high, CALIBRATION.line_points)
        rms, largest = float(np.sqrt(np.mean(residuals**2))), float(np.max(np.abs(residuals)))
        quality = CalibrationQuality(
            degree=1,
            rms=rms,
            max_residual=largest,
            linearity=0.0,
            resolution=ADC_RESOLUTION / abs(self.sensitivity),
            covered=(float(values.min()), float(values.max())),
            uncertainty_volts=tuple(places.tolist()),
            half_widths=tuple(self.half_width(places).tolist()),
        )
        return Certificate(
            channel=channel,
            unit=unit,
            coefficients=(-self.zero / self.sensitivity, 1.0 / self.sensitivity),
            range=(float(low), float(high)),
            who=who,
            stamp=stamp.replace(microsecond=0),
            points=tuple(points),
            rms_residual=rms,
            max_residual=largest,
            temperature=temperature,
            instrument=instrument,
            notes=notes,
            quality=quality,
        )


SensorVerdictKind = Literal["agrees", "differs", "dead", "reversed", "swapped", "clipped"]


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorVerdict:
    """What became of the comparison with the factory's figures."""

    kind: SensorVerdictKind
    """``agrees`` and ``differs``: the instrument can be used as measured."""
    sentence: str

    @property
    def passed(self) -> bool:
        """Return whether the instrument is as the factory made it."""
        return self.kind == "agrees"

    @property
    def usable(self) -> bool:
        """Return whether its own volts tell its own quantity, whatever the figures."""
        return self.kind in ("agrees", "differs", "reversed")


@dataclass(frozen=True, slots=True, kw_only=True)
class FactoryCalibration:
    """A straight line by the factory."""

    channel: str
    unit: str
    """Of what is measured."""
    zero: float
    """Volts at zero."""
    sensitivity: float
    """V per unit."""
    range: tuple[float, float]
    """Volts between which it holds."""

    @classmethod
    def from_certificate(cls, certificate: Certificate) -> FactoryCalibration:
        """Return the figures that a certificate stands for; straight between its ends if curved."""
        ends = certificate.evaluate(np.array(certificate.range))
        key = channel(certificate.channel).quantity
        rise = from_si(float(ends[1] - ends[0]), certificate.unit, key)
        return cls(
            channel=certificate.channel,
            unit=certificate.unit,
            zero=float(certificate.volts(to_si(0.0, certificate.unit, key))),
            sensitivity=(certificate.range[1] - certificate.range[0]) / rise,
            range=certificate.range,
        )


@cache
def factory_calibrations() -> Mapping[str, FactoryCalibration]:
    """Return the figures of the model airliner: gyros in deg/s, accelerometers in g (3.5.3)."""
    names = ("p", "q", "r", "ax", "ay", "an")
    certificates = load_certificates("b777")
    return MappingProxyType(
        {name: FactoryCalibration.from_certificate(certificates[name]) for name in names}
    )

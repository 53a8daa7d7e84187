"""What is measured held against the figures of the factory."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import Literal

import numpy as np

from calibration.certificate import Certificate
from calibration.certificate_toml import load_certificates
from gsapp.quantities import channel, from_si, to_si

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

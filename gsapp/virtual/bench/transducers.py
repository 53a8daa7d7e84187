"""Gyros, accelerometers and pressure transducers as they really are on one aircraft."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from calibration.certificate import Certificate
from gsapp.aircraft import Aircraft
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import DEGREE, GRAVITY

GYROS = ("p", "q", "r")
ACCELEROMETERS = ("ax", "ay", "an")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SensorTriad:
    """Three instruments along the body axes: v = zero + matrix x."""

    zero: FloatArray  # Shape (3,). V.
    matrix: FloatArray
    """Shape (3, 3). V per unit; beside the diagonal what each picks up of the other axes."""
    noise: FloatArray  # Shape (3,). Standard deviation of a sample, V.
    drift: FloatArray  # Shape (3,). Of the zero, V/s.

    def reversed(self, index: int) -> SensorTriad:
        """Return these instruments with one mounted the other way round."""
        sense = np.ones(3)
        sense[index] = -1.0
        return replace(self, matrix=sense[:, None] * self.matrix)

    def volts(self, values: FloatArray, times: FloatArray, white: FloatArray) -> FloatArray:
        """Return the volts (n, 3) for values (n, 3), times (n,) in s and unit noise (n, 3)."""
        drifted = self.zero + times[:, None] * self.drift
        return np.asarray(drifted + values @ self.matrix.T + self.noise * white)


def _sample_triad(
    nominal: Mapping[str, Certificate],
    names: tuple[str, ...],
    unit: float,
    random: np.random.Generator,
    *,
    zero_std: float,
    noise: float,
    drift_std: float,
) -> SensorTriad:
    """Draw three instruments about straight certificates; stds in `unit` (SI)."""
    zero = np.array([float(nominal[name].volts(0.0)) for name in names])
    per_unit = np.array([float(nominal[name].volts(unit)) for name in names]) - zero
    # Misaligned by a degree or so, scaled by a percent or so, both about the factory's figures.
    lean = np.tan(random.normal(0.0, 0.8 * DEGREE, (3, 3)))
    np.fill_diagonal(lean, 1.0 + random.normal(0.0, 0.01, 3))
    return SensorTriad(
        zero=zero + per_unit * random.normal(0.0, zero_std, 3),
        matrix=per_unit[:, None] * lean,
        noise=np.abs(per_unit) * noise,
        drift=per_unit * random.normal(0.0, drift_std, 3),
    )


def sample_gyros(
    nominal: Mapping[str, Certificate], aircraft: Aircraft, random: np.random.Generator
) -> SensorTriad:
    """Draw the gyros; units are deg/s. The zero creeps by some hundredths of that a minute."""
    noise = aircraft.sensors.gyro.noise / DEGREE
    return _sample_triad(
        nominal, GYROS, DEGREE, random, zero_std=0.8, noise=noise, drift_std=0.02 / 60.0
    )


def sample_accelerometers(
    nominal: Mapping[str, Certificate], aircraft: Aircraft, random: np.random.Generator
) -> SensorTriad:
    """Draw the accelerometers; units are g."""
    noise = aircraft.sensors.accelerometer.noise / GRAVITY
    return _sample_triad(
        nominal, ACCELEROMETERS, GRAVITY, random, zero_std=0.02, noise=noise, drift_std=1e-6
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Transducer:
    """A straight instrument: v = zero + slope x, x in SI."""

    zero: float  # V.
    slope: float
    noise: float
    """V per unit, and standard deviation of a sample in V."""

    @classmethod
    def sample(
        cls, nominal: Certificate, random: np.random.Generator, *, zero_std: float, noise: float
    ) -> Transducer:
        """Draw one about a straight certificate; stds in SI."""
        zero = float(nominal.volts(0.0))
        slope = float(nominal.volts(1000.0)) / 1000.0 - zero / 1000.0
        return cls(
            zero=zero + slope * float(random.normal(0.0, zero_std)),
            slope=slope * (1.0 + float(random.normal(0.0, 0.003))),
            noise=abs(slope) * noise,
        )

    def reversed(self) -> Transducer:
        """Return it with its hoses exchanged."""
        return replace(self, slope=-self.slope)

    def volts(self, values: FloatArray, white: FloatArray) -> FloatArray:
        """Return the volts (n,) for values (n,) and unit noise (n,)."""
        return np.asarray(self.zero + self.slope * values + self.noise * white)

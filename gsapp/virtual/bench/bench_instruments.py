"""Potentiometers on surfaces and vanes: a bent curve behind a linkage with play.

With the surface at the angle a (deg), the shaft follows with play s,

    shaft = min(max(shaft, a - s/2), a + s/2),

and with L the travel and E the supply the volts are

    v = E / 5 (c + k (shaft + curvature shaft^2 / L + cubic shaft^3 / L^2)).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from calibration.certificate import Certificate
from gsapp.aircraft import Aircraft
from gsapp.foundation import FlightError
from gsapp.foundation.name_suggestions import did_you_mean
from gsapp.quantities import INSTRUMENTS, FloatArray
from gsapp.quantities.constants import DEGREE, GRAVITY
from gsapp.virtual.settings import VIRTUAL

SURFACE_POTENTIOMETERS = (
    "elevator_left",
    "elevator_right",
    "aileron_left",
    "aileron_right",
    "rudder",
)
VANE_POTENTIOMETERS = ("alpha", "beta")
POTENTIOMETERS = (*SURFACE_POTENTIOMETERS, *VANE_POTENTIOMETERS)

POTENTIOMETER_TRAVEL: Mapping[str, float] = MappingProxyType(
    dict.fromkeys(POTENTIOMETERS, 30.0)
    | dict.fromkeys(("elevator_left", "elevator_right", "aileron_left", "aileron_right"), 25.0)
)
"""To either side, deg."""
_FALLING = frozenset(("elevator_right", "beta"))
"""Mounted so that the volts fall with the angle."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Potentiometer:
    """One potentiometer as it really is."""

    center: float  # Volts at zero with 5 V supply.
    slope: float  # V/deg there.
    curvature: float
    cubic: float
    """Share of the slope's volts by which the curve is bent at the end of the travel."""
    travel: float  # deg to either side.
    play: float  # Of the linkage, deg: the whole distance between the two branches.
    noise: float  # Standard deviation of a sample, V.

    @classmethod
    def sample(cls, name: str, random: np.random.Generator) -> Potentiometer:
        vane = name in VANE_POTENTIOMETERS
        slope = random.uniform(0.036, 0.046) * (1.15 if vane else 1.0)
        return cls(
            center=float(random.uniform(2.3, 2.7)),
            slope=-slope if name in _FALLING else slope,
            curvature=float(random.uniform(-0.05, 0.05)),
            cubic=float(random.uniform(-0.02, 0.02)),
            travel=POTENTIOMETER_TRAVEL[name],
            play=float(random.uniform(0.04, 0.2) if vane else random.uniform(0.15, 0.7)),
            noise=float(random.uniform(0.8e-3, 2.0e-3)),
        )

    def volts(
        self, shaft: npt.ArrayLike, supply: npt.ArrayLike = VIRTUAL.nominal_supply
    ) -> FloatArray:
        """Return the volts (V) at angles of the shaft (deg), without noise."""
        a = np.asarray(shaft, dtype=np.float64)
        share = a / self.travel
        bent = a * (1.0 + self.curvature * share + self.cubic * share * share)
        volts = (self.center + self.slope * bent) * (np.asarray(supply) / VIRTUAL.nominal_supply)
        return np.asarray(volts, dtype=np.float64)

    def reversed(self) -> Potentiometer:
        """Return this potentiometer, mounted the other way round."""
        return replace(self, slope=-self.slope, curvature=-self.curvature)


class Linkage:
    """The play (deg) between a surface and the shaft of its potentiometer."""

    def __init__(self, play: float, shaft: float) -> None:
        self._half = 0.5 * play
        self.shaft = shaft

    def follow(self, angles: FloatArray) -> FloatArray:
        """Return the angle of the shaft (n,) while the surface goes through angles (n,), deg."""
        if not angles.size:
            return angles
        low, high = angles - self._half, angles + self._half
        if low.max() <= self.shaft <= high.min():
            return np.full(angles.size, self.shaft)
        shaft = self.shaft
        followed = np.empty(angles.size)
        for index, (lowest, highest) in enumerate(zip(low.tolist(), high.tolist(), strict=True)):
            shaft = min(max(shaft, lowest), highest)
            followed[index] = shaft
        self.shaft = shaft
        return followed


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


BenchFaultKind = Literal["dead", "reversed", "swapped", "noisy", "clipped"]
BENCH_FAULT_KINDS: tuple[BenchFaultKind, ...] = get_args(BenchFaultKind)
REVERSIBLE_CHANNELS = (*POTENTIOMETERS, *GYROS, *ACCELEROMETERS, "dynamic_pressure")
"""What can be mounted, or have its hoses, the other way round."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BenchFault:
    """One thing that is wrong."""

    channel: str
    kind: BenchFaultKind
    """``dead``: its volts stay where they are, or its wire is open and reads nothing. ``reversed``:
    mounted the other way round. ``swapped``: its plug and that of `other` are exchanged. ``noisy``:
    a bad contact. ``clipped``: its volts run into the end of the converter within its travel."""
    other: str = ""  # Of ``swapped``.


def parse_bench_fault(text: str) -> BenchFault:
    """Read what is wrong with an instrument before a flight, from one line.

    ``CHANNEL:KIND``, and for two plugs that are swapped ``CHANNEL:swapped:with=CHANNEL``.

    Raise FlightError if it says something else.
    """
    name, _, rest = text.partition(":")
    kind, _, rest = rest.partition(":")
    name, kind = name.strip(), kind.strip()
    if name not in INSTRUMENTS:
        hint = did_you_mean(name, INSTRUMENTS, f"choose one of {', '.join(INSTRUMENTS)}")
        raise FlightError(f"'{text}': no instrument is called '{name}'; {hint}")
    if kind not in BENCH_FAULT_KINDS:
        hint = did_you_mean(
            kind, BENCH_FAULT_KINDS, f"choose one of {', '.join(BENCH_FAULT_KINDS)}"
        )
        raise FlightError(f"'{text}': '{kind}' is not a fault; {hint}")
    key, _, other = (part.strip() for part in rest.partition("="))
    if kind == "swapped":
        if key != "with" or other not in INSTRUMENTS or other == name:
            raise FlightError(
                f"'{text}' needs the other channel; write for example "
                "elevator_left:swapped:with=elevator_right"
            )
    elif kind == "reversed" and name not in REVERSIBLE_CHANNELS:
        raise FlightError(f"'{text}': {name} cannot be reversed; choose another fault")
    elif rest:
        raise FlightError(f"'{text}': {kind} has no options; remove '{rest}'")
    return BenchFault(channel=name, kind=kind, other=other)

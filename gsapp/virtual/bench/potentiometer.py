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

import numpy as np
import numpy.typing as npt

from gsapp.quantities import FloatArray
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
    """The play between a surface and the shaft of its potentiometer.

    Parameters
    ----------
    play : float
        deg.
    shaft : float
        Where the shaft stands, deg.
    """

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

"""Density, airspeed and dynamic pressure from whatever is measured; whether the aircraft flies."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from gsapp.decoding.air_data import density, standard_density
from gsapp.dynamics.atmosphere import SEA_LEVEL_DENSITY
from gsapp.dynamics.first_order_lag import filter_first_order
from gsapp.identification.ftr.channels import CHANNEL_INDEX
from gsapp.quantities import BoolArray, FloatArray
from gsapp.quantities.constants import GRAVITY

MIN_GROUND_CLEARANCE = 5.0
"""Height above the place of take-off below which wheels may touch the ground, m."""
PRESSURE_TIME_CONSTANT = 0.5
"""Time constant of the smoothing of static pressure, s."""


class AirDataComputer:
    """The air that the aircraft flies in, and its height above the last ground.

    Parameters
    ----------
    speed : float or None
        Airspeed that stands in where none is measured, m/s.
    dt : float
        Sample time, s.
    """

    def __init__(self, speed: float | None, dt: float) -> None:
        self._speed, self._dt = speed, dt
        self.restart()

    def restart(self) -> None:
        """Forget what was measured so far."""
        self._pressures = np.full(2, np.nan)  # static, smoothed: now, and on the ground

    def air(
        self, values: FloatArray, held: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return density, airspeed and dynamic pressure; NaN where there is none."""

        def one(name: str) -> FloatArray:
            return values[:, CHANNEL_INDEX[name]]

        def slow(name: str) -> FloatArray:
            return held[:, CHANNEL_INDEX[name]]

        with np.errstate(divide="ignore", invalid="ignore"):
            V, qbar = one("V"), one("qbar")
            qbar = np.where(np.isfinite(qbar), qbar, one("dynamic_pressure"))
            rho = slow("density")
            if not np.isfinite(rho).all():
                static = slow("static_pressure")
                rho = _first_finite(
                    rho,
                    density(static, slow("temperature")),
                    standard_density(static),
                    2.0 * qbar / (V * V),
                )
            # A density off by more than a factor of two is no air: take that of sea level.
            sound = (rho > 0.3) & (rho < 2.0)
            rho = np.where(sound, rho, SEA_LEVEL_DENSITY)
            if self._speed is not None:
                known = np.isfinite(V) | np.isfinite(qbar)
                V = np.where(known, V, self._speed)
            V = np.where(np.isfinite(V), V, np.sqrt(2.0 * np.maximum(qbar, 0.0) / rho))
            qbar = np.where(np.isfinite(qbar), qbar, 0.5 * rho * V * V)
        return rho, V, qbar

    def is_clear_of_ground(
        self, static: FloatArray, rho: FloatArray, standing: BoolArray
    ) -> BoolArray:
        """Return where the wheels are well above the place where the aircraft last stood.

        Everywhere if static pressure is not measured, or the aircraft was never seen on the
        ground.
        """
        smooth = self._smoothed(static, np.isfinite(static), 0)
        ground = self._smoothed(static, np.isfinite(static) & standing, 1)
        with np.errstate(invalid="ignore"):
            return np.asarray(~(ground - smooth < MIN_GROUND_CLEARANCE * GRAVITY * rho))

    def _smoothed(self, signal: FloatArray, chosen: BoolArray, place: int) -> FloatArray:
        """Return a first-order smoothing of chosen samples, held in between."""
        state = float(self._pressures[place])
        picked = signal[chosen]
        if not picked.size:
            return np.full(signal.size, state)
        first = float(picked[0]) if np.isnan(state) else state
        decay = float(np.exp(-self._dt / PRESSURE_TIME_CONSTANT))
        smooth = filter_first_order(picked, decay, first)
        self._pressures[place] = smooth[-1]
        return np.concatenate(([state], smooth))[np.cumsum(chosen)]

    def state(self) -> dict[str, npt.NDArray[np.generic]]:
        """Return all that is remembered, for `restore`."""
        return {"pressures": self._pressures}

    def restore(self, state: Mapping[str, npt.NDArray[np.generic]]) -> None:
        """Go on from what `state` gave."""
        self._pressures = np.array(state["pressures"], dtype=np.float64)


def _first_finite(*candidates: FloatArray) -> FloatArray:
    """Return the first of several values that is a number, sample by sample."""
    found = candidates[0]
    for other in candidates[1:]:
        found = np.where(np.isfinite(found), found, other)
    return found

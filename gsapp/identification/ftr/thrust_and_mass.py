"""Thrust and mass, as levers were moved and fuel burned."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from gsapp.aircraft import Aircraft
from gsapp.dynamics.propulsion import filter_first_order, thrust
from gsapp.identification.ftr.channels import CHANNEL_INDEX
from gsapp.quantities import FloatArray


class ThrustAndMassModel:
    """Engines that follow their levers, and the fuel that they burn.

    Parameters
    ----------
    dt : float
        Sample time, s.
    mass : float
        At the start, kg, where there is no channel for it.
    burning : bool
        Whether that mass burns off as the throttle asks.
    """

    def __init__(self, aircraft: Aircraft, dt: float, *, mass: float, burning: bool) -> None:
        self._aircraft, self._dt = aircraft, dt
        self._mass, self._burning = mass, burning
        self.restart()

    def restart(self) -> None:
        """Forget where the levers were, and fill the tanks."""
        self._levers = np.full(2, np.nan)  # throttle and difference, as the engines follow them
        self._burned = np.zeros(1)

    def thrust(
        self, held: FloatArray, rho: FloatArray, V: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return the thrust, and what left exceeds right by in thrust over two."""
        left, right = (
            held[:, CHANNEL_INDEX["throttle_left"]],
            held[:, CHANNEL_INDEX["throttle_right"]],
        )
        lever = np.where(
            np.isfinite(left + right), 0.5 * (left + right), held[:, CHANNEL_INDEX["throttle"]]
        )
        levers = np.stack((lever, 0.5 * (left - right)), axis=1)
        followed = self._follow(levers)
        force = np.asarray(thrust(self._aircraft, followed[:, 0], rho, V), dtype=np.float64)
        side = np.asarray(thrust(self._aircraft, followed[:, 1], rho, V), dtype=np.float64)
        measured = held[:, CHANNEL_INDEX["thrust"]]
        return np.where(np.isfinite(measured), measured, force), side

    def _follow(self, levers: FloatArray) -> FloatArray:
        """Return what the engines make of the levers: first order, settled at the start."""
        lag = self._aircraft.propulsion.lag
        if lag <= 0.0:
            return np.where(np.isfinite(levers), levers, 0.0)
        decay = float(np.exp(-self._dt / lag))
        followed = np.zeros_like(levers)
        for column in range(levers.shape[1]):
            one, state = levers[:, column], float(self._levers[column])
            first = 0
            if np.isnan(state):
                # Settled at the first known position; before that there is no thrust to speak of.
                known = np.flatnonzero(np.isfinite(one))
                if not known.size:
                    continue
                first = int(known[0])
                state = float(one[first])
            followed[first:, column] = filter_first_order(one[first:], decay, state)
            self._levers[column] = followed[-1, column]
        return followed

    def mass(self, held: FloatArray) -> FloatArray:
        """Return the mass at every sample, kg."""
        properties = self._aircraft.mass
        measured = held[:, CHANNEL_INDEX["mass"]]
        if self._burning:
            throttle = np.clip(np.nan_to_num(held[:, CHANNEL_INDEX["throttle"]]), 0.0, 1.0)
            idle, full = properties.fuel_flow_idle, properties.fuel_flow_full
            steps = self._dt * (idle + (full - idle) * throttle)
            burned = np.cumsum(np.concatenate((self._burned, steps)))
            self._burned = burned[-1:].copy()
            burning = self._mass - np.minimum(burned[1:], properties.fuel)
        else:
            burning = np.full(len(held), self._mass)
        return np.where(np.isfinite(measured), measured, burning)

    def state(self) -> dict[str, npt.NDArray[np.generic]]:
        """Return all that is remembered, for `restore`."""
        return {"levers": self._levers, "burned": self._burned}

    def restore(self, state: Mapping[str, npt.NDArray[np.generic]]) -> None:
        """Go on from what `state` gave."""
        self._levers = np.array(state["levers"], dtype=np.float64)
        self._burned = np.array(state["burned"], dtype=np.float64)

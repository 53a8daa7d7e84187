"""How controls acted, from their records, which are noisy.

Noise of the record works a play that the surface never felt: within its width it would be turned
over by the converter alone. So play follows the record smoothed, and what it takes is taken from
the record as it is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter1d

from gsapp.dynamics.settings import SIMULATION
from gsapp.dynamics.signal_terms import (
    Backlash,
    PathResponse,
    PathTerms,
    invert_path,
    path_response,
)
from gsapp.quantities import FloatArray


@dataclass(frozen=True, slots=True)
class _SmoothedBacklash:
    """Play that a noisy record does not turn over."""

    play: Backlash

    def respond(self, signal: FloatArray, dt: float, parameters: tuple[float, ...]) -> PathResponse:
        smooth = _smooth(signal, dt)
        found = self.play.respond(smooth, dt, parameters)

        def tangent(change: FloatArray) -> FloatArray:
            even = _smooth(change, dt)
            return change + found.tangent(even) - even

        return PathResponse(
            values=signal + found.values - smooth, parameters=found.parameters, tangent=tangent
        )


def _smooth(history: FloatArray, dt: float) -> FloatArray:
    half = round(0.5 * SIMULATION.control_smoothing / dt)
    return np.asarray(uniform_filter1d(history, 2 * half + 1, axis=0, mode="nearest"))


def simulate_control_path(moved: PathTerms, recorded: FloatArray, dt: float) -> PathResponse:
    """Return how a control acted, from a record that its sensor left as it was.

    Parameters
    ----------
    moved : PathTerms
        Effects on the control path (``FlightModel.control_terms``).
    recorded : ndarray, shape (n,)
    dt : float
        Sample time, s.

    Returns
    -------
    PathResponse
        Columns of `parameters`: those of `moved`.
    """
    terms = [
        (_SmoothedBacklash(term) if isinstance(term, Backlash) else term, values)
        for term, values in moved
    ]
    return path_response(terms, recorded, dt)


def reconstruct_deflection(
    shown: PathTerms, moved: PathTerms, recorded: FloatArray, dt: float
) -> PathResponse:
    """Return how a control acted, from its record: its sensor undone, then its control path.

    Parameters
    ----------
    shown, moved : PathTerms
        Effects on the sensor (``FlightModel.sensor_terms``) and on the control path.
    recorded : ndarray, shape (n,)
    dt : float
        Sample time, s.

    Returns
    -------
    PathResponse
        Columns of `parameters`: those of `shown`, then those of `moved`.
    """
    true = invert_path(shown, recorded, dt)
    found = simulate_control_path(moved, true.values, dt)
    return PathResponse(
        values=found.values,
        parameters=np.hstack((found.tangent(true.parameters), found.parameters)),
        tangent=lambda change: found.tangent(true.tangent(change)),
    )

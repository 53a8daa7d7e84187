"""How controls acted, from their records, which are noisy.

Noise of the record works a play that the surface never felt: within its width it would be turned
over by the converter alone. So play follows the record smoothed, and what it takes is taken from
the record as it is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter1d

from gsapp.dynamics.signals import Backlash, Path, Response, respond, undo
from gsapp.quantities import FloatArray

STEADIED = 0.1
"""Seconds over which a record is averaged for a play: shorter than any hand's move."""


@dataclass(frozen=True, slots=True)
class _Steadied:
    """Play that a noisy record does not turn over."""

    play: Backlash

    def respond(self, signal: FloatArray, dt: float, parameters: tuple[float, ...]) -> Response:
        smooth = _smoothed(signal, dt)
        found = self.play.respond(smooth, dt, parameters)

        def tangent(change: FloatArray) -> FloatArray:
            even = _smoothed(change, dt)
            return change + found.tangent(even) - even

        return Response(
            values=signal + found.values - smooth, parameters=found.parameters, tangent=tangent
        )


def _smoothed(history: FloatArray, dt: float) -> FloatArray:
    half = round(0.5 * STEADIED / dt)
    return np.asarray(uniform_filter1d(history, 2 * half + 1, axis=0, mode="nearest"))


def acted(moved: Path, recorded: FloatArray, dt: float) -> Response:
    """Return how a control acted, from a record that its sensor left as it was.

    Parameters
    ----------
    moved : Path
        Effects on the control path (``FlightModel.control_terms``).
    recorded : ndarray, shape (n,)
    dt : float
        Sample time, s.

    Returns
    -------
    Response
        Columns of `parameters`: those of `moved`.
    """
    terms = [
        (_Steadied(term) if isinstance(term, Backlash) else term, values) for term, values in moved
    ]
    return respond(terms, recorded, dt)


def drive(shown: Path, moved: Path, recorded: FloatArray, dt: float) -> Response:
    """Return how a control acted, from its record: its sensor undone, then its control path.

    Parameters
    ----------
    shown, moved : Path
        Effects on the sensor (``FlightModel.sensor_terms``) and on the control path.
    recorded : ndarray, shape (n,)
    dt : float
        Sample time, s.

    Returns
    -------
    Response
        Columns of `parameters`: those of `shown`, then those of `moved`.
    """
    true = undo(shown, recorded, dt)
    found = acted(moved, true.values, dt)
    return Response(
        values=found.values,
        parameters=np.hstack((found.tangent(true.parameters), found.parameters)),
        tangent=lambda change: found.tangent(true.tangent(change)),
    )

"""Late instruments: what they show of a motion, and of a deviation from it.

A filter predicts a motion; a late instrument shows what it was. Its reading is made of the
prediction's values and rates up to now, never of later ones: those have seen the measurement that
the reading is compared with. A deviation now was, a moment ago, what the equations make of it
backward in time; without that, turbulence that a late instrument shows would be taken for
something else.
"""

from __future__ import annotations

import numpy as np

from gsapp.dynamics.signals import Delay, Lag, Path, Straight, lagged
from gsapp.quantities import FloatArray

_FINER = 4
"""Samples in the place of one, for the response of a lag."""


def shown(path: Path, signal: FloatArray, rate: FloatArray, dt: float) -> FloatArray:
    """Return what comes out of an instrument's path, from what went in up to each sample.

    Parameters
    ----------
    path : Path
    signal, rate : ndarray, shape (n,)
        What goes in, and its time derivative.
    dt : float
        Sample time, s.

    Returns
    -------
    ndarray, shape (n,)
    """
    for term, values in path:
        if isinstance(term, Lag):
            signal, rate = _lagged(signal, rate, values[0], dt)
        elif isinstance(term, Delay):
            signal, rate = _delayed(signal, rate, values[0], dt)
        elif isinstance(term, Straight):
            slope = term.jacobian((signal,), (), values).reads[0]
            signal = np.broadcast_to(np.asarray(term.value((signal,), (), values)), rate.shape)
            rate = rate * slope
        else:
            signal = term.respond(signal, dt, values).values
    return signal


def looking_back(path: Path, jacobian: FloatArray) -> FloatArray | None:
    """Return what turns a deviation now into the one that a path shows, (n, n_states, n_states).

    Parameters
    ----------
    path : Path
    jacobian : ndarray, shape (n, n_states, n_states)
        Of the equations, 1/s.

    Returns
    -------
    ndarray or None
        To second order in the lateness; None where nothing is late.
    """
    found = None
    one = np.eye(jacobian.shape[1])
    for term, values in path:
        if isinstance(term, Delay | Lag):
            step = values[0] * jacobian
            # exp(-step) of a delay, 1/(1 + step) of a lag.
            second = 0.5 if isinstance(term, Delay) else 1.0
            back = one - step + second * (step @ step)
            found = back if found is None else found @ back
    return found


def _lagged(
    signal: FloatArray, rate: FloatArray, tau: float, dt: float
) -> tuple[FloatArray, FloatArray]:
    if tau <= 0.0 or len(signal) < 2:
        return signal, rate
    steps = np.arange(_FINER * (len(signal) - 1) + 1) / _FINER
    out = lagged(_between(signal, rate, steps, dt), tau, dt / _FINER)[::_FINER]
    return out, (signal - out) / tau


def _delayed(
    signal: FloatArray, rate: FloatArray, late: float, dt: float
) -> tuple[FloatArray, FloatArray]:
    """Return a signal and its rate as they were; one that is early goes on with its rate."""
    if len(signal) < 2:
        return signal, rate
    if late < 0.0:
        bend = np.diff(rate, prepend=rate[:1]) / dt
        return signal - late * rate + 0.5 * late * late * bend, rate - late * bend
    places = np.maximum(np.arange(len(signal)) - late / dt, 0.0)
    return _between(signal, rate, places, dt), np.interp(places, np.arange(len(rate)), rate)


def _between(signal: FloatArray, rate: FloatArray, places: FloatArray, dt: float) -> FloatArray:
    """Return a signal between its samples, on the cubics that its values and rates make."""
    index = np.minimum(places.astype(np.intp), len(signal) - 2)
    s = places - index
    left = (1.0 - s) ** 2 * ((1.0 + 2.0 * s) * signal[index] + s * dt * rate[index])
    right = s * s * ((3.0 - 2.0 * s) * signal[index + 1] - (1.0 - s) * dt * rate[index + 1])
    return np.asarray(left + right)

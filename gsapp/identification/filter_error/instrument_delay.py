"""Late instruments: what they show of a motion, and of a deviation from it.

A filter predicts a motion; a late instrument shows what it was. Its reading is made of the
prediction's values and rates up to now, never of later ones: those have seen the measurement that
the reading is compared with. Deviations that a late instrument is still to show are states of the
filter (`blocks`): turbulence that came in between could not be told from noise otherwise. One that
is early, as the clock of a box can make it, shows what the equations make of a deviation now.
"""

from __future__ import annotations

import numpy as np

from gsapp.dynamics.signal_terms import Delay, Lag, MemorylessTerm, PathTerms, apply_lag
from gsapp.identification.filter_error.settings import FILTER_ERROR
from gsapp.quantities import FloatArray


def path_delay(path: PathTerms) -> float:
    """Return by how much a path is late, its lag left out, s; below zero if it is early."""
    return float(sum(values[0] for term, values in path if isinstance(term, Delay)))


def path_lag(path: PathTerms) -> float | None:
    """Return the time constant of the lag on a path, s; None without one."""
    return next((values[0] for term, values in path if isinstance(term, Lag)), None)


def instrument_output(
    path: PathTerms, signal: FloatArray, rate: FloatArray, dt: float
) -> FloatArray:
    """Return what comes out of an instrument's path, from what went in up to each sample.

    `signal` and `rate`, shape (n,): what goes in, and its time derivative.
    `dt`: sample time, s.

    Returns
    -------
    ndarray, shape (n,)
    """
    for term, values in path:
        if isinstance(term, Lag):
            signal, rate = _lagged(signal, rate, values[0], dt)
        elif isinstance(term, Delay):
            signal, rate = _delayed(signal, rate, values[0], dt)
        elif isinstance(term, MemorylessTerm):
            slope = term.jacobian((signal,), (), values).reads[0]
            signal = np.broadcast_to(np.asarray(term.value((signal,), (), values)), rate.shape)
            rate = rate * slope
        else:
            signal = term.respond(signal, dt, values).values
    return signal


def delay_sensitivity(
    path: PathTerms, signal: FloatArray, rate: FloatArray, dt: float
) -> dict[str, FloatArray]:
    """Return the derivatives of what comes out by how late the effects of a path are.

    By the rates of the prediction only: where measurements correct it, it jumps, and to follow the
    jumps would be to trust the model of turbulence to a thousandth of a second.

    `signal` and `rate`, shape (n,): what goes in, and its time derivative.
    `dt`: sample time, s.

    Returns
    -------
    dict of str to ndarray, shape (n,)
        By parameter, ``<effect id>.<name>``.
    """
    out = rate
    for term, values in path:
        if isinstance(term, Lag):
            out = apply_lag(out, values[0], dt)
        elif isinstance(term, Delay):
            _, out = _delayed(signal, out, values[0], dt)
        else:
            out = out * term.jacobian((signal,), (), values).reads[0]
    return {
        f"{term.id}.{term.parameters[0].name}": -apply_lag(out, values[0], dt)
        if isinstance(term, Lag)
        else -out
        for term, values in path
        if isinstance(term, Lag | Delay)
    }


def lead_matrix(path: PathTerms, jacobian: FloatArray) -> FloatArray | None:
    """Return what turns a deviation now into the one that an early path shows.

    `jacobian`, shape (n, n_states, n_states): of the equations, 1/s.

    Returns
    -------
    ndarray, shape (n, n_states, n_states), or None
        To second order in what is early; None where nothing is.
    """
    early = -path_delay(path)
    if early <= 0.0:
        return None
    step = early * jacobian
    found: FloatArray = np.eye(jacobian.shape[1]) + step + 0.5 * (step @ step)
    return found


def visible_shares(path: PathTerms, dt: float, steps: int) -> FloatArray:
    """Return what share of a change shows, that came about within a step between samples.

    `path`: what is late on it is left out, and what the instrument multiplies.
    `dt`: sample time, s.

    Returns
    -------
    ndarray, shape (2 * steps,)
        From steps that lie as far ahead to those that lie as far back; 0 for the former and 1 for
        the latter where nothing is early.
    """
    early = max(-path_delay(path), 0.0)
    return np.asarray(np.clip(np.arange(-steps, steps) + 1.0 + early / dt, 0.0, 1.0))


def _lagged(
    signal: FloatArray, rate: FloatArray, tau: float, dt: float
) -> tuple[FloatArray, FloatArray]:
    if tau <= 0.0 or len(signal) < 2:
        return signal, rate
    steps = np.arange(FILTER_ERROR.oversampling * (len(signal) - 1) + 1) / FILTER_ERROR.oversampling
    out = apply_lag(
        _interpolate_hermite(signal, rate, steps, dt), tau, dt / FILTER_ERROR.oversampling
    )[:: FILTER_ERROR.oversampling]
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
    return _interpolate_hermite(signal, rate, places, dt), np.interp(
        places, np.arange(len(rate)), rate
    )


def _interpolate_hermite(
    signal: FloatArray, rate: FloatArray, places: FloatArray, dt: float
) -> FloatArray:
    """Return a signal between its samples, on the cubics that its values and rates make."""
    index = np.minimum(places.astype(np.intp), len(signal) - 2)
    s = places - index
    left = (1.0 - s) ** 2 * ((1.0 + 2.0 * s) * signal[index] + s * dt * rate[index])
    right = s * s * ((3.0 - 2.0 * s) * signal[index + 1] - (1.0 - s) * dt * rate[index + 1])
    return np.asarray(left + right)

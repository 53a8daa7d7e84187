"""What the instruments show of a motion, with derivatives, early or late.

The same formulas as `gsapp.dynamics.sensors.OutputModel`, which gives the values; their
derivatives are written out for the flow at each place, of which most columns are zero.

A filter predicts a motion; a late instrument shows what it was. Its reading is made of the
prediction's values and rates up to now, never of later ones: those have seen the measurement that
the reading is compared with. Deviations that a late instrument is still to show are states of the
filter (`blocks`): turbulence that came in between could not be told from noise otherwise. One that
is early, as the clock of a box can make it, shows what the equations make of a deviation now.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gsapp.dynamics.arithmetic import Value
from gsapp.dynamics.equations import POLAR_STATES
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.sensors import (
    accelerations_at,
    alpha_vane,
    beta_vane,
    pitot_airspeed,
    velocity_at,
)
from gsapp.dynamics.signal_terms import Delay, Lag, MemorylessTerm, PathTerms, apply_lag
from gsapp.identification.filter_error.equation_jacobian import (
    EquationJacobian,
    SparseGradient,
    add_scaled,
    linear_combination,
)
from gsapp.identification.filter_error.settings import FILTER_ERROR
from gsapp.quantities import FloatArray

_Vector = tuple[Value, Value, Value]
_VectorGradient = tuple[SparseGradient, SparseGradient, SparseGradient]
_ACCELERATIONS = ("ax", "ay", "an")


ValueWithGradient = tuple[Value, SparseGradient]
"""A value and its derivatives."""


def sensor_inputs(
    model: FlightModel, channels: Sequence[str], state: Sequence[Value], found: EquationJacobian
) -> list[ValueWithGradient]:
    """Return what the instruments are exposed to, with derivatives, channel by channel.

    `state`: polar states first; arrays of shape (n,).
    `found`: of the equations at these states.
    """
    exposed = _SensorInputs(model, state, found)
    partner = {name: name for name in channels}
    for one, other in model.swapped_channels:
        partner[one], partner[other] = partner.get(other, other), partner.get(one, one)
    return [exposed.channel(partner[name]) for name in channels]


class _SensorInputs:
    """The flow and the accelerations at the places of the instruments."""

    def __init__(self, model: FlightModel, state: Sequence[Value], found: EquationJacobian) -> None:
        self._model, self._found, self._state = model, found, state
        V, alpha, beta = state[:3]
        sa, ca, sb, cb = np.sin(alpha), np.cos(alpha), np.sin(beta), np.cos(beta)
        forward = V * cb
        self._flow: _Vector = (forward * ca, V * sb, forward * sa)
        self._flow_slopes: _VectorGradient = (
            {0: cb * ca, 1: -forward * sa, 2: -V * sb * ca},
            {0: sb, 2: forward},
            {0: cb * sa, 1: forward * ca, 2: -V * sb * sa},
        )
        self._spin: _Vector = (found.rates[3], found.rates[4], found.rates[5])
        self._accelerations: (
            tuple[ValueWithGradient, ValueWithGradient, ValueWithGradient] | None
        ) = None

    def channel(self, name: str) -> ValueWithGradient:
        """Return one channel."""
        sensors = self._model.aircraft.sensors
        if name in _ACCELERATIONS:
            if self._accelerations is None:
                self._accelerations = self._at_accelerometer()
            return self._accelerations[_ACCELERATIONS.index(name)]
        if name == "V":
            return _speed(*self._flow_at("air_data"))
        if name == "alpha":
            flow, (du, _, dw) = self._flow_at("alpha_vane")
            u, _, w = flow
            upwash = sensors.alpha_vane.upwash
            factor = upwash / (u * u + w * w)
            return alpha_vane(flow, upwash), linear_combination((factor * u, dw), (-factor * w, du))
        if name == "beta":
            flow, slopes = self._flow_at("beta_vane")
            fin = sensors.beta_vane
            return beta_vane(flow, fin.kind, fin.upwash), _beta_vane_gradient(
                flow, slopes, fin.kind, fin.upwash
            )
        index = POLAR_STATES.index(name)
        return self._state[index], {index: 1.0}

    def _place(self, instrument: str) -> tuple[_Vector, _VectorGradient]:
        """Return where an instrument sits from the center of gravity."""
        x, y, z = getattr(self._model.aircraft.sensors, instrument).position
        totals, found = self._found.totals, self._found
        if instrument in totals.position_offsets:
            off = totals.position_offsets[instrument]
            x, y, z = x + off[0], y + off[1], z + off[2]
        cg = totals.cg
        own = found.position_gradients.get(instrument, ({}, {}, {}))
        dx, dy, dz = (
            linear_combination((1.0, one), (-1.0, gone))
            for one, gone in zip(own, found.cg_gradients, strict=True)
        )
        return (x - cg[0], y - cg[1], z - cg[2]), (dx, dy, dz)

    def _flow_at(self, instrument: str) -> tuple[_Vector, _VectorGradient]:
        (x, y, z), (dx, dy, dz) = self._place(instrument)
        p, q, r = self._state[3:6]
        (du, dv, dw), first = self._flow_slopes, self._found.layout.rotation.start
        # The air turns, too.
        units: list[SparseGradient] = [{3 + axis: 1.0, first + axis: -1.0} for axis in range(3)]
        dp, dq, dr = units
        return velocity_at((x, y, z), self._flow, (p, q, r)), (
            linear_combination((1.0, du), (z, dq), (q, dz), (-y, dr), (-r, dy)),
            linear_combination((1.0, dv), (x, dr), (r, dx), (-z, dp), (-p, dz)),
            linear_combination((1.0, dw), (y, dp), (p, dy), (-x, dq), (-q, dx)),
        )

    def _at_accelerometer(self) -> tuple[ValueWithGradient, ValueWithGradient, ValueWithGradient]:
        (x, y, z), (dx, dy, dz) = self._place("accelerometer")
        found, totals = self._found, self._found.totals
        p, q, r = self._state[3:6]
        p_dot, q_dot, r_dot = self._spin
        by_spin = found.rate_gradients[3:6]
        mass = totals.body.mass
        rows, specific = [], []
        for sign, force, slopes in zip(
            (1.0, 1.0, -1.0), totals.loads[:3], found.force_gradients, strict=True
        ):
            specific.append(sign * force / mass)
            rows.append(
                linear_combination(
                    (sign / mass, slopes), (-sign * force / (mass * mass), found.mass_gradient)
                )
            )
        ax, ay, an = rows
        add_scaled(ax, 1.0, {3: q * y + r * z, 4: p * y - 2.0 * q * x, 5: p * z - 2.0 * r * x})
        add_scaled(ay, 1.0, {3: q * x - 2.0 * p * y, 4: p * x + r * z, 5: q * z - 2.0 * r * y})
        add_scaled(an, 1.0, {3: 2.0 * p * z - r * x, 4: 2.0 * q * z - r * y, 5: -p * x - q * y})
        for out, parts in (
            (ax, ((-y, by_spin[2]), (z, by_spin[1]))),
            (ay, ((x, by_spin[2]), (-z, by_spin[0]))),
            (an, ((x, by_spin[1]), (-y, by_spin[0]))),
        ):
            for factor, slopes in parts:
                add_scaled(out, factor, slopes)
        if any((dx, dy, dz)):
            add_scaled(ax, -(q * q + r * r), dx)
            add_scaled(ax, p * q - r_dot, dy)
            add_scaled(ax, p * r + q_dot, dz)
            add_scaled(ay, p * q + r_dot, dx)
            add_scaled(ay, -(p * p + r * r), dy)
            add_scaled(ay, q * r - p_dot, dz)
            add_scaled(an, q_dot - p * r, dx)
            add_scaled(an, -(q * r + p_dot), dy)
            add_scaled(an, p * p + q * q, dz)
        values = accelerations_at(
            (x, y, z), (specific[0], specific[1], specific[2]), (p, q, r), self._spin
        )
        return (values[0], ax), (values[1], ay), (values[2], an)


def _speed(flow: _Vector, slopes: _VectorGradient) -> ValueWithGradient:
    speed = pitot_airspeed(flow)
    return speed, linear_combination(
        *((one / speed, own) for one, own in zip(flow, slopes, strict=True))
    )


def _beta_vane_gradient(
    flow: _Vector, slopes: _VectorGradient, kind: str, sidewash: float
) -> SparseGradient:
    """Return the derivatives of what a beta vane shows."""
    (u, v, _), (du, dv, _) = flow, slopes
    if kind == "fixed":
        factor = sidewash / (u * u + v * v)
        return linear_combination((factor * u, dv), (-factor * v, du))
    speed, by_speed = _speed(flow, slopes)
    ratio = v / speed
    factor = sidewash / (speed * np.sqrt(1.0 - ratio * ratio))
    return linear_combination((factor, dv), (-factor * ratio, by_speed))


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

    Shape (n,).
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

    Shape (n,). By parameter, ``<effect id>.<name>``.
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

    Shape (n, n_states, n_states). To second order in what is early; None where nothing is.
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

    Shape (2 * steps,). From steps that lie as far ahead to those that lie as far back; 0 for the
    former and 1 for the latter where nothing is early.
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

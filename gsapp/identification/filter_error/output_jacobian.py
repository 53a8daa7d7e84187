"""What the instruments show, with derivatives column by column.

The same formulas as `gsapp.dynamics.sensors.OutputModel`, which gives the values; their
derivatives are written out for the flow at each place, of which most columns are zero.
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
from gsapp.identification.filter_error.equation_jacobian import (
    EquationJacobian,
    SparseGradient,
    add_scaled,
    linear_combination,
)

_Vector = tuple[Value, Value, Value]
_VectorGradient = tuple[SparseGradient, SparseGradient, SparseGradient]
_ACCELERATIONS = ("ax", "ay", "an")
_UNITS: _VectorGradient = ({3: 1.0}, {4: 1.0}, {5: 1.0})
"""Of p, q, r."""


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
        place = POLAR_STATES.index(name)
        return self._state[place], {place: 1.0}

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
        (du, dv, dw), (dp, dq, dr) = self._flow_slopes, _UNITS
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

"""What instruments are exposed to where they sit: vanes, pitot, accelerometers (notes, section 7).

Positions are from the center of gravity, body axes, m. The formulas take single numbers, arrays
of shape (n,), and numbers with derivatives (`gsapp.dynamics.arithmetic.Dual`) alike.
`OutputModel` puts them behind a `FlightModel`: predicted measurements with their exact Jacobians.

An instrument that sits elsewhere than the aircraft file says, and two that are swapped, belong to
the model behind an `OutputModel`. Lag, delay, scale and bias of an instrument are terms on the path
of its signal (`gsapp.dynamics.signal_terms`), found in ``FlightModel.sensor_terms``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.dynamics.arithmetic import Dual, Value, array_namespace, clip
from gsapp.dynamics.equations import POLAR_STATES, angular_accelerations
from gsapp.dynamics.flight_model import MODEL_INPUTS, FlightModel, ModelEvaluation, ModelJacobian
from gsapp.dynamics.settings import SIMULATION
from gsapp.dynamics.terms import Values
from gsapp.foundation import UnknownNameError
from gsapp.quantities import FloatArray

Vector = tuple[Any, Any, Any]
"""Three components along the body axes, each a number, an array (n,), or a `Dual`."""

OUTPUTS = (
    "V", "alpha", "beta", "p", "q", "r", "phi", "theta", "psi", "ax", "ay", "an",
    "qbar", "p_dot", "q_dot", "r_dot",
)  # fmt: skip
"""What `OutputModel` can predict."""
_AIR_DATA = frozenset(("V", "qbar"))
_ACCELERATIONS = frozenset(("ax", "ay", "an"))


def velocity_at(position: Vector, flow: Vector, rates: Vector) -> Vector:
    """Return the velocity through the air at a place on the aircraft.

    The position is from the CG, m; `flow` is u, v, w there, m/s; `rates` p, q, r, rad/s.
    """
    x, y, z = position
    u, v, w = flow
    p, q, r = rates
    return u + q * z - r * y, v + r * x - p * z, w + p * y - q * x


def alpha_vane(flow: Vector, upwash: float = 1.0) -> Any:
    """Return the angle (rad) of an alpha vane in the local flow u, v, w (m/s)."""
    return upwash * array_namespace(flow[0]).atan2(flow[2], flow[0])


def beta_vane(flow: Vector, kind: str = "fixed", sidewash: float = 1.0) -> Any:
    """Return the angle (rad) of a beta vane in the local flow.

    ``fixed`` on the body's z axis shows the flank angle atan(v/u); a ``swivel`` head turns with
    alpha and shows asin(v/V).
    """
    u, v, _ = flow
    m = array_namespace(u)
    if kind == "fixed":
        return sidewash * m.atan2(v, u)
    return sidewash * m.asin(v / pitot_airspeed(flow))


def pitot_airspeed(flow: Vector) -> Any:
    """Return the speed (m/s) of the local flow, as a pitot tube sees it."""
    u, v, w = flow
    return array_namespace(u).sqrt(u * u + v * v + w * w)


def accelerations_at(
    position: Vector, specific_force: Vector, rates: Vector, spin: Vector
) -> Vector:
    """Return ax, ay, an (m/s^2; an positive up) as an accelerometer at a place reads them.

    The position is from the CG, m; `specific_force` is ax, ay, an there, m/s^2; `rates` and `spin`
    p, q, r (rad/s) and their rates (rad/s^2).
    """
    x, y, z = position
    ax, ay, an = specific_force
    p, q, r = rates
    p_dot, q_dot, r_dot = spin
    return (
        ax - (q * q + r * r) * x + (p * q - r_dot) * y + (p * r + q_dot) * z,
        ay + (p * q + r_dot) * x - (p * p + r * r) * y + (q * r - p_dot) * z,
        an - (p * r - q_dot) * x - (q * r + p_dot) * y + (p * p + q * q) * z,
    )


def accelerations_at_cg(position: Vector, measured: Vector, rates: Vector, spin: Vector) -> Vector:
    """Return ax, ay, an at the CG from those measured at a place: `accelerations_at` undone."""
    x, y, z = position
    return accelerations_at((-x, -y, -z), measured, rates, spin)


def flow_at_cg(
    aircraft: Aircraft, V: Value, alpha: Value, beta: Value, rates: tuple[Value, Value, Value]
) -> tuple[Value, Value, Value]:
    """Return V, alpha, beta at the CG from what the pitot and the two vanes show.

    Each shows the flow at its own place. The vanes fix w and v as multiples of u plus what the
    rates add, and the speed at the pitot then gives a quadratic equation for u. A swivel head
    adds the slope of the flow at its place, which comes from the round before.
    """
    sensors = aircraft.sensors
    vane, fin, pitot = sensors.alpha_vane, sensors.beta_vane, sensors.air_data
    m = array_namespace(V)
    still = (0.0, 0.0, 0.0)
    ahead, _, under = velocity_at(vane.position, still, rates)
    before, beside, below = velocity_at(fin.position, still, rates)
    along, across, down = velocity_at(pitot.position, still, rates)
    attack, slip = m.tan(alpha / vane.upwash), m.tan(beta / fin.upwash)
    # w = attack u + steady; w + down = attack u + sunk.
    steady = attack * ahead - under
    sunk = steady + down
    flank = slip
    for _ in range(1 if fin.kind == "fixed" else SIMULATION.swivel_iterations):
        drift = flank * before - beside
        pushed = drift + across
        square = 1.0 + attack * attack + flank * flank
        half = along + attack * sunk + flank * pushed
        rest = along * along + sunk * sunk + pushed * pushed - V * V
        # Negative where rates alone make more than the speed shown: no flow does that.
        u = (m.sqrt(clip(half * half - square * rest, 0.0, math.inf)) - half) / square
        v, w = flank * u + drift, attack * u + steady
        if fin.kind != "fixed":
            slope = (w + below) / (u + before)
            flank = slip * m.sqrt(1.0 + slope * slope)
    speed = pitot_airspeed((u, v, w))
    return speed, m.atan2(w, u), m.atan2(v, m.sqrt(u * u + w * w))


def _spin(state: Values, totals: ModelEvaluation) -> tuple[Value, Value, Value]:
    p, q, r = state[3:6]
    return angular_accelerations(p, q, r, *totals.loads[3:], totals.body)


class OutputModel:
    """Predicted measurements of a flight model, at the places of the instruments.

    Of the channels, from `OUTPUTS`, V, qbar, alpha, beta, ax, ay, an are as their instruments show
    them where they sit, relative to the CG with the model's offset; the rest belongs to the whole
    body. Raise UnknownNameError if a channel cannot be predicted.
    """

    def __init__(self, model: FlightModel, channels: Sequence[str]) -> None:
        unknown = [name for name in channels if name not in OUTPUTS]
        if unknown:
            raise UnknownNameError(
                f"{', '.join(unknown)} cannot be predicted by the equations; "
                f"they give {', '.join(OUTPUTS)}"
            )
        self.model = model
        self.channels = tuple(channels)
        partners = [other for pair in model.swapped_channels for other in pair]
        self._needed = frozenset((*channels, *partners))

    def values(
        self,
        state: Values,
        inputs: Values,
        parameters: Values | None = None,
    ) -> tuple[Value, ...]:
        """Return the channels in order; arguments as in `FlightModel.totals`."""
        totals = self.model.evaluate(state, inputs, parameters)
        spin = _spin(state, totals)
        table = self._predict(
            state[:9],
            spin,
            totals.loads[:3],
            totals.body.mass,
            totals.cg,
            inputs[6],
            totals.position_offsets,
        )
        return tuple(table[name] for name in self.channels)

    def jacobian(
        self,
        state: Values,
        inputs: Values,
        parameters: Values | None = None,
        *,
        free: Sequence[str] | None = None,
    ) -> tuple[FloatArray, FloatArray, ModelJacobian]:
        """Return values, total derivatives, and the differential of the equations.

        Shapes (n, n_channels) and (n, n_channels, n_all): by all states, then inputs, then the free
        parameters, as in `ModelJacobian`.
        """
        differential = self.model.differentiate(state, inputs, parameters, free=free)
        count, n_states, n_all = differential.rates.shape
        totals = differential.evaluation
        spin = _spin(state, totals)
        unit = np.eye(n_all)

        def dual(value: Value, slope: FloatArray) -> Dual:
            full = np.array(np.broadcast_to(np.asarray(value, dtype=float), (count,)))
            return Dual(full, np.array(np.broadcast_to(slope, (count, n_all))))

        table = self._predict(
            tuple(dual(x, unit[index]) for index, x in enumerate(state[:9])),
            tuple(dual(spin[index], differential.rates[:, 3 + index]) for index in range(3)),
            tuple(dual(totals.loads[index], differential.loads[:, index]) for index in range(3)),
            dual(totals.body.mass, differential.body[:, 0]),
            tuple(dual(totals.cg[index], differential.cg[:, index]) for index in range(3)),
            dual(inputs[6], unit[n_states + MODEL_INPUTS.index("rho")]),
            {
                name: tuple(
                    dual(place[index], differential.position_offsets[name][:, index])
                    for index in range(3)
                )
                for name, place in totals.position_offsets.items()
            },
        )
        chosen = [table[name] for name in self.channels]
        values = np.stack([x.value for x in chosen], axis=-1)
        return values, np.stack([x.derivative for x in chosen], axis=1), differential

    def _predict(
        self,
        polar: Sequence[Any],
        spin: Sequence[Any],
        force: Sequence[Any],
        mass: Any,
        cg: Sequence[Any],
        rho: Any,
        places: Mapping[str, Sequence[Any]],
    ) -> dict[str, Any]:
        sensors = self.model.aircraft.sensors
        V, alpha, beta, p, q, r = polar[:6]
        m = array_namespace(V)
        rates = (p, q, r)
        forward = V * m.cos(beta)
        flow = (forward * m.cos(alpha), V * m.sin(beta), forward * m.sin(alpha))

        def place(instrument: str) -> Vector:
            x, y, z = getattr(sensors, instrument).position
            if instrument in places:
                off = places[instrument]
                x, y, z = x + off[0], y + off[1], z + off[2]
            return x - cg[0], y - cg[1], z - cg[2]

        def flow_at(instrument: str) -> Vector:
            return velocity_at(place(instrument), flow, rates)

        table = dict(zip(POLAR_STATES, polar, strict=True))
        table.update(p_dot=spin[0], q_dot=spin[1], r_dot=spin[2])
        if not _AIR_DATA.isdisjoint(self._needed):
            speed = pitot_airspeed(flow_at("air_data"))
            table.update(V=speed, qbar=0.5 * rho * speed * speed)
        vane, fin = sensors.alpha_vane, sensors.beta_vane
        if "alpha" in self._needed:
            table["alpha"] = alpha_vane(flow_at("alpha_vane"), vane.upwash)
        if "beta" in self._needed:
            table["beta"] = beta_vane(flow_at("beta_vane"), fin.kind, fin.upwash)
        if not _ACCELERATIONS.isdisjoint(self._needed):
            specific = (force[0] / mass, force[1] / mass, -(force[2] / mass))
            table["ax"], table["ay"], table["an"] = accelerations_at(
                place("accelerometer"), specific, rates, (spin[0], spin[1], spin[2])
            )
        for one, other in self.model.swapped_channels:
            table[one], table[other] = table[other], table[one]
        return table

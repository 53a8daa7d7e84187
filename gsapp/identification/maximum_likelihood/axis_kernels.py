"""Kernels written out for the usual cases: alpha, q, or beta, p, r; all else measured.

Where attitude was not measured, theta joins the first, phi the second.

The same equations as `GeneralKernel` runs on, with only the active columns, and what does not
depend on the active states worked out beforehand. Coefficients are the linear build-up plus any
static effect on them. `build_axis_kernel` says whether a case is covered.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.dynamics.equations import POLAR_STATES
from gsapp.dynamics.flight_model import MODEL_INPUTS, FlightModel
from gsapp.dynamics.propulsion import thrust as thrust_of
from gsapp.dynamics.terms import Term
from gsapp.identification.axes import AXIS_COEFFICIENTS, Axis
from gsapp.identification.maximum_likelihood.kernels import Forcing, GradientFactor, Kernel
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import GRAVITY

_ROW = {name: row for row, name in enumerate(POLAR_STATES)}
_INPUT = {name: row for row, name in enumerate(MODEL_INPUTS)}
_STATES: dict[Axis, tuple[str, ...]] = {"lon": ("alpha", "q"), "lat": ("beta", "p", "r")}
_ATTITUDE: dict[Axis, str] = {"lon": "theta", "lat": "phi"}
_NORMALIZED_RATES = {"p_hat": "p", "q_hat": "q", "r_hat": "r"}
_UNSUPPORTED_VARIABLES = frozenset(("alpha_dot_hat", "beta_dot_hat"))
# Target of an effect: the coefficient that it acts through, and its sign.
_EFFECT_COEFFICIENTS: dict[Axis, dict[str, tuple[str, float]]] = {
    "lon": {
        **{name: (name, 1.0) for name in AXIS_COEFFICIENTS["lon"]},
        "CZ": ("CN", -1.0),
        "CX": ("CA", -1.0),
        "M": ("Cm", 1.0),
    },
    "lat": {
        **{name: (name, 1.0) for name in AXIS_COEFFICIENTS["lat"]},
        "L": ("Cl", 1.0),
        "N": ("Cn", 1.0),
    },
}


class _EffectTerm(NamedTuple):
    """An effect on a coefficient: its term, parameters (places), free columns, and its sign."""

    term: Term
    places: slice
    columns: tuple[tuple[int, int], ...]
    sign: float
    moment: bool


class _Coefficient:
    """One coefficient: bias and linear terms, then effects."""

    def __init__(self, name: str, model: FlightModel, free: Sequence[str], suffixes: int) -> None:
        first = model.parameter_names.index(f"{name}_0")
        self.places = slice(first, first + suffixes)
        own = model.parameter_names[self.places]
        self.rows = [row for row, one in enumerate(own) if one in free]
        self.all_rows = len(self.rows) == suffixes
        start = free.index(own[self.rows[0]]) if self.rows else 0
        self.columns = slice(start, start + len(self.rows))
        self.extras: list[_EffectTerm] = []

    def rows_of(self, basis: FloatArray) -> FloatArray:
        """Return the derivatives by the free linear parameters."""
        return basis if self.all_rows else basis[self.rows]


class _CoefficientJacobian(NamedTuple):
    """A coefficient with its derivatives.

    By the rows of the basis that hold states, plain numbers but for effects; and by its free
    parameters: columns, and the rows of derivatives.
    """

    value: FloatArray
    by_row: list[FloatArray | float]
    by_parameter: list[tuple[slice, FloatArray]]


class _AxisKernel(Kernel):
    """What both cases share."""

    axis: Axis
    surfaces: tuple[str, ...]
    _half: int
    """Row of the table with half the reference length over V."""

    def __init__(
        self,
        model: FlightModel,
        responses: Sequence[str],
        free: Sequence[str],
        *,
        with_attitude: bool = False,
    ) -> None:
        self.model = model
        own = _STATES[self.axis]
        self.state_names = (*own, _ATTITUDE[self.axis]) if with_attitude else own
        self._with_attitude = with_attitude
        self.responses = tuple(responses)
        self.free = tuple(free)
        self._coefficients = {
            name: _Coefficient(name, model, self.free, 1 + len(own) + len(self.surfaces))
            for name in AXIS_COEFFICIENTS[self.axis]
        }
        self._linear = np.array(
            [np.arange(one.places.start, one.places.stop) for one in self._coefficients.values()]
        )
        for term, places in model.terms:
            through = _EFFECT_COEFFICIENTS[self.axis].get(term.target)
            if through is None or term.id.startswith("linear."):
                continue
            names = model.parameter_names[places]
            columns = tuple(
                (row, self.free.index(name)) for row, name in enumerate(names) if name in self.free
            )
            name, sign = through
            moment = term.target in ("L", "M", "N")
            self._coefficients[name].extras.append(_EffectTerm(term, places, columns, sign, moment))
        aircraft = model.aircraft
        self._aircraft = aircraft
        self._area = aircraft.geometry.wing_area
        self._span, self._chord = aircraft.geometry.span, aircraft.geometry.chord

    # --- coefficients ---------------------------------------------------------------------------

    def _read(self, name: str, drive: Forcing, x: FloatArray) -> FloatArray:
        found: FloatArray
        if name in self.state_names:
            found = x[self.state_names.index(name)]
        elif name in _NORMALIZED_RATES:
            length = self._chord if name == "q_hat" else self._span
            found = (
                self._read(_NORMALIZED_RATES[name], drive, x)
                * (0.5 * length)
                / drive.states[_ROW["V"]]
            )
        elif name in _ROW:
            found = drive.states[_ROW[name]]
        elif name in _INPUT:
            found = drive.inputs[_INPUT[name]]
        else:
            found = drive.precomputed[0 if name == "thrust" else 1]
        return found

    def _by_row(self, name: str, drive: Forcing) -> tuple[int, FloatArray | float] | None:
        """Return which state a reading depends on, and its slope by that state's basis row."""
        if _NORMALIZED_RATES.get(name) in self.state_names:
            return self.state_names.index(_NORMALIZED_RATES[name]), 1.0
        if name not in self.state_names:
            return None
        row = self.state_names.index(name)
        return row, 1.0 / drive.precomputed[self._half] if row else 1.0

    def _factor(self, extra: _EffectTerm, drive: Forcing) -> FloatArray | float:
        if not extra.moment:
            return extra.sign
        length = self._chord if self.axis == "lon" else self._span
        factor: FloatArray = extra.sign / (drive.precomputed[1] * (self._area * length))
        return factor

    def _reads(self, extra: _EffectTerm, drive: Forcing, x: FloatArray) -> tuple[FloatArray, ...]:
        return tuple(self._read(read, drive, x) for read in extra.term.reads)

    def _values(
        self, basis: FloatArray, drive: Forcing, x: FloatArray, values: FloatArray
    ) -> FloatArray:
        total: FloatArray = values[self._linear] @ basis
        for row, one in enumerate(self._coefficients.values()):
            for extra in one.extras:
                reads = self._reads(extra, drive, x)
                added = extra.term.value(reads, (), tuple(values[extra.places]))
                total[row] += self._factor(extra, drive) * added
        return total

    def _slopes(
        self, basis: FloatArray, drive: Forcing, x: FloatArray, values: FloatArray
    ) -> list[_CoefficientJacobian]:
        found = []
        coefficients = self._values(basis, drive, x, values)
        last = 1 + len(_STATES[self.axis])
        for value, one in zip(coefficients, self._coefficients.values(), strict=True):
            by_row: list[FloatArray | float] = values[one.places][1:last].tolist()
            by_parameter = [(one.columns, one.rows_of(basis))] if one.rows else []
            for extra in one.extras:
                reads = self._reads(extra, drive, x)
                jacobian = extra.term.jacobian(reads, (), tuple(values[extra.places]))
                factor = self._factor(extra, drive)
                for read, slope in zip(extra.term.reads, jacobian.reads, strict=True):
                    through = self._by_row(read, drive)
                    if through is not None:
                        row, scale = through
                        by_row[row] = by_row[row] + factor * slope * scale
                for row, column in extra.columns:
                    added = factor * jacobian.parameters[row] + 0.0 * x[:1]
                    by_parameter.append((slice(column, column + 1), added))
            found.append(_CoefficientJacobian(value, by_row, by_parameter))
        return found

    def _weighted(
        self,
        out: FloatArray,
        pairs: Sequence[tuple[_CoefficientJacobian, FloatArray]],
        by_rate: Sequence[FloatArray | float],
        drive: Forcing,
        S: FloatArray,
    ) -> None:
        """Write the total derivatives (m, n) of a response that is a weighted sum of coefficients.

        `pairs`: coefficients and their weights.
        `by_rate`: what else the response changes by with the rates of turn among the states.
        """
        for row in range(1 + len(by_rate)):
            by_state = sum(weight * slope.by_row[row] for slope, weight in pairs)
            if row:
                by_state = by_state * drive.precomputed[self._half] + by_rate[row - 1]
                out += by_state * S[row]
            else:
                np.multiply(by_state, S[0], out=out)
        for slope, weight in pairs:
            for columns, rows in slope.by_parameter:
                out[columns] += weight * rows

    # --- drives ---------------------------------------------------------------------------------

    def _common(self, states: FloatArray, inputs: FloatArray) -> tuple[FloatArray, ...]:
        """Return thrust, dynamic pressure, and thrust that yaws."""
        V, rho = states[0], inputs[_INPUT["rho"]]
        thrust = np.asarray(thrust_of(self._aircraft, inputs[_INPUT["throttle"]], rho, V))
        lever = inputs[_INPUT["throttle_difference"]]
        return thrust, 0.5 * rho * V * V, np.asarray(thrust_of(self._aircraft, lever, rho, V))


def _gradient_factors(
    slopes: Sequence[_CoefficientJacobian], factors: Sequence[tuple[tuple[int, FloatArray], ...]]
) -> list[GradientFactor]:
    """Return the derivatives of the rates by parameters from those by each coefficient."""
    return [
        GradientFactor(columns, own, rows)
        for slope, own in zip(slopes, factors, strict=True)
        for columns, rows in slope.by_parameter
    ]


def _sin_cos(angle: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return sine and cosine of flow angles; the root is cheaper than a second function."""
    sine = np.sin(angle)
    # Beyond a right angle no solution is accepted (`problem`), only passed through.
    return sine, np.sqrt(1.0 - sine * sine)


class LongitudinalKernel(_AxisKernel):
    """States alpha and q.

    alpha' = q + cos a (A - c CN) - sin a (B - c CA),  q' = d Cm + E,
    theta' = q cos phi - r sin phi
    with A = A0 + g cos phi cos theta/(V cos b),  B = B0 - g sin theta/(V cos b)
    """

    axis: Axis = "lon"
    surfaces = ("de",)
    _half = 7

    def build_forcing(
        self, states: FloatArray, inputs: FloatArray, by_path: FloatArray | None, values: FloatArray
    ) -> Forcing:
        del values
        V, _, beta, p, _, r, phi, theta, _ = states
        thrust, qbar, _ = self._common(states, inputs)
        mass, body = inputs[_INPUT["mass"]], self._aircraft.mass
        height = sum(z for _, _, z in self._aircraft.propulsion.position)
        height /= max(len(self._aircraft.propulsion.position), 1)
        cos_b, tan_b = np.cos(beta), np.tan(beta)
        per_speed = 1.0 / (V * cos_b)
        fall = GRAVITY * per_speed
        level = fall * np.cos(phi)
        up, forward = -tan_b * p, thrust / mass * per_speed + tan_b * r
        at_measured_pitch = (up + level * np.cos(theta), forward - fall * np.sin(theta))
        qS = qbar * self._area
        table = np.array(
            [
                thrust,
                qbar,
                *((up, forward) if self._with_attitude else at_measured_pitch),
                qS / mass * per_speed,
                qS * (self._chord / body.iyy),
                (height * thrust - (body.ixx - body.izz) * p * r - body.ixz * (p * p - r * r))
                / body.iyy,
                0.5 * self._chord / V,
                qS / mass,
                V * cos_b,
                thrust / mass,
                *((level, fall, np.cos(phi), np.sin(phi)) if self._with_attitude else ()),
            ]
        )
        return Forcing(states=states, inputs=inputs, path_derivatives=by_path, precomputed=table)

    def _along_and_across(self, drive: Forcing, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return A and B: all but aerodynamics across the flight path and along the body."""
        A, B = drive.precomputed[2:4]
        if self._with_attitude:
            A = A + drive.precomputed[11] * np.cos(x[2])
            B = B - drive.precomputed[12] * np.sin(x[2])
        return A, B

    def _basis(self, drive: Forcing, x: FloatArray) -> FloatArray:
        basis = np.empty((4, x.shape[1]))
        basis[0] = 1.0
        basis[1] = x[0]
        np.multiply(x[1], drive.precomputed[7], out=basis[2])
        basis[3] = drive.inputs[0]
        return basis

    def rates(self, drive: Forcing, x: FloatArray, values: FloatArray) -> FloatArray:
        basis = self._basis(drive, x)
        CN, CA, Cm = self._values(basis, drive, x, values)
        A, B = self._along_and_across(drive, x)
        c, d, E = drive.precomputed[4:7]
        sin_a, cos_a = _sin_cos(x[0])
        f = np.empty_like(x)
        f[0] = x[1] + cos_a * (A - c * CN) - sin_a * (B - c * CA)
        f[1] = d * Cm + E
        if self._with_attitude:
            f[2] = x[1] * drive.precomputed[13] - drive.states[_ROW["r"]] * drive.precomputed[14]
        return f

    def jacobian(
        self, drive: Forcing, x: FloatArray, values: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        basis = self._basis(drive, x)
        return self._with_slopes(drive, x, basis, values)[:2]

    def _with_slopes(
        self, drive: Forcing, x: FloatArray, basis: FloatArray, values: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, list[_CoefficientJacobian]]:
        CN, CA, Cm = three = self._slopes(basis, drive, x, values)
        A, B = self._along_and_across(drive, x)
        c, d, E, half = drive.precomputed[4:8]
        sin_a, cos_a = _sin_cos(x[0])
        up, forward = A - c * CN.value, B - c * CA.value
        f = np.empty_like(x)
        f[0] = x[1] + cos_a * up - sin_a * forward
        f[1] = d * Cm.value + E
        by_CN, by_CA = -c * cos_a, c * sin_a
        f_x = np.zeros((len(x), len(x), x.shape[1]))
        f_x[0, 0] = by_CN * CN.by_row[0] + by_CA * CA.by_row[0] - sin_a * up - cos_a * forward
        f_x[0, 1] = (by_CN * CN.by_row[1] + by_CA * CA.by_row[1]) * half + 1.0
        f_x[1, 0] = d * Cm.by_row[0]
        f_x[1, 1] = d * half * Cm.by_row[1]
        if self._with_attitude:
            level, fall, cos_phi, sin_phi = drive.precomputed[11:15]
            f[2] = x[1] * cos_phi - drive.states[_ROW["r"]] * sin_phi
            f_x[0, 2] = sin_a * fall * np.cos(x[2]) - cos_a * level * np.sin(x[2])
            f_x[2, 1] = cos_phi
        return f, f_x, by_CN, by_CA, three

    def gradients(
        self, drive: Forcing, x: FloatArray, values: FloatArray
    ) -> tuple[FloatArray, FloatArray, list[GradientFactor]]:
        basis = self._basis(drive, x)
        f, f_x, by_CN, by_CA, three = self._with_slopes(drive, x, basis, values)
        factors = (((0, by_CN),), ((0, by_CA),), ((1, drive.precomputed[5]),))
        return f, f_x, _gradient_factors(three, factors)

    def _shown(self, drive: Forcing, x: FloatArray, CN: FloatArray, CA: FloatArray,
               q_dot: FloatArray) -> FloatArray:  # fmt: skip
        sensors = self._aircraft.sensors
        p, r, q = drive.states[3], drive.states[5], x[1]
        per_mass, _, pull = drive.precomputed[8:11]
        y = np.empty((len(self.responses), x.shape[1]))
        for row, name in enumerate(self.responses):
            if name == "alpha":
                u, w = self._flow(drive, x)
                y[row] = sensors.alpha_vane.upwash * np.arctan2(w, u)
            elif name == "q":
                y[row] = q
            else:
                ahead, _, below = sensors.accelerometer.position
                if name == "an":
                    y[row] = per_mass * CN - (p * r - q_dot) * ahead + (p * p + q * q) * below
                else:
                    y[row] = (
                        pull - per_mass * CA - (q * q + r * r) * ahead + (p * r + q_dot) * below
                    )
        return y

    def _flow(self, drive: Forcing, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        ahead, right, below = self._aircraft.sensors.alpha_vane.position
        p, r, speed = drive.states[3], drive.states[5], drive.precomputed[9]
        sin_a, cos_a = _sin_cos(x[0])
        return (
            speed * cos_a + x[1] * below - r * right,
            speed * sin_a + p * right - x[1] * ahead,
        )

    def outputs(self, drive: Forcing, x: FloatArray, values: FloatArray) -> FloatArray:
        basis = self._basis(drive, x)
        CN, CA, Cm = self._values(basis, drive, x, values)
        return self._shown(drive, x, CN, CA, drive.precomputed[5] * Cm + drive.precomputed[6])

    def output_sensitivities(
        self, drive: Forcing, x: FloatArray, values: FloatArray, S: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        basis = self._basis(drive, x)
        CN, CA, Cm = self._slopes(basis, drive, x, values)
        y = self._shown(
            drive, x, CN.value, CA.value, drive.precomputed[5] * Cm.value + drive.precomputed[6]
        )
        dy = np.empty((len(self.responses), *S.shape[1:]))
        ahead, _, below = self._aircraft.sensors.accelerometer.position
        d, per_mass, q = drive.precomputed[5], drive.precomputed[8], x[1]
        for row, name in enumerate(self.responses):
            if name == "alpha":
                self._vane_sensitivity(drive, x, S, dy[row])
            elif name == "q":
                dy[row] = S[1]
            elif name == "an":
                pairs = ((CN, per_mass), (Cm, d * ahead))
                self._weighted(dy[row], pairs, (2.0 * below * q,), drive, S)
            else:
                pairs = ((CA, -per_mass), (Cm, d * below))
                self._weighted(dy[row], pairs, (-2.0 * ahead * q,), drive, S)
        return y, dy

    def _vane_sensitivity(
        self, drive: Forcing, x: FloatArray, S: FloatArray, out: FloatArray
    ) -> None:
        vane = self._aircraft.sensors.alpha_vane
        u, w = self._flow(drive, x)
        scale = vane.upwash / (u * u + w * w)
        speed = drive.precomputed[9]
        sin_a, cos_a = _sin_cos(x[0])
        by_alpha = scale * speed * (u * cos_a + w * sin_a)
        by_q = -scale * (u * vane.position[0] + w * vane.position[2])
        np.multiply(by_alpha, S[0], out=out)
        out += by_q * S[1]


class LateralKernel(_AxisKernel):
    """States beta, p and r.

    beta' = p sin a - r cos a + cos b (c CY + G) - sin b F,
    p' = d1 Cl + d2 Cn + q (e1 p + e2 r) + E1,  r' = d2 Cl + d3 Cn + q (e3 p + e4 r) + E3,
    phi' = p + tan theta (q sin phi + r cos phi), G = g cos theta sin phi/V, F = F0 + F1 cos phi
    """

    axis: Axis = "lat"
    surfaces = ("da", "dr")
    _half = 16

    def build_forcing(
        self, states: FloatArray, inputs: FloatArray, by_path: FloatArray | None, values: FloatArray
    ) -> Forcing:
        V, alpha, _, _, q, _, phi, theta, _ = states
        thrust, qbar, spread = self._common(states, inputs)
        mass, body = inputs[_INPUT["mass"]], self._aircraft.mass
        engines = self._aircraft.propulsion.position
        sideways = sum(abs(y) for _, y, _ in engines) / max(len(engines), 1)
        sin_a, cos_a, cos_t = np.sin(alpha), np.cos(alpha), np.cos(theta)
        qS = qbar * self._area
        lon = np.array([np.ones_like(V), alpha, q * (0.5 * self._chord) / V, inputs[0]])
        names = self.model.parameter_names
        CN, CA = (
            values[names.index(f"{name}_0") : names.index(f"{name}_0") + 4] @ lon
            for name in ("CN", "CA")
        )
        forward = (thrust - qS * CA) / mass - GRAVITY * np.sin(theta)
        weight = GRAVITY * cos_t / V
        # With roll computed along: F without, and what cos phi adds to it.
        F0 = (cos_a * forward - sin_a * qS * CN / mass) / V
        F1 = sin_a * weight
        determinant = body.ixx * body.izz - body.ixz**2
        moment = qS * (self._span / determinant)
        yaw = sideways * spread / determinant
        table = np.array(
            [
                thrust,
                qbar,
                sin_a,
                cos_a,
                qS / (mass * V),
                weight if self._with_attitude else weight * np.sin(phi),
                F0 if self._with_attitude else F0 + F1 * np.cos(phi),
                moment * body.izz,
                moment * body.ixz,
                moment * body.ixx,
                q * ((body.izz + body.ixx - body.iyy) * body.ixz / determinant),
                q * (-(body.izz * (body.izz - body.iyy) + body.ixz**2) / determinant),
                q * ((body.ixz**2 - body.ixx * (body.iyy - body.ixx)) / determinant),
                q * (-body.ixz * (body.izz - body.iyy + body.ixx) / determinant),
                yaw * body.ixz,
                yaw * body.ixx,
                0.5 * self._span / V,
                qS / mass,
                V * cos_a,
                *((F1, np.tan(theta)) if self._with_attitude else ()),
            ]
        )
        return Forcing(states=states, inputs=inputs, path_derivatives=by_path, precomputed=table)

    def _basis(self, drive: Forcing, x: FloatArray) -> FloatArray:
        basis = np.empty((6, x.shape[1]))
        basis[0] = 1.0
        basis[1] = x[0]
        np.multiply(x[1:3], drive.precomputed[16], out=basis[2:4])
        basis[4:] = drive.inputs[1:3]
        return basis

    def _gravity(self, drive: Forcing, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return G and F: the forces that are not side force, across and along the path."""
        G, F = drive.precomputed[5:7]
        if self._with_attitude:
            G, F = G * np.sin(x[3]), F + drive.precomputed[19] * np.cos(x[3])
        return G, F

    def _spin(
        self, drive: Forcing, x: FloatArray, Cl: FloatArray, Cn: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        d1, d2, d3, e1, e2, e3, e4, E1, E3 = drive.precomputed[7:16]
        return (
            d1 * Cl + d2 * Cn + e1 * x[1] + e2 * x[2] + E1,
            d2 * Cl + d3 * Cn + e3 * x[1] + e4 * x[2] + E3,
        )

    def rates(self, drive: Forcing, x: FloatArray, values: FloatArray) -> FloatArray:
        basis = self._basis(drive, x)
        CY, Cl, Cn = self._values(basis, drive, x, values)
        sin_a, cos_a, c = drive.precomputed[2:5]
        G, F = self._gravity(drive, x)
        sin_b, cos_b = _sin_cos(x[0])
        f = np.empty_like(x)
        f[0] = x[1] * sin_a - x[2] * cos_a + cos_b * (c * CY + G) - sin_b * F
        f[1], f[2] = self._spin(drive, x, Cl, Cn)
        if self._with_attitude:
            q, tan_t = drive.states[_ROW["q"]], drive.precomputed[20]
            f[3] = x[1] + tan_t * (q * np.sin(x[3]) + x[2] * np.cos(x[3]))
        return f

    def jacobian(
        self, drive: Forcing, x: FloatArray, values: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        basis = self._basis(drive, x)
        return self._with_slopes(drive, x, basis, values)[:2]

    def _with_slopes(
        self, drive: Forcing, x: FloatArray, basis: FloatArray, values: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray, list[_CoefficientJacobian]]:
        half = drive.precomputed[16]
        CY, Cl, Cn = three = self._slopes(basis, drive, x, values)
        sin_a, cos_a, c = drive.precomputed[2:5]
        G, F = self._gravity(drive, x)
        d1, _, _, e1, e2, e3, e4 = drive.precomputed[7:14]
        sin_b, cos_b = _sin_cos(x[0])
        side = c * CY.value + G
        f = np.empty_like(x)
        f[0] = x[1] * sin_a - x[2] * cos_a + cos_b * side - sin_b * F
        f[1], f[2] = self._spin(drive, x, Cl.value, Cn.value)
        by_CY = c * cos_b
        f_x = np.zeros((len(x), len(x), x.shape[1]))
        by_rate = by_CY * half
        f_x[0, 0] = by_CY * CY.by_row[0] - sin_b * side - cos_b * F
        f_x[0, 1] = by_rate * CY.by_row[1] + sin_a
        f_x[0, 2] = by_rate * CY.by_row[2] - cos_a
        # The moments d1, d2, d3 are in the ratio of the inertias: numbers are combined first.
        body = self._aircraft.mass
        d2_share, d3_share = body.ixz / body.izz, body.ixx / body.izz
        per_rate = d1 * half
        for column in range(3):
            per_row = per_rate if column else d1
            l_x, n_x = Cl.by_row[column], Cn.by_row[column]
            np.multiply(l_x + d2_share * n_x, per_row, out=f_x[1, column])
            np.multiply(d2_share * l_x + d3_share * n_x, per_row, out=f_x[2, column])
        f_x[1, 1] += e1
        f_x[1, 2] += e2
        f_x[2, 1] += e3
        f_x[2, 2] += e4
        if self._with_attitude:
            q, tan_t = drive.states[_ROW["q"]], drive.precomputed[20]
            sin_phi, cos_phi = np.sin(x[3]), np.cos(x[3])
            f[3] = x[1] + tan_t * (q * sin_phi + x[2] * cos_phi)
            f_x[0, 3] = (
                cos_b * drive.precomputed[5] * cos_phi + sin_b * drive.precomputed[19] * sin_phi
            )
            f_x[3, 1] = 1.0
            f_x[3, 2] = tan_t * cos_phi
            f_x[3, 3] = tan_t * (q * cos_phi - x[2] * sin_phi)
        return f, f_x, by_CY, three

    def gradients(
        self, drive: Forcing, x: FloatArray, values: FloatArray
    ) -> tuple[FloatArray, FloatArray, list[GradientFactor]]:
        basis = self._basis(drive, x)
        f, f_x, by_CY, three = self._with_slopes(drive, x, basis, values)
        d1, d2, d3 = drive.precomputed[7:10]
        factors = (((0, by_CY),), ((1, d1), (2, d2)), ((1, d2), (2, d3)))
        return f, f_x, _gradient_factors(three, factors)

    def _flow(self, drive: Forcing, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        ahead, right, below = self._aircraft.sensors.beta_vane.position
        sin_b, cos_b = _sin_cos(x[0])
        return (
            drive.precomputed[18] * cos_b + drive.states[_ROW["q"]] * below - x[2] * right,
            drive.states[0] * sin_b + x[2] * ahead - x[1] * below,
        )

    def _shown(
        self, drive: Forcing, x: FloatArray, CY: FloatArray, spin: tuple[FloatArray, FloatArray]
    ) -> FloatArray:
        sensors = self._aircraft.sensors
        q = drive.states[_ROW["q"]]
        p, r = x[1:3]
        y = np.empty((len(self.responses), x.shape[1]))
        for row, name in enumerate(self.responses):
            if name == "beta":
                u, v = self._flow(drive, x)
                y[row] = sensors.beta_vane.upwash * np.arctan2(v, u)
            elif name == "ay":
                ahead, right, below = sensors.accelerometer.position
                y[row] = (
                    drive.precomputed[17] * CY
                    + (p * q + spin[1]) * ahead
                    - (p * p + r * r) * right
                    + (q * r - spin[0]) * below
                )
            else:
                y[row] = p if name == "p" else r
        return y

    def outputs(self, drive: Forcing, x: FloatArray, values: FloatArray) -> FloatArray:
        basis = self._basis(drive, x)
        CY, Cl, Cn = self._values(basis, drive, x, values)
        return self._shown(drive, x, CY, self._spin(drive, x, Cl, Cn))

    def output_sensitivities(
        self, drive: Forcing, x: FloatArray, values: FloatArray, S: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        basis = self._basis(drive, x)
        CY, Cl, Cn = self._slopes(basis, drive, x, values)
        y = self._shown(drive, x, CY.value, self._spin(drive, x, Cl.value, Cn.value))
        dy = np.empty((len(self.responses), *S.shape[1:]))
        for row, name in enumerate(self.responses):
            if name == "beta":
                self._vane_sensitivity(drive, x, S, dy[row])
            elif name == "ay":
                ahead, right, below = self._aircraft.sensors.accelerometer.position
                d1, d2, d3, e1, e2, e3, e4 = drive.precomputed[7:14]
                q = drive.states[_ROW["q"]]
                pairs = (
                    (CY, drive.precomputed[17]),
                    (Cl, ahead * d2 - below * d1),
                    (Cn, ahead * d3 - below * d2),
                )
                by_p = ahead * (q + e3) - below * e1 - 2.0 * right * x[1]
                by_r = ahead * e4 + below * (q - e2) - 2.0 * right * x[2]
                self._weighted(dy[row], pairs, (by_p, by_r), drive, S)
            else:
                dy[row] = S[1] if name == "p" else S[2]
        return y, dy

    def _vane_sensitivity(
        self, drive: Forcing, x: FloatArray, S: FloatArray, out: FloatArray
    ) -> None:
        vane = self._aircraft.sensors.beta_vane
        ahead, right, below = vane.position
        u, v = self._flow(drive, x)
        scale = vane.upwash / (u * u + v * v)
        sin_b, cos_b = _sin_cos(x[0])
        np.multiply(
            scale * (u * drive.states[0] * cos_b + v * drive.precomputed[18] * sin_b), S[0], out=out
        )
        out += (scale * u * -below) * S[1]
        out += (scale * (u * ahead + v * right)) * S[2]


def build_axis_kernel(
    model: FlightModel,
    axis: Axis,
    states: Sequence[str],
    responses: Sequence[str],
    free: Sequence[str],
) -> Kernel | None:
    """Return the kernel written out for a case; None where only the general one covers it.

    `states` and `responses`: active ones.
    `free`: free parameters of the equations, in the order of ``model.parameter_names``.
    """
    if axis == "both" or len(model.state_names) > len(POLAR_STATES):
        return None
    with_attitude = tuple(states) == (*_STATES[axis], _ATTITUDE[axis])
    if tuple(states) != _STATES[axis] and not with_attitude:
        return None
    shown = {"lon": ("alpha", "q", "an", "ax"), "lat": ("beta", "p", "r", "ay")}[axis]
    if not set(responses) <= set(shown) or not _supports_model(model, axis, free):
        return None
    if (
        not _supports_instruments(model.aircraft, axis)
        or model.swapped_channels
        or model.displaced_instruments
    ):
        return None
    kind = LongitudinalKernel if axis == "lon" else LateralKernel
    return kind(model, responses, free, with_attitude=with_attitude)


def _supports_instruments(aircraft: Aircraft, axis: Axis) -> bool:
    if axis == "lon":
        # Off the plane of symmetry the accelerometer feels p' and r'.
        return aircraft.sensors.accelerometer.position[1] == 0.0
    return aircraft.sensors.beta_vane.kind == "fixed"


def _supports_model(model: FlightModel, axis: Axis, free: Sequence[str]) -> bool:
    own = {f"linear.{name}" for name in AXIS_COEFFICIENTS[axis]}
    for term, places in model.terms:
        names = model.parameter_names[places]
        if term.id in own:
            continue
        if not set(names).isdisjoint(free) and term.target not in _EFFECT_COEFFICIENTS[axis]:
            return False
        if term.id.startswith("linear."):
            continue
        if term.states or not _UNSUPPORTED_VARIABLES.isdisjoint(term.reads):
            return False
        if term.target not in _EFFECT_COEFFICIENTS[axis] and not _is_irrelevant_target(
            term.target, axis
        ):
            return False
    return True


def _is_irrelevant_target(target: str, axis: Axis) -> bool:
    """Return whether an effect on this target leaves the active states and responses alone."""
    return target in (("CY", "Cl", "Cn", "Y", "L", "N") if axis == "lon" else ("Cm", "M"))

"""An aircraft, a model and its effects put together: loads, rates of the states, outputs.

`FlightModel` sums the terms of a model into coefficients, adds thrust, and hands forces and
moments to the equations of motion. The same object serves the simulator (single floats), the
estimators (arrays, Jacobians) and trim.

States are the nine polar ones followed by those of the terms; inputs are `MODEL_INPUTS`; parameters
are those of all terms in the equations, named by `parameter_names`. Effects of control paths and
instruments lie outside the equations and are found in `control_terms` and `sensor_terms`.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.dynamics.arithmetic import Value
from gsapp.dynamics.atmosphere import SEA_LEVEL_DENSITY
from gsapp.dynamics.buildup import create_linear_terms
from gsapp.dynamics.equations import (
    POLAR_STATES,
    Loads,
    PolarState,
    RigidBody,
    polar_jacobian,
    polar_rates,
    wind_axis_rates,
)
from gsapp.dynamics.model import Model
from gsapp.dynamics.signal_terms import PathTerms, SignalTerm, SwappedChannels, channels_of_target
from gsapp.dynamics.terms import (
    POSITIONED_INSTRUMENTS,
    TARGETS,
    VARIABLES,
    Term,
    TermJacobian,
    Values,
    position_targets,
)
from gsapp.foundation import FlightError, UnknownNameError
from gsapp.quantities import FloatArray

MODEL_INPUTS = ("de", "da", "dr", "flap", "throttle", "throttle_difference", "rho", "mass")
"""Inputs of the equations: surfaces (rad), throttle as the engines follow it, half the left
throttle minus the right, air density (kg/m^3), mass of the aircraft (kg)."""

_VARIABLE_NAMES = tuple(VARIABLES)
_VARIABLE_INDEX = {name: index for index, name in enumerate(_VARIABLE_NAMES)}
_TARGET_INDEX = {name: index for index, name in enumerate(TARGETS)}
_THRUST = _VARIABLE_INDEX["thrust"]
_ALPHA_DOT = _VARIABLE_INDEX["alpha_dot_hat"]
_BETA_DOT = _VARIABLE_INDEX["beta_dot_hat"]
_PREFIXES = ("control.", "sensor.")

# Terms are summed in three passes: what they read must be known by then.
_POSITION_TARGETS = {name: position_targets(name) for name in POSITIONED_INSTRUMENTS}
_OFFSETS = (
    "thrust", "mass", "ixx", "iyy", "izz", "ixz", "cg.x", "cg.y", "cg.z",
    *(target for target in TARGETS if target.startswith("place.")),
)  # fmt: skip
_FORCES = ("CN", "CA", "CY", "CX", "CZ", "X", "Y", "Z")


class _Entry(NamedTuple):
    """A term, with where to find what it reads and where to put what it gives."""

    term: Term
    target: int
    read: Callable[[Any], Any]
    reads: tuple[int, ...]
    states: slice
    parameters: slice


class ModelEvaluation(NamedTuple):
    """Everything on the way from states to rates."""

    coefficients: dict[str, Value]
    """CN, CA, CY, Cl, Cm, Cn with all effects, about the aircraft file's CG."""
    loads: Loads  # Forces (N) and moments about the CG (N m), thrust included.
    thrust: Value  # N.
    body: RigidBody  # Mass and inertia with the effects' offsets.
    cg: tuple[Value, Value, Value]  # Where the CG lies from the aircraft file's, m.
    term_rates: tuple[Value, ...]  # Rates of the terms' own states.
    variables: list[Value]  # In the order of `gsapp.dynamics.terms.VARIABLES`.
    position_offsets: dict[str, tuple[Value, Value, Value]]
    """How far an instrument sits from where the aircraft file says, m; only those that do."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ModelJacobian:
    """Derivatives by all states, `MODEL_INPUTS`, then the free parameters: n_all columns."""

    evaluation: ModelEvaluation  # The values, arrays of shape (n,) or floats.
    coefficients: FloatArray  # Shape (n, 6, n_all). Of CN, CA, CY, Cl, Cm, Cn.
    thrust: FloatArray  # Shape (n, n_all).
    loads: FloatArray  # Shape (n, 6, n_all). Of X, Y, Z, L, M, N.
    body: FloatArray  # Shape (n, 5, n_all). Of mass, ixx, iyy, izz, ixz.
    cg: FloatArray  # Shape (n, 3, n_all).
    position_offsets: dict[str, FloatArray]
    """Shape (n, 3, n_all). Of the instruments in ``totals.places``."""
    rates: FloatArray  # Shape (n, n_states, n_all).
    free_parameters: tuple[str, ...]  # The parameters in the last columns.

    def split(self, array: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the columns by states, by inputs and by parameters of one of the arrays."""
        one = self.rates.shape[1]
        two = one + len(MODEL_INPUTS)
        return array[..., :one], array[..., one:two], array[..., two:]


class FlightModel:
    """The equations of one aircraft with one model.

    Parameters
    ----------
    extra : sequence of Term
        Terms beside those of the model file, with their default parameters (the stall of a
        virtual aircraft, a candidate under test).

    Attributes
    ----------
    state_names, parameter_names : tuple of str
        A derivative keeps its name; a parameter of an effect is ``<effect id>.<name>``.
    defaults : tuple of float
        Values of the parameters in the model file.
    control_terms, sensor_terms : dict of str to PathTerms
        Effects outside the equations, by surface (``elevator``) or channel, with values. An
        effect on a box stands with every channel of the box.
    swapped_channels : tuple of (str, str)
        Channels that carry each other's signal, before their paths.
    displaced_instruments : tuple of str
        Instruments that sit elsewhere than the aircraft file says.
    """

    def __init__(self, aircraft: Aircraft, model: Model, *, extra: Sequence[Term] = ()) -> None:
        self.aircraft = aircraft
        self.model = model
        geometry = aircraft.geometry
        self.area, self.span, self.chord = geometry.wing_area, geometry.span, geometry.chord
        propulsion = aircraft.propulsion
        self._thrust_per_density = propulsion.max_thrust / SEA_LEVEL_DENSITY
        self._thrust_slope = 1.0 / propulsion.zero_thrust_speed
        self._engine_offsets = _engine_offsets(propulsion.position)
        mass = aircraft.mass
        self._inertia = (mass.ixx, mass.iyy, mass.izz, mass.ixz)
        self.control_terms: dict[str, PathTerms] = {}
        self.sensor_terms: dict[str, PathTerms] = {}
        self.swapped_channels: tuple[tuple[str, str], ...] = ()
        states: list[str] = list(POLAR_STATES)
        names: list[str] = []
        values: list[float] = []
        entries: list[_Entry] = []
        for term, given in self._all_terms(extra):
            if term.target.startswith(_PREFIXES):
                self._outside(term, given)
                continue
            derivative = term.id.startswith("linear.")
            first_state, first_parameter = len(states), len(names)
            states += [f"{term.id}.{name}" for name in term.states]
            names += [
                parameter.name if derivative else f"{term.id}.{parameter.name}"
                for parameter in term.parameters
            ]
            values += given
            entries.append(
                _entry(
                    term,
                    slice(first_state, len(states)),
                    slice(first_parameter, len(names)),
                )
            )
        self.state_names = tuple(states)
        self.parameter_names = tuple(names)
        self.defaults = tuple(values)
        passes = ([], [], [])  # type: tuple[list[_Entry], list[_Entry], list[_Entry]]
        for entry in entries:
            target = entry.term.target
            passes[0 if target in _OFFSETS else 1 if target in _FORCES else 2].append(entry)
        self._passes = tuple(tuple(one) for one in passes)
        self._entries = tuple(entries)
        offset = {entry.term.target for entry in entries}
        self.displaced_instruments = tuple(
            name
            for name, axes in _POSITION_TARGETS.items()
            if any(not offset.isdisjoint(targets) for targets in axes)
        )
        self._needs_flow_rates = any(
            index in entry.reads for entry in entries for index in (_ALPHA_DOT, _BETA_DOT)
        )
        self._check_order()

    # --- putting together -----------------------------------------------------------------------

    @property
    def terms(self) -> tuple[tuple[Term, slice], ...]:
        """Return the terms in the equations, each with the places of its parameters."""
        return tuple((entry.term, entry.parameters) for entry in self._entries)

    def _all_terms(self, extra: Sequence[Term]) -> list[tuple[Term, tuple[float, ...]]]:
        terms: list[tuple[Term, tuple[float, ...]]] = [
            (term, tuple(self.model.derivative(item.name) for item in term.parameters))
            for term in create_linear_terms()
        ]
        terms += [
            (effect.term(self.aircraft), effect.values(self.aircraft))
            for effect in self.model.effects
        ]
        terms += [(term, tuple(term.defaults.values())) for term in extra]
        return terms

    def _outside(self, term: Term, values: tuple[float, ...]) -> None:
        if isinstance(term, SwappedChannels):
            self.swapped_channels = (*self.swapped_channels, term.pair)
            return
        if not isinstance(term, SignalTerm):
            raise TypeError(f"the effect '{term.id}' on '{term.target}' is no signal term")
        group, _, target = term.target.partition(".")
        table = self.control_terms if group == "control" else self.sensor_terms
        for name in channels_of_target(target):
            table[name] = (*table.get(name, ()), (term, values))

    def _check_order(self) -> None:
        late = {_ALPHA_DOT: "alpha_dot_hat", _BETA_DOT: "beta_dot_hat"}
        for index, one_pass in enumerate(self._passes[:2]):
            blocked = dict(late) if index else {**late, _THRUST: "thrust"}
            for entry in one_pass:
                for variable, name in zip(entry.reads, entry.term.reads, strict=True):
                    if variable in blocked and name not in entry.term.rate_only_reads:
                        raise FlightError(
                            f"the effect '{entry.term.id}' reads {blocked[variable]}, which is "
                            f"known only after {entry.term.target} is summed; give it its own "
                            "state instead (aero.CN.memory does so)"
                        )

    def steady_states(self, state: Values, inputs: Values) -> tuple[Value, ...]:
        """Return the terms' own states that have settled at the polar state and inputs."""
        variables = self._variables(state, inputs)
        sums: list[Value] = [0.0] * len(TARGETS)
        _add(self._passes[0], variables, state, self.defaults, sums)
        variables[_THRUST] = self._thrust(variables, sums)
        settled: list[Value] = []
        for entry in self._entries:
            if entry.term.states:
                read = entry.read(variables)
                settled += entry.term.steady_state(read, self.defaults[entry.parameters])
        return tuple(settled)

    # --- values ---------------------------------------------------------------------------------

    def _variables(self, state: Values, inputs: Values) -> list[Value]:
        V, alpha, beta, p, q, r = state[:6]
        de, da, dr, flap, throttle, difference, rho, _ = inputs
        half = 0.5 / V
        by_span, by_chord = half * self.span, half * self.chord
        return [
            V, alpha, beta, p, q, r, p * by_span, q * by_chord, r * by_span,
            de, da, dr, flap, throttle, difference, rho, 0.5 * rho * V * V, 0.0, 0.0, 0.0,
        ]  # fmt: skip

    def _thrust(self, variables: Values, sums: Values) -> Value:
        """Return the thrust (N), what terms add to it included."""
        V, throttle, rho = variables[0], variables[13], variables[15]
        return (
            throttle * self._thrust_per_density * rho * (1.0 - self._thrust_slope * V)
            + sums[_TARGET_INDEX["thrust"]]
        )

    def evaluate(
        self,
        state: Values,
        inputs: Values,
        parameters: Values | None = None,
    ) -> ModelEvaluation:
        """Return coefficients, loads and all else between states and rates.

        The state is polar states, then the terms' own, each a float or an array (n,); inputs are in
        the order of `MODEL_INPUTS`, parameters in that of `parameter_names`, the model's own by
        default.
        """
        values = self.defaults if parameters is None else parameters
        variables = self._variables(state, inputs)
        sums: list[Value] = [0.0] * len(TARGETS)
        offsets, forces, moments = self._passes
        if offsets:
            _add(offsets, variables, state, values, sums)
        V, rho, qbar = variables[0], variables[15], variables[16]
        thrust = variables[_THRUST] = self._thrust(variables, sums)
        _add(forces, variables, state, values, sums)
        CN, CA, CY = sums[0] - sums[7], sums[1] - sums[6], sums[2]
        qS = qbar * self.area
        X = thrust - qS * CA + sums[8]
        Y = qS * CY + sums[9]
        Z = sums[10] - qS * CN
        ixx, iyy, izz, ixz = self._inertia
        body = RigidBody(
            mass=inputs[7] + sums[15],
            ixx=ixx + sums[16],
            iyy=iyy + sums[17],
            izz=izz + sums[18],
            ixz=ixz + sums[19],
        )
        if self._needs_flow_rates:
            flow = wind_axis_rates(PolarState(*state[:9]), X, Y, Z, body.mass)
            variables[_ALPHA_DOT] = flow[1] * self.chord * 0.5 / V
            variables[_BETA_DOT] = flow[2] * self.span * 0.5 / V
        _add(moments, variables, state, values, sums)
        Cl, Cm, Cn = sums[3:6]
        height, sideways = self._engine_offsets
        spread = variables[14] * self._thrust_per_density * rho * (1.0 - self._thrust_slope * V)
        cg = (sums[20], sums[21], sums[22])
        # Moments about the CG where it is; engines and aerodynamics act about the file's.
        L = qS * self.span * Cl + sums[11] + cg[2] * Y - cg[1] * Z
        M = qS * self.chord * Cm + height * thrust + sums[12] + cg[0] * Z - cg[2] * X
        N = qS * self.span * Cn + sideways * spread + sums[13] + cg[1] * X - cg[0] * Y
        term_rates: tuple[Value, ...] = ()
        if len(self.state_names) > 9:
            for entry in self._entries:
                if entry.term.states:
                    term_rates += entry.term.rates(
                        entry.read(variables), state[entry.states], values[entry.parameters]
                    )
        return ModelEvaluation(
            {"CN": CN, "CA": CA, "CY": CY, "Cl": Cl, "Cm": Cm, "Cn": Cn},
            Loads(X, Y, Z, L, M, N),
            thrust,
            body,
            cg,
            term_rates,
            variables,
            {name: _position_offset(name, sums) for name in self.displaced_instruments},
        )

    def rates(
        self,
        state: Values,
        inputs: Values,
        parameters: Values | None = None,
    ) -> tuple[Value, ...]:
        """Return the rates of all states, in the order of `state_names`; see `evaluate`."""
        totals = self.evaluate(state, inputs, parameters)
        polar = polar_rates(PolarState(*state[:9]), totals.loads, totals.body)
        return (*polar, *totals.term_rates)

    # --- derivatives ----------------------------------------------------------------------------

    def differentiate(
        self,
        state: Values,
        inputs: Values,
        parameters: Values | None = None,
        *,
        free: Sequence[str] | None = None,
    ) -> ModelJacobian:
        """Return the exact total derivatives; arguments as in `evaluate`.

        Single numbers count as arrays of length 1. `free` are the parameters by which to
        differentiate; all by default.
        """
        values = self.defaults if parameters is None else parameters
        totals = self.evaluate(state, inputs, parameters)
        chain = _Chain(self, totals, state, inputs, values, free)
        offsets, forces, moments = self._passes
        chain.add(offsets)
        chain.add_thrust(self._thrust_per_density, self._thrust_slope)
        chain.add(forces)

        sums, area = chain.sums, self.area
        d_coefficients = {
            "CN": sums("CN") - sums("CZ"),
            "CA": sums("CA") - sums("CX"),
            "CY": sums("CY"),
        }
        dX = chain.thrust - chain.times_qbar(d_coefficients["CA"], "CA", area) + sums("X")
        dY = chain.times_qbar(d_coefficients["CY"], "CY", area) + sums("Y")
        dZ = sums("Z") - chain.times_qbar(d_coefficients["CN"], "CN", area)
        d_mass = sums("mass").copy()
        d_mass[:, chain.input("mass")] += 1.0
        polar = PolarState(*state[:9])
        equations = polar_jacobian(polar, totals.loads, totals.body)
        if self._needs_flow_rates:
            d_force = np.stack([dX, dY, dZ], axis=1)
            for row, index, length in ((1, _ALPHA_DOT, self.chord), (2, _BETA_DOT, self.span)):
                d_rate = np.einsum("ni,nij->nj", equations.loads[:, row, :3], d_force)
                d_rate += equations.body[:, row, :1] * d_mass
                d_rate[:, :9] += equations.states[:, row]
                chain.add_flow_rate(index, d_rate, length)
        chain.add(moments)

        d_coefficients.update({name: sums(name) for name in ("Cl", "Cm", "Cn")})
        height, sideways = self._engine_offsets
        d_spread = chain.thrust_of(
            "throttle_difference", self._thrust_per_density, self._thrust_slope
        )
        loads, (cx, cy, cz) = totals.loads, totals.cg
        gx, gy, gz = sums("cg.x"), sums("cg.y"), sums("cg.z")
        by_span, by_chord = area * self.span, area * self.chord
        dL = chain.times_qbar(d_coefficients["Cl"], "Cl", by_span) + sums("L")
        dM = chain.times_qbar(d_coefficients["Cm"], "Cm", by_chord) + sums("M")
        dN = chain.times_qbar(d_coefficients["Cn"], "Cn", by_span) + sums("N")
        dM += height * chain.thrust
        dN += sideways * d_spread
        if chain.has("cg.x", "cg.y", "cg.z"):
            dL += _cross(cz, loads.Y, cy, loads.Z, gz, dY, gy, dZ)
            dM += _cross(cx, loads.Z, cz, loads.X, gx, dZ, gz, dX)
            dN += _cross(cy, loads.X, cx, loads.Y, gy, dX, gx, dY)
        d_loads = np.stack([dX, dY, dZ, dL, dM, dN], axis=1)
        d_body = np.stack([d_mass, *(sums(name) for name in ("ixx", "iyy", "izz", "ixz"))], axis=1)
        rates = np.zeros((chain.count, len(self.state_names), chain.width))
        rates[:, :9] = equations.loads @ d_loads + equations.body @ d_body
        rates[:, :9, :9] += equations.states
        for entry in self._entries:
            if entry.term.states:
                chain.add_rates(entry, rates)
        return ModelJacobian(
            evaluation=totals,
            coefficients=np.stack([d_coefficients[name] for name in totals.coefficients], axis=1),
            thrust=chain.thrust,
            loads=d_loads,
            body=d_body,
            cg=np.stack([gx, gy, gz], axis=1),
            position_offsets={
                name: np.stack(
                    [sum(sums(one) for one in targets) for targets in _POSITION_TARGETS[name]],
                    axis=1,
                )
                for name in self.displaced_instruments
            },
            rates=rates,
            free_parameters=chain.free,
        )


class _Chain:
    """The chain rule through the terms: from variables to the sums of each target.

    Variables of motion and inputs depend on one or two columns each; thrust and the flow rates on
    many. So the former are kept as (column, slope) pairs, the latter as whole arrays (n, n_all).
    """

    def __init__(
        self,
        model: FlightModel,
        totals: ModelEvaluation,
        state: Values,
        inputs: Values,
        parameters: Values,
        free: Sequence[str] | None,
    ) -> None:
        self._n_states = len(model.state_names)
        self._totals, self._state = totals, state
        self._inputs, self._parameters = inputs, parameters
        self.free = model.parameter_names if free is None else tuple(free)
        unknown = [name for name in self.free if name not in model.parameter_names]
        if unknown:
            raise UnknownNameError(
                f"the model '{model.model.name}' has no parameter {', '.join(unknown)}"
            )
        first = self._n_states + len(MODEL_INPUTS)
        place = {name: first + index for index, name in enumerate(self.free)}
        self._columns = [place.get(name) for name in model.parameter_names]
        self.width = first + len(self.free)
        shapes = [np.shape(x) for x in (*state, *inputs, *parameters)]
        shape = np.broadcast_shapes((1,), *shapes)
        self.count = shape[0]
        self._sums: dict[int, FloatArray] = {}
        self._dense: dict[int, FloatArray] = {}
        V, rho = state[0], inputs[6]
        self._sparse: dict[int, list[tuple[int, Value]]] = {
            index: [(index, 1.0)] for index in range(6)
        }
        for row, rate, length in ((6, 3, model.span), (7, 4, model.chord), (8, 5, model.span)):
            self._sparse[row] = [(rate, 0.5 * length / V), (0, -totals.variables[row] / V)]
        for index in range(7):
            self._sparse[9 + index] = [(self._n_states + index, 1.0)]
        self._d_qbar: list[tuple[int, Value]] = [(0, rho * V), (self.input("rho"), 0.5 * V * V)]
        self._sparse[16] = self._d_qbar

    def input(self, name: str) -> int:
        return self._n_states + MODEL_INPUTS.index(name)

    def has(self, *targets: str) -> bool:
        """Return whether any term adds to one of the targets."""
        return any(_TARGET_INDEX[target] in self._sums for target in targets)

    def sums(self, target: str) -> FloatArray:
        """Return the derivatives of what was added to a target, shape (n, n_all)."""
        return self._sum(_TARGET_INDEX[target])

    def _sum(self, target: int) -> FloatArray:
        if target not in self._sums:
            return np.zeros((self.count, self.width))
        return self._sums[target]

    @property
    def thrust(self) -> FloatArray:
        return self._dense[_THRUST]

    def thrust_of(self, lever: str, per_density: float, slope: float) -> FloatArray:
        """Return the derivatives of the thrust that one of the throttle inputs makes."""
        rho, V, setting = self._inputs[6], self._state[0], self._inputs[MODEL_INPUTS.index(lever)]
        fade = 1.0 - slope * V
        out = np.zeros((self.count, self.width))
        out[:, self.input(lever)] = per_density * rho * fade
        out[:, self.input("rho")] = per_density * setting * fade
        out[:, 0] = -per_density * setting * rho * slope
        return out

    def add_thrust(self, per_density: float, slope: float) -> None:
        """Enter the derivatives of the thrust, effects on it included."""
        whole = self.thrust_of("throttle", per_density, slope)
        self._dense[_THRUST] = whole + self.sums("thrust") if self.has("thrust") else whole

    def add_flow_rate(self, index: int, d_rate: FloatArray, length: float) -> None:
        """Enter the derivatives of rate * length/(2V)."""
        V = self._state[0]
        out = _as_column(0.5 * length / V) * d_rate
        out[:, 0] -= self._totals.variables[index] / V
        self._dense[index] = out

    def times_qbar(self, slopes: FloatArray, name: str, size: float) -> FloatArray:
        """Return the derivatives of size * qbar * coefficient."""
        out = _as_column(size * self._totals.variables[16]) * slopes
        for column, slope in self._d_qbar:
            out[:, column] += size * self._totals.coefficients[name] * slope
        return out

    def add(self, entries: Sequence[_Entry]) -> None:
        """Add the derivatives of terms to those of their targets."""
        for entry in entries:
            jacobian = self._jacobian(entry)
            out = self._sum(entry.target)
            self._sums[entry.target] = out
            self._spread(entry, out, jacobian.reads, jacobian.states, jacobian.parameters)

    def add_rates(self, entry: _Entry, rates: FloatArray) -> None:
        """Add the derivatives of the rates of a term's own states."""
        jacobian = self._jacobian(entry)
        for row in range(len(entry.term.states)):
            self._spread(
                entry,
                rates[:, entry.states.start + row],
                jacobian.rate_reads[row],
                jacobian.rate_states[row],
                jacobian.rate_parameters[row],
            )

    def _jacobian(self, entry: _Entry) -> TermJacobian:
        return entry.term.jacobian(
            entry.read(self._totals.variables),
            self._state[entry.states],
            self._parameters[entry.parameters],
        )

    def _spread(
        self,
        entry: _Entry,
        out: FloatArray,
        by_reads: Values,
        by_states: Values,
        by_parameters: Values,
    ) -> None:
        for index, slope in zip(entry.reads, by_reads, strict=True):
            if index in self._dense:
                out += _as_column(slope) * self._dense[index]
            else:
                # Rates of the flow, which are known only after the forces, enter no force.
                for column, part in self._sparse.get(index, ()):
                    out[:, column] += slope * part
        for offset, slope in enumerate(by_states):
            out[:, entry.states.start + offset] += slope
        for offset, slope in enumerate(by_parameters):
            place = self._columns[entry.parameters.start + offset]
            if place is not None:
                out[:, place] += slope


def _as_column(value: Value) -> FloatArray:
    return np.asarray(value, dtype=float)[..., None]


def _cross(
    a: Value, b: Value, c: Value, d: Value,
    da: FloatArray, db: FloatArray, dc: FloatArray, dd: FloatArray,
) -> FloatArray:  # fmt: skip
    return _as_column(a) * db + _as_column(b) * da - _as_column(c) * dd - _as_column(d) * dc


def _position_offset(name: str, sums: Values) -> tuple[Value, Value, Value]:
    x, y, z = (
        sum(sums[_TARGET_INDEX[one]] for one in targets) for targets in _POSITION_TARGETS[name]
    )
    return x, y, z


def _engine_offsets(positions: Sequence[tuple[float, float, float]]) -> tuple[float, float]:
    """Return the mean height below the CG, and the yawing arm of a difference in throttle (m)."""
    count = max(len(positions), 1)
    height = sum(z for _, _, z in positions) / count
    # Each engine gives 1/count of the thrust; the left ones (y < 0) get more by the difference.
    return height, sum(abs(y) for _, y, _ in positions) / count


def _entry(term: Term, states: slice, parameters: slice) -> _Entry:
    unknown = [name for name in term.reads if name not in _VARIABLE_INDEX]
    if unknown:
        raise UnknownNameError(
            f"the effect '{term.id}' reads {', '.join(unknown)}, which the equations do not have; "
            f"they have {', '.join(VARIABLES)}"
        )
    if term.target not in _TARGET_INDEX:
        raise UnknownNameError(
            f"the effect '{term.id}' adds to '{term.target}'; targets are {', '.join(TARGETS)}"
        )
    reads = tuple(_VARIABLE_INDEX[name] for name in term.reads)
    read: Callable[[Any], Any]
    if len(reads) > 1:
        read = operator.itemgetter(*reads)
    elif reads:
        read = operator.itemgetter(slice(reads[0], reads[0] + 1))
    else:
        read = operator.itemgetter(slice(0, 0))
    return _Entry(term, _TARGET_INDEX[term.target], read, reads, states, parameters)


def _add(
    entries: Sequence[_Entry],
    variables: list[Value],
    state: Values,
    parameters: Values,
    sums: list[Value],
) -> None:
    for term, target, read, _, states, own in entries:
        sums[target] = sums[target] + term.value(read(variables), state[states], parameters[own])

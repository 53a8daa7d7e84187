"""Derivatives of rates and forces by what a search moves, column by column.

`FlightModel.differentiate` gives whole Jacobians; along thousands of samples most of what is in
them is zero. Here a derivative is a table of the columns that are not: states but heading, inputs
whose paths may hold an effect, coefficients, and free parameters of the equations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gsapp.dynamics.arithmetic import Value
from gsapp.dynamics.atmosphere import SEA_LEVEL_DENSITY
from gsapp.dynamics.equations import (
    INERTIA_NAMES,
    POLAR_STATES,
    PolarJacobian,
    PolarState,
    polar_jacobian,
    polar_rates,
)
from gsapp.dynamics.flight_model import MODEL_INPUTS, FlightModel, ModelEvaluation
from gsapp.dynamics.terms import (
    COEFFICIENTS,
    TARGETS,
    VARIABLES,
    Term,
    TermJacobian,
    position_targets,
)
from gsapp.quantities import FloatArray

CONTROLS = ("de", "da", "dr", "flap", "throttle")
"""Inputs whose paths may hold an effect."""
SparseGradient = dict[int, Value]
"""Derivatives that are not zero, by column."""

_VARIABLES = tuple(VARIABLES)
_HEADING = POLAR_STATES.index("psi")
_FORCES = frozenset(("CN", "CA", "CY", "CX", "CZ", "X", "Y", "Z"))
_MOMENTS = frozenset(("Cl", "Cm", "Cn", "L", "M", "N"))
_OFFSETS = frozenset(TARGETS) - _FORCES - _MOMENTS
_QBAR, _RHO = _VARIABLES.index("qbar"), _VARIABLES.index("rho")
_THROTTLE, _DIFFERENCE = _VARIABLES.index("throttle"), _VARIABLES.index("throttle_difference")
_FLOW_READS = ((1, 2, 6, 7), tuple(range(8)), (0, 1, 2, 3, 5, 6, 7))
"""States that enter V', alpha', beta' beside the forces."""
_PITCH = POLAR_STATES.index("q")


@dataclass(frozen=True, slots=True, kw_only=True)
class ColumnLayout:
    """Which column is what."""

    n_states: int
    """Without heading: the first columns; `CONTROLS`, `COEFFICIENTS`, the rotation of the air and
    `free` follow."""
    free: tuple[str, ...]  # Parameters of the equations.

    @property
    def controls(self) -> slice:
        return slice(self.n_states, self.n_states + len(CONTROLS))

    @property
    def coefficients(self) -> slice:
        first = self.n_states + len(CONTROLS)
        return slice(first, first + len(COEFFICIENTS))

    @property
    def rotation(self) -> slice:
        """Return the columns of p_g, q_g, r_g: rotation of the air."""
        first = self.coefficients.stop
        return slice(first, first + 3)

    @property
    def parameters(self) -> slice:
        first = self.rotation.stop
        return slice(first, first + len(self.free))

    def stack_columns(
        self, rows: Sequence[SparseGradient], columns: slice, count: int
    ) -> FloatArray:
        """Return some columns as an array, shape (n, n_rows, n_columns), in memory time last."""
        table = np.zeros((len(rows), columns.stop - columns.start, count))
        for row, slopes in enumerate(rows):
            for column, slope in slopes.items():
                if columns.start <= column < columns.stop:
                    table[row, column - columns.start] = slope
        return table.transpose(2, 0, 1)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class EquationJacobian:
    """The equations at a row of samples, with their derivatives."""

    layout: ColumnLayout
    totals: ModelEvaluation
    rates: FloatArray  # Shape (n_states, n). Of the states but heading.
    rate_gradients: list[SparseGradient]
    force_gradients: tuple[SparseGradient, SparseGradient, SparseGradient]  # Of X, Y, Z.
    mass_gradient: SparseGradient
    cg_gradients: tuple[SparseGradient, SparseGradient, SparseGradient]
    position_gradients: dict[str, tuple[SparseGradient, ...]]
    """Of how far instruments sit from where the aircraft file says."""


def add_scaled(out: SparseGradient, factor: Value, slopes: SparseGradient) -> None:
    """Add a multiple of derivatives to others, in place."""
    for column, slope in slopes.items():
        product = factor * slope
        out[column] = out[column] + product if column in out else product


def linear_combination(*parts: tuple[Value, SparseGradient]) -> SparseGradient:
    """Return a linear combination of derivatives."""
    out: SparseGradient = {}
    for factor, slopes in parts:
        add_scaled(out, factor, slopes)
    return out


def compute_jacobian(
    model: FlightModel,
    state: Sequence[Value],
    inputs: Sequence[Value],
    values: Sequence[float],
    free: tuple[str, ...],
) -> EquationJacobian:
    """Return rates and forces with their derivatives.

    `state`, `inputs`, `values`: as in `FlightModel.totals`; arrays of shape (n,).
    `free`: parameters of the equations by which to differentiate too.
    """
    return _Chain(model, state, inputs, values, free).found()


class _Chain:
    """The chain rule from variables to rates."""

    def __init__(
        self,
        model: FlightModel,
        state: Sequence[Value],
        inputs: Sequence[Value],
        values: Sequence[float],
        free: tuple[str, ...],
    ) -> None:
        self._model, self._state, self._values = model, state, values
        self._placed: list[tuple[Term, slice, slice]] = []
        place = len(POLAR_STATES)
        for term, parameters in model.terms:
            states = slice(place, place + len(term.states))
            place = states.stop
            self._placed.append((term, parameters, states))
        self._totals = model.evaluate(state, inputs, values)
        self._layout = ColumnLayout(n_states=len(model.state_names) - 1, free=free)
        self._sums: dict[str, SparseGradient] = {name: {} for name in TARGETS}
        first = self._layout.coefficients.start
        for offset, name in enumerate(COEFFICIENTS):
            self._sums[name][first + offset] = 1.0
        self._columns = {
            model.parameter_names.index(name): self._layout.parameters.start + offset
            for offset, name in enumerate(free)
        }
        self._inputs = {name: self._layout.controls.start + k for k, name in enumerate(CONTROLS)}
        V, rho = state[0], inputs[MODEL_INPUTS.index("rho")]
        variables = self._totals.variables
        reads: dict[str, SparseGradient] = {name: {k: 1.0} for k, name in enumerate(_VARIABLES[:6])}
        turned = range(self._layout.rotation.start, self._layout.rotation.stop)
        for rate, length, column in zip(
            "pqr", (model.span, model.chord, model.span), turned, strict=True
        ):
            hat, size = variables[_VARIABLES.index(f"{rate}_hat")], 0.5 * length / V
            reads[f"{rate}_hat"] = {POLAR_STATES.index(rate): size, 0: -hat / V, column: -size}
        reads |= {name: {column: 1.0} for name, column in self._inputs.items()}
        reads |= {"throttle_difference": {}, "rho": {}, "qbar": {0: rho * V}}
        self._reads = reads

    def _add(self, chosen: frozenset[str]) -> None:
        for term, parameters, states in self._placed:
            if term.target in chosen:
                self._add_term(term, parameters, states)

    def _add_term(self, term: Term, parameters: slice, states: slice) -> None:
        jacobian = self._jacobian(term, parameters, states)
        self._spread(
            self._sums[term.target],
            term,
            (parameters.start, states.start),
            (jacobian.reads, jacobian.states, jacobian.parameters),
        )

    def _jacobian(self, term: Term, parameters: slice, states: slice) -> TermJacobian:
        variables = self._totals.variables
        reads = tuple(variables[_VARIABLES.index(name)] for name in term.reads)
        return term.jacobian(reads, self._state[states], self._values[parameters])

    def _spread(
        self,
        out: SparseGradient,
        term: Term,
        starts: tuple[int, int],
        by: tuple[Sequence[Value], Sequence[Value], Sequence[Value]],
    ) -> None:
        """Add the derivatives of one term, through what it reads, its states and parameters."""
        by_reads, by_states, by_parameters = by
        for name, slope in zip(term.reads, by_reads, strict=True):
            if not _is_zero(slope):
                add_scaled(out, slope, self._reads[name])
        for offset, slope in enumerate(by_states, starts[1] - 1):
            add_scaled(out, slope, {offset: 1.0})
        for offset, slope in enumerate(by_parameters, starts[0]):
            if offset in self._columns:
                add_scaled(out, slope, {self._columns[offset]: 1.0})

    def _lever(self, setting: Value) -> tuple[Value, Value]:
        """Return the thrust of a lever at 1, and its derivative by V where the lever stands."""
        propulsion = self._model.aircraft.propulsion
        size = propulsion.max_thrust / SEA_LEVEL_DENSITY * self._totals.variables[_RHO]
        fade = 1.0 / propulsion.zero_thrust_speed
        return size * (1.0 - fade * self._state[0]), -size * fade * setting

    def found(self) -> EquationJacobian:
        """Return all of it."""
        model, totals, sums = self._model, self._totals, self._sums
        n_states = len(POLAR_STATES)
        loads, body, cg = totals.loads, totals.body, totals.cg
        area, span, chord = model.area, model.area * model.span, model.area * model.chord
        self._add(_OFFSETS)
        full, by_V = self._lever(totals.variables[_THROTTLE])
        thrust = linear_combination(
            (1.0, {0: by_V, self._inputs["throttle"]: full}), (1.0, sums["thrust"])
        )
        self._reads["thrust"] = thrust
        self._add(_FORCES)
        by_CN = linear_combination((1.0, sums["CN"]), (-1.0, sums["CZ"]))
        by_CA = linear_combination((1.0, sums["CA"]), (-1.0, sums["CX"]))
        dX = linear_combination(
            (1.0, thrust), (-1.0, self._times_qbar("CA", by_CA, area)), (1.0, sums["X"])
        )
        dY = linear_combination((1.0, self._times_qbar("CY", sums["CY"], area)), (1.0, sums["Y"]))
        dZ = linear_combination((-1.0, self._times_qbar("CN", by_CN, area)), (1.0, sums["Z"]))
        equations = polar_jacobian(PolarState(*self._state[:n_states]), loads, body)
        forces = (dX, dY, dZ)
        flow = [self._flow_row(equations, row, forces) for row in range(3)]
        self._read_flow_rates(flow)
        self._add(_MOMENTS)
        height, sideways = _engine_offsets(model.aircraft.propulsion.position)
        _, spread_by_V = self._lever(totals.variables[_DIFFERENCE])
        d_cg = (sums["cg.x"], sums["cg.y"], sums["cg.z"])
        dL = linear_combination((1.0, self._times_qbar("Cl", sums["Cl"], span)), (1.0, sums["L"]))
        dM = linear_combination(
            (1.0, self._times_qbar("Cm", sums["Cm"], chord)), (1.0, sums["M"]), (height, thrust)
        )
        dN = linear_combination(
            (1.0, self._times_qbar("Cn", sums["Cn"], span)),
            (1.0, sums["N"]),
            (sideways, {0: spread_by_V}),
        )
        if any(d_cg) or any(not _is_zero(one) for one in cg):
            (cx, cy, cz), (gx, gy, gz) = cg, d_cg
            for out, parts in (
                (dL, ((cz, dY), (loads.Y, gz), (-cy, dZ), (-loads.Z, gy))),
                (dM, ((cx, dZ), (loads.Z, gx), (-cz, dX), (-loads.X, gz))),
                (dN, ((cy, dX), (loads.X, gy), (-cx, dY), (-loads.Y, gx))),
            ):
                for factor, slopes in parts:
                    add_scaled(out, factor, slopes)
        rows = [*flow, *(self._spin_row(equations, row, (dL, dM, dN)) for row in (3, 4, 5))]
        rows += [
            {column: equations.states[:, row, column] for column in columns}
            for row, columns in ((6, (3, 4, 5, 6, 7)), (7, (4, 5, 6)))
        ]
        rows += self._own_rows()
        polar = polar_rates(PolarState(*self._state[:n_states]), loads, body)
        rates = np.array(np.broadcast_arrays(*polar[:_HEADING], *totals.term_rates))
        return EquationJacobian(
            layout=self._layout,
            totals=totals,
            rates=rates,
            rate_gradients=rows,
            force_gradients=forces,
            mass_gradient=sums["mass"],
            cg_gradients=d_cg,
            position_gradients={
                name: tuple(
                    linear_combination(*((1.0, sums[one]) for one in targets))
                    for targets in position_targets(name)
                )
                for name in model.displaced_instruments
            },
        )

    def _times_qbar(self, name: str, slopes: SparseGradient, size: float) -> SparseGradient:
        found = linear_combination((size * self._totals.variables[_QBAR], slopes))
        add_scaled(found, size * self._totals.coefficients[name], self._reads["qbar"])
        return found

    def _flow_row(
        self,
        equations: PolarJacobian,
        row: int,
        forces: tuple[SparseGradient, SparseGradient, SparseGradient],
    ) -> SparseGradient:
        out: SparseGradient = {
            column: equations.states[:, row, column] for column in _FLOW_READS[row]
        }
        for column, slopes in enumerate(forces):
            add_scaled(out, equations.loads[:, row, column], slopes)
        add_scaled(out, equations.body[:, row, 0], self._sums["mass"])
        return out

    def _spin_row(
        self,
        equations: PolarJacobian,
        row: int,
        moments: tuple[SparseGradient, SparseGradient, SparseGradient],
    ) -> SparseGradient:
        out: SparseGradient = {column: equations.states[:, row, column] for column in (3, 4, 5)}
        for column in (1,) if row == _PITCH else (0, 2):
            add_scaled(out, equations.loads[:, row, 3 + column], moments[column])
        for column, name in enumerate(INERTIA_NAMES[1:], 1):
            add_scaled(out, equations.body[:, row, column], self._sums[name])
        return out

    def _read_flow_rates(self, flow: list[SparseGradient]) -> None:
        """Make the rates of the flow angles ready, where a term reads them."""
        V, wanted = self._state[0], {name for term, _ in self._model.terms for name in term.reads}
        for row, name, length in (
            (1, "alpha_dot_hat", self._model.chord),
            (2, "beta_dot_hat", self._model.span),
        ):
            if name in wanted:
                value = self._totals.variables[_VARIABLES.index(name)]
                self._reads[name] = linear_combination(
                    (0.5 * length / V, flow[row]), (-value / V, {0: 1.0})
                )

    def _own_rows(self) -> list[SparseGradient]:
        """Return the derivatives of the rates of the terms' own states."""
        rows: list[SparseGradient] = []
        for term, parameters, states in self._placed:
            if not term.states:
                continue
            jacobian = self._jacobian(term, parameters, states)
            for by in zip(
                jacobian.rate_reads, jacobian.rate_states, jacobian.rate_parameters, strict=True
            ):
                out: SparseGradient = {}
                self._spread(out, term, (parameters.start, states.start), by)
                rows.append(out)
        return rows


def _is_zero(value: Value) -> bool:
    return isinstance(value, int | float) and value == 0.0


def _engine_offsets(positions: Sequence[tuple[float, float, float]]) -> tuple[float, float]:
    """Return the mean height of the engines below the CG, and their mean distance sideways, m."""
    count = max(len(positions), 1)
    return sum(z for _, _, z in positions) / count, sum(abs(y) for _, y, _ in positions) / count

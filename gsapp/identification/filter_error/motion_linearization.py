"""A flight model linearized along a motion: what every later step works with.

One Runge-Kutta step per sample gives the defect of the motion; the transition matrices are the
series of the exponential of the exact Jacobian, averaged over the step. Time comes first.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gsapp.dynamics.actuators import simulate_control_path
from gsapp.dynamics.equations import POLAR_STATES
from gsapp.dynamics.flight_model import MODEL_INPUTS, FlightModel
from gsapp.dynamics.sensors import OutputModel
from gsapp.dynamics.signal_terms import (
    SURFACE_CHANNELS,
    MemorylessTerm,
    PathTerms,
    invert_path,
    path_response,
)
from gsapp.dynamics.terms import VARIABLES
from gsapp.identification.filter_error.equation_jacobian import (
    CONTROLS,
    EquationJacobian,
    SparseGradient,
    compute_jacobian,
    linear_combination,
)
from gsapp.identification.filter_error.instrument_output import (
    instrument_output,
    lead_matrix,
    sensor_inputs,
)
from gsapp.identification.filter_error.settings import FILTER_ERROR
from gsapp.identification.maneuver import Maneuver
from gsapp.identification.motion import MeasuredMotion, measured_motion
from gsapp.quantities import BoolArray, FloatArray

INTEGRATED_STATES = ("V", "alpha", "beta", "p", "q", "r", "phi", "theta")
"""Polar states that are integrated; heading changes nothing."""
COMPARED_CHANNELS = ("V", "alpha", "beta", "p", "q", "r", "ax", "ay", "an", "phi", "theta")
"""Channels that are compared, where they were measured."""
_ALWAYS_FROM_RECORD = frozenset(("ax", "ay", "an"))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ManeuverRecord:
    """One maneuver, ready for linearization."""

    maneuver: Maneuver
    motion: MeasuredMotion
    dt: float  # s.
    channels: tuple[str, ...]
    measured: FloatArray  # Shape (n, n_channels). SI; zero where a sample does not count.
    valid: BoolArray  # Shape (n, n_channels).
    states: tuple[str, ...] = INTEGRATED_STATES
    """Polar states that are integrated; the others are as measured."""

    @property
    def id(self) -> str:
        return self.maneuver.id

    @property
    def flight(self) -> str:
        return self.maneuver.flight

    def __len__(self) -> int:
        return len(self.measured)


def create_maneuver_record(maneuver: Maneuver) -> ManeuverRecord:
    """Return a maneuver made ready.

    Raises `FlightError` if it holds too little to simulate anything.
    """
    motion = measured_motion(maneuver)
    columns: dict[str, FloatArray] = {}
    for name in COMPARED_CHANNELS:
        if name in _ALWAYS_FROM_RECORD or name in motion.measured:
            samples = maneuver.samples(name)
            if not np.isfinite(samples).any() and name == "V":
                # Airspeed that follows from pressures.
                samples = np.where(motion.interpolated.get("V", False), np.nan, motion.state("V"))
            if np.isfinite(samples).any():
                columns[name] = samples
    stacked = np.column_stack([*columns.values()])
    counted = np.isfinite(stacked)
    return ManeuverRecord(
        maneuver=maneuver,
        motion=motion,
        dt=maneuver.dt,
        channels=tuple(columns),
        measured=np.where(counted, stacked, 0.0),
        valid=counted,
    )


_VARIABLES = tuple(VARIABLES)


@dataclass(slots=True, kw_only=True, eq=False)
class NominalMotion:
    """The motion of one maneuver that a model is linearized along."""

    states: FloatArray  # Shape (n_states, n). `ManeuverRecord.states`, then the model's own.
    gust: FloatArray
    """Shape (n_gusts, n). `GustStates`: share of V (m/s), beta and alpha (rad) that is turbulence
    and, where the air rotates, its states; of another number of rows, it starts from zero."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Linearization:
    """A model near one motion."""

    record: ManeuverRecord
    paths: dict[int, PathTerms]  # Effects on the paths of channels, by the channel's place.
    states: FloatArray  # Shape (n_states, n).
    speed: float  # Mean airspeed, m/s.
    transition: FloatArray  # Shape (n - 1, n_states, n_states).
    next_states: FloatArray
    """Shape (n_states, n - 1). Where the model goes in one step from each sample."""
    sensor_inputs: FloatArray
    sensor_input_rates: FloatArray
    """Shape (n, n_channels). What the instruments are exposed to, and its time derivatives."""
    computed: FloatArray  # Shape (n, n_channels). What they make of it; without free biases.
    output_by_state: FloatArray
    """Shape (n, n_channels, n_states). What is late on their paths is left out."""
    output_by_coefficient: FloatArray
    rate_by_coefficient: FloatArray
    """Shape (n, ..., 6). Derivatives of channels and rates by CN, CA, CY, Cl, Cm, Cn."""
    output_by_control: FloatArray
    rate_by_control: FloatArray
    """Shape (n, ..., 5). By `CONTROLS`."""
    output_by_rotation: FloatArray
    rate_by_rotation: FloatArray
    """Shape (n, ..., 3). By rotation of the air, p_g, q_g, r_g."""
    variables: dict[str, FloatArray]  # Shape (n,). What terms may read.
    output_rates: FloatArray  # Shape (n, n_channels). Time derivatives of `computed`.
    bias_sensitivity: FloatArray
    """Shape (n, n_channels). What a zero error of 1 changes; see `bias_sensitivity`."""
    inputs: FloatArray  # Shape (8, n). After the model's control paths.
    free: tuple[str, ...]
    """Further parameters of the equations, with the derivatives of rates and channels by them:
    `rate_by_free`, `output_by_free`, shape (n, ..., n_free)."""
    rate_by_free: FloatArray
    output_by_free: FloatArray


def initial_motion(record: ManeuverRecord, model: FlightModel) -> NominalMotion:
    """Return the measured motion, with the model's own states at rest."""
    full = record.motion.states.T
    polar = full[[POLAR_STATES.index(name) for name in record.states]]
    own = model.steady_states(tuple(full), tuple(record.motion.inputs.T))
    rows = [polar, *(np.broadcast_to(np.asarray(one, float), (1, len(record))) for one in own)]
    return NominalMotion(states=np.vstack(rows), gust=np.zeros((3, len(record))))


def _all_states(record: ManeuverRecord, x: FloatArray) -> FloatArray:
    """Return all polar states, those that are not integrated as measured, and the model's own."""
    count = len(record.states)
    full = np.vstack((record.motion.states.T, x[count:]))
    full[[POLAR_STATES.index(name) for name in record.states]] = x[:count]
    return full


def linearize_along(
    record: ManeuverRecord,
    model: FlightModel,
    values: FloatArray,
    motion: NominalMotion,
    free: tuple[str, ...] = (),
    speed_zero: float = 0.0,
) -> Linearization:
    """Return the model with parameters `values` linearized along a motion.

    `free`: parameters of the equations to differentiate by.
    `speed_zero`: zero error of airspeed at `FILTER_ERROR.bias_reference_speed`, m/s: airspeed shows
    that much less of a change.
    """
    inputs = _surface_inputs(record, model)
    x, dt, parameters = motion.states, record.dt, tuple(values)
    state = _all_states(record, x)
    found = compute_jacobian(model, tuple(state), tuple(inputs), parameters, free)
    layout, count = found.layout, len(record)
    seen = sensor_inputs(model, record.channels, tuple(state), found)
    outputs = np.stack([np.broadcast_to(value, (count,)) for value, _ in seen], axis=-1)
    # What an instrument scales, it scales all through.
    rows = [slopes for _, slopes in seen]
    moved = np.gradient(inputs[[MODEL_INPUTS.index(name) for name in CONTROLS]], dt, axis=1)
    exposed_rates = _output_rates(rows, (*found.rates, *moved), count)
    output_rates = exposed_rates.copy()
    zeros = bias_sensitivity(record, state[0])
    for column, scale in _scales(record, model, outputs, speed_zero * zeros).items():
        rows[column] = linear_combination((scale, rows[column]))
        output_rates[:, column] *= scale
    chosen = _integrated_rows(record, layout.n_states)
    gradients = [found.rate_gradients[row] for row in chosen]

    def by_states(gradients: list[SparseGradient]) -> FloatArray:
        by_all = layout.stack_columns(gradients, slice(0, layout.n_states), count)
        return np.ascontiguousarray(
            by_all if len(chosen) == layout.n_states else by_all[..., chosen]
        )

    jacobian = by_states(gradients)
    step = 0.5 * dt * (jacobian[1:] + jacobian[:-1])
    square = step @ step
    transition = np.eye(len(chosen)) + step + 0.5 * square + (square @ step) / 6.0
    by_state = by_states(rows)
    computed, paths = outputs.copy(), _instrument_paths(record, model)
    for column, path in paths.items():
        computed[:, column] = instrument_output(
            path, outputs[:, column], exposed_rates[:, column], dt
        )
        ahead = lead_matrix(path, jacobian)
        if ahead is not None:
            by_state[:, column] = (by_state[:, column, None] @ ahead)[:, 0]
    return Linearization(
        record=record,
        paths=paths,
        states=x,
        speed=float(np.mean(state[0])),
        transition=transition,
        next_states=_next_states(model, record, state, inputs, found.rates, parameters),
        sensor_inputs=outputs,
        sensor_input_rates=exposed_rates,
        computed=computed,
        output_by_state=by_state,
        output_by_coefficient=layout.stack_columns(rows, layout.coefficients, count),
        rate_by_coefficient=layout.stack_columns(gradients, layout.coefficients, count),
        output_by_control=layout.stack_columns(rows, layout.controls, count),
        rate_by_control=layout.stack_columns(gradients, layout.controls, count),
        output_by_rotation=layout.stack_columns(rows, layout.rotation, count),
        rate_by_rotation=layout.stack_columns(gradients, layout.rotation, count),
        variables=_variables(record, model, found, state[0]),
        output_rates=output_rates,
        bias_sensitivity=zeros,
        inputs=inputs,
        free=free,
        rate_by_free=layout.stack_columns(gradients, layout.parameters, count),
        output_by_free=layout.stack_columns(rows, layout.parameters, count),
    )


def _integrated_rows(record: ManeuverRecord, n_states: int) -> list[int]:
    """Return the places of integrated states among all but heading."""
    own = range(len(INTEGRATED_STATES), n_states)
    return [*(INTEGRATED_STATES.index(name) for name in record.states), *own]


def outputs_along(record: ManeuverRecord, model: FlightModel, motion: NominalMotion) -> FloatArray:
    """Return the computed channels of a model with its own values along a motion, (n, n_channels).

    As simulators compute them, all samples at hand.
    """
    inputs = _surface_inputs(record, model)
    state = tuple(_all_states(record, motion.states))
    values = OutputModel(model, record.channels).values(state, tuple(inputs))
    outputs = np.stack([np.broadcast_to(one, (len(record),)) for one in values], axis=-1)
    for column, path in _instrument_paths(record, model).items():
        outputs[:, column] = path_response(path, outputs[:, column], record.dt).values
    return outputs


def bias_sensitivity(record: ManeuverRecord, V: FloatArray) -> FloatArray:
    """Return what a zero error of 1 changes in each channel, (n, n_channels), at airspeeds (n,).

    Each channel by 1, airspeed by what a pressure does that changes it by 1 at
    `FILTER_ERROR.bias_reference_speed`.
    """
    zeros = np.ones((len(record), len(record.channels)))
    if "V" in record.channels:
        zeros[:, record.channels.index("V")] = FILTER_ERROR.bias_reference_speed / np.maximum(
            V, FILTER_ERROR.min_speed
        )
    return zeros


def _next_states(
    model: FlightModel,
    record: ManeuverRecord,
    state: FloatArray,
    inputs: FloatArray,
    rates: FloatArray,
    values: tuple[float, ...],
) -> FloatArray:
    """Return where a Runge-Kutta step goes from each sample.

    Inputs and states that are not integrated go straight in between.
    """
    dt, chosen = record.dt, _integrated_rows(record, len(rates))
    places = [row if row < len(INTEGRATED_STATES) else row + 1 for row in chosen]
    middle, given = 0.5 * (state[:, 1:] + state[:, :-1]), 0.5 * (inputs[:, 1:] + inputs[:, :-1])

    def at(moved: FloatArray, others: FloatArray, given: FloatArray) -> FloatArray:
        full = others.copy()
        full[places] = moved
        found = model.rates(tuple(full), tuple(given), values)
        return np.array(np.broadcast_arrays(*found))[places]

    start, k1 = state[places, :-1], rates[chosen, :-1]
    k2 = at(start + 0.5 * dt * k1, middle, given)
    k3 = at(start + 0.5 * dt * k2, middle, given)
    k4 = at(start + dt * k3, state[:, 1:], inputs[:, 1:])
    stepped: FloatArray = start + dt / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)
    return stepped


def _output_rates(
    rows: list[SparseGradient], rates: tuple[FloatArray, ...], count: int
) -> FloatArray:
    """Return the time derivatives of channels, for rates of states and controls."""
    table = np.zeros((len(rows), count))
    for row, slopes in enumerate(rows):
        for column, slope in slopes.items():
            if column < len(rates):
                table[row] += slope * rates[column]
    return table.T


def _variables(
    record: ManeuverRecord, model: FlightModel, found: EquationJacobian, V: FloatArray
) -> dict[str, FloatArray]:
    count = (len(record),)
    table = {
        name: np.array(np.broadcast_to(np.asarray(one, dtype=float), count))
        for name, one in zip(_VARIABLES, found.totals.variables, strict=True)
    }
    table["alpha_dot_hat"] = 0.5 * found.rates[1] * model.chord / V
    table["beta_dot_hat"] = 0.5 * found.rates[2] * model.span / V
    return table


def _surface_inputs(record: ManeuverRecord, model: FlightModel) -> FloatArray:
    """Return the inputs after the model's control paths, (8, n)."""
    inputs = record.motion.inputs.T.copy()
    for channel, path in model.sensor_terms.items():
        if channel in CONTROLS:
            row = MODEL_INPUTS.index(channel)
            inputs[row] = invert_path(path, inputs[row], record.dt).values
    for surface, path in model.control_terms.items():
        row = MODEL_INPUTS.index(SURFACE_CHANNELS[surface])
        inputs[row] = simulate_control_path(path, inputs[row], record.dt).values
    return inputs


def _instrument_paths(record: ManeuverRecord, model: FlightModel) -> dict[int, PathTerms]:
    """Return the model's effects on the paths of channels, by the channel's place."""
    return {
        record.channels.index(name): path
        for name, path in model.sensor_terms.items()
        if name in record.channels
    }


def _scales(
    record: ManeuverRecord, model: FlightModel, outputs: FloatArray, zeros: FloatArray
) -> dict[int, FloatArray]:
    """Return by how much instruments without memory multiply changes, by channel's place."""
    scales: dict[int, FloatArray] = {}
    if "V" in record.channels:
        column = record.channels.index("V")
        scales[column] = 1.0 - zeros[:, column] / np.maximum(
            outputs[:, column], FILTER_ERROR.min_speed
        )
    for column, path in _instrument_paths(record, model).items():
        for term, values in path:
            if isinstance(term, MemorylessTerm):
                slope = term.jacobian((outputs[:, column],), (), values).reads[0]
                scales[column] = scales.get(column, np.ones(len(outputs))) * slope
    return scales

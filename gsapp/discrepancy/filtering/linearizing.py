"""A flight model linearized along a motion: what every later step works with.

One Runge-Kutta step per sample gives the defect of the motion; the transition matrices are the
series of the exponential of the exact Jacobian, averaged over the step. Time comes first.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gsapp.discrepancy.filtering.lateness import looking_ahead, shown
from gsapp.discrepancy.filtering.outputs import exposures
from gsapp.discrepancy.filtering.record import STATES, Record
from gsapp.discrepancy.filtering.slopes import (
    CONTROLS,
    Differences,
    Slopes,
    combined,
    differences,
)
from gsapp.dynamics.flight_model import INPUTS, FlightModel
from gsapp.dynamics.recorded_controls import acted
from gsapp.dynamics.sensors import OutputModel
from gsapp.dynamics.signals import SURFACES, Path, Straight, respond, undo
from gsapp.dynamics.terms import VARIABLES
from gsapp.quantities import FloatArray

__all__ = [
    "CONTROLS",
    "Linearization",
    "Motion",
    "first_motion",
    "linearize",
    "shown_along",
    "zeros_along",
]
_VARIABLES = tuple(VARIABLES)
ZERO_SPEED = 30.0
"""Airspeed at which its zero error is told, m/s: a pressure's zero is less speed when fast."""
_SLOW = 5.0
"""Airspeed (m/s) below which no pressure is believed."""


@dataclass(slots=True, kw_only=True, eq=False)
class Motion:
    """The motion of one maneuver that a model is linearized along.

    Attributes
    ----------
    states : ndarray, shape (n_states, n)
        `STATES`, then the model's own.
    gust : ndarray, shape (3, n)
        Share of V (m/s), beta and alpha (rad) that is turbulence.
    """

    states: FloatArray
    gust: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Linearization:
    """A model near one motion.

    Attributes
    ----------
    record : Record
    paths : dict of int to Path
        Effects on the paths of channels, by the channel's place.
    states : ndarray, shape (n_states, n)
    transition : ndarray, shape (n - 1, n_states, n_states)
    stepped : ndarray, shape (n_states, n - 1)
        Where the model goes in one step from each sample.
    exposed, exposed_rates : ndarray, shape (n, n_channels)
        What the instruments are exposed to, and its time derivatives.
    computed : ndarray, shape (n, n_channels)
        What they make of it; without free biases.
    by_state : ndarray, shape (n, n_channels, n_states)
        What is late on their paths is left out.
    output_by_coefficient, rate_by_coefficient : ndarray, shape (n, ..., 6)
        Derivatives of channels and rates by CN, CA, CY, Cl, Cm, Cn.
    output_by_control, rate_by_control : ndarray, shape (n, ..., 5)
        By `CONTROLS`.
    variables : dict of str to ndarray, shape (n,)
        What terms may read.
    output_rates : ndarray, shape (n, n_channels)
        Time derivatives of `computed`.
    zeros : ndarray, shape (n, n_channels)
        What a zero error of 1 changes; see `zeros_along`.
    inputs : ndarray, shape (8, n)
        After the model's control paths.
    free : tuple of str
        Further parameters of the equations, with the derivatives of rates and channels by them:
        `rate_by_free`, `output_by_free`, shape (n, ..., n_free).
    """

    record: Record
    paths: dict[int, Path]
    states: FloatArray
    transition: FloatArray
    stepped: FloatArray
    exposed: FloatArray
    exposed_rates: FloatArray
    computed: FloatArray
    by_state: FloatArray
    output_by_coefficient: FloatArray
    rate_by_coefficient: FloatArray
    output_by_control: FloatArray
    rate_by_control: FloatArray
    variables: dict[str, FloatArray]
    output_rates: FloatArray
    zeros: FloatArray
    inputs: FloatArray
    free: tuple[str, ...]
    rate_by_free: FloatArray
    output_by_free: FloatArray


def first_motion(record: Record, model: FlightModel) -> Motion:
    """Return the measured motion, with the model's own states at rest."""
    polar = record.motion.states.T[: len(STATES)]
    full = record.motion.states.T
    own = model.resting_states(tuple(full), tuple(record.motion.inputs.T))
    rows = [polar, *(np.broadcast_to(np.asarray(one, float), (1, len(record))) for one in own)]
    return Motion(states=np.vstack(rows), gust=np.zeros((3, len(record))))


def linearize(
    record: Record,
    model: FlightModel,
    values: FloatArray,
    motion: Motion,
    free: tuple[str, ...] = (),
    speed_zero: float = 0.0,
) -> Linearization:
    """Return the model with parameters `values` linearized along a motion.

    Parameters
    ----------
    record : Record
    model : FlightModel
    values : ndarray
    motion : Motion
    free : tuple of str
        Parameters of the equations to differentiate by.
    speed_zero : float
        Zero error of airspeed at `ZERO_SPEED`, m/s: airspeed shows that much less of a change.
    """
    inputs = _driven(record, model)
    heading = record.motion.states.T[len(STATES)]
    x, dt, parameters = motion.states, record.dt, tuple(values)
    state = (*x[:8], heading, *x[8:])
    found = differences(model, state, tuple(inputs), parameters, free)
    layout, count = found.layout, len(record)
    seen = exposures(model, record.channels, state, found)
    outputs = np.stack([np.broadcast_to(value, (count,)) for value, _ in seen], axis=-1)
    # What an instrument scales, it scales all through.
    rows = [slopes for _, slopes in seen]
    moved = np.gradient(inputs[[INPUTS.index(name) for name in CONTROLS]], dt, axis=1)
    exposed_rates = _output_rates(rows, (*found.rates, *moved), count)
    output_rates = exposed_rates.copy()
    zeros = zeros_along(record, x[0])
    for column, scale in _scales(record, model, outputs, speed_zero * zeros).items():
        rows[column] = combined((scale, rows[column]))
        output_rates[:, column] *= scale
    states = slice(0, layout.n_states)
    jacobian = np.ascontiguousarray(layout.stacked(found.rate_slopes, states, count))
    step = 0.5 * dt * (jacobian[1:] + jacobian[:-1])
    square = step @ step
    transition = np.eye(layout.n_states) + step + 0.5 * square + (square @ step) / 6.0
    by_state = np.ascontiguousarray(layout.stacked(rows, states, count))
    computed, paths = outputs.copy(), _instrument_paths(record, model)
    for column, path in paths.items():
        computed[:, column] = shown(path, outputs[:, column], exposed_rates[:, column], dt)
        ahead = looking_ahead(path, jacobian)
        if ahead is not None:
            by_state[:, column] = (by_state[:, column, None] @ ahead)[:, 0]
    return Linearization(
        record=record,
        paths=paths,
        states=x,
        transition=transition,
        stepped=_stepped(model, x, heading, inputs, found.rates, dt, parameters),
        exposed=outputs,
        exposed_rates=exposed_rates,
        computed=computed,
        by_state=by_state,
        output_by_coefficient=layout.stacked(rows, layout.coefficients, count),
        rate_by_coefficient=layout.stacked(found.rate_slopes, layout.coefficients, count),
        output_by_control=layout.stacked(rows, layout.controls, count),
        rate_by_control=layout.stacked(found.rate_slopes, layout.controls, count),
        variables=_variables(record, model, found, x[0]),
        output_rates=output_rates,
        zeros=zeros,
        inputs=inputs,
        free=free,
        rate_by_free=layout.stacked(found.rate_slopes, layout.parameters, count),
        output_by_free=layout.stacked(rows, layout.parameters, count),
    )


def shown_along(record: Record, model: FlightModel, motion: Motion) -> FloatArray:
    """Return the computed channels of a model with its own values along a motion, (n, n_channels).

    As simulators compute them, all samples at hand.
    """
    inputs = _driven(record, model)
    x, heading = motion.states, record.motion.states.T[len(STATES)]
    values = OutputModel(model, record.channels).values((*x[:8], heading, *x[8:]), tuple(inputs))
    outputs = np.stack([np.broadcast_to(one, (len(record),)) for one in values], axis=-1)
    for column, path in _instrument_paths(record, model).items():
        outputs[:, column] = respond(path, outputs[:, column], record.dt).values
    return outputs


def zeros_along(record: Record, V: FloatArray) -> FloatArray:
    """Return what a zero error of 1 changes in each channel, (n, n_channels), at airspeeds (n,).

    Each channel by 1, airspeed by what a pressure does that changes it by 1 at `ZERO_SPEED`.
    """
    zeros = np.ones((len(record), len(record.channels)))
    if "V" in record.channels:
        zeros[:, record.channels.index("V")] = ZERO_SPEED / np.maximum(V, _SLOW)
    return zeros


def _stepped(
    model: FlightModel,
    x: FloatArray,
    heading: FloatArray,
    inputs: FloatArray,
    rates: FloatArray,
    dt: float,
    values: tuple[float, ...],
) -> FloatArray:
    """Return where a Runge-Kutta step goes from each sample; inputs go straight in between."""

    def at(moved: FloatArray, psi: FloatArray, given: FloatArray) -> FloatArray:
        found = model.rates((*moved[:8], psi, *moved[8:]), tuple(given), values)
        return np.array(np.broadcast_arrays(*found[:8], *found[9:]))

    start, k1 = x[:, :-1], rates[:, :-1]
    psi, given = 0.5 * (heading[1:] + heading[:-1]), 0.5 * (inputs[:, 1:] + inputs[:, :-1])
    k2 = at(start + 0.5 * dt * k1, psi, given)
    k3 = at(start + 0.5 * dt * k2, psi, given)
    k4 = at(start + dt * k3, heading[1:], inputs[:, 1:])
    stepped: FloatArray = start + dt / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)
    return stepped


def _output_rates(rows: list[Slopes], rates: tuple[FloatArray, ...], count: int) -> FloatArray:
    """Return the time derivatives of channels, for rates of states and controls."""
    table = np.zeros((len(rows), count))
    for row, slopes in enumerate(rows):
        for column, slope in slopes.items():
            if column < len(rates):
                table[row] += slope * rates[column]
    return table.T


def _variables(
    record: Record, model: FlightModel, found: Differences, V: FloatArray
) -> dict[str, FloatArray]:
    count = (len(record),)
    table = {
        name: np.array(np.broadcast_to(np.asarray(one, dtype=float), count))
        for name, one in zip(_VARIABLES, found.totals.variables, strict=True)
    }
    table["alpha_dot_hat"] = 0.5 * found.rates[1] * model.chord / V
    table["beta_dot_hat"] = 0.5 * found.rates[2] * model.span / V
    return table


def _driven(record: Record, model: FlightModel) -> FloatArray:
    """Return the inputs after the model's control paths, (8, n)."""
    inputs = record.motion.inputs.T.copy()
    for channel, path in model.sensor_terms.items():
        if channel in CONTROLS:
            row = INPUTS.index(channel)
            inputs[row] = undo(path, inputs[row], record.dt).values
    for surface, path in model.control_terms.items():
        row = INPUTS.index(SURFACES[surface])
        inputs[row] = acted(path, inputs[row], record.dt).values
    return inputs


def _instrument_paths(record: Record, model: FlightModel) -> dict[int, Path]:
    """Return the model's effects on the paths of channels, by the channel's place."""
    return {
        record.channels.index(name): path
        for name, path in model.sensor_terms.items()
        if name in record.channels
    }


def _scales(
    record: Record, model: FlightModel, outputs: FloatArray, zeros: FloatArray
) -> dict[int, FloatArray]:
    """Return by how much instruments without memory multiply changes, by channel's place."""
    scales: dict[int, FloatArray] = {}
    if "V" in record.channels:
        column = record.channels.index("V")
        scales[column] = 1.0 - zeros[:, column] / np.maximum(outputs[:, column], _SLOW)
    for column, path in _instrument_paths(record, model).items():
        for term, values in path:
            if isinstance(term, Straight):
                slope = term.jacobian((outputs[:, column],), (), values).reads[0]
                scales[column] = scales.get(column, np.ones(len(outputs))) * slope
    return scales

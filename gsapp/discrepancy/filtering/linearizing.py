"""A flight model linearized along a motion: what every later step works with.

One Runge-Kutta step per sample gives the defect of the motion; the transition matrices are the
series of the exponential of the exact Jacobian, averaged over the step. Time comes first.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gsapp.discrepancy.filtering.record import STATES, Record
from gsapp.dynamics.flight_model import INPUTS, FlightModel
from gsapp.dynamics.sensors import OutputModel
from gsapp.dynamics.signals import SURFACES, SignalTerm, Straight, respond, undo
from gsapp.dynamics.terms import COEFFICIENTS, VARIABLES
from gsapp.identification.maximum_likelihood.engine import Engine, drives_of
from gsapp.identification.maximum_likelihood.kernels import GeneralKernel
from gsapp.quantities import FloatArray

CONTROLS = ("de", "da", "dr", "flap", "throttle")
"""Inputs whose paths may hold an effect."""
_VARIABLES = tuple(VARIABLES)
_LEVELS = tuple(f"{name}_0" for name in COEFFICIENTS)


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
    states : ndarray, shape (n_states, n)
    transition : ndarray, shape (n - 1, n_states, n_states)
    stepped : ndarray, shape (n_states, n - 1)
        Where the model goes in one step from each sample.
    exposed, computed : ndarray, shape (n, n_channels)
        Before and after the instruments' effects; without free biases.
    by_state : ndarray, shape (n, n_channels, n_states)
    output_by_coefficient, rate_by_coefficient : ndarray, shape (n, ..., 6)
        Derivatives of channels and rates by CN, CA, CY, Cl, Cm, Cn.
    output_by_control, rate_by_control : ndarray, shape (n, ..., 5)
        By `CONTROLS`.
    variables : dict of str to ndarray, shape (n,)
        What terms may read.
    output_rates : ndarray, shape (n, n_channels)
        Time derivatives of `computed`.
    inputs : ndarray, shape (8, n)
        After the model's control paths.
    free : tuple of str
        Further parameters of the equations, with the derivatives of rates and channels by them:
        `rate_by_free`, `output_by_free`, shape (n, ..., n_free).
    """

    record: Record
    states: FloatArray
    transition: FloatArray
    stepped: FloatArray
    exposed: FloatArray
    computed: FloatArray
    by_state: FloatArray
    output_by_coefficient: FloatArray
    rate_by_coefficient: FloatArray
    output_by_control: FloatArray
    rate_by_control: FloatArray
    variables: dict[str, FloatArray]
    output_rates: FloatArray
    inputs: FloatArray
    free: tuple[str, ...]
    rate_by_free: FloatArray
    output_by_free: FloatArray

    def shown_before(self, channel: str) -> FloatArray:
        """Return what an instrument is exposed to, shape (n,)."""
        return self.exposed[:, self.record.channels.index(channel)]


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
) -> Linearization:
    """Return the model with parameters `values` linearized along a motion."""
    kernel = GeneralKernel(model, STATES, record.channels, _LEVELS)
    engine = Engine(kernel, "rk4")
    inputs = _driven(record, model)
    measured = record.motion.states.T
    drives = drives_of(kernel, measured, inputs, None, values)
    x = motion.states
    state = [*x[:8], measured[8], *x[8:]]
    outputs, slopes, found = OutputModel(model, record.channels).jacobian(
        state, tuple(inputs), tuple(values), free=(*_LEVELS, *free)
    )
    n_all = len(model.state_names)
    active = [*range(8), *range(9, n_all)]
    controls = [n_all + INPUTS.index(name) for name in CONTROLS]
    first = n_all + len(INPUTS)
    levels, others = slice(first, first + len(_LEVELS)), slice(first + len(_LEVELS), None)
    rates = found.rates[:, active]
    jacobian = np.ascontiguousarray(rates[:, :, active])
    step = 0.5 * record.dt * (jacobian[1:] + jacobian[:-1])
    square = step @ step
    transition = np.eye(len(active)) + step + 0.5 * square + (square @ step) / 6.0
    own_rates = np.array(np.broadcast_arrays(*kernel.rates(drives.samples, x, values)))
    by_state = np.ascontiguousarray(slopes[:, :, active])
    by_control = np.ascontiguousarray(slopes[:, :, controls])
    moved = inputs[[INPUTS.index(name) for name in CONTROLS]]
    output_rates = np.einsum("nyi,in->ny", by_state, own_rates) + np.einsum(
        "nyj,jn->ny", by_control, np.gradient(moved, record.dt, axis=1)
    )
    # What an instrument scales, it scales all through.
    scale = _scales(record, model, outputs)
    output_rates *= scale
    by_state *= scale[:, :, None]
    by_control *= scale[:, :, None]
    return Linearization(
        record=record,
        states=x,
        transition=transition,
        stepped=engine.step(drives, x[:, :-1], record.dt, values),
        exposed=outputs,
        computed=_shown(record, model, outputs),
        by_state=by_state,
        output_by_coefficient=slopes[:, :, levels] * scale[:, :, None],
        rate_by_coefficient=np.ascontiguousarray(rates[:, :, levels]),
        output_by_control=by_control,
        rate_by_control=np.ascontiguousarray(rates[:, :, controls]),
        variables=_variables(record, model, found.totals.variables, own_rates, x[0]),
        output_rates=output_rates,
        inputs=inputs,
        free=free,
        rate_by_free=np.ascontiguousarray(rates[:, :, others]),
        output_by_free=slopes[:, :, others] * scale[:, :, None],
    )


def _variables(
    record: Record,
    model: FlightModel,
    found: list[object],
    rates: FloatArray,
    V: FloatArray,
) -> dict[str, FloatArray]:
    count = (len(record),)
    table = {
        name: np.array(np.broadcast_to(np.asarray(one, dtype=float), count))
        for name, one in zip(_VARIABLES, found, strict=True)
    }
    table["alpha_dot_hat"] = 0.5 * rates[1] * model.chord / V
    table["beta_dot_hat"] = 0.5 * rates[2] * model.span / V
    return table


def _signal_path(
    terms: tuple[tuple[object, tuple[float, ...]], ...],
) -> tuple[tuple[SignalTerm, tuple[float, ...]], ...]:
    return tuple((term, values) for term, values in terms if isinstance(term, SignalTerm))


def _driven(record: Record, model: FlightModel) -> FloatArray:
    """Return the inputs after the model's control paths, (8, n)."""
    inputs = record.motion.inputs.T.copy()
    for channel, terms in model.sensor_terms.items():
        if channel in CONTROLS:
            row = INPUTS.index(channel)
            inputs[row] = undo(_signal_path(terms), inputs[row], record.dt).values
    for surface, terms in model.control_terms.items():
        row = INPUTS.index(SURFACES[surface])
        inputs[row] = respond(_signal_path(terms), inputs[row], record.dt).values
    return inputs


def _shown(record: Record, model: FlightModel, outputs: FloatArray) -> FloatArray:
    """Return computed channels after the model's instrument effects, (n, n_channels)."""
    shown = np.array(outputs)
    for name, terms in model.sensor_terms.items():
        if name in record.channels:
            column = record.channels.index(name)
            shown[:, column] = respond(_signal_path(terms), shown[:, column], record.dt).values
    return shown


def _scales(record: Record, model: FlightModel, outputs: FloatArray) -> FloatArray:
    """Return by how much the instruments without memory multiply changes, (n, n_channels)."""
    scale = np.ones(outputs.shape)
    for name, terms in model.sensor_terms.items():
        if name in record.channels:
            column = record.channels.index(name)
            for term, values in _signal_path(terms):
                if isinstance(term, Straight):
                    slope = term.jacobian((outputs[:, column],), (), values).reads[0]
                    scale[:, column] = scale[:, column] * slope
    return scale

"""Effects on the path of a signal: from command to surface, from quantity to record.

A signal term reads one signal and *replaces* it by its value; terms of one path follow one
another. They exist in two forms that agree for signals slow against the sample time:

- *continuous*, as every term: states with rates, so that a path can be integrated together with
  the aircraft. Delay is a second-order Pade fraction there, and edges (backlash, rate limit) are
  rounded by `SIMULATION.edge_rounding`;
- *sampled*, exact for signals that are straight lines between samples: `begin` and `step` for a
  running simulation, `path_response` for whole histories with derivatives by the parameters and,
  for sensitivities of the signal itself, `PathResponse.tangent`.

What was measured on a surface is an *input* of the equations: there, a path from quantity to record
is walked backward, `SignalTerm.undo` and `invert_path`.

Two effects of instruments concern several channels at once. A *box* (`INSTRUMENT_BOXES`) is late
as a whole: its term stands on the path of every channel of the box, with one parameter for all.
Two axes that are *swapped* (`SwappedChannels`) are no signal term: they change places before any
path begins (`gsapp.dynamics.flight_model.FlightModel.exchanged`). The third, an instrument that
sits elsewhere than the aircraft file says, is an offset in the equations (targets
``place.<instrument>.<axis>``) that `gsapp.dynamics.sensors.OutputModel` takes into account.

The effects made of these terms are in `gsapp.dynamics.effects`.
"""

# ruff: noqa: ARG002 - overridden methods, which use their arguments or not

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Protocol

import numpy as np

from gsapp.dynamics.arithmetic import Value, clip, where
from gsapp.dynamics.settings import SIMULATION
from gsapp.dynamics.terms import Term, TermJacobian, Values
from gsapp.foundation import FlightError
from gsapp.quantities import SURFACE_NAMES, FloatArray

SURFACE_CHANNELS = {**{name: channel for channel, name in SURFACE_NAMES.items()}, "flap": "flap"}
"""Name in effect ids: channel."""
MOTION_CHANNELS = ("alpha", "beta", "V", "p", "q", "r", "ax", "ay", "an", "phi", "theta", "qbar")
"""Measured channels that the equations predict."""
INPUT_CHANNELS = tuple(SURFACE_CHANNELS.values())
"""Measured channels that drive the equations."""
SENSOR_CHANNELS = (*MOTION_CHANNELS, *INPUT_CHANNELS)
INSTRUMENT_BOXES: dict[str, tuple[str, ...]] = {
    "airdata": ("alpha", "beta", "V", "qbar"),
    "inertial": ("p", "q", "r", "ax", "ay", "an"),
    "attitude": ("phi", "theta"),
    "surfaces": INPUT_CHANNELS,
}
"""Instruments that share a clock, and so are late together: either all inputs or none."""
SCALED_GROUPS: dict[str, tuple[str, ...]] = {"gyros": ("p", "q", "r"), "attitude": ("phi", "theta")}
"""Instruments of one kind, which one factor of units or calibration scales together."""
SWAPPABLE_PAIRS = (
    ("p", "q"), ("p", "r"), ("q", "r"), ("ax", "ay"), ("ax", "an"), ("ay", "an"),
    ("alpha", "beta"),
)  # fmt: skip
"""Channels of one kind, whose plugs fit each other's sockets."""


Sizes = tuple[float, ...]
"""Parameters of a term, in its order."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PathResponse:
    """A signal after its path."""

    values: FloatArray  # Shape (n,).
    parameters: FloatArray
    """Shape (n, n_parameters). Derivatives of the values by the term's parameters."""
    tangent: Callable[[FloatArray], FloatArray]
    """Takes derivatives of the signal going in, shape (n, m), and returns those of the signal
    coming out, shape (n, m)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SignalTerm(Term):
    """Base of the terms on a signal's path."""

    def initial_memory(self, signal: float, dt: float, parameters: Sizes) -> list[float]:
        """Return the memory of a path on which the signal was constant so far."""
        return [signal]

    @abstractmethod
    def step(self, memory: list[float], signal: float, dt: float, parameters: Sizes) -> float:
        """Take the signal's next sample, update the memory, return what comes out."""

    @abstractmethod
    def respond(self, signal: FloatArray, dt: float, parameters: Sizes) -> PathResponse:
        """Return the whole history after the path, shape (n,), sampled every `dt` s."""

    def invert(self, signal: FloatArray, dt: float, parameters: Sizes) -> PathResponse:
        """Return the history, shape (n,), that came out as `signal`.

        Where the path lost it (clipping, play), the signal stands for it.
        """
        return _identity_response(signal, len(parameters))


def _identity_response(signal: FloatArray, n_parameters: int) -> PathResponse:
    return PathResponse(
        values=signal,
        parameters=np.zeros((signal.size, n_parameters)),
        tangent=lambda change: change,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class SwappedChannels(Term):
    """Two channels that carry each other's signal."""

    pair: tuple[str, str]

    def value(self, reads: Values, states: Values, parameters: Values) -> Value:
        return reads[1]

    def jacobian(self, reads: Values, states: Values, parameters: Values) -> TermJacobian:
        return TermJacobian(reads=(0.0, 1.0))


@dataclass(frozen=True, slots=True, kw_only=True)
class MemorylessTerm(SignalTerm):
    """Base of paths without memory."""

    def step(self, memory: list[float], signal: float, dt: float, parameters: Sizes) -> float:
        return float(self.value((signal,), (), parameters))

    def respond(self, signal: FloatArray, dt: float, parameters: Sizes) -> PathResponse:
        jacobian = self.jacobian((signal,), (), parameters)
        slope = np.broadcast_to(jacobian.reads[0], signal.shape)
        columns = [np.broadcast_to(column, signal.shape) for column in jacobian.parameters]
        by_parameters = np.stack(columns, axis=-1) if columns else np.empty((signal.size, 0))
        return PathResponse(
            values=np.asarray(self.value((signal,), (), parameters)),
            parameters=by_parameters,
            tangent=lambda change: slope[:, None] * change,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class ScaleFactor(MemorylessTerm):
    """Signal times a factor."""

    def value(self, reads: Values, states: Values, parameters: Values) -> Value:
        return parameters[0] * reads[0]

    def jacobian(self, reads: Values, states: Values, parameters: Values) -> TermJacobian:
        return TermJacobian(reads=(parameters[0],), parameters=(reads[0],))

    def invert(self, signal: FloatArray, dt: float, parameters: Sizes) -> PathResponse:
        (factor,) = parameters
        if factor == 0.0:
            return _identity_response(signal, 1)
        values = signal / factor
        return PathResponse(
            values=values,
            parameters=(-values / factor)[:, None],
            tangent=lambda change: change / factor,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class SignReversal(MemorylessTerm):
    """Signal with the wrong sign."""

    def value(self, reads: Values, states: Values, parameters: Values) -> Value:
        return -reads[0]

    def jacobian(self, reads: Values, states: Values, parameters: Values) -> TermJacobian:
        return TermJacobian(reads=(-1.0,))

    def invert(self, signal: FloatArray, dt: float, parameters: Sizes) -> PathResponse:
        return PathResponse(
            values=-signal,
            parameters=np.empty((signal.size, 0)),
            tangent=lambda change: -change,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Bias(MemorylessTerm):
    """Signal plus a constant."""

    def value(self, reads: Values, states: Values, parameters: Values) -> Value:
        return reads[0] + parameters[0]

    def jacobian(self, reads: Values, states: Values, parameters: Values) -> TermJacobian:
        return TermJacobian(reads=(1.0,), parameters=(1.0,))

    def invert(self, signal: FloatArray, dt: float, parameters: Sizes) -> PathResponse:
        return PathResponse(
            values=signal - parameters[0],
            parameters=np.full((signal.size, 1), -1.0),
            tangent=lambda change: change,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Saturation(MemorylessTerm):
    """Signal that stops at plus and minus a limit."""

    def value(self, reads: Values, states: Values, parameters: Values) -> Value:
        return clip(reads[0], -parameters[0], parameters[0])

    def jacobian(self, reads: Values, states: Values, parameters: Values) -> TermJacobian:
        signal, limit = reads[0], parameters[0]
        above = where(signal > limit, 1.0, 0.0)
        below = where(signal < -limit, 1.0, 0.0)
        return TermJacobian(reads=(1.0 - above - below,), parameters=(above - below,))


@dataclass(frozen=True, slots=True, kw_only=True)
class FollowingTerm(SignalTerm):
    """Base of paths whose only state is what comes out, and follows the signal."""

    def value(self, reads: Values, states: Values, parameters: Values) -> Value:
        return states[0]

    def steady_state(self, reads: Values, parameters: Values) -> tuple[Value, ...]:
        return (reads[0],)


@dataclass(frozen=True, slots=True, kw_only=True)
class Lag(FollowingTerm):
    """First-order lag."""

    def rates(self, reads: Values, states: Values, parameters: Values) -> tuple[Value, ...]:
        return ((reads[0] - states[0]) / _limit_time_constant(parameters[0]),)

    def jacobian(self, reads: Values, states: Values, parameters: Values) -> TermJacobian:
        tau = _limit_time_constant(parameters[0])
        by_tau = where(
            parameters[0] > SIMULATION.min_time_constant, (states[0] - reads[0]) / (tau * tau), 0.0
        )
        return TermJacobian(
            reads=(0.0,),
            states=(1.0,),
            parameters=(0.0,),
            rate_reads=((1.0 / tau,),),
            rate_states=((-1.0 / tau,),),
            rate_parameters=((by_tau,),),
        )

    def initial_memory(self, signal: float, dt: float, parameters: Sizes) -> list[float]:
        return [signal, signal]

    def step(self, memory: list[float], signal: float, dt: float, parameters: Sizes) -> float:
        decay, old, new = lag_weights(parameters[0], dt)
        out = decay * memory[0] + old * memory[1] + new * signal
        memory[0], memory[1] = out, signal
        return out

    def respond(self, signal: FloatArray, dt: float, parameters: Sizes) -> PathResponse:
        tau = parameters[0]
        decay, _, _ = lag_weights(tau, dt)

        def run(history: FloatArray) -> FloatArray:
            return apply_lag(history, tau, dt)

        values = run(signal)
        if tau <= 0.0:
            by_tau = -np.gradient(signal, dt) if signal.size > 1 else np.zeros_like(signal)
        else:
            from scipy.signal import lfilter  # a third of a second

            ratio = dt / tau
            mean = -math.expm1(-ratio) / ratio
            d_mean = (mean - decay) / tau
            d_decay = decay * ratio / tau
            drive = np.zeros_like(signal)
            drive[1:] = (
                d_decay * values[:-1] + (d_mean - d_decay) * signal[:-1] - d_mean * signal[1:]
            )
            by_tau = np.asarray(lfilter([1.0], [1.0, -decay], drive))
        return PathResponse(values=values, parameters=by_tau[:, None], tangent=run)

    def invert(self, signal: FloatArray, dt: float, parameters: Sizes) -> PathResponse:
        if signal.size < 2:
            return _identity_response(signal, 1)
        tau = parameters[0]
        rate = np.gradient(signal, dt)
        return PathResponse(
            values=signal + tau * rate,
            parameters=rate[:, None],
            tangent=lambda change: change + tau * np.gradient(change, dt, axis=0),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Delay(SignalTerm):
    """Pure delay.

    A negative one (the signal is early, which the clock of a box can bring about) acts on recorded
    histories only.
    """

    def value(self, reads: Values, states: Values, parameters: Values) -> Value:
        return reads[0] - _limit_time_constant(parameters[0]) * states[1]

    def rates(self, reads: Values, states: Values, parameters: Values) -> tuple[Value, ...]:
        delay = _limit_time_constant(parameters[0])
        return (
            states[1],
            12.0 * (reads[0] - states[0]) / (delay * delay) - 6.0 * states[1] / delay,
        )

    def steady_state(self, reads: Values, parameters: Values) -> tuple[Value, ...]:
        return (reads[0], 0.0 * reads[0])

    def jacobian(self, reads: Values, states: Values, parameters: Values) -> TermJacobian:
        delay = _limit_time_constant(parameters[0])
        moves = where(parameters[0] > SIMULATION.min_time_constant, 1.0, 0.0)
        stiffness = 12.0 / (delay * delay)
        by_delay = -2.0 * stiffness * (reads[0] - states[0]) / delay + 6.0 * states[1] / (
            delay * delay
        )
        return TermJacobian(
            reads=(1.0,),
            states=(0.0, -delay),
            parameters=(-moves * states[1],),
            rate_reads=((0.0,), (stiffness,)),
            rate_states=((0.0, 1.0), (-stiffness, -6.0 / delay)),
            rate_parameters=((0.0,), (moves * by_delay,)),
        )

    def initial_memory(self, signal: float, dt: float, parameters: Sizes) -> list[float]:
        if parameters[0] < 0.0:
            raise FlightError(
                f"the effect '{self.id}' has a delay of {parameters[0]:g} s, which must not be "
                "negative; give zero or more (or delay the other instruments)"
            )
        return [signal] * (math.ceil(parameters[0] / dt) + 2)

    def step(self, memory: list[float], signal: float, dt: float, parameters: Sizes) -> float:
        memory.insert(0, signal)
        memory.pop()
        place = parameters[0] / dt
        index = int(place)
        part = place - index
        return (1.0 - part) * memory[index] + part * memory[index + 1]

    def respond(self, signal: FloatArray, dt: float, parameters: Sizes) -> PathResponse:
        return _shift(signal, parameters[0] / dt, dt)

    def invert(self, signal: FloatArray, dt: float, parameters: Sizes) -> PathResponse:
        found = _shift(signal, -parameters[0] / dt, dt)
        return PathResponse(
            values=found.values, parameters=-found.parameters, tangent=found.tangent
        )


def _shift(signal: FloatArray, steps: float, dt: float) -> PathResponse:
    """Return a signal so many samples later, on the straight lines between samples."""
    count = signal.size
    wanted = np.arange(count) - steps
    place = np.clip(wanted, 0.0, count - 1.0)
    index = np.minimum(place.astype(np.intp), max(count - 2, 0))
    after = np.minimum(index + 1, count - 1)
    part = place - index

    def run(history: FloatArray) -> FloatArray:
        weight = part if history.ndim == 1 else part[:, None]
        return np.asarray((1.0 - weight) * history[index] + weight * history[after])

    moving = (wanted > 0.0) & (wanted < count - 1.0)
    slope = np.where(moving, (signal[after] - signal[index]) / dt, 0.0)
    return PathResponse(values=run(signal), parameters=-slope[:, None], tangent=run)


@dataclass(frozen=True, slots=True, kw_only=True)
class RateLimit(FollowingTerm):
    """Signal that follows no faster than a limit."""

    def rates(self, reads: Values, states: Values, parameters: Values) -> tuple[Value, ...]:
        return (
            clip((reads[0] - states[0]) / SIMULATION.edge_rounding, -parameters[0], parameters[0]),
        )

    def jacobian(self, reads: Values, states: Values, parameters: Values) -> TermJacobian:
        wanted = (reads[0] - states[0]) / SIMULATION.edge_rounding
        above = where(wanted > parameters[0], 1.0, 0.0)
        below = where(wanted < -parameters[0], 1.0, 0.0)
        slope = (1.0 - above - below) / SIMULATION.edge_rounding
        return TermJacobian(
            reads=(0.0,),
            states=(1.0,),
            parameters=(0.0,),
            rate_reads=((slope,),),
            rate_states=((-slope,),),
            rate_parameters=((above - below,),),
        )

    def step(self, memory: list[float], signal: float, dt: float, parameters: Sizes) -> float:
        reach = parameters[0] * dt
        memory[0] += min(max(signal - memory[0], -reach), reach)
        return memory[0]

    def respond(self, signal: FloatArray, dt: float, parameters: Sizes) -> PathResponse:
        reach = parameters[0] * dt
        values = np.empty(signal.size)
        moved = np.zeros(signal.size)
        free = np.ones(signal.size, dtype=bool)
        out = float(signal[0]) if signal.size else 0.0
        for index, sample in enumerate(signal.tolist()):
            step = sample - out
            if abs(step) <= reach:
                out = sample
            else:
                direction = math.copysign(1.0, step)
                out += direction * reach
                moved[index] = direction * dt
                free[index] = False
            values[index] = out
        last = _last_true(free)
        total = np.cumsum(moved)
        by_limit = total - np.where(last >= 0, total[last], 0.0)
        return PathResponse(values=values, parameters=by_limit[:, None], tangent=_held_from(last))


@dataclass(frozen=True, slots=True, kw_only=True)
class Backlash(FollowingTerm):
    """Free play: what comes out moves only when the play is used up."""

    def rates(self, reads: Values, states: Values, parameters: Values) -> tuple[Value, ...]:
        half = 0.5 * parameters[0]
        inside = clip(states[0], reads[0] - half, reads[0] + half)
        return ((inside - states[0]) / SIMULATION.edge_rounding,)

    def jacobian(self, reads: Values, states: Values, parameters: Values) -> TermJacobian:
        half = 0.5 * parameters[0]
        pushed = where(states[0] < reads[0] - half, 1.0, 0.0)
        pulled = where(states[0] > reads[0] + half, 1.0, 0.0)
        touch = (pushed + pulled) / SIMULATION.edge_rounding
        return TermJacobian(
            reads=(0.0,),
            states=(1.0,),
            parameters=(0.0,),
            rate_reads=((touch,),),
            rate_states=((-touch,),),
            rate_parameters=((0.5 * (pulled - pushed) / SIMULATION.edge_rounding,),),
        )

    def step(self, memory: list[float], signal: float, dt: float, parameters: Sizes) -> float:
        half = 0.5 * parameters[0]
        memory[0] = min(max(memory[0], signal - half), signal + half)
        return memory[0]

    def respond(self, signal: FloatArray, dt: float, parameters: Sizes) -> PathResponse:
        half = 0.5 * parameters[0]
        values = np.empty(signal.size)
        side = np.zeros(signal.size)
        touched = np.zeros(signal.size, dtype=bool)
        out = float(signal[0]) if signal.size else 0.0
        for index, sample in enumerate(signal.tolist()):
            if out < sample - half:
                out, side[index], touched[index] = sample - half, -0.5, True
            elif out > sample + half:
                out, side[index], touched[index] = sample + half, 0.5, True
            values[index] = out
        last = _last_true(touched)
        by_slop = np.where(last >= 0, side[last], 0.0)
        return PathResponse(
            values=values, parameters=by_slop[:, None], tangent=_held_from(np.maximum(last, 0))
        )


def _limit_time_constant(time: Value) -> Value:
    return where(time > SIMULATION.min_time_constant, time, SIMULATION.min_time_constant)


def apply_lag(signal: FloatArray, tau: float, dt: float) -> FloatArray:
    """Return a signal, shape (n, ...), after a first-order lag that was at rest before.

    Exact for straight lines between the samples.
    """
    from scipy.signal import lfilter  # a third of a second

    decay, old, new = lag_weights(tau, dt)
    start = (1.0 - new) * signal[:1]
    out, _ = lfilter([new, old], [1.0, -decay], signal, axis=0, zi=start)
    return np.asarray(out)


def lag_weights(tau: float, dt: float) -> tuple[float, float, float]:
    """Return weights of the last output, the last input and the new input, for straight lines."""
    if tau <= 0.0:
        return 0.0, 0.0, 1.0
    ratio = dt / tau
    decay = math.exp(-ratio)
    mean = -math.expm1(-ratio) / ratio
    return decay, mean - decay, 1.0 - mean


def _last_true(
    mask: np.ndarray[tuple[int], np.dtype[np.bool_]],
) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    return np.asarray(np.maximum.accumulate(np.where(mask, np.arange(mask.size), -1)))


def _held_from(
    last: np.ndarray[tuple[int], np.dtype[np.intp]],
) -> Callable[[FloatArray], FloatArray]:
    places = np.maximum(last, 0)
    return lambda change: np.asarray(change[places])


PathTerms = tuple[tuple[SignalTerm, tuple[float, ...]], ...]
"""Signal terms in the order in which the signal passes them, with their parameters."""


class SignalPath:
    """Terms one after another, running sample by sample, every `dt` s."""

    def __init__(self, terms: PathTerms, dt: float) -> None:
        self._terms = terms
        self._dt = dt
        self._memories: list[list[float]] | None = None

    def step(self, signal: float) -> float:
        """Take one sample and return what comes out; the first one is taken as constant before."""
        if self._memories is None:
            self._memories = []
            for term, values in self._terms:
                self._memories.append(term.initial_memory(signal, self._dt, values))
                # Constant so far: what came out is what one more such sample gives.
                signal = term.step(self._memories[-1], signal, self._dt, values)
            return signal
        for (term, values), memory in zip(self._terms, self._memories, strict=True):
            signal = term.step(memory, signal, self._dt, values)
        return signal


class SupportsRespond(Protocol):
    """What gives a whole history after one part of a path, as `SignalTerm.respond`."""

    def respond(self, signal: FloatArray, dt: float, parameters: Sizes) -> PathResponse: ...


def _apply_all(
    tangents: Sequence[Callable[[FloatArray], FloatArray]], change: FloatArray
) -> FloatArray:
    for tangent in tangents:
        change = tangent(change)
    return change


def path_response(
    terms: Sequence[tuple[SupportsRespond, tuple[float, ...]]], signal: FloatArray, dt: float
) -> PathResponse:
    """Return a whole history after several terms, with the derivatives by all their parameters.

    The columns of `PathResponse.parameters` follow the terms and their parameters in order.
    """
    values = np.asarray(signal, dtype=np.float64)
    columns = np.empty((values.size, 0))
    tangents: list[Callable[[FloatArray], FloatArray]] = []
    for term, parameters in terms:
        one = term.respond(values, dt, parameters)
        columns = np.hstack([one.tangent(columns), one.parameters])
        values = one.values
        tangents.append(one.tangent)

    return PathResponse(values=values, parameters=columns, tangent=partial(_apply_all, tangents))


def invert_path(terms: PathTerms, signal: FloatArray, dt: float) -> PathResponse:
    """Return the history before several terms, from what came out of them; as `path_response`.

    The columns of `PathResponse.parameters` follow the terms in their order on the path.
    """
    values = np.asarray(signal, dtype=np.float64)
    widths = [len(parameters) for _, parameters in terms]
    columns = np.zeros((values.size, sum(widths)))
    tangents: list[Callable[[FloatArray], FloatArray]] = []
    stop = sum(widths)
    for (term, parameters), width in zip(reversed(terms), reversed(widths), strict=True):
        one = term.invert(values, dt, parameters)
        columns = one.tangent(columns)
        columns[:, stop - width : stop] = one.parameters
        stop -= width
        values = one.values
        tangents.append(one.tangent)

    return PathResponse(values=values, parameters=columns, tangent=partial(_apply_all, tangents))


def channels_of_target(name: str) -> tuple[str, ...]:
    """Return the channels that a target ``sensor.<name>`` stands for: one, or those of a group."""
    return INSTRUMENT_BOXES.get(name) or SCALED_GROUPS.get(name) or (name,)

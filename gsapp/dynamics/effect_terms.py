"""The forms of terms that effects are made of, beside powers and products (`Monomial`).

The modules of `gsapp.dynamics.effects` enter them in the registry with their parameters and words.
"""

# ruff: noqa: ARG002 - overridden methods, which use their arguments or not

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np

from gsapp.dynamics.arithmetic import Value, array_namespace, where
from gsapp.dynamics.signal_terms import apply_lag
from gsapp.dynamics.terms import Term, TermJacobian, Values
from gsapp.quantities import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class SpeedTerm(Term):
    """Coefficient that changes with speed itself: parameter * (V/V_ref - 1)."""

    def value(self, reads: Values, states: Values, parameters: Values) -> Value:
        return parameters[0] * (reads[0] / parameters[1] - 1.0)

    def jacobian(self, reads: Values, states: Values, parameters: Values) -> TermJacobian:
        slope, reference = parameters
        ratio = reads[0] / reference
        return TermJacobian(
            reads=(slope / reference,), parameters=(ratio - 1.0, -slope * ratio / reference)
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class UnsteadyTerm(Term):
    """Target that follows a variable with one lag: scale * parameter * (x - lagged x).

    For slow changes it equals scale * parameter * tau * x'.
    """

    scale: float = 1.0  # A fixed factor.

    def value(self, reads: Values, states: Values, parameters: Values) -> Value:
        return self.scale * parameters[0] * (reads[0] - states[0])

    def rates(self, reads: Values, states: Values, parameters: Values) -> tuple[Value, ...]:
        return ((reads[0] - states[0]) / parameters[1],)

    def steady_state(self, reads: Values, parameters: Values) -> tuple[Value, ...]:
        return (reads[0],)

    def states_along(
        self, reads: Sequence[FloatArray], parameters: Sequence[float], dt: float
    ) -> tuple[FloatArray, ...]:
        return (apply_lag(reads[0], parameters[1], dt),)

    def jacobian(self, reads: Values, states: Values, parameters: Values) -> TermJacobian:
        tau = parameters[1]
        size = self.scale * parameters[0]
        difference = reads[0] - states[0]
        return TermJacobian(
            reads=(size,),
            states=(-size,),
            parameters=(self.scale * difference, 0.0),
            rate_reads=((1.0 / tau,),),
            rate_states=((-1.0 / tau,),),
            rate_parameters=((0.0, -difference / (tau * tau)),),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class StallDepartureTerm(Term):
    """Departure from the linear coefficient beyond the linear angles of attack, without memory.

    Exactly zero between `alpha_low` and `alpha_high`; outside it starts as a parabola and turns
    into a line of the slope `slope`: with e the excess over the limit, slope * e^2/(|e| + width).
    An even coefficient (drag) takes |e|.
    """

    even: bool = False  # Whether the term has the same sign on both sides.

    def value(self, reads: Values, states: Values, parameters: Values) -> Value:
        excess, sign = self._excess(reads[0], parameters)
        slope, width = parameters[0], parameters[1]
        return slope * sign * excess * excess / (excess + width)

    def jacobian(self, reads: Values, states: Values, parameters: Values) -> TermJacobian:
        excess, sign = self._excess(reads[0], parameters)
        slope, width = parameters[0], parameters[1]
        shape = excess * excess / (excess + width)
        by_excess = slope * sign * excess * (excess + 2.0 * width) / (excess + width) ** 2
        above = reads[0] > parameters[3]
        direction = where(above, 1.0, -1.0)
        return TermJacobian(
            reads=(by_excess * direction,),
            parameters=(
                sign * shape,
                -slope * sign * shape / (excess + width),
                where(above, 0.0, 1.0) * by_excess,
                where(above, -1.0, 0.0) * by_excess,
            ),
        )

    def _excess(self, alpha: Value, parameters: Values) -> tuple[Value, Value]:
        low, high = parameters[2], parameters[3]
        above = where(alpha > high, alpha - high, 0.0)
        below = where(alpha < low, low - alpha, 0.0)
        sign = 1.0 if self.even else where(alpha < low, -1.0, 1.0)
        return above + below, sign


STALL_SHAPE: Final = ("a1", "alpha_star", "tau1", "tau2")
"""Parameters of a `StallTerm` after its size: one flow separates, so that all coefficients share
them."""
_MIN_ATTACHED = 1e-3
"""Position of the separation point below which its root goes on in a straight line."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StallTerm(Term):
    """Flow that separates from the trailing edge forward, late in time: Kirchhoff's stall.

    The state X is the point up to which the flow is attached, 1 at the trailing edge, 0 at the
    leading edge:

        tau1 X' + X = (1 - tanh(a1 (alpha - tau2 alpha' - alpha_star)))/2

    The lift of the attached flow is multiplied by ((1 + sqrt X)/2)^2: ``lift`` adds the size times
    alpha times what is lost of that. ``separation`` adds the size times 1 - X. Reads alpha, V and
    alpha' c/(2V), the last for the rate of X only.

    Goman, Khrabrov, State-space representation of aerodynamic characteristics of an aircraft at
    high angles of attack, J. Aircraft 31, 1994; Jategaonkar, Flight Vehicle System
    Identification, 2015, chapter 12.
    """

    shape: Literal["lift", "separation"]
    chord: float  # m.

    def with_shape(self, values: Mapping[str, float]) -> StallTerm:
        """Return the stall with other defaults of `STALL_SHAPE`."""
        return replace(
            self,
            parameters=tuple(
                replace(item, default=values.get(item.name, item.default))
                for item in self.parameters
            ),
        )

    def value(self, reads: Values, states: Values, parameters: Values) -> Value:
        if self.shape == "separation":
            return parameters[0] * (1.0 - states[0])
        factor = 0.5 * (1.0 + self._root(states[0])[0])
        return parameters[0] * reads[0] * (1.0 - factor * factor)

    def rates(self, reads: Values, states: Values, parameters: Values) -> tuple[Value, ...]:
        return ((self._settled(reads, parameters)[0] - states[0]) / parameters[3],)

    def steady_state(self, reads: Values, parameters: Values) -> tuple[Value, ...]:
        return (self._settled((reads[0], reads[1], 0.0), parameters)[0],)

    def states_along(
        self, reads: Sequence[FloatArray], parameters: Sequence[float], dt: float
    ) -> tuple[FloatArray, ...]:
        settled = np.asarray(self._settled(reads, parameters)[0])
        return (apply_lag(settled, parameters[3], dt),)

    def jacobian(self, reads: Values, states: Values, parameters: Values) -> TermJacobian:
        alpha, V, alpha_dot_hat = reads
        size, a1, alpha_star, tau1, tau2 = parameters
        root, by_state = self._root(states[0])
        factor = 0.5 * (1.0 + root)
        if self.shape == "lift":
            lost = 1.0 - factor * factor
            by_alpha, by_X, by_size = size * lost, -size * alpha * factor * by_state, alpha * lost
        else:
            by_alpha, by_X, by_size = 0.0, -size + 0.0 * states[0], 1.0 - states[0]
        settled, slope = self._settled(reads, parameters)
        alpha_dot = 2.0 * V * alpha_dot_hat / self.chord
        excess = alpha - tau2 * alpha_dot - alpha_star
        by_delay = -a1 * slope * tau2 / tau1
        return TermJacobian(
            reads=(by_alpha, 0.0, 0.0),
            states=(by_X,),
            parameters=(by_size, 0.0, 0.0, 0.0, 0.0),
            rate_reads=(
                (
                    a1 * slope / tau1,
                    by_delay * 2.0 * alpha_dot_hat / self.chord,
                    by_delay * 2.0 * V / self.chord,
                ),
            ),
            rate_states=((-1.0 / tau1,),),
            rate_parameters=(
                (
                    0.0,
                    excess * slope / tau1,
                    -a1 * slope / tau1,
                    -(settled - states[0]) / (tau1 * tau1),
                    -a1 * slope * alpha_dot / tau1,
                ),
            ),
        )

    def _settled(self, reads: Values, parameters: Values) -> tuple[Value, Value]:
        """Return where X settles, and its derivative by a1 (alpha - tau2 alpha' - alpha_star)."""
        alpha, V, alpha_dot_hat = reads
        _, a1, alpha_star, _, tau2 = parameters
        excess = a1 * (alpha - 2.0 * tau2 * V * alpha_dot_hat / self.chord - alpha_star)
        tanh = array_namespace(excess).tanh(excess)
        return 0.5 * (1.0 - tanh), -0.5 * (1.0 - tanh * tanh)

    @staticmethod
    def _root(X: Value) -> tuple[Value, Value]:
        """Return the square root of X and its derivative, finite where X falls to zero."""
        attached = where(X > _MIN_ATTACHED, X, _MIN_ATTACHED)
        root = array_namespace(attached).sqrt(attached)
        slope = 0.5 / root
        return root + slope * (X - attached), slope


@dataclass(frozen=True, slots=True, kw_only=True)
class EffectivenessLossTerm(Term):
    """Effectiveness of a surface that falls off beyond a deflection, alike to both sides.

    Exactly zero up to `onset`; with e = |x| - onset beyond it, slope * e^2/(e + width) * sign(x).
    """

    def value(self, reads: Values, states: Values, parameters: Values) -> Value:
        excess, sign = _onset_excess(reads[0], parameters[1])
        return parameters[0] * sign * excess * excess / (excess + parameters[2])

    def jacobian(self, reads: Values, states: Values, parameters: Values) -> TermJacobian:
        slope, width = parameters[0], parameters[2]
        excess, sign = _onset_excess(reads[0], parameters[1])
        shape = excess * excess / (excess + width)
        by_excess = slope * excess * (excess + 2.0 * width) / (excess + width) ** 2
        return TermJacobian(
            reads=(by_excess,),
            parameters=(sign * shape, -sign * by_excess, -slope * sign * shape / (excess + width)),
        )


def _onset_excess(x: Value, onset: Value) -> tuple[Value, Value]:
    """Return how far |x| lies beyond the onset, zero before it, and the sign of x."""
    over = where(x > onset, x - onset, 0.0)
    under = where(x < -onset, -onset - x, 0.0)
    return over + under, where(x < 0.0, -1.0, 1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class ThrustSpeedTerm(Term):
    """Thrust that changes otherwise with speed: parameter * T * (V/V_ref - 1)."""

    def value(self, reads: Values, states: Values, parameters: Values) -> Value:
        return parameters[0] * reads[0] * (reads[1] / parameters[1] - 1.0)

    def jacobian(self, reads: Values, states: Values, parameters: Values) -> TermJacobian:
        thrust, V = reads
        fade, reference = parameters
        ratio = V / reference
        return TermJacobian(
            reads=(fade * (ratio - 1.0), fade * thrust / reference),
            parameters=(thrust * (ratio - 1.0), -fade * thrust * ratio / reference),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class ThrustErrorTerm(Term):
    """A share of the thrust of the aircraft file: parameter * k throttle rho (1 - V/V_0)."""

    per_density: float  # Thrust of all engines at rest over density, N m^3/kg.
    zero_thrust_speed: float  # m/s.

    def _thrust(self, reads: Values) -> Value:
        throttle, rho, V = reads
        return self.per_density * throttle * rho * (1.0 - V / self.zero_thrust_speed)

    def value(self, reads: Values, states: Values, parameters: Values) -> Value:
        return parameters[0] * self._thrust(reads)

    def jacobian(self, reads: Values, states: Values, parameters: Values) -> TermJacobian:
        throttle, rho, V = reads
        size = parameters[0] * self.per_density
        left = 1.0 - V / self.zero_thrust_speed
        return TermJacobian(
            reads=(
                size * rho * left,
                size * throttle * left,
                -size * throttle * rho / self.zero_thrust_speed,
            ),
            parameters=(self._thrust(reads),),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class OffsetTerm(Term):
    """A constant added to the target: a value of the aircraft file that is wrong."""

    def value(self, reads: Values, states: Values, parameters: Values) -> Value:
        return parameters[0]

    def jacobian(self, reads: Values, states: Values, parameters: Values) -> TermJacobian:
        return TermJacobian(reads=(), parameters=(1.0,))

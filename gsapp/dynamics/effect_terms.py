"""The forms of terms that effects are made of, beside powers and products (`Monomial`).

The modules of `gsapp.dynamics.effects` enter them in the registry with their parameters and words.
"""

# ruff: noqa: ARG002 - overridden methods, which use their arguments or not

from __future__ import annotations

from dataclasses import dataclass

from gsapp.dynamics.arithmetic import Value, where
from gsapp.dynamics.terms import Term, TermJacobian, Values


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
class StallTerm(Term):
    """Departure from the linear coefficient beyond the linear angles of attack.

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

"""Effects of aerodynamics, propulsion and mass that a linear build-up leaves out.

Importing this module enters them in the registry of `gsapp.dynamics.terms`. Effects of the
control path and of the instruments are in `gsapp.dynamics.signals`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from gsapp.aircraft import Aircraft
from gsapp.dynamics.arithmetic import Value, choose
from gsapp.dynamics.buildup import COEFFICIENT_TITLES, reads_of
from gsapp.dynamics.terms import (
    COEFFICIENTS,
    Monomial,
    Parameter,
    Term,
    TermFactory,
    TermJacobian,
    Values,
    register,
)

_REFERENCE_SPEED = 28.956  # 95 ft/s, the middle of the flight-test speeds


@dataclass(frozen=True, slots=True, kw_only=True)
class SpeedTerm(Term):
    """Coefficient that changes with speed itself: parameter * (V/V_ref - 1)."""

    def value(self, reads: Values, states: Values, parameters: Values) -> Value:
        """Return the change from the reference speed."""
        del states
        return parameters[0] * (reads[0] / parameters[1] - 1.0)

    def jacobian(self, reads: Values, states: Values, parameters: Values) -> TermJacobian:
        """Return the partial derivatives."""
        del states
        slope, reference = parameters
        ratio = reads[0] / reference
        return TermJacobian(
            reads=(slope / reference,), parameters=(ratio - 1.0, -slope * ratio / reference)
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class MemoryTerm(Term):
    """Coefficient that follows a variable with one lag: parameter * (x - lagged x).

    For slow changes it equals parameter * tau * x'.
    """

    def value(self, reads: Values, states: Values, parameters: Values) -> Value:
        """Return the part that has not settled yet."""
        return parameters[0] * (reads[0] - states[0])

    def rates(self, reads: Values, states: Values, parameters: Values) -> tuple[Value, ...]:
        """Return (x - state)/tau."""
        return ((reads[0] - states[0]) / parameters[1],)

    def rest(self, reads: Values, parameters: Values) -> tuple[Value, ...]:
        """Return x itself: all has settled."""
        del parameters
        return (reads[0],)

    def jacobian(self, reads: Values, states: Values, parameters: Values) -> TermJacobian:
        """Return the partial derivatives."""
        size, tau = parameters
        difference = reads[0] - states[0]
        return TermJacobian(
            reads=(size,),
            states=(-size,),
            parameters=(difference, 0.0),
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

    Attributes
    ----------
    even : bool
        Whether the term has the same sign on both sides.
    """

    even: bool = False

    def value(self, reads: Values, states: Values, parameters: Values) -> Value:
        """Return the departure."""
        del states
        excess, sign = self._excess(reads[0], parameters)
        slope, width = parameters[0], parameters[1]
        return slope * sign * excess * excess / (excess + width)

    def jacobian(self, reads: Values, states: Values, parameters: Values) -> TermJacobian:
        """Return the partial derivatives."""
        del states
        excess, sign = self._excess(reads[0], parameters)
        slope, width = parameters[0], parameters[1]
        shape = excess * excess / (excess + width)
        by_excess = slope * sign * excess * (excess + 2.0 * width) / (excess + width) ** 2
        above = reads[0] > parameters[3]
        direction = choose(above, 1.0, -1.0)
        return TermJacobian(
            reads=(by_excess * direction,),
            parameters=(
                sign * shape,
                -slope * sign * shape / (excess + width),
                choose(above, 0.0, 1.0) * by_excess,
                choose(above, -1.0, 0.0) * by_excess,
            ),
        )

    def _excess(self, alpha: Value, parameters: Values) -> tuple[Value, Value]:
        low, high = parameters[2], parameters[3]
        above = choose(alpha > high, alpha - high, 0.0)
        below = choose(alpha < low, low - alpha, 0.0)
        sign = 1.0 if self.even else choose(alpha < low, -1.0, 1.0)
        return above + below, sign


@dataclass(frozen=True, slots=True, kw_only=True)
class OffsetTerm(Term):
    """A constant added to the target: a value of the aircraft file that is wrong."""

    def value(self, reads: Values, states: Values, parameters: Values) -> Value:
        """Return the parameter."""
        del reads, states
        return parameters[0]

    def jacobian(self, reads: Values, states: Values, parameters: Values) -> TermJacobian:
        """Return 1 for the parameter."""
        del reads, states, parameters
        return TermJacobian(reads=(), parameters=(1.0,))


# --- aerodynamic effects ------------------------------------------------------------------------

_WORDS = {
    "alpha": "angle of attack",
    "beta": "sideslip",
    "p_hat": "roll rate",
    "q_hat": "pitch rate",
    "r_hat": "yaw rate",
    "de": "elevator",
    "da": "aileron",
    "dr": "rudder",
    "flap": "flap",
    "alpha_dot_hat": "rate of angle of attack",
    "throttle": "throttle",
}


def _monomial(
    target: str, kind: str, factors: Sequence[tuple[str, int]], default: float, title: str
) -> None:
    name = f"{target}_{kind}"
    product = " ".join(
        variable if power == 1 else f"{variable}^{power}" for variable, power in factors
    )
    term = Monomial(
        id=f"aero.{target}.{kind}",
        title=title,
        equation=f"{target} += {name} {product}",
        target=target,
        reads=tuple(variable for variable, _ in factors),
        powers=tuple(power for _, power in factors),
        parameters=(
            Parameter(
                name=name,
                unit="",
                default=default,
                bounds=(-200.0, 200.0),
                description="size of the term, angles in radians",
            ),
        ),
    )
    register(term.id, lambda _: term)


def _title(target: str) -> str:
    words = COEFFICIENT_TITLES[target]
    return words[0].upper() + words[1:]


def _register_polynomials() -> None:
    for target, size in (("Cm", -2.0), ("CN", 6.0), ("CA", 2.0)):
        _monomial(
            target,
            "alpha2",
            [("alpha", 2)],
            size,
            f"{_title(target)} curves with angle of attack",
        )
        _monomial(
            target,
            "flap",
            [("flap", 1)],
            {"Cm": -0.08, "CN": 0.6, "CA": 0.06}[target],
            f"Flap changes the {COEFFICIENT_TITLES[target]}",
        )
    _monomial(
        "Cm",
        "alphadot",
        [("alpha_dot_hat", 1)],
        -8.0,
        "Downwash reaches the tail late: damping by the rate of angle of attack",
    )
    for target, size in (("Cl", -1.5), ("Cn", 0.8)):
        _monomial(
            target,
            "alpha_beta",
            [("alpha", 1), ("beta", 1)],
            size,
            f"{_title(target)} from sideslip changes with angle of attack",
        )
    for target, size in (("Cl", 2.0), ("Cn", 1.5)):
        _monomial(
            target,
            "beta3",
            [("beta", 3)],
            size,
            f"{_title(target)} stiffens or softens at large sideslip",
        )
    _monomial("Cm", "beta2", [("beta", 2)], -0.6, "Sideslip pitches the nose")
    for target, surface, size in (
        ("Cm", "de", 2.5),
        ("Cl", "da", -0.9),
        ("Cn", "dr", 0.15),
    ):
        word = _WORDS[surface]
        _monomial(
            target,
            f"{surface}3",
            [(surface, 3)],
            size,
            f"{word.capitalize()} loses effect at large deflection",
        )
        _monomial(
            target,
            f"alpha_{surface}",
            [("alpha", 1), (surface, 1)],
            size,
            f"{word.capitalize()} effect changes with angle of attack",
        )
    for target, rate, size in (("Cm", "q_hat", 60.0), ("Cl", "p_hat", 3.0), ("Cn", "r_hat", -1.0)):
        _monomial(
            target,
            f"alpha_{rate[0]}",
            [("alpha", 1), (rate, 1)],
            size,
            f"{_WORDS[rate].capitalize()} damping changes with angle of attack",
        )
    _monomial("Cl", "alpha", [("alpha", 1)], 0.05, "Left and right wing differ: roll with alpha")


def _register_linear() -> None:
    """Enter every single linear derivative, and the usual cross terms, as effects."""
    for target in COEFFICIENTS:
        own = reads_of(target)
        for suffix, variable in own.items():
            _monomial(
                target,
                suffix,
                [(variable, 1)],
                0.1,
                f"{_title(target)} from {_WORDS[variable]} is missing",
            )


def _speed(target: str, coefficient_title: str, default: float) -> None:
    name = f"{target}_V"
    term = SpeedTerm(
        id=f"aero.{target}.speed",
        title=f"{coefficient_title} changes with speed",
        equation=f"{target} += {name} (V/V_ref - 1)",
        target=target,
        reads=("V",),
        parameters=(
            Parameter(
                name=name,
                unit="",
                default=default,
                bounds=(-5.0, 5.0),
                description="change of the coefficient when the speed doubles",
            ),
            Parameter(
                name="V_ref",
                unit="m/s",
                default=_REFERENCE_SPEED,
                bounds=(1.0, 300.0),
                neutral=_REFERENCE_SPEED,
                description="speed at which the term is zero",
                free=False,
            ),
        ),
    )
    register(term.id, lambda _: term)


def _memory(target: str, default: float) -> None:
    term = MemoryTerm(
        id=f"aero.{target}.memory",
        title="The flow takes time to settle (one lag)",
        equation=f"{target} += {target}_memory (alpha - x), x' = (alpha - x)/tau",
        target=target,
        reads=("alpha",),
        states=("x",),
        parameters=(
            Parameter(
                name=f"{target}_memory",
                unit="",
                default=default,
                bounds=(-50.0, 50.0),
                description="part of the coefficient that comes late, per radian",
            ),
            Parameter(
                name="tau",
                unit="s",
                default=0.1,
                bounds=(0.005, 2.0),
                neutral=0.1,
                description="time constant",
            ),
        ),
    )
    register(term.id, lambda _: term)


# --- stall --------------------------------------------------------------------------------------


def _stall(target: str, default: float, *, even: bool, words: str) -> TermFactory:
    def make(aircraft: Aircraft) -> Term:
        low, high = aircraft.limits.alpha_linear
        limit = (-math.pi / 2.0, math.pi / 2.0)
        return StallTerm(
            id=f"aero.{target}.stall",
            title=f"Stall: {words}",
            equation=f"{target} += slope e^2/(|e| + width), e = alpha beyond the linear range",
            target=target,
            reads=("alpha",),
            even=even,
            parameters=(
                Parameter(
                    name="slope",
                    unit="",
                    default=default,
                    bounds=(-20.0, 20.0),
                    description="final slope of the departure, per radian",
                ),
                Parameter(
                    name="width",
                    unit="rad",
                    default=0.06,
                    bounds=(1e-3, 1.0),
                    neutral=0.06,
                    description="excess at which half of the final slope is reached",
                    free=False,
                ),
                Parameter(
                    name="alpha_low",
                    unit="rad",
                    default=low,
                    bounds=limit,
                    neutral=low,
                    description="lower end of the linear range",
                    free=False,
                ),
                Parameter(
                    name="alpha_high",
                    unit="rad",
                    default=high,
                    bounds=limit,
                    neutral=high,
                    description="upper end of the linear range",
                    free=False,
                ),
            ),
        )

    return make


# --- propulsion and mass ------------------------------------------------------------------------


def _throttle_pitch(_: Aircraft) -> Term:
    return Monomial(
        id="propulsion.Cm.throttle",
        title="Throttle pitches the nose up, most at low speed",
        equation="M += arm T, so Cm += arm T/(qbar S c)",
        target="M",
        reads=("thrust",),
        powers=(1,),
        parameters=(
            Parameter(
                name="arm",
                unit="m",
                default=0.05,
                bounds=(-0.5, 0.5),
                description="height of the CG above the thrust line, beyond the aircraft file's",
            ),
        ),
    )


def _asymmetric_thrust(aircraft: Aircraft) -> Term:
    distance = max((abs(y) for _, y, _ in aircraft.propulsion.position), default=0.0)
    arm = distance or 0.1 * aircraft.geometry.span
    return Monomial(
        id="propulsion.Cn.asymmetry",
        title="Engines differ: throttle turns the nose",
        equation=f"N += imbalance {arm:.3f} m T, so Cn += imbalance y T/(qbar S b)",
        target="N",
        reads=("thrust",),
        powers=(1,),
        scale=arm,
        parameters=(
            Parameter(
                name="imbalance",
                unit="",
                default=0.15,
                bounds=(-1.0, 1.0),
                description="left thrust minus right over their sum; positive: nose right",
            ),
        ),
    )


def _thrust_scale(_: Aircraft) -> Term:
    return Monomial(
        id="propulsion.thrust.scale",
        title="Engines give less (or more) thrust than the aircraft file says",
        equation="X += error T",
        target="X",
        reads=("thrust",),
        powers=(1,),
        parameters=(
            Parameter(
                name="error",
                unit="",
                default=-0.15,
                bounds=(-1.0, 1.0),
                description="share of the thrust by which it differs",
            ),
        ),
    )


def _offset(term_id: str, target: str, unit: str, default: float, bound: float, title: str) -> None:
    name = target.rpartition(".")[2] if target.startswith("cg") else "error"
    term = OffsetTerm(
        id=term_id,
        title=title,
        equation=f"{target} = aircraft file's + {name}",
        target=target,
        reads=(),
        parameters=(
            Parameter(
                name=name,
                unit=unit,
                default=default,
                bounds=(-bound, bound),
                description="difference from the aircraft file",
            ),
        ),
    )
    register(term.id, lambda _: term)


_register_polynomials()
_register_linear()
_speed("CX", "Axial force", 0.03)
_speed("CZ", "Lift", -0.15)
_speed("Cm", "Pitching moment", 0.04)
_memory("Cm", -0.8)
_memory("CN", 0.8)
register("aero.CN.stall", _stall("CN", -4.6, even=False, words="the wing stops lifting"))
register("aero.CA.stall", _stall("CA", 1.6, even=True, words="the drag rises"))
register("aero.Cm.stall", _stall("Cm", -0.6, even=False, words="the nose drops"))
register("propulsion.Cm.throttle", _throttle_pitch)
register("propulsion.Cn.asymmetry", _asymmetric_thrust)
register("propulsion.thrust.scale", _thrust_scale)
_offset("mass.cg.x", "cg.x", "m", 0.02, 0.5, "Center of gravity lies further forward or aft")
_offset("mass.mass.error", "mass", "kg", -1.0, 20.0, "Mass differs from the aircraft file")
_offset("mass.inertia.ixx", "ixx", "kg*m^2", 0.7, 20.0, "Roll inertia differs")
_offset("mass.inertia.iyy", "iyy", "kg*m^2", 0.8, 20.0, "Pitch inertia differs")
_offset("mass.inertia.izz", "izz", "kg*m^2", 0.9, 20.0, "Yaw inertia differs")
_offset("mass.inertia.ixz", "ixz", "kg*m^2", 0.6, 20.0, "Roll and yaw are coupled by the mass")

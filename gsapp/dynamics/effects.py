"""Effects of aerodynamics, propulsion and mass that a linear build-up leaves out.

Importing this module enters them in the registry of `gsapp.dynamics.terms`. Effects of the
control path and of the instruments are in `gsapp.dynamics.signal_effects`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from gsapp.aircraft import Aircraft
from gsapp.dynamics.atmosphere import SEA_LEVEL_DENSITY
from gsapp.dynamics.buildup import COEFFICIENT_TITLES, linear_variables
from gsapp.dynamics.effect_terms import (
    EffectivenessLossTerm,
    OffsetTerm,
    SpeedTerm,
    StallTerm,
    ThrustErrorTerm,
    ThrustSpeedTerm,
    UnsteadyTerm,
)
from gsapp.dynamics.terms import (
    COEFFICIENTS,
    Monomial,
    Parameter,
    Term,
    TermFactory,
    register_effect,
)

_REFERENCE_SPEED = 28.956  # 95 ft/s, the middle of the flight-test speeds
_V_REF = Parameter(
    name="V_ref",
    unit="m/s",
    default=_REFERENCE_SPEED,
    bounds=(1.0, 300.0),
    neutral=_REFERENCE_SPEED,
    description="speed at which the term is zero",
    free=False,
)


# --- aerodynamic effects ------------------------------------------------------------------------

_VARIABLE_TITLES = {
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
    target: str,
    kind: str,
    factors: Sequence[tuple[str, int]],
    default: float,
    title: str,
    *,
    group: str = "aero",
) -> None:
    name = f"{target}_{kind}"
    product = " ".join(
        variable if power == 1 else f"{variable}^{power}" for variable, power in factors
    )
    term = Monomial(
        id=f"{group}.{target}.{kind}",
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
    register_effect(term.id, lambda _: term)


def _title(target: str) -> str:
    words = COEFFICIENT_TITLES[target]
    return words[0].upper() + words[1:]


_LINEAR_SIZES = {
    "CN": {"alpha": 0.5, "q": 3.0, "de": 0.1},
    "CA": {"alpha": 0.1, "q": 0.5, "de": 0.05},
    "Cm": {"alpha": -0.1, "q": -5.0, "de": -0.2},
    "CY": {"beta": -0.1, "p": 0.1, "r": 0.2, "da": 0.05, "dr": 0.05},
    "Cl": {"beta": -0.05, "p": -0.2, "r": 0.1, "da": 0.05, "dr": 0.02},
    "Cn": {"beta": 0.03, "p": -0.06, "r": -0.1, "da": 0.01, "dr": -0.02},
}
_CROSS_SIZES = {"alpha": 0.05, "beta": 0.05, "p": 0.3, "q": 1.0, "r": 0.3}
_CROSS_SURFACE = 0.03


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
    for target, size in (("Cl", -1.5), ("Cn", 0.8), ("CY", -1.0)):
        _monomial(
            target,
            "alpha_beta",
            [("alpha", 1), ("beta", 1)],
            size,
            f"{_title(target)} from sideslip changes with angle of attack",
        )
    for target, size in (("Cl", 2.0), ("Cn", 1.5), ("CY", -3.0)):
        _monomial(
            target,
            "beta3",
            [("beta", 3)],
            size,
            f"{_title(target)} stiffens or softens at large sideslip",
        )
    _monomial("Cm", "beta2", [("beta", 2)], -0.6, "Sideslip pitches the nose")
    _monomial("CN", "beta2", [("beta", 2)], -1.0, "Sideslip to either side costs lift")
    _monomial("CA", "beta2", [("beta", 2)], 0.5, "Sideslip to either side brakes")


def _register_surfaces() -> None:
    for target, surface, size in (
        ("Cm", "de", 2.5),
        ("CN", "de", -1.0),
        ("Cl", "da", -0.9),
        ("Cn", "da", -0.1),
        ("Cn", "dr", 0.15),
        ("Cl", "dr", -0.05),
        ("CY", "dr", -0.3),
    ):
        _monomial(
            target,
            f"{surface}3",
            [(surface, 3)],
            size,
            f"{_describe_effectiveness_loss(target, surface)} at large deflection",
        )
    for target, surface, size in (
        ("Cm", "de", 2.5),
        ("CN", "de", -1.0),
        ("CA", "de", 0.4),
        ("Cl", "da", -0.9),
        ("Cn", "da", -0.2),
        ("CY", "da", 0.3),
        ("Cn", "dr", 0.15),
        ("Cl", "dr", -0.1),
        ("CY", "dr", -0.4),
    ):
        word = _VARIABLE_TITLES[surface].capitalize()
        main = _MAIN_SURFACE.get(target) == surface
        own = "" if main else f" on the {COEFFICIENT_TITLES[target]}"
        _monomial(
            target,
            f"alpha_{surface}",
            [("alpha", 1), (surface, 1)],
            size,
            f"{word} effect{own} changes with angle of attack",
        )
    _monomial("CA", "de2", [("de", 2)], 0.3, "Elevator brakes to either side")
    for target, surface, size in (("Cm", "de", 0.9), ("Cl", "da", -0.32), ("Cn", "dr", 0.055)):
        _register_effectiveness_loss(target, surface, size)


_MAIN_SURFACE = {"Cm": "de", "Cl": "da", "Cn": "dr"}


def _describe_effectiveness_loss(target: str, surface: str) -> str:
    word = _VARIABLE_TITLES[surface].capitalize()
    if _MAIN_SURFACE.get(target) == surface:
        return f"{word} loses effect"
    return f"{word} loses {COEFFICIENT_TITLES[target]}"


def _register_damping() -> None:
    for target, rate, size in (
        ("Cm", "q_hat", 60.0),
        ("CN", "q_hat", 20.0),
        ("Cl", "p_hat", 3.0),
        ("Cn", "p_hat", -1.0),
        ("CY", "p_hat", 1.0),
        ("Cl", "r_hat", 1.5),
        ("Cn", "r_hat", -1.0),
        ("CY", "r_hat", 1.0),
    ):
        word = _VARIABLE_TITLES[rate].capitalize()
        damping = (target, rate) in {("Cm", "q_hat"), ("Cl", "p_hat"), ("Cn", "r_hat")}
        _monomial(
            target,
            f"alpha_{rate[0]}",
            [("alpha", 1), (rate, 1)],
            size,
            f"{word.removesuffix(' rate')} damping changes with angle of attack"
            if damping
            else f"{_title(target)} from {_VARIABLE_TITLES[rate]} changes with angle of attack",
        )


def _register_linear() -> None:
    """Enter every single linear derivative, and those that couple the two planes, as effects."""
    for target in COEFFICIENTS:
        for suffix, variable in linear_variables(target).items():
            _monomial(
                target,
                suffix,
                [(variable, 1)],
                _LINEAR_SIZES[target][suffix],
                f"{_title(target)} from {_VARIABLE_TITLES[variable]} is missing",
            )
        foreign = linear_variables("CY" if target in ("CN", "CA", "Cm") else "CN")
        for suffix, variable in foreign.items():
            title = f"{_title(target)} from {_VARIABLE_TITLES[variable]}: left and right differ"
            if (target, suffix) == ("Cl", "alpha"):
                title = "Left and right wing differ: roll with alpha"
            _monomial(
                target,
                suffix,
                [(variable, 1)],
                _CROSS_SIZES.get(suffix, _CROSS_SURFACE),
                title,
            )


def _register_effectiveness_loss(target: str, surface: str, default: float) -> None:
    word = _VARIABLE_TITLES[surface]
    term = EffectivenessLossTerm(
        id=f"aero.{target}.{surface}_falloff",
        title=f"{word.capitalize()} loses effect beyond a certain deflection",
        equation=(
            f"{target} += slope e^2/(e + width) sign({surface}), e = |{surface}| beyond onset"
        ),
        target=target,
        reads=(surface,),
        parameters=(
            Parameter(
                name="slope",
                unit="",
                default=default,
                bounds=(-20.0, 20.0),
                description="final change of the effectiveness, per radian",
            ),
            Parameter(
                name="onset",
                unit="rad",
                default=0.15,
                bounds=(0.0, 1.0),
                neutral=0.15,
                description="deflection at which the loss begins",
            ),
            Parameter(
                name="width",
                unit="rad",
                default=0.05,
                bounds=(1e-3, 1.0),
                neutral=0.05,
                description="deflection beyond the onset at which half of the slope is reached",
                free=False,
            ),
        ),
    )
    register_effect(term.id, lambda _: term)


def _register_speed_effect(target: str, coefficient_title: str, default: float) -> None:
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
            _V_REF,
        ),
    )
    register_effect(term.id, lambda _: term)


def _register_unsteady(target: str, default: float) -> None:
    term = UnsteadyTerm(
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
    register_effect(term.id, lambda _: term)


# --- stall --------------------------------------------------------------------------------------


def _stall_factory(target: str, default: float, *, even: bool, words: str) -> TermFactory:
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
        equation="N += imbalance y T, so Cn += imbalance y T/(qbar S b)",
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


def _thrust_error(aircraft: Aircraft) -> Term:
    propulsion = aircraft.propulsion
    return ThrustErrorTerm(
        id="propulsion.thrust.scale",
        title="Engines give less (or more) thrust than the aircraft file says",
        equation="T += error T",
        target="thrust",
        reads=("throttle", "rho", "V"),
        per_density=propulsion.max_thrust / SEA_LEVEL_DENSITY,
        zero_thrust_speed=propulsion.zero_thrust_speed,
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


def _thrust_product(
    term_id: str,
    title: str,
    equation: str,
    target: str,
    parameter: Parameter,
    scale: float = 1.0,
) -> None:
    """Enter an effect that is one parameter times the thrust."""
    term = Monomial(
        id=term_id,
        title=title,
        equation=equation,
        target=target,
        reads=("thrust",),
        powers=(1,),
        scale=scale,
        parameters=(parameter,),
    )
    register_effect(term.id, lambda _: term)


def _register_thrust() -> None:
    _thrust_product(
        "propulsion.CZ.throttle",
        "Thrust line points up: throttle lifts",
        "Z += -tilt T, so CZ += -tilt T/(qbar S)",
        "Z",
        Parameter(
            name="tilt",
            unit="rad",
            default=0.06,
            bounds=(-0.5, 0.5),
            description="angle of the thrust line, nose up positive",
        ),
        scale=-1.0,
    )
    _thrust_product(
        "propulsion.Cl.throttle",
        "Throttle rolls the aircraft (torque of the engines)",
        "L += arm T, so Cl += arm T/(qbar S b)",
        "L",
        Parameter(
            name="arm",
            unit="m",
            default=0.01,
            bounds=(-0.5, 0.5),
            description="rolling moment over thrust",
        ),
    )
    _monomial(
        "Cm",
        "slipstream",
        [("throttle", 1)],
        0.02,
        "Throttle changes the flow over the tail: pitches alike at every speed",
        group="propulsion",
    )
    fade = ThrustSpeedTerm(
        id="propulsion.thrust.speed",
        title="Thrust falls with speed otherwise than the aircraft file says",
        equation="X += fade T (V/V_ref - 1)",
        target="X",
        reads=("thrust", "V"),
        parameters=(
            Parameter(
                name="fade",
                unit="",
                default=-0.3,
                bounds=(-3.0, 3.0),
                description="share of the thrust that is lost more when the speed doubles",
            ),
            _V_REF,
        ),
    )
    register_effect(fade.id, lambda _: fade)
    late = UnsteadyTerm(
        id="propulsion.thrust.lag",
        title="Engines follow the throttle later than the aircraft file says",
        equation="X += share (x - T), x' = (T - x)/tau",
        target="X",
        reads=("thrust",),
        states=("x",),
        scale=-1.0,
        parameters=(
            Parameter(
                name="share",
                unit="",
                default=1.0,
                bounds=(-1.0, 2.0),
                description="share of the thrust that comes late",
            ),
            Parameter(
                name="tau",
                unit="s",
                default=0.4,
                bounds=(0.02, 5.0),
                neutral=0.4,
                description="time constant beyond the aircraft file's",
            ),
        ),
    )
    register_effect(late.id, lambda _: late)


def _register_offset(
    term_id: str, target: str, unit: str, size: Callable[[Aircraft], float], title: str
) -> None:
    """Enter a value of the aircraft file in error, by `size` where nothing else is said."""
    name = target.rpartition(".")[2] if "." in target else "error"

    def make(aircraft: Aircraft) -> Term:
        default = size(aircraft)
        bound = 20.0 * abs(default)
        return OffsetTerm(
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

    register_effect(term_id, make)


def _register_mass() -> None:
    _register_offset(
        "mass.cg.x",
        "cg.x",
        "m",
        lambda aircraft: 0.05 * aircraft.geometry.chord,
        "Center of gravity lies further forward or aft",
    )
    _register_offset(
        "mass.cg.y",
        "cg.y",
        "m",
        lambda aircraft: 0.005 * aircraft.geometry.span,
        "Center of gravity lies to one side",
    )
    _register_offset(
        "mass.cg.z",
        "cg.z",
        "m",
        lambda aircraft: 0.05 * aircraft.geometry.chord,
        "Center of gravity lies higher or lower",
    )
    _register_offset(
        "mass.mass.error",
        "mass",
        "kg",
        lambda aircraft: -0.05 * aircraft.mass.mass,
        "Mass differs from the aircraft file",
    )
    _register_offset(
        "mass.inertia.ixx",
        "ixx",
        "kg*m^2",
        lambda aircraft: 0.1 * aircraft.mass.ixx,
        "Roll inertia differs",
    )
    _register_offset(
        "mass.inertia.iyy",
        "iyy",
        "kg*m^2",
        lambda aircraft: 0.1 * aircraft.mass.iyy,
        "Pitch inertia differs",
    )
    _register_offset(
        "mass.inertia.izz",
        "izz",
        "kg*m^2",
        lambda aircraft: 0.1 * aircraft.mass.izz,
        "Yaw inertia differs",
    )
    _register_offset(
        "mass.inertia.ixz",
        "ixz",
        "kg*m^2",
        lambda aircraft: 0.1 * aircraft.mass.ixx,
        "Roll and yaw are coupled by the mass",
    )


_POSITION_TITLES = {
    "alpha_vane": "Alpha vane",
    "beta_vane": "Beta vane",
    "accelerometer": "Accelerometer",
    "air_data": "Pitot tube",
}
_AXIS_TITLES = {"x": "further forward or aft", "y": "to one side", "z": "higher or lower"}
_POSITION_AXES = (
    ("alpha_vane", "xy"), ("beta_vane", "xz"), ("accelerometer", "xyz"), ("air_data", "yz"),
)  # fmt: skip
"""The axes along which a place shows: a pitot tube further forward sees the same speed."""


def _of_span(share: float) -> Callable[[Aircraft], float]:
    return lambda aircraft: share * aircraft.geometry.span


def _register_positions() -> None:
    for instrument, axes in _POSITION_AXES:
        far = 0.02 if instrument == "accelerometer" else 0.1
        for axis in axes:
            target = f"place.{instrument}.{axis}"
            _register_offset(
                f"sensor.{instrument}.{axis}",
                target,
                "m",
                _of_span(far),
                f"{_POSITION_TITLES[instrument]} sits {_AXIS_TITLES[axis]} than the aircraft "
                "file says",
            )


_register_polynomials()
_register_surfaces()
_register_damping()
_register_linear()
_register_speed_effect("CX", "Axial force", 0.03)
_register_speed_effect("CZ", "Lift", -0.15)
_register_speed_effect("Cm", "Pitching moment", 0.04)
_register_unsteady("Cm", -0.8)
_register_unsteady("CN", 0.8)
register_effect(
    "aero.CN.stall", _stall_factory("CN", -4.6, even=False, words="the wing stops lifting")
)
register_effect("aero.CA.stall", _stall_factory("CA", 1.6, even=True, words="the drag rises"))
register_effect("aero.Cm.stall", _stall_factory("Cm", -0.6, even=False, words="the nose drops"))
register_effect("propulsion.Cm.throttle", _throttle_pitch)
register_effect("propulsion.Cn.asymmetry", _asymmetric_thrust)
register_effect("propulsion.thrust.scale", _thrust_error)
_register_thrust()
_register_mass()
_register_positions()

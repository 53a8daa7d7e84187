"""Effects of the engines."""

from __future__ import annotations

from gsapp.aircraft import Aircraft
from gsapp.dynamics.atmosphere import SEA_LEVEL_DENSITY
from gsapp.dynamics.effect_terms import ThrustErrorTerm, ThrustSpeedTerm, UnsteadyTerm
from gsapp.dynamics.effects.effect_registration import V_REF, register_monomial, register_term
from gsapp.dynamics.terms import EffectGuidance, Monomial, Parameter, Term, register_effect

_STEPS = "throttle steps with the wings level at low and at high speed, elevator held"


def _guidance(
    mistaken_for: tuple[str, ...],
    separated_by: str,
    source: str,
    needs: tuple[str, ...] = ("throttle",),
    variant_of: str = "",
) -> EffectGuidance:
    return EffectGuidance(
        mistaken_for=mistaken_for,
        separated_by=separated_by,
        needs=needs,
        source=source,
        variant_of=variant_of,
    )


def _thrust_product(
    term_id: str,
    title: str,
    equation: str,
    target: str,
    parameter: Parameter,
    scale: float = 1.0,
) -> Term:
    """Return one parameter times the thrust."""
    return Monomial(
        id=term_id,
        title=title,
        equation=equation,
        target=target,
        reads=("thrust",),
        powers=(1,),
        scale=scale,
        parameters=(parameter,),
    )


register_term(
    _thrust_product(
        "propulsion.Cm.throttle",
        "Throttle pitches the nose up, most at low speed",
        "M += arm T, so Cm += arm T/(qbar S c)",
        "M",
        Parameter(
            "arm",
            "m",
            0.05,
            (-0.5, 0.5),
            "height of the CG above the thrust line, beyond the aircraft file's",
        ),
    ),
    _guidance(
        ("propulsion.Cm.slipstream", "aero.Cm.speed", "mass.cg.z", "aero.Cm.alpha2"),
        f"{_STEPS}: a thrust line off the center of gravity counts as 1/V^2",
        "Seanor, flight tests: high throttle at low airspeed pitches the nose up",
    ),
)
register_monomial(
    "Cm",
    "slipstream",
    [("throttle", 1)],
    0.02,
    "Throttle changes the flow over the tail: same pitching moment coefficient at every speed",
    _guidance(
        ("propulsion.Cm.throttle", "aero.Cm.speed"),
        f"{_STEPS}: the flow over the tail counts alike at both",
        "flow of the fans over the tail",
        variant_of="propulsion.Cm.throttle",
    ),
    group="propulsion",
)


def _asymmetric_thrust(aircraft: Aircraft) -> Term:
    distance = max((abs(y) for _, y, _ in aircraft.propulsion.position), default=0.0)
    return _thrust_product(
        "propulsion.Cn.asymmetry",
        "Engines differ: throttle turns the nose",
        "N += imbalance y T, so Cn += imbalance y T/(qbar S b)",
        "N",
        Parameter(
            "imbalance",
            "",
            0.15,
            (-1.0, 1.0),
            "left thrust minus right over their sum; positive: nose right",
        ),
        scale=distance or 0.1 * aircraft.geometry.span,
    )


register_effect(
    "propulsion.Cn.asymmetry",
    _asymmetric_thrust,
    _guidance(
        ("aero.Cn.alpha", "sensor.beta.bias"),
        "throttle steps with the wings level, rudder and aileron held, at low speed; rpm of both "
        "engines recorded",
        "Seanor, flight tests: engine rpm imbalance shows up as yaw",
    ),
)
register_term(
    _thrust_product(
        "propulsion.CZ.throttle",
        "Thrust line points up: throttle lifts",
        "Z += -tilt T, so CZ += -tilt T/(qbar S)",
        "Z",
        Parameter("tilt", "rad", 0.06, (-0.5, 0.5), "angle of the thrust line, nose up positive"),
        scale=-1.0,
    ),
    _guidance(
        ("aero.CZ.speed", "propulsion.Cm.throttle", "aero.CN.alpha2"),
        f"{_STEPS}, angle of attack read before and after",
        "thrust line not along x",
    ),
)
register_term(
    _thrust_product(
        "propulsion.Cl.throttle",
        "Throttle rolls the aircraft (torque of the engines)",
        "L += arm T, so Cl += arm T/(qbar S b)",
        "L",
        Parameter("arm", "m", 0.01, (-0.5, 0.5), "rolling moment over thrust"),
    ),
    _guidance(
        ("aero.Cl.alpha", "propulsion.Cn.asymmetry"),
        "throttle steps with the wings level, aileron held",
        "reaction of the engines' torque",
    ),
)


def _thrust_error(aircraft: Aircraft) -> Term:
    propulsion = aircraft.propulsion
    return ThrustErrorTerm(
        id="propulsion.thrust.scale",
        title="Thrust differs from the aircraft file",
        equation="T += error T",
        target="thrust",
        reads=("throttle", "rho", "V"),
        per_density=propulsion.max_thrust / SEA_LEVEL_DENSITY,
        zero_thrust_speed=propulsion.zero_thrust_speed,
        parameters=(
            Parameter("error", "", -0.15, (-1.0, 1.0), "relative difference of the thrust"),
        ),
    )


register_effect(
    "propulsion.thrust.scale",
    _thrust_error,
    _guidance(
        ("aero.CX.speed", "propulsion.thrust.speed", "sensor.ax.scale"),
        "level accelerations from idle to full throttle and a glide with idling engines; a "
        "static pull with a spring scale determines it",
        "Seanor, section 3: two fans of about 12 lb each",
    ),
)
register_term(
    ThrustSpeedTerm(
        id="propulsion.thrust.speed",
        title="Thrust variation with speed differs from the aircraft file",
        equation="X += fade T (V/V_ref - 1)",
        target="X",
        reads=("thrust", "V"),
        parameters=(
            Parameter(
                "fade",
                "",
                -0.3,
                (-3.0, 3.0),
                "additional relative loss of thrust when the speed doubles",
            ),
            V_REF,
        ),
    ),
    _guidance(
        ("aero.CX.speed", "propulsion.thrust.scale"),
        "throttle steps at two speeds, one half as fast again, a glide with idling engines",
        "aircraft file: zero_thrust_speed is often assumed",
        needs=("throttle", "V"),
    ),
)
register_term(
    UnsteadyTerm(
        id="propulsion.thrust.lag",
        title="Engine lag is longer than in the aircraft file",
        equation="X += share (x - T), x' = (T - x)/tau",
        target="X",
        reads=("thrust",),
        states=("x",),
        scale=-1.0,
        parameters=(
            Parameter("share", "", 1.0, (-1.0, 2.0), "lagged share of the thrust"),
            Parameter(
                "tau",
                "s",
                0.4,
                (0.02, 5.0),
                "time constant beyond the aircraft file's",
                neutral=0.4,
            ),
        ),
    ),
    _guidance(
        ("propulsion.thrust.scale", "sensor.ax.lag"),
        "throttle steps and throttle doublets, rpm recorded",
        "aircraft file: lag of the engines is often assumed",
    ),
)

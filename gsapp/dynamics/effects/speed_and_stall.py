"""Aerodynamic effects of speed, flap, unsteady flow, and stall."""

from __future__ import annotations

from gsapp.aircraft import Aircraft
from gsapp.dynamics.buildup import COEFFICIENT_TITLES
from gsapp.dynamics.effect_terms import STALL_SHAPE, SpeedTerm, StallTerm, UnsteadyTerm
from gsapp.dynamics.effects.effect_registration import (
    BEYOND,
    V_REF,
    register_monomial,
    register_term,
)
from gsapp.dynamics.terms import EffectGuidance, Parameter, Term, TermFactory, register_effect

# --- speed and flap -----------------------------------------------------------------------------

_SPEEDS = (
    "level accelerations and decelerations at constant throttle, and the same doublet at "
    "three speeds, each a fifth faster"
)
for _target, _word, _size, _alike, _maneuver, _source in (
    (
        "CX",
        "Axial force",
        0.03,
        ("propulsion.thrust.speed", "propulsion.thrust.scale", "aero.CA.alpha2"),
        f"{_SPEEDS}; a glide with idling engines tells drag from thrust",
        "Seanor, appendix A: X_u and X_Tu",
    ),
    (
        "CZ",
        "Lift",
        -0.15,
        ("propulsion.CZ.throttle", "aero.CN.alpha2", "sensor.qbar.scale"),
        _SPEEDS,
        BEYOND,
    ),
    (
        "Cm",
        "Pitching moment",
        0.04,
        ("aero.Cm.alphadot", "propulsion.Cm.throttle", "aero.Cm.alpha2"),
        f"{_SPEEDS}; throttle steps at constant speed tell thrust from speed",
        "a missing speed derivative looks like alpha' damping in a fit",
    ),
):
    register_term(
        SpeedTerm(
            id=f"aero.{_target}.speed",
            title=f"{_word} changes with speed",
            equation=f"{_target} += {_target}_V (V/V_ref - 1)",
            target=_target,
            reads=("V",),
            parameters=(
                Parameter(
                    f"{_target}_V",
                    "",
                    _size,
                    (-5.0, 5.0),
                    "change of the coefficient when the speed doubles",
                ),
                V_REF,
            ),
        ),
        EffectGuidance(
            mistaken_for=_alike,
            separated_by=_maneuver,
            needs=("V",),
            source=_source,
        ),
    )
for _target, _size, _like in (
    ("Cm", -0.08, "aero.Cm.speed"),
    ("CN", 0.6, "aero.CZ.speed"),
    ("CA", 0.06, "aero.CX.speed"),
):
    register_monomial(
        _target,
        "flap",
        [("flap", 1)],
        _size,
        f"Flap changes the {COEFFICIENT_TITLES[_target]}",
        EffectGuidance(
            mistaken_for=(_like, f"aero.{_target}.alpha2"),
            separated_by="flap down and up again at constant speed and throttle, wings level, "
            "between doublets of the same kind with either setting",
            needs=("flap",),
            source="Seanor, flight tests: flaps change trim",
        ),
    )

# --- unsteady flow ------------------------------------------------------------------------------

register_monomial(
    "Cm",
    "alphadot",
    [("alpha_dot_hat", 1)],
    -8.0,
    "Downwash lag at the tail: damping by the rate of angle of attack",
    EffectGuidance(
        mistaken_for=("aero.Cm.speed", "aero.Cm.memory", "aero.Cm.q", "sensor.alpha.delay"),
        separated_by="maneuvers in which q and alpha' differ: slow and quick doublets, and "
        "rolls with elevator held; short doublets about level flight hardly "
        "separate them",
        source="Seanor, appendix A: M_adot; downwash lag at the tail",
    ),
)
for _target, _size, _alike in (
    ("Cm", -0.8, ("aero.Cm.alphadot", "control.elevator.lag", "sensor.alpha.lag")),
    ("CN", 0.8, ("aero.CN.q", "sensor.an.lag", "sensor.alpha.lag")),
):
    register_term(
        UnsteadyTerm(
            id=f"aero.{_target}.memory",
            title="Unsteady flow (first-order lag)",
            equation=f"{_target} += {_target}_memory (alpha - x), x' = (alpha - x)/tau",
            target=_target,
            reads=("alpha",),
            states=("x",),
            parameters=(
                Parameter(
                    f"{_target}_memory",
                    "",
                    _size,
                    (-50.0, 50.0),
                    "lagged part of the coefficient, per radian",
                ),
                Parameter("tau", "s", 0.1, (0.005, 2.0), "time constant", neutral=0.1),
            ),
        ),
        EffectGuidance(
            mistaken_for=_alike,
            separated_by="doublets of very different step times (0.15 to 1 s)",
            source="indicial lift: one lag of the flow",
            decoy=True,
        ),
    )


# --- stall --------------------------------------------------------------------------------------

_SHAPE = "tau1 X' + X = (1 - tanh(a1 (alpha - tau2 alpha' - alpha_star)))/2"


def _stall_factory(
    target: str, default: float, bounds: tuple[float, float], text: str
) -> TermFactory:
    def make(aircraft: Aircraft) -> Term:
        lift = target == "CN"
        part = "alpha (1 - ((1 + sqrt X)/2)^2)" if lift else "(1 - X)"
        return StallTerm(
            id=f"aero.{target}.stall",
            title=f"Stall: {text}",
            equation=f"{target} += {target}_stall {part}, {_SHAPE}",
            target=target,
            reads=("alpha", "V", "alpha_dot_hat"),
            rate_only_reads=("alpha_dot_hat",),
            states=("X",),
            shared_parameters=STALL_SHAPE,
            shape="lift" if lift else "separation",
            chord=aircraft.geometry.chord,
            parameters=(
                Parameter(
                    f"{target}_stall",
                    "",
                    default,
                    bounds,
                    "lift slope that is lost, -CN_alpha in theory, per radian"
                    if lift
                    else "change of the coefficient when all of the flow has separated",
                ),
                *_shape_parameters(aircraft),
            ),
        )

    return make


def _shape_parameters(aircraft: Aircraft) -> tuple[Parameter, ...]:
    angle = aircraft.limits.alpha_stall
    return tuple(
        Parameter(name, unit, value, bounds, text, neutral=value)
        for name, unit, value, bounds, text in (
            ("a1", "", 20.0, (8.0, 100.0), "abruptness of the separation, per radian"),
            (
                "alpha_star",
                "rad",
                angle,
                (0.1, 0.8),
                "angle of attack at which half of the flow has separated",
            ),
            ("tau1", "s", 0.2, (0.02, 5.0), "time constant with which the flow follows"),
            ("tau2", "s", 0.1, (0.0, 5.0), "delay of the separation by alpha'"),
        )
    )


for _target, _size, _bounds, _words in (
    ("CN", -4.6, (-20.0, 0.0), "the wing stops lifting"),
    ("CA", 0.15, (-5.0, 5.0), "the drag rises"),
    ("Cm", -0.15, (-5.0, 5.0), "the nose drops"),
):
    register_effect(
        f"aero.{_target}.stall",
        _stall_factory(_target, _size, _bounds, _words),
        EffectGuidance(
            mistaken_for=(f"aero.{_target}.alpha2", "sensor.alpha.clipping"),
            separated_by="a slow deceleration with the wings level until the break and back, with "
            "height to spare, twice, and doublets that stay within the linear range",
            source="Goman, Khrabrov, J. Aircraft 31, 1994; Jategaonkar, Flight Vehicle System "
            "Identification, 2015, chapter 12",
            beyond_linear_alpha=True,
        ),
    )

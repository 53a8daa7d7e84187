"""Aerodynamic effects of speed, flap, unsteady flow, and stall."""

from __future__ import annotations

import math

from gsapp.aircraft import Aircraft
from gsapp.dynamics.buildup import COEFFICIENT_TITLES
from gsapp.dynamics.effect_terms import SpeedTerm, StallTerm, UnsteadyTerm
from gsapp.dynamics.effects.effect_registration import (
    BEYOND,
    V_REF,
    held_parameter,
    register_monomial,
    register_term,
)
from gsapp.dynamics.terms import EffectGuidance, Parameter, Term, TermFactory, register_effect

# --- speed and flap -----------------------------------------------------------------------------

_SPEEDS = (
    "level accelerations and decelerations at constant throttle, and the same doublet at "
    "80 ft/s, 100 ft/s and 120 ft/s"
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
                    "slope", "", default, (-20.0, 20.0), "final slope of the departure, per radian"
                ),
                held_parameter(
                    "width",
                    "rad",
                    0.06,
                    (1e-3, 1.0),
                    "excess at which half of the final slope is reached",
                ),
                held_parameter("alpha_low", "rad", low, limit, "lower end of the linear range"),
                held_parameter("alpha_high", "rad", high, limit, "upper end of the linear range"),
            ),
        )

    return make


for _target, _size, _even, _words in (
    ("CN", -4.6, False, "the wing stops lifting"),
    ("CA", 1.6, True, "the drag rises"),
    ("Cm", -0.6, False, "the nose drops"),
):
    register_effect(
        f"aero.{_target}.stall",
        _stall_factory(_target, _size, even=_even, words=_words),
        EffectGuidance(
            mistaken_for=(f"aero.{_target}.alpha2", "sensor.alpha.clipping"),
            separated_by="a slow deceleration with the wings level until the break, with height "
            "to spare, and doublets that stay within the linear range",
            source="departure beyond the linear range of the aircraft file",
            variant_of=f"aero.{_target}.alpha2",
        ),
    )

"""Aerodynamic effects of second and third order: curves, surfaces, damping, sideslip."""

from __future__ import annotations

from gsapp.dynamics.buildup import COEFFICIENT_TITLES
from gsapp.dynamics.effect_terms import EffectivenessLossTerm
from gsapp.dynamics.effects.effect_registration import (
    BEYOND,
    SURFACE_NAMES,
    VARIABLE_TITLES,
    coefficient_title,
    held_parameter,
    register_monomial,
    register_term,
)
from gsapp.dynamics.terms import EffectGuidance, Parameter

_SURFACE_RATE = {"de": "q", "da": "p", "dr": "r"}
_MAIN_SURFACE = {"Cm": "de", "Cl": "da", "Cn": "dr"}


# --- curves over angle of attack and sideslip ---------------------------------------------------

_SLOW = (
    "pull-ups and push-overs to both ends of the linear range, begun at two trim speeds: a "
    "curve follows alpha whatever the speed"
)
for _target, _size, _alike, _maneuver, _source in (
    (
        "Cm",
        -2.0,
        ("aero.Cm.alpha_q", "aero.Cm.alpha_de", "aero.Cm.speed", "aero.Cm.stall", "aero.Cm.beta2"),
        f"{_SLOW}; small and large doublets at one trim",
        BEYOND,
    ),
    (
        "CN",
        6.0,
        ("aero.CN.alpha_q", "aero.CZ.speed", "aero.CN.stall", "sensor.an.scale"),
        _SLOW,
        BEYOND,
    ),
    (
        "CA",
        2.0,
        ("aero.CA.de2", "aero.CA.alpha_de", "aero.CX.speed", "aero.CA.stall"),
        f"{_SLOW}, at constant throttle",
        "induced drag: the axial force falls with alpha squared",
    ),
):
    register_monomial(
        _target,
        "alpha2",
        [("alpha", 2)],
        _size,
        f"{coefficient_title(_target)} varies nonlinearly with angle of attack",
        EffectGuidance(mistaken_for=_alike, separated_by=_maneuver, source=_source),
    )
for _target, _size in (("Cl", -1.5), ("Cn", 0.8), ("CY", -1.0)):
    register_monomial(
        _target,
        "alpha_beta",
        [("alpha", 1), ("beta", 1)],
        _size,
        f"{coefficient_title(_target)} from sideslip changes with angle of attack",
        EffectGuidance(
            mistaken_for=(
                f"aero.{_target}.alpha_p",
                f"aero.{_target}.beta3",
                f"aero.{_target}.alpha_r",
            ),
            separated_by="rudder doublets, and steady sideslips, at three trim angles of attack "
            "(speeds)",
            source="swept wing: dihedral effect grows with lift (sweep 27 deg, table 3.2.1)",
        ),
    )
for _target, _size in (("Cl", 2.0), ("Cn", 1.5), ("CY", -3.0)):
    register_monomial(
        _target,
        "beta3",
        [("beta", 3)],
        _size,
        f"{coefficient_title(_target)} stiffens or softens at large sideslip",
        EffectGuidance(
            mistaken_for=(
                f"aero.{_target}.alpha_beta",
                f"aero.{_target}.dr3",
                "sensor.beta.clipping",
            ),
            separated_by="steady sideslips of growing size to both sides, and rudder doublets of "
            "quarter, half and full stick",
            source=BEYOND,
        ),
    )
for _target, _size, _title in (
    ("Cm", -0.6, "Sideslip pitches the nose"),
    ("CN", -1.0, "Sideslip reduces lift (both sides)"),
    ("CA", 0.5, "Sideslip adds drag (both sides)"),
):
    register_monomial(
        _target,
        "beta2",
        [("beta", 2)],
        _size,
        _title,
        EffectGuidance(
            mistaken_for=(f"aero.{_target}.beta", f"aero.{_target}.alpha2"),
            separated_by="steady sideslips to both sides at constant speed, elevator noted: an "
            "even effect has the same sign to either side",
            source="tail in the wake of the body at sideslip",
        ),
    )


# --- effectiveness of surfaces ------------------------------------------------------------------

_CUBIC_SIZES = {
    ("Cm", "de"): 2.5,
    ("CN", "de"): -1.0,
    ("Cl", "da"): -0.9,
    ("Cn", "da"): -0.1,
    ("Cn", "dr"): 0.15,
    ("Cl", "dr"): -0.05,
    ("CY", "dr"): -0.3,
}
for (_target, _surface), _size in _CUBIC_SIZES.items():
    _word = SURFACE_NAMES[_surface]
    _loss = "effect" if _MAIN_SURFACE.get(_target) == _surface else COEFFICIENT_TITLES[_target]
    register_monomial(
        _target,
        f"{_surface}3",
        [(_surface, 3)],
        _size,
        f"{_word.capitalize()} loses {_loss} at large deflection",
        EffectGuidance(
            mistaken_for=(
                f"aero.{_target}.alpha_{_surface}",
                f"control.{_word}.saturation",
                f"control.{_word}.rate",
                f"control.{_word}.backlash",
            ),
            separated_by=f"{_word} doublets of quarter, half and full stick from the same trim",
            needs=(_surface,),
            source=f"Seanor, flight tests: doublets too large become nonlinear; {BEYOND}",
        ),
    )


def _effectiveness_aliases(target: str, surface: str) -> tuple[str, ...]:
    speed = {"Cm": ("aero.Cm.speed",), "CN": ("aero.CZ.speed",), "CA": ("aero.CX.speed",)}
    cubic = (target, surface) in _CUBIC_SIZES and (target, surface) != ("Cn", "da")
    return (
        *(() if target == "CA" else (f"aero.{target}.alpha_{_SURFACE_RATE[surface]}",)),
        *((f"aero.{target}.{surface}3",) if cubic else ()),
        *speed.get(target, ()),
    )


for _target, _surface, _size in (
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
    _word = SURFACE_NAMES[_surface]
    _own = (
        "" if _MAIN_SURFACE.get(_target) == _surface else f" on the {COEFFICIENT_TITLES[_target]}"
    )
    register_monomial(
        _target,
        f"alpha_{_surface}",
        [("alpha", 1), (_surface, 1)],
        _size,
        f"{_word.capitalize()} effect{_own} changes with angle of attack",
        EffectGuidance(
            mistaken_for=_effectiveness_aliases(_target, _surface),
            separated_by=f"the same {_word} doublet at three trim angles of attack (speeds), "
            "small enough to stay linear in each",
            needs=(_surface,),
            source=f"{BEYOND}; Seanor, flight tests from 80 to 120 ft/s",
        ),
    )
register_monomial(
    "CA",
    "de2",
    [("de", 2)],
    0.3,
    "Elevator deflection adds drag (both directions)",
    EffectGuidance(
        mistaken_for=("aero.CA.alpha2", "aero.CA.alpha_de"),
        separated_by="elevator doublets of several sizes at one trim: drag rises to both sides",
        needs=("de",),
        source="drag of a deflected surface rises with its square",
    ),
)
for _target, _surface, _size in (("Cm", "de", 0.9), ("Cl", "da", -0.32), ("Cn", "dr", 0.055)):
    _word = SURFACE_NAMES[_surface]
    register_term(
        EffectivenessLossTerm(
            id=f"aero.{_target}.{_surface}_falloff",
            title=f"{_word.capitalize()} loses effectiveness beyond a certain deflection",
            equation=f"{_target} += slope e^2/(e + width) sign({_surface}), "
            f"e = |{_surface}| beyond onset",
            target=_target,
            reads=(_surface,),
            parameters=(
                Parameter(
                    "slope",
                    "",
                    _size,
                    (-20.0, 20.0),
                    "final change of the effectiveness, per radian",
                ),
                Parameter(
                    "onset",
                    "rad",
                    0.15,
                    (0.0, 1.0),
                    "deflection at which the loss begins",
                    neutral=0.15,
                ),
                held_parameter(
                    "width",
                    "rad",
                    0.05,
                    (1e-3, 1.0),
                    "deflection beyond the onset at which half of the slope is reached",
                ),
            ),
        ),
        EffectGuidance(
            mistaken_for=(f"aero.{_target}.{_surface}3", f"control.{_word}.saturation"),
            separated_by=f"{_word} doublets in five sizes from the same trim show where the effect "
            "begins to fall off",
            needs=(_surface,),
            source="separation on a plain flap beyond 10 to 15 deg of deflection",
            variant_of=f"aero.{_target}.{_surface}3",
        ),
    )


# --- damping ------------------------------------------------------------------------------------

_RATE_SURFACE = {rate: surface for surface, rate in _SURFACE_RATE.items()}
for _target, _rate, _size in (
    ("Cm", "q", 60.0),
    ("CN", "q", 20.0),
    ("Cl", "p", 3.0),
    ("Cn", "p", -1.0),
    ("CY", "p", 1.0),
    ("Cl", "r", 1.5),
    ("Cn", "r", -1.0),
    ("CY", "r", 1.0),
):
    _surface = _RATE_SURFACE[_rate]
    _title = VARIABLE_TITLES[f"{_rate}_hat"]
    register_monomial(
        _target,
        f"alpha_{_rate}",
        [("alpha", 1), (f"{_rate}_hat", 1)],
        _size,
        f"{_title.capitalize().removesuffix(' rate')} damping changes with angle of attack"
        if _MAIN_SURFACE.get(_target) == _surface
        else f"{coefficient_title(_target)} from {_title} changes with angle of attack",
        EffectGuidance(
            mistaken_for=(
                *((f"aero.{_target}.alpha2",) if _rate == "q" else ()),
                *((f"aero.{_target}.alpha_beta",) if _rate == "p" else ()),
                f"aero.{_target}.alpha_{_surface}",
                *((f"aero.{_target}.alpha_beta",) if _rate == "r" else ()),
                *(("aero.Cm.alphadot",) if _target == "Cm" else ()),
            ),
            separated_by=f"the same {SURFACE_NAMES[_surface]} doublet at three trim angles of "
            "attack (speeds)",
            source="strip theory: Cl_r and Cn_p grow with the lift coefficient"
            if (_target, _rate) in {("Cl", "r"), ("Cn", "p")}
            else BEYOND,
        ),
    )

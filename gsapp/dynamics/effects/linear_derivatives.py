"""Every linear derivative as an effect, and those that couple the two planes of motion."""

from __future__ import annotations

from gsapp.dynamics.buildup import linear_variables
from gsapp.dynamics.effects.effect_registration import (
    LONGITUDINAL,
    SURFACE_NAMES,
    VARIABLE_TITLES,
    coefficient_title,
    register_monomial,
)
from gsapp.dynamics.terms import COEFFICIENTS, EffectGuidance

_SIZES = {
    "CN": {"alpha": 0.5, "q": 3.0, "de": 0.1},
    "CA": {"alpha": 0.1, "q": 0.5, "de": 0.05},
    "Cm": {"alpha": -0.1, "q": -5.0, "de": -0.2},
    "CY": {"beta": -0.1, "p": 0.1, "r": 0.2, "da": 0.05, "dr": 0.05},
    "Cl": {"beta": -0.05, "p": -0.2, "r": 0.1, "da": 0.05, "dr": 0.02},
    "Cn": {"beta": 0.03, "p": -0.06, "r": -0.1, "da": 0.01, "dr": -0.02},
}
_CROSS_SIZES = {"alpha": 0.05, "beta": 0.05, "p": 0.3, "q": 1.0, "r": 0.3}
_CROSS_SURFACE = 0.03
_MANEUVERS = {
    "alpha": "elevator doublets at several amplitudes, and slow pull-ups",
    "q": "elevator doublets of different step times, to separate q and alpha in phase",
    "de": "elevator doublets from trim; a 3-2-1-1 separates the elevator from alpha and q",
    "beta": "rudder doublets, and a steady sideslip to either side",
    "p": "aileron doublets; combined aileron and rudder doublets separate p from beta and r",
    "r": "rudder doublets; combined aileron and rudder doublets separate r from beta and p",
    "da": "aileron doublets, combined with rudder doublets that do not coincide",
    "dr": "rudder doublets, combined with aileron doublets that do not coincide",
}
_SPIN = {
    ("Cn", "q"): "what the spin of the engines does to pitching",
    ("Cm", "r"): "what the spin of the engines does to yawing",
}


def _guidance(target: str, suffix: str) -> EffectGuidance:
    return EffectGuidance(
        mistaken_for=_others(target, suffix, linear_variables(target)),
        separated_by=_MANEUVERS[suffix],
        needs=(suffix,) if suffix in SURFACE_NAMES else (),
        source="Seanor, (4.2.1)-(4.2.6); free or held as in tables 6.2.5 and 6.2.6",
        derivative=f"{target}_{suffix}",
    )


def _cross_guidance(target: str, suffix: str) -> EffectGuidance:
    """Return what tells an asymmetry by which one plane of motion drives the other."""
    if (target, suffix) == ("Cl", "alpha"):
        return EffectGuidance(
            mistaken_for=("mass.cg.y", "propulsion.Cl.throttle", "aero.Cl.q", "aero.Cl.de"),
            separated_by="slow pull-ups and push-overs with aileron and rudder still, at two "
            "speeds; weighing both wheels of the main gear determines the center "
            "of gravity",
            source="Seanor, flight tests: unequal dihedral gives Cl_0 and Cn_0",
        )
    others = _others(target, suffix, linear_variables("CY" if target in LONGITUDINAL else "CN"))
    if (target, suffix) == ("Cn", "alpha"):
        others = ("propulsion.Cn.asymmetry", *others)
    still = (
        "to the left as often as to the right and with the sticks of the other axes still"
        if target in LONGITUDINAL
        else "with aileron and rudder still"
    )
    separated_by = f"{_MANEUVERS[suffix]}, {still}"
    source = "Seanor, flight tests: unequal sides; Etkin and Reid, coupling derivatives"
    if (target, suffix) in _SPIN:
        separated_by += (
            f"; at two throttle settings, because {_SPIN[target, suffix]} grows with rpm"
        )
        source += "; the engines' angular momentum looks like this"
    return EffectGuidance(
        mistaken_for=others,
        separated_by=separated_by,
        needs=(suffix,) if suffix in SURFACE_NAMES else (),
        source=source,
    )


def _others(target: str, suffix: str, variables: dict[str, str]) -> tuple[str, ...]:
    return tuple(f"aero.{target}.{other}" for other in variables if other != suffix)


for _target in COEFFICIENTS:
    _name = coefficient_title(_target)
    for _suffix, _variable in linear_variables(_target).items():
        register_monomial(
            _target,
            _suffix,
            [(_variable, 1)],
            _SIZES[_target][_suffix],
            f"{_name} from {VARIABLE_TITLES[_variable]} is missing",
            _guidance(_target, _suffix),
        )
    for _suffix, _variable in linear_variables("CY" if _target in LONGITUDINAL else "CN").items():
        register_monomial(
            _target,
            _suffix,
            [(_variable, 1)],
            _CROSS_SIZES.get(_suffix, _CROSS_SURFACE),
            "Left and right wing differ: roll with alpha"
            if (_target, _suffix) == ("Cl", "alpha")
            else f"{_name} from {VARIABLE_TITLES[_variable]}: left and right differ",
            _cross_guidance(_target, _suffix),
        )

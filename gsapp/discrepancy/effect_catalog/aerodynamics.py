"""Aerodynamic effects: what each is mistaken for, and the maneuver that tells."""

from __future__ import annotations

from dataclasses import replace

from gsapp.discrepancy.effect_catalog.effect_record import EffectGuidance
from gsapp.dynamics.buildup import linear_variables
from gsapp.dynamics.terms import COEFFICIENTS

_BUILD_UP = "Seanor, (4.2.1)-(4.2.6)"
_BEYOND = "Seanor, section 4.2: left out of the linear build-up"
_SURFACE_NAMES = {"de": "elevator", "da": "aileron", "dr": "rudder"}
_LONGITUDINAL = ("CN", "CA", "Cm")
_LATERAL = ("CY", "Cl", "Cn")


def aerodynamic_guidance() -> dict[str, EffectGuidance]:
    """Return what is known of the aerodynamic effects, by id."""
    found: dict[str, EffectGuidance] = {}
    for part in (
        _linear(),
        _cross_coupling(),
        _nonlinear_terms(),
        _flap(),
        _surfaces(),
        _damping(),
        _sideslip(),
        _speed(),
        _unsteady(),
        _stall(),
    ):
        found.update(part)
    return found


# --- linear derivatives -------------------------------------------------------------------------

_OWN_MANEUVER = {
    "alpha": "elevator doublets at several amplitudes, and slow pull-ups",
    "q": "elevator doublets of different step times, so that q and alpha part in phase",
    "de": "elevator doublets from trim; a 3-2-1-1 parts the elevator from alpha and q",
    "beta": "rudder doublets, and a steady sideslip to either side",
    "p": "aileron doublets; combined aileron and rudder doublets part p from beta and r",
    "r": "rudder doublets; combined aileron and rudder doublets part r from beta and p",
    "da": "aileron doublets, combined with rudder doublets that do not coincide",
    "dr": "rudder doublets, combined with aileron doublets that do not coincide",
}


def _linear() -> dict[str, EffectGuidance]:
    found = {}
    for target in COEFFICIENTS:
        suffixes = tuple(linear_variables(target))
        for suffix in suffixes:
            others = tuple(f"aero.{target}.{other}" for other in suffixes if other != suffix)
            surface = suffix in _SURFACE_NAMES
            found[f"aero.{target}.{suffix}"] = EffectGuidance(
                mistaken_for=others,
                separated_by=_OWN_MANEUVER[suffix],
                effect_class="A",
                needs=(suffix,) if surface else (),
                source=f"{_BUILD_UP}; free or held as in tables 6.2.5 and 6.2.6",
                derivative=f"{target}_{suffix}",
            )
    return found


def _cross_coupling() -> dict[str, EffectGuidance]:
    """Return the effects by which one plane of motion drives the other, one asymmetry each."""
    found = {}
    for target in COEFFICIENTS:
        foreign = linear_variables("CY" if target in _LONGITUDINAL else "CN")
        for suffix in foreign:
            others = tuple(f"aero.{target}.{other}" for other in foreign if other != suffix)
            surface = suffix in _SURFACE_NAMES
            found[f"aero.{target}.{suffix}"] = EffectGuidance(
                mistaken_for=others,
                separated_by=(
                    f"{_OWN_MANEUVER[suffix]}, to the left as often as to the right and with the "
                    "sticks of the other axes still"
                    if target in _LONGITUDINAL
                    else f"{_OWN_MANEUVER[suffix]}, with aileron and rudder still"
                ),
                effect_class="A",
                needs=(suffix,) if surface else (),
                source="Seanor, flight tests: unequal sides; Etkin and Reid, coupling derivatives",
            )
    found["aero.Cl.alpha"] = EffectGuidance(
        mistaken_for=("mass.cg.y", "propulsion.Cl.throttle", "aero.Cl.q", "aero.Cl.de"),
        separated_by=(
            "slow pull-ups and push-overs with aileron and rudder still, at two speeds; weighing "
            "both wheels of the main gear settles the center of gravity"
        ),
        effect_class="A",
        source="Seanor, flight tests: unequal dihedral gives Cl_0 and Cn_0",
    )
    found["aero.Cn.alpha"] = replace(
        found["aero.Cn.alpha"],
        mistaken_for=("propulsion.Cn.asymmetry", *found["aero.Cn.alpha"].mistaken_for),
    )
    for target, words in (
        ("Cn", "what the spin of the engines does to pitching"),
        ("Cm", "what the spin of the engines does to yawing"),
    ):
        suffix = "q" if target == "Cn" else "r"
        old = found[f"aero.{target}.{suffix}"]
        found[f"aero.{target}.{suffix}"] = replace(
            old,
            separated_by=f"{old.separated_by}; at two throttle settings, because {words} grows "
            "with rpm",
            source=f"{old.source}; the engines' angular momentum looks like this",
        )
    return found


# --- curves over angle of attack ----------------------------------------------------------------


def _nonlinear_terms() -> dict[str, EffectGuidance]:
    slow = (
        "pull-ups and push-overs to both ends of the linear range, begun at two trim speeds: a "
        "curve follows alpha whatever the speed"
    )
    return {
        "aero.Cm.alpha2": EffectGuidance(
            mistaken_for=(
                "aero.Cm.alpha_q",
                "aero.Cm.alpha_de",
                "aero.Cm.speed",
                "aero.Cm.stall",
                "aero.Cm.beta2",
            ),
            separated_by=f"{slow}; small and large doublets at one trim",
            effect_class="A",
            source=_BEYOND,
        ),
        "aero.CN.alpha2": EffectGuidance(
            mistaken_for=("aero.CN.alpha_q", "aero.CZ.speed", "aero.CN.stall", "sensor.an.scale"),
            separated_by=slow,
            effect_class="A",
            source=_BEYOND,
        ),
        "aero.CA.alpha2": EffectGuidance(
            mistaken_for=("aero.CA.de2", "aero.CA.alpha_de", "aero.CX.speed", "aero.CA.stall"),
            separated_by=f"{slow}, at constant throttle",
            effect_class="A",
            source="induced drag: the axial force falls with alpha squared",
        ),
    }


def _stall() -> dict[str, EffectGuidance]:
    return {
        f"aero.{target}.stall": EffectGuidance(
            mistaken_for=(f"aero.{target}.alpha2", "sensor.alpha.clipping"),
            separated_by="a slow deceleration with the wings level until the break, with height "
            "to spare, and doublets that stay within the linear range",
            effect_class="A",
            source="departure beyond the linear angles of attack of the aircraft file",
            variant_of=f"aero.{target}.alpha2",
        )
        for target in _LONGITUDINAL
    }


# --- flap, surfaces -----------------------------------------------------------------------------


def _flap() -> dict[str, EffectGuidance]:
    alike = {"Cm": "aero.Cm.speed", "CN": "aero.CZ.speed", "CA": "aero.CX.speed"}
    return {
        f"aero.{target}.flap": EffectGuidance(
            mistaken_for=(alike[target], f"aero.{target}.alpha2"),
            separated_by="flap down and up again at constant speed and throttle, wings level, "
            "between doublets of the same kind with either setting",
            effect_class="A",
            needs=("flap",),
            source="Seanor, flight tests: flaps change trim",
        )
        for target in _LONGITUDINAL
    }


def _surfaces() -> dict[str, EffectGuidance]:
    found: dict[str, EffectGuidance] = {}
    for target, surfaces in (
        *((target, ("de",)) for target in _LONGITUDINAL),
        *((target, ("da", "dr")) for target in _LATERAL),
    ):
        for surface in surfaces:
            word = _SURFACE_NAMES[surface]
            found[f"aero.{target}.alpha_{surface}"] = EffectGuidance(
                mistaken_for=_effectiveness_aliases(target, surface),
                separated_by=f"the same {word} doublet at three trim angles of attack (speeds), "
                "small enough to stay linear in each",
                effect_class="A",
                needs=(surface,),
                source=f"{_BEYOND}; Seanor, flight tests from 80 to 120 ft/s",
            )
    for target, surface in (
        ("Cm", "de"),
        ("CN", "de"),
        ("Cl", "da"),
        ("Cn", "dr"),
        ("CY", "dr"),
        ("Cl", "dr"),
        ("Cn", "da"),
    ):
        word = _SURFACE_NAMES[surface]
        found[f"aero.{target}.{surface}3"] = EffectGuidance(
            mistaken_for=tuple(
                name
                for name in (
                    f"aero.{target}.alpha_{surface}",
                    f"control.{_SURFACE_NAMES[surface]}.saturation",
                    f"control.{_SURFACE_NAMES[surface]}.rate",
                    f"control.{_SURFACE_NAMES[surface]}.backlash",
                )
            ),
            separated_by=f"{word} doublets of quarter, half and full stick from the same trim",
            effect_class="A",
            needs=(surface,),
            source=f"Seanor, flight tests: doublets too large become nonlinear; {_BEYOND}",
        )
    for target, surface in (("Cm", "de"), ("Cl", "da"), ("Cn", "dr")):
        found[f"aero.{target}.{surface}_falloff"] = EffectGuidance(
            mistaken_for=(
                f"aero.{target}.{surface}3",
                f"control.{_SURFACE_NAMES[surface]}.saturation",
            ),
            separated_by=f"{_SURFACE_NAMES[surface]} doublets in five sizes from the same trim "
            "show where "
            "the effect begins to fall off",
            effect_class="A",
            needs=(surface,),
            source="separation on a plain flap beyond 10 to 15 deg of deflection",
            variant_of=f"aero.{target}.{surface}3",
        )
    found["aero.CA.de2"] = EffectGuidance(
        mistaken_for=("aero.CA.alpha2", "aero.CA.alpha_de"),
        separated_by="elevator doublets of several sizes at one trim: drag rises to both sides",
        effect_class="A",
        needs=("de",),
        source="drag of a deflected surface rises with its square",
    )
    return found


def _effectiveness_aliases(target: str, surface: str) -> tuple[str, ...]:
    speed = {"Cm": ("aero.Cm.speed",), "CN": ("aero.CZ.speed",), "CA": ("aero.CX.speed",)}
    rate = {"de": "q", "da": "p", "dr": "r"}[surface]
    own = {("Cm", "de"), ("CN", "de"), ("Cl", "da"), ("Cn", "dr"), ("CY", "dr"), ("Cl", "dr")}
    cubic = (f"aero.{target}.{surface}3",) if (target, surface) in own else ()
    damping = () if target == "CA" else (f"aero.{target}.alpha_{rate}",)
    return (*damping, *cubic, *speed.get(target, ()))


# --- damping, sideslip --------------------------------------------------------------------------


def _damping() -> dict[str, EffectGuidance]:
    found = {}
    rows = (
        ("Cm", "q"), ("CN", "q"),
        *((target, rate) for target in _LATERAL for rate in ("p", "r")),
    )  # fmt: skip
    lift = {("Cl", "r"), ("Cn", "p")}
    for target, rate in rows:
        surface = {"q": "de", "p": "da", "r": "dr"}[rate]
        found[f"aero.{target}.alpha_{rate}"] = EffectGuidance(
            mistaken_for=(
                *((f"aero.{target}.alpha2",) if rate == "q" else ()),
                *((f"aero.{target}.alpha_beta",) if rate == "p" else ()),
                f"aero.{target}.alpha_{surface}",
                *((f"aero.{target}.alpha_beta",) if rate == "r" else ()),
                *(("aero.Cm.alphadot",) if target == "Cm" else ()),
            ),
            separated_by=f"the same {_SURFACE_NAMES[surface]} doublet at three trim angles of "
            "attack "
            "(speeds)",
            effect_class="A",
            source="strip theory: Cl_r and Cn_p grow with the lift coefficient"
            if (target, rate) in lift
            else _BEYOND,
        )
    return found


def _sideslip() -> dict[str, EffectGuidance]:
    found = {}
    for target in _LATERAL:
        found[f"aero.{target}.alpha_beta"] = EffectGuidance(
            mistaken_for=(
                f"aero.{target}.alpha_p",
                f"aero.{target}.beta3",
                f"aero.{target}.alpha_r",
            ),
            separated_by="rudder doublets, and steady sideslips, at three trim angles of attack "
            "(speeds)",
            effect_class="A",
            source="swept wing: dihedral effect grows with lift (sweep 27 deg, table 3.2.1)",
        )
        found[f"aero.{target}.beta3"] = EffectGuidance(
            mistaken_for=(
                f"aero.{target}.alpha_beta",
                f"aero.{target}.dr3",
                "sensor.beta.clipping",
            ),
            separated_by="steady sideslips of growing size to both sides, and rudder doublets of "
            "quarter, half and full stick",
            effect_class="A",
            source=_BEYOND,
        )
    for target in _LONGITUDINAL:
        found[f"aero.{target}.beta2"] = EffectGuidance(
            mistaken_for=(f"aero.{target}.beta", f"aero.{target}.alpha2"),
            separated_by="steady sideslips to both sides at constant speed, elevator noted: an "
            "even effect has the same sign to either side",
            effect_class="A",
            source="tail in the wake of the body at sideslip",
        )
    return found


# --- speed, unsteady flow -----------------------------------------------------------------------


def _speed() -> dict[str, EffectGuidance]:
    maneuver = (
        "level accelerations and decelerations at constant throttle, and the same doublet at "
        "80 ft/s, 100 ft/s and 120 ft/s"
    )
    return {
        "aero.Cm.speed": EffectGuidance(
            mistaken_for=("aero.Cm.alphadot", "propulsion.Cm.throttle", "aero.Cm.alpha2"),
            separated_by=f"{maneuver}; throttle steps at constant speed tell thrust from speed",
            effect_class="A",
            needs=("V",),
            source="a missing speed derivative passes for damping by alpha' in a fit",
        ),
        "aero.CZ.speed": EffectGuidance(
            mistaken_for=("propulsion.CZ.throttle", "aero.CN.alpha2", "sensor.qbar.scale"),
            separated_by=maneuver,
            effect_class="A",
            needs=("V",),
            source=_BEYOND,
        ),
        "aero.CX.speed": EffectGuidance(
            mistaken_for=("propulsion.thrust.speed", "propulsion.thrust.scale", "aero.CA.alpha2"),
            separated_by=f"{maneuver}; a glide with idling engines tells drag from thrust",
            effect_class="A",
            needs=("V",),
            source="Seanor, appendix A: X_u and X_Tu",
        ),
    }


def _unsteady() -> dict[str, EffectGuidance]:
    return {
        "aero.Cm.alphadot": EffectGuidance(
            mistaken_for=("aero.Cm.speed", "aero.Cm.memory", "aero.Cm.q", "sensor.alpha.delay"),
            separated_by="maneuvers in which q and alpha' differ: slow and quick doublets, and "
            "rolls with elevator held; in short doublets about level flight they hardly part",
            effect_class="A",
            source="Seanor, appendix A: M_adot; downwash lag at the tail",
        ),
        "aero.Cm.memory": EffectGuidance(
            mistaken_for=("aero.Cm.alphadot", "control.elevator.lag", "sensor.alpha.lag"),
            separated_by="doublets of very different step times (0.15 to 1 s)",
            effect_class="A",
            source="indicial lift: one lag of the flow",
            decoy=True,
        ),
        "aero.CN.memory": EffectGuidance(
            mistaken_for=("aero.CN.q", "sensor.an.lag", "sensor.alpha.lag"),
            separated_by="doublets of very different step times (0.15 to 1 s)",
            effect_class="A",
            source="indicial lift: one lag of the flow",
            decoy=True,
        ),
    }

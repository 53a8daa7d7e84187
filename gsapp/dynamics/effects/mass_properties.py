"""Errors of mass, inertia, and center of gravity."""

from __future__ import annotations

from collections.abc import Callable

from gsapp.aircraft import Aircraft
from gsapp.dynamics.effects.effect_registration import register_offset
from gsapp.dynamics.terms import EffectGuidance

_WEIGH = "weigh the aircraft on three scales under its wheels, ready to fly"
_PENDULUM_TEST = "swing the aircraft as a pendulum (gsapp inertia)"
_MERELY = "nothing in flight: it rescales the coefficients that a fit leaves free"
_SUSPICIOUS = "Seanor, table 3.2.1: the published inertias are suspicious"

register_offset(
    "mass.cg.x",
    "cg.x",
    "m",
    lambda aircraft: 0.05 * aircraft.geometry.chord,
    "Center of gravity lies further forward or aft",
    EffectGuidance(
        mistaken_for=("aero.Cm.alpha", "aero.Cn.beta", "aero.Cm.q"),
        separated_by=_MERELY,
        effect_class="C",
        remedy=f"{_WEIGH}: the loads of nose and main wheels give x",
        source="aircraft file; fuel burned moves it",
    ),
)
register_offset(
    "mass.cg.y",
    "cg.y",
    "m",
    lambda aircraft: 0.005 * aircraft.geometry.span,
    "Center of gravity lies to one side",
    EffectGuidance(
        mistaken_for=("aero.Cl.alpha",),
        separated_by="hardly anything in flight: lift to one side of the center of gravity rolls "
        f"as a wing does that differs from the other; {_WEIGH}: left and right wheel give y",
        source="unequal tanks, payload to one side",
        variant_of="aero.Cl.alpha",
    ),
)
register_offset(
    "mass.cg.z",
    "cg.z",
    "m",
    lambda aircraft: 0.05 * aircraft.geometry.chord,
    "Center of gravity lies higher or lower",
    EffectGuidance(
        mistaken_for=("propulsion.Cm.throttle", "aero.Cl.beta"),
        separated_by="throttle steps see it only together with the thrust line",
        effect_class="C",
        remedy="hang the aircraft by two points in turn: the plumb lines cross in the center "
        "of gravity",
        source="aircraft file",
    ),
)
register_offset(
    "mass.mass.error",
    "mass",
    "kg",
    lambda aircraft: -0.05 * aircraft.mass.mass,
    "Mass differs from the aircraft file",
    EffectGuidance(
        mistaken_for=("aero.CN.alpha", "propulsion.thrust.scale", "sensor.an.scale"),
        separated_by=_MERELY,
        effect_class="C",
        remedy=f"{_WEIGH}, before take-off and after landing",
        source="Seanor, table 6.2.3: 6 % of the mass burns off in a flight",
    ),
)


def _share_of_inertia(name: str) -> Callable[[Aircraft], float]:
    return lambda aircraft: 0.1 * float(getattr(aircraft.mass, name))


for _name, _title, _alike, _axis in (
    ("ixx", "Roll inertia", ("aero.Cl.p", "aero.Cl.da", "control.aileron.gearing"), "x"),
    ("iyy", "Pitch inertia", ("aero.Cm.q", "aero.Cm.de", "control.elevator.gearing"), "y"),
    (
        "izz",
        "Yaw inertia",
        ("aero.Cn.r", "aero.Cn.dr", "control.rudder.gearing"),
        "z, on two wires",
    ),
):
    register_offset(
        f"mass.inertia.{_name}",
        _name,
        "kg*m^2",
        _share_of_inertia(_name),
        f"{_title} differs",
        EffectGuidance(
            mistaken_for=_alike,
            separated_by=_MERELY,
            effect_class="C",
            remedy=f"{_PENDULUM_TEST} about {_axis}",
            source=_SUSPICIOUS,
        ),
    )
register_offset(
    "mass.inertia.ixz",
    "ixz",
    "kg*m^2",
    _share_of_inertia("ixx"),
    "Product of inertia couples roll and yaw",
    EffectGuidance(
        mistaken_for=("aero.Cn.p", "aero.Cl.r", "aero.Cn.da"),
        separated_by=_MERELY,
        effect_class="C",
        remedy=f"{_PENDULUM_TEST} on two wires, level and with the nose up",
        source="Seanor, section 3.6: Ixz from the bifilar inertia at an angle",
    ),
)

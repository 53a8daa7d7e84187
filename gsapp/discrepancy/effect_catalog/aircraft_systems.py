"""Effects of engines, controls and mass: what each is mistaken for, and what tells."""

from __future__ import annotations

from gsapp.discrepancy.effect_catalog.effect_record import EffectGuidance
from gsapp.dynamics.signal_terms import SURFACE_CHANNELS

_WEIGH = "weigh the aircraft on three scales under its wheels, ready to fly"
_PENDULUM_TEST = "swing the aircraft as a pendulum (gsapp inertia)"


def propulsion_guidance() -> dict[str, EffectGuidance]:
    """Return what is known of the effects of the engines, by id."""
    steps = "throttle steps with the wings level at low and at high speed, elevator held"
    return {
        "propulsion.Cm.throttle": EffectGuidance(
            mistaken_for=(
                "propulsion.Cm.slipstream",
                "aero.Cm.speed",
                "mass.cg.z",
                "aero.Cm.alpha2",
            ),
            separated_by=f"{steps}: a thrust line off the center of gravity counts as 1/V^2",
            effect_class="A",
            needs=("throttle",),
            source="Seanor, flight tests: high throttle at low airspeed pitches the nose up",
        ),
        "propulsion.Cm.slipstream": EffectGuidance(
            mistaken_for=("propulsion.Cm.throttle", "aero.Cm.speed"),
            separated_by=f"{steps}: the flow over the tail counts alike at both",
            effect_class="A",
            needs=("throttle",),
            source="flow of the fans over the tail",
            variant_of="propulsion.Cm.throttle",
        ),
        "propulsion.Cn.asymmetry": EffectGuidance(
            mistaken_for=("aero.Cn.alpha", "sensor.beta.bias"),
            separated_by="throttle steps with the wings level, rudder and aileron held, at low "
            "speed; rpm of both engines recorded",
            effect_class="A",
            needs=("throttle",),
            source="Seanor, flight tests: engine rpm imbalance shows up as yaw",
        ),
        "propulsion.CZ.throttle": EffectGuidance(
            mistaken_for=("aero.CZ.speed", "propulsion.Cm.throttle", "aero.CN.alpha2"),
            separated_by=f"{steps}, angle of attack read before and after",
            effect_class="A",
            needs=("throttle",),
            source="thrust line not along x",
        ),
        "propulsion.Cl.throttle": EffectGuidance(
            mistaken_for=("aero.Cl.alpha", "propulsion.Cn.asymmetry"),
            separated_by="throttle steps with the wings level, aileron held",
            effect_class="A",
            needs=("throttle",),
            source="reaction of the engines' torque",
        ),
        "propulsion.thrust.scale": EffectGuidance(
            mistaken_for=("aero.CX.speed", "propulsion.thrust.speed", "sensor.ax.scale"),
            separated_by="level accelerations from idle to full throttle and a glide with idling "
            "engines; a static pull with a spring scale settles it",
            effect_class="A",
            needs=("throttle",),
            source="Seanor, section 3: two fans of about 12 lb each",
        ),
        "propulsion.thrust.speed": EffectGuidance(
            mistaken_for=("aero.CX.speed", "propulsion.thrust.scale"),
            separated_by="throttle steps at 80 ft/s and 120 ft/s, a glide with idling engines",
            effect_class="A",
            needs=("throttle", "V"),
            source="aircraft file: zero_thrust_speed is often assumed",
        ),
        "propulsion.thrust.lag": EffectGuidance(
            mistaken_for=("propulsion.thrust.scale", "sensor.ax.lag"),
            separated_by="throttle steps and throttle doublets, rpm recorded",
            effect_class="A",
            needs=("throttle",),
            source="aircraft file: lag of the engines is often assumed",
        ),
    }


def control_guidance() -> dict[str, EffectGuidance]:
    """Return what is known of the effects between command and surface, by id."""
    found: dict[str, EffectGuidance] = {}
    main = {"de": "Cm", "da": "Cl", "dr": "Cn"}
    for surface, channel in SURFACE_CHANNELS.items():
        target = main.get(channel)
        cubic = () if target is None else (f"aero.{target}.{channel}3",)
        path = f"control.{surface}"
        rows = {
            "backlash": EffectGuidance(
                mistaken_for=(f"{path}.lag", f"{path}.delay", *cubic),
                separated_by=f"{surface} doublets of quarter and full stick: play takes the same "
                "angle from each; moving the surface by hand on the ground shows it at once",
                effect_class="A",
                needs=(channel,),
                source="Seanor, section 3.5: linkage slop, servo not returning",
            ),
            "saturation": EffectGuidance(
                mistaken_for=(*cubic, f"{path}.rate", f"{path}.gearing"),
                separated_by=f"{surface} doublets of half and full stick; full stick on the "
                "ground against a protractor",
                effect_class="A",
                needs=(channel,),
                source="stops, or a servo stalled by the air load",
            ),
            "lag": EffectGuidance(
                mistaken_for=(f"{path}.delay", f"{path}.backlash", f"{path}.rate"),
                separated_by=f"{surface} doublets of very different step times (0.15 to 1 s), or "
                "a frequency sweep",
                effect_class="A",
                needs=(channel,),
                source="first-order servo",
            ),
            "rate": EffectGuidance(
                mistaken_for=(f"{path}.lag", f"{path}.saturation", *cubic),
                separated_by=f"{surface} doublets of quarter and full stick with the same step "
                "time: a rate limit spares the small ones",
                effect_class="A",
                needs=(channel,),
                source="servo under load or low battery",
            ),
            "delay": EffectGuidance(
                mistaken_for=(f"{path}.lag", "sensor.surfaces.delay"),
                separated_by=f"{surface} doublets of very different step times, or a frequency "
                "sweep: a delay turns the phase and leaves the size",
                effect_class="A",
                needs=(channel,),
                source="radio link, receiver and servo",
            ),
            "gearing": EffectGuidance(
                mistaken_for=() if target is None else (f"aero.{target}.{channel}",),
                separated_by="nothing in flight: it multiplies every derivative of the surface",
                effect_class="C",
                remedy=f"move the {surface} on the ground and read a protractor against the "
                "record, from stop to stop",
                needs=(channel,),
                source="calibration of the surface or its linkage",
            ),
        }
        found.update({f"{path}.{kind}": lore for kind, lore in rows.items()})
    return found


def mass_guidance() -> dict[str, EffectGuidance]:
    """Return what is known of errors of mass, inertia and center of gravity, by id."""
    merely = "nothing in flight: it rescales the coefficients that a fit leaves free"
    return {
        "mass.cg.x": EffectGuidance(
            mistaken_for=("aero.Cm.alpha", "aero.Cn.beta", "aero.Cm.q"),
            separated_by=merely,
            effect_class="C",
            remedy=f"{_WEIGH}: the loads of nose and main wheels give x",
            source="aircraft file; fuel burned moves it",
        ),
        "mass.cg.y": EffectGuidance(
            mistaken_for=("aero.Cl.alpha",),
            separated_by="hardly anything in flight: lift beside the center of gravity rolls as "
            f"a wing does that differs from the other; {_WEIGH}: left and right wheel give y",
            effect_class="A",
            source="unequal tanks, payload to one side",
            variant_of="aero.Cl.alpha",
        ),
        "mass.cg.z": EffectGuidance(
            mistaken_for=("propulsion.Cm.throttle", "aero.Cl.beta"),
            separated_by="throttle steps see it only together with the thrust line",
            effect_class="C",
            remedy="hang the aircraft by two points in turn: the plumb lines cross in the center "
            "of gravity",
            source="aircraft file",
        ),
        "mass.mass.error": EffectGuidance(
            mistaken_for=("aero.CN.alpha", "propulsion.thrust.scale", "sensor.an.scale"),
            separated_by=merely,
            effect_class="C",
            remedy=f"{_WEIGH}, before take-off and after landing",
            source="Seanor, table 6.2.3: 6 % of the mass burns off in a flight",
        ),
        "mass.inertia.ixx": EffectGuidance(
            mistaken_for=("aero.Cl.p", "aero.Cl.da", "control.aileron.gearing"),
            separated_by=merely,
            effect_class="C",
            remedy=f"{_PENDULUM_TEST} about x",
            source="Seanor, table 3.2.1: the published inertias are suspicious",
        ),
        "mass.inertia.iyy": EffectGuidance(
            mistaken_for=("aero.Cm.q", "aero.Cm.de", "control.elevator.gearing"),
            separated_by=merely,
            effect_class="C",
            remedy=f"{_PENDULUM_TEST} about y",
            source="Seanor, table 3.2.1: the published inertias are suspicious",
        ),
        "mass.inertia.izz": EffectGuidance(
            mistaken_for=("aero.Cn.r", "aero.Cn.dr", "control.rudder.gearing"),
            separated_by=merely,
            effect_class="C",
            remedy=f"{_PENDULUM_TEST} about z, on two wires",
            source="Seanor, table 3.2.1: the published inertias are suspicious",
        ),
        "mass.inertia.ixz": EffectGuidance(
            mistaken_for=("aero.Cn.p", "aero.Cl.r", "aero.Cn.da"),
            separated_by=merely,
            effect_class="C",
            remedy=f"{_PENDULUM_TEST} on two wires, level and with the nose up",
            source="Seanor, section 3.6: Ixz from the bifilar inertia at an angle",
        ),
    }

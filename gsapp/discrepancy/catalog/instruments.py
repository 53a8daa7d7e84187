"""Effects of the instruments: what each is mistaken for, and what tells."""

from __future__ import annotations

from gsapp.discrepancy.catalog.records import Lore
from gsapp.discrepancy.results import EffectClass
from gsapp.dynamics.signals import SENSOR_CHANNELS
from gsapp.dynamics.terms import effect_ids

_WORDS = {
    "alpha": "alpha vane",
    "beta": "beta vane",
    "V": "airspeed",
    "qbar": "dynamic pressure",
    "p": "roll gyro",
    "q": "pitch gyro",
    "r": "yaw gyro",
    "ax": "x accelerometer",
    "ay": "y accelerometer",
    "an": "normal accelerometer",
    "phi": "bank angle",
    "theta": "pitch angle",
    "de": "elevator position",
    "da": "aileron position",
    "dr": "rudder position",
    "flap": "flap position",
}
_SURFACES = ("de", "da", "dr", "flap")
_EXCITING = {
    "alpha": "elevator doublets and pull-ups",
    "beta": "rudder doublets and steady sideslips",
    "V": "level accelerations and decelerations",
    "qbar": "level accelerations and decelerations",
    "p": "aileron doublets and banks held for some seconds",
    "q": "elevator doublets and pull-ups",
    "r": "rudder doublets and steady turns",
    "ax": "level accelerations, pull-ups",
    "ay": "rudder doublets and steady sideslips",
    "an": "elevator doublets and pull-ups",
    "phi": "banks to 45 deg and back",
    "theta": "climbs and dives",
    "de": "elevator doublets",
    "da": "aileron doublets",
    "dr": "rudder doublets",
    "flap": "flap down and up",
}
# What the coefficients would make of the channel, were the instrument trusted.
_COEFFICIENT = {
    "alpha": "aero.CN.alpha",
    "beta": "aero.CY.beta",
    "V": "aero.CZ.speed",
    "qbar": "aero.CZ.speed",
    "p": "aero.Cl.p",
    "q": "aero.Cm.q",
    "r": "aero.Cn.r",
    "ax": "aero.CX.speed",
    "ay": "aero.CY.beta",
    "an": "aero.CN.alpha",
    "phi": "sensor.p.bias",
    "theta": "sensor.q.bias",
    "de": "aero.Cm.de",
    "da": "aero.Cl.da",
    "dr": "aero.Cn.dr",
    "flap": "aero.Cm.flap",
}
_KINEMATICS = "notes, section 2 and 7; data compatibility, kinematics without aerodynamics"


def instrument_lore() -> dict[str, Lore]:
    """Return what is known of the effects of the instruments, by id."""
    found: dict[str, Lore] = {}
    for channel in SENSOR_CHANNELS:
        found.update(_channel(channel))
    known = set(effect_ids())
    return {name: lore for name, lore in found.items() if name in known}


def _channel(channel: str) -> dict[str, Lore]:
    sensor, word = f"sensor.{channel}", _WORDS[channel]
    surface = channel in _SURFACES
    alike = _COEFFICIENT[channel]
    static: EffectClass = "C" if surface else "B"
    protractor = f"move the surface on the ground and read a protractor against the {word}"
    exciting = _EXCITING[channel]
    others = (
        f"{exciting}; surface and motion of the aircraft must agree in time"
        if surface
        else f"{exciting}, with the other instruments of the same motion recorded: the "
        "compatibility check needs no aerodynamics"
    )
    rows = {
        "scale": Lore(
            mistaken_for=(alike, f"{sensor}.bias"),
            separated_by="nothing in flight: it multiplies every derivative of the surface"
            if surface
            else others,
            effect_class=static,
            remedy=f"{protractor}, from stop to stop" if surface else "",
            needs=(channel,),
            source=_KINEMATICS,
        ),
        "bias": Lore(
            mistaken_for=(f"{sensor}.scale", alike),
            separated_by="nothing in flight: it hides in the constant terms" if surface else others,
            effect_class=static,
            remedy=f"{protractor}, at neutral" if surface else "",
            needs=(channel,),
            source=_KINEMATICS,
        ),
        "delay": Lore(
            mistaken_for=(f"{sensor}.lag",),
            separated_by=f"{others}; quick doublets (steps of 0.2 s) show lateness best",
            effect_class="A" if surface else "B",
            needs=(channel,),
            source=_KINEMATICS,
        ),
        "lag": Lore(
            mistaken_for=(f"{sensor}.delay",),
            separated_by=f"{others}; doublets of different step times part a filter from a delay",
            effect_class="A" if surface else "B",
            needs=(channel,),
            source=_KINEMATICS,
        ),
        "reversed": Lore(
            mistaken_for=(alike,),
            separated_by="nothing in flight: all derivatives of the surface change sign"
            if surface
            else others,
            effect_class=static,
            remedy="move the stick on the ground and look at the chart" if surface else "",
            needs=(channel,),
            source="notes, section 5: the source's a_y carries the wrong sign",
        ),
    }
    return {f"{sensor}.{kind}": lore for kind, lore in rows.items()}

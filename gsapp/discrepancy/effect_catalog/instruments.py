"""Effects of the instruments: what each is mistaken for, and what tells."""

from __future__ import annotations

from gsapp.discrepancy.effect_catalog.effect_record import EffectGuidance
from gsapp.discrepancy.results import EffectClass
from gsapp.dynamics.signal_terms import (
    INPUT_CHANNELS,
    INSTRUMENT_BOXES,
    SENSOR_CHANNELS,
    SWAPPABLE_PAIRS,
)

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
_LIKE_CLIPPING = {
    "alpha": ("aero.CN.stall",),
    "beta": ("aero.Cn.beta3", "aero.Cl.beta3"),
    "de": ("aero.Cm.de3",),
    "da": ("aero.Cl.da3",),
    "dr": ("aero.Cn.dr3",),
}
_KINEMATICS = "data compatibility: kinematics without aerodynamics"


def instrument_guidance() -> dict[str, EffectGuidance]:
    """Return what is known of the effects of the instruments, by id."""
    found: dict[str, EffectGuidance] = {}
    for channel in SENSOR_CHANNELS:
        found.update(_channel(channel))
    found.update(_sensor_units())
    found.update(_pairs())
    found.update(_sensor_positions())
    return found


def _channel(channel: str) -> dict[str, EffectGuidance]:
    sensor = f"sensor.{channel}"
    surface = channel in INPUT_CHANNELS
    alike = _COEFFICIENT[channel]
    static: EffectClass = "C" if surface else "B"
    protractor = "move the surface on the ground and read a protractor against the record"
    exciting = _EXCITING[channel]
    others = (
        f"{exciting}; surface and motion of the aircraft must agree in time"
        if surface
        else f"{exciting}, with the other instruments of the same motion recorded: the "
        "compatibility check needs no aerodynamics"
    )
    rows = {
        "scale": EffectGuidance(
            mistaken_for=(alike, f"{sensor}.bias"),
            separated_by="nothing in flight: it multiplies every derivative of the surface"
            if surface
            else others,
            effect_class=static,
            remedy=f"{protractor}, from stop to stop" if surface else "",
            needs=(channel,),
            source=_KINEMATICS,
        ),
        "bias": EffectGuidance(
            mistaken_for=(f"{sensor}.scale", alike),
            separated_by="nothing in flight: it hides in the constant terms" if surface else others,
            effect_class=static,
            remedy=f"{protractor}, at neutral" if surface else "",
            needs=(channel,),
            source=_KINEMATICS,
        ),
        "delay": EffectGuidance(
            mistaken_for=(f"{sensor}.lag", _sensor_unit(channel)),
            separated_by=f"{others}; quick doublets (steps of 0.2 s) show lateness best",
            effect_class="A" if surface else "B",
            needs=(channel,),
            source=_KINEMATICS,
        ),
        "lag": EffectGuidance(
            mistaken_for=(f"{sensor}.delay", _sensor_unit(channel)),
            separated_by=f"{others}; doublets of different step times part a filter from a delay",
            effect_class="A" if surface else "B",
            needs=(channel,),
            source=_KINEMATICS,
        ),
        "clipping": EffectGuidance(
            mistaken_for=(f"{sensor}.scale", *_LIKE_CLIPPING.get(channel, ())),
            separated_by=f"{exciting}, small and large: only the large ones reach the end, and "
            "the record shows a flat top",
            effect_class="A" if surface else "B",
            needs=(channel,),
            source="Seanor, section 3.5: some early maneuvers went past the range of the gyros",
        ),
        "reversed": EffectGuidance(
            mistaken_for=(alike,),
            separated_by="nothing in flight: all derivatives of the surface change sign"
            if surface
            else others,
            effect_class=static,
            remedy="move the stick on the ground and look at the chart" if surface else "",
            needs=(channel,),
            source="Seanor, (7.3.13): the side-force row carries the wrong sign",
        ),
    }
    return {f"{sensor}.{kind}": lore for kind, lore in rows.items()}


def _sensor_unit(channel: str) -> str:
    box = next(box for box, channels in INSTRUMENT_BOXES.items() if channel in channels)
    return f"sensor.{box}.delay"


def _sensor_units() -> dict[str, EffectGuidance]:
    found = {}
    for box, channels in INSTRUMENT_BOXES.items():
        surfaces = box == "surfaces"
        others = tuple(f"sensor.{other}.delay" for other in INSTRUMENT_BOXES if other != box)
        controls = tuple(f"control.{name}.delay" for name in ("elevator", "aileron", "rudder"))
        found[f"sensor.{box}.delay"] = EffectGuidance(
            mistaken_for=(
                *others,
                *(f"sensor.{channel}.delay" for channel in channels),
                *(controls if surfaces else ()),
            ),
            separated_by="quick doublets of elevator, aileron and rudder: one clock makes all "
            f"channels of the box ({', '.join(channels)}) late by the same time; a tap on the "
            "airframe with a surface held shows it on the ground",
            effect_class="A" if surfaces else "B",
            needs=channels[:2] if not surfaces else (),
            source="two recorders, two clocks",
        )
    return found


def _pairs() -> dict[str, EffectGuidance]:
    return {
        f"sensor.{one}_{other}.swapped": EffectGuidance(
            mistaken_for=(f"sensor.{one}.reversed", f"sensor.{other}.reversed"),
            separated_by=f"{_EXCITING[one]}, then {_EXCITING[other]}, one after the other; on the "
            "ground, turning and tilting the aircraft by hand shows which chart answers",
            effect_class="B",
            needs=(one, other),
            source="Seanor, flights 14 to 18: all three gyros measured q",
        )
        for one, other in SWAPPABLE_PAIRS
    }


_POSITION_ALIASES = {
    "sensor.alpha_vane.x": ("aero.CN.q", "sensor.alpha.delay"),
    "sensor.alpha_vane.y": ("aero.CN.p", "sensor.alpha.scale"),
    "sensor.beta_vane.x": ("aero.CY.r", "sensor.beta.delay"),
    "sensor.beta_vane.z": ("aero.CY.p", "sensor.beta.scale"),
    "sensor.accelerometer.x": ("aero.CN.q", "aero.CY.r", "sensor.an.delay"),
    "sensor.accelerometer.y": ("sensor.an.scale", "sensor.ax.scale"),
    "sensor.accelerometer.z": ("aero.CY.p", "aero.CA.q", "sensor.ay.delay"),
    "sensor.air_data.y": ("sensor.V.scale",),
    "sensor.air_data.z": ("sensor.V.scale",),
}
_POSITION_CHANNEL = {
    "alpha_vane": "alpha",
    "beta_vane": "beta",
    "accelerometer": "an",
    "air_data": "V",
}


def _sensor_positions() -> dict[str, EffectGuidance]:
    found = {}
    for name, alike in _POSITION_ALIASES.items():
        instrument = name.split(".")[1]
        lateral = name in ("sensor.alpha_vane.y", "sensor.beta_vane.z", "sensor.accelerometer.y")
        found[name] = EffectGuidance(
            mistaken_for=alike,
            separated_by=(
                "quick aileron doublets" if lateral else "quick elevator and rudder doublets"
            )
            + ": the share of the rotation grows with its rate and acceleration; a tape measure "
            "from the center of gravity settles it at once",
            effect_class="B",
            needs=(_POSITION_CHANNEL[instrument],),
            source="kinematics: what sensors at (x, y, z) from the CG show",
        )
    return found

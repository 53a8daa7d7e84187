"""Effects of the instruments: of each channel, of boxes and pairs of them, of where they sit."""

from __future__ import annotations

from collections.abc import Callable

from gsapp.aircraft import Aircraft
from gsapp.dynamics.effects.effect_registration import DELAY, TAU, register_offset, register_term
from gsapp.dynamics.signal_terms import (
    INPUT_CHANNELS,
    INSTRUMENT_BOXES,
    SENSOR_CHANNELS,
    SWAPPABLE_PAIRS,
    Bias,
    Delay,
    Lag,
    Saturation,
    ScaleFactor,
    SignalTerm,
    SignReversal,
    SwappedChannels,
)
from gsapp.dynamics.terms import EffectClass, EffectGuidance, Parameter

_UNITS = {
    "V": "m/s", "qbar": "Pa",
    **dict.fromkeys(("p", "q", "r"), "rad/s"), **dict.fromkeys(("ax", "ay", "an"), "m/s^2"),
}  # fmt: skip
_BIASES = {"V": 1.5, "qbar": 25.0, **dict.fromkeys(("ax", "ay", "an"), 0.3)}
_CLIPS = {
    "V": 30.0, "qbar": 550.0, "alpha": 0.12, "beta": 0.06, "ax": 1.5, "ay": 2.0, "an": 13.0,
    "phi": 0.5, "theta": 0.15,
}  # fmt: skip
_CLIP = 0.3
_INSTRUMENT_TITLES = {
    "alpha": "Alpha vane",
    "beta": "Beta vane",
    "V": "Airspeed",
    "p": "Roll gyro",
    "q": "Pitch gyro",
    "r": "Yaw gyro",
    "ax": "x accelerometer",
    "ay": "y accelerometer",
    "an": "Normal accelerometer",
    "phi": "Bank angle",
    "theta": "Pitch angle",
    "qbar": "Dynamic pressure",
    "de": "Elevator position",
    "da": "Aileron position",
    "dr": "Rudder position",
    "flap": "Flap position",
}
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


def _channel_guidance(channel: str) -> dict[str, EffectGuidance]:
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
    return {
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
            separated_by=f"{others}; quick doublets (steps of 0.2 s) show delays best",
            effect_class="A" if surface else "B",
            needs=(channel,),
            source=_KINEMATICS,
        ),
        "lag": EffectGuidance(
            mistaken_for=(f"{sensor}.delay", _sensor_unit(channel)),
            separated_by=(
                f"{others}; doublets of different step times separate a filter from a delay"
            ),
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


def _sensor_unit(channel: str) -> str:
    box = next(box for box, channels in INSTRUMENT_BOXES.items() if channel in channels)
    return f"sensor.{box}.delay"


def _box_guidance(box: str) -> EffectGuidance:
    channels, surfaces = INSTRUMENT_BOXES[box], box == "surfaces"
    others = tuple(f"sensor.{other}.delay" for other in INSTRUMENT_BOXES if other != box)
    controls = tuple(f"control.{name}.delay" for name in ("elevator", "aileron", "rudder"))
    return EffectGuidance(
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


def _register_sensors() -> None:
    for channel in SENSOR_CHANNELS:
        unit = _UNITS.get(channel, "rad")
        bias, clip_at = _BIASES.get(channel, 0.015), _CLIPS.get(channel, _CLIP)
        if channel in INPUT_CHANNELS:
            clip_at = 0.1
        target, reads, name = f"sensor.{channel}", (channel,), _INSTRUMENT_TITLES[channel]
        rows: tuple[SignalTerm, ...] = (
            ScaleFactor(
                id=f"sensor.{channel}.scale",
                title=f"{name} has a scale error",
                equation=f"{channel} recorded = scale * {channel}",
                parameters=(Parameter("scale", "", 1.1, (-3.0, 3.0), "recorded over true", 1.0),),
                target=target,
                reads=reads,
            ),
            Bias(
                id=f"sensor.{channel}.bias",
                title=f"{name} has an offset",
                equation=f"{channel} recorded = {channel} + bias",
                parameters=(
                    Parameter(
                        "bias", unit, bias, (-30.0 * bias, 30.0 * bias), "recorded minus true"
                    ),
                ),
                target=target,
                reads=reads,
            ),
            Delay(
                id=f"sensor.{channel}.delay",
                title=f"{name} is late",
                equation=f"{channel} recorded(t) = {channel}(t - delay)",
                states=("x1", "x2"),
                parameters=DELAY,
                target=target,
                reads=reads,
            ),
            Lag(
                id=f"sensor.{channel}.lag",
                title=f"{name} is filtered",
                equation=f"recorded' = ({channel} - recorded)/tau",
                states=("recorded",),
                parameters=TAU,
                target=target,
                reads=reads,
            ),
            Saturation(
                id=f"sensor.{channel}.clipping",
                title=f"{name} reaches the end of its range",
                equation=f"{channel} recorded = limit({channel}, -limit, limit)",
                parameters=(
                    Parameter(
                        "limit",
                        unit,
                        clip_at,
                        (0.0, 100.0 * clip_at),
                        "largest size recorded",
                        100.0 * clip_at,
                    ),
                ),
                target=target,
                reads=reads,
            ),
            SignReversal(
                id=f"sensor.{channel}.reversed",
                title=f"{name} has the wrong sign",
                equation=f"{channel} recorded = -{channel}",
                target=target,
                reads=reads,
            ),
        )
        guidance = _channel_guidance(channel)
        for term in rows:
            register_term(term, guidance[term.id.rpartition(".")[2]])


_BOX_TITLES = {
    "airdata": "All air data (vanes, airspeed) come late",
    "inertial": "Gyros and accelerometers come late",
    "attitude": "Bank and pitch angle come late",
    "surfaces": "All surface positions come late",
}


def _register_boxes() -> None:
    for box, channels in INSTRUMENT_BOXES.items():
        term = Delay(
            id=f"sensor.{box}.delay",
            title=_BOX_TITLES[box],
            equation=f"recorded(t) = true(t - delay) for {', '.join(channels)}",
            states=("x1", "x2"),
            parameters=(
                Parameter(
                    "delay",
                    "s",
                    0.02,
                    (-0.2, 0.5),
                    "clock delay of the recorder; negative: early, recorded flights only",
                ),
            ),
            target=f"sensor.{box}",
            # Of any of its channels: each has a path of its own.
            reads=("signal",),
        )
        register_term(term, _box_guidance(box))


def _small(channel: str) -> str:
    title = _INSTRUMENT_TITLES[channel]
    return title[0].lower() + title[1:]


def _register_pairs() -> None:
    for one, other in SWAPPABLE_PAIRS:
        term = SwappedChannels(
            id=f"sensor.{one}_{other}.swapped",
            title=f"{_INSTRUMENT_TITLES[one]} and {_small(other)} are swapped",
            equation=f"{one} recorded = {other}, {other} recorded = {one}",
            target=f"sensor.{one}_{other}",
            reads=(one, other),
            pair=(one, other),
        )
        register_term(
            term,
            EffectGuidance(
                mistaken_for=(f"sensor.{one}.reversed", f"sensor.{other}.reversed"),
                separated_by=f"{_EXCITING[one]}, then {_EXCITING[other]}, one after the other; on "
                "the ground, turning and tilting the aircraft by hand shows which chart answers",
                effect_class="B",
                needs=(one, other),
                source="Seanor, flights 14 to 18: all three gyros measured q",
            ),
        )


_POSITION_TITLES = {
    "alpha_vane": "Alpha vane",
    "beta_vane": "Beta vane",
    "accelerometer": "Accelerometer",
    "air_data": "Pitot tube",
}
_AXIS_TITLES = {"x": "further forward or aft", "y": "to one side", "z": "higher or lower"}
_POSITIONS = {
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
"""The axes along which a place shows (a pitot tube further forward sees the same speed), and what
it is mistaken for."""
_POSITION_CHANNEL = {
    "alpha_vane": "alpha",
    "beta_vane": "beta",
    "accelerometer": "an",
    "air_data": "V",
}


def _of_span(share: float) -> Callable[[Aircraft], float]:
    return lambda aircraft: share * aircraft.geometry.span


def _register_positions() -> None:
    for name, alike in _POSITIONS.items():
        _, instrument, axis = name.split(".")
        lateral = name in ("sensor.alpha_vane.y", "sensor.beta_vane.z", "sensor.accelerometer.y")
        quick = "quick aileron doublets" if lateral else "quick elevator and rudder doublets"
        register_offset(
            name,
            f"place.{instrument}.{axis}",
            "m",
            _of_span(0.02 if instrument == "accelerometer" else 0.1),
            f"{_POSITION_TITLES[instrument]} sits {_AXIS_TITLES[axis]} than in the aircraft file",
            EffectGuidance(
                mistaken_for=alike,
                separated_by=f"{quick}: the share of the rotation grows with its rate and "
                "acceleration; a tape measure from the center of gravity "
                "determines it at once",
                effect_class="B",
                needs=(_POSITION_CHANNEL[instrument],),
                source="kinematics: what sensors at (x, y, z) from the CG show",
            ),
        )


_register_sensors()
_register_boxes()
_register_pairs()
_register_positions()

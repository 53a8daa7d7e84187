"""Effects on the paths of controls, between command and surface, and of the instruments.

Those of instruments are of each channel, of boxes and pairs of them, of where they sit.
"""

from __future__ import annotations

from collections.abc import Callable

from gsapp.aircraft import Aircraft
from gsapp.dynamics.effects.effect_registration import (
    DELAY,
    TAU,
    register_offset,
    register_signal_term,
    register_term,
)
from gsapp.dynamics.signal_terms import (
    INPUT_CHANNELS,
    INSTRUMENT_BOXES,
    SCALED_GROUPS,
    SENSOR_CHANNELS,
    SURFACE_CHANNELS,
    SWAPPABLE_PAIRS,
    Backlash,
    Bias,
    Delay,
    Lag,
    RateLimit,
    Saturation,
    ScaleFactor,
    SignReversal,
    SwappedChannels,
)
from gsapp.dynamics.terms import EffectGuidance, Parameter

_COEFFICIENTS = {"de": "Cm", "da": "Cl", "dr": "Cn"}
_SLOP = (Parameter("slop", "rad", 0.02, (0.0, 0.2), "full width of the play"),)
_TRAVEL = (Parameter("limit", "rad", 0.1, (0.0, 1.6), "largest deflection reached", 1.6),)
_RATE = (Parameter("limit", "rad/s", 1.0, (0.01, 100.0), "fastest deflection", 100.0),)
_GEARING = (Parameter("gearing", "", 0.8, (-3.0, 3.0), "deflection over record", 1.0),)


def _register_controls() -> None:
    for surface, channel in SURFACE_CHANNELS.items():
        word, path, needs = surface.capitalize(), f"control.{surface}", (channel,)
        coefficient = _COEFFICIENTS.get(channel)
        cubic = () if coefficient is None else (f"aero.{coefficient}.{channel}3",)
        register_signal_term(
            Backlash,
            f"{path}.backlash",
            channel,
            f"{word} linkage has free play",
            f"{channel} moves only after the play of width slop",
            EffectGuidance(
                mistaken_for=(f"{path}.lag", f"{path}.delay", *cubic),
                separated_by=f"{surface} doublets of quarter and full stick: play takes the same "
                "angle from each; moving the surface by hand on the ground shows it at once",
                needs=needs,
                source="Seanor, section 3.5: linkage slop, servo not returning",
            ),
            _SLOP,
            ("position",),
        )
        register_signal_term(
            Saturation,
            f"{path}.saturation",
            channel,
            f"{word} does not reach full travel",
            f"{channel} = limit({channel}, -limit, limit)",
            EffectGuidance(
                mistaken_for=(*cubic, f"{path}.rate", f"{path}.gearing"),
                separated_by=f"{surface} doublets of half and full stick; full stick on the "
                "ground against a protractor",
                needs=needs,
                source="stops, or a servo stalled by the air load",
            ),
            _TRAVEL,
        )
        register_signal_term(
            Lag,
            f"{path}.lag",
            channel,
            f"{word} servo is slow",
            f"{channel}' = (command - {channel})/tau",
            EffectGuidance(
                mistaken_for=(f"{path}.delay", f"{path}.backlash", f"{path}.rate"),
                separated_by=f"{surface} doublets of very different step times (0.15 to 1 s), or "
                "a frequency sweep",
                needs=needs,
                source="first-order servo",
            ),
            TAU,
            ("position",),
        )
        register_signal_term(
            RateLimit,
            f"{path}.rate",
            channel,
            f"{word} servo is rate-limited",
            f"|{channel}'| <= limit",
            EffectGuidance(
                mistaken_for=(f"{path}.lag", f"{path}.saturation", *cubic),
                separated_by=f"{surface} doublets of quarter and full stick with the same step "
                "time: a rate limit spares the small ones",
                needs=needs,
                source="servo under load or low battery",
            ),
            _RATE,
            ("position",),
        )
        register_signal_term(
            Delay,
            f"{path}.delay",
            channel,
            f"{word} is delayed",
            f"{channel}(t) = command(t - delay)",
            EffectGuidance(
                mistaken_for=(f"{path}.lag", "sensor.surfaces.delay"),
                separated_by=f"{surface} doublets of very different step times, or a frequency "
                "sweep: a delay turns the phase and leaves the size",
                needs=needs,
                source="radio link, receiver and servo",
            ),
            DELAY,
            ("x1", "x2"),
        )
        register_signal_term(
            ScaleFactor,
            f"{path}.gearing",
            channel,
            f"{word} moves more or less than recorded",
            f"{channel} = gearing * recorded",
            EffectGuidance(
                mistaken_for=() if coefficient is None else (f"aero.{coefficient}.{channel}",),
                separated_by="nothing in flight: it multiplies every derivative of the surface",
                effect_class="C",
                remedy=f"move the {surface} on the ground and read a protractor against the "
                "record, from stop to stop",
                needs=needs,
                source="calibration of the surface or its linkage",
            ),
            _GEARING,
        )


_register_controls()


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


def _register_channel(channel: str) -> None:
    path, name, surface = (
        f"sensor.{channel}",
        _INSTRUMENT_TITLES[channel],
        channel in INPUT_CHANNELS,
    )
    unit, bias = _UNITS.get(channel, "rad"), _BIASES.get(channel, 0.015)
    clip_at = 0.1 if surface else _CLIPS.get(channel, _CLIP)
    alike, exciting = _COEFFICIENT[channel], _EXCITING[channel]
    protractor = "move the surface on the ground and read a protractor against the record"
    others = (
        f"{exciting}; surface and motion of the aircraft must agree in time"
        if surface
        else f"{exciting}, with the other instruments of the same motion recorded: the "
        "compatibility check needs no aerodynamics"
    )

    def guide(
        mistaken_for: tuple[str, ...],
        separated_by: str,
        source: str = _KINEMATICS,
        remedy: str = "",
    ) -> EffectGuidance:
        """Return the guidance for what is seen in flight; a remedy is for a surface alone."""
        return EffectGuidance(
            mistaken_for=mistaken_for,
            separated_by=separated_by if surface or not remedy else others,
            effect_class=("C" if remedy else "A") if surface else "B",
            remedy=remedy if surface else "",
            needs=(channel,),
            source=source,
        )

    register_signal_term(
        ScaleFactor,
        f"{path}.scale",
        channel,
        f"{name} has a scale error",
        f"{channel} recorded = scale * {channel}",
        guide(
            (alike, f"{path}.bias"),
            "nothing in flight: it multiplies every derivative of the surface",
            remedy=f"{protractor}, from stop to stop",
        ),
        (Parameter("scale", "", 1.1, (-3.0, 3.0), "recorded over true", 1.0),),
    )
    register_signal_term(
        Bias,
        f"{path}.bias",
        channel,
        f"{name} has an offset",
        f"{channel} recorded = {channel} + bias",
        guide(
            (f"{path}.scale", alike),
            "nothing in flight: it hides in the constant terms",
            remedy=f"{protractor}, at neutral",
        ),
        (Parameter("bias", unit, bias, (-30.0 * bias, 30.0 * bias), "recorded minus true"),),
    )
    register_signal_term(
        Delay,
        f"{path}.delay",
        channel,
        f"{name} is late",
        f"{channel} recorded(t) = {channel}(t - delay)",
        guide(
            (f"{path}.lag", _sensor_unit(channel)),
            f"{others}; quick doublets (steps of 0.2 s) show delays best",
        ),
        DELAY,
        ("x1", "x2"),
    )
    register_signal_term(
        Lag,
        f"{path}.lag",
        channel,
        f"{name} is filtered",
        f"recorded' = ({channel} - recorded)/tau",
        guide(
            (f"{path}.delay", _sensor_unit(channel)),
            f"{others}; doublets of different step times separate a filter from a delay",
        ),
        TAU,
        ("recorded",),
    )
    limits = (0.0, 100.0 * clip_at)
    register_signal_term(
        Saturation,
        f"{path}.clipping",
        channel,
        f"{name} reaches the end of its range",
        f"{channel} recorded = limit({channel}, -limit, limit)",
        guide(
            (f"{path}.scale", *_LIKE_CLIPPING.get(channel, ())),
            f"{exciting}, small and large: only the large ones reach the end, and the record shows "
            "a flat top",
            "Seanor, section 3.5: some early maneuvers went past the range of the gyros",
        ),
        (Parameter("limit", unit, clip_at, limits, "largest size recorded", 100.0 * clip_at),),
    )
    register_signal_term(
        SignReversal,
        f"{path}.reversed",
        channel,
        f"{name} has the wrong sign",
        f"{channel} recorded = -{channel}",
        guide(
            (alike,),
            "nothing in flight: all derivatives of the surface change sign",
            "Seanor, (7.3.13): the side-force row carries the wrong sign",
            "move the stick on the ground and look at the chart",
        ),
    )


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


_BOX_TITLES = {
    "airdata": "Clock of the air data (vanes, airspeed) is off",
    "inertial": "Clock of gyros and accelerometers is off",
    "attitude": "Clock of bank and pitch angle is off",
    "surfaces": "Clock of the surface positions is off",
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


_SCALED_TITLES = {
    "gyros": "All gyros have the same scale error",
    "attitude": "Bank and pitch angle have the same scale error",
}
_ON_GROUND = {
    "gyros": "turning the aircraft on the ground by a known angle and integrating the gyro",
    "attitude": "tilting the aircraft on the ground by a known angle",
}


def _register_scaled_groups() -> None:
    for group, channels in SCALED_GROUPS.items():
        (other,) = SCALED_GROUPS.keys() - {group}
        term = ScaleFactor(
            id=f"sensor.{group}.scale",
            title=_SCALED_TITLES[group],
            equation=f"recorded = scale * true for {', '.join(channels)}",
            parameters=(
                Parameter("scale", "", 1.03, (0.5, 2.0), "recorded over true", neutral=1.0),
            ),
            target=f"sensor.{group}",
            reads=("signal",),
        )
        register_term(
            term,
            EffectGuidance(
                mistaken_for=(
                    f"sensor.{other}.scale",
                    *(f"sensor.{channel}.scale" for channel in channels),
                ),
                separated_by="banks and pull-ups, large and slow, with all gyros, attitude and "
                "accelerometers recorded: the compatibility check needs no aerodynamics; "
                f"{_ON_GROUND[group]} shows it at once",
                effect_class="B",
                needs=channels,
                source=_KINEMATICS,
            ),
        )


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
    "boom": "Boom with both vanes",
}
_AXIS_TITLES = {
    "x": "further forward or aft than",
    "y": "to one side of where it is",
    "z": "higher or lower than",
}
_POSITIONS = {
    "sensor.alpha_vane.x": ("aero.CN.q", "sensor.alpha.delay", "sensor.alpha.lag"),
    "sensor.alpha_vane.y": ("aero.CN.p", "sensor.alpha.scale"),
    "sensor.beta_vane.x": ("aero.CY.r", "sensor.beta.delay", "sensor.beta.lag"),
    "sensor.beta_vane.z": ("aero.CY.p", "sensor.beta.scale"),
    "sensor.accelerometer.x": ("aero.CN.q", "aero.CY.r", "sensor.an.delay"),
    "sensor.accelerometer.y": ("aero.CN.da", "aero.CN.p", "sensor.alpha_vane.y"),
    "sensor.accelerometer.z": ("aero.CY.p", "aero.CA.q", "sensor.ay.delay"),
    "sensor.air_data.y": ("sensor.V.scale",),
    "sensor.air_data.z": ("sensor.V.scale",),
    "sensor.boom.x": ("sensor.alpha_vane.x", "sensor.beta_vane.x", "sensor.airdata.delay"),
}
"""The axes along which a place shows (a pitot tube further forward sees the same speed), and what
it is mistaken for."""
_POSITION_CHANNELS = {
    "alpha_vane": ("alpha",),
    "beta_vane": ("beta",),
    "accelerometer": ("an",),
    "air_data": ("V",),
    "boom": ("alpha", "beta"),
}
_VANE_AHEAD = (
    "a turn held steep: alpha and beta stand still there while q and r do not; a vane ahead shows "
    "less alpha by q x/V and more beta by r x/V all along, a late or filtered one is right; then "
    "a slow deceleration in level flight: alpha grows without q, which shows upwash and no "
    "position; a tape measure from the center of gravity determines it at once"
)
"""What parts the position of a vane from delay, lag and upwash."""
_AHEAD = ("sensor.alpha_vane.x", "sensor.beta_vane.x", "sensor.boom.x")


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
            f"{_POSITION_TITLES[instrument]} sits {_AXIS_TITLES[axis]} in the aircraft file",
            EffectGuidance(
                mistaken_for=alike,
                separated_by=_VANE_AHEAD
                if name in _AHEAD
                else f"{quick}: the share of the rotation grows with its rate and "
                "acceleration; a tape measure from the center of gravity "
                "determines it at once",
                effect_class="B",
                needs=_POSITION_CHANNELS[instrument],
                source="kinematics: what sensors at (x, y, z) from the CG show",
            ),
        )


for _channel in SENSOR_CHANNELS:
    _register_channel(_channel)
_register_boxes()
_register_scaled_groups()
_register_pairs()
_register_positions()

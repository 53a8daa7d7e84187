"""Effects on the paths of signals: of control surfaces, instruments, and boxes of instruments.

Importing this module enters ``control.<surface>.<kind>``, ``sensor.<channel>.<kind>``,
``sensor.<box>.delay`` and ``sensor.<one>_<other>.swapped`` in the registry of
`gsapp.dynamics.terms`. What they do to a signal is in `gsapp.dynamics.signal_terms`.
"""

from __future__ import annotations

from gsapp.dynamics.signal_terms import (
    INPUT_CHANNELS,
    INSTRUMENT_BOXES,
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
    SignalTerm,
    SignReversal,
    SwappedChannels,
)
from gsapp.dynamics.terms import Parameter, Term, TermFactory, register_effect


def _parameter(
    name: str,
    unit: str,
    default: float,
    bounds: tuple[float, float],
    description: str,
    neutral: float = 0.0,
) -> tuple[Parameter, ...]:
    return (
        Parameter(
            name=name,
            unit=unit,
            default=default,
            bounds=bounds,
            description=description,
            neutral=neutral,
        ),
    )


def _constant(term: Term) -> TermFactory:
    return lambda _: term


_TAU = _parameter("tau", "s", 0.06, (0.0, 1.0), "time constant")
_DELAY = _parameter("delay", "s", 0.05, (0.0, 0.5), "how late the signal is")


def _register_controls() -> None:
    for surface, channel in SURFACE_CHANNELS.items():
        word = surface.capitalize()
        target, reads = f"control.{surface}", (channel,)
        rows: tuple[SignalTerm, ...] = (
            Backlash(
                id=f"control.{surface}.backlash",
                title=f"{word} linkage has free play",
                equation=f"{channel} moves only when the play of width slop is used up",
                states=("position",),
                parameters=_parameter("slop", "rad", 0.02, (0.0, 0.2), "whole width of the play"),
                target=target,
                reads=reads,
            ),
            Saturation(
                id=f"control.{surface}.saturation",
                title=f"{word} does not reach its full travel",
                equation=f"{channel} = limit({channel}, -limit, limit)",
                parameters=_parameter(
                    "limit", "rad", 0.1, (0.0, 1.6), "largest deflection reached", 1.6
                ),
                target=target,
                reads=reads,
            ),
            Lag(
                id=f"control.{surface}.lag",
                title=f"{word} servo is slow",
                equation=f"{channel}' = (command - {channel})/tau",
                states=("position",),
                parameters=_TAU,
                target=target,
                reads=reads,
            ),
            RateLimit(
                id=f"control.{surface}.rate",
                title=f"{word} servo cannot move fast enough",
                equation=f"|{channel}'| <= limit",
                states=("position",),
                parameters=_parameter(
                    "limit", "rad/s", 1.0, (0.01, 100.0), "fastest deflection", 100.0
                ),
                target=target,
                reads=reads,
            ),
            Delay(
                id=f"control.{surface}.delay",
                title=f"{word} moves late",
                equation=f"{channel}(t) = command(t - delay)",
                states=("x1", "x2"),
                parameters=_DELAY,
                target=target,
                reads=reads,
            ),
            ScaleFactor(
                id=f"control.{surface}.gearing",
                title=f"{word} moves more or less than recorded",
                equation=f"{channel} = gearing * recorded",
                parameters=_parameter(
                    "gearing", "", 0.8, (-3.0, 3.0), "deflection over record", 1.0
                ),
                target=target,
                reads=reads,
            ),
        )
        for term in rows:
            register_effect(term.id, _constant(term))


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
                title=f"{name} reads too much or too little",
                equation=f"{channel} recorded = scale * {channel}",
                parameters=_parameter("scale", "", 1.1, (-3.0, 3.0), "recorded over true", 1.0),
                target=target,
                reads=reads,
            ),
            Bias(
                id=f"sensor.{channel}.bias",
                title=f"{name} has an offset",
                equation=f"{channel} recorded = {channel} + bias",
                parameters=_parameter(
                    "bias", unit, bias, (-30.0 * bias, 30.0 * bias), "recorded minus true"
                ),
                target=target,
                reads=reads,
            ),
            Delay(
                id=f"sensor.{channel}.delay",
                title=f"{name} is late",
                equation=f"{channel} recorded(t) = {channel}(t - delay)",
                states=("x1", "x2"),
                parameters=_DELAY,
                target=target,
                reads=reads,
            ),
            Lag(
                id=f"sensor.{channel}.lag",
                title=f"{name} is filtered",
                equation=f"recorded' = ({channel} - recorded)/tau",
                states=("recorded",),
                parameters=_TAU,
                target=target,
                reads=reads,
            ),
            Saturation(
                id=f"sensor.{channel}.clipping",
                title=f"{name} reaches the end of its range",
                equation=f"{channel} recorded = limit({channel}, -limit, limit)",
                parameters=_parameter(
                    "limit",
                    unit,
                    clip_at,
                    (0.0, 100.0 * clip_at),
                    "largest size recorded",
                    100.0 * clip_at,
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
        for term in rows:
            register_effect(term.id, _constant(term))


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
            parameters=_parameter(
                "delay",
                "s",
                0.02,
                (-0.2, 0.5),
                "how late the clock of the box is; negative: early, in recorded flights only",
            ),
            target=f"sensor.{box}",
            # Of any of its channels: each has a path of its own.
            reads=("signal",),
        )
        register_effect(term.id, _constant(term))


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
        register_effect(term.id, _constant(term))


_register_controls()
_register_sensors()
_register_boxes()
_register_pairs()

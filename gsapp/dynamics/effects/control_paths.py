"""Effects on the paths of controls, between command and surface."""

from __future__ import annotations

from gsapp.dynamics.effects.effect_registration import DELAY, TAU, register_signal_term
from gsapp.dynamics.signal_terms import (
    SURFACE_CHANNELS,
    Backlash,
    Delay,
    Lag,
    RateLimit,
    Saturation,
    ScaleFactor,
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

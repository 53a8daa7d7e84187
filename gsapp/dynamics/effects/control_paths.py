"""Effects on the paths of controls, between command and surface."""

from __future__ import annotations

from gsapp.dynamics.effects.effect_registration import DELAY, TAU, register_term
from gsapp.dynamics.signal_terms import (
    SURFACE_CHANNELS,
    Backlash,
    Delay,
    Lag,
    RateLimit,
    Saturation,
    ScaleFactor,
    SignalTerm,
)
from gsapp.dynamics.terms import EffectGuidance, Parameter

_COEFFICIENTS = {"de": "Cm", "da": "Cl", "dr": "Cn"}


def _register_controls() -> None:
    for surface, channel in SURFACE_CHANNELS.items():
        word = surface.capitalize()
        target = path = f"control.{surface}"
        reads = (channel,)
        coefficient = _COEFFICIENTS.get(channel)
        rows: tuple[SignalTerm, ...] = (
            Backlash(
                id=f"control.{surface}.backlash",
                title=f"{word} linkage has free play",
                equation=f"{channel} moves only after the play of width slop",
                states=("position",),
                parameters=(Parameter("slop", "rad", 0.02, (0.0, 0.2), "full width of the play"),),
                target=target,
                reads=reads,
            ),
            Saturation(
                id=f"control.{surface}.saturation",
                title=f"{word} does not reach full travel",
                equation=f"{channel} = limit({channel}, -limit, limit)",
                parameters=(
                    Parameter("limit", "rad", 0.1, (0.0, 1.6), "largest deflection reached", 1.6),
                ),
                target=target,
                reads=reads,
            ),
            Lag(
                id=f"control.{surface}.lag",
                title=f"{word} servo is slow",
                equation=f"{channel}' = (command - {channel})/tau",
                states=("position",),
                parameters=TAU,
                target=target,
                reads=reads,
            ),
            RateLimit(
                id=f"control.{surface}.rate",
                title=f"{word} servo is rate-limited",
                equation=f"|{channel}'| <= limit",
                states=("position",),
                parameters=(
                    Parameter("limit", "rad/s", 1.0, (0.01, 100.0), "fastest deflection", 100.0),
                ),
                target=target,
                reads=reads,
            ),
            Delay(
                id=f"control.{surface}.delay",
                title=f"{word} is delayed",
                equation=f"{channel}(t) = command(t - delay)",
                states=("x1", "x2"),
                parameters=DELAY,
                target=target,
                reads=reads,
            ),
            ScaleFactor(
                id=f"control.{surface}.gearing",
                title=f"{word} moves more or less than recorded",
                equation=f"{channel} = gearing * recorded",
                parameters=(
                    Parameter("gearing", "", 0.8, (-3.0, 3.0), "deflection over record", 1.0),
                ),
                target=target,
                reads=reads,
            ),
        )
        cubic = () if coefficient is None else (f"aero.{coefficient}.{channel}3",)
        guidance = {
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
                mistaken_for=() if coefficient is None else (f"aero.{coefficient}.{channel}",),
                separated_by="nothing in flight: it multiplies every derivative of the surface",
                effect_class="C",
                remedy=f"move the {surface} on the ground and read a protractor against the "
                "record, from stop to stop",
                needs=(channel,),
                source="calibration of the surface or its linkage",
            ),
        }
        for term in rows:
            register_term(term, guidance[term.id.rpartition(".")[2]])


_register_controls()

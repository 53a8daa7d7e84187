"""The catalog of effects: one frozen record each, and which of them can compete for a flight.

Formulas, parameters, bounds and guidance are those of the registered effects
(`gsapp.dynamics.effects`, entry points of the group ``gsapp.effects``).
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, fields
from functools import cache
from typing import Any, Literal

from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.dynamics.effects.unnamed_terms import is_unnamed
from gsapp.dynamics.signal_terms import SURFACE_CHANNELS
from gsapp.dynamics.terms import EffectGuidance, Parameter, create_term, effect_guidance, effect_ids
from gsapp.foundation import UnknownNameError
from gsapp.foundation.name_suggestions import did_you_mean
from gsapp.quantities.constants import DEGREE

EffectEntry = Literal[
    "coefficient", "propulsion", "control path", "instrument", "mass", "atmosphere"
]
"""Where in the chain from stick to record an effect enters."""


@dataclass(frozen=True, slots=True, kw_only=True)
class EffectRecord(EffectGuidance):
    """One effect of the catalog: its guidance, and what its term says."""

    id: str  # ``group.target.kind``.
    title: str  # In a field engineer's words.
    equation: str
    entry: EffectEntry  # Where it enters.
    target: str  # What its term adds to (`gsapp.dynamics.terms`); empty for the atmosphere.
    parameters: tuple[Parameter, ...]
    """Name, unit, bounds, plausible size (`Parameter.default`), of the shipped aircraft;
    `Term.defaults` gives those of another one."""
    disturbance: bool = False  # Whether it is no effect of the aircraft at all and is never named.

    @property
    def group(self) -> str:
        """Return the first part of the id: aero, propulsion, control, sensor, mass, atmosphere."""
        return self.id.partition(".")[0]


_ENTRIES: dict[str, EffectEntry] = {
    "aero": "coefficient",
    "propulsion": "propulsion",
    "control": "control path",
    "sensor": "instrument",
    "mass": "mass",
}

TURBULENCE = EffectRecord(
    id="atmosphere.turbulence",
    title="Gusts and turbulence",
    equation="u, v, w of the air add to the flow; Dryden spectra of rms gust",
    entry="atmosphere",
    target="",
    parameters=(
        Parameter(
            name="gust",
            unit="m/s",
            default=0.3,
            bounds=(0.0, 10.0),
            description="standard deviation of each component",
        ),
    ),
    mistaken_for=("aero.CN.memory", "aero.Cm.alphadot", "sensor.alpha.lag"),
    separated_by="the same maneuver repeated: what gusts do does not repeat; fly at dawn",
    effect_class="A",
    source="MIL-F-8785C, Dryden form; a disturbance of the flight, not of the model",
    disturbance=True,
)
"""Always a disturbance, never an effect to name."""


@cache
def all_effects() -> tuple[EffectRecord, ...]:
    """Return all records: registered effects in the order of their ids, then disturbances.

    Parameters are those of the shipped aircraft; `Term.defaults` gives the sizes of another one.
    """
    aircraft = load_aircraft("b777")
    records = [_create_record(effect_id, aircraft) for effect_id in effect_ids()]
    return (*records, TURBULENCE)


def find_effect(effect_id: str) -> EffectRecord:
    """Return the record of one effect.

    Raise UnknownNameError if the catalog has no such effect; the nearest are named. Structure
    without a name (``unnamed.CA.absbeta``) has a record, too.
    """
    if is_unnamed(effect_id):
        return _create_record(effect_id, load_aircraft("b777"), _UNNAMED)
    table = _table()
    if effect_id not in table:
        hint = did_you_mean(effect_id, table, "gsapp discrepancy --list lists all")
        raise UnknownNameError(f"the catalog has no effect '{effect_id}'; {hint}")
    return table[effect_id]


@cache
def _table() -> dict[str, EffectRecord]:
    return {one.id: one for one in all_effects()}


_UNNAMED = EffectGuidance(
    mistaken_for=(),
    separated_by="the same maneuvers, larger and at other angles and speeds: how the structure "
    "grows with them shows what it is",
    source="found in a record; no effect of the catalog is like it",
)


def _create_record(
    effect_id: str, aircraft: Aircraft, guidance: EffectGuidance | None = None
) -> EffectRecord:
    term = create_term(effect_id, aircraft)
    guidance = guidance or effect_guidance(effect_id)
    return EffectRecord(
        id=effect_id,
        title=term.title,
        equation=term.equation,
        entry=_ENTRIES.get(effect_id.partition(".")[0], "coefficient"),
        target=term.target,
        parameters=term.parameters,
        **{one.name: getattr(guidance, one.name) for one in fields(EffectGuidance)},
    )


# --- which can compete --------------------------------------------------------------------------

# A channel that stands in for one that is needed.
_SUBSTITUTE_CHANNELS: dict[str, tuple[str, ...]] = {
    "throttle": ("thrust",),
    "V": ("qbar", "dynamic_pressure"),
    "qbar": ("V", "dynamic_pressure"),
    "de": ("elevator_left", "elevator_right"),
    "da": ("aileron_left", "aileron_right"),
    "dr": ("rudder",),
}
_INPUTS = ("de", "da", "dr", "flap", "throttle")
_LIKE_THRUST = ("sensor.ax.bias", "aero.CX.speed")
"""Effects that show as thrust does, which falls with speed."""
_ALLOWED: dict[str, tuple[str, ...]] = {
    "position": (),
    "servo": ("backlash", "saturation"),
    "command": ("backlash", "saturation", "lag", "rate", "delay"),
}


def eligible_effects(
    aircraft: Aircraft,
    channels: Collection[str],
    *,
    moving: Collection[str] | None = None,
    variants: bool = False,
    highest_alpha: float | None = None,
) -> tuple[EffectRecord, ...]:
    """Return the effects that can compete; `excluded_effects` says why the others cannot.

    They are of class A and B, in the order of the catalog. Derivatives of the linear build-up are
    among them; the caller leaves out those that its baseline has free. Where the controls of the
    aircraft are measured decides on the effects of the control path.

    Parameters
    ----------
    channels : collection of str
        Channels recorded.
    moving : collection of str, optional
        Of surfaces, flap and throttle, those that move in these flights; by default all recorded.
    variants : bool
        Whether other forms of one effect (`EffectRecord.variant_of`) compete too. Beside the
        plain form they would only split its evidence.
    highest_alpha : float, optional
        Angle of attack that these flights reach, rad: effects beyond the linear range need more
        than that of the aircraft file.
    """
    reasons = excluded_effects(
        aircraft, channels, moving=moving, variants=variants, highest_alpha=highest_alpha
    )
    return tuple(one for one in all_effects() if one.id not in reasons)


def excluded_effects(
    aircraft: Aircraft,
    channels: Collection[str],
    *,
    moving: Collection[str] | None = None,
    variants: bool = False,
    highest_alpha: float | None = None,
) -> dict[str, str]:
    """Return, by id, why an effect cannot compete; arguments as in `eligible_effects`."""
    found = {}
    for one in all_effects():
        why = _exclusion_reason(one, aircraft, channels, moving)
        if not why and one.variant_of and not variants:
            why = f"looks like {one.variant_of}; tried after that is found"
        end = aircraft.limits.alpha_linear[1]
        if one.beyond_linear_alpha and highest_alpha is not None and highest_alpha < end:
            why = (
                f"needs angles of attack beyond the linear range: {end / DEGREE:.0f} deg; these "
                f"flights reach {highest_alpha / DEGREE:.1f} deg"
            )
        if why:
            found[one.id] = why
    return found


def _exclusion_reason(
    one: EffectRecord,
    aircraft: Aircraft,
    channels: Collection[str],
    moving: Collection[str] | None,
) -> str:
    if one.disturbance:
        return "a disturbance of the flight, never an effect of the aircraft"
    if one.effect_class == "C":
        return f"not observable in flight: {one.remedy}"
    if one.id in _LIKE_THRUST and not aircraft.states_thrust:
        return "looks like thrust, which the aircraft file does not state (state 0 for a glider)"
    for channel in one.needs:
        stand_ins = (channel, *_SUBSTITUTE_CHANNELS.get(channel, ()))
        if not any(name in channels for name in stand_ins):
            return f"needs {channel}, which is not recorded"
        if (
            moving is not None
            and channel in _INPUTS
            and not any(name in moving for name in stand_ins)
        ):
            return f"needs {channel} to move, but it is constant in these flights"
    return _path_reason(one, aircraft, channels)


def _positions(aircraft: Aircraft, channels: Collection[str]) -> list[str]:
    """Return the surfaces of which a measured position, not a command, is recorded."""
    return [
        name
        for name in SURFACE_CHANNELS.values()
        if getattr(aircraft.controls, name).kind != "command"
        and any(one in channels for one in (name, *_SUBSTITUTE_CHANNELS.get(name, ())))
    ]


def _path_reason(one: EffectRecord, aircraft: Aircraft, channels: Collection[str]) -> str:
    """Return why the way a control is measured leaves no room for an effect."""
    group, name, kind = one.id.split(".")
    if group == "control":
        channel = SURFACE_CHANNELS[name]
        measured = getattr(aircraft.controls, channel).kind
        if kind in _ALLOWED[measured]:
            return ""
        if measured == "position":
            return f"{channel} is measured on the surface, after servo and linkage"
        return f"{channel} is measured at the servo, which {kind} comes before"
    if name == "surfaces" and not _positions(aircraft, channels):
        return "no surface position is recorded, only commands"
    commanded = (
        name in SURFACE_CHANNELS.values() and getattr(aircraft.controls, name).kind == "command"
    )
    if group == "sensor" and commanded:
        return f"{name} is a command, not a measured position"
    return ""


# --- for programs -----------------------------------------------------------------------------


def effect_catalog_json() -> dict[str, Any]:
    """Return the JSON of ``gsapp discrepancy --catalog``: SI and radians; absent = null."""
    records = all_effects()
    return {
        "effects": [_record_json(one) for one in records if not one.disturbance],
        "disturbances": [_record_json(one) for one in records if one.disturbance],
    }


def _record_json(one: EffectRecord) -> dict[str, Any]:
    return {
        "effect": one.id,
        "title": one.title,
        "equation": one.equation,
        "entry": one.entry,
        "target": one.target or None,
        "class": one.effect_class,
        "parameters": {item.name: _parameter_json(item) for item in one.parameters},
        "mistaken_for": list(one.mistaken_for),
        "separated_by": one.separated_by,
        "remedy": one.remedy or None,
        "needs": list(one.needs),
        "derivative": one.derivative or None,
        "variant_of": one.variant_of or None,
        "decoy": one.decoy,
        "source": one.source,
    }


def _parameter_json(item: Parameter) -> dict[str, Any]:
    return {
        "unit": item.unit,
        "plausible": item.default,
        "neutral": item.neutral,
        "bounds": list(item.bounds),
        "free": item.free,
        "description": item.description,
    }

"""Which effects can compete for an aircraft and the channels that its flights recorded."""

from __future__ import annotations

from collections.abc import Collection

from gsapp.aircraft import Aircraft
from gsapp.discrepancy.effect_catalog.effect_record import EffectRecord
from gsapp.discrepancy.effect_catalog.registry import all_effects, find_effect
from gsapp.dynamics.signal_terms import SURFACE_CHANNELS
from gsapp.dynamics.terms import create_term

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
) -> tuple[EffectRecord, ...]:
    """Return the effects that can compete; `excluded_effects` says why the others cannot.

    Parameters
    ----------
    aircraft : Aircraft
        Where its controls are measured decides on the effects of the control path.
    channels : collection of str
        Channels recorded.
    moving : collection of str, optional
        Of surfaces, flap and throttle, those that move in these flights; by default all recorded.
    variants : bool
        Whether other forms of one effect (`EffectRecord.variant_of`) compete too. Beside the
        plain form they would only split its evidence.

    Returns
    -------
    tuple of EffectRecord
        Of class A and B, in the order of the catalog. Derivatives of the linear build-up are
        among them; the caller leaves out those that its baseline has free.
    """
    reasons = excluded_effects(aircraft, channels, moving=moving, variants=variants)
    return tuple(one for one in all_effects() if one.id not in reasons)


def excluded_effects(
    aircraft: Aircraft,
    channels: Collection[str],
    *,
    moving: Collection[str] | None = None,
    variants: bool = False,
) -> dict[str, str]:
    """Return, by id, why an effect cannot compete; arguments as in `eligible_effects`."""
    found = {}
    for one in all_effects():
        why = _exclusion_reason(one, aircraft, channels, moving)
        if not why and one.variant_of and not variants:
            why = f"looks like {one.variant_of}; tried once that is found"
        if why:
            found[one.id] = why
    return found


def plausible_sizes(effect_id: str, aircraft: Aircraft) -> dict[str, float]:
    """Return the plausible size of every parameter of an effect, by name, for an aircraft.

    Raises
    ------
    UnknownNameError
        If the catalog has no such effect.
    """
    one = find_effect(effect_id)
    if one.disturbance:
        return {item.name: item.default for item in one.parameters}
    return create_term(effect_id, aircraft).defaults


def _exclusion_reason(
    one: EffectRecord,
    aircraft: Aircraft,
    channels: Collection[str],
    moving: Collection[str] | None,
) -> str:
    if one.disturbance:
        return "a disturbance of the flight, never an effect of the aircraft"
    if one.effect_class == "C":
        return f"no flight can show it: {one.remedy}"
    for channel in one.needs:
        stand_ins = (channel, *_SUBSTITUTE_CHANNELS.get(channel, ()))
        if not any(name in channels for name in stand_ins):
            return f"needs {channel}, which is not recorded"
        if (
            moving is not None
            and channel in _INPUTS
            and not any(name in moving for name in stand_ins)
        ):
            return f"needs {channel} to move, which it does not in these flights"
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
            return f"{channel} is measured on the surface, behind servo and linkage"
        return f"{channel} is measured at the servo, which {kind} comes before"
    if name == "surfaces" and not _positions(aircraft, channels):
        return "no surface position is recorded, only commands"
    commanded = (
        name in SURFACE_CHANNELS.values() and getattr(aircraft.controls, name).kind == "command"
    )
    if group == "sensor" and commanded:
        return f"{name} is a command, not a measured position"
    return ""

"""The catalog of effects for programs: the JSON of ``gsapp discrepancy --list``.

SI and radians; absent = null.
"""

from __future__ import annotations

from typing import Any

from gsapp.discrepancy.effect_catalog import EffectRecord, all_effects
from gsapp.dynamics.terms import Parameter


def effect_catalog_json() -> dict[str, Any]:
    """Return all records, effects and disturbances apart, as strict JSON can hold them."""
    records = all_effects()
    return {
        "effects": [_record(one) for one in records if not one.disturbance],
        "disturbances": [_record(one) for one in records if one.disturbance],
    }


def _record(one: EffectRecord) -> dict[str, Any]:
    return {
        "effect": one.id,
        "title": one.title,
        "equation": one.equation,
        "entry": one.entry,
        "target": one.target or None,
        "class": one.effect_class,
        "parameters": {item.name: _parameter(item) for item in one.parameters},
        "mistaken_for": list(one.mistaken_for),
        "separated_by": one.separated_by,
        "remedy": one.remedy or None,
        "needs": list(one.needs),
        "derivative": one.derivative or None,
        "variant_of": one.variant_of or None,
        "decoy": one.decoy,
        "source": one.source,
    }


def _parameter(item: Parameter) -> dict[str, Any]:
    return {
        "unit": item.unit,
        "plausible": item.default,
        "neutral": item.neutral,
        "bounds": list(item.bounds),
        "free": item.free,
        "description": item.description,
    }

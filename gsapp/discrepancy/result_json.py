"""The answer of a search for programs: the JSON of ``gsapp discrepancy`` (DESIGN section 5).

SI and radians; absent = null. Beyond the fixed keys stand those that a program would otherwise have
to work out again: what each step closed, how good a candidate was on maneuvers left out, whether an
effect was forced.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from gsapp.discrepancy.results import (
    Alternative,
    DiscrepancyResult,
    FoundEffect,
    ModelStep,
    Observability,
)


def discrepancy_json(
    found: DiscrepancyResult, *, model: Path | str | None = None
) -> dict[str, Any]:
    """Return what `found` says, as strict JSON can hold it.

    Parameters
    ----------
    found : DiscrepancyResult
    model : Path or str, optional
        Where the revised model was written; null where it was not.

    Returns
    -------
    dict
        Numbers that are not finite are None.
    """
    content = {
        "verdict": found.verdict,
        "why": found.why,
        "disagreements": [asdict(one) for one in found.disagreements],
        "observability": [_observability(one) for one in found.observability],
        "ranking": [asdict(one) for one in found.ranking],
        "effects": [_effect(one) for one in found.effects],
        "values": {name: asdict(one) for name, one in found.values.items()},
        "alternatives": [_alternative(one) for one in found.alternatives],
        "disturbance": {"gust": None, **found.disturbance},
        "gap": asdict(found.gap),
        "steps": [_step(one) for one in found.steps],
        "instruments": [asdict(one) for one in found.instruments],
        "warnings": found.warnings,
        "model": None if model is None else str(model),
    }
    plain: dict[str, Any] = _plain(content)
    return plain


def _observability(one: Observability) -> dict[str, Any]:
    return {
        "effect": one.effect,
        "class": one.effect_class,
        "sigma": one.sigma,
        "sigma_size": one.sigma_size,
        "aliases": [name for name, _ in one.aliases],
        "cosines": [cosine for _, cosine in one.aliases],
        "fly": one.fly,
    }


def _effect(one: FoundEffect) -> dict[str, Any]:
    parameters = {
        name: {"value": value, "std": std} for name, (value, std) in one.parameters.items()
    }
    return {
        "effect": one.effect,
        "title": one.title,
        "equation": one.equation,
        "parameters": parameters,
        "confidence": one.confidence,
        "runner_up": one.runner_up or None,
        "margin": one.margin,
        "held_out": one.held_out,
        "forced": one.forced,
        "one_of": one.one_of,
    }


def _alternative(one: Alternative) -> dict[str, Any]:
    # A reader of the ranking looks for "effect": one id, or all that act together.
    return {"effect": "+".join(one.effects), **asdict(one)}


def _step(one: ModelStep) -> dict[str, Any]:
    return {
        "added": one.added or None,
        "model": one.model.name,
        "misfit": one.misfit,
        "gap": one.gap,
        "ranking": [asdict(candidate) for candidate in one.ranking],
    }


def _plain(value: Any) -> Any:
    """Return `value` in the types of JSON; numbers that are not finite become None."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if value is None or isinstance(value, bool | str | int):
        return value
    number = float(value)
    return number if math.isfinite(number) else None

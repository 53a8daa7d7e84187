"""Plans and readings as JSON, as the journal keeps them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

from calibration.plan import CalibrationPlan, InstrumentPlan

_TUPLES = ("settings", "check_settings", "travel")


def to_json_content(value: Any) -> Any:
    """Return a frozen record as tables, lists, texts and numbers."""
    if is_dataclass(value):
        return {one.name: to_json_content(getattr(value, one.name)) for one in fields(value)}
    if isinstance(value, Mapping):
        return {str(key): to_json_content(one) for key, one in value.items()}
    if isinstance(value, (tuple, list)):
        return [to_json_content(one) for one in value]
    return value


def plan_from_json(content: Mapping[str, Any]) -> CalibrationPlan:
    """Return the plan that a journal kept: it goes on by the plan that it was begun with."""
    instruments = tuple(_instrument(one) for one in content["instruments"])
    return CalibrationPlan(**{**content, "instruments": instruments})


def _instrument(content: Mapping[str, Any]) -> InstrumentPlan:
    tuples = {key: tuple(content[key]) for key in _TUPLES if content[key] is not None}
    return InstrumentPlan(**{**content, **tuples})

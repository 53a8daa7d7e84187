"""A calibration plan as JSON, so that a journal goes on by the plan that it was begun with."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from calibration.plan import CalibrationPlan, InstrumentPlan

_TUPLES = ("settings", "check_settings", "travel")


def plan_content(plan: CalibrationPlan) -> dict[str, Any]:
    """Return what a journal keeps of a plan."""
    return asdict(plan)


def plan_of(content: Mapping[str, Any]) -> CalibrationPlan:
    """Return the plan that a journal kept."""
    return CalibrationPlan(
        name=content["name"],
        instruments=tuple(_instrument(one) for one in content["instruments"]),
    )


def _instrument(content: Mapping[str, Any]) -> InstrumentPlan:
    tuples = {key: tuple(content[key]) for key in _TUPLES if content[key] is not None}
    return InstrumentPlan(**{**content, **tuples})

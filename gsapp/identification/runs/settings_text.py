"""The settings of a run in words, each by its title."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from gsapp.foundation.settings import setting_info
from gsapp.identification.estimate_settings import EstimateSettings
from gsapp.identification.methods import estimation_method
from gsapp.identification.runs.request import RunRequest

_DIGITS: Final = 6
"""Enough for people; all of them tell settings apart that look alike."""
_ORIGINS: Final = frozenset({"label", "maneuver_windows", "every_grade", "as_found"})
"""They name the run, or tell where its maneuvers came from."""


def setting_title(name: str) -> str:
    """Return the title of a setting within a sentence."""
    return EstimateSettings.title_of(name).lower()


def describe_settings(request: RunRequest, *, digits: int = _DIGITS) -> dict[str, str]:
    """Return every setting of a run in words, by its title; maneuvers and flights are none.

    `digits`: significant digits of numbers.
    """
    model, weights = request.known_model, request.response_weights
    values = {name: getattr(request, name) for name in EstimateSettings.model_fields}
    values |= {
        "method": estimation_method(request.method).title,
        "model": "" if model is None else model.name,
        "weights": "; ".join(
            f"{flight or 'others'}: {_text(found, digits) or 'from the residuals'}"
            for flight, found in (weights or {}).items()
        ),
    }
    described = {}
    for name, field in EstimateSettings.model_fields.items():
        if name in _ORIGINS:
            continue
        info = setting_info(field)
        text = dict(info.choices).get(values[name]) if info.choices else None
        text = text or _text(values[name], digits)
        described[setting_title(name)] = (
            f"{text} {info.unit}".strip() if text else info.default_text
        )
    return {**described, "left out of the means": ", ".join(request.without) or "none"}


def _text(value: Any, digits: int) -> str:
    """Return a value in words; empty for none."""
    match value:
        case bool():
            return "yes" if value else "no"
        case float():
            return f"{value:.{digits}g}"
        case Mapping():
            return ", ".join(f"{name} {_text(one, digits)}" for name, one in value.items())
        case (float() as number, float() as std):
            return f"{_text(number, digits)} ± {_text(std, digits)}"
        case tuple():
            return ", ".join(value)
    return "" if value is None else str(value)


def setting_differences(one: RunRequest, other: RunRequest) -> tuple[tuple[str, str, str], ...]:
    """Return the settings in which two runs differ: title, the one's, the other's in words."""
    exact = describe_settings(one, digits=17), describe_settings(other, digits=17)
    short = describe_settings(one), describe_settings(other)
    found = []
    for name in exact[0]:
        if exact[0][name] != exact[1][name]:
            words = short if short[0][name] != short[1][name] else exact
            found.append((name, words[0][name], words[1][name]))
    if one.known_model != other.known_model and not any(row[0] == "model" for row in found):
        found.append(("model", "its values", "other values of the same name"))
    return tuple(found)

"""What the states, verdicts and surfaces are called on the page. No Qt."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Final

from gsapp.excitation.doublets.verdict import InputVerdict, VerdictResult
from gsapp.excitation.trim.trim_cue import TrimDeviation, TrimState
from gsapp.quantities import SURFACE_NAMES, ChannelSpec, from_si
from ui.number_format import DASH, number_text, unit_text
from ui.pilot.cue_display import DisplayTone, SignName

TRIM_STATE_SIGNS: Final[Mapping[TrimState, tuple[str, SignName, DisplayTone]]] = {
    "blind": ("NO CUE", "unknown", "unknown"),
    "ground": ("ON THE GROUND", "level", "plain"),
    "fly": ("FLY", "stick", "plain"),
    "hold": ("HOLD", "hold", "plain"),
    "go": ("GO", "go", "good"),
    "gusty": ("WAIT", "wait", "caution"),
    "turn": ("TURN", "turn", "plain"),
}
"""Word, shape and color of every state."""

RESULT_SIGNS: Final[Mapping[VerdictResult, tuple[str, SignName, DisplayTone]]] = {
    "good": ("GOOD", "check", "good"),
    "too-small": ("TOO SMALL", "more", "caution"),
    "too-large": ("TOO LARGE", "less", "caution"),
    "too-fast": ("TOO FAST", "slower", "caution"),
    "too-slow": ("TOO SLOW", "quicker", "caution"),
    "not-trimmed": ("NOT TRIMMED", "level", "caution"),
    "spoiled": ("SPOILED", "cross", "caution"),
    "unclear": ("UNCLEAR", "unknown", "unknown"),
}
"""Word, shape and color of every verdict; an arrow shows what to do next time."""

_SIDE_SIGNS: Final[Mapping[str, tuple[SignName, SignName]]] = {
    "bank": ("wing-left", "wing-right"),
    "roll rate": ("wing-left", "wing-right"),
    "turn": ("turn-left", "turn-right"),
    "yaw rate": ("turn-left", "turn-right"),
}
"""Shapes of what is off to the left and to the right."""


def find_sign(off: TrimDeviation) -> SignName:
    """Return the shape of what is off: wings and turns as they are, for all else the way back."""
    left, right = _SIDE_SIGNS.get(off.quantity, ("up", "down"))
    return left if off.amount < 0.0 else right


def surfaces_text(surfaces: Iterable[str]) -> str:
    """Return ``aileron and rudder``."""
    return " and ".join(SURFACE_NAMES.get(name, name) for name in surfaces)


def coarse_number_text(spec: ChannelSpec, value: float | None, system: str, decimals: int) -> str:
    """Return an SI value as a number that is read from afar: fewer digits, no unit."""
    if value is None:
        return DASH
    shown = spec.display_unit(system)
    return number_text(from_si(float(value), shown, spec.quantity), decimals)


def display_unit_text(spec: ChannelSpec, system: str) -> str:
    """Return the unit beside the number."""
    return unit_text(spec.display_unit(system))


def advice_text(verdict: InputVerdict) -> str:
    """Return what to do next time, without what the big word says already.

    "rudder doublet too small: half again" becomes "rudder: half again".
    """
    before, colon, after = verdict.advice.partition(": ")
    if not colon:
        return "" if verdict.result == "good" and verdict.advice == "good" else verdict.advice
    surface = SURFACE_NAMES.get(verdict.findings[0].surface, "") if verdict.findings else ""
    if surface and surface in before and surface not in after:
        return f"{surface}: {after}"
    return after

"""What the states, verdicts and surfaces are called on the page. No Qt."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Final

from gsapp.excitation.doublets.verdict import InputVerdict, VerdictResult
from gsapp.excitation.trim.trim_cue import TrimDeviation, TrimState
from gsapp.quantities import SURFACE_NAMES, ChannelSpec, from_si
from ui.number_format import DASH, number_text, unit_text
from ui.pilot.cue_display import DisplayTone, SignName
from ui.translation import QT_TR_NOOP, tr

TRIM_STATE_SIGNS: Final[Mapping[TrimState, tuple[str, SignName, DisplayTone]]] = {
    "blind": (QT_TR_NOOP("NO CUE"), "unknown", "unknown"),
    "ground": (QT_TR_NOOP("ON THE GROUND"), "level", "plain"),
    "fly": (QT_TR_NOOP("FLY"), "stick", "plain"),
    "hold": (QT_TR_NOOP("HOLD"), "hold", "plain"),
    "go": (QT_TR_NOOP("GO"), "go", "good"),
    "gusty": (QT_TR_NOOP("WAIT"), "wait", "caution"),
    "turn": (QT_TR_NOOP("TURN"), "turn", "plain"),
}
"""Word, shape and color of every state."""

RESULT_SIGNS: Final[Mapping[VerdictResult, tuple[str, SignName, DisplayTone]]] = {
    "good": (QT_TR_NOOP("GOOD"), "check", "good"),
    "too-small": (QT_TR_NOOP("TOO SMALL"), "more", "caution"),
    "too-large": (QT_TR_NOOP("TOO LARGE"), "less", "caution"),
    "too-fast": (QT_TR_NOOP("TOO FAST"), "slower", "caution"),
    "too-slow": (QT_TR_NOOP("TOO SLOW"), "quicker", "caution"),
    "not-trimmed": (QT_TR_NOOP("NOT TRIMMED"), "level", "caution"),
    "spoiled": (QT_TR_NOOP("SPOILED"), "cross", "caution"),
    "unclear": (QT_TR_NOOP("UNCLEAR"), "unknown", "unknown"),
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
    return tr(" and ").join(SURFACE_NAMES.get(name, name) for name in surfaces)


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

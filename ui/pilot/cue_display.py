"""What stands on the pilot's page at one moment, and what it is called. No Qt."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Final, Literal

from gsapp.excitation.doublets.verdict import InputVerdict, VerdictResult
from gsapp.excitation.trim.trim_cue import TrimDeviation, TrimState
from gsapp.quantities import SURFACE_NAMES, ChannelSpec, from_si
from ui.number_format import DASH, number_text, unit_text
from ui.translation import QT_TR_NOOP, tr

DisplayTone = Literal["plain", "good", "caution", "warning", "strong", "unknown"]
"""How something is colored: ``strong`` is ink with light letters, ``unknown`` has no value."""

SignName = Literal[
    "", "up", "down", "wing-left", "wing-right", "turn", "turn-left", "turn-right", "hold", "go",
    "wait", "hand", "stick", "check", "more", "less", "quicker", "slower", "level", "cross",
    "unknown", "danger", "land",
]  # fmt: skip
"""Shapes that say the same as the word, or which way; see `ui.pilot.sign_shapes`."""


STATEMENT_SEPARATOR: Final = " · "
"""Between the statements of the small line."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Hint:
    """One thing that is off, or a piece of advice."""

    text: str
    sign: SignName = ""
    tone: DisplayTone = "plain"


@dataclass(frozen=True, slots=True, kw_only=True)
class Gauge:
    """A value with the band that is wanted."""

    title: str
    number: str
    unit: str = ""
    """The value now; a dash where it is missing."""
    target_text: str = ""
    """In words: ``want 100 ± 5``; empty where nothing is wanted."""
    marker: float | None = None
    """Where the value stands on the bar, 0 to 1; beyond, it stands at the end as an arrow."""
    low: float | None = None
    high: float | None = None
    """Where the wanted band stands on the bar; None where nothing is wanted."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CardDisplay:
    """The card that comes next, and what time there is."""

    heading: str = ""
    text: str = ""
    benefit_text: str = ""
    problem: bool = False
    """Whether `benefit_text` says instead what is wrong with it."""
    time_left_text: str = ""
    maneuvers_left_text: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class CueDisplay:
    """The whole page."""

    status_text: str
    sign: SignName = ""
    tone: DisplayTone = "plain"
    ring: float | None = None
    """Share of a ring around the sign: how much of the steady time has passed, or how much of
    the hands-off interval is left; None for no ring."""
    count: str = ""
    hints: tuple[Hint, ...] = ()
    """What is off, the largest first, or the advice; two at most."""
    gauges: tuple[Gauge, ...] = ()
    """The test point, or the input while it is made; two at most."""
    leg_time_text: str = ""
    """Seconds of straight leg left; a dash where nobody knows."""
    leg_short: bool = False
    card: CardDisplay = CardDisplay()
    footer: str = ""
    """What can and cannot be judged."""

    @property
    def accessible_text(self) -> str:
        """Return the page in words, for those who hear it."""
        gauges = (f"{one.title} {one.number} {one.unit} {one.target_text}" for one in self.gauges)
        parts = (
            f"{self.status_text} {self.count}".rstrip(),
            *(hint.text for hint in self.hints),
            *gauges,
            tr("leg {time} s").format(time=self.leg_time_text) if self.leg_time_text else "",
            self.card.text,
            self.card.benefit_text,
            self.card.time_left_text,
            self.footer,
        )
        return ". ".join(part for part in parts if part)


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
    "invalid": (QT_TR_NOOP("INVALID"), "cross", "caution"),
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

    "rudder doublet too small: 50 % larger" becomes "rudder: 50 % larger".
    """
    before, colon, after = verdict.advice.partition(": ")
    if not colon:
        return "" if verdict.result == "good" and verdict.advice == "good" else verdict.advice
    surface = SURFACE_NAMES.get(verdict.findings[0].surface, "") if verdict.findings else ""
    if surface and surface in before and surface not in after:
        return f"{surface}: {after}"
    return after

"""What stands on the pilot's page at one moment: five things and a small line. No Qt."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

from ui.translation import tr

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
    """Which card, how many of it are good: ``NEXT C1 · 2 of 4``."""
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
    """Number inside the ring, in place of the sign."""
    hints: tuple[Hint, ...] = ()
    """What is off, the largest first, or the advice; two at most."""
    gauges: tuple[Gauge, ...] = ()
    """The test point, or the input while it is made; two at most."""
    leg_time_text: str = ""
    """Seconds of straight leg left; a dash where nobody knows."""
    leg_short: bool = False
    """Whether it is too short for an input."""
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

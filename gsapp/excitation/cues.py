"""What the cues are at one moment, and what happened so far: the records that a page shows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from gsapp.excitation.alerts.alert import Alert
from gsapp.excitation.doublets.verdict import InputInProgress, InputVerdict
from gsapp.excitation.information.outlook import Outlook
from gsapp.excitation.settings import CUES
from gsapp.excitation.test_points.point import TestPoint
from gsapp.excitation.test_points.target_input import TargetInput
from gsapp.excitation.trim.trim_cue import TrimCue
from gsapp.flight.cards import TestCard

EventKind = Literal["trim", "input", "hands-off", "verdict", "danger", "card"]

CardSelectionReason = Literal["chosen", "captured", "most to gain", "next on the list"]
"""How the card to be flown was found."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CueEvent:
    """Something that changed what the crew is told."""

    time: float
    """Flight time, s."""
    kind: EventKind
    """See `EventKind`."""
    state: str
    """``trim``: a state of `TrimCue`; ``input``: ``made``, noted once the sticks are let go;
    ``hands-off``: ``begins``, ``ends`` or ``broken``; ``verdict``: its result; ``danger``:
    ``caution``, ``warning`` or ``over``; ``card``: ``next``, ``chosen``, ``captured`` or
    ``done``."""
    text: str = ""
    """Short enough to be spoken."""
    data: Mapping[str, Any] = field(default_factory=dict)
    """Further values that JSON can hold, SI."""

    def to_json(self) -> dict[str, Any]:
        """Return what a program reads."""
        return {
            "time": round(self.time, 6),
            "kind": self.kind,
            "state": self.state,
            "words": self.text,
            "data": dict(self.data),
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class NextCard:
    """The card that is to be flown now."""

    card: TestCard
    good_repeats: int
    """Repeats that count so far."""
    point: TestPoint | None
    """None where the card asks for what cannot be flown; `problem` says why."""
    target_input: TargetInput | None
    """None where no input can be told."""
    stick_text: Mapping[str, str]
    """By surface: "half stick, high rate"."""
    text: str
    """To be read and spoken: "aileron and rudder doublet at 100 ft/s, half stick, then two thirds
    rudder, low rate"."""
    reason: CardSelectionReason
    """How it was found."""
    problem: str = ""
    """What is wrong with the card, in words; empty for nothing."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CueSnapshot:
    """Everything that is to be told at one moment."""

    time: float | None = None
    """Flight time of the newest row judged, s; None before the first."""
    trim: TrimCue | None = None
    """None before the first row."""
    input_in_progress: InputInProgress | None = None
    """An input that is being made, or its answer awaited."""
    verdict: InputVerdict | None = None
    card: NextCard | None = None
    """None without cards, and once all are flown."""
    outlook: Outlook | None = None
    """What was learned and what comes next; None where no model tells."""
    alerts: tuple[Alert, ...] = ()
    """Those that stand, the most urgent first."""
    speed: float | None = None
    alpha: float | None = None
    """Airspeed, m/s, and angle of attack, rad, over the last half second; None where missing."""
    guidance: str = ""
    """Towards the test point, short; empty where there is nothing to say."""
    judged_by: tuple[str, ...] = ()
    """By what is judged, in words."""
    limitations: tuple[str, ...] = ()
    """What cannot be judged and why, in words."""
    unmeasured_surfaces: tuple[str, ...] = ()
    """Surfaces that nothing shows: an input on them gets no verdict."""
    good_repeats: int = 0
    requested_repeats: int = 0
    """Repeats that count, and those that all cards ask for."""
    event_count: int = 0
    """How many events the log holds: grows with every change."""

    @property
    def verdict_age(self) -> float | None:
        """Return the seconds since the latest verdict; None without one."""
        if self.verdict is None or self.time is None:
            return None
        return self.time - self.verdict.given_at

    @property
    def fresh_verdict(self) -> InputVerdict | None:
        """Return the latest verdict while it is news: see `CUES.verdict_display_time`."""
        age = self.verdict_age
        return self.verdict if age is not None and age <= CUES.verdict_display_time else None

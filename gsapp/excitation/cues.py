"""What the cues are at one moment, and what happened so far: the records that a page shows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final, Literal

from gsapp.excitation.alerts.alert import Alert
from gsapp.excitation.doublets.verdict import InputInProgress, InputVerdict
from gsapp.excitation.information.outlook import Outlook
from gsapp.excitation.test_points.point import TestPoint
from gsapp.excitation.test_points.target_input import TargetInput
from gsapp.excitation.trim.trim_cue import TrimCue
from gsapp.flight.cards import TestCard

EventKind = Literal["trim", "input", "hands-off", "verdict", "danger", "card"]

CardSelectionReason = Literal["chosen", "captured", "most to gain", "next on the list"]
"""How the card to be flown was found."""

VERDICT_DISPLAY_TIME: Final = 6.0
"""Seconds for which a verdict is the news: until then the pilot is busy with the recovery."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CueEvent:
    """Something that changed what the crew is told.

    Attributes
    ----------
    time : float
        Flight time, s.
    kind : str
        See `EventKind`.
    state : str
        ``trim``: a state of `TrimCue`; ``input``: ``made``, noted once the sticks are let go;
        ``hands-off``: ``begins``, ``ends`` or ``broken``; ``verdict``: its result;
        ``danger``: ``caution``, ``warning`` or ``over``; ``card``: ``next``, ``chosen``,
        ``captured`` or ``done``.
    text : str
        Short enough to be spoken.
    data : mapping
        Further values that JSON can hold, SI.
    """

    time: float
    kind: EventKind
    state: str
    text: str = ""
    data: Mapping[str, Any] = field(default_factory=dict)

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
    """The card that is to be flown now.

    Attributes
    ----------
    card : TestCard
    good_repeats : int
        Repeats that count so far.
    point : TestPoint or None
        None where the card asks for what cannot be flown; `problem` says why.
    target_input : TargetInput or None
        None where no input can be told.
    stick_text : mapping of str to str
        By surface: "half stick, high rate".
    text : str
        To be read and spoken: "aileron and rudder doublet at 100 ft/s, half stick, then two
        thirds rudder, low rate".
    reason : {"chosen", "captured", "most to gain", "next on the list"}
        How it was found.
    problem : str
        What is wrong with the card, in words; empty for nothing.
    """

    card: TestCard
    good_repeats: int
    point: TestPoint | None
    target_input: TargetInput | None
    stick_text: Mapping[str, str]
    text: str
    reason: CardSelectionReason
    problem: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class CueSnapshot:
    """Everything that is to be told at one moment.

    Attributes
    ----------
    time : float or None
        Flight time of the newest row judged, s; None before the first.
    trim : TrimCue or None
        None before the first row.
    input_in_progress : InputInProgress or None
        An input that is being made, or its answer awaited.
    verdict : InputVerdict or None
        The latest.
    card : NextCard or None
        None without cards, and once all are flown.
    outlook : Outlook or None
        What was learned and what comes next; None where no model tells.
    alerts : tuple of Alert
        Those that stand, the most urgent first.
    speed, alpha : float or None
        Airspeed, m/s, and angle of attack, rad, over the last half second; None where missing.
    guidance : str
        Towards the test point, short; empty where there is nothing to say.
    judged_by : tuple of str
        By what is judged, in words.
    limitations : tuple of str
        What cannot be judged and why, in words.
    unmeasured_surfaces : tuple of str
        Surfaces that nothing shows: an input on them gets no verdict.
    good_repeats, requested_repeats : int
        Repeats that count, and those that all cards ask for.
    event_count : int
        How many events the log holds: grows with every change.
    """

    time: float | None = None
    trim: TrimCue | None = None
    input_in_progress: InputInProgress | None = None
    verdict: InputVerdict | None = None
    card: NextCard | None = None
    outlook: Outlook | None = None
    alerts: tuple[Alert, ...] = ()
    speed: float | None = None
    alpha: float | None = None
    guidance: str = ""
    judged_by: tuple[str, ...] = ()
    limitations: tuple[str, ...] = ()
    unmeasured_surfaces: tuple[str, ...] = ()
    good_repeats: int = 0
    requested_repeats: int = 0
    event_count: int = 0

    @property
    def verdict_age(self) -> float | None:
        """Return the seconds since the latest verdict; None without one."""
        if self.verdict is None or self.time is None:
            return None
        return self.time - self.verdict.given_at

    @property
    def fresh_verdict(self) -> InputVerdict | None:
        """Return the latest verdict while it is news: see `VERDICT_DISPLAY_TIME`."""
        age = self.verdict_age
        return self.verdict if age is not None and age <= VERDICT_DISPLAY_TIME else None

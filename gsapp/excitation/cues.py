"""What the cues are at one moment, and everything that changed them, in order of flight time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from gsapp.excitation.alerts.alert import Alert, AlertLevel
from gsapp.excitation.doublets.verdict import InputInProgress, InputVerdict
from gsapp.excitation.information.outlook import Outlook
from gsapp.excitation.settings import CUES
from gsapp.excitation.test_points.point import TargetInput, TestPoint
from gsapp.excitation.trim.trim_cue import TrimCue
from gsapp.flight.cards import TestCard
from gsapp.quantities import SURFACE_NAMES

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


_URGENCY: Mapping[AlertLevel, str] = {AlertLevel.CAUTION: "caution", AlertLevel.WARNING: "warning"}


class CueLog:
    """Notes changes from one tick to the next."""

    def __init__(self, system: str = "US") -> None:
        self.system = system
        self.restart()

    def restart(self) -> None:
        self.events: list[CueEvent] = []
        self._trim = ""
        self._answer: float | None = None  # when the input began whose answer is awaited
        self._left = 0.0  # of the time for which the hands should be off, s
        self._dangers: dict[str, Alert] = {}
        self._card: tuple[str, str] = ("", "")

    def log_trim(self, cue: TrimCue) -> None:
        """Note a change of the trim cue."""
        if cue.state == self._trim:
            return
        self._trim = cue.state
        worst = cue.worst
        told = cue.state == "fly" and worst is not None
        self._add(
            cue.time,
            "trim",
            cue.state,
            worst.format_text(self.system) if told and worst is not None else "",
            {
                "off": [
                    {"quantity": off.quantity, "amount": off.amount, "share": off.tolerance_ratio}
                    for off in cue.deviations
                    if off.tolerance_ratio > 1.0
                ],
                "gusts": cue.gust_strength,
                "leg_left": cue.leg_time_left,
            },
        )

    def log_input(self, time: float, now: InputInProgress | None) -> None:
        """Note an input, once the sticks are let go, and its hands-off interval.

        Quick moves before that may turn out to be steering.
        """
        free = now is not None and now.phase == "hands-off"
        if self._answer is not None and (not free or now is None or now.t_input != self._answer):
            state = "ends" if now is None and self._left <= CUES.tick else "broken"
            self._add(time, "hands-off", state, "", {"t_input": self._answer})
            self._answer = None
        self._left = 0.0 if now is None else now.hands_off_left
        if free and now is not None and self._answer is None:
            self._answer = now.t_input
            text = " and ".join(SURFACE_NAMES[name] for name in now.surfaces)
            facts = {
                "t_input": now.t_input,
                "surfaces": list(now.surfaces),
                "amplitudes": dict(now.amplitudes),
            }
            self._add(time, "input", "made", text, facts)
            facts = {"t_input": now.t_input, "seconds": now.hands_off_total}
            self._add(time, "hands-off", "begins", "hands off", facts)

    def log_verdict(self, verdict: InputVerdict, go_at: float | None) -> None:
        """Note a verdict on an input that answered to a GO at some time (s), or to none."""
        self._add(
            verdict.given_at,
            "verdict",
            verdict.result,
            verdict.advice,
            {
                "id": verdict.id,
                "t_input": verdict.t_input,
                "surfaces": list(verdict.surfaces),
                "card": verdict.card,
                "counts": verdict.counts,
                "grade": verdict.grade,
                "go_at": go_at,
            },
        )

    def log_alerts(self, time: float, standing: Sequence[Alert]) -> None:
        """Note dangers that arose, grew worse, or are over."""
        now = {danger.key: danger for danger in standing}
        for key in [key for key in self._dangers if key not in now]:
            self._add(time, "danger", "over", "", {"key": key})
        for danger in standing:
            former = self._dangers.get(danger.key)
            if former is None or former.level < danger.level:
                facts = {"key": danger.key, "sentence": danger.text}
                self._add(time, "danger", _URGENCY[danger.level], danger.spoken_text, facts)
        self._dangers = now

    def log_card(self, time: float, card: NextCard | None, *, all_done: bool) -> None:
        """Note that another card is to be flown, or why."""
        key = ("", "done" if all_done else "") if card is None else (card.card.id, card.reason)
        if key == self._card:
            return
        former, self._card = self._card, key
        if card is not None and card.card.id != former[0]:
            state = card.reason if card.reason in ("chosen", "captured") else "next"
            self._add(time, "card", state, card.text, {"card": card.card.id, "why": card.reason})
        elif card is None and all_done:
            self._add(time, "card", "done", "all cards are flown", {})

    def _add(self, time: float, kind: Any, state: str, text: str, data: dict[str, Any]) -> None:
        self.events.append(CueEvent(time=time, kind=kind, state=state, text=text, data=data))

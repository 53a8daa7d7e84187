"""What is said aloud, and when it is held back: few words, no repeats, dangers first.

The rule:

1. While an input is made and its hands-off interval runs nothing is spoken. Dangers are a tone
   then; only a warning that calls for the ground or for the nose down is spoken even there. What
   was held back is said afterwards, if it still stands.
2. GO is a tone and one word. Losing it again is what is off, in a few words.
3. What is off is said when it becomes another thing, or the same by a good deal more; else it is
   repeated ever more rarely. What is off by far is not said at all: a pilot who climbs to the test
   point knows that he climbs.
4. A verdict is one sentence. The next card is said when the pilot has time to listen.

All that is decided here follows from flight time, so a replay says what was said in flight. Who
is heard when two want to speak at once is up to the voice.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal

from gsapp.excitation.alerts.alert import Alert, AlertLevel
from gsapp.excitation.cues import CueEvent
from gsapp.excitation.settings import CUES
from gsapp.excitation.trim.trim_cue import TrimCue, TrimDeviation

SpeechPriority = Literal["note", "prompt", "warning"]

GO_TONE: Final = "taken"
"""Goes up, as everything good does."""
LOST_TONE: Final = "moved"
HANDS_OFF_TONE: Final = "steady"
HANDS_ON_TONE: Final = "prompt"


_URGENT: Final = ("land", "stall", "nose down")
"""Words of a warning that is spoken even into a hands-off interval."""

_ALOUD: Final[Mapping[str, str]] = {
    "ft/s": "feet a second",
    "m/s": "meters a second",
    "deg/s": "degrees a second",
    "ft": "feet",
    "m": "meters",
    "deg": "degrees",
    "s": "seconds",
    "%": "percent",
}
"""How a voice says units; a symbol it would spell."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Announcement:
    """Something to be heard."""

    time: float
    """Flight time, s."""
    text: str
    """One short sentence; empty where the tone says it all."""
    priority: SpeechPriority
    tone: str = ""
    """Name of a tone to be played with it; empty for none."""


def spell_out_units(text: str) -> str:
    """Return words as a voice should say them: units in full."""
    said = [_ALOUD.get(word.rstrip(",;:."), "") for word in text.split(" ")]
    return " ".join(
        unit + word[len(word.rstrip(",;:.")) :] if unit and _follows_number(text, k) else word
        for k, (word, unit) in enumerate(zip(text.split(" "), said, strict=True))
    )


def _follows_number(text: str, place: int) -> bool:
    return place > 0 and text.split(" ")[place - 1].replace(".", "").lstrip("-").isdigit()


class Announcer:
    """Decides what is said."""

    def __init__(self, system: str = "US") -> None:
        self.system = system
        self.restart()

    def restart(self) -> None:
        self._silent_until = -math.inf
        self._recovers_until = -math.inf
        self._level_at = -math.inf  # when a turn should be over
        self._moving = False
        self._last_words = -math.inf  # when a sentence was given
        self._note: str | None = None  # waits until the pilot has time
        self._held: dict[str, Alert] = {}
        self._state = ""
        self._nagging = _RepeatTimer()

    def update(
        self,
        time: float,
        events: Sequence[CueEvent],
        trim: TrimCue | None,
        standing: Sequence[Alert] = (),
        *,
        moving: bool = False,
    ) -> tuple[Announcement, ...]:
        """Take in what happened since, and return what is to be heard, the most urgent first.

        Sticks that move quickly (`moving`) are an input, unless it turns out to be steering.
        """
        said: list[Announcement] = []
        self._moving = moving
        for event in events:
            if event.kind == "danger":
                said += self._danger(event, standing)
            elif event.kind == "hands-off":
                said += self._interval(event)
            elif event.kind == "verdict":
                self._silent_until = -math.inf
                self._recovers_until = event.time + CUES.recovery_time
                said.append(self._say(event.time, spell_out_units(event.text), "prompt"))
            elif event.kind == "card":
                self._note = spell_out_units(event.text)
        if not self._silent(time):
            said += self._held_back(time, standing)
        if not self._silent(time) and time >= self._recovers_until:
            said += self._trim(time, trim)
        else:
            self._state = ""  # what holds afterwards is news
        if not self._silent(time):
            said += self._noted(time)
        return tuple(sorted(said, key=lambda one: _ORDER.index(one.priority)))

    def _say(
        self, time: float, text: str, priority: SpeechPriority, tone: str = ""
    ) -> Announcement:
        if text:
            self._last_words = time
        return Announcement(time=time, text=text, priority=priority, tone=tone)

    def _silent(self, time: float) -> bool:
        return self._moving or time < self._silent_until

    def _interval(self, event: CueEvent) -> list[Announcement]:
        """Fall silent for the answer to an input."""
        if event.state == "begins":
            self._silent_until = math.inf
            self._nagging = _RepeatTimer()
            return [self._say(event.time, "hands off", "prompt", HANDS_OFF_TONE)]
        self._silent_until = event.time + CUES.verdict_silence
        if event.state == "ends":
            return [Announcement(time=event.time, text="", priority="prompt", tone=HANDS_ON_TONE)]
        return []

    def _danger(self, event: CueEvent, standing: Sequence[Alert]) -> list[Announcement]:
        if event.state == "over":
            self._held.pop(str(event.data.get("key")), None)
            return []
        warning = event.state == "warning"
        urgent = warning and any(word in event.text for word in _URGENT)
        tone = "warning" if warning else "caution"
        if self._silent(event.time) and not urgent:
            key = event.data.get("key")
            self._held.update({one.key: one for one in standing if one.key == key})
            return [Announcement(time=event.time, text="", priority="warning", tone=tone)]
        return [
            self._say(
                event.time, spell_out_units(event.text), "warning" if warning else "prompt", tone
            )
        ]

    def _held_back(self, time: float, standing: Sequence[Alert]) -> list[Announcement]:
        held, self._held = self._held, {}
        keys = {one.key for one in standing}
        return [
            self._say(
                time,
                spell_out_units(one.spoken_text),
                "warning" if one.level is AlertLevel.WARNING else "prompt",
            )
            for one in held.values()
            if one.key in keys
        ]

    def _trim(self, time: float, trim: TrimCue | None) -> list[Announcement]:
        if trim is None:
            return []
        former, self._state = self._state, trim.state
        if trim.state == "go":
            self._nagging = _RepeatTimer()
            return [self._say(time, "go", "prompt", GO_TONE)] if former != "go" else []
        lost = LOST_TONE if former == "go" else ""
        if former == "turn" and trim.state != "turn":
            self._level_at = time + CUES.roll_out_time
        if trim.state == "fly" and trim.worst is not None:
            text = spell_out_units(trim.worst.format_text(self.system))
            due = bool(lost) or (
                trim.worst.tolerance_ratio <= CUES.max_announced_ratio and time >= self._level_at
            )
            due = due and self._nagging.due(
                time, _deviation_key(trim.worst), abs(trim.worst.amount), bool(lost)
            )
        elif trim.state == "gusty":
            due, text = self._nagging.due(time, "gusty", 1.0, bool(lost)), "gusty, wait"
        elif trim.state == "turn" and former in ("go", "hold"):
            due, text = True, "turn"
        else:
            due, text = bool(lost), "hold"
        if due:
            return [self._say(time, text, "prompt", lost)]
        return [Announcement(time=time, text="", priority="prompt", tone=lost)] if lost else []

    def _noted(self, time: float) -> list[Announcement]:
        if self._note is None or time - self._last_words < CUES.note_silence:
            return []
        text, self._note = self._note, None
        return [self._say(time, text, "note")]


_ORDER: Final = ("warning", "prompt", "note")


class _RepeatTimer:
    """How often the same thing is said again."""

    def __init__(self) -> None:
        self._key = ""
        self._amount = 0.0
        self._time = -math.inf
        self._count = 0

    def due(self, time: float, key: str, amount: float, at_once: bool) -> bool:
        """Return whether it is time to say it, and count it as said."""
        passed = time - self._time
        if key != self._key:
            due, count = at_once or passed >= CUES.deviation_interval, 0
        elif amount > CUES.deviation_growth * self._amount:
            due, count = passed >= CUES.min_repeat_interval, self._count
        else:
            wait = CUES.repeat_intervals[min(self._count, len(CUES.repeat_intervals) - 1)]
            due, count = at_once or passed >= wait, self._count + 1
        if due:
            self._key, self._amount, self._time, self._count = key, amount, time, count
        return due


def _deviation_key(off: TrimDeviation) -> str:
    return f"{off.quantity} {'+' if off.amount > 0.0 else '-'}"

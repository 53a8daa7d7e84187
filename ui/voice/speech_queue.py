"""Which sentence is spoken, which waits, which is forgotten. No Qt, no sound.

The rule:

1. One sentence is spoken at a time and at most one waits: nothing that is heard is ever more than
   one sentence behind.
2. The more urgent goes first. It cuts off a less urgent one that is being spoken; what was cut
   off waits, unless something newer waits already.
3. Of two that would wait, the more urgent stays; of two equally urgent ones the newer, because it
   is what holds now.
4. Nothing is said twice: words that are being spoken or wait are not taken again, and the words
   said last only after `DISPLAY.repeat_interval` seconds, unless other words were said in between.
5. In a hush, as while the pilot's hands are off the sticks, nothing begins but what belongs to it:
   warnings wait for its end, all else is forgotten.
6. Mute acts at once: what is spoken is cut off, what waits is forgotten, and nothing is taken, so
   that nothing old is heard afterwards.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum

from ui.display_limits import DISPLAY


class UtterancePriority(IntEnum):
    """How urgent a sentence is."""

    NOTE = 0
    PROMPT = 1
    WARNING = 2


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Utterance:
    """Words to be spoken once."""

    text: str
    priority: UtterancePriority
    allowed_in_quiet: bool = False  # Whether it may be heard in a hush.


class SpeechQueue:
    """Decides what is heard; see the rule above."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        # To be heard now. Whoever speaks compares it with what it speaks after every call.
        self.speaking: Utterance | None = None
        self.waiting: Utterance | None = None  # To be heard next.
        self.is_muted = False  # Whether nothing is.
        self.is_quiet = False  # Whether only what belongs to the hush is.
        self._last = ""
        self._said_at = -math.inf

    def enqueue(self, text: str, priority: UtterancePriority, *, through: bool = False) -> None:
        """Take words to be said, now, next, or not at all.

        `through`: whether they may be heard in a hush, because whoever offers them knows of it.
        """
        text = text.strip()
        if self.is_muted or not text or self._is_repeat(text, priority):
            return
        held = self.is_quiet and not through
        if held and priority < UtterancePriority.WARNING:
            return
        if self.waiting is not None and self.waiting.text == text:
            self.waiting = None  # the same, and less urgent
        offered = Utterance(text=text, priority=priority, allowed_in_quiet=through)
        if held:
            if self.waiting is None or priority >= self.waiting.priority:
                self.waiting = offered
        elif self.speaking is None:
            self._begin(offered)
        elif priority > self.speaking.priority:
            self.waiting = self.waiting or self.speaking
            self._begin(offered)
        elif self.waiting is None or priority >= self.waiting.priority:
            self.waiting = offered

    def finished(self, utterance: Utterance) -> None:
        """Go on to what waits; an utterance that was cut off before has no say."""
        if utterance is not self.speaking:
            return
        self._said_at = self._clock()
        self.speaking = None
        self._speak_next()

    def set_quiet(self, hushed: bool) -> None:
        """Begin a hush, cutting off all but warnings, or end it and say what waits."""
        if hushed == self.is_quiet:
            return
        self.is_quiet = hushed
        if hushed:
            if self.waiting is not None and self.waiting.priority < UtterancePriority.WARNING:
                self.waiting = None
            if self.speaking is not None and self.speaking.priority < UtterancePriority.WARNING:
                self.speaking = None
                # What was cut off may be said again when it is over.
                self._last = ""
        else:
            self._speak_next()

    def set_muted(self, muted: bool) -> None:
        """Fall silent at once, or be ready to speak again."""
        self.is_muted = muted
        if muted:
            self.speaking = self.waiting = None
            # Whoever turns the sound on again wants to hear what holds then.
            self._last = ""

    def _is_repeat(self, text: str, priority: UtterancePriority) -> bool:
        if self.speaking is not None and self.speaking.text == text:
            return True
        if self.waiting is not None and self.waiting.text == text:
            return self.waiting.priority >= priority
        return text == self._last and self._clock() - self._said_at < DISPLAY.repeat_interval

    def _speak_next(self) -> None:
        """Say what waits, if it may be said and nothing else is."""
        waiting = self.waiting
        if (
            self.speaking is None
            and waiting is not None
            and (waiting.allowed_in_quiet or not self.is_quiet)
        ):
            self.waiting = None
            self._begin(waiting)

    def _begin(self, utterance: Utterance) -> None:
        self.speaking = utterance
        self._last = utterance.text
        self._said_at = self._clock()

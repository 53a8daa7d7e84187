"""How trim stood as an input began: the cues of the last minute."""

from __future__ import annotations

from collections import deque
from typing import Final

from gsapp.excitation.flight_rows import TICK_DURATION
from gsapp.excitation.trim.trim_cue import TrimCue

_KEPT: Final = 60.0
"""Seconds of cues kept."""
_GO_COUNTS: Final = 2.0
"""Seconds after GO was lost in which an input still answers to it: a hand takes its time."""


class TrimHistory:
    """Keeps one cue for each tick."""

    def __init__(self) -> None:
        self._cues: deque[TrimCue] = deque(maxlen=round(_KEPT / TICK_DURATION))

    def clear(self) -> None:
        """Forget all cues."""
        self._cues.clear()

    def add(self, cue: TrimCue) -> None:
        """Take in the cue of a tick."""
        self._cues.append(cue)

    def deviations_at(self, time: float) -> dict[str, float]:
        """Return what was off at a flight time (s), in tolerances, signed."""
        before = [cue for cue in self._cues if cue.time <= time]
        if not before:
            return {}
        return {
            off.quantity: off.tolerance_ratio if off.amount > 0.0 else -off.tolerance_ratio
            for off in before[-1].deviations
        }

    def go_before(self, time: float) -> float | None:
        """Return when the GO was given that an input at a flight time (s) answers to."""
        for cue in reversed(self._cues):
            if cue.time <= time:
                if cue.state == "go":
                    return cue.since
                if cue.time < time - _GO_COUNTS:
                    return None
        return None

"""Keeping the page calm: its words change at most twice a second. No Qt."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from ui.display_limits import DISPLAY
from ui.pilot.cue_display import CueDisplay, Gauge


class DisplayRateLimiter:
    """Lets another state through at once, and the words beside it when they have stood.

    Bars move all the time; numbers and sentences do not.
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._shown: CueDisplay | None = None
        self._changed = 0.0

    def reset(self) -> None:
        """Let everything through next time: the crew did something and looks for its answer."""
        self._shown = None

    def limit(self, sheet: CueDisplay) -> CueDisplay:
        shown, now = self._shown, self._clock()
        if (
            shown is None
            or _unlimited_part(sheet) != _unlimited_part(shown)
            or now - self._changed >= DISPLAY.min_text_time
        ):
            if shown is None or _text_part(sheet) != _text_part(shown):
                self._changed = now
            self._shown = sheet
        else:
            self._shown = replace(
                shown,
                ring=sheet.ring,
                count=sheet.count,
                gauges=tuple(map(_with_new_marker, shown.gauges, sheet.gauges)),
            )
        return self._shown


def _with_new_marker(shown: Gauge, new: Gauge) -> Gauge:
    return replace(shown, marker=new.marker)


def _unlimited_part(sheet: CueDisplay) -> tuple[object, ...]:
    """Return what is never held back: the state, what its gauges are of, a gauge that went."""
    return (sheet.status_text, sheet.sign, sheet.tone, tuple(one.title for one in sheet.gauges))


def _text_part(sheet: CueDisplay) -> tuple[object, ...]:
    """Return everything that is read, without what moves."""
    numbers = tuple((one.number, one.target_text) for one in sheet.gauges)
    return (sheet.status_text, sheet.hints, numbers, sheet.leg_time_text, sheet.card, sheet.footer)

"""Keeping the page calm: its words change at most twice a second. No Qt."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from ui.pilot.sheet import Gauge, Sheet

HOLD = 0.5
"""Seconds for which words stand at least."""


class Calm:
    """Lets another state through at once, and the words beside it when they have stood.

    Bars move all the time; numbers and sentences do not.

    Parameters
    ----------
    clock : callable
        Seconds of a clock that never goes back.
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._shown: Sheet | None = None
        self._changed = 0.0

    def release(self) -> None:
        """Let everything through next time: the crew did something and looks for its answer."""
        self._shown = None

    def calmed(self, sheet: Sheet) -> Sheet:
        """Return what is to be shown now."""
        shown, now = self._shown, self._clock()
        if shown is None or _state(sheet) != _state(shown) or now - self._changed >= HOLD:
            if shown is None or _words(sheet) != _words(shown):
                self._changed = now
            self._shown = sheet
        else:
            self._shown = replace(
                shown,
                ring=sheet.ring,
                count=sheet.count,
                gauges=tuple(map(_moved, shown.gauges, sheet.gauges)),
            )
        return self._shown


def _moved(shown: Gauge, new: Gauge) -> Gauge:
    """Return the gauge as it is shown with its marker where it is now."""
    return replace(shown, at=new.at)


def _state(sheet: Sheet) -> tuple[object, ...]:
    """Return what is never held back: the state, what its gauges are of, a gauge that went."""
    return (sheet.word, sheet.sign, sheet.tone, tuple(one.title for one in sheet.gauges))


def _words(sheet: Sheet) -> tuple[object, ...]:
    """Return everything that is read, without what moves."""
    numbers = tuple((one.number, one.wanted) for one in sheet.gauges)
    return (sheet.word, sheet.hints, numbers, sheet.leg, sheet.card, sheet.foot)

"""The range of a chart's y axis when the program chooses it: steady, not nervous."""

from __future__ import annotations

import math

from ui.strips.axis_ticks import round_range

_MARGIN = 0.06  # of the values' span, left free on either side when the range changes
_SHRINK = 0.5  # a range this much smaller would do
_SHRINK_DELAY = 4.0  # s for which it must have been enough


class AutoRange:
    """A range that widens as soon as it must and narrows only when that is clearly right.

    Parameters
    ----------
    least : float
        Smallest span, in displayed units: below it noise would look like motion.
    """

    __slots__ = ("_enough_since", "_least", "high", "low")

    def __init__(self, least: float) -> None:
        self._least = max(least, 1e-9)
        self._enough_since: float | None = None
        self.low = math.nan
        self.high = math.nan

    def target_range(self, low: float, high: float) -> tuple[float, float]:
        span = high - low
        if span < self._least:
            middle = (low + high) / 2.0
            low, high = middle - self._least / 2.0, middle + self._least / 2.0
        else:
            low, high = low - _MARGIN * span, high + _MARGIN * span
        return round_range(low, high)

    def update(self, low: float, high: float, now: float, *, at_once: bool = False) -> bool:
        """Take note of the values in sight; return whether the range changed.

        Parameters
        ----------
        low, high : float
            Lowest and highest value in sight; NaN if there is none.
        now : float
            s, of any clock that goes forward.
        at_once : bool
            Narrow without waiting, as when the picture was moved or zoomed.
        """
        if math.isnan(low) or math.isnan(high):
            return False
        wanted = self.target_range(low, high)
        if math.isnan(self.low):
            self.low, self.high = wanted
            return True
        if low < self.low or high > self.high:
            self._enough_since = None
            # Keep the end that still holds, so that only one label moves.
            self.low = min(wanted[0], self.low) if low < self.low else self.low
            self.high = max(wanted[1], self.high) if high > self.high else self.high
            self.low, self.high = round_range(self.low, self.high)
            return True
        if wanted[1] - wanted[0] > _SHRINK * (self.high - self.low):
            self._enough_since = None
            return False
        if self._enough_since is None or now < self._enough_since:
            self._enough_since = now
        if not at_once and now - self._enough_since < _SHRINK_DELAY:
            return False
        self._enough_since = None
        self.low, self.high = wanted
        return True

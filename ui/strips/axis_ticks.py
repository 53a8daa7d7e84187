"""Round numbers for axes: steps, ticks, and ranges that follow the values without nervousness."""

from __future__ import annotations

import itertools
import math

_TIME_STEPS = (
    0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5,
    1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 60.0, 120.0, 300.0, 600.0, 900.0, 1800.0, 3600.0,
)  # fmt: skip


def round_step(least: float) -> float:
    """Return the smallest of ..., 0.5, 1, 2, 5, 10, ... that is not below `least`."""
    exponent = math.floor(math.log10(least))
    for factor in (1.0, 2.0, 5.0, 10.0):
        step = factor * 10.0**exponent
        if step >= least * (1.0 - 1e-9):
            return step
    return 10.0 ** (exponent + 1)


def next_step(step: float) -> float:
    """Return the round step after `step`."""
    return round_step(step * 1.5)


def round_range(low: float, high: float) -> tuple[float, float]:
    """Return the narrowest range that holds both values and begins and ends at a round step."""
    step = round_step(max(high - low, 1e-12) / 8.0)
    return math.floor(low / step + 1e-9) * step, math.ceil(high / step - 1e-9) * step


def multiples(low: float, high: float, step: float) -> list[float]:
    """Return the multiples of `step` from `low` to `high`, both included."""
    first, last = math.ceil(low / step - 1e-6), math.floor(high / step + 1e-6)
    return [number * step + 0.0 for number in range(first, last + 1)]


def value_ticks(
    low: float, high: float, length: float, pad: float, apart: float, most: int = 6
) -> list[float]:
    """Return round values whose labels fit one above the other.

    Parameters
    ----------
    low, high : float
        The range of the axis.
    length, pad : float
        Pixels of the chart, and those free at either end.
    apart : float
        Least distance in pixels between the middles of two labels; a label at an edge is moved
        inwards by half of it.
    most : int
        No more than so many.
    """
    gain = (length - 2.0 * pad) / (high - low)

    def fitting(step: float) -> list[float]:
        ticks = multiples(low, high, step)
        if not ticks or len(ticks) > most + 2:
            return []
        places = [
            min(max(pad + gain * (value - low), apart / 2.0), length - apart / 2.0)
            for value in ticks
        ]
        # A label moved inwards from an edge gives way to its neighbor.
        if len(ticks) > 2 and places[1] - places[0] < apart:
            ticks, places = ticks[1:], places[1:]
        if len(ticks) > 2 and places[-1] - places[-2] < apart:
            ticks, places = ticks[:-1], places[:-1]
        close = [after - before for before, after in itertools.pairwise(places)]
        return ticks if len(ticks) <= most and min(close, default=apart) >= apart else []

    step = round_step((high - low) / (most + 1))
    while step <= high - low:
        ticks = fitting(step)
        if len(ticks) > 1:
            return ticks
        step = next_step(step)
    if length >= 1.4 * apart:
        # One label is no scale. The ends are round, and tell most.
        return [low, high]
    step = round_step((high - low) / 2.0)
    return [round((low + high) / 2.0 / step) * step]


def time_step(window: float, most: float) -> float:
    """Return the step of the time axis (s) at which not more than `most` labels appear."""
    for step in _TIME_STEPS:
        if window / step <= most:
            return step
    return math.ceil(window / most / 3600.0) * 3600.0


def step_decimals(step: float) -> int:
    """Return the digits after the point that multiples of a step need."""
    decimals = 0
    while decimals < 6 and abs(round(step, decimals) - step) > 1e-6 * step:
        decimals += 1
    return decimals


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

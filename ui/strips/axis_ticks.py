"""Round numbers: steps of axes, ranges that begin and end at them."""

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

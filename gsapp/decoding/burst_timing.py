"""Times of messages without a stamp that a link delivers in bursts.

A modem or a network may keep messages back and deliver a second of them at once. Timed by arrival
they would all have one time. They are spread at the rate at which they come on average, so that the
last of a burst has the time of its arrival and none lies before the one that came before the burst.
Only the arrivals tell, so a replay gives the same times.
"""

from __future__ import annotations

from collections import deque
from typing import Any, NamedTuple

from gsapp.decoding.settings import DECODING

_NEVER = 2**62


class SpreadItem(NamedTuple):
    """An item with the flight time that it is given, microseconds."""

    stream: int
    time: int
    item: Any


class _Arrivals:
    """Arrivals of one message, and the burst that is coming in."""

    __slots__ = ("held", "last", "steps", "time")

    def __init__(self) -> None:
        self.time: int | None = None  # Of the latest arrival.
        self.last: int | None = None  # Time given to the latest item that was placed.
        self.steps: deque[int] = deque(maxlen=DECODING.burst_window)
        self.held: list[Any] = []

    def burst_period(self) -> int:
        """Return the mean interval where most intervals are far shorter; 0 where they are not."""
        count = len(self.steps)
        if count < DECODING.min_burst_intervals:
            return 0
        ordered = sorted(self.steps)
        # One pause of the link is no burst, nor does it lengthen the period.
        longest = ordered[-DECODING.min_bursts]
        mean = sum(min(step, longest) for step in ordered) // count
        return mean if ordered[(count - 1) // 2] * DECODING.burst_ratio <= mean else 0


class BurstSpreader:
    """Spreads items of bursts over the time in which they were sent.

    `add` takes an item with the flight time (us) of its arrival; it returns that time where the
    message does not come in bursts. Others wait until their burst is over: `release` hands out
    those that do not wait any more at a flight time; `due` is when it has to be called next.
    """

    def __init__(self) -> None:
        self.due = _NEVER
        self._arrivals: dict[int, _Arrivals] = {}

    def add(self, stream: int, time: int, item: Any) -> int | None:
        arrivals = self._arrivals.setdefault(stream, _Arrivals())
        if arrivals.time is not None:
            arrivals.steps.append(max(time - arrivals.time, 0))
        arrivals.time = time
        period = arrivals.burst_period()
        if not period and not arrivals.held:
            arrivals.last = time
            return time
        arrivals.held.append(item)
        self.due = min(self.due, time + period // DECODING.burst_ratio)
        return None

    def release(self, time: int) -> list[SpreadItem]:
        """Return the items of bursts that are over at a flight time, us."""
        found: list[SpreadItem] = []
        self.due = _NEVER
        for stream, arrivals in self._arrivals.items():
            if not arrivals.held or arrivals.time is None:
                continue
            period = arrivals.burst_period()
            end = arrivals.time + period // DECODING.burst_ratio
            if time < end:
                self.due = min(self.due, end)
                continue
            count, newest = len(arrivals.held), arrivals.time
            if arrivals.last is not None:
                period = min(period, (newest - arrivals.last) // count)
            first = newest - (count - 1) * period
            for index, item in enumerate(arrivals.held):
                found.append(SpreadItem(stream, first + index * period, item))
            arrivals.held = []
            arrivals.last = newest
        return found

    def release_all(self) -> list[SpreadItem]:
        """Return all that still wait: nothing more will come."""
        return self.release(_NEVER)

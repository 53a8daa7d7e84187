"""Those who watch the samples of a flight, and how far each of them has come.

Some are a thousand times as quick as the flight (limits), some fifty times (cues for the pilot).
Where they begin late, in a replay that jumped or in a window that opens an hour into a flight, the
quick ones are not held up by the slow ones.
"""

from __future__ import annotations

import bisect
import math
from collections.abc import Callable, Sequence
from typing import Protocol, runtime_checkable

import numpy as np

from gsapp.quantities import Block
from gsapp.session.monitor_settings import MONITORS
from gsapp.session.sample_history import SampleHistory


class Consumer(Protocol):
    """Watches the samples of a flight in order."""

    def feed(self, block: Block) -> None:
        """Take in the next samples of some channels, on consecutive places of the grid."""

    def process_step(self) -> None:
        """Draw conclusions, after all blocks of a step; go on with longer work by a slice."""

    def reset(self) -> None:
        """Forget everything; the flight begins anew."""


@runtime_checkable
class SlowConsumer(Consumer, Protocol):
    """A consumer that works on what it saw for longer than a step takes."""

    def has_pending_work(self, time: float) -> bool:
        """Return whether that is to be done before samples up to a flight time (s) come.

        Where samples come as they happen nobody waits: then the rest is done at once when it is
        due. Where they come from the past it is given time instead, so that no step takes long.
        """


class GridSegments:
    """Where on the grid samples lie, as stretches without a long pause inside."""

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._pause = round(MONITORS.max_filled_pause * rate)
        self._firsts: list[int] = []
        self._lasts: list[int] = []

    def add(self, block: Block) -> None:
        """Add the samples of a block, which follow one another; pauses may lie between them."""
        if not len(block):
            return
        index = np.rint(block.times * self._rate).astype(np.int64)
        ends = np.flatnonzero(np.diff(index) > self._pause)
        firsts = index[np.append(0, ends + 1)].tolist()
        for first, last in zip(firsts, index[np.append(ends, -1)].tolist(), strict=True):
            self._insert(first, last)

    def _insert(self, first: int, last: int) -> None:
        index = bisect.bisect_right(self._firsts, first)
        # The one before may reach up to here.
        if index > 0 and first - self._lasts[index - 1] <= self._pause:
            index -= 1
            first = self._firsts.pop(index)
            last = max(last, self._lasts.pop(index))
        while index < len(self._firsts) and self._firsts[index] - last <= self._pause:
            last = max(last, self._lasts[index])
            del self._firsts[index], self._lasts[index]
        self._firsts.insert(index, first)
        self._lasts.insert(index, last)

    @property
    def first(self) -> int | None:
        return self._firsts[0] if self._firsts else None

    @property
    def last(self) -> int | None:
        return self._lasts[-1] if self._lasts else None

    def segment_from(self, index: int) -> tuple[int, int] | None:
        """Return the stretch that holds a place, from there on, or else the next one."""
        place = bisect.bisect_right(self._firsts, index)
        if place > 0 and self._lasts[place - 1] >= index:
            return index, self._lasts[place - 1]
        if place < len(self._firsts):
            return self._firsts[place], self._lasts[place]
        return None


class ConsumerCursor:
    """One consumer, and how far it has come.

    Attributes
    ----------
    next_index : int
        The next place on the grid that is to be given to it.
    """

    def __init__(self, consumer: Consumer, first: int) -> None:
        self.consumer = consumer
        self.next_index = first
        self._busy = consumer if isinstance(consumer, SlowConsumer) else None
        self._seconds_a_row = 0.0  # of its work, smoothed

    def restart(self, first: int) -> None:
        """Begin anew."""
        self.consumer.reset()
        self.next_index = first

    def process_pending_work(self, time: float) -> bool:
        """Give it a slice if it is to finish something before a flight time, s."""
        if self._busy is None or not self._busy.has_pending_work(time):
            return False
        self._busy.process_step()
        return True

    def rows_for(self, seconds: float, steps: tuple[int, int]) -> int:
        """Return how many rows it can be given in a time, between the shortest and longest step."""
        if not math.isfinite(seconds) or self._seconds_a_row <= 0.0:
            return steps[1]
        return min(max(int(seconds / self._seconds_a_row), steps[0]), steps[1])

    def feed_rows(self, block: Block, seconds: Callable[[], float]) -> None:
        """Give it rows that follow one another, and learn how long it takes."""
        began = seconds()
        self.consumer.feed(block)
        self.consumer.process_step()
        each = (seconds() - began) / len(block)
        self._seconds_a_row += 0.3 * (each - self._seconds_a_row)


class ConsumerScheduler:
    """Gives consumers what lies in a history, each from where it is."""

    def __init__(
        self,
        history: SampleHistory,
        stretches: GridSegments,
        consumers: Sequence[Consumer],
        clock: Callable[[], float],
    ) -> None:
        self._history = history
        self._stretches = stretches
        self._clock = clock
        self._steps = (
            min(max(round(MONITORS.min_step * history.rate), 1), MONITORS.max_rows),
            min(max(round(MONITORS.max_step * history.rate), 1), MONITORS.max_rows),
        )
        self._rows: tuple[int, int, Block] | None = None
        self.cursors = [ConsumerCursor(consumer, 0) for consumer in consumers]

    def restart(self, first: int) -> None:
        """Let all begin anew, at a place of the grid."""
        for follower in self.cursors:
            follower.restart(first)

    def feed_until(
        self,
        target: int,
        deadline: float,
        *,
        abreast: bool = False,
        reach: Callable[[int], None] = lambda _: None,
    ) -> bool:
        """Give what lies up to a place, until a deadline (s): one step each, at least.

        Returns whether nothing is left to be given.

        Parameters
        ----------
        target : int
            The last place of the grid that counts.
        abreast : bool
            Whether the one that is behind goes first; else the first in line has all that it
            wants before the next.
        reach : callable
            Called with the last place of each step before it is given.
        """
        self._rows = None
        served: set[int] = set()
        while True:
            late = self._clock() >= deadline
            wanting = [
                (number, follower, found)
                for number, follower in enumerate(self.cursors)
                if not (late and number in served)
                and (found := self._stretches.segment_from(follower.next_index)) is not None
                and found[0] <= target
            ]
            if not wanting:
                return not late or self.all_reached(target)
            number, follower, (first, end) = (
                min(wanting, key=lambda one: one[1].next_index) if abreast else wanting[0]
            )
            served.add(number)
            rows = follower.rows_for(deadline - self._clock(), self._steps)
            last = min(end, target, first + rows - 1)
            if follower.process_pending_work(last / self._history.rate):
                continue
            reach(last)
            follower.feed_rows(self._between(first, last), self._clock)
            follower.next_index = last + 1

    def all_reached(self, place: int) -> bool:
        """Return whether everybody was given everything up to a place."""
        return all(self.has_reached(follower, place) for follower in self.cursors)

    def has_reached(self, follower: ConsumerCursor, place: int) -> bool:
        """Return whether one was given everything up to a place."""
        found = self._stretches.segment_from(follower.next_index)
        return found is None or found[0] > place

    def progress(self, consumer: Consumer, place: int) -> float:
        """Return how much of the way to a place a consumer has come, 0 to 1."""
        first = self._stretches.first
        (follower,) = (one for one in self.cursors if one.consumer is consumer)
        near = place - round(MONITORS.max_delay * self._history.rate)
        if first is None or near <= first or self.has_reached(follower, near):
            return 1.0
        return max(follower.next_index - first, 0) / (place - first)

    def _between(self, first: int, last: int) -> Block:
        if self._rows is None or self._rows[:2] != (first, last):
            self._rows = (first, last, self._history.rows(first, last + 1))
        return self._rows[2]

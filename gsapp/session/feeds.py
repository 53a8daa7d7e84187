"""What drives a flight forward: the end of a growing record, or the playhead of a replay.

Both read the same records through the same decoder into the same history. Live, everything that
was read counts as having happened, and those who watch the samples (alarms, cues, estimators) get
them as they come; what lies behind when a window opens late is shown first and watched then. In a
replay the record is read ahead as fast as it goes, and the playhead decides what has happened:
charts see no further, and those who watch get the samples in order up to there.

Nothing here waits. Work is done in pieces until a deadline, so that the caller's timer is never
held up, and goes on in the next call.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol

from gsapp.foundation import FlightError
from gsapp.quantities import Block, join_blocks
from gsapp.session.consumer_scheduler import (
    Consumer,
    ConsumerCursor,
    ConsumerScheduler,
    GridSegments,
    SlowConsumer,
)
from gsapp.session.monitor_settings import MONITORS
from gsapp.session.sample_history import SampleHistory
from gsapp.session.snapshot import Playhead

UNLIMITED_SPEED = math.inf
MIN_REPLAY_SPEED, MAX_REPLAY_SPEED = 0.1, 50.0

_FEWEST, _MOST = 64, 4096
"""Records read at a time, as their decoding time allows."""


_BEFORE_FIRST_INDEX = -(2**62)


def parse_speed(text: str | float) -> float:
    """Return the speed of a replay, times real time.

    Raises
    ------
    FlightError
        If it is neither ``max`` nor a number from 0.1 to 50.
    """
    if str(text).strip().casefold() == "max":
        return UNLIMITED_SPEED
    try:
        speed = float(text)
    except ValueError:
        speed = math.nan
    if speed != UNLIMITED_SPEED and not MIN_REPLAY_SPEED <= speed <= MAX_REPLAY_SPEED:
        raise FlightError(
            f"invalid replay speed '{text}'; give {MIN_REPLAY_SPEED:g} to {MAX_REPLAY_SPEED:g} "
            "times real time, or max"
        )
    return speed


class ReadResult(NamedTuple):
    """What one reading gave: blocks, whether more is to come, and whether the disk has it still."""

    blocks: Sequence[Block]
    more: bool
    is_waiting: bool = False


class BlockReader(Protocol):
    """Gives the blocks of a flight in the order in which they became known."""

    def read(self, limit: int) -> ReadResult:
        """Take at most about `limit` records, and say whether more are waiting."""

    def finish(self) -> Sequence[Block]:
        """Give what was held back for samples that will not come; the record is complete."""

    @property
    def progress(self) -> float:
        """Return the share of the record that was read, 0 to 1."""


class _BatchSizer:
    """How many records to read at a time so that a deadline is kept."""

    def __init__(self) -> None:
        self._piece = _FEWEST
        self._each = 0.0  # seconds for one record, smoothed

    def piece(self, seconds: float) -> int:
        """Return how many records fit well into the time left."""
        if self._each > 0.0 and math.isfinite(seconds):
            wanted = int(0.5 * max(seconds, 0.0) / self._each)
        else:
            wanted = 4 * self._piece
        self._piece = min(max(wanted, _FEWEST), _MOST)
        return self._piece

    def took(self, seconds: float) -> None:
        """Learn from the time that the last piece took."""
        each = max(seconds, 0.0) / self._piece
        self._each = each if self._each == 0.0 else 0.7 * self._each + 0.3 * each


class LiveFeed:
    """Follows a record that grows.

    What was recorded before is read first, so that charts and values show the present as soon as
    can be. Then those who watch hear it from its beginning, and from where they have caught up
    they hear everything as it comes.

    Parameters
    ----------
    consumers : sequence of Consumer
        Who watches them, the most urgent first.

    Attributes
    ----------
    is_up_to_date : bool
        Whether everything recorded so far was read.
    """

    def __init__(
        self,
        reader: BlockReader,
        history: SampleHistory,
        consumers: Sequence[Consumer],
        clock: Callable[[], float],
    ) -> None:
        self._reader = reader
        self._history = history
        self._clock = clock
        self._pace = _BatchSizer()
        self._stretches = GridSegments(history.rate)
        self._following = ConsumerScheduler(history, self._stretches, consumers, clock)
        self._listening: list[tuple[Consumer, float]] = []  # and from which flight time on
        self._slow: list[SlowConsumer] = []  # Those of them with work between two steps.
        self._undelivered: list[Block] = []
        self._delivered_at = -math.inf
        self._begun = False
        self.is_up_to_date = False

    @property
    def now(self) -> float | None:
        return self._history.end

    @property
    def caught_up(self) -> bool:
        """Return whether everything recorded so far was read, and watched by consumers."""
        return self.is_up_to_date and self._begun and not self._following.cursors

    @property
    def progress(self) -> float:
        """Return the share of the record that was read, 0 to 1."""
        return 1.0 if self.is_up_to_date else self._reader.progress

    def monitored_fraction(self, consumer: Consumer) -> float:
        """Return how much of what there is a consumer has seen, 0 to 1."""
        if not any(one.consumer is consumer for one in self._following.cursors):
            return 1.0
        last = self._stretches.last
        if not self._begun or last is None:
            return 0.0
        return min(self._following.progress(consumer, last), MONITORS.max_progress)

    def advance(self, deadline: float) -> None:
        """Take in what was recorded since, until the clock shows `deadline`."""
        self._read(deadline)
        self._deliver()
        if self.is_up_to_date:
            self._catch_up(deadline)

    def finish(self) -> None:
        """Take in the rest of a record that is complete."""
        self.advance(math.inf)
        self._append_blocks(self._reader.finish())
        self._deliver(at_once=True)

    def _read(self, deadline: float) -> None:
        while True:
            now = self._clock()
            step = self._reader.read(self._pace.piece(deadline - now))
            self._append_blocks(step.blocks)
            self.is_up_to_date = not step.more
            if self.is_up_to_date or step.is_waiting:
                return
            after = self._clock()
            self._pace.took(after - now)
            if after >= deadline:
                return

    def _append_blocks(self, blocks: Sequence[Block]) -> None:
        if not blocks:
            return
        for block in blocks:
            self._history.append(block)
            if self._following.cursors:
                self._stretches.add(block)
        if self._listening:
            self._undelivered += blocks

    def _deliver(self, *, at_once: bool = False) -> None:
        """Give new blocks to alarms, cues and estimates, once a `delivery_interval`.

        A step of each costs about the same, however many samples it holds. Charts are faster.
        """
        now = self._clock()
        due = now >= self._delivered_at + MONITORS.delivery_interval
        if not self._undelivered or not (due or at_once or self._following.cursors):
            for one in self._slow:
                if one.has_pending_work(math.inf):
                    one.process_step()
            return
        self._delivered_at = now
        blocks, self._undelivered = join_blocks(self._undelivered), []
        for consumer, begin in self._listening:
            for block in blocks:
                # What it was given from the history it is not given again.
                consumer.feed(_rows_from(block, begin))
            consumer.process_step()

    def _catch_up(self, deadline: float) -> None:
        """Let those who are behind hear what was before."""
        following = self._following
        if not following.cursors and self._begun:
            return
        first, last = self._stretches.first, self._stretches.last
        if not self._begun:
            self._begun = True
            for follower in following.cursors:
                follower.next_index = 0 if first is None else first
        # Slow messages still bring what happened before.
        target = (
            _BEFORE_FIRST_INDEX
            if last is None
            else last - round(MONITORS.read_ahead * self._history.rate)
        )
        following.feed_until(target, deadline)
        for follower in [one for one in following.cursors if following.has_reached(one, target)]:
            self._feed_newest_samples(follower)

    def _feed_newest_samples(self, follower: ConsumerCursor) -> None:
        """Give somebody who caught up the newest samples, of each channel as far as they came."""
        history, consumer = self._history, follower.consumer
        ends: dict[int, list[str]] = {}
        for name in history.channels:
            span = history.span(name)
            if span is not None and span[1] > follower.next_index:
                ends.setdefault(span[1], []).append(name)
        for end, names in ends.items():
            # What comes together stays together.
            consumer.feed(history.rows(follower.next_index, end, names))
        consumer.process_step()
        self._following.cursors.remove(follower)
        begun = follower.next_index != self._stretches.first
        begin = (follower.next_index - 0.5) / history.rate if begun else -math.inf
        self._listening.append((consumer, begin))
        if isinstance(consumer, SlowConsumer):
            self._slow.append(consumer)


class ReplayFeed:
    """Plays a finished record.

    Parameters
    ----------
    history : SampleHistory
        Filled ahead of the playhead; its horizon is the playhead.
    consumers : sequence of Consumer
        Get samples up to the playhead. After a jump back they are reset and fed again. Those that
        say when they are `SlowConsumer` are waited for.
    ahead : sequence of Consumer
        Get the whole record as it is read, whatever the playhead.

    Attributes
    ----------
    playing : bool
        False while paused, and at the end.
    """

    def __init__(
        self,
        reader: BlockReader,
        history: SampleHistory,
        consumers: Sequence[Consumer],
        clock: Callable[[], float],
        *,
        speed: float = 1.0,
        playing: bool = True,
        ahead: Sequence[Consumer] = (),
    ) -> None:
        self._reader = reader
        self._history = history
        self._clock = clock
        self._pace = _BatchSizer()
        self._stretches = GridSegments(history.rate)
        self._following = ConsumerScheduler(history, self._stretches, consumers, clock)
        self._ahead = ConsumerScheduler(history, self._stretches, ahead, clock)
        self._looks_ahead = False  # whether those have been told where the flight begins
        self._complete = False
        self._ticked: float | None = None
        self._position: float | None = None  # playhead, s
        self._begun = False  # whether consumers have been told where the flight begins
        self.playing = playing
        self._speed = 1.0
        self.speed = speed

    # What the window shows

    @property
    def playhead(self) -> Playhead | None:
        """Return where the replay is and how it runs; None before the first sample was read."""
        if self.now is None or self.start is None or self.end is None:
            return None
        return Playhead(
            time=self.now,
            start=self.start,
            end=self.end,
            playing=self.playing,
            speed=self.speed,
            complete=self.complete,
            at_end=self.at_end,
        )

    @property
    def now(self) -> float | None:
        """Return the playhead: flight time, s; None before the first sample was read."""
        return self._position

    @property
    def start(self) -> float | None:
        first = self._stretches.first
        return None if first is None else first / self._history.rate

    @property
    def end(self) -> float | None:
        last = self._stretches.last
        return None if last is None else last / self._history.rate

    @property
    def complete(self) -> bool:
        """Return whether the record was read to its end, so that `end` is the flight's."""
        return self._complete

    @property
    def progress(self) -> float:
        """Return the share of the record that was read, 0 to 1."""
        return 1.0 if self._complete else self._reader.progress

    @property
    def at_end(self) -> bool:
        """Return whether the playhead stands at the end of the flight."""
        if not self._complete:
            return False
        last = self._stretches.last
        return last is None or (self._position is not None and self._place(self._position) >= last)

    @property
    def is_up_to_date(self) -> bool:
        """Return whether everything up to the playhead was read."""
        if self._position is None:
            return self._complete
        return self._place(self._position) <= self._readable

    @property
    def caught_up(self) -> bool:
        """Return whether everything up to the playhead was read, and watched by consumers."""
        if self._position is None or not self._begun:
            return self._complete
        return self.is_up_to_date and self._following.all_reached(self._place(self._position))

    def monitored_fraction(self, consumer: Consumer) -> float:
        """Return how much of what lies before the playhead a consumer has seen, 0 to 1."""
        if self._position is None:
            return 1.0
        return self._following.progress(consumer, self._place(self._position))

    @property
    def speed(self) -> float:
        """Times real time, 0.1 to 50, or `UNLIMITED_SPEED`."""
        return self._speed

    @speed.setter
    def speed(self, value: float) -> None:
        if not value > 0.0:
            raise ValueError(f"a replay speed must be positive, not {value}; pause it instead")
        self._speed = (
            value
            if value == UNLIMITED_SPEED
            else min(max(value, MIN_REPLAY_SPEED), MAX_REPLAY_SPEED)
        )

    # What the user does

    def play(self) -> None:
        """Go on from the playhead; from the start if it stands at the end."""
        if self.at_end:
            self.seek(-math.inf)
        self.playing = True

    def pause(self) -> None:
        """Stand still."""
        self.playing = False

    def seek(self, time: float) -> None:
        """Go to a flight time, forward or back; beyond the ends means the ends."""
        start = self.start
        if start is None:
            return
        time = max(time, start)
        if self._complete:
            time = min(time, self.end or start)
        self._move_to(time)

    def step(self, samples: int) -> None:
        """Pause, and go on by some samples of the grid, or back if negative."""
        self.playing = False
        if self._position is not None:
            place = self._place(self._position) + samples
            self.seek(place / self._history.rate)

    # Work

    def advance(self, deadline: float) -> None:
        """Read ahead, move the playhead, feed consumers, until the clock shows `deadline`."""
        now = self._clock()
        elapsed = 0.0 if self._ticked is None else now - self._ticked
        self._ticked = now
        # Half of the time for reading ahead; what consumers leave goes there, too. One piece at
        # least, so that the slowest machine arrives.
        self._read_piece()
        self._read(now + 0.5 * (deadline - now) if math.isfinite(deadline) else deadline)
        if self._position is None:
            start = self.start
            if start is None:
                return
            self._move_to(start)
        if self.playing and self._speed != UNLIMITED_SPEED:
            # A window that stood still for long goes on where it was.
            self._play(min(max(elapsed, 0.0), MONITORS.max_tick) * self._speed)
        self._feed(deadline)
        self._read(deadline)
        if not (self.playing and self._speed == UNLIMITED_SPEED):
            self._look_ahead(deadline)

    def restart_read_ahead(self) -> None:
        """Give the whole record anew to those who get it ahead of the playhead."""
        self._looks_ahead = False

    def _look_ahead(self, deadline: float) -> None:
        first = self._stretches.first
        if first is None:
            return
        if not self._looks_ahead:
            self._looks_ahead = True
            self._ahead.restart(first)
        with self._history.without_horizon():
            self._ahead.feed_until(self._readable, deadline)

    def _read(self, deadline: float) -> None:
        while not self._complete:
            now = self._clock()
            if now >= deadline or not self._read_piece(deadline - now):
                return
            self._pace.took(self._clock() - now)

    def _read_piece(self, seconds: float = 0.0) -> bool:
        """Read a piece; return whether there was one, and not a disk that is waited for."""
        if self._complete:
            return False
        step = self._reader.read(self._pace.piece(seconds))
        self._store(step.blocks)
        if not step.more:
            self._store(self._reader.finish())
            self._complete = True
        return not step.is_waiting

    def _store(self, blocks: Sequence[Block]) -> None:
        for block in blocks:
            self._history.append(block)
            self._stretches.add(block)

    @property
    def _readable(self) -> int:
        """Return the last place before which nothing can turn up any more."""
        last = self._stretches.last
        if last is None:
            return _BEFORE_FIRST_INDEX
        return last if self._complete else last - round(MONITORS.read_ahead * self._history.rate)

    def _place(self, time: float) -> int:
        return math.floor(time * self._history.rate + 1e-6)

    def _play(self, seconds: float) -> None:
        """Move on by some seconds of flight, as far as the record was read."""
        rate = self._history.rate
        position = self._position
        readable = self._readable
        if position is None or position * rate >= readable:
            # At the end, or waiting for samples to be read.
            self.playing = self.playing and not self._complete
            return
        position = min(position + seconds, readable / rate)
        found = self._stretches.segment_from(self._place(position))
        if found is not None and found[0] > self._place(position):
            position = min(found[0], readable) / rate  # a long pause
        self._move_to(position)

    def _move_to(self, position: float) -> None:
        self._position = position
        self._history.horizon = position
        place = self._place(position)
        if not self._begun or any(place + 1 < one.next_index for one in self._following.cursors):
            self._begun = True
            self._following.restart(self._stretches.first or 0)

    def _feed(self, deadline: float) -> None:
        """Give consumers what lies between where they are and the playhead."""
        if not self._begun or self._position is None:
            return
        headlong = self.playing and self._speed == UNLIMITED_SPEED
        readable = self._readable
        target = readable if headlong else min(self._place(self._position), readable)
        # As fast as it goes nobody runs ahead, so that what one tells of another comes in time.
        whole = self._following.feed_until(
            target,
            deadline,
            abreast=headlong,
            reach=self._advance_playhead if headlong else _ignore_playhead,
        )
        if headlong and whole and self._complete:
            self.playing = False

    def _advance_playhead(self, place: int) -> None:
        if self._position is None or place > self._place(self._position):
            self._position = place / self._history.rate
            self._history.horizon = self._position


def _ignore_playhead(_place: int) -> None:
    """Let the playhead be where it is."""


def _rows_from(block: Block, begin: float) -> Block:
    if not len(block) or block.times[0] >= begin:
        return block
    return block.between(begin, math.inf)

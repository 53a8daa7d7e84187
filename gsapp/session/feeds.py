"""What drives a flight forward: the end of a growing record, or the playhead of a replay.

Both read the same records through the same decoder into the same history. Live, everything that
was read counts as having happened. In a replay the record is read ahead as fast as it goes, and
the playhead decides what has happened: charts see no further, and those who watch the samples
(alarms, estimators) get them in order up to there.

Nothing here waits. Work is done in pieces until a deadline, so that the caller's timer is never
held up, and goes on in the next call.
"""

from __future__ import annotations

import bisect
import math
from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol, runtime_checkable

from gsapp.foundation import FlightError
from gsapp.quantities import Block
from gsapp.session.history import History

MAX_SPEED = math.inf
SLOWEST, FASTEST = 0.1, 50.0

_MOST_ROWS = 512
"""Rows of the grid given to consumers at a time where nothing holds them up."""
_SHORTEST_STEP, _STEP = 0.25, 1.0
"""Seconds of flight given at a time, as the consumers' time allows. What is due some seconds after
something happened, such as a look ahead, is never due in the very step in which it happened."""

_FEWEST, _MOST = 64, 4096
"""Records read at a time, as their decoding time allows."""

_LONGEST_TICK = 1.0
"""Seconds that a replay moves on at most between two calls, at single speed."""

_NOWHERE = -(2**62)

_LONGEST_PAUSE = 60.0
"""Seconds without a sample that a replay waits through; longer pauses are skipped."""

_READ_AHEAD = 5.0
"""Seconds that reading must be ahead of the playhead: slow messages arrive late."""


def parse_speed(text: str | float) -> float:
    """Return the speed of a replay, times real time.

    Raises
    ------
    FlightError
        If it is neither ``max`` nor a number from 0.1 to 50.
    """
    if str(text).strip().casefold() == "max":
        return MAX_SPEED
    try:
        speed = float(text)
    except ValueError:
        speed = math.nan
    if speed != MAX_SPEED and not SLOWEST <= speed <= FASTEST:
        raise FlightError(
            f"a replay does not run at speed '{text}'; give {SLOWEST:g} to {FASTEST:g} times real "
            "time, or max"
        )
    return speed


class Step(NamedTuple):
    """What one reading gave."""

    blocks: Sequence[Block]
    more: bool


class Reader(Protocol):
    """Gives the blocks of a flight in the order in which they became known."""

    def read(self, limit: int) -> Step:
        """Take at most about `limit` records, and say whether more are waiting."""

    def finish(self) -> Sequence[Block]:
        """Give what was held back for samples that will not come; the record is complete."""

    @property
    def progress(self) -> float:
        """Return the share of the record that was read, 0 to 1."""


class Consumer(Protocol):
    """Watches the samples of a flight in order."""

    def feed(self, block: Block) -> None:
        """Take in the next samples of some channels, on consecutive places of the grid."""

    def settle(self) -> None:
        """Draw conclusions, after all blocks of a step; go on with longer work by a slice."""

    def reset(self) -> None:
        """Forget everything; the flight begins anew."""


@runtime_checkable
class Busy(Consumer, Protocol):
    """A consumer that works on what it saw for longer than a step takes."""

    def busy(self, time: float) -> bool:
        """Return whether that is to be done before samples up to a flight time (s) come.

        Live nobody waits: then the rest is done at once when it is due. A replay that runs ahead
        of its clock gives it time instead, so that no step takes long.
        """


class _Pace:
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

    Parameters
    ----------
    reader : Reader
        The record.
    history : History
        Where samples go.
    consumers : sequence of Consumer
        Who watches them.
    clock : callable
        Seconds of a clock that never goes back.

    Attributes
    ----------
    caught_up : bool
        Whether everything recorded so far was taken in.
    """

    def __init__(
        self,
        reader: Reader,
        history: History,
        consumers: Sequence[Consumer],
        clock: Callable[[], float],
    ) -> None:
        self._reader = reader
        self._history = history
        self._consumers = consumers
        self._clock = clock
        self._pace = _Pace()
        self.caught_up = False

    @property
    def now(self) -> float | None:
        """Return the flight time reached, s."""
        return self._history.end

    @property
    def progress(self) -> float:
        """Return the share of the record that was taken in, 0 to 1."""
        return 1.0 if self.caught_up else self._reader.progress

    def advance(self, deadline: float) -> None:
        """Take in what was recorded since, until the clock shows `deadline`."""
        while True:
            now = self._clock()
            step = self._reader.read(self._pace.piece(deadline - now))
            self._take(step.blocks)
            self.caught_up = not step.more
            if self.caught_up:
                return
            after = self._clock()
            self._pace.took(after - now)
            if after >= deadline:
                return

    def finish(self) -> None:
        """Take in the rest of a record that is complete."""
        self.advance(math.inf)
        self._take(self._reader.finish())

    def _take(self, blocks: Sequence[Block]) -> None:
        if not blocks:
            return
        for block in blocks:
            self._history.append(block)
        for consumer in self._consumers:
            for block in blocks:
                consumer.feed(block)
            consumer.settle()


class _Stretches:
    """Where on the grid samples lie, as stretches without a long pause inside."""

    def __init__(self, longest_pause: int) -> None:
        self._pause = longest_pause
        self._firsts: list[int] = []
        self._lasts: list[int] = []

    def add(self, first: int, last: int) -> None:
        """Add samples ``first <= k <= last``."""
        place = bisect.bisect_right(self._firsts, first)
        # The one before may reach up to here.
        if place > 0 and first - self._lasts[place - 1] <= self._pause:
            place -= 1
            first = self._firsts.pop(place)
            last = max(last, self._lasts.pop(place))
        while place < len(self._firsts) and self._firsts[place] - last <= self._pause:
            last = max(last, self._lasts[place])
            del self._firsts[place], self._lasts[place]
        self._firsts.insert(place, first)
        self._lasts.insert(place, last)

    @property
    def first(self) -> int | None:
        """Return the first sample of all."""
        return self._firsts[0] if self._firsts else None

    @property
    def last(self) -> int | None:
        """Return the last sample of all."""
        return self._lasts[-1] if self._lasts else None

    def at_or_after(self, index: int) -> tuple[int, int] | None:
        """Return the stretch that holds a place, from there on, or else the next one."""
        place = bisect.bisect_right(self._firsts, index)
        if place > 0 and self._lasts[place - 1] >= index:
            return index, self._lasts[place - 1]
        if place < len(self._firsts):
            return self._firsts[place], self._lasts[place]
        return None


class ReplayFeed:
    """Plays a finished record.

    Parameters
    ----------
    reader : Reader
        The record.
    history : History
        Filled ahead of the playhead; its horizon is the playhead.
    consumers : sequence of Consumer
        Get samples up to the playhead. After a jump back they are reset and fed again. Those that
        say when they are `Busy` are waited for.
    clock : callable
        Seconds of a clock that never goes back.
    speed : float
        Times real time; `MAX_SPEED` for as fast as it goes.
    playing : bool
        Whether it plays from the start.

    Attributes
    ----------
    playing : bool
        False while paused, and at the end.
    """

    def __init__(
        self,
        reader: Reader,
        history: History,
        consumers: Sequence[Consumer],
        clock: Callable[[], float],
        *,
        speed: float = 1.0,
        playing: bool = True,
    ) -> None:
        self._reader = reader
        self._history = history
        self._consumers = consumers
        self._busy = [one for one in consumers if isinstance(one, Busy)]
        self._step_rows = tuple(
            min(max(round(seconds * history.rate), 1), _MOST_ROWS)
            for seconds in (_SHORTEST_STEP, _STEP)
        )
        self._seconds_a_row = 0.0  # of the consumers' work, smoothed
        self._clock = clock
        self._pace = _Pace()
        self._stretches = _Stretches(round(_LONGEST_PAUSE * history.rate))
        self._complete = False
        self._ticked: float | None = None
        self._position: float | None = None  # playhead, s
        self._fed: int | None = None  # the next place on the grid to be given to consumers
        self.playing = playing
        self._speed = 1.0
        self.speed = speed

    # What the window shows

    @property
    def now(self) -> float | None:
        """Return the playhead: flight time, s; None before the first sample was read."""
        return self._position

    @property
    def start(self) -> float | None:
        """Return the time of the first sample read, s."""
        first = self._stretches.first
        return None if first is None else first / self._history.rate

    @property
    def end(self) -> float | None:
        """Return the time of the last sample read so far, s."""
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
    def caught_up(self) -> bool:
        """Return whether everything up to the playhead was read, and watched by consumers."""
        if self._position is None or self._fed is None:
            return self._complete
        place = self._place(self._position)
        if place > self._readable:
            return False
        found = self._stretches.at_or_after(self._fed)
        return found is None or found[0] > place

    @property
    def speed(self) -> float:
        """Times real time, 0.1 to 50, or `MAX_SPEED`."""
        return self._speed

    @speed.setter
    def speed(self, value: float) -> None:
        if not value > 0.0:
            raise ValueError(f"a replay runs at a positive speed, not {value}; pause it instead")
        self._speed = value if value == MAX_SPEED else min(max(value, SLOWEST), FASTEST)

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
        if self.playing and self._speed != MAX_SPEED:
            # A window that stood still for long goes on where it was.
            self._play(min(max(elapsed, 0.0), _LONGEST_TICK) * self._speed)
        self._feed(deadline)
        self._read(deadline)

    def _read(self, deadline: float) -> None:
        while not self._complete:
            now = self._clock()
            if now >= deadline:
                return
            self._read_piece(deadline - now)
            self._pace.took(self._clock() - now)

    def _read_piece(self, seconds: float = 0.0) -> None:
        if self._complete:
            return
        step = self._reader.read(self._pace.piece(seconds))
        self._store(step.blocks)
        if not step.more:
            self._store(self._reader.finish())
            self._complete = True

    def _store(self, blocks: Sequence[Block]) -> None:
        rate = self._history.rate
        for block in blocks:
            if len(block):
                self._history.append(block)
                self._stretches.add(
                    round(float(block.times[0]) * rate), round(float(block.times[-1]) * rate)
                )

    @property
    def _readable(self) -> int:
        """Return the last place before which nothing can turn up any more."""
        last = self._stretches.last
        if last is None:
            return _NOWHERE
        return last if self._complete else last - round(_READ_AHEAD * self._history.rate)

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
        found = self._stretches.at_or_after(self._place(position))
        if found is not None and found[0] > self._place(position):
            position = min(found[0], readable) / rate  # a long pause
        self._move_to(position)

    def _move_to(self, position: float) -> None:
        self._position = position
        self._history.horizon = position
        if self._fed is None or self._place(position) + 1 < self._fed:
            for consumer in self._consumers:
                consumer.reset()
            self._fed = self._stretches.first

    def _feed(self, deadline: float) -> None:
        """Give consumers what lies between where they are and the playhead."""
        while self._fed is not None and self._position is not None:
            headlong = self.playing and self._speed == MAX_SPEED
            readable = self._readable
            target = readable if headlong else min(self._place(self._position), readable)
            found = self._stretches.at_or_after(self._fed)
            if found is None or found[0] > target:
                if headlong and self._complete:
                    self.playing = False
                return
            first = found[0]
            last = min(found[1], target, first + self._rows_for(deadline) - 1)
            if self._waits(last / self._history.rate):
                if self._clock() >= deadline:
                    return
                continue
            if headlong and last > self._place(self._position):
                self._position = last / self._history.rate
                self._history.horizon = self._position
            block = self._history.rows(first, last + 1)
            began = self._clock()
            for consumer in self._consumers:
                consumer.feed(block)
                consumer.settle()
            self._fed = last + 1
            now = self._clock()
            each = (now - began) / len(block)
            self._seconds_a_row += 0.3 * (each - self._seconds_a_row)
            if now >= deadline:
                return

    def _rows_for(self, deadline: float) -> int:
        """Return how many rows the consumers can be given in the time that is left."""
        fewest, most = self._step_rows
        left = deadline - self._clock()
        if not math.isfinite(left) or self._seconds_a_row <= 0.0:
            return most
        return min(max(int(left / self._seconds_a_row), fewest), most)

    def _waits(self, time: float) -> bool:
        """Give a slice to those who are to finish something before a flight time (s)."""
        late = [consumer for consumer in self._busy if consumer.busy(time)]
        for consumer in late:
            consumer.settle()
        return bool(late)

"""Driving a flight: a playhead over a record, and the end of a record that grows."""

import math
from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gsapp.quantities import Block
from gsapp.session.feeds import UNLIMITED_SPEED, LiveFeed, ReadResult, ReplayFeed
from gsapp.session.sample_history import SampleHistory

RATE = 100.0


def block(first: int, values: dict[str, np.ndarray]) -> Block:
    count = len(next(iter(values.values())))
    return Block(
        channels=tuple(values),
        times=np.arange(first, first + count) / RATE,
        values=np.column_stack(list(values.values())),
    )


class ListReader:
    """Blocks from a list, as if decoded from records."""

    def __init__(self, blocks: Sequence[Block], tail: Sequence[Block] = ()) -> None:
        self.blocks = list(blocks)
        self.tail = list(tail)
        self.position = 0
        self.per_read = 3

    def read(self, limit: int) -> ReadResult:
        given = self.blocks[self.position : self.position + min(self.per_read, limit)]
        self.position += len(given)
        return ReadResult(given, self.position < len(self.blocks))

    def finish(self) -> Sequence[Block]:
        given, self.tail = self.tail, []
        return given

    @property
    def progress(self) -> float:
        return self.position / max(len(self.blocks), 1)


class Watcher:
    """Remembers the samples it was given since the last reset."""

    def __init__(self) -> None:
        self.resets = 0
        self.seen: dict[str, list[float]] = {}
        self.times: dict[str, list[float]] = {}
        self.settled = True

    def feed(self, given: Block) -> None:
        self.settled = False
        for column, name in enumerate(given.channels):
            self.seen.setdefault(name, []).extend(given.values[:, column].tolist())
            self.times.setdefault(name, []).extend(given.times.tolist())

    def process_step(self) -> None:
        self.settled = True

    def reset(self) -> None:
        self.resets += 1
        self.seen.clear()
        self.times.clear()


class Thinker(Watcher):
    def __init__(self, slices: int) -> None:
        super().__init__()
        self.left = slices

    def has_pending_work(self, time: float) -> bool:
        return self.left > 0 and time >= 9.0

    def process_step(self) -> None:
        super().process_step()
        self.left -= self.left > 0 and bool(self.times) and self.times["q"][-1] > 8.0


class Clock:
    def __init__(self, each: float = 0.0) -> None:
        self.time = 100.0
        self.each = each

    def __call__(self) -> float:
        self.time += self.each
        return self.time


def flight(seconds: int = 40, start: int = 500) -> list[Block]:
    blocks = []
    for second in range(seconds):
        for part in range(0, 100, 10):
            k = start + second * 100 + part
            blocks.append(block(k, {"q": np.arange(k, k + 10.0)}))
        if second >= 2:
            k = start + (second - 2) * 100
            blocks.append(block(k, {"battery": np.arange(k, k + 100.0)}))
    return blocks


def run(feed: ReplayFeed, clock: Clock, seconds: float, step: float = 0.02) -> None:
    for _ in range(round(seconds / step)):
        feed.advance(clock.time + 0.008)
        clock.time += step


def replay(
    blocks: Sequence[Block], *, each: float = 0.0, speed: float = 1.0
) -> tuple[ReplayFeed, SampleHistory, Watcher, Clock]:
    clock = Clock(each)
    history = SampleHistory(["q", "battery"], RATE)
    watcher = Watcher()
    feed = ReplayFeed(ListReader(blocks), history, [watcher], clock, speed=speed)
    return feed, history, watcher, clock


def test_the_playhead_runs_at_its_speed_and_the_charts_see_no_further() -> None:
    """1x, 10x and pause, to the end, where it stops."""
    feed, history, watcher, clock = replay(flight())
    run(feed, clock, 2.0)
    assert feed.now == pytest.approx(5.0 + 1.98)
    assert history.end == pytest.approx(feed.now, abs=0.01)
    assert history.last("q")[0] <= feed.now + 1e-6
    assert watcher.seen["q"] == np.arange(500.0, history.index(history.end) + 1).tolist()
    feed.speed = 10.0
    run(feed, clock, 1.0)
    assert feed.now == pytest.approx(6.98 + 10.0)
    feed.pause()
    run(feed, clock, 5.0)
    assert feed.now == pytest.approx(16.98)
    feed.play()
    feed.speed = 1000.0
    assert feed.speed == 50.0
    feed.speed = 0.001
    assert feed.speed == 0.1
    feed.speed = UNLIMITED_SPEED
    run(feed, clock, 1.0)
    assert (feed.now, feed.at_end, feed.playing) == (44.99, True, False)
    assert watcher.seen["q"] == np.arange(500.0, 4500.0).tolist()
    assert watcher.resets == 1  # the beginning
    feed.play()
    assert feed.now == 5.0
    assert watcher.resets == 2


def test_going_back_feeds_everything_up_to_there_again() -> None:
    """After a jump back consumers hold what they would hold had the flight just come to here."""
    feed, history, watcher, clock = replay(flight(), speed=50.0)
    run(feed, clock, 0.5)
    assert feed.now == pytest.approx(5.0 + 24.0)
    revision = history.revision
    feed.seek(12.0)
    assert history.end == 12.0
    assert history.revision > revision
    assert np.isnan(history.samples("q", 1201, 1300)).all()
    feed.pause()
    run(feed, clock, 0.1)
    assert feed.caught_up
    assert watcher.seen["q"] == np.arange(500.0, 1201.0).tolist()
    assert watcher.seen["battery"] == np.arange(500.0, 1201.0).tolist()
    feed.seek(20.0)
    run(feed, clock, 0.1)
    assert watcher.resets == 2
    assert watcher.seen["q"] == np.arange(500.0, 2001.0).tolist()
    feed.seek(1e9)
    assert feed.now == 44.99
    feed.seek(-5.0)
    assert feed.now == 5.0


def test_single_steps() -> None:
    feed, history, watcher, clock = replay(flight())
    run(feed, clock, 1.0)
    index = history.index(history.end)
    feed.step(1)
    assert history.last("q") == ((index + 1) / RATE, index + 1.0)
    feed.step(-2)
    assert history.last("q") == ((index - 1) / RATE, index - 1.0)
    assert not feed.playing
    run(feed, clock, 0.1)
    assert watcher.seen["q"][-1] == index - 1.0


@settings(deadline=None, max_examples=20)
@given(
    each=st.sampled_from([0.0, 0.001, 0.02]),
    moves=st.lists(
        st.tuples(st.sampled_from(["seek", "step", "speed", "pause", "play"]), st.floats(0.0, 1.0)),
        max_size=8,
    ),
)
def test_whatever_the_user_does_consumers_see_a_flight_in_order(
    each: float, moves: list[tuple[str, float]]
) -> None:
    feed, _, watcher, clock = replay(flight(20), each=each)
    for what, share in moves:
        run(feed, clock, 0.2)
        if what == "seek":
            feed.seek(5.0 + 22.0 * share)
        elif what == "step":
            feed.step(round(40 * share) - 20)
        elif what == "speed":
            feed.speed = 50.0 * share + 0.1 if share < 0.8 else UNLIMITED_SPEED
        elif what == "pause":
            feed.pause()
        else:
            feed.play()
        for name, seen in watcher.seen.items():
            count = len(seen)
            expected = np.arange(500.0, 500.0 + count)
            if name == "battery":
                expected[expected >= 2300.0] = np.nan
            np.testing.assert_array_equal(seen, expected)
            assert not count or watcher.times[name][-1] <= feed.now + 1e-6
    feed.play()
    feed.speed = UNLIMITED_SPEED
    run(feed, clock, 200.0, 1.0)
    assert feed.at_end
    assert watcher.seen["q"] == np.arange(500.0, 2500.0).tolist()


def test_a_long_pause_between_two_flights_is_skipped() -> None:
    first = [block(k, {"q": np.zeros(100)}) for k in range(0, 1000, 100)]
    hours = 3 * 3600 * 100
    second = [block(hours + k, {"q": np.ones(100)}) for k in range(0, 1000, 100)]
    third = [block(hours + 4000 + k, {"q": np.ones(100)}) for k in range(0, 1000, 100)]
    feed, _, watcher, clock = replay([*first, *second, *third])
    run(feed, clock, 9.5)
    assert feed.now < 10.0
    run(feed, clock, 1.5)
    assert 10800.0 <= feed.now <= 10802.0
    run(feed, clock, 20.0)
    assert 10810.0 < feed.now < 10840.0
    run(feed, clock, 60.0)
    assert feed.at_end
    assert np.nansum(watcher.seen["q"]) == 2000.0
    assert len(watcher.seen["q"]) == 1000 + 5000


def test_a_pause_inside_a_block_costs_nothing() -> None:
    whole = block(0, {"q": np.zeros(100)})
    later = block(10**12, {"q": np.ones(50)})
    joined = Block(
        channels=("q",),
        times=np.concatenate((whole.times, later.times)),
        values=np.concatenate((whole.values, later.values)),
    )
    feed, _, watcher, clock = replay([joined], speed=UNLIMITED_SPEED)
    run(feed, clock, 1.0)
    assert feed.at_end
    assert watcher.seen["q"] == [0.0] * 100 + [1.0] * 50


def test_a_slow_machine_keeps_its_deadline_and_gets_there() -> None:
    feed, _, watcher, clock = replay(flight(), each=0.003, speed=UNLIMITED_SPEED)
    calls = 0
    while not feed.at_end:
        begin = clock.time
        feed.advance(begin + 0.008)
        assert clock.time - begin < 0.008 + 8 * 0.003
        calls += 1
    assert calls > 10
    assert watcher.seen["q"] == np.arange(500.0, 4500.0).tolist()


def test_live_everything_read_has_happened_at_once() -> None:
    history = SampleHistory(["q"], RATE)
    watcher = Watcher()
    blocks = flight(5)
    tail = [block(1000, {"q": np.arange(1000.0, 1002.0)})]
    feed = LiveFeed(ListReader(blocks, tail), history, [watcher], Clock())
    feed.advance(math.inf)
    assert feed.caught_up
    assert feed.now == 9.99
    assert watcher.seen["q"] == np.arange(500.0, 1000.0).tolist()
    feed.finish()
    assert watcher.seen["q"] == np.arange(500.0, 1002.0).tolist()
    assert history.last("q") == (10.01, 1001.0)


def test_live_a_long_past_is_taken_in_over_several_calls() -> None:
    history = SampleHistory(["q"], RATE)
    clock = Clock(each=0.001)
    feed = LiveFeed(ListReader(flight(30)), history, [], clock)
    told = []
    while not feed.caught_up:
        begin = clock.time
        feed.advance(begin + 0.008)
        assert clock.time - begin < 0.012
        told.append(feed.progress)
    assert told == sorted(told)
    assert told[0] < 0.5
    assert told[-1] == 1.0
    assert history.end == 34.99


@pytest.mark.parametrize("speed", [1.0, UNLIMITED_SPEED])
def test_a_consumer_that_still_thinks_is_waited_for(speed: float) -> None:
    clock, history, thinker = Clock(0.001), SampleHistory(["q", "battery"], RATE), Thinker(60)
    feed = ReplayFeed(ListReader(flight()), history, [thinker], clock, speed=speed)
    while feed.now is None or feed.now < 11.0:
        before = clock.time
        feed.advance(clock.time + 0.008)
        assert clock.time - before < 0.03
        assert not thinker.left or thinker.times.get("q", [0.0])[-1] < 9.0
        clock.time += 0.02
    run(feed, clock, 2.0)
    assert thinker.left == 0
    seen = thinker.times["q"]
    assert seen[-1] > 11.0
    assert np.diff(seen) == pytest.approx(0.01)


class GrowingReader(ListReader):
    """Blocks that come as a flight goes on."""

    def __init__(self, blocks: Sequence[Block], come: int) -> None:
        super().__init__(blocks)
        self.come = come

    def read(self, limit: int) -> ReadResult:
        given = self.blocks[
            self.position : min(self.position + min(self.per_read, limit), self.come)
        ]
        self.position += len(given)
        return ReadResult(given, self.position < self.come)

    @property
    def progress(self) -> float:
        return self.position / self.come


class Slow(Watcher):
    def __init__(self, clock: Clock, each: float) -> None:
        super().__init__()
        self.clock, self.each = clock, each

    def feed(self, given: Block) -> None:
        super().feed(given)
        self.clock.time += self.each * len(given)


def test_a_window_opened_late_shows_the_present_and_looks_through_the_past_after() -> None:
    clock, history = Clock(0.0001), SampleHistory(["q"], RATE)
    blocks = flight(120)
    reader = GrowingReader(blocks, len(blocks))
    quick, slow = Watcher(), Slow(clock, 0.0005)
    feed = LiveFeed(reader, history, [quick, slow], clock)
    shares: list[tuple[bool, float, float]] = []
    while not feed.caught_up:
        begin = clock.time
        feed.advance(begin + 0.02)
        # A step, and once the newest seconds in one go.
        assert clock.time - begin < 0.02 + (100 + 700) * 0.0005 + 0.02
        shares.append(
            (feed.is_up_to_date, feed.monitored_fraction(quick), feed.monitored_fraction(slow))
        )
    assert history.end == 124.99
    assert not slow.seen or shares[0][2] < 1.0
    reading = [share for share in shares if not share[0]]
    assert all(share[1] < 1.0 and share[2] < 1.0 for share in reading)
    late = [share for share in shares if share[0]]
    assert late[4][1] == 1.0  # at once
    assert late[4][2] < 0.5
    assert [share[2] for share in shares] == sorted(share[2] for share in shares)
    assert shares[-1] == (True, 1.0, 1.0)


@settings(deadline=None, max_examples=40)
@given(
    come=st.integers(0, 400),
    each=st.sampled_from([0.0, 0.0002, 0.003]),
    pieces=st.lists(st.integers(1, 60), min_size=1, max_size=12),
)
def test_whenever_a_window_opens_watchers_see_the_flight_in_order(
    come: int, each: float, pieces: list[int]
) -> None:
    """Every sample of every channel once, late ones too, whatever was there when it opened."""
    clock, history = Clock(0.0001), SampleHistory(["q", "battery"], RATE)
    blocks = flight(40)
    reader = GrowingReader(blocks, min(come, len(blocks)))
    watchers = [Watcher(), Slow(clock, each)]
    feed = LiveFeed(reader, history, watchers, clock)
    for piece in pieces:
        feed.advance(clock.time + 0.01)
        reader.come = min(reader.come + piece, len(blocks))
        assert all(watcher.settled for watcher in watchers)
    feed.finish()
    for watcher in watchers:
        assert watcher.settled
        for name, seen in watcher.seen.items():
            given = [k for k in seen if not math.isnan(k)]
            count = history.span(name)[1] - 500
            assert given == np.arange(500.0, 500.0 + count).tolist()
            assert watcher.times[name] == sorted(set(watcher.times[name]))
        assert watcher.resets == 0


def test_after_a_jump_the_slow_watcher_holds_nobody_up() -> None:
    clock, history = Clock(0.0001), SampleHistory(["q", "battery"], RATE)
    quick, slow = Watcher(), Slow(clock, 0.001)
    feed = ReplayFeed(ListReader(flight(120)), history, [quick, slow], clock, playing=False)
    run(feed, clock, 4.0)
    assert feed.complete
    feed.seek(110.0)
    assert feed.monitored_fraction(slow) < 0.1
    for _ in range(4):
        feed.advance(clock.time + 0.02)
    assert (feed.monitored_fraction(quick), feed.caught_up) == (1.0, False)
    assert 0.0 < feed.monitored_fraction(slow) < 0.2
    while not feed.caught_up:
        feed.advance(clock.time + 0.02)
    assert feed.monitored_fraction(slow) == 1.0
    assert slow.seen == quick.seen
    assert slow.seen["q"] == np.arange(500.0, 11001.0).tolist()

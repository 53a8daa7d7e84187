"""The log of a flight's alarms: the same in every window, after reopening, and in its replay."""

import math
from pathlib import Path

import numpy as np
import pytest

from gsapp.flight.events import EventLog
from gsapp.session.alarm_log import AlarmLog
from gsapp.session.alarms import AlarmRegistry
from gsapp.session.limits import LimitBands, Severity
from gsapp.session.marks import MarkStore
from gsapp.session.session import Session


class Window:
    def __init__(self, path: Path, clock: list[int]) -> None:
        self.board = AlarmRegistry()
        self.book = MarkStore(EventLog(path), lambda: clock[0])
        self.log = AlarmLog(self.board, self.book, lambda: clock[0])
        self.log.read()


def test_trouble_of_the_equipment_stands_once_in_every_window_and_after_reopening(
    tmp_path: Path,
) -> None:
    path, clock = tmp_path / "events.jsonl", [1_000_000_000]
    left, right = Window(path, clock), Window(path, clock)
    for window, time in ((left, 10.0), (right, 10.2)):
        window.board.raise_("link", Severity.CAUTION, time, "weak")
        window.log.write_equipment(time)
    clock[0] += 20_000_000
    for window, time in ((left, 30.0), (right, 30.1)):
        window.board.raise_("link", Severity.WARNING, time, "silent")
        window.log.write_equipment(time)
    left.book.add(31.0)  # takes in events by itself
    right.log.acknowledge(right.board.unacknowledged[0], 32.0, "crew, key K")
    left.book.add(32.5)
    left.log.read()
    assert left.board.unacknowledged == ()
    clock[0] += 20_000_000
    for window, time in ((left, 50.0), (right, 50.1)):
        window.board.clear("link", time)
        window.log.write_equipment(time)
    right.log.read()
    again = Window(path, clock)
    for window in (left, right, again):
        window.log.read()
        (one,) = window.log.episodes
        assert (one.onset, one.end, one.severity) == (10.0, 50.0, Severity.WARNING)
        assert (one.message, one.is_over) == ("silent", True)
        assert (one.acknowledgment.by, one.acknowledgment.time) == ("crew, key K", 32.0)


def test_an_alarm_that_came_back_is_seen_together_with_what_it_was_before() -> None:
    board = AlarmRegistry()
    for onset in (1.0, 3.0):
        board.raise_("cues", Severity.CAUTION, onset, "words")
        board.clear("cues", onset + 1.0)
    board.acknowledge("cues", 3.0, "crew", 5.0)
    board.raise_("cues", Severity.CAUTION, 7.0, "words")
    assert [one.acknowledged for one in board.episodes] == [True, True, False]


def test_a_replay_knows_all_alarms_of_the_flight_wherever_it_stands(tmp_path: Path) -> None:
    flight = tmp_path / "flight.csv"
    times = np.arange(3000) / 100.0
    alpha = np.where((times % 10.0 >= 5.0) & (times % 10.0 < 7.0), 15.0, 3.0)
    rows = "\n".join(f"{t:.2f},{a}" for t, a in zip(times, alpha, strict=True))
    flight.write_text(f"time [s],alpha [deg]\n{rows}\n")
    session = Session.replay(flight, playing=False, cues=False)
    session.set_user_limits("alpha", LimitBands(caution_high=math.radians(10.0)))
    for _ in range(60):
        session.update(0.02)
    feed = session.replay_feed
    assert session.now == 0.0
    assert session.alarm_registry.episodes == ()
    found = session.alarm_log.episodes
    assert [one.onset for one in found] == pytest.approx([5.1, 15.1, 25.1], abs=0.02)
    assert [one.end for one in found] == pytest.approx([7.1, 17.1, 27.1], abs=0.02)
    feed.seek(6.0)
    session.update(0.2)
    assert session.acknowledge(by="crew, key K")
    feed.seek(0.0)
    session.update(0.2)
    assert [one.acknowledged for one in session.alarm_log.episodes] == [True, False, False]
    session.close()
    again = Session.replay(flight, playing=False, cues=False)
    again.set_user_limits("alpha", LimitBands(caution_high=math.radians(10.0)))
    for _ in range(60):
        again.update(0.02)
    assert again.alarm_log.episodes[0].acknowledgment.by == "crew, key K"
    again.close()

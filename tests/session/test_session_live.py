"""Live flights: a real recorder process, a real socket, sessions that tail its files."""

import os
import shutil
import signal
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gsapp.flight.events import EventLog
from gsapp.flight.flight_loader import load_flight
from gsapp.flight.raw_files.record_files import RawFile
from gsapp.foundation import FlightError
from gsapp.quantities import Block
from gsapp.session import UNLIMITED_SPEED, Freshness, Session, Severity, equipment_monitor, readers
from gsapp.session.monitor_settings import MONITORS
from gsapp.session.replay_runner import run_replay
from gsapp.session.sample_history import SampleHistory
from gsapp.session.session_monitors import AlarmMonitor
from gsapp.telemetry.recorder_control import find_recorders

Field = Any
Patience = Callable[..., None]


@pytest.fixture
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    settings = replace(MONITORS, equipment_interval=0.0, events_interval=0.0)
    monkeypatch.setattr(equipment_monitor, "MONITORS", settings)
    monkeypatch.setattr("gsapp.session.session.MONITORS", settings)


def frames_in(session: Session) -> int:
    return 0 if session.decoder is None else session.decoder.health.good


def caught_up(session: Session, frames: int) -> Callable[[], bool]:
    def come() -> bool:
        session.update()
        return frames_in(session) >= frames

    return come


def everything(history: SampleHistory) -> dict[str, np.ndarray]:
    found = {}
    for name in history.channels:
        first, last = history.span(name)
        found[name] = np.concatenate([[first, last], history.samples(name, first, last)])
    return found


def same(left: SampleHistory, right: SampleHistory) -> None:
    one, other = everything(left), everything(right)
    assert one.keys() == other.keys()
    for name, values in one.items():
        np.testing.assert_array_equal(values, other[name], err_msg=name)


def test_live_two_windows_a_frozen_one_and_the_replay_hold_the_same_bits(
    field: Field, patience: Patience
) -> None:
    """One session polls all the time, one froze, one came in mid-flight, one replays: all equal."""
    field.record()
    steady = Session.follow(field.folder, channel_map="b777", aircraft="b777")
    frozen = Session.follow(field.folder, channel_map="b777", aircraft="b777")
    for _ in range(5):
        field.aircraft.send(20)
        steady.update()
        frozen.update()
    assert steady.snapshot().mode == "live"
    for _ in range(20):
        field.aircraft.send(20)
        steady.update()  # the other one stands still meanwhile
    late = Session.follow(field.folder, channel_map="b777", aircraft="b777")
    assert late.recorder is None
    for session in (steady, frozen, late):
        patience(caught_up(session, field.aircraft.sent))
        assert session.feed.caught_up
        assert session.decoder.health.lost == 0
        assert session.snapshot().recorder.state == "recording"
        assert session.recorder.pid == field.recorder.pid
    assert field.recorder.stop()
    for session in (steady, frozen, late):
        session.finish()
    replayed = Session.replay(
        field.folder, channel_map="b777", aircraft="b777", speed=UNLIMITED_SPEED
    )
    run_replay(replayed)
    assert len(steady.history.channels) > 35
    assert steady.history.last("phi")[0] == pytest.approx(1.0 + 4.98)
    for session in (frozen, late, replayed):
        same(steady.history, session.history)
        assert session.alarm_registry.onsets == steady.alarm_registry.onsets
    loaded = load_flight(field.folder, channel_map="b777", aircraft="b777")
    live = steady.flight()
    assert live.frames == loaded.frames
    assert live.block.channels == loaded.block.channels
    np.testing.assert_array_equal(live.block.times, loaded.block.times)
    np.testing.assert_array_equal(live.block.values, loaded.block.values)


def test_the_map_is_found_in_the_stream_itself(
    field: Field, patience: Patience, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(readers, "MONITORS", replace(MONITORS, map_guess_us=500_000))
    field.record()
    session = Session.follow(field.folder)
    field.aircraft.send(100)
    session.update()
    assert session.snapshot().channel_map == ""
    time.sleep(0.1)
    for _ in range(40):
        field.aircraft.send(20)
        time.sleep(0.02)
        session.update()
        if session.decoder is not None:
            break
    assert session.snapshot().channel_map == "B777 box"
    patience(caught_up(session, field.aircraft.sent))
    assert session.history.span("q_volts")[0] == 100
    assert session.snapshot().calibration != ()


@pytest.mark.usefixtures("impatient")
def test_a_recorder_that_dies_is_an_alarm_and_the_next_one_goes_on(
    field: Field, patience: Patience
) -> None:
    """Kill -9: alarm, written once for all windows; after the restart the alarm is over."""
    field.record()
    session, other = (Session.follow(field.folder, channel_map="b777") for _ in range(2))

    def look() -> None:
        session.update()
        other.update()

    field.aircraft.send(50)
    patience(lambda: (look(), frames_in(session) >= 76)[1])
    assert session.alarm_registry.current_alarms == ()
    # Windows has no SIGKILL; there SIGTERM leaves a process no time either.
    os.kill(field.recorder.pid, getattr(signal, "SIGKILL", signal.SIGTERM))
    patience(lambda: (look(), session.alarm_registry.get("recorder") is not None)[1])
    alarm = session.alarm_registry.get("recorder")
    assert alarm.severity is Severity.WARNING
    assert session.snapshot().recorder.state == "failed"
    look()
    written = (field.folder / "events.jsonl").read_text()
    assert written.count('"recorder"') == 1
    assert other.acknowledge()
    look()
    assert session.alarm_registry.get("recorder").acknowledged
    field.record()
    field.aircraft.send(50)
    patience(lambda: (look(), frames_in(session) >= field.aircraft.sent)[1])
    look()
    assert session.alarm_registry.get("recorder") is None
    assert session.snapshot().recorder.state == "recording"


@pytest.mark.skipif(sys.platform == "win32", reason="Windows renames no folder with open files")
@pytest.mark.usefixtures("impatient")
def test_a_flight_folder_that_disappears_is_an_alarm_and_its_recorder_can_be_stopped(
    field: Field, patience: Patience
) -> None:
    handle = field.record()
    session = Session.follow(field.folder, channel_map="b777")
    field.aircraft.send(50)
    patience(caught_up(session, field.aircraft.sent))
    session.update()
    assert session.alarm_registry.current_alarms == ()
    field.folder.rename(field.folder.with_name("elsewhere"))
    session.update()
    assert session.snapshot().recorder.severity is Severity.WARNING
    assert session.recorder == handle
    # The recorder goes on beside it, and whoever knows the former name is led there.
    beside = field.folder.with_name(f"{field.folder.name}-2")
    patience(lambda: session.update() or session.equipment.moved_to == beside)
    patience(lambda: session.update() or session.alarm_registry.get("folder") is not None)
    assert handle.is_alive()
    assert [(one.folder, one.pid) for one in find_recorders()] == [(beside, handle.pid)]
    field.aircraft.send(50)
    patience(lambda: handle.status().frames >= field.aircraft.sent)
    assert session.recorder.stop()
    assert not handle.is_alive()
    session.update()
    assert session.snapshot().recorder.state == "stopped"
    assert session.equipment.ended
    assert find_recorders() == []


@pytest.mark.skipif(sys.platform == "win32", reason="Windows renames no folder with open files")
@pytest.mark.usefixtures("impatient")
def test_a_recorder_that_dies_together_with_its_folder_is_an_alarm(
    field: Field, patience: Patience
) -> None:
    handle = field.record()
    session = Session.follow(field.folder, channel_map="b777")
    field.aircraft.send(50)
    patience(caught_up(session, field.aircraft.sent))
    session.update()
    field.folder.rename(field.folder.with_name("elsewhere"))
    os.kill(handle.pid, signal.SIGKILL)
    patience(lambda: not handle.is_alive())
    assert find_recorders() == []
    session.update()
    view = session.snapshot().recorder
    assert (view.state, view.severity) == ("failed", Severity.WARNING)


@pytest.mark.usefixtures("impatient")
def test_silence_of_the_aircraft_is_said_and_no_value_is_left_standing(
    field: Field, patience: Patience
) -> None:
    """Age grows while nothing comes, channels turn stale, the link alarms; then all is well."""
    field.record()
    ahead = [0]
    session = Session.follow(
        field.folder,
        channel_map="b777",
        aircraft="b777",
        wall_us=lambda: time.time_ns() // 1000 + ahead[0],
    )

    look = session.update
    assert session.states() == {
        name: state
        for name, state in session.states().items()
        if state.freshness is Freshness.MISSING
    }
    field.aircraft.send(100)
    patience(lambda: (look(), frames_in(session) >= field.aircraft.sent)[1])
    look()
    states = session.states(("q", "phi", "V", "thrust"))
    assert states["q"].freshness is Freshness.FRESH
    assert states["q"].calibrated
    assert states["q"].kind == "measured"
    assert states["phi"].kind == "estimated"
    assert states["thrust"].freshness is Freshness.MISSING
    assert session.snapshot().link.state == "ok"
    ahead[0] = 4_000_000
    look()
    assert session.snapshot().link.state == "silent"
    assert session.snapshot().link.age > 3.9
    assert session.states(("q",))["q"].freshness is Freshness.STALE
    assert "silent" in session.alarm_registry.get("link").message_text()
    ahead[0] = 0
    field.aircraft.send(50)
    patience(lambda: (look(), frames_in(session) >= field.aircraft.sent)[1])
    look()
    assert not session.alarm_registry.get("link").active
    assert session.states(("q",))["q"].freshness is Freshness.FRESH


def test_a_long_past_is_taken_in_without_holding_up_the_window(
    field: Field, patience: Patience
) -> None:
    field.record()
    field.aircraft.send(1500)
    patience(lambda: field.recorder.status().frames >= field.aircraft.sent)
    session = Session.follow(field.folder, channel_map="b777")
    calls, told = 0, []
    while not session.feed.caught_up or frames_in(session) < field.aircraft.sent:
        session.update(0.002)
        told.append(session.snapshot().progress)
        calls += 1
        assert calls < 5000
    assert calls > 5
    assert session.history.span("elevator_left_volts")[0] == 100
    assert session.history.end == 15.99


def test_a_torn_record_opens_as_far_as_it_is_good(
    field: Field, patience: Patience, tmp_path: Path
) -> None:
    field.record()
    field.aircraft.send(300)
    session = Session.follow(field.folder, channel_map="b777")
    patience(caught_up(session, field.aircraft.sent))
    field.recorder.stop()
    copy = tmp_path / "copy"
    shutil.copytree(field.folder, copy, ignore=shutil.ignore_patterns("recorder*"))
    raw = bytearray((copy / "raw.tlog").read_bytes())
    raw[20_000:20_040] = b"\x55" * 40
    (copy / "raw.tlog").write_bytes(raw[:-7])
    torn = Session.replay(copy, channel_map="b777", speed=UNLIMITED_SPEED)
    run_replay(torn)
    assert "raw.tlog" in " ".join(torn.remarks)
    assert frames_in(torn) >= field.aircraft.sent - 4
    values = torn.history.samples("q_volts", 100, 390)
    good = session.history.samples("q_volts", 100, 390)
    present = ~np.isnan(values)
    assert present.sum() > 280
    # A sample lost is bridged by a straight line; all the others are untouched.
    assert (np.abs(values - good)[present] > 1e-9).sum() <= 4


def test_marks_and_acknowledgments_reach_the_other_window(field: Field) -> None:
    field.record()
    now = [0.0]
    left, right = (
        Session.follow(field.folder, channel_map="b777", clock=lambda: now[0]) for _ in range(2)
    )
    mark = left.mark("doublet", at=3.0)
    left.alarm_registry.raise_("disk", Severity.CAUTION, 3.0, "disk nearly full")
    right.alarm_registry.raise_("disk", Severity.CAUTION, 3.0, "disk nearly full")
    assert left.acknowledge()
    assert not left.acknowledge()
    now[0] += 1.0
    right.update()
    assert right.marks == (mark,)
    assert right.alarm_registry.unacknowledged == ()
    third = Session.follow(field.folder, channel_map="b777")
    third.update()
    assert third.marks == (mark,)


@pytest.mark.usefixtures("impatient")
def test_a_record_that_cannot_be_read_is_said_once_and_hides_no_dead_recorder(
    field: Field,
    patience: Patience,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    """A disk fails: the samples stand still, but link and recorder are looked after."""
    field.record()
    now = [1000.0]
    session = Session.follow(field.folder, channel_map="b777", clock=lambda: now[0])
    field.aircraft.send(50)
    patience(caught_up(session, field.aircraft.sent))
    reads = []

    def refuse(file: RawFile) -> int:
        reads.append(file)
        raise FlightError(f"{file.path} cannot be read (Device not configured)")

    with monkeypatch.context() as patch:
        patch.setattr(RawFile, "size", refuse)
        for _ in range(500):
            now[0] += 0.002
            session.update()
        assert "Device not configured" in session.snapshot().problem

        # Nobody may say that the aircraft is silent; the recorder still hears it.
        def heard() -> bool:
            now[0] += 0.1
            field.aircraft.send(5)
            session.update()
            return session.snapshot().link.state == "not read"

        patience(heard)
        link = session.alarm_registry.get("link")
        assert link is None or not link.active
        # What reached the recorder and no file is lost with it.
        patience(lambda: field.recorder.status().frames >= field.aircraft.sent)
        os.kill(field.recorder.pid, getattr(signal, "SIGKILL", signal.SIGTERM))

        def told_dead() -> bool:
            now[0] += 0.1
            session.update()
            return session.snapshot().recorder.state == "failed"

        patience(told_dead)
        alarm = session.alarm_registry.get("recorder")
        assert alarm.active
    assert len(reads) <= 2 + (now[0] - 1000.0)  # once a second
    assert len([one for one in caplog.records if "cannot be followed" in one.message]) == 1
    # Readable again, all of it is there.
    field.record()
    field.aircraft.send(50)

    def all_there() -> bool:
        now[0] += 0.1
        session.update()
        return frames_in(session) >= field.aircraft.sent

    patience(all_there)
    assert session.snapshot().problem == ""


@pytest.mark.usefixtures("impatient")
def test_events_that_cannot_be_read_hide_no_alarm_of_the_equipment(
    field: Field, patience: Patience, monkeypatch: pytest.MonkeyPatch
) -> None:
    handle = field.record()
    session = Session.follow(field.folder, channel_map="b777")

    def refuse(log: EventLog) -> list[object]:
        raise FlightError(f"{log.path} cannot be read (Input/output error)")

    monkeypatch.setattr(EventLog, "poll", refuse)
    session.update()
    assert "Input/output error" in session.snapshot().problem
    field.aircraft.send(50)
    patience(caught_up(session, field.aircraft.sent), 0.9)  # without waiting for the next try
    handle.stop()
    os.truncate(field.folder / "recorder.json", 0)
    patience(lambda: (session.update(), session.alarm_registry.get("recorder") is not None)[1])


def test_who_fails_while_watching_holds_up_nobody_else(
    field: Field, patience: Patience, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The limits fail, and a consumer beside them: said once, and the samples go on."""

    class Watcher:
        def __init__(self, fault: str = "") -> None:
            self.fault, self.rows, self.calls = fault, 0, 0

        def feed(self, block: Block) -> None:
            self.calls += 1
            if self.fault:
                raise ValueError(self.fault)
            self.rows += len(block)

        def process_step(self) -> None: ...

        def reset(self) -> None: ...

    def fail(_watch: AlarmMonitor, _block: Block) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr(AlarmMonitor, "feed", fail)
    field.record()
    broken, sound = Watcher("no"), Watcher()
    session = Session.follow(field.folder, channel_map="b777", consumers=(broken, sound))
    field.aircraft.send(100)
    patience(caught_up(session, field.aircraft.sent))
    assert sound.rows > 100
    assert broken.calls == 1
    raised = {alarm.key: alarm for alarm in session.alarm_registry.current_alarms}
    assert raised["failed:AlarmMonitor"].severity is Severity.WARNING
    assert "limits" in raised["failed:AlarmMonitor"].message_text()
    assert raised["failed:Watcher"].severity is Severity.CAUTION
    assert session.snapshot().problem == ""

"""Replays of every kind of flight, the summary, and what the bar is told."""

import io
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gsapp.flight.read_settings
from calibration import load_certificates
from gsapp.aircraft.aircraft_loader import SHIPPED_AIRCRAFT
from gsapp.cli._console import PlainConsole
from gsapp.cli.replay import print_summary, replay
from gsapp.decoding.channel_map import load_channel_map
from gsapp.decoding.dialect import dialect
from gsapp.decoding.framing import Framer
from gsapp.flight.events import Event, EventLog
from gsapp.flight.flight import Flight
from gsapp.flight.flight_loader import load_flight
from gsapp.flight.folder import FlightFolder
from gsapp.flight.raw_files import RawWriter
from gsapp.flight.summary import summarize_flight
from gsapp.foundation import FlightError, GroundStationError
from gsapp.session import UNLIMITED_SPEED, Session
from gsapp.session.feeds import parse_speed
from gsapp.session.limits import LimitBands
from gsapp.session.monitor_settings import MONITORS
from gsapp.session.replay_runner import run_replay

START_US = 1_700_000_000_000_000


def recorded(folder: Path, box: Any, ticks: int, *, skip: range = range(0)) -> Path:
    FlightFolder.create(folder)
    writer = RawWriter(folder)
    framer = Framer()
    for k in range(ticks):
        frames = box.tick(k)
        if k not in skip:
            writer.append(START_US + 10_000 * k + 3000, framer.feed(b"".join(frames)))
    writer.append(START_US + 10_000 * ticks, framer.flush())
    writer.close()
    return folder


def flight_csv(path: Path, count: int = 500, rate: float = 50.0) -> Path:
    times = np.arange(count) / rate
    alpha = np.round(3.0 + 2.0 * np.sin(times), 4)
    lines = [f"{t:.3f},{a:.4f},{120.0 + t:.3f}" for t, a in zip(times, alpha, strict=True)]
    path.write_text("time [s],alpha [deg],V [ft/s]\n" + "\n".join(lines) + "\n")
    return path


def same_but_for_cues(told: dict[str, Any], flight: Flight) -> bool:
    assert {cue["kind"] for cue in told["cues"]} >= {"trim"}
    assert isinstance(told["verdicts"], list)
    beside = ("cues", "verdicts", "flown", "senders", "messages", "rejected")
    rest = {name: told[name] for name in told if name not in beside}
    rest["events"] = [event for event in told["events"] if event["kind"] != "alarm"]
    whole = json.loads(json.dumps(summarize_flight(flight)))
    del whole["cues"]
    return rest == whole


def test_the_summary_is_that_of_the_flight_read_whole(tmp_path: Path, box: Any) -> None:
    """Headless replay and `load_flight`, of one folder with losses: one and the same JSON."""
    folder = recorded(tmp_path / "flight", box, 1500, skip=range(700, 760))
    EventLog(folder / "events.jsonl").append(Event(kind="mark", text="doublet", time=4.0))
    target = tmp_path / "out.json"
    replay(flight=folder, json=target, channel_map="b777")
    told = json.loads(target.read_text())
    assert same_but_for_cues(told, load_flight(folder, channel_map="b777"))
    assert told["frames"]["lost"] == 60 + 30 + 1
    assert told["channels"]["q"]["gaps"] == 1
    assert told["channels"]["q"]["measured"] is True
    assert told["channels"]["phi"]["measured"] is False
    assert told["events"][0]["text"] == "doublet"
    (sender,) = told["senders"]
    assert sender["lost"] == told["frames"]["lost"]
    assert sender["good"] == told["frames"]["good"]
    assert sum(one["count"] for one in told["messages"]) == sender["good"]
    daq = next(one for one in told["messages"] if one["name"] == "DEBUG_FLOAT_ARRAY")
    assert daq["count"] == 1500 - 60
    assert daq["rate"] == pytest.approx(1440 / told["duration"])
    assert daq["delay"] == pytest.approx(0.0, abs=1e-3)


def test_the_summary_of_a_flight_csv(tmp_path: Path) -> None:
    path = flight_csv(tmp_path / "flight.csv")
    target = tmp_path / "out.json"
    replay(flight=path, json=target)
    told = json.loads(target.read_text())
    assert same_but_for_cues(told, load_flight(path))
    assert told["channels"]["alpha"]["count"] == 500
    session = Session.replay(path, speed=UNLIMITED_SPEED)
    run_replay(session)
    assert session.history.rate == pytest.approx(50.0)
    np.testing.assert_array_equal(
        session.history.samples("alpha", 0, 500), load_flight(path).block["alpha"]
    )


@pytest.mark.long
def test_a_real_flight_replayed_is_the_flight_read_whole(tmp_path: Path, shared_data: Path) -> None:
    path = shared_data / "alfa_carbonz_engine_failure.tlog"
    target = tmp_path / "out.json"
    replay(flight=path, json=target)
    told = json.loads(target.read_text())
    assert same_but_for_cues(told, load_flight(path))
    assert told["frames"]["good"] > 20_000


def test_json_for_the_screen_is_nothing_but_json(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """``--json -`` can be piped; for people there is a table and the alarms."""
    path = flight_csv(tmp_path / "flight.csv")
    replay(flight=path, json=Path("-"))
    assert json.loads(capsys.readouterr().out)["duration"] == pytest.approx(9.98)
    replay(flight=path, headless=True)
    shown = capsys.readouterr().out
    assert "alpha" in shown
    assert "500" in shown


def test_wrong_speeds_and_missing_flights_are_named(tmp_path: Path) -> None:
    for text in ("0", "-1", "51", "fast", "nan"):
        with pytest.raises(GroundStationError, match=r"0\.1 to 50"):
            parse_speed(text)
    assert parse_speed("0.1") == 0.1
    assert parse_speed(" Max ") == UNLIMITED_SPEED
    with pytest.raises(FlightError, match="no flight"):
        replay(flight=tmp_path / "nothing.csv", headless=True)


def test_alarms_are_told_for_people_and_for_programs(tmp_path: Path) -> None:
    """One that is over and acknowledged, and one that is not: sentence, onset, end; no keys."""
    times = np.arange(3000) / 100.0
    alpha = np.where((times >= 5.0) & (times < 9.0), 15.2, 3.0)
    normal = np.where(times >= 20.0, 3.7, 1.0)
    flight, target = tmp_path / "flight.csv", tmp_path / "out.json"
    rows = [f"{t:.2f},{a},{n}" for t, a, n in zip(times, alpha, normal, strict=True)]
    flight.write_text("time [s],alpha [deg],an [g]\n" + "\n".join(rows) + "\n")
    watched = Session.replay(flight, aircraft="b777", speed=UNLIMITED_SPEED)
    run_replay(watched)
    assert watched.acknowledge("alpha:high")
    watched.close()
    again = Session.replay(flight, aircraft="b777", speed=UNLIMITED_SPEED)
    run_replay(again)
    screen = PlainConsole(file=io.StringIO(), width=80)
    print_summary(again, screen, target)
    again.close()
    told = json.loads(target.read_text())["events"]
    alarms = {event["data"]["alarm"]: event for event in told if event["kind"] == "alarm"}
    stall, load = alarms["alpha:high"], alarms["an:high"]
    assert "15.2 deg, above 14.0 deg" in stall["text"]
    assert stall["data"]["severity"] == "warning"
    assert stall["time"] == stall["data"]["onset"] == pytest.approx(5.1, abs=0.15)
    assert stall["data"]["end"] == pytest.approx(9.1, abs=0.15)
    assert stall["data"]["acknowledged"] is True
    assert (load["data"]["end"], load["data"]["acknowledged"]) == (None, False)
    assert stall["host_time_us"] is None
    said = screen.file.getvalue()
    assert f"{len(alarms)} alarms\n" in said
    assert "15.2 deg, above 14.0 deg" in said
    assert not any(key in said for key in alarms)


def test_jumps_show_the_past_as_it_was(tmp_path: Path, box: Any) -> None:
    """After a jump back alarms, values and messages are those of that moment."""
    folder = recorded(tmp_path / "flight", box, 3000)
    now = [0.0]
    session = Session.replay(
        folder, channel_map="b777", aircraft="b777", speed=UNLIMITED_SPEED, clock=lambda: now[0]
    )
    run_replay(session)
    end = session.snapshot()
    assert end.playhead.at_end
    assert end.playhead.time == pytest.approx(30.99)
    log = session.alarm_registry.onsets
    assert log
    middle = [onset for onset in log if onset.time <= 12.0]
    session.replay_feed.seek(12.0)
    session.update()
    assert session.now == 12.0
    assert session.alarm_registry.onsets == tuple(middle)
    assert session.history.last("q")[0] == 12.0
    states = session.states(("q",))
    assert states["q"].age == pytest.approx(0.0, abs=0.011)
    session.replay_feed.seek(1e9)
    session.update()
    assert session.alarm_registry.onsets == log
    snapshot = session.snapshot()
    assert (snapshot.mode, snapshot.aircraft, snapshot.channel_map) == (
        "replay",
        "B777",
        "B777 box",
    )
    assert snapshot.link.good > 4000
    assert snapshot.recorder.state == "none"


def test_patience_goes_by_how_often_a_message_comes(tmp_path: Path) -> None:
    """A voltage that comes every 5 s is waited for longer than an attitude."""
    common = dialect()
    link = common.MAVLink(None, srcSystem=1, srcComponent=1)
    folder = tmp_path / "flight"
    FlightFolder.create(folder)
    writer, framer = RawWriter(folder), Framer()
    for k in range(400):
        frames = link.attitude_encode(100 * k, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0).pack(link)
        if k % 50 == 0:
            status = link.sys_status_encode(0, 0, 0, 0, 11_100, -1, -1, 0, 0, 0, 0, 0, 0)
            frames += status.pack(link)
        writer.append(START_US + 100_000 * k, framer.feed(frames))
    writer.close()
    session = Session.replay(folder, channel_map="ardupilot-plane", speed=UNLIMITED_SPEED)
    run_replay(session)
    assert session.stale_timeouts(("phi", "battery", "alpha")) == {
        "phi": 0.5, "battery": 10.0, "alpha": MONITORS.default_stale_time
    }  # fmt: skip


def test_a_replay_goes_at_its_speed(tmp_path: Path, box: Any) -> None:
    folder = recorded(tmp_path / "flight", box, 2000)
    now = [0.0]
    session = Session.replay(folder, channel_map="b777", speed=2.0, clock=lambda: now[0])
    while not session.replay_feed.complete:
        session.update(math.inf)
    start = session.now
    for _ in range(100):
        now[0] += 0.02
        session.update()
    assert session.now == pytest.approx(start + 4.0, abs=0.011)
    assert session.history.end == pytest.approx(session.now, abs=0.011)
    session.replay_feed.pause()
    now[0] += 1.0
    session.update()
    assert session.now == pytest.approx(start + 4.0, abs=0.011)


def test_limits_typed_under_way_count_from_then_on(tmp_path: Path) -> None:
    """Alpha swings up to 5 deg: typed at 4 deg it alarms, and no more once they are taken back."""
    now = [0.0]
    path = flight_csv(tmp_path / "flight.csv")
    session = Session.replay(path, clock=lambda: now[0], cues=False)

    def play(seconds: float) -> list[str]:
        for _ in range(round(seconds / 0.1)):
            now[0] += 0.1
            session.update()
        return [alarm.key for alarm in session.alarm_registry.current_alarms]

    assert play(4.0) == []
    session.set_user_limits("alpha", LimitBands(warning_high=math.radians(4.0)))
    assert session.alarm_registry.current_alarms == ()  # what was before does not count
    assert play(3.9) == ["alpha:high"]
    assert session.acknowledge_all() == 1
    assert play(0.2) == ["alpha:high"]
    session.set_user_limits("alpha", None)
    assert play(0.2) == []


def test_acknowledgments_of_the_flight_hold_in_its_replay(tmp_path: Path, box: Any) -> None:
    folder = recorded(tmp_path / "flight", box, 1000)
    first = Session.replay(folder, channel_map="b777", aircraft="b777", speed=UNLIMITED_SPEED)
    run_replay(first)
    waiting = first.alarm_registry.unacknowledged
    assert waiting
    assert first.acknowledge_all() == len(waiting)
    again = Session.replay(folder, channel_map="b777", aircraft="b777", speed=UNLIMITED_SPEED)
    again.update(0.0)
    run_replay(again)
    assert not {alarm.key for alarm in again.alarm_registry.unacknowledged} & {
        alarm.key for alarm in waiting
    }


def test_settings_come_from_the_folder(tmp_path: Path, box: Any) -> None:
    folder = recorded(tmp_path / "flight", box, 300)
    place = FlightFolder.open(folder)
    place.store_channel_map(load_channel_map("b777").path)
    place.store_aircraft(SHIPPED_AIRCRAFT.find("b777"))
    (folder / "limits.toml").write_text(
        '[[limits]]\nchannel = "q"\nhigh_caution = "5 deg/s"\nhysteresis = "1 deg/s"\n'
    )
    session = Session.replay(folder, speed=UNLIMITED_SPEED)
    run_replay(session)
    assert session.snapshot().aircraft == "B777"
    assert session.limits.bands("q").caution_high == pytest.approx(math.radians(5.0))
    assert session.limits.bands("battery").caution_low is None


def test_an_empty_flight_is_no_fault(tmp_path: Path) -> None:
    folder = FlightFolder.create(tmp_path / "flight").path
    session = Session.replay(folder, speed=UNLIMITED_SPEED)
    run_replay(session)
    assert session.now is None
    assert session.snapshot().playhead is None
    assert session.flight().block.channels == ()


def test_what_the_vehicle_said_is_told_at_its_time(tmp_path: Path, box: Any) -> None:
    folder = FlightFolder.create(tmp_path / "flight").path
    writer, framer = RawWriter(folder), Framer()
    for k in range(1500):
        frames = box.tick(k)
        if k in (300, 900):
            frames.append(box.say(f"engine {k}"))
        writer.append(START_US + 10_000 * k, framer.feed(b"".join(frames)))
    writer.close()
    session = Session.replay(folder, channel_map="b777", speed=UNLIMITED_SPEED)
    run_replay(session)
    assert [event.text for event in session.messages()] == ["engine 300", "engine 900"]
    assert session.messages()[0].time == pytest.approx(4.0, abs=0.02)
    session.replay_feed.seek(6.0)
    assert [event.text for event in session.messages()] == ["engine 300"]


def test_a_record_that_fits_no_map_says_so(tmp_path: Path) -> None:
    folder = FlightFolder.create(tmp_path / "flight").path
    writer, framer = RawWriter(folder), Framer()
    module = dialect()
    packer = module.MAVLink(None, srcSystem=1, srcComponent=1)
    for k in range(100):
        frame = bytes(module.MAVLink_attitude_message(k, 0, 0, 0, 0, 0, 0).pack(packer))
        writer.append(START_US + 50_000 * k, framer.feed(frame))
    writer.close()
    with pytest.raises(FlightError, match="channel map"):
        run_replay(Session.replay(folder, speed=UNLIMITED_SPEED))
    (folder / "recorder.lock").touch()
    live = Session.follow(folder)
    live.update()
    assert "b777" in live.snapshot().problem
    assert live.history.channels == ()


def test_certificates_that_the_map_names_are_read_once(
    tmp_path: Path, box: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "flight"
    FlightFolder.create(folder)
    writer, framer = RawWriter(folder), Framer()
    for k in range(400):
        writer.append(START_US + 10_000 * k, framer.feed(b"".join(box.tick(k))))
    writer.close()
    read: list[object] = []

    def counted(name: Any) -> Any:
        read.append(name)
        return load_certificates(name)

    monkeypatch.setattr(gsapp.flight.read_settings, "load_certificates", counted)
    session = Session.replay(folder, channel_map="b777", speed=UNLIMITED_SPEED)
    run_replay(session)
    told = [session.snapshot().calibration for _ in range(5)]
    assert read == ["b777"]
    assert set(told) == {tuple(sorted(load_certificates("b777")))}
    session.close()

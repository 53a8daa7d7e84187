"""Two transmitters on one link: the state of the link is that of the flown aircraft."""

import json
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from gsapp.cli.replay import summary_json
from gsapp.decoding.health import LinkReport
from gsapp.flight import load_flight
from gsapp.flight.events import events_path, read_events
from gsapp.flight.folder_setup import prepare_flight_folder
from gsapp.session import Session
from gsapp.session.channel_states import Freshness
from gsapp.session.limits import Severity
from gsapp.session.replay_runner import run_replay
from gsapp.telemetry.recorder_control import RecorderHandle, start_recorder

# System, component, what it sends, port. A process of its own, as a transmitter is.
_SENDER = """
import sys, time
from pymavlink import mavutil
system, component, what, port = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3], sys.argv[4]
link = mavutil.mavlink_connection(
    f"udpout:127.0.0.1:{port}", source_system=system, source_component=component
)
for k in range(10_000):
    boot_ms = 1000 * system + round(1000 * (time.monotonic() % 1e6))  # 1 s apart a system
    if what == "aircraft":
        link.mav.attitude_send(boot_ms, 0.1 * system, 0, 0, 0, 0, 0)
    if what == "radio":
        link.mav.radio_status_send(180, 190, 100, 40, 45, 0, 0)
    elif k % 10 == 0:
        kind, autopilot = {"aircraft": (1, 3), "companion": (18, 8), "station": (6, 8)}[what]
        link.mav.heartbeat_send(kind, autopilot, 0, 0, 4)
    time.sleep(0.02)
"""


class Link:
    """A recorder on a UDP port, and processes that send to it."""

    def __init__(self, folder: Path) -> None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = probe.getsockname()[1]
        prepare_flight_folder(
            folder, aircraft="b777", channel_map="ardupilot-plane", source="udpin"
        )
        self.folder = folder
        self.recorder: RecorderHandle = start_recorder(f"udpin:127.0.0.1:{self.port}", folder)
        self.senders: list[subprocess.Popen[bytes]] = []

    def send(self, system: int, component: int, what: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-c", _SENDER, str(system), str(component), what, str(self.port)]
        self.senders.append(subprocess.Popen(command, env=os.environ | {"MAVLINK20": "1"}))
        return self.senders[-1]

    def close(self) -> None:
        for sender in self.senders:
            sender.kill()
            sender.wait()
        self.recorder.stop()


@pytest.fixture
def link(tmp_path: Path) -> Iterator[Link]:
    found = Link(tmp_path / "flight")
    yield found
    found.close()


def follow(session: Session, until: Callable[[], object], seconds: float = 20.0) -> None:
    deadline = time.monotonic() + seconds
    while not until():
        assert time.monotonic() < deadline
        session.update()
        time.sleep(0.01)


def follow_for(session: Session, seconds: float) -> None:
    end = time.monotonic() + seconds
    follow(session, lambda: time.monotonic() >= end, seconds + 1.0)


def report_of(session: Session) -> LinkReport:
    report = session.link_report()
    assert report is not None
    return report


def test_the_loss_of_the_aircraft_is_seen_whoever_else_is_heard(link: Link) -> None:
    """System 1 is killed; system 7, a companion computer, the radio and a station go on."""
    aircraft = link.send(1, 1, "aircraft")
    session = Session.follow(link.folder, cues=False)
    follow(session, lambda: session.snapshot().link.state == "ok")
    link.send(7, 1, "aircraft")
    link.send(1, 191, "companion")
    link.send(51, 68, "radio")
    link.send(255, 190, "station")
    follow(session, lambda: len(report_of(session).senders) == 5)
    assert session.snapshot().link.system == 1
    aircraft.send_signal(signal.SIGKILL)
    killed = time.monotonic()
    follow(session, lambda: session.snapshot().link.state == "silent")
    assert 2.5 < time.monotonic() - killed < 6.0
    follow_for(session, 1.0)
    seen = session.snapshot().link
    assert (seen.state, seen.severity, seen.system) == ("silent", Severity.WARNING, 1)
    assert (seen.age or 0.0) > 3.0
    assert session.alarm_registry.severity("link") is Severity.WARNING
    # Values do not stand as if they were new, and no value of the other aircraft takes their place.
    state = session.states(["phi"])["phi"]
    assert state.freshness is Freshness.STALE
    assert state.value == pytest.approx(0.1)
    assert [vehicle.system for vehicle in report_of(session).vehicles] == [1, 7]
    session.close()


@pytest.mark.parametrize(
    ("system", "component", "what"),
    [
        (255, 190, "station"),
        pytest.param(51, 68, "radio", marks=pytest.mark.long),
        pytest.param(1, 191, "companion", marks=pytest.mark.long),
    ],
)
def test_no_aircraft_is_heard_where_only_others_are(
    link: Link, system: int, component: int, what: str
) -> None:
    link.send(system, component, what)
    session = Session.follow(link.folder, cues=False)
    follow(session, lambda: session.snapshot().link.state == "no aircraft")
    seen = session.snapshot().link
    assert (seen.age, seen.system, seen.severity) == (None, None, Severity.CAUTION)
    assert f"system {system}, component {component}" in seen.problem
    assert session.alarm_registry.severity("link") is Severity.CAUTION
    # The aircraft comes: the alarm has gone, with nothing to acknowledge, and is in the log.
    link.send(1, 1, "aircraft")
    follow(session, lambda: session.snapshot().link.state == "ok")
    assert session.alarm_registry.get("link") is None
    assert [one.is_over for one in session.alarm_registry.episodes if one.key == "link"] == [True]
    session.close()


def test_the_flown_system_that_is_chosen_counts_everywhere(link: Link) -> None:
    """In every window, in replays, in commands, and in the data of the whole flight."""
    link.send(1, 1, "aircraft")
    session = Session.follow(link.folder, cues=False)
    follow(session, lambda: session.snapshot().link.state == "ok")
    chosen = link.send(7, 1, "aircraft")
    follow(session, lambda: len(report_of(session).vehicles) == 2)
    other_window = Session.follow(link.folder, cues=False)
    assert session.system_selection.pending is other_window.system_selection.pending is None
    session.select_system(1)  # as it is: nothing is read again, and nobody asks which any more
    assert session.system_selection.pending is None
    assert report_of(session).is_system_selected
    # Each counts flight time by its own clock, 6 s apart.
    now = session.now
    span = session.mark("first seen", at=now - 0.5, end=now)
    session.select_system(7)
    assert session.system_selection.pending == (7, "")
    assert session.marks == (span,)
    follow(other_window, lambda: other_window.system_selection.pending == (7, ""))
    session.close()
    other_window.close()

    again = Session.follow(link.folder, cues=False)
    follow(again, lambda: again.snapshot().link.state == "ok" and again.history.has("phi"))
    assert (again.snapshot().link.system, again.system_selection.pending) == (7, None)
    last = again.history.last("phi")
    assert last[1] == pytest.approx(0.7)
    assert all("on this link" not in said for said in again.snapshot().link.remarks)
    moved = now - 0.5 + 6.0
    follow(again, lambda: bool(again.marks))
    assert [mark.time for mark in again.marks] == [pytest.approx(moved, abs=0.2)]
    assert again.marks[0].end == pytest.approx(moved + 0.5, abs=0.2)
    new = again.mark("by the clock of system 7", at=now + 7.0)
    chosen.kill()
    follow(again, lambda: again.snapshot().link.state == "silent")
    again.close()

    link.close()
    events = read_events(events_path(link.folder)).events
    _, event = [one for one in events if one.kind == "vehicle"]
    assert (event.data["system"], event.host_time_us > 0) == (7, True)
    phi = load_flight(link.folder).block["phi"]
    assert (np.nanmin(phi), np.nanmax(phi)) == (pytest.approx(0.7), pytest.approx(0.7))
    replay = Session.replay(link.folder, speed=float("inf"), cues=False)
    run_replay(replay, lambda _share: None)
    times = [pytest.approx(moved, abs=0.2), new.time]
    assert [mark.time for mark in replay.marks] == times
    told = [one.time for one in load_flight(link.folder).events if one.kind == "mark"]
    assert told == times
    summary = json.loads(json.dumps(summary_json(replay)))
    replay.close()
    flown = summary["flown"]
    assert (flown["system"], flown["component"], flown["chosen"]) == (7, 1, True)
    assert summary["channels"]["phi"]["max"] == pytest.approx(0.7)

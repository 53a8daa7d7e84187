"""Recorder, disk and link: what the crew is told, from the state that a recorder writes."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from gsapp.decoding.framing import Framer
from gsapp.decoding.health import LinkHealth
from gsapp.session import equipment
from gsapp.session.alarms import AlarmBoard
from gsapp.session.equipment import EquipmentMonitor
from gsapp.session.limits import Severity
from gsapp.telemetry.status import RecorderStatus, write_status

NOW_US = 1_700_000_000_000_000


@dataclass
class Bench:
    """A monitor whose clocks, recorder and status the test turns."""

    folder: Path
    running: bool = True
    now: float = 0.0
    ahead_us: int = 0
    values: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.board = AlarmBoard()
        self.health = LinkHealth()
        self.monitor = EquipmentMonitor(
            self.folder, self.board, lambda: self.now, lambda: NOW_US + self.ahead_us
        )

    def find(self, _: Path) -> Any:
        return self if self.running else None

    def status(self) -> RecorderStatus:
        given = {
            "pid": 7,
            "link": "udpin:127.0.0.1:14550",
            "folder": str(self.folder),
            "state": "recording",
            "started_us": NOW_US,
            "updated_us": NOW_US + self.ahead_us,
            "connected": True,
            "disk_free_bytes": 10**11,
            "seconds_until_full": 1e6,
        }
        return RecorderStatus(**{**given, **self.values})

    def look(self, **values: Any) -> dict[str, Severity]:
        """Change the status, let half a second pass, and return what is wrong."""
        self.values.update(values)
        write_status(self.folder / "recorder.json", self.status())
        self.now += 0.5
        assert self.monitor.look(self.health, 12.0)
        assert not self.monitor.look(self.health, 12.0)
        return {alarm.key: alarm.current for alarm in self.board.standing if alarm.active}


@pytest.fixture
def bench(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Bench:
    found = Bench(tmp_path)
    monkeypatch.setattr(equipment, "find_recorder", found.find)
    return found


def test_all_is_well(bench: Bench) -> None:
    """A recorder that writes, room on the disk, an aircraft not yet heard: no alarm."""
    assert bench.look(received_bytes=1000) == {}
    assert bench.look(received_bytes=2000, byte_rate=2000.0) == {}
    seen = bench.monitor
    assert (seen.recorder.words, seen.recorder.growing, seen.recorder.pid) == ("recording", True, 7)
    assert (seen.link.words, seen.link.age) == ("waiting", None)
    assert seen.disk.free_bytes == 10**11
    assert bench.look() == {}
    assert not seen.recorder.growing


def test_a_record_that_is_being_read_again_says_nothing_of_the_link(bench: Bench) -> None:
    """A window that attaches late sees old frames first; the aircraft is not silent for that."""
    bench.look()
    bench.now += 0.5
    assert bench.monitor.look(bench.health, 12.0, caught_up=False)
    assert (bench.monitor.link.words, bench.monitor.link.age) == ("catching up", None)
    assert not bench.board.standing


def test_the_disk_is_announced_long_before_it_is_full(bench: Bench) -> None:
    """Caution half an hour ahead or at 500 MB, warning ten minutes ahead or at 50 MB."""
    assert bench.look(seconds_until_full=1900.0) == {}
    assert bench.look(seconds_until_full=1500.0) == {"disk": Severity.CAUTION}
    assert "enough for 25 min" in bench.board.get("disk").sentence()
    assert bench.look(seconds_until_full=300.0) == {"disk": Severity.WARNING}
    assert bench.look(seconds_until_full=None, disk_free_bytes=4 * 10**8) == {
        "disk": Severity.CAUTION
    }
    assert bench.look(disk_free_bytes=10**7) == {"disk": Severity.WARNING}
    assert bench.look(disk_free_bytes=10**11) == {}


def test_a_recorder_that_fails_hangs_dies_or_was_stopped(bench: Bench) -> None:
    """Each in its own words; a recorder that was stopped is none of the crew's worries."""
    assert bench.look(error="The disk is full.") == {"recorder": Severity.WARNING}
    assert bench.monitor.recorder.words == "not writing"
    assert bench.board.get("recorder").sentence() == "The disk is full."
    assert bench.look(error="") == {}
    bench.ahead_us = 6_000_000
    assert bench.look(updated_us=NOW_US) == {"recorder": Severity.WARNING}
    assert bench.monitor.recorder.words == "hangs"
    bench.running = False
    assert bench.look() == {"recorder": Severity.WARNING}
    assert bench.monitor.recorder.words == "dead"
    assert "start it again" in bench.board.get("recorder").sentence()
    assert not bench.monitor.ended
    assert bench.look(state="stopped") == {}
    assert bench.monitor.ended
    assert bench.monitor.link.words == "ended"


def test_a_link_that_is_lost_silent_or_weak(bench: Bench, box: Any) -> None:
    """Lost is the port, silent the aircraft, weak the way between."""
    assert bench.look(connected=False, source_state="/dev/ttyUSB0 is gone") == {
        "link": Severity.WARNING
    }
    assert "ttyUSB0" in bench.board.get("link").sentence()
    assert bench.look(connected=True) == {}
    framer = Framer()

    def hear(ticks: range, every: int = 1) -> None:
        for k in ticks:
            frames = framer.feed(b"".join(box.tick(k)))
            if k % every == 0:
                stamp = NOW_US + bench.ahead_us
                bench.health.feed([(stamp, "frame", frame.data) for frame in frames])

    hear(range(100))
    assert bench.look() == {}
    assert (bench.monitor.link.words, bench.monitor.link.loss) == ("ok", 0.0)
    hear(range(100, 200), every=4)
    assert bench.look() == {"link": Severity.CAUTION}
    assert bench.monitor.link.words == "weak"
    assert 0.2 < bench.monitor.link.loss < 0.6
    for _ in range(25):
        bench.look()
    hear(range(200, 300))
    assert bench.look() == {}
    bench.ahead_us = 4_000_000
    assert bench.look(updated_us=NOW_US + 4_000_000) == {"link": Severity.WARNING}
    assert bench.monitor.link.words == "silent"
    garbage = [(NOW_US + 4_000_000 + k * 10_000, "residue", b"\xa5" * 50) for k in range(400)]
    bench.health.feed(garbage)
    bench.ahead_us = 8_000_000
    assert bench.look(updated_us=NOW_US + 8_000_000) == {"link": Severity.WARNING}
    assert (bench.monitor.link.words, bench.monitor.link.age) == ("unreadable", None)
    assert "check the baud rate" in bench.board.get("link").sentence()

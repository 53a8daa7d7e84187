"""Recorder, disk and link: what the crew is told, from the state that a recorder writes."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from gsapp.decoding.framing import Framer
from gsapp.decoding.health import LinkHealth
from gsapp.session import equipment_monitor
from gsapp.session.alarms import AlarmRegistry
from gsapp.session.equipment_monitor import EquipmentMonitor, build_link_summary
from gsapp.session.limits import Severity
from gsapp.telemetry.clock import HostClock
from gsapp.telemetry.recorder_status import RecorderStatus, read_status, write_status

NOW_US = 1_700_000_000_000_000


@dataclass
class Bench:
    """A monitor whose clocks, recorder and status the test turns."""

    folder: Path
    running: bool = True
    now: float = 0.0
    set_us: int = 0
    values: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.board = AlarmRegistry()
        self.health = LinkHealth()
        self.health.flown = 1, 1
        self.clock = HostClock(wall_us=self.wall_us)
        self.monitor = EquipmentMonitor(self.folder, self.board, lambda: self.now, self.wall_us)

    def wall_us(self) -> int:
        return NOW_US + round(1e6 * self.now) + self.set_us

    def find(self, _: Path) -> Any:
        return self if self.running else None

    def is_folder_reachable(self) -> bool:
        return True

    def status(self) -> RecorderStatus:
        given = {
            "pid": 7,
            "link": "udpin:127.0.0.1:14550",
            "folder": str(self.folder),
            "state": "recording",
            "started_us": NOW_US,
            "updated_us": self.clock.now_us(),
            "ahead_us": self.clock.correction_us,
            "connected": True,
            "disk_free_bytes": 10**11,
            "seconds_until_full": 1e6,
        }
        return RecorderStatus(**{**given, **self.values})

    def look(self, **values: Any) -> dict[str, Severity]:
        self.values.update(values)
        write_status(self.folder / "recorder.json", self.status())
        self.now += 0.5
        assert self.monitor.update(self.health, 12.0)
        assert not self.monitor.update(self.health, 12.0)
        return {alarm.key: alarm.current for alarm in self.board.current_alarms if alarm.active}


@pytest.fixture
def bench(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Bench:
    found = Bench(tmp_path)
    monkeypatch.setattr(equipment_monitor, "find_recorder", found.find)
    return found


def test_all_is_well(bench: Bench) -> None:
    assert bench.look(received_bytes=1000) == {}
    assert bench.look(received_bytes=2000, byte_rate=2000.0) == {}
    seen = bench.monitor
    assert (seen.recorder.state, seen.recorder.growing, seen.recorder.pid) == ("recording", True, 7)
    assert (seen.link.state, seen.link.age) == ("waiting", None)
    assert seen.disk.free_bytes == 10**11
    assert bench.look() == {}
    assert not seen.recorder.growing


def test_a_record_that_is_being_read_again_says_nothing_of_the_link(bench: Bench) -> None:
    bench.look()
    bench.now += 0.5
    assert bench.monitor.update(bench.health, 12.0, caught_up=False)
    assert (bench.monitor.link.state, bench.monitor.link.age) == ("catching up", None)
    assert not bench.board.current_alarms


def test_the_disk_is_announced_long_before_it_is_full(bench: Bench) -> None:
    assert bench.look(seconds_until_full=1900.0) == {}
    assert bench.look(seconds_until_full=1500.0) == {"disk": Severity.CAUTION}
    assert "enough for 25 min" in bench.board.get("disk").message_text()
    assert bench.look(seconds_until_full=300.0) == {"disk": Severity.WARNING}
    assert bench.look(seconds_until_full=None, disk_free_bytes=4 * 10**8) == {
        "disk": Severity.CAUTION
    }
    assert bench.look(disk_free_bytes=10**7) == {"disk": Severity.WARNING}
    assert bench.look(disk_free_bytes=10**11) == {}


def test_a_recorder_that_fails_hangs_dies_or_was_stopped(bench: Bench) -> None:
    assert bench.look(error="Disk full.") == {"recorder": Severity.WARNING}
    assert bench.monitor.recorder.state == "not writing"
    assert bench.board.get("recorder").message_text() == "Disk full."
    assert bench.look(error="The disk fails.", unconfirmed=True) == {"recorder": Severity.WARNING}
    assert bench.monitor.recorder.state == "on failing disk"
    assert bench.look(error="", unconfirmed=False) == {}
    stamp = bench.status().updated_us
    assert bench.look(updated_us=stamp) == {}
    bench.now += 6.0
    assert bench.look() == {"recorder": Severity.WARNING}
    assert bench.monitor.recorder.state == "hangs"
    bench.running = False
    assert bench.look() == {"recorder": Severity.WARNING}
    assert bench.monitor.recorder.state == "failed"
    assert not bench.monitor.ended
    assert bench.look(state="stopped") == {}
    assert bench.monitor.ended
    assert bench.monitor.link.state == "ended"


def test_a_link_that_is_lost_silent_or_weak(bench: Bench, box: Any) -> None:
    assert bench.look(connected=False, source_state="/dev/ttyUSB0 is gone") == {
        "link": Severity.WARNING
    }
    assert "ttyUSB0" in bench.board.get("link").message_text()
    assert bench.look(connected=True) == {}
    framer = Framer()

    def hear(ticks: range, every: int = 1) -> None:
        for k in ticks:
            frames = framer.feed(b"".join(box.tick(k)))
            if k % every == 0:
                stamp = bench.clock.now_us()
                bench.health.feed([(stamp, "frame", frame.data) for frame in frames])

    hear(range(100))
    assert bench.look() == {}
    assert (bench.monitor.link.state, bench.monitor.link.loss) == ("ok", 0.0)
    hear(range(100, 200), every=4)
    assert bench.look() == {"link": Severity.CAUTION}
    assert bench.monitor.link.state == "weak"
    assert 0.2 < bench.monitor.link.loss < 0.6
    for tick in range(200, 225):
        hear(range(tick, tick + 1))
        bench.look()
    hear(range(225, 325))
    assert bench.look() == {}
    bench.now += 4.0
    assert bench.look() == {"link": Severity.WARNING}
    assert bench.monitor.link.state == "silent"
    garbage = []
    for _ in range(400):
        bench.now += 0.01
        garbage.append((bench.clock.now_us(), "residue", b"\xa5" * 50))
    bench.health.feed(garbage)
    assert bench.look() == {"link": Severity.WARNING}
    assert (bench.monitor.link.state, bench.monitor.link.age) == ("unreadable", None)
    assert "baud rate" in bench.board.get("link").message_text()


def test_loss_is_the_share_of_what_was_sent(bench: Bench, box: Any) -> None:
    framer = Framer()
    frames = framer.feed(b"".join(b"".join(box.tick(k)) for k in range(500)))
    bench.look()
    for index, frame in enumerate(frames[:400]):
        if index < 200 or index % 4:
            bench.health.feed([(bench.clock.now_us(), "frame", frame.data)])
        if index in (199, 399):
            bench.look()
    report = bench.health.report()
    assert (report.good, report.lost) == (350, 50)
    assert bench.monitor.link.loss == pytest.approx(50 / 400)
    assert build_link_summary(report, words="replay").loss == pytest.approx(50 / 400)
    assert build_link_summary(report, words="ok", loss=0.0).loss == 0.0
    # What was lost long ago does not count any more.
    bench.now += 10.0
    bench.look()
    for frame in frames[400:]:
        bench.health.feed([(bench.clock.now_us(), "frame", frame.data)])
    bench.look()
    assert bench.monitor.link.loss == 0.0


def test_where_the_record_cannot_be_read_the_recorder_tells_of_the_link(bench: Bench) -> None:
    def look(heard: float | None) -> str:
        last = None if heard is None else bench.wall_us() - round(1e6 * heard)
        bench.values["last_data_us"] = last
        write_status(bench.folder / "recorder.json", bench.status())
        bench.now += 0.5
        assert bench.monitor.update(bench.health, 12.0, unread=True)
        return bench.monitor.link.state

    assert [look(heard) for heard in (None, -1.0, 0.0, 2.4, 2.6)] == [
        "waiting", "not read", "not read", "not read", "silent",
    ]  # fmt: skip
    assert bench.board.severity("link") is Severity.WARNING


def test_a_full_disk_does_not_silence_the_aircraft(bench: Bench, box: Any) -> None:
    frames = Framer().feed(b"".join(b"".join(box.tick(k)) for k in range(100)))
    bench.health.feed([(bench.clock.now_us(), "frame", frame.data) for frame in frames])
    full = {"error": "Disk full.", "waiting_bytes": 80_000}
    for _ in range(10):  # the record ends, and the recorder receives
        alarms = bench.look(last_data_us=bench.wall_us(), **full)
    assert alarms == {"recorder": Severity.WARNING}
    assert bench.monitor.link.state == "not read"
    for _ in range(10):
        alarms = bench.look(**full)
    assert alarms == {"recorder": Severity.WARNING, "link": Severity.WARNING}
    assert bench.monitor.link.state == "silent"


def test_a_record_does_not_grow_that_nobody_writes(bench: Bench) -> None:
    bench.look(received_bytes=1000)
    bench.running = False
    bench.look(received_bytes=2000, byte_rate=2000.0)
    seen = bench.monitor.recorder
    assert (seen.state, seen.growing, seen.byte_rate, seen.pid) == ("failed", False, 0.0, None)


@pytest.mark.parametrize("step", [-30.0, 30.0, -3600.0])
def test_a_clock_that_was_set_hides_no_silence_and_no_hanging_recorder(
    bench: Bench, box: Any, step: float
) -> None:
    """The stamps of a record go on where the computer's clock goes back; so do the ages."""
    framer = Framer()

    def fly(ticks: range) -> None:
        for k in ticks:
            for frame in framer.feed(b"".join(box.tick(k))):
                bench.health.feed([(bench.clock.now_us(), "frame", frame.data)])
            bench.now += 0.01

    fly(range(100))
    assert bench.look() == {}
    bench.set_us = round(1e6 * step)
    fly(range(100, 200))
    told = {"clock": Severity.CAUTION} if step < 0.0 else {}
    assert bench.look() == told
    assert bench.monitor.link.state == "ok"
    assert bench.monitor.link.age == pytest.approx(0.5, abs=0.1)
    assert bench.monitor.recorder.state == "recording"
    # Told once, and remembered by the recorder's words after that.
    alarm = bench.board.get("clock")
    assert bench.look() == {}
    if step < 0.0:
        much = "30 s" if step == -30.0 else "60 min"
        assert f"{much} behind the record" in alarm.message_text()
        assert any("was set back" in remark for remark in bench.monitor.recorder.remarks)
    stamp = bench.status().updated_us
    assert bench.look(updated_us=stamp) == {}
    bench.now += 20.0
    assert bench.look() == {"link": Severity.WARNING, "recorder": Severity.WARNING}
    assert (bench.monitor.link.state, bench.monitor.recorder.state) == ("silent", "hangs")
    assert bench.monitor.link.age == pytest.approx(22.0, abs=0.1)


def test_a_clock_set_back_while_the_recorder_hangs_does_not_hide_that(bench: Bench) -> None:
    stamp = bench.status().updated_us
    assert bench.look(updated_us=stamp) == {}
    bench.set_us = -3_600_000_000
    bench.now += 6.0
    bench.monitor.update(bench.health, 12.0)
    assert bench.monitor.recorder.state == "hangs"


def test_a_flight_that_ends_in_the_future_is_continued_with_eyes_open(
    bench: Bench, box: Any
) -> None:
    bench.clock = HostClock(after_us=NOW_US + 30_000_000, wall_us=bench.wall_us)
    for frame in Framer().feed(b"".join(box.tick(0))):
        bench.health.feed([(bench.clock.now_us(), "frame", frame.data)])
    assert bench.look() == {"clock": Severity.CAUTION}
    bench.now += 5.0
    assert bench.look() == {"link": Severity.WARNING}


def test_a_state_without_the_correction_is_still_read(tmp_path: Path) -> None:
    path = tmp_path / "recorder.json"
    path.write_text(
        '{"pid": 7, "link": "virtual", "folder": "/f", "state": "recording", "started_us": 1, '
        '"updated_us": 2}',
        encoding="utf-8",
    )
    status = read_status(path)
    assert status.ahead_us == 0

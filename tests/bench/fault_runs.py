"""Runs of the fault campaign: what sends, records, follows, and the account of every byte."""

import json
import multiprocessing
import os
import random
import select
import signal
import socket
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from fastcrc import crc16

from gsapp.decoding.dialect import wire_formats
from gsapp.flight.folder_setup import prepare_flight_folder
from gsapp.flight.raw_files import RawTail
from gsapp.session import Session
from gsapp.telemetry.recorder_control import find_recorder, start_recorder
from gsapp.telemetry.recorder_process import record_link
from gsapp.virtual.downlink.aircraft_process import find_free_udp_port

FLIGHT = 200.0  # s
GOAL = 2.0  # s of recovery
EQUIPMENT = ("link", "recorder", "disk", "clock", "folder", "aircraft", "stranger")
_TIMEOUT = 15.0


@dataclass(slots=True)
class Outcome:
    """What one run showed."""

    fault: str
    seed: int
    sent: int = 0
    lost: int = 0
    missed: int = 0
    due: bool = True  # Whether an alarm is due.
    announced: float | None = None
    recovered: float | None = None
    false: list[str] = field(default_factory=list)
    other: list[str] = field(default_factory=list)  # Alarms of the flight itself.
    wrong: list[str] = field(default_factory=list)  # Whatever else is not as it should be.

    @property
    def good(self) -> bool:
        unannounced = self.due and self.announced is None
        slow = self.recovered is not None and self.recovered > GOAL
        return not (self.lost or unannounced or self.false or self.wrong or slow)


# The aircraft


class Sender(threading.Thread):
    """Sends a part of the flight at its real rate, and keeps what it delivered.

    `deliver` hands bytes over and returns whether they were taken; `shape` makes of a frame what
    is sent in its place.
    """

    def __init__(self, frames: list[tuple[float, bytes]], deliver: Callable[[bytes], bool]) -> None:
        super().__init__(daemon=True)
        self.delivered: list[tuple[float, bytes]] = []
        self.silent = self.over = False
        self.speed = 1.0
        self.deliver = deliver
        self.shape: Callable[[bytes], list[bytes]] = lambda frame: [frame]
        self._frames = frames

    def run(self) -> None:
        due, former = time.monotonic(), self._frames[0][0]
        for at, frame in self._frames:
            due, former = due + (at - former) / self.speed, at
            time.sleep(max(due - time.monotonic(), 0.0))
            if self.over:
                break
            if not self.silent:
                for data in self.shape(frame):
                    self.send(data)

    def send(self, data: bytes) -> None:
        if self.deliver(data):
            self.delivered.append((time.monotonic(), data))

    def stop(self) -> None:
        self.over = True
        self.join()


def udp(port: int) -> Callable[[bytes], bool]:
    line = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    line.connect(("127.0.0.1", port))

    def deliver(data: bytes) -> bool:
        try:
            line.send(data)
        except ConnectionRefusedError:  # it tells of the one before
            return False
        return True

    return deliver


def of_system(frame: bytes, system: int) -> bytes:
    data = bytearray(frame)
    body = 10 + data[1]
    data[5] = system
    extra = wire_formats()[int.from_bytes(data[7:10], "little")].crc_extra
    data[body : body + 2] = crc16.mcrf4xx(bytes(data[1:body]) + extra).to_bytes(2, "little")
    return bytes(data)


def _hangs_up(master: int) -> bool:
    """Return whether no program has the other end of a pseudo-terminal open."""
    state = select.poll()
    state.register(master, select.POLLHUP)
    return bool(state.poll(0))


class SerialPort:
    """A pseudo-terminal under a name that stays."""

    def __init__(self, name: Path) -> None:
        self.name = name
        self._master: int | None = None
        self._opened = 0.0

    def plug(self) -> None:
        self._master, slave = os.openpty()
        self.name.unlink(missing_ok=True)
        self.name.symlink_to(os.ttyname(slave))
        os.close(slave)
        os.set_blocking(self._master, False)

    def unplug(self) -> None:
        master, self._master = self._master, None
        self.name.unlink()
        os.close(master)

    def deliver(self, data: bytes) -> bool:
        """Write bytes where a program has opened the port; while it opens, they are flushed."""
        if self._master is None or _hangs_up(self._master):
            self._opened = time.monotonic()
            return False
        if time.monotonic() < self._opened + 0.03:
            return False
        try:
            return self._master is not None and os.write(self._master, data) == len(data)
        except OSError:
            return False


# The ground station


class Run:
    """Recorder, sender and a session that follows, of one run."""

    def __init__(self, outcome: Outcome, flight: list[tuple[float, bytes]], scratch: Path) -> None:
        self.outcome = outcome
        self.choose = random.Random(outcome.seed * 1000 + sum(outcome.fault.encode()))
        self.scratch = scratch
        os.environ["GSAPP_RUNTIME_FOLDER"] = str(scratch / "run")
        self.folder = scratch / "field" / "flight"
        self.port = find_free_udp_port()
        self.link = f"udpin:127.0.0.1:{self.port}"
        self.flight = flight
        self.offset = self.choose.uniform(0.0, FLIGHT - 60.0)
        self.sender = Sender(self.part(), udp(self.port))
        self.expected: set[str] = set()
        self.clock_step = 0.0  # s of the computer's clock
        self.asleep = 0.0  # s by which the clock that never goes back did not go on
        self.session: Session | None = None
        self.others: list[Session] = []  # further windows
        self.senders: list[Sender] = [self.sender]
        self._own: multiprocessing.Process | None = None
        self._step = multiprocessing.Value("d", 0.0)

    def part(self) -> list[tuple[float, bytes]]:
        return [one for one in self.flight if one[0] >= self.offset]

    # The ground station

    def prepare(self) -> None:
        prepare_flight_folder(self.folder, aircraft="b777", channel_map="b777", source=self.link)

    def record(self) -> None:
        start_recorder(self.link, self.folder)

    def record_here(self, **options) -> None:
        """Record in a fork of this process, whose clock can be set and whose ports are made up."""

        def work() -> None:
            real = time.time_ns
            time.time_ns = lambda: real() + round(1e9 * self._step.value)
            stop = threading.Event()
            signal.signal(signal.SIGTERM, lambda *_: stop.set())
            record_link(self.link, self.folder, stop=stop, **options)
            os._exit(0)

        self._own = multiprocessing.get_context("fork").Process(target=work, daemon=True)
        self._own.start()

    def set_clock(self, seconds: float) -> None:
        self._step.value = self.clock_step = seconds

    def follow(self, folder: Path | None = None, **options) -> Session:
        return Session.follow(
            folder or self.folder, channel_map="b777", aircraft="b777",
            clock=lambda: time.monotonic() - self.asleep,
            wall_us=lambda: time.time_ns() // 1000 + round(1e6 * self.clock_step), **options,
        )  # fmt: skip

    def begin(self, **options) -> None:
        """Record, follow, and fly until the link is well."""
        self.prepare()
        if self._own is None:
            self.record()
        else:
            self.wait(lambda: find_recorder(self.folder), step=False)
        self.session = self.follow(**options)
        self.sender.start()
        self.wait(lambda: self.session.snapshot().link.state == "ok")
        self.fly(self.choose.uniform(0.2, 2.0))

    @property
    def handle(self):
        return find_recorder(self.folder)

    def kill_recorder(self, number: int = signal.SIGKILL) -> None:
        os.kill(self.handle.pid, number)

    def step(self) -> None:
        for session in (self.session, *self.others):
            if session is not None:
                session.update()
                self.note(session)
        time.sleep(0.003)

    def note(self, session: Session) -> None:
        for alarm in session.alarm_registry.current_alarms:
            is_false = alarm.key in EQUIPMENT or alarm.key.endswith(":silent")
            known = self.outcome.false if is_false else self.outcome.other
            text = f"{alarm.key}: {alarm.message}"
            if alarm.key not in self.expected and not any(
                one.startswith(f"{alarm.key}:") for one in known
            ):
                known.append(text)

    def fly(self, seconds: float) -> None:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.step()

    def wait(self, condition: Callable, seconds: float = _TIMEOUT, *, step: bool = True) -> float:
        """Go on until a condition holds; return after how many seconds, inf if it never did."""
        begin = time.monotonic()
        while not condition():
            if time.monotonic() > begin + seconds:
                return float("inf")
            if step:
                self.step()
            else:
                time.sleep(0.01)
        return time.monotonic() - begin

    # What is asked

    def alarm(self, *keys: str, session: Session | None = None) -> bool:
        registry = (session or self.session).alarm_registry
        return any((found := registry.get(key)) is not None and found.active for key in keys)

    def is_announced(self, *keys: str) -> bool:
        return any(self.session.alarm_registry.get(key) is not None for key in keys)

    def announce(self, *keys: str, within: float = _TIMEOUT) -> None:
        """Wait for one of these alarms, be it over again."""
        self.expected.update(keys)
        took = self.wait(lambda: self.is_announced(*keys), within)
        self.outcome.announced = None if took == float("inf") else took

    def is_current(self, session: Session | None = None) -> bool:
        """Return whether the newest sample that was sent is nearly there, and nothing is behind."""
        found = session or self.session
        decoder = found.decoder
        stamp = None if decoder is None else decoder.data_stamp
        now = time.time_ns() // 1000 + round(1e6 * self.clock_step)
        if stamp is None or found.equipment is None or not found.feed.is_up_to_date:
            return False
        ahead = found.equipment.host_us() - now
        return abs(now + ahead - stamp) < 0.15e6

    def recover(self, condition: Callable[[], bool] | None = None) -> None:
        """Wait until samples are current again, then until its alarms have ended."""
        took = self.wait(lambda: (condition is None or condition()) and self.is_current())
        if took == float("inf"):
            self.outcome.wrong.append("never recovered")
        self.outcome.recovered = took
        if self.wait(lambda: not self.alarm("link", "recorder", "disk"), 12.0) == float("inf"):
            self.outcome.false += [
                f"does not end: {one.key}: {one.message}"
                for one in self.session.alarm_registry.current_alarms
                if one.active and one.key in ("link", "recorder", "disk")
            ]
        self.fly(self.choose.uniform(0.2, 0.6))

    # The account

    def finish(self) -> None:
        for sender in self.senders:
            sender.stop()
        time.sleep(0.1)
        handle = self.handle
        self.record_folder = self.folder if handle is None else handle.folder
        if handle is not None and not handle.stop():
            self.outcome.wrong.append("the recorder does not stop")
        if self._own is not None:
            self._own.join(5.0)
        for session in (self.session, *self.others):
            if session is not None:
                session.close()

    def count(self) -> None:
        """Compare the record with what was delivered."""
        sent = [item for sender in self.senders for item in sender.delivered]
        self.outcome.sent += sum(len(data) for _, data in sent)
        kept = [record.data for record in RawTail(self.record_folder).poll()]
        if len(self.senders) == 1 and b"".join(kept) == b"".join(data for _, data in sent):
            return
        there = Counter(kept)
        for _, data in sent:
            if there[data]:
                there[data] -= 1
            elif data not in b"".join(kept):
                self.outcome.lost += len(data)

    def excuse(self, begin: float, end: float) -> None:
        """Take out of the account what was sent while nothing could receive it."""
        kept = Counter(record.data for record in RawTail(self.handle.folder).poll())
        for sender in self.senders:
            for at, data in [one for one in sender.delivered if begin <= one[0] < end]:
                if not kept[data]:
                    sender.delivered.remove((at, data))
                    self.outcome.missed += len(data)


# The window


class Window:
    """The real window off screen, in a process of its own that tells a file how it fares."""

    def __init__(self, run: Run) -> None:
        self.told = run.scratch / f"told-{time.monotonic_ns()}.json"
        self.process = subprocess.Popen(
            [sys.executable, __file__, run.scratch / "settings", run.folder, self.told],
            env={
                **os.environ, "QT_QPA_PLATFORM": "offscreen",
                "PYTHONPATH": os.pathsep.join(path for path in sys.path if path),
            },
            stderr=(run.scratch / "window.log").open("ab"),
        )  # fmt: skip

    def state(self) -> dict:
        try:
            return json.loads(self.told.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return {}

    def is_current(self) -> bool:
        found = self.state()
        return bool(found) and found["current"] and time.monotonic() - found["at"] < 0.3

    def stop(self) -> None:
        self.process.send_signal(signal.SIGCONT)
        self.process.kill()
        self.process.wait()


def show_window(settings: Path, folder: Path, told: Path) -> None:
    from PySide6.QtCore import QTimer

    from gsapp.foundation import write_atomically
    from ui.app import create_application
    from ui.error_reporter import ErrorReporter
    from ui.main_window import MainWindow
    from ui.settings import SettingsStore

    application = create_application()
    store = SettingsStore(settings / "window.toml")
    store.change(muted=True)
    window = MainWindow(store, ErrorReporter(), offer_recorders=False)
    window.resize(1280, 800)
    window.show()
    window.flight_controller.flight_opener.open_flight(folder)

    def tell() -> None:
        session = window.flight_controller.session
        stamp = None if session is None or session.decoder is None else session.decoder.data_stamp
        if stamp is None:
            return
        state = {
            "at": time.monotonic(),
            "current": session.feed.is_up_to_date and time.time() - stamp / 1e6 < 0.15,
            "alarms": [one.key for one in session.alarm_registry.current_alarms if one.active],
            "folder": str(session.path),
            "recorder": session.snapshot().recorder.state,
        }
        write_atomically(told, json.dumps(state))

    timer = QTimer()
    timer.timeout.connect(tell)
    timer.start(50)
    application.exec()


if __name__ == "__main__":
    show_window(*map(Path, sys.argv[1:4]))

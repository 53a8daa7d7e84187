"""Runs of the fault campaign: what sends, records, follows, and the account of every byte."""

import contextlib
import json
import math
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

from gsapp.decoding.dialect import dialect
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
_FORK = multiprocessing.get_context("fork")


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
            for data in [] if self.silent else self.shape(frame):
                if self.deliver(data):
                    self.delivered.append((time.monotonic(), data))

    def stop(self) -> None:
        self.over = True
        self.join()


def udp(port: int) -> Callable[[bytes], bool]:
    line = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    line.connect(("127.0.0.1", port))

    def deliver(data: bytes) -> bool:
        with contextlib.suppress(ConnectionRefusedError):  # it tells of the one before
            return line.send(data) == len(data)
        return False

    return deliver


def of_system(frame: bytes, system: int) -> bytes:
    packer = dialect().MAVLink(None, srcSystem=system, srcComponent=frame[6])
    packer.seq = frame[4]
    return bytes(dialect().MAVLink(None).decode(bytearray(frame)).pack(packer))


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
        state, master = select.poll(), self._master
        with contextlib.suppress(OSError, ValueError):  # it was pulled meanwhile
            state.register(-1 if master is None else master, select.POLLHUP)
            if state.poll(0):
                self._opened = time.monotonic()
            elif time.monotonic() > self._opened + 0.03:
                return os.write(master, data) == len(data)
            return False
        self._opened = time.monotonic()
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
        self.senders: list[Sender] = []
        self.start_at(self.choose.uniform(0.0, FLIGHT - 60.0))
        self.expected: set[str] = set()
        self.clock_step = 0.0  # s of the computer's clock
        self.asleep = 0.0  # s by which the clock that never goes back did not go on
        self.sessions: list[Session] = []
        self.windows: list[Window] = []
        self.cleanup = contextlib.ExitStack()  # when all is counted
        self._own: multiprocessing.Process | None = None
        self._step = multiprocessing.Value("d", 0.0)

    def start_at(self, seconds: float) -> None:
        """Let the flight be sent from a time on."""
        self.offset = seconds
        self.sender = Sender(self.part(), udp(self.port))
        self.senders[:] = [self.sender]

    def part(self) -> list[tuple[float, bytes]]:
        return [one for one in self.flight if one[0] >= self.offset]

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

        self._own = _FORK.Process(target=work, daemon=True)
        self._own.start()

    def set_clock(self, seconds: float) -> None:
        self._step.value = self.clock_step = seconds

    def follow(self, **options) -> Session:
        return Session.follow(
            self.folder, channel_map="b777", aircraft="b777",
            clock=lambda: time.monotonic() - self.asleep,
            wall_us=lambda: time.time_ns() // 1000 + round(1e6 * self.clock_step), **options,
        )  # fmt: skip

    def start(self) -> None:
        """Record, and let the aircraft send."""
        prepare_flight_folder(self.folder, aircraft="b777", channel_map="b777", source=self.link)
        if self._own is None:
            self.record()
        self.wait(self.is_recording, step=False)
        self.sender.start()

    def begin(self, **options) -> None:
        """Record, follow, and fly until the link is well."""
        self.start()
        self.sessions = [self.follow(**options)]
        self.wait(lambda: self.session.snapshot().link.state == "ok")
        self.fly(self.choose.uniform(0.2, 2.0))

    @property
    def handle(self):
        return find_recorder(self.folder)

    def is_recording(self) -> bool:
        status = None if self.handle is None else self.handle.status()
        return status is not None and status.state == "recording"

    @property
    def session(self) -> Session:
        return self.sessions[0]

    def signal_recorder(self, number: int) -> int:
        pid = self.handle.pid
        os.kill(pid, number)
        return pid

    def step(self) -> None:
        for session in self.sessions:
            session.update()
            for alarm in session.alarm_registry.current_alarms:
                is_false = alarm.key in EQUIPMENT or alarm.key.endswith(":silent")
                known = self.outcome.false if is_false else self.outcome.other
                is_known = any(one.startswith(f"{alarm.key}:") for one in known)
                if alarm.key not in self.expected and not is_known:
                    known.append(f"{alarm.key}: {alarm.message}")
        time.sleep(0.003)

    def fly(self, seconds: float) -> None:
        self.wait(lambda: False, seconds)

    def wait(
        self, condition: Callable, seconds: float = _TIMEOUT, *, step: bool = True, wrong: str = ""
    ) -> float | None:
        """Go on until a condition holds; return after how many seconds.

        None if it never did; that is noted as `wrong`, if given.
        """
        begin = time.monotonic()
        while not condition():
            if time.monotonic() > begin + seconds:
                self.outcome.wrong += [wrong] if wrong else []
                return None
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
        """Return whether there was one of these alarms, be it over again."""
        return any(self.session.alarm_registry.get(key) is not None for key in keys)

    def announce(self, *keys: str) -> None:
        self.expected.update(keys)
        self.outcome.announced = self.wait(lambda: self.is_announced(*keys))

    def is_current(self, session: Session | None = None) -> bool:
        """Return whether the newest sample that was sent is nearly there, and nothing is behind."""
        found = session or self.session
        stamp = None if found.decoder is None else found.decoder.data_stamp
        if stamp is None or found.equipment is None or not found.feed.is_up_to_date:
            return False
        return abs(found.equipment.host_us() - stamp) < 0.15e6

    def recover(self, condition: Callable[[], bool] = lambda: True) -> None:
        """Wait until samples are current again, then until its alarms have ended."""
        self.outcome.recovered = self.wait(
            lambda: condition() and self.is_current(), wrong="never recovered"
        )
        if self.wait(lambda: not self.alarm("link", "recorder", "disk"), 12.0) is None:
            self.outcome.false += [
                f"does not end: {one.key}: {one.message}"
                for one in self.session.alarm_registry.current_alarms
                if one.active and one.key in ("link", "recorder", "disk")
            ]
        self.fly(self.choose.uniform(0.2, 0.6))

    # The account

    def finish(self) -> None:
        """End the flight, and compare the record with what was delivered."""
        for one in (*self.windows, *self.senders):
            one.stop()
        time.sleep(0.1)
        handle = self.handle
        folder = self.folder if handle is None else handle.folder
        if handle is not None and not handle.stop():
            self.outcome.wrong.append("the recorder does not stop")
        if self._own is not None:
            self._own.join(5.0)
        for session in self.sessions:
            session.close()
        sent = [data for sender in self.senders for _, data in sender.delivered]
        self.outcome.sent += sum(map(len, sent))
        kept = [record.data for record in RawTail(folder).poll()]
        whole = b"".join(kept)
        if len(self.senders) == 1 and whole == b"".join(sent):
            return
        there = Counter(kept)
        for data in sent:
            if there[data]:
                there[data] -= 1
            elif data not in whole:
                self.outcome.lost += len(data)

    def excuse(self, begin: float, end: float = math.inf) -> None:
        """Take out of the account what was sent while nothing could receive it."""
        end = min(end, time.monotonic())
        kept = Counter(record.data for record in RawTail(self.handle.folder).poll())
        for sender in self.senders:
            for at, data in [one for one in sender.delivered if begin <= one[0] < end]:
                if not kept[data]:
                    sender.delivered.remove((at, data))
                    self.outcome.missed += len(data)


class Window:
    """The real window off screen, in a process of its own that tells a file how it fares."""

    def __init__(self, run: Run) -> None:
        run.windows.append(self)
        self._run = run
        self._told = run.scratch / f"told-{time.monotonic_ns()}.json"
        self.process = subprocess.Popen(
            [sys.executable, __file__, run.scratch / "settings", run.folder, self._told],
            env={
                **os.environ, "QT_QPA_PLATFORM": "offscreen",
                "PYTHONPATH": os.pathsep.join(path for path in sys.path if path),
            },
            stderr=(run.scratch / "window.log").open("ab"),
        )  # fmt: skip

    def wait(self, seconds: float = _TIMEOUT) -> float | None:
        """Wait until it shows the newest samples."""
        return self._run.wait(
            self._is_current, seconds, step=False, wrong="the window does not show the flight"
        )

    @property
    def alarms(self) -> list[str]:
        return self._state().get("alarms", [])

    def _state(self) -> dict:
        with contextlib.suppress(OSError, ValueError):
            return json.loads(self._told.read_text(encoding="utf-8"))
        return {}

    def _is_current(self) -> bool:
        found = self._state()
        return bool(found) and found["current"] and time.monotonic() - found["at"] < 0.3

    def stop(self) -> None:
        self.process.kill()
        self.process.wait()


def describe(window) -> dict[str, object]:
    session = window.flight_controller.session
    stamp = None if session is None or session.decoder is None else session.decoder.data_stamp
    return {} if stamp is None else {
        "current": session.feed.is_up_to_date and time.time() - stamp / 1e6 < 0.15,
        "alarms": [one.key for one in session.alarm_registry.current_alarms if one.active],
    }  # fmt: skip


if __name__ == "__main__":
    from tests.ui.watched_window import show_window

    show_window(*map(Path, sys.argv[1:]), describe, 50)

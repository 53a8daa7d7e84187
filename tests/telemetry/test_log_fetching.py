"""The on-board log comes over a bad link whole, goes on after a break, and disturbs nobody."""

import random
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gsapp.decoding.dialect import dialect
from gsapp.flight.file_names import SEND_FILE
from gsapp.flight.folder import FlightFolder
from gsapp.flight.raw_files import read_tlog
from gsapp.foundation import LinkError
from gsapp.foundation.file_lock import FileLock
from gsapp.telemetry.log_download import LogEntry, LogFetcher
from gsapp.telemetry.log_download.log_protocol import (
    LOG_DATA_BYTES,
    LogDownloadProtocol,
    MissingRanges,
)
from gsapp.telemetry.recorder_control import find_recorders, start_recorder
from gsapp.telemetry.send_queue import request_send

AUTOPILOT = Path(__file__).with_name("foreign_autopilot.py")
BEGUN = 1_760_000_000
NUMBER = 8


def log_bytes(size: int) -> bytes:
    return b"\xa3\x95" + random.Random(2).randbytes(size - 2)


# --- which bytes are missing ------------------------------------------------------------------


@given(st.lists(st.tuples(st.integers(0, 60), st.integers(0, 25)), max_size=12))
def test_what_came_is_not_missing_any_more(pieces):
    """Whatever comes, in any order and over each other: as a set of bytes would have it."""
    missing, left = MissingRanges(64), set(range(64))
    for start, count in pieces:
        stop = min(start + count, 64)
        came = set(range(start, stop)) & left
        assert missing.is_missing_any(start, stop) == bool(came)
        assert missing.mark_received(start, stop) == len(came)
        left -= came
        found = {byte for a, b in missing.ranges for byte in range(a, b)}
        assert (found, missing.missing_bytes, bool(missing)) == (left, len(left), bool(left))
        again = MissingRanges(64, missing.ranges)
        assert again.ranges == missing.ranges
        wanted = missing.next_range(start, 10, 0)
        if left:
            beyond = {byte for byte in left if byte >= start} or left
            assert wanted[0] == min(beyond)
            assert set(range(*wanted)) <= left
            assert wanted[1] - wanted[0] <= 10
        else:
            assert wanted is None


# --- the conversation, with time at hand --------------------------------------------------------


class Air:
    """A server of logs behind a link that loses and delays, in a time of its own."""

    def __init__(
        self, data: bytes, loss: float, seed: int, rate: float = 20_000.0, delay: float = 0.05
    ) -> None:
        self.data, self.loss, self.luck = data, loss, random.Random(seed)
        self.delay = delay
        self.names = dialect()
        self.packer = self.names.MAVLink(None, srcSystem=3, srcComponent=1)
        self.asked: tuple[int, int] | None = None
        self.due: list[tuple[float, bytes]] = []
        self.per_step = max(round(rate / LOG_DATA_BYTES * 0.02), 1)
        self.sent = 0
        self.armed = False
        self.now = 0.0

    def send(self, message, now: float) -> None:
        frame = bytes(message.pack(self.packer))
        if self.luck.random() >= self.loss:
            self.due.append((now + self.delay, frame))

    def step(self, requests: list[bytes], now: float) -> list[bytes]:
        self.now = now
        mode = 128 if self.armed else 0
        self.send(self.names.MAVLink_heartbeat_message(1, 3, mode, 0, 4, 3), now)
        for frame in requests:
            message = self.names.MAVLink(None).decode(bytearray(frame))
            if self.luck.random() < self.loss:
                continue
            if message.get_type() == "LOG_REQUEST_LIST":
                self.send(self.names.MAVLink_log_entry_message(5, 1, 5, BEGUN, len(self.data)), now)
            elif message.get_type() == "LOG_REQUEST_DATA":
                assert message.id == 5
                self.asked = (message.ofs, min(message.ofs + message.count, len(self.data)))
        for _ in range(self.per_step):
            if self.asked is None:
                break
            start, stop = self.asked
            piece = self.data[start : min(start + LOG_DATA_BYTES, stop)]
            self.send(
                self.names.MAVLink_log_data_message(
                    5, start, len(piece), piece.ljust(LOG_DATA_BYTES, b"\0")
                ),
                now,
            )
            self.sent += len(piece)
            self.asked = (start + LOG_DATA_BYTES, stop) if start + LOG_DATA_BYTES < stop else None
        come = [frame for due, frame in self.due if due <= now]
        self.due = [(due, frame) for due, frame in self.due if due > now]
        return come


def converse(
    air: Air, kept: bytearray, limit: float = 600.0, missing: MissingRanges | None = None
) -> LogDownloadProtocol:
    def keep(offset: int, data: bytes) -> None:
        kept[offset : offset + len(data)] = data

    talk, now, requests = LogDownloadProtocol(keep), 0.0, []
    while talk.phase not in ("done", "failed") and now < limit:
        for frame in air.step(requests, now):
            talk.receive_frame(frame, now)
        if talk.phase == "listed":
            talk.fetch(talk.entries[5], missing or MissingRanges(talk.entries[5].size))
        requests = talk.pending_requests(now)
        now += 0.02
    return talk


@settings(max_examples=10, deadline=None)
@given(size=st.integers(1, 30_000), loss=st.floats(0.0, 0.3), seed=st.integers(0, 10_000))
def test_every_byte_comes_however_much_is_lost(size, loss, seed):
    data = random.Random(seed).randbytes(size)
    kept = bytearray(size)
    air = Air(data, loss, seed)
    talk = converse(air, kept)
    assert talk.phase == "done", talk.state(0.0)
    assert bytes(kept) == data


def test_little_is_sent_twice():
    size = 150_000
    air = Air(random.Random(1).randbytes(size), 0.02, 4)
    talk = converse(air, bytearray(size), limit=2.0 * size / 20_000.0 + 5.0)
    assert talk.phase == "done"
    assert air.sent < 1.5 * size


@pytest.mark.parametrize(("rate", "delay"), [(100_000.0, 0.05), (20_000.0, 0.6)])
def test_what_was_lost_is_fetched_in_no_more_time_than_all(rate, delay):
    data = bytes(200_000)
    lost = MissingRanges(
        len(data), [(at, at + LOG_DATA_BYTES) for at in range(0, len(data), 20 * LOG_DATA_BYTES)]
    )
    took = []
    for missing in (None, lost):
        air = Air(data, 0.0, 4, rate, delay)
        assert converse(air, bytearray(len(data)), missing=missing).phase == "done"
        took.append(air.now)
    assert took[1] <= took[0] + 2.0 * delay


def test_a_link_that_dies_and_an_armed_aircraft_are_told():
    silent = converse(Air(b"x" * 500, 1.0, 1), bytearray(500))
    assert silent.phase == "failed"
    assert "log list request" in silent.state(0.0).why
    air = Air(b"x" * 50_000, 0.0, 1)
    talk = LogDownloadProtocol(lambda _, __: None)
    talk.fetch(LogEntry(id=5, size=50_000, time_utc=0), MissingRanges(50_000))
    now, requests = 0.0, talk.pending_requests(0.0)
    while talk.phase == "fetching" and now < 60.0:
        if now < 1.0:
            for frame in air.step(requests, now):
                talk.receive_frame(frame, now)
        requests = talk.pending_requests(now)
        now += 0.02
    assert "resumes" in talk.state(now).why
    assert 0 < talk.state(now).received_bytes < 50_000
    armed = Air(b"x" * 500, 0.0, 1)
    armed.armed = True
    assert "disarm" in converse(armed, bytearray(500)).state(0.0).why


# --- over a real socket, with a foreign peer -----------------------------------------------------


class Autopilot:
    """The foreign autopilot in a process of its own."""

    def __init__(self, port: int, folder: Path, data: bytes, loss: float) -> None:
        self.log = folder / "served.bin"
        self.log.write_bytes(data)
        self.heard_file = folder / "heard.txt"
        self._command = [
            sys.executable, str(AUTOPILOT), str(port), str(self.log), str(self.heard_file),
            str(loss),
        ]  # fmt: skip
        self.start()

    def start(self, at_once: int = 8) -> None:
        self.process = subprocess.Popen([*self._command, str(at_once)])

    def kill(self) -> None:
        self.process.kill()
        self.process.wait()

    def heard(self) -> set[str]:
        return set(self.heard_file.read_text().split()) if self.heard_file.exists() else set()


@pytest.fixture
def autopilot(port, tmp_path):
    number = port(socket.SOCK_DGRAM)
    made = Autopilot(number, tmp_path, log_bytes(200_000), loss=0.05)
    made.link = f"udpin:127.0.0.1:{number}"
    yield made
    made.kill()


@pytest.mark.usefixtures("own_runtime")
def test_a_log_is_fetched_while_the_recorder_owns_the_link(autopilot, tmp_path, patience):
    """Through the recorder at work: whole, although 5 % are lost; cancelled once, gone on with.

    The recorder goes on recording. It passes on what asks for logs and nothing else.
    """
    folder = FlightFolder.create(tmp_path / "flight")
    recorder = start_recorder(autopilot.link, folder.path)
    try:
        names = dialect()
        for message in (
            names.MAVLink_log_erase_message(3, 1),
            names.MAVLink_command_long_message(3, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0),
        ):
            request_send(folder.path, bytes(message.pack(names.MAVLink(None, srcSystem=255))))
        patience(folder.tlog_file.exists)
        passing = {SEND_FILE, "cache"}
        before = {path.name for path in folder.path.iterdir()} - passing
        stop = threading.Event()
        seen = []

        def tell(state) -> None:
            seen.append(state)
            if state.received_bytes > 50_000:
                stop.set()

        with LogFetcher(folder.path, stop=stop, tell=tell) as fetcher:
            assert [entry.id for entry in fetcher.list_logs()] == [7, NUMBER]
            entry = fetcher.select(NUMBER)
            assert fetcher.fetch(entry) is None
        got = seen[-1].received_bytes
        assert 50_000 < got < 200_000
        assert any(state.rate > 0.0 and state.seconds_left for state in seen)
        assert {path.name for path in folder.path.iterdir()} - passing == before

        later = []
        with LogFetcher(folder.path, tell=later.append) as fetcher:
            fetched = fetcher.fetch(fetcher.select())  # the one begun nearest the flight
        assert next(state.received_bytes for state in later if state.size) >= got
        assert fetched.entry.id == NUMBER
        assert fetched.start_time.timestamp() == BEGUN
        assert fetched.path.suffix == ".bin"
        assert fetched.path.read_bytes() == autopilot.log.read_bytes()
        assert recorder.is_alive()
        assert autopilot.heard() == {
            "LOG_REQUEST_LIST", "LOG_REQUEST_DATA", "LOG_REQUEST_END",
        }  # fmt: skip
    finally:
        recorder.stop()
    assert not (folder.path / SEND_FILE).exists()
    assert sum(1 for _ in read_tlog(folder.tlog_file)) > 200_000 / LOG_DATA_BYTES


@pytest.mark.skipif(sys.platform != "linux", reason="needs a second address of this computer")
@pytest.mark.usefixtures("own_runtime")
def test_a_stranger_puts_no_byte_into_a_log(autopilot, tmp_path, patience):
    """It answers every request as the autopilot does, with bytes of its own."""
    folder = FlightFolder.create(tmp_path / "flight")
    recorder = start_recorder(autopilot.link, folder.path)
    over = threading.Event()
    names = dialect()
    packer = names.MAVLink(None, srcSystem=3, srcComponent=1)
    port = int(autopilot.link.rpartition(":")[2])

    def forge() -> None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
            stranger.bind(("127.0.0.2", 0))
            offset = 0
            while not over.wait(0.001):
                for message in (
                    names.MAVLink_log_entry_message(NUMBER, 2, NUMBER, BEGUN, 200_000),
                    names.MAVLink_log_data_message(NUMBER, offset, LOG_DATA_BYTES, b"\xff" * 90),
                ):
                    stranger.sendto(bytes(message.pack(packer)), ("127.0.0.1", port))
                offset = (offset + LOG_DATA_BYTES) % 200_000

    patience(lambda: folder.tlog_file.exists() and folder.tlog_file.stat().st_size > 100)
    forger = threading.Thread(target=forge)
    forger.start()
    try:
        with LogFetcher(folder.path) as fetcher:
            fetched = fetcher.fetch(fetcher.select(NUMBER))
        assert fetched.path.read_bytes() == autopilot.log.read_bytes()
    finally:
        over.set()
        forger.join()
        recorder.stop()


@pytest.mark.long
@pytest.mark.usefixtures("own_runtime")
def test_a_killed_fetch_goes_on_and_leaves_no_recorder(autopilot, tmp_path, patience):
    """Both sides killed in the midst; the next one asks for the rest, and takes all away."""
    folder = FlightFolder.create(tmp_path / "flight")
    # So slow that the first note of what came, after two seconds, is not the last.
    autopilot.kill()
    autopilot.start(at_once=1)
    code = (
        "import sys; from gsapp.telemetry.log_download import LogFetcher\n"
        "with LogFetcher(sys.argv[1], sys.argv[2]) as fetcher:\n"
        f"    fetcher.fetch(fetcher.select({NUMBER}))\n"
    )
    child = subprocess.Popen([sys.executable, "-c", code, str(folder.path), autopilot.link])
    scratch = folder.cache_folder / "download"
    note = scratch / f"onboard-{NUMBER}.json"
    assert patience(note.exists, 60.0)
    child.kill()
    child.wait()
    autopilot.kill()
    assert [handle.folder.parent for handle in find_recorders()] == [scratch]
    autopilot.start()
    told = []
    with LogFetcher(folder.path, autopilot.link, tell=told.append) as fetcher:
        with pytest.raises(LinkError, match="being fetched"):
            LogFetcher(folder.path, autopilot.link)
        fetched = fetcher.fetch(fetcher.select(NUMBER))
    assert next(state.received_bytes for state in told if state.size) > 0
    assert fetched.path.read_bytes() == autopilot.log.read_bytes()
    assert patience(lambda: not find_recorders())
    assert sorted(path.name for path in scratch.iterdir()) == ["lock", fetched.path.name]
    assert sorted(path.name for path in folder.path.iterdir()) == ["cache", "flight.toml"]


@pytest.mark.usefixtures("own_runtime")
def test_a_recorder_made_for_a_fetch_ends_with_it(port, tmp_path, patience):
    """While the lock is held it records; once nobody holds it, the link is given back."""
    lock = FileLock(tmp_path / "lock")
    assert lock.acquire()
    number = port(socket.SOCK_DGRAM)
    link = f"udpin:127.0.0.1:{number}"
    recorder = start_recorder(link, tmp_path / "line", while_held=lock.path)
    time.sleep(2.5)
    assert recorder.is_alive()
    lock.release()
    assert patience(lambda: not recorder.is_alive())
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", number))

"""The recorder: nothing that arrived is lost, whoever is frozen or killed above or beside it."""

import errno
import os
import random
import signal
import socket
import subprocess
import sys
import textwrap
import threading
import time
from collections import Counter, deque
from dataclasses import replace
from pathlib import Path

import pytest

from gsapp.decoding.dialect import dialect
from gsapp.decoding.framing import Framer, LineFramer
from gsapp.flight.file_names import LOCK_FILE, STATUS_FILE, STOP_FILE
from gsapp.flight.raw_files import FRAMES_FILE, LINES_FILE, RawTail, RawWriter
from gsapp.foundation import FlightError, GroundStationError, LinkError
from gsapp.foundation.file_lock import FileLock, lock_holder
from gsapp.telemetry import recorder_control
from gsapp.telemetry.clock import HostClock
from gsapp.telemetry.link_kinds import LinkAddress
from gsapp.telemetry.link_registry import parse_link
from gsapp.telemetry.recorder import PeerStream, Recorder
from gsapp.telemetry.recorder_control import (
    find_recorder,
    find_recorders,
    restart_recorder,
    start_recorder,
)
from gsapp.telemetry.recorder_process import record_link
from gsapp.telemetry.recorder_status import (
    RUNTIME_VARIABLE,
    RecorderStatus,
    read_status,
    write_status,
)
from gsapp.telemetry.send_queue import request_send
from gsapp.telemetry.settings import TELEMETRY
from gsapp.telemetry.sources import Chunk, LinkSource

pytestmark = pytest.mark.usefixtures("own_runtime")

# Windows has no SIGKILL; there SIGTERM leaves a process no time either.
KILL = getattr(signal, "SIGKILL", signal.SIGTERM)


class Script(LinkSource):
    """A source that plays what a test hands it."""

    def __init__(self, chunks=(), framing="mavlink") -> None:
        super().__init__(LinkAddress(kind="virtual"), clock=HostClock())
        self.framing = framing
        self.chunks: deque[Chunk] = deque(chunks)
        self.written: list[bytes] = []
        self.connected = True

    def open(self) -> None: ...

    def read(self, timeout: float) -> list[Chunk]:
        if self.chunks:
            return [self.chunks.popleft()]
        time.sleep(min(timeout, 0.01))
        return []

    def write(self, data: bytes) -> None:
        self.written.append(data)

    def close(self) -> None:
        self.connected = False


class Running:
    """A recorder in a thread of this process."""

    def __init__(self, source: LinkSource, folder: Path, **options) -> None:
        writer = options.pop("writer", None) or RawWriter(folder)
        self.recorder = Recorder(source, writer, clock=HostClock(), **options)
        self.stop = threading.Event()
        self.thread = threading.Thread(target=self.recorder.run, args=(self.stop,))

    def __enter__(self) -> Recorder:
        self.thread.start()
        return self.recorder

    def __exit__(self, *_: object) -> None:
        self.stop.set()
        self.thread.join(10)
        assert not self.thread.is_alive()


def stamped(sent: list[bytes]) -> list[Chunk]:
    return [Chunk(1_000_000 + index, frame) for index, frame in enumerate(sent)]


class FullDisk(threading.Event):
    """Takes nothing while it is set."""

    def __init__(self) -> None:
        super().__init__()
        self.set()

    def write(self, descriptor: int, data: bytes) -> int:
        if self.is_set():
            raise OSError(errno.ENOSPC, "No space left on device")
        return os.write(descriptor, data)


def data_of(folder: Path) -> list[bytes]:
    return [item.data for item in RawTail(folder).poll()]


def test_frames_are_in_the_file_at_once_not_when_it_ends(tmp_path, frames, patience) -> None:
    sent = frames(50)
    clock = HostClock()
    source = Script(Chunk(clock.now_us(), frame) for frame in sent)
    with Running(source, tmp_path):
        patience(lambda: data_of(tmp_path) == sent)


def test_text_goes_to_its_own_file(tmp_path, patience) -> None:
    source = Script(
        [Chunk(1_000_000, b"1,2\r\n3,4\r\nhal"), Chunk(1_000_001, b"f\r\n\xff\n")], "text"
    )
    with Running(source, tmp_path):
        patience(lambda: len(data_of(tmp_path)) == 4)
    assert (tmp_path / LINES_FILE).read_bytes() == b"1000000\t1,2\n1000000\t3,4\n1000001\thalf\n"


def test_stray_bytes_are_kept_with_their_place(tmp_path, frames, patience) -> None:
    one, two = frames(2)
    source = Script([Chunk(1_000_000, one + b"stray" + two[:-3]), Chunk(1_000_001, two[-3:])])
    with Running(source, tmp_path):
        patience(lambda: len(data_of(tmp_path)) == 3)
    assert data_of(tmp_path) == [one, b"stray", two]
    residue = (tmp_path / "residue.bin").read_bytes()
    assert int.from_bytes(residue[8:16], "big") == len(one)


def test_peers_that_speak_by_turns_are_framed_apart(tmp_path, frames, patience) -> None:
    first, second = frames(30, seed=1), frames(30, seed=2, system=2)
    streams = {"a": b"".join(first), "b": b"".join(second)}
    chunks, stamp = [], 1_000_000
    while any(streams.values()):
        for peer, size in (("a", 17), ("b", 23)):
            piece, streams[peer] = streams[peer][:size], streams[peer][size:]
            stamp += 1
            if piece:
                chunks.append(Chunk(stamp, piece, peer))
    with Running(Script(chunks), tmp_path):
        patience(lambda: len(data_of(tmp_path)) == 60)
    assert sorted(data_of(tmp_path)) == sorted(first + second)


def test_residue_of_several_peers_lies_where_it_came(frames) -> None:
    stream, other = PeerStream(Framer()), PeerStream(LineFramer())
    frame = frames(1)[0]
    assert other.feed(b"xxxx", 0) == []
    items = stream.feed(frame[:10], 4)
    items += stream.feed(frame[10:15] + b"noise", 100)  # torn off, then noise
    items += stream.flush()
    assert [(item.offset, item.data) for item in items] == [
        (4, frame[:10]),
        (100, frame[10:15] + b"noise"),
    ]


def test_the_end_of_a_peer_settles_its_stream(tmp_path, frames, patience) -> None:
    one, two = frames(2)
    chunks = [Chunk(1_000_000, one[:-4]), Chunk(1_000_001, b""), Chunk(1_000_002, two)]
    with Running(Script(chunks), tmp_path):
        patience(lambda: len(data_of(tmp_path)) == 2)
    assert data_of(tmp_path) == [one[:-4], two]


def test_in_a_pause_what_is_whole_is_in_the_file(tmp_path, frames, patience) -> None:
    (frame,) = frames(1)
    head = bytes((0xFD, 250, 0, 0, 1, 1, 1)) + (30).to_bytes(3, "little")
    with Running(Script([Chunk(1_000_000, head + frame)]), tmp_path):
        patience(lambda: data_of(tmp_path) == [head, frame])


def test_stamps_of_batches_rise(tmp_path, frames, patience) -> None:
    same = [Chunk(1_000_000, frame) for frame in frames(20)]
    with Running(Script(same), tmp_path):
        patience(lambda: len(data_of(tmp_path)) == 20)
    stamps = [item.stamp_us for item in RawTail(tmp_path).poll()]
    assert stamps == sorted(set(stamps))


def test_who_sees_the_state_in_the_folder_finds_the_recorder(tmp_path, patience) -> None:
    before: list[bool] = []
    file = tmp_path / STATUS_FILE
    with Running(Script(), tmp_path, on_status=lambda _: before.append(file.exists())):
        patience(file.exists)
    assert before[0] is False


def test_the_sign_of_life_is_sent_when_asked_for(tmp_path, patience) -> None:
    source, silent = Script(), Script()
    begun = time.monotonic()
    with (
        Running(source, tmp_path / "asked", heartbeat=True),
        Running(silent, tmp_path / "not-asked"),
    ):
        patience(lambda: source.written)
        time.sleep(0.3)
    (item,) = Framer().feed(source.written[0])[:1]
    assert (item.message_id, item.system, item.component) == (0, 255, 190)
    assert len(source.written) <= 1 + int(time.monotonic() - begun)
    assert silent.written == []


def test_a_fault_of_a_driver_does_not_end_the_record(tmp_path, frames, patience) -> None:
    class Faulty(Script):
        faults = 1

        def read(self, timeout: float) -> list[Chunk]:
            if self.faults:
                self.faults -= 1
                raise RuntimeError("driver fault")
            return super().read(timeout)

    def tell(_: RecorderStatus) -> None:
        raise ValueError("nobody listens")

    sent = frames(5)
    source = Faulty(stamped(sent))
    with Running(source, tmp_path, on_status=tell):
        patience(lambda: data_of(tmp_path) == sent)


def test_a_fault_in_sending_does_not_end_the_record(tmp_path, frames, patience) -> None:
    class Faulty(Script):
        def write(self, _data: bytes) -> None:
            raise TypeError("the port was closed meanwhile")

    told: list[RecorderStatus] = []
    sent = frames(5)
    source = Faulty()
    with Running(source, tmp_path, heartbeat=True, on_status=told.append):
        patience(lambda: told and "cannot send (the port was closed" in told[-1].source_state)
        source.chunks.extend(stamped(sent))
        patience(lambda: data_of(tmp_path) == sent)


def test_an_output_that_is_blocked_does_not_hold_up_the_record(tmp_path, frames, patience) -> None:
    class Blocked(Script):
        let_go = threading.Event()

        def write(self, data: bytes) -> None:
            self.let_go.wait(60.0)
            super().write(data)

    request = dialect().MAVLink_log_request_data_message(1, 1, 1, 0, 90)
    sent = frames(5)
    source = Blocked()
    with Running(source, tmp_path, heartbeat=True):
        patience((tmp_path / STATUS_FILE).exists)
        for _ in range(2 * TELEMETRY.max_unsent):
            request_send(tmp_path, bytes(request.pack(dialect().MAVLink(None, srcSystem=255))))
        source.chunks.extend(stamped(sent))
        patience(lambda: data_of(tmp_path) == sent)
        assert source.written == []
        time.sleep(0.2)
        source.let_go.set()
        patience(lambda: len(source.written) > 20)
    assert (
        len(source.written) <= TELEMETRY.max_unsent + 3
    )  # the first is being sent, and the heartbeats


def test_a_clock_that_was_set_back_is_told_in_the_status(tmp_path, patience) -> None:
    set_back = [0]
    clock = HostClock(wall_us=lambda: time.time_ns() // 1000 - set_back[0])
    told: list[RecorderStatus] = []
    recorder = Recorder(Script(), RawWriter(tmp_path), clock=clock, on_status=told.append)
    stop = threading.Event()
    thread = threading.Thread(target=recorder.run, args=(stop,))
    thread.start()
    patience(lambda: told)
    assert told[-1].ahead_us == 0
    set_back[0] = 30_000_000
    patience(lambda: told[-1].ahead_us > 29_000_000)
    stop.set()
    thread.join(10)
    stamps = [status.updated_us for status in told]
    assert stamps == sorted(stamps)
    assert abs(stamps[-1] - time.time_ns() // 1000) < 1_000_000


def test_a_full_disk_is_announced_long_before(tmp_path, frames, patience) -> None:
    room = 50_000_000
    told: list[RecorderStatus] = []
    source = Script(stamped(frames(100)))
    with Running(source, tmp_path, disk_free=lambda _: room, on_status=told.append):
        patience(lambda: told and told[-1].seconds_until_full)
    assert told[-1].disk_free_bytes == room
    assert told[-1].seconds_until_full == pytest.approx(room / told[-1].byte_rate)
    assert "50 MB left" in told[-1].warnings[0]
    with Running(Script(), tmp_path / "roomy", disk_free=lambda _: 10**12, on_status=told.append):
        patience(lambda: told[-1].disk_free_bytes == 10**12)
    assert told[-1].warnings == []


def test_a_full_disk_does_not_end_the_record(tmp_path, frames, patience) -> None:
    full = FullDisk()
    told: list[RecorderStatus] = []
    sent = frames(100)
    source = Script(stamped(sent))
    writer = RawWriter(tmp_path, write=full.write)
    with Running(source, tmp_path, writer=writer, on_status=told.append):
        patience(lambda: told and told[-1].waiting_bytes > 100)
        assert "disk" in told[-1].error
        full.clear()
        patience(lambda: data_of(tmp_path) == sent)
        patience(lambda: not told[-1].error)
    assert data_of(tmp_path) == sent


def test_a_disk_that_fails_to_flush_is_told_without_a_break(
    tmp_path, frames, patience, monkeypatch
) -> None:
    def broken(_: int) -> None:
        raise OSError(errno.EIO, "Input/output error")

    monkeypatch.setattr(os, "fsync", broken)
    told: list[RecorderStatus] = []
    source = Script()
    sent = frames(60)
    with Running(source, tmp_path, on_status=told.append):
        for index, frame in enumerate(sent):
            source.chunks.append(Chunk(1_000_000 + index, frame))
            time.sleep(0.05)
    first = next(n for n, status in enumerate(told) if status.error)
    assert len(told) - first >= 3
    assert len({status.error for status in told[first:]}) == 1
    assert all(status.unconfirmed for status in told[first:])
    assert told[-1].waiting_bytes == 0
    assert data_of(tmp_path) == sent


def test_a_record_that_ends_on_a_full_disk_waits_for_room(tmp_path, frames, patience) -> None:
    full = FullDisk()

    def ended(folder: Path, remedy) -> Recorder:
        told: list[RecorderStatus] = []
        source = Script(stamped(sent))
        writer = RawWriter(folder, write=full.write)
        recorder = Recorder(source, writer, clock=HostClock(), on_status=told.append)
        stop, give_up = threading.Event(), threading.Event()
        thread = threading.Thread(target=recorder.run, args=(stop, give_up))
        thread.start()
        patience(lambda: writer.state.frames == len(sent))
        stop.set()
        patience(lambda: told and "are unwritten" in told[-1].error)
        assert thread.is_alive()
        remedy(give_up)
        thread.join(10)
        assert not thread.is_alive()
        return recorder

    sent = frames(100)
    status = ended(tmp_path / "given up", lambda give_up: give_up.set()).status("stopped")
    assert status.unwritten_frames == status.frames == 100
    assert status.dropped_bytes > 1000
    assert "100 records" in status.error
    assert "oldest" not in status.error
    again = tmp_path / "asked again"
    assert ended(again, lambda _: (again / STOP_FILE).touch()).writer.state.lost_records == 100
    status = ended(tmp_path / "room", lambda _: full.clear()).status("stopped")
    assert (status.dropped_bytes, status.unwritten_frames, status.error) == (0, 0, "")
    assert data_of(tmp_path / "room") == sent


def test_a_full_disk_takes_the_last_status(tmp_path: Path, monkeypatch) -> None:
    def told(state) -> RecorderStatus:
        return RecorderStatus(
            pid=1, link="", folder="", state=state, started_us=1, updated_us=2, error="12" * 9
        )

    path = tmp_path / STATUS_FILE
    assert write_status(path, told("recording"))

    def refuse(_path: Path, _content: bytes) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", refuse)
    assert write_status(path, told("stopped").model_copy(update={"error": ""}))
    assert read_status(path).state == "stopped"
    assert not write_status(tmp_path / "other.json", told("stopped"))


@pytest.mark.parametrize("fault", [SystemExit(1), BrokenPipeError(32, "Broken pipe")])
def test_a_record_is_kept_though_nobody_hears_of_it(tmp_path, frames, patience, fault) -> None:
    def deaf(_status: RecorderStatus) -> None:
        raise fault

    source = Script()
    with Running(source, tmp_path, on_status=deaf) as recorder:
        patience(lambda: read_status(tmp_path / STATUS_FILE))
        source.chunks.extend(Chunk(1_000_000 + n, one) for n, one in enumerate(frames(9)))
        patience(lambda: read_status(tmp_path / STATUS_FILE).frames == 9)
        patience(lambda: not any(recorder.writer._unsynced.values()))


@pytest.mark.skipif(sys.platform == "win32", reason="no limit on the size of files there")
def test_a_disk_that_really_takes_no_more(tmp_path, frames) -> None:
    code = textwrap.dedent(
        """
        import resource, sys
        from gsapp.decoding.framing import Framer
        from gsapp.flight.raw_files import RawWriter
        writer = RawWriter(sys.argv[1])
        framer = Framer()
        soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, hard))
        stream = sys.stdin.buffer.read()
        for number in range(0, len(stream), 50):
            writer.append(1_000_000 + number, framer.feed(stream[number : number + 50]))
        assert writer.state.waiting_bytes > 0 and writer.state.error, writer.state
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        assert writer.retry()
        writer.append(2_000_000, framer.flush())
        writer.close()
        """
    )
    sent = frames(100)
    command = [sys.executable, "-c", code, str(tmp_path)]
    subprocess.run(command, input=b"".join(sent), check=True)
    assert data_of(tmp_path) == sent


def udp_link(port) -> tuple[str, socket.socket, tuple[str, int]]:
    number = port(socket.SOCK_DGRAM)
    sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    return f"udpin:127.0.0.1:{number}", sender, ("127.0.0.1", number)


@pytest.fixture
def recorders(own_runtime):
    yield
    for handle in find_recorders():
        handle.stop(5.0)


@pytest.mark.usefixtures("recorders")
def test_a_recorder_is_started_found_and_stopped(tmp_path, frames, port, patience) -> None:
    link, sender, target = udp_link(port)
    folder = tmp_path / "flight"
    handle = start_recorder(link, folder)
    assert handle.is_alive()
    assert handle.pid != os.getpid()
    assert find_recorder(folder) == handle
    assert find_recorders() == [handle]
    assert read_status(folder / STATUS_FILE).pid == handle.pid
    sent = frames(200)
    tails = [RawTail(folder) for _ in range(3)]
    seen: list[list[bytes]] = [[] for _ in tails]
    for index, frame in enumerate(sent):
        sender.sendto(frame, target)
        if index % 20 == 0:
            time.sleep(0.005)
            for tail, mine in zip(tails[:2], seen[:2], strict=True):  # the third one is frozen
                mine += [item.data for item in tail.poll()]

    def all_seen() -> bool:
        for tail, mine in zip(tails, seen, strict=True):
            mine += [item.data for item in tail.poll()]
        return all(len(mine) == 200 for mine in seen)

    patience(all_seen)
    assert seen == [sent] * 3
    status = patience(lambda: (s := handle.status()) and s.frames == 200 and s)
    assert status.received_bytes == sum(map(len, sent))
    assert status.residue_bytes == 0
    assert status.disk_free_bytes > 0
    assert "receiving from 127.0.0.1" in status.source_state
    assert handle.stop()
    assert not handle.is_alive()
    assert find_recorder(folder) is None
    assert find_recorders() == []
    assert read_status(folder / STATUS_FILE).state == "stopped"
    assert not (folder / STOP_FILE).exists()


@pytest.mark.usefixtures("recorders")
def test_pymavlink_is_sender_and_reader(tmp_path, port, patience) -> None:
    from pymavlink import mavutil

    link = f"tcpin:127.0.0.1:{port(socket.SOCK_STREAM)}"
    handle = start_recorder(link, tmp_path / "flight")
    vehicle = mavutil.mavlink_connection(link.replace("tcpin", "tcp"), source_system=1)
    for number in range(100):
        vehicle.mav.attitude_send(number, 0.1, 0.2, 0.3, 0.0, 0.0, 0.0)
    patience(lambda: len(data_of(tmp_path / "flight")) == 100)
    vehicle.close()
    handle.stop()
    log = mavutil.mavlink_connection(str(tmp_path / "flight" / FRAMES_FILE))
    times = []
    while (message := log.recv_msg()) is not None:
        times.append(message.time_boot_ms)
    log.close()
    assert times == list(range(100))


@pytest.mark.usefixtures("recorders")
def test_a_second_recorder_is_refused(tmp_path, port) -> None:
    link, _, _ = udp_link(port)
    other, _, _ = udp_link(port)
    handle = start_recorder(link, tmp_path)
    with pytest.raises(LinkError, match=f"process {handle.pid}"):
        start_recorder(other, tmp_path)
    with pytest.raises(FlightError, match="already being recorded"):
        record_link(other, tmp_path)
    assert handle.is_alive()


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="stands for the launchers there elsewhere")
@pytest.mark.usefixtures("recorders")
def test_a_recorder_behind_a_launcher_is_told_from_another(tmp_path, port, monkeypatch) -> None:
    launcher = tmp_path / "python"
    launcher.write_text(f'#!/bin/sh\n"{sys.executable}" "$@"\nexit $?\n')
    launcher.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(launcher))
    (link, _, _), (other, _, _) = udp_link(port), udp_link(port)
    folder = tmp_path / "flight"
    handle = start_recorder(link, folder)
    assert handle.pid == read_status(folder / STATUS_FILE).pid
    assert handle.status().parent not in (0, os.getpid())
    with pytest.raises(LinkError, match=f"process {handle.pid}"):
        start_recorder(other, folder)
    assert handle.stop()


@pytest.mark.usefixtures("recorders")
def test_what_cannot_begin_says_why(tmp_path, port) -> None:
    link, _, target = udp_link(port)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(target)
        with pytest.raises(LinkError, match="in use"):
            start_recorder(link, tmp_path / "flight")
    with pytest.raises(LinkError, match="the port is missing"):
        start_recorder("udpin:here", tmp_path / "flight")
    (tmp_path / "file").write_text("")
    with pytest.raises(GroundStationError, match="choose another folder"):
        start_recorder(link, tmp_path / "file" / "flight")


@pytest.mark.usefixtures("own_runtime")
def test_what_takes_too_long_to_begin_is_ended_and_says_what_to_do(
    tmp_path, port, monkeypatch
) -> None:
    monkeypatch.setattr(recorder_control, "TELEMETRY", replace(TELEMETRY, start_timeout=0.01))
    with pytest.raises(LinkError, match=r"recorder\.log"):
        start_recorder(udp_link(port)[0], tmp_path)
    assert find_recorder(tmp_path) is None


@pytest.mark.usefixtures("recorders")
def test_a_port_that_is_recorded_already_names_the_flight(tmp_path, port) -> None:
    link, _, _ = udp_link(port)
    former = start_recorder(link, tmp_path / "flight 1")
    with pytest.raises(LinkError) as refused:
        start_recorder(link, tmp_path / "flight 2")
    assert f"already recorded into {tmp_path / 'flight 1'}" in str(refused.value)
    assert former.is_alive()


@pytest.mark.usefixtures("recorders")
def test_a_link_that_is_not_there_yet_is_waited_for(tmp_path, frames, port, patience) -> None:
    number = port(socket.SOCK_STREAM)
    handle = start_recorder(f"tcp:127.0.0.1:{number}", tmp_path)
    assert "refuses the connection" in handle.status().source_state
    sent = frames(20)
    with socket.create_server(("127.0.0.1", number)) as listener:
        vehicle, _ = listener.accept()
        vehicle.sendall(b"".join(sent))
        patience(lambda: data_of(tmp_path) == sent)
        vehicle.close()


@pytest.mark.usefixtures("recorders")
def test_killing_the_window_loses_no_byte(tmp_path, frames, port, patience) -> None:
    """The process that started the recorder is killed in full flow; another finds it again."""
    link, sender, target = udp_link(port)
    folder = tmp_path / "flight"
    code = textwrap.dedent(
        """
        import sys, time
        from gsapp.flight.raw_files import RawTail
        from gsapp.telemetry.recorder_control import start_recorder
        start_recorder(sys.argv[1], sys.argv[2])
        print("recording", flush=True)
        tail = RawTail(sys.argv[2])
        while True:
            tail.poll()
            time.sleep(0.01)
        """
    )
    window = subprocess.Popen(
        [sys.executable, "-c", code, link, str(folder)], stdout=subprocess.PIPE
    )
    assert window.stdout.readline().strip() == b"recording"
    sent = frames(600)
    for index, frame in enumerate(sent):
        sender.sendto(frame, target)
        if index == 300:
            window.kill()
            window.wait()
        if index % 10 == 0:
            time.sleep(0.002)
    patience(lambda: len(data_of(folder)) == 600)
    assert data_of(folder) == sent
    (handle,) = find_recorders()
    assert handle.folder == folder
    assert handle.stop()


@pytest.mark.usefixtures("recorders")
def test_killing_the_recorder_loses_only_what_came_afterwards(
    tmp_path, frames, port, patience
) -> None:
    link, sender, target = udp_link(port)
    handle = start_recorder(link, tmp_path)
    sent = frames(400)
    tail, seen = RawTail(tmp_path), []

    def send(part: list[bytes]) -> None:
        for index, frame in enumerate(part):
            sender.sendto(frame, target)
            if index % 10 == 0:
                time.sleep(0.002)

    send(sent[:200])
    patience(lambda: seen.extend(item.data for item in tail.poll()) or len(seen) == 200)
    os.kill(handle.pid, KILL)
    patience(lambda: not handle.is_alive())
    assert find_recorder(tmp_path) is None
    assert find_recorders() == []
    with (tmp_path / FRAMES_FILE).open("ab") as file:  # as if killed in the middle of a record
        file.write(b"\0\0\1\x8b" + b"\xfd" * 3)
    again = start_recorder(link, tmp_path)
    assert again.pid != handle.pid
    assert "7 bytes" in again.status().notes[0]
    send(sent[200:])
    patience(lambda: seen.extend(item.data for item in tail.poll()) or len(seen) == 400)
    assert seen == sent  # the same tail, across the change of recorders
    assert tail.damage == ()
    stamps = [item.stamp_us for item in RawTail(tmp_path).poll()]
    assert stamps == sorted(stamps)


@pytest.mark.skipif(sys.platform == "win32", reason="no pseudo-terminals on Windows")
def test_a_serial_port_that_vanishes_and_returns(tmp_path, frames, patience) -> None:
    """A pseudo-terminal is unplugged in the middle of a frame, and comes back."""
    device = tmp_path / "ttyGround"

    def plug() -> int:
        master, slave = os.openpty()
        device.unlink(missing_ok=True)
        device.symlink_to(os.ttyname(slave))
        os.close(slave)
        return master

    master = plug()
    stop, told = threading.Event(), []
    thread = threading.Thread(
        target=record_link,
        args=(parse_link(f"serial:{device}:57600"), tmp_path / "flight"),
        kwargs={"stop": stop, "on_status": told.append},
    )
    thread.start()
    sent = frames(60)
    patience(lambda: told and told[-1].connected)
    os.write(master, b"".join(sent[:30]) + sent[30][:9])
    patience(lambda: len(data_of(tmp_path / "flight")) == 30)
    os.close(master)
    device.unlink()
    patience(lambda: not told[-1].connected)
    master = plug()
    patience(lambda: told[-1].connected)
    os.write(master, b"".join(sent[31:]))
    patience(lambda: len(data_of(tmp_path / "flight")) == 60)
    stop.set()
    thread.join(10)
    os.close(master)
    assert data_of(tmp_path / "flight") == [*sent[:30], sent[30][:9], *sent[31:]]


def test_a_recycled_process_id_does_not_pass_for_a_recorder(tmp_path: Path) -> None:
    (tmp_path / LOCK_FILE).write_text(str(os.getpid()))
    assert lock_holder(tmp_path / LOCK_FILE) is None
    assert find_recorder(tmp_path) is None
    lock = FileLock(tmp_path / LOCK_FILE)
    assert lock.acquire()
    assert lock_holder(tmp_path / LOCK_FILE) == os.getpid()
    assert not FileLock(tmp_path / LOCK_FILE).acquire(patience=0.0)
    lock.release()
    assert lock_holder(tmp_path / LOCK_FILE) is None


def test_a_flight_is_recorded_again_from_its_record(tmp_path, frames) -> None:
    first = tmp_path / "first"
    writer, framer, sent = RawWriter(first), Framer(), frames(50)
    for index, frame in enumerate(sent):
        writer.append(1_000_000 + index * 1000, framer.feed(frame) + framer.flush_complete())
    writer.close()
    status = record_link(str(first), tmp_path / "second", speed=float("inf"))
    assert status.state == "stopped"
    assert status.frames == 50
    assert data_of(tmp_path / "second") == sent


def test_the_record_command_tells_what_it_did(tmp_path, frames, capsys, port) -> None:
    from gsapp.cli.record import record

    first = tmp_path / "first"
    writer, framer = RawWriter(first), Framer()
    for index, frame in enumerate(frames(20)):
        writer.append(1_000_000 + index * 1000, framer.feed(frame) + framer.flush_complete())
    writer.close()
    record(str(first), tmp_path / "out", speed=1000.0, json=tmp_path / "state.json")
    printed = capsys.readouterr().out
    assert "Recorded 20 frames" in printed
    assert '"state": "stopped"' in (tmp_path / "state.json").read_text()


def test_sigterm_ends_a_record_cleanly(tmp_path, frames, port, patience) -> None:
    if sys.platform == "win32":
        pytest.skip("SIGTERM ends a process at once on Windows; the stop file is the way there")
    link, sender, target = udp_link(port)
    command = ["nohup", sys.executable, "-m", "gsapp.telemetry.recorder_process", link,
               str(tmp_path)]  # fmt: skip
    child = subprocess.Popen(
        command, env=os.environ | {RUNTIME_VARIABLE: str(tmp_path / "r")},
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    patience(lambda: find_recorder(tmp_path) and read_status(tmp_path / STATUS_FILE))
    frame = frames(1)[0]
    sender.sendto(frame[:-1], target)  # the beginning of a frame is kept as well
    patience(lambda: read_status(tmp_path / STATUS_FILE).received_bytes)
    child.send_signal(signal.SIGHUP)
    sender.sendto(frame[-1:], target)
    patience(lambda: read_status(tmp_path / STATUS_FILE).received_bytes == len(frame))
    child.send_signal(signal.SIGTERM)
    assert child.wait(10) == 0
    assert data_of(tmp_path) == [frame]


@pytest.mark.usefixtures("recorders")
def test_bad_input_over_a_link_is_kept_byte_for_byte(tmp_path, frames, port, patience) -> None:
    choose = random.Random(5)
    unknown = bytes((0xFD, 5, 0, 0, 9, 1, 1)) + (15_000_000).to_bytes(3, "little") + b"1234567"
    one, two = frames(200, seed=1, system=1), frames(200, seed=2, system=2)
    stream, whole = b"", []
    for index, pair in enumerate(zip(one, two, strict=True)):
        stream += b"".join(pair)
        whole += pair
        if index % 10 == 0:
            stream += choose.randbytes(choose.randrange(30))
        if index % 10 == 3:
            stream += pair[0][: len(pair[0]) // 2]
        if index % 10 == 6:
            stream += unknown
    handle = start_recorder(f"tcpin:127.0.0.1:{port(socket.SOCK_STREAM)}", tmp_path)
    address = parse_link(handle.status().link)
    with socket.create_connection((address.host, address.port)) as vehicle:
        for start in range(0, len(stream), 777):
            vehicle.sendall(stream[start : start + 777])
        patience(lambda: handle.status().received_bytes == len(stream))
    handle.stop()
    records = RawTail(tmp_path).poll()
    assert b"".join(item.data for item in records) == stream
    found = [item.data for item in records if item.kind == "frame"]
    assert Counter(whole) - Counter(found) == Counter()
    assert found.count(unknown) == 20


def filled_disk(folder: Path):
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=400k", "none", str(folder)]
    if sys.platform != "linux" or subprocess.run(mount, capture_output=True).returncode:
        pytest.skip("only the superuser of a Linux computer may make a small disk")
    (folder / "filler").write_bytes(bytes(340_000))


@pytest.mark.usefixtures("recorders")
def test_a_recorder_lives_through_a_disk_that_is_full(tmp_path, frames, port, patience) -> None:
    disk = tmp_path / "disk"
    filled_disk(disk)
    link, sender, target = udp_link(port)
    try:
        handle = start_recorder(link, disk / "flight")
        sent = frames(2000)
        for index, frame in enumerate(sent):
            sender.sendto(frame, target)
            if index % 20 == 0:
                time.sleep(0.002)
        patience(lambda: handle.status().waiting_bytes > 10_000)
        status = handle.status()
        assert "is full" in status.error
        assert status.frames > 1000
        (disk / "filler").unlink()
        patience(lambda: len(data_of(disk / "flight")) == len(sent))
        assert data_of(disk / "flight") == sent
        patience(lambda: not handle.status().error)
        assert handle.stop()
    finally:
        if running := find_recorder(disk / "flight"):
            running.stop()
        subprocess.run(["umount", str(disk)], check=True)  # noqa: S607


@pytest.mark.usefixtures("recorders")
def test_a_recorder_that_died_is_started_again_as_it_was(tmp_path, frames, port, patience) -> None:
    key = tmp_path / "key"
    key.write_bytes(bytes(range(32)))
    key.chmod(0o600)
    link, sender, target = udp_link(port)
    folder = tmp_path / "flight"
    died = start_recorder(link, folder, heartbeat=True, signing_key=str(key))
    sender.sendto(frames(1)[0], target)
    patience(lambda: len(data_of(folder)) == 1)
    os.kill(died.pid, KILL)
    patience(lambda: not died.is_alive())
    again = restart_recorder(folder)
    assert again.pid != died.pid
    assert restart_recorder(folder) == again
    found = again.status()
    assert (found.link, found.sends_heartbeats, found.listen_only, found.signing_key) == (
        link, True, False, str(key),
    )  # fmt: skip
    sender.sendto(frames(2)[1], target)
    patience(lambda: len(data_of(folder)) == 2)
    with pytest.raises(LinkError):
        restart_recorder(tmp_path / "nowhere")


def test_a_recorder_starts_without_the_numerics_of_models() -> None:
    """A recorder that died is missed for as long as the next one takes to start."""
    code = (
        "import sys, gsapp.telemetry.recorder_process\n"
        "sys.exit(bool({'scipy', 'pint', 'gsapp.dynamics'} & set(sys.modules)))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0

"""A second recorder that copies the flight of the first, late, with its stamps and marks."""

import os
import signal
import socket
import threading
import time
from collections import deque
from collections.abc import Iterator
from pathlib import Path

import pytest

from gsapp.decoding.dialect import dialect
from gsapp.decoding.framing import Framer
from gsapp.flight.events import Event, EventLog, events_path, read_events
from gsapp.flight.raw_files import RawTail, RawWriter
from gsapp.foundation import LinkError
from gsapp.session import Session
from gsapp.telemetry.flight_stream import FlightReceiver, FlightSender, StreamSeal
from gsapp.telemetry.link_diagnosis import LinkTest
from gsapp.telemetry.link_registry import kind_of, parse_link
from gsapp.telemetry.recorder_control import RecorderHandle, restart_recorder, start_recorder
from gsapp.telemetry.signing import derive_key, write_signing_key
from gsapp.telemetry.sources import open_source
from gsapp.telemetry.stream_server import ShareRequest, StreamServer
from tests.telemetry.conftest import free_port, make_frames, wait_until
from tests.telemetry.test_recorder import Running
from tests.telemetry.test_stream_sharing import Flight


class Crew:
    """Two laptops: one records the aircraft, the other copies."""

    def __init__(self, folder: Path, *, key: str = "", other_key: str = "") -> None:
        self.first = Flight(folder / "first")
        self.second_folder = folder / "second"
        self.second: RecorderHandle | None = None
        self.port = free_port(socket.SOCK_STREAM)
        self.key, self.other_key = key, other_key

    def share(self, host: str = "127.0.0.1") -> None:
        self.first.share(f"tcpin:{host}:{self.port}", key_file=self.key)

    def join(self) -> None:
        link = f"gsapp:127.0.0.1:{self.port}"
        self.second = start_recorder(link, self.second_folder, signing_key=self.other_key)

    def copied(self) -> list:
        return RawTail(self.second_folder).poll()

    def wait_until_copied(self) -> None:
        first = self.first.folder
        wait_until(lambda: self.copied() == RawTail(first).poll())
        name = "raw.tlog"
        assert (self.second_folder / name).read_bytes() == (first / name).read_bytes()

    def close(self) -> None:
        for recorder in (self.second, self.first.recorder):
            if recorder is not None:
                recorder.stop()
        self.first.aircraft.close()


@pytest.fixture
def crew(tmp_path: Path, own_runtime: Path) -> Iterator[Crew]:
    made = Crew(tmp_path)
    yield made
    made.close()


def test_a_late_recorder_has_the_whole_flight_with_its_stamps(crew: Crew) -> None:
    names = dialect()
    heartbeat = names.MAVLink_heartbeat_message(1, 3, 0, 0, 4, 3)
    frames = [bytes(heartbeat.pack(names.MAVLink(None, srcSystem=1))), *make_frames(6000)]
    crew.first.send([*frames[:3000], b"stray bytes", *frames[3000:5000]], pause=0.0002)
    wait_until(lambda: len(crew.first.recorded()) > 4900)
    crew.share()
    crew.join()
    crew.first.send(frames[5000:], pause=0.001)
    crew.wait_until_copied()
    assert len(crew.copied()) > 5900
    assert any(record.kind == "residue" for record in crew.copied())
    status = crew.second.status()
    assert (status.listen_only, status.heartbeats) == (True, 0)
    times = []
    for folder in (crew.first.folder, crew.second_folder):
        session = Session.follow(folder, channel_map="ardupilot-plane")
        while not session.feed.caught_up:
            session.update()
        times.append(session.now)
        session.close()
    assert times[0] == times[1] is not None


def test_marks_are_copied_once_and_alarms_of_the_other_computer_are_not(crew: Crew) -> None:
    crew.first.send(make_frames(10))
    log = EventLog(events_path(crew.first.folder))
    before = log.append(Event(kind="mark", text="before", time=1.0, data={"a": [1.5, None]}))
    log.append(Event(kind="alarm", text="disk", time=1.0, data={"alarm": "disk"}))
    crew.share()
    crew.join()

    def copied() -> list[Event]:
        return list(read_events(events_path(crew.second_folder)).events)

    wait_until(lambda: copied() == [before])
    own = EventLog(events_path(crew.second_folder)).append(Event(kind="note", text="our own"))
    crew.first.share()  # the connection ends ...
    crew.share()  # ... and comes back
    after = log.append(Event(kind="mark", text="after", time=2.0))
    wait_until(lambda: copied() == [before, own, after])
    time.sleep(1.5)
    assert copied() == [before, own, after]
    assert own not in read_events(events_path(crew.first.folder)).events  # one way


@pytest.mark.parametrize("breaks", ["connection", "recorder"])
def test_a_copy_that_breaks_off_goes_on_without_gap_or_repetition(crew: Crew, breaks: str) -> None:
    frames = make_frames(900)
    crew.share()
    crew.join()
    crew.first.send(frames[:300])
    wait_until(lambda: len(crew.copied()) > 200)
    if breaks == "connection":
        crew.first.share()
        crew.first.send(frames[300:600])
        crew.share()
    else:
        os.kill(crew.second.pid, getattr(signal, "SIGKILL", signal.SIGTERM))
        wait_until(lambda: not crew.second.is_alive())
        crew.first.send(frames[300:600])
        crew.second = restart_recorder(crew.second_folder)
    crew.first.send(frames[600:])
    wait_until(lambda: len(crew.copied()) == len(crew.first.recorded()) == 900)
    crew.wait_until_copied()


def test_another_flight_is_not_appended_to_the_copy(crew: Crew, tmp_path: Path) -> None:
    crew.share()
    crew.join()
    crew.first.send(make_frames(50))
    wait_until(lambda: len(crew.copied()) == 50)
    crew.first.recorder.stop()
    former, crew.first = crew.first, Flight(tmp_path / "next")
    former.aircraft.close()
    crew.first.send(make_frames(70))
    wait_until(lambda: len(crew.first.recorded()) == 70)
    crew.share()
    wait_until(lambda: "another flight" in crew.second.status().source_state)
    assert len(crew.copied()) == 50


def key_file(folder: Path, words: str) -> str:
    path = folder / words / "key"
    write_signing_key(path, derive_key(words))
    return str(path)


@pytest.mark.parametrize(("words", "is_admitted"), [("crew", True), ("others", False), ("", False)])
def test_other_computers_copy_the_flight_with_the_key_alone(
    tmp_path: Path, own_runtime: Path, words: str, is_admitted: bool
) -> None:
    crew = Crew(
        tmp_path, key=key_file(tmp_path, "crew"),
        other_key=key_file(tmp_path, words) if words else "",
    )  # fmt: skip
    try:
        crew.first.send(make_frames(100))
        wait_until(lambda: len(crew.first.recorded()) == 100)
        crew.share("0.0.0.0")  # noqa: S104
        assert not crew.first.shares()[0].error
        crew.join()
        if is_admitted:
            # The key is for the connection: an aircraft that does not sign is decoded all the same.
            wait_until(lambda: len(crew.copied()) == 100)
            crew.wait_until_copied()
            test = LinkTest(f"gsapp:127.0.0.1:{crew.port}", signing_key=crew.other_key)
            wait_until(lambda: test.diagnosis() is None)
            test.close()
            assert {record.origin.signature for record in crew.copied()} == {""}
        else:
            wait_until(lambda: "--share-key" in crew.second.status().source_state)
            assert crew.copied() == []
        with socket.create_connection(("127.0.0.1", crew.port)) as stranger:
            stranger.settimeout(10.0)
            crew.first.send(make_frames(20))
            assert stranger.recv(100) == b""
        wait_until(lambda: "not the key" in crew.first.shares()[0].note)
    finally:
        crew.close()


def test_datagrams_to_other_computers_need_more_than_a_key() -> None:
    server = StreamServer(parse_link("virtual"), bytes(32))
    with pytest.raises(LinkError):
        server.open(ShareRequest(links=("udpout:192.0.2.1:14550",)))


def test_a_block_that_was_altered_dropped_or_repeated_is_not_taken(tmp_path: Path) -> None:
    writer = RawWriter(tmp_path)
    key = bytes(32)
    sender = FlightSender(tmp_path, [key])
    nonce = sender.answer(b"gsapp flight 1 0 0 abc").split()[-1]
    assert sender.answer(StreamSeal(bytes(31), b"abc", nonce).proof()) == b"key\n"
    assert sender.answer(StreamSeal(key, b"abc", nonce).proof()) == b"ok\n"
    blocks = []
    for stamp in range(1, 5):
        framer = Framer()
        writer.append(stamp, framer.feed(make_frames(1)[0]) + framer.flush())
        blocks.append(sender.poll(0))
    one, two, three, _ = blocks

    def received(*parts: bytes) -> list[int]:
        receiver = FlightReceiver(StreamSeal(key, b"abc", nonce), deque())
        return [chunk.stamp_us for part in parts for chunk in receiver.feed(part)]

    assert received(*blocks) == [1, 2, 3, 4]
    assert received(b"".join(blocks)[:-1]) == [1, 2, 3]
    altered = bytes([*two[:-1], two[-1] ^ 1])
    for parts in ([one, altered], [one, three], [one, one], [two]):
        with pytest.raises(ValueError, match="altered"):
            received(*parts)


def test_a_copy_says_what_it_calls() -> None:
    kind = kind_of(parse_link("gsapp:192.168.1.10:5770"))
    assert not kind.accepts_commands
    port = free_port(socket.SOCK_STREAM)
    with socket.create_server(("127.0.0.1", port)) as server:
        source = open_source(f"gsapp:127.0.0.1:{port}")

        def answer() -> None:
            with server.accept()[0] as caller:
                caller.sendall(make_frames(1)[0] * 20)

        thread = threading.Thread(target=answer)
        thread.start()
        with pytest.raises(LinkError):
            source.open()
        assert f"tcp:127.0.0.1:{port}" in source.state
        thread.join()
        source.close()


def test_ages_count_by_the_clock_of_the_recorder_that_is_copied(tmp_path: Path) -> None:
    """Laptops at a field have no time server: 30 s apart are usual."""
    ahead_us = 30_000_000
    writer = RawWriter(tmp_path / "first")
    writer.append(time.time_ns() // 1000 + ahead_us, Framer().feed(make_frames(2)[0]))
    sender = FlightSender(writer.folder, [b""])
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve() -> None:
            with server.accept()[0] as client, client.makefile("rb") as lines:
                while not sender.is_accepted:
                    client.sendall(sender.answer(lines.readline().removesuffix(b"\n")))
                while not over.wait(0.05):
                    client.sendall(sender.poll(time.time_ns() // 1000 + ahead_us))

        over = threading.Event()
        thread = threading.Thread(target=serve)
        thread.start()
        source = open_source(f"gsapp:127.0.0.1:{server.getsockname()[1]}")
        with Running(source, tmp_path / "second") as recorder:
            wait_until(lambda: source.clock_offset_us and recorder.last_data_us)
            status = recorder.status("recording")
        over.set()
        thread.join()
    assert status.clock_offset_us == pytest.approx(ahead_us, abs=1_000_000)
    assert status.ahead_us - status.clock_offset_us < 1_000_000  # no clock was set back
    assert 0 <= status.updated_us - status.last_data_us < 5_000_000

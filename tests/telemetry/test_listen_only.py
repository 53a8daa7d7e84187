"""What the ground station sends: nothing, or heartbeats and log requests alone."""

import contextlib
import os
import socket
import subprocess
import sys
import threading
import time
import tty
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from gsapp.decoding.dialect import dialect
from gsapp.decoding.framing import Framer, MavlinkFrame, frame_message_id
from gsapp.flight.raw_files import RawTail
from gsapp.foundation import LinkError
from gsapp.telemetry.log_download.log_fetcher import LogFetcher
from gsapp.telemetry.recorder_control import start_recorder
from gsapp.telemetry.recorder_status import HEARTBEAT_END
from gsapp.telemetry.send_queue import request_send
from tests.telemetry.conftest import free_port, make_frames, wait_until

HEARTBEAT, LOG_REQUEST_LIST = 0, 117
SECONDS = 3.0  # three heartbeats
RECORD = [sys.executable, "-m", "gsapp", "record", "--map", "b777"]


class Peer:
    """The other end of a link: sends frames, and keeps every byte that comes back."""

    def __init__(self, send: Callable[[bytes], object], receive: Callable[[], bytes]) -> None:
        self._send, self._receive = send, receive
        self.received = bytearray()
        self._over = threading.Event()
        self._threads = [threading.Thread(target=one) for one in (self._talk, self._listen)]
        for thread in self._threads:
            thread.start()

    def _talk(self) -> None:
        for frame in make_frames(10_000):
            with contextlib.suppress(OSError):
                self._send(frame)
            if self._over.wait(0.02):
                return

    def _listen(self) -> None:
        while not self._over.is_set():
            with contextlib.suppress(OSError):
                self.received += self._receive()

    def close(self) -> None:
        self._over.set()
        for thread in self._threads:
            thread.join(5.0)


@contextlib.contextmanager
def udp_peer() -> Iterator[tuple[str, Peer]]:
    port = free_port(socket.SOCK_DGRAM)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as end:
        end.settimeout(0.1)
        end.bind(("127.0.0.1", 0))
        peer = Peer(lambda data: end.sendto(data, ("127.0.0.1", port)), lambda: end.recv(4096))
        yield f"udpin:127.0.0.1:{port}", peer
        peer.close()


@contextlib.contextmanager
def tcp_peer() -> Iterator[tuple[str, Peer]]:
    with socket.create_server(("127.0.0.1", 0)) as server:
        server.settimeout(20.0)
        ends: list[socket.socket] = []

        def end() -> socket.socket:
            if not ends:
                time.sleep(0.05)
                raise OSError
            return ends[0]

        def accept() -> None:
            connection = server.accept()[0]
            connection.settimeout(0.1)
            ends.append(connection)

        caller = threading.Thread(target=accept)
        caller.start()
        peer = Peer(lambda data: end().send(data), lambda: end().recv(4096))
        yield f"tcp:127.0.0.1:{server.getsockname()[1]}", peer
        peer.close()
        caller.join()
        for connection in ends:
            connection.close()


@contextlib.contextmanager
def serial_peer() -> Iterator[tuple[str, Peer]]:
    ours, theirs = os.openpty()
    tty.setraw(theirs)  # or what is sent would come back as an echo before the port is opened
    os.set_blocking(ours, False)

    def receive() -> bytes:
        time.sleep(0.02)
        return os.read(ours, 4096)

    peer = Peer(lambda data: os.write(ours, data), receive)
    yield f"serial:{os.ttyname(theirs)}:57600", peer
    peer.close()
    for descriptor in (ours, theirs):
        os.close(descriptor)


def ask_for_logs(folder: Path) -> None:
    packer = dialect().MAVLink(None, srcSystem=255, srcComponent=190)
    request_send(folder, bytes(dialect().MAVLink_log_request_list_message(1, 1, 0, 9).pack(packer)))


def sent_ids(peer: Peer) -> list[int]:
    framer = Framer()
    items = framer.feed(bytes(peer.received)) + framer.flush()
    assert all(isinstance(item, MavlinkFrame) for item in items)
    return [frame_message_id(item.data) for item in items]


PEERS = [udp_peer, tcp_peer, serial_peer]


@pytest.mark.parametrize("make", PEERS)
def test_listen_only_sends_no_byte(make, tmp_path: Path) -> None:
    """Not even where a program asks for logs."""
    with make() as (link, peer):
        recorder = start_recorder(link, tmp_path, listen_only=True)
        wait_until(lambda: len(RawTail(tmp_path).poll()) > 5)
        ask_for_logs(tmp_path)
        time.sleep(SECONDS)
        status = recorder.status()
        with pytest.raises(LinkError):
            LogFetcher(tmp_path)
        recorder.stop()
        assert len(peer.received) == 0
    assert status is not None
    assert (status.listen_only, status.heartbeats) == (True, 0)


@pytest.mark.parametrize("make", PEERS)
def test_heartbeats_and_log_requests_are_all_that_is_sent(make, tmp_path: Path) -> None:
    with make() as (link, peer):
        recorder = start_recorder(link, tmp_path, heartbeat=True)
        wait_until(lambda: len(RawTail(tmp_path).poll()) > 5)
        wait_until(lambda: len(peer.received) > 0)
        ask_for_logs(tmp_path)
        wait_until(lambda: LOG_REQUEST_LIST in sent_ids(peer))
        recorder.stop()
        ids = sent_ids(peer)
    assert set(ids) == {HEARTBEAT, LOG_REQUEST_LIST}
    assert ids.count(LOG_REQUEST_LIST) == 1


def test_without_heartbeat_a_link_is_not_spoken_to(tmp_path: Path) -> None:
    with udp_peer() as (link, peer):
        recorder = start_recorder(link, tmp_path)
        wait_until(lambda: len(RawTail(tmp_path).poll()) > 5)
        time.sleep(SECONDS)
        recorder.stop()
        assert len(peer.received) == 0


@pytest.mark.parametrize("option", ["--listen-only", "--heartbeat"])
def test_the_command_cautions_against_the_end_of_the_heartbeats_that_it_sent(
    tmp_path: Path, option: str
) -> None:
    folder, sends = tmp_path / "flight", option == "--heartbeat"
    with udp_peer() as (link, peer):
        run = subprocess.Popen(
            [*RECORD, link, "--out", str(folder), option], stdout=subprocess.PIPE, text=True
        )
        wait_until(lambda: len(RawTail(folder).poll()) > 100)
        wait_until(lambda: bool(peer.received) or not sends)
        run.terminate()
        output = run.communicate(timeout=20.0)[0]
        assert run.returncode == 0
        assert (HEARTBEAT_END in output, len(peer.received) > 0) == (sends, sends)


@pytest.mark.parametrize(
    ("link", "options", "code"),
    [
        ("udpout:127.0.0.1:{port}", ["--listen-only"], 1),  # nothing would ever come
        ("udpin:127.0.0.1:{port}", ["--listen-only", "--heartbeat"], 2),
    ],
)
def test_listen_only_that_cannot_be_is_refused(
    link: str, options: list[str], code: int, tmp_path: Path
) -> None:
    given = link.format(port=free_port(socket.SOCK_DGRAM))
    run = subprocess.run(
        [*RECORD, given, "--out", str(tmp_path / "flight"), *options], check=False, timeout=60.0
    )
    assert run.returncode == code
    assert not (tmp_path / "flight").exists()

"""What a recorder receives, passed on to pymavlink and to sockets that misbehave."""

import contextlib
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from gsapp.flight.raw_files import RawTail
from gsapp.foundation import LinkError
from gsapp.telemetry.link_registry import parse_link
from gsapp.telemetry.recorder_control import RecorderHandle, restart_recorder, start_recorder
from gsapp.telemetry.recorder_process import record_link
from gsapp.telemetry.recorder_status import ShareStatus
from gsapp.telemetry.stream_server import ShareRequest, StreamServer, request_shares
from tests.telemetry.conftest import free_port, make_frames, wait_until

os.environ["MAVLINK20"] = "1"
from pymavlink import mavutil


class Flight:
    """A recorder process, and the aircraft that sends to it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.port = free_port(socket.SOCK_DGRAM)
        self.aircraft = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.aircraft.bind(("127.0.0.1", 0))
        self.recorder: RecorderHandle = start_recorder(f"udpin:127.0.0.1:{self.port}", folder)

    def share(self, *links: str, key_file: str = "") -> list[ShareStatus]:
        request_shares(self.folder, ShareRequest(links=links, key_file=key_file))
        wait_until(lambda: [share.link for share in self.shares()] == list(links))
        return self.shares()

    def shares(self) -> list[ShareStatus]:
        status = self.recorder.status()
        return [] if status is None else status.shares

    def send(self, frames: list[bytes], pause: float = 0.001) -> None:
        for frame in frames:
            self.aircraft.sendto(frame, ("127.0.0.1", self.port))
            time.sleep(pause)

    def recorded(self) -> list[bytes]:
        return [record.data for record in RawTail(self.folder).poll()]


@pytest.fixture
def flight(tmp_path: Path, own_runtime: Path) -> Iterator[Flight]:
    made = Flight(tmp_path / "flight")
    yield made
    made.recorder.stop()
    made.aircraft.close()


def tcp_share() -> tuple[str, int]:
    port = free_port(socket.SOCK_STREAM)
    return f"tcpin:127.0.0.1:{port}", port


def clients(flight: Flight, count: int) -> None:
    wait_until(lambda: len(flight.shares()[0].clients) == count)


def receive(link: mavutil.mavfile, count: int) -> list[bytes]:
    found: list[bytes] = []
    deadline = time.monotonic() + 20.0
    while len(found) < count and time.monotonic() < deadline:
        if (message := link.recv_msg()) is None:
            time.sleep(0.005)
        else:
            found.append(bytes(message.get_msgbuf()))
    return found


@pytest.mark.parametrize("protocol", ["tcp", "udp"])
def test_pymavlink_receives_every_frame(flight: Flight, protocol: str) -> None:
    frames = make_frames(300)
    if protocol == "tcp":
        link, port = tcp_share()
        flight.share(link)
        client = mavutil.mavlink_connection(f"tcp:127.0.0.1:{port}", dialect="all")
        clients(flight, 1)
    else:
        port = free_port(socket.SOCK_DGRAM)
        link = f"udpout:127.0.0.1:{port}"
        client = mavutil.mavlink_connection(f"udpin:127.0.0.1:{port}", dialect="all")
        flight.share(link)
    sent = [b"stray", *frames[:150], b"bytes", *frames[150:]]
    sender = threading.Thread(target=flight.send, args=(sent, 0.004))
    sender.start()
    assert receive(client, len(frames)) == frames
    sender.join()
    wait_until(lambda: flight.shares()[0].sent_bytes == sum(map(len, frames)))
    assert flight.shares()[0].dropped_bytes == 0
    client.close()


def test_lines_of_text_are_passed_on_as_lines(tmp_path: Path) -> None:
    from tests.telemetry.test_recorder import Running, Script, stamped

    link, port = tcp_share()
    server = StreamServer(parse_link("virtual"))
    server.open(ShareRequest(links=(link,)))
    source = Script(framing="text")
    with (
        Running(source, tmp_path, server=server),
        socket.create_connection(("127.0.0.1", port)) as client,
    ):
        wait_until(lambda: server.status()[0].clients)
        source.chunks.extend(stamped([b"1,2\r\n", b"3,4\n"]))
        client.settimeout(10.0)
        received = b""
        while received.count(b"\n") < 2:
            received += client.recv(100)
    assert received == b"1,2\n3,4\n"


def test_what_a_client_sends_reaches_nobody(flight: Flight) -> None:
    """Neither the aircraft, nor the record, nor the other clients."""
    first, port = tcp_share()
    udp = free_port(socket.SOCK_DGRAM)
    frames, foreign = make_frames(20), make_frames(200, seed=7, system=255)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", udp))
        other.settimeout(10.0)
        flight.share(first, f"udpout:127.0.0.1:{udp}")
        with (
            socket.create_connection(("127.0.0.1", port)) as talker,
            socket.create_connection(("127.0.0.1", port)) as listener,
        ):
            clients(flight, 2)
            flight.send(frames[:1])
            sender = other.recvfrom(1000)[1]
            for frame in foreign:
                talker.sendall(frame)
                other.sendto(frame, sender)
            flight.send(frames[1:])
            wait_until(lambda: len(flight.recorded()) == len(frames))
            received = b""
            while len(received) < sum(map(len, frames)):
                received += listener.recv(65536)
            assert received == b"".join(frames)
            received = b"".join(frames[:1])
            while len(received) < sum(map(len, frames)):
                received += other.recv(65536)
            assert received == b"".join(frames)
    assert flight.recorded() == frames
    flight.aircraft.settimeout(0.5)
    with pytest.raises(TimeoutError):
        flight.aircraft.recv(1000)


def test_a_client_that_never_reads_delays_nobody_and_is_disconnected(flight: Flight) -> None:
    link, port = tcp_share()
    flight.share(link)
    stuck = socket.socket()
    stuck.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    stuck.connect(("127.0.0.1", port))
    frames = make_frames(20_000)
    received = bytearray()
    size = sum(map(len, frames))
    with socket.create_connection(("127.0.0.1", port)) as client:
        clients(flight, 2)
        stuck_name = f"127.0.0.1:{stuck.getsockname()[1]}"

        def read() -> None:
            while len(received) < size and (data := client.recv(65536)):
                received.extend(data)

        reader = threading.Thread(target=read)
        reader.start()
        for start in range(0, len(frames), 20):
            flight.send(frames[start : start + 20], pause=0.0)
            time.sleep(0.001)
        clients(flight, 1)
        reader.join(20.0)
        share = flight.shares()[0]
        assert stuck_name not in share.clients
        assert stuck_name in share.note
        assert 0 < share.dropped_bytes < size
        assert flight.recorded() == frames
        assert bytes(received) == b"".join(frames)
    stuck.close()


def test_clients_come_and_go_and_the_ninth_is_refused(flight: Flight) -> None:
    link, port = tcp_share()
    flight.share(link)
    frames = make_frames(40)
    callers = [socket.create_connection(("127.0.0.1", port)) for _ in range(9)]
    clients(flight, 8)
    callers[8].settimeout(10.0)
    assert callers[8].recv(100) == b""
    for caller in callers:
        caller.close()
    clients(flight, 0)
    flight.send(frames[:20])
    wait_until(lambda: flight.recorded() == frames[:20])
    time.sleep(0.2)  # passed on to nobody
    with socket.create_connection(("127.0.0.1", port)) as late:
        clients(flight, 1)
        flight.send(frames[20:])
        late.settimeout(10.0)
        received = b""
        while len(received) < sum(map(len, frames[20:])):
            received += late.recv(65536)
        assert received == b"".join(frames[20:])  # from when it called, as MAVProxy sends
    assert flight.recorded() == frames


def test_shares_are_switched_on_and_off_while_recording(flight: Flight) -> None:
    (first, one), (second, other) = tcp_share(), tcp_share()
    flight.share(first)
    with socket.create_connection(("127.0.0.1", one)) as client:
        clients(flight, 1)
        flight.share(first, second)
        assert flight.shares()[0].clients  # stays connected
        socket.create_connection(("127.0.0.1", other)).close()
        flight.share(second)
        client.settimeout(10.0)
        assert client.recv(100) == b""
    flight.share()
    for port in (one, other):
        with pytest.raises(ConnectionRefusedError):
            socket.create_connection(("127.0.0.1", port))


def test_a_recorder_that_died_shares_again(flight: Flight) -> None:
    link, port = tcp_share()
    flight.share(link)
    os.kill(flight.recorder.pid, getattr(signal, "SIGKILL", signal.SIGTERM))
    wait_until(lambda: not flight.recorder.is_alive())
    flight.recorder = restart_recorder(flight.folder)
    wait_until(lambda: [share.link for share in flight.shares()] == [link])
    socket.create_connection(("127.0.0.1", port)).close()


def refusal(link: str, recorded: str = "virtual", *, is_open: bool = False) -> str:
    server = StreamServer(parse_link(recorded))
    with pytest.raises(LinkError) as refused:
        server.open(ShareRequest(links=(link,), is_open=is_open))
    assert server.status()[0].error == str(refused.value)
    return str(refused.value)


def test_a_port_in_use_gets_a_sentence(flight: Flight) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        link = f"tcpin:127.0.0.1:{taken.getsockname()[1]}"
        assert "in use" in refusal(link)
        good, _ = tcp_share()
        bad, shared = flight.share(link, good)
        assert "in use" in bad.error
        assert not shared.error
        assert flight.recorder.is_alive()


@pytest.mark.parametrize("link", ["tcpin:0.0.0.0:5770", "udpout:192.0.2.1:14550"])
def test_a_network_is_not_shared_with_unless_that_is_asked_for(link: str) -> None:
    assert "--share-open" in refusal(link)
    link = link.replace("5770", str(free_port(socket.SOCK_STREAM)))
    server = StreamServer(parse_link("virtual"))
    server.open(ShareRequest(links=(link,), is_open=True))
    assert [(share.link, share.error) for share in server.status()] == [(link, "")]
    server.close()


@pytest.mark.parametrize("link", ["serial:/dev/ttyS0:57600", "udpin:127.0.0.1:14550", "virtual"])
def test_other_links_cannot_be_shared_with(link: str) -> None:
    assert "tcpin:HOST:PORT" in refusal(link)


def test_a_stream_does_not_come_back_to_its_own_port() -> None:
    port = free_port(socket.SOCK_DGRAM)
    link, recorded = f"udpout:127.0.0.1:{port}", f"udpin:0.0.0.0:{port}"
    assert "come back" in refusal(link, recorded)


def test_the_command_shares_and_says_so(tmp_path: Path, own_runtime: Path) -> None:
    port = free_port(socket.SOCK_DGRAM)
    link, shared = tcp_share()
    udp = free_port(socket.SOCK_DGRAM)
    record = [sys.executable, "-m", "gsapp", "record", f"udpin:127.0.0.1:{port}"]
    run = subprocess.Popen(
        [
            *record, "--map", "b777", "--out", str(tmp_path / "flight"),
            "--share", link, "--share", f"udpout:127.0.0.1:{udp}",
        ],
        stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    frames = make_frames(30)

    def call() -> socket.socket | None:
        with contextlib.suppress(OSError):
            return socket.create_connection(("127.0.0.1", shared))
        return None

    client = wait_until(call)
    time.sleep(0.5)  # welcomed, and the command has seen it
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as aircraft:
        for frame in frames:
            aircraft.sendto(frame, ("127.0.0.1", port))
    received = b""
    while len(received) < sum(map(len, frames)):
        received += client.recv(65536)
    time.sleep(1.0)
    run.terminate()
    output = " ".join(run.communicate(timeout=20.0)[0].split())
    assert run.returncode == 0
    assert f"{link}: 1 client connected" in output
    assert f"Shared {sum(map(len, frames))} bytes over {link}." in output
    client.close()


@pytest.mark.parametrize("options", [("tcpin:0.0.0.0:0",), ("udpin:127.0.0.1:1",)])
def test_the_command_refuses_before_a_folder_is_made(tmp_path: Path, options) -> None:
    link, folder = f"udpin:127.0.0.1:{free_port(socket.SOCK_DGRAM)}", tmp_path / "flight"
    with pytest.raises(LinkError):
        record_link(link, tmp_path / "direct", shares=ShareRequest(links=options))
    run = subprocess.run(
        [
            sys.executable, "-m", "gsapp", "record", link, "--out", str(folder),
            "--share", options[0],
        ],
        check=False, timeout=60.0,
    )  # fmt: skip
    assert run.returncode == 1
    assert not folder.exists()

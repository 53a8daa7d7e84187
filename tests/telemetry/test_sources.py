"""Sources: one suite for all of them, over real sockets and pseudo-terminals."""

import contextlib
import errno
import itertools
import os
import socket
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace

import pytest

from gsapp.decoding.framing import Framer, LineFramer
from gsapp.flight.raw_files import RawWriter
from gsapp.foundation import LinkError
from gsapp.telemetry.clock import HostClock
from gsapp.telemetry.link_kinds import BUILT_IN_KINDS, LinkAddress, is_same_port
from gsapp.telemetry.link_registry import parse_link
from gsapp.telemetry.sources import Chunk, LinkSource, LinkUnavailableError, open_source
from gsapp.telemetry.sources.link_source import network_error
from gsapp.telemetry.stream_server import ShareRequest, StreamServer

STAMP = 1_700_000_000_000_000


class OtherEnd:
    def __init__(
        self,
        link: str,
        send: Callable[[bytes], object],
        receive: Callable[[], bytes] | None = None,
        close: Callable[[], object] = lambda: None,
        begin: Callable[[], object] = lambda: None,
    ) -> None:
        self.link, self.send, self.receive, self.close, self.begin = (
            link, send, receive, close, begin,
        )  # fmt: skip


def udpin_end(port, _folder) -> OtherEnd:
    number = port(socket.SOCK_DGRAM)
    sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    sender.settimeout(5)
    return OtherEnd(
        f"udpin:127.0.0.1:{number}",
        lambda data: sender.sendto(data, ("127.0.0.1", number)),
        lambda: sender.recv(2048),
        sender.close,
    )


def udpout_end(_port, _folder) -> OtherEnd:
    peer = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    peer.bind(("127.0.0.1", 0))
    peer.settimeout(5)
    heard: list[tuple] = []

    def receive() -> bytes:
        data, sender = peer.recvfrom(2048)
        heard.append(sender)
        return data

    def send(data: bytes) -> None:
        if not heard:
            receive()  # only who has been spoken to can answer
        peer.sendto(data, heard[-1])

    return OtherEnd(f"udpout:127.0.0.1:{peer.getsockname()[1]}", send, receive, peer.close)


def tcp_end(_port, _folder) -> OtherEnd:
    listener = socket.create_server(("127.0.0.1", 0))
    listener.settimeout(5)
    calls: list[socket.socket] = []

    def connection() -> socket.socket:
        if not calls:
            calls.append(listener.accept()[0])
            calls[0].settimeout(5)
        return calls[0]

    def close() -> None:
        for call in calls:
            call.close()
        listener.close()

    return OtherEnd(
        f"tcp:127.0.0.1:{listener.getsockname()[1]}",
        lambda data: connection().sendall(data),
        lambda: connection().recv(2048),
        close,
    )


def tcpin_end(port, _folder) -> OtherEnd:
    number = port(socket.SOCK_STREAM)
    calls: list[socket.socket] = []

    def connection() -> socket.socket:
        if not calls:
            calls.append(socket.create_connection(("127.0.0.1", number), timeout=5))
        return calls[0]

    return OtherEnd(
        f"tcpin:127.0.0.1:{number}",
        lambda data: connection().sendall(data),
        lambda: connection().recv(2048),
        lambda: [call.close() for call in calls],
    )


def serial_end(_port, _folder, kind: str = "serial") -> OtherEnd:
    if sys.platform == "win32":
        pytest.skip("no pseudo-terminals on Windows")
    master, slave = os.openpty()
    path = os.ttyname(slave)
    os.close(slave)
    return OtherEnd(
        f"{kind}:{path}:57600",
        lambda data: os.write(master, data),
        lambda: os.read(master, 2048),
        lambda: os.close(master),
    )


def text_end(port, folder) -> OtherEnd:
    return serial_end(port, folder, "text")


def flight_end(_port, folder: Path) -> OtherEnd:
    writer = RawWriter(folder / "flight")

    def send(data: bytes) -> None:
        framer = Framer()
        writer.append(STAMP, framer.feed(data) + framer.flush())
        writer.close()

    return OtherEnd(str(folder / "flight"), send)


def gsapp_end(port, folder: Path) -> OtherEnd:
    """Another recorder, reduced to its files and what shares them."""
    writer, number = RawWriter(folder / "flight"), port(socket.SOCK_STREAM)
    server = StreamServer(parse_link("virtual"))
    server.folder = writer.folder
    server.open(ShareRequest(links=(f"tcpin:127.0.0.1:{number}",)))
    clock = HostClock()

    def send(data: bytes) -> None:
        framer = Framer()
        for item in (*framer.feed(data), *framer.flush()):
            writer.append(clock.now_us(), [item])
        time.sleep(0.2)

    return OtherEnd(f"gsapp:127.0.0.1:{number}", send, None, server.close)


ENDS = {
    "udpin": udpin_end, "udpout": udpout_end, "tcp": tcp_end, "tcpin": tcpin_end,
    "serial": serial_end, "text": text_end, "flight": flight_end,
    "gsapp": gsapp_end,
}  # fmt: skip


@pytest.fixture(params=sorted(ENDS))
def end(request, port, tmp_path: Path) -> Iterator[OtherEnd]:
    made = ENDS[request.param](port, tmp_path)
    yield made
    with contextlib.suppress(OSError):
        made.close()


def collect(source: LinkSource, count: int, seconds: float = 5.0) -> list[Chunk]:
    chunks: list[Chunk] = []
    deadline = time.monotonic() + seconds
    while sum(len(chunk.data) for chunk in chunks) < count and time.monotonic() < deadline:
        chunks += source.read(0.05)
    return chunks


def received(source: LinkSource, count: int) -> bytes:
    return b"".join(chunk.data for chunk in collect(source, count))


def serial_port(place: str, opener: Callable, ports: Callable = list, clock=None) -> LinkSource:
    address = parse_link(f"serial:{place}")
    return open_source(address, clock=clock or HostClock(), ports=ports, opener=opener)


def make(end: OtherEnd) -> LinkSource:
    source = open_source(end.link)
    if source.address.kind != "flight":
        source.open()
    return source


def send_to(source: LinkSource, end: OtherEnd, data: bytes) -> None:
    if source.address.kind == "udpout":
        source.write(b"hello")
    thread = threading.Thread(target=end.send, args=(data,))
    thread.start()
    if source.address.kind == "flight":
        thread.join()


def test_every_kind_of_link_is_in_the_suite() -> None:
    """The virtual aircraft makes its data itself: it has a test of its own below."""
    assert {kind.name for kind in BUILT_IN_KINDS} | {"flight"} == {*ENDS, "virtual"}


def test_all_bytes_arrive_in_order_with_rising_stamps(end: OtherEnd, frames) -> None:
    data = b"".join(frames(40))
    if end.link.startswith("text"):
        data = b"1,2,3\n" * 200
    source = make(end)
    before = time.time_ns() // 1000
    send_to(source, end, data)
    chunks = collect(source, len(data))
    after = time.time_ns() // 1000
    assert b"".join(chunk.data for chunk in chunks) == data
    stamps = [chunk.stamp_us for chunk in chunks]
    assert all(first < second for first, second in itertools.pairwise(stamps))
    assert before <= stamps[0] <= stamps[-1] <= after + 1000
    assert source.connected or source.finished
    assert source.framing == ("text" if end.link.startswith("text") else "mavlink")
    source.close()


def test_replies_go_to_whoever_spoke(end: OtherEnd, frames) -> None:
    source = make(end)
    if end.receive is None:
        source.write(b"a record does not listen")
        return
    message = frames(1)[0]
    send_to(source, end, message)
    assert collect(source, len(message))
    source.write(b"answer")
    received = b""
    while b"answer" not in received:
        received += end.receive()
    source.close()


def test_silence_gives_nothing_and_takes_its_time(end: OtherEnd) -> None:
    if end.receive is None:
        pytest.skip("a record is never silent")
    source = make(end)
    source.read(0.0)  # a caller may be welcomed
    start = time.monotonic()
    assert source.read(0.05) == []
    assert 0.045 <= time.monotonic() - start < 1.5
    source.close()


def test_a_closed_source_stays_closed(end: OtherEnd, frames) -> None:
    source = make(end)
    if end.receive is None:
        end.send(b"".join(frames(300)))
        assert source.read(0.05)
    source.close()
    source.close()
    source.write(b"nobody hears this")
    start = time.monotonic()
    assert source.read(0.05) == []
    assert time.monotonic() - start >= 0.045
    assert not source.connected
    assert source.state.endswith(": closed")
    make(end).close()  # the port is free again


def test_what_is_away_is_said_and_does_not_raise(tmp_path: Path, port) -> None:
    for link in (f"tcp:127.0.0.1:{port(socket.SOCK_STREAM)}", f"serial:{tmp_path}/ttyNone:57600"):
        source = open_source(link)
        with pytest.raises(LinkUnavailableError):
            source.open()
        assert source.read(0.0) == []
        assert link in source.state
        source.close()


class FakeClock:
    """Time that passes only when somebody sleeps."""

    correction_us = 0

    def __init__(self) -> None:
        self.now = 0.0
        self.sleeps = 0

    def now_us(self) -> int:
        self.now += 1e-6
        return int(self.now * 1e6)

    def monotonic(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        assert seconds > 0.0
        self.sleeps += 1
        self.now += seconds


def test_attempts_grow_rarer_and_never_spin() -> None:
    clock, attempts = FakeClock(), []

    def opener(path: str, baud: int):
        attempts.append(clock.now)
        raise OSError(errno.ENOENT, "could not open port")

    source = serial_port("/dev/ttyUSB9:57600", opener, clock=clock)
    reads = 0
    while clock.now < 3600.0:
        assert source.read(0.2) == []
        reads += 1
    assert 3000 < len(attempts) < 3700
    assert reads - len(attempts) == clock.sleeps
    intervals = [second - first for first, second in itertools.pairwise(attempts)]
    assert intervals[:4] == pytest.approx([0.1, 0.2, 0.4, 0.8], abs=0.01)
    assert max(intervals) == pytest.approx(1.0, abs=0.01)


def test_a_device_that_comes_and_goes_is_looked_for_calmly_and_found_soon() -> None:
    clock, radio = FakeClock(), SimpleNamespace(device="COM5", serial_number="A1", vid=1, pid=2)
    plugged, looks = [radio], []

    class Port:
        timeout = in_waiting = 0

        def read(self, _count: int) -> bytes:
            if not plugged:
                raise OSError(errno.EIO, "pulled out")
            return b"x"

        def close(self) -> None:
            pass

    def ports() -> list[SimpleNamespace]:
        looks.append(clock.now)
        return list(plugged)

    source = serial_port("COM5:57600", lambda *_: Port(), ports, clock=clock)
    for _ in range(2):
        assert [chunk.data for chunk in source.read(0.2)] == [b"x"]
        plugged.clear()
        assert [chunk.data for chunk in source.read(0.2)] == [b""]
        gone = clock.now
        looks.clear()
        while clock.now < gone + 60.0 and len(looks) < 100:
            assert source.read(0.2) == []
        assert looks[0] == pytest.approx(gone + 0.1, abs=0.01)
        assert 60 <= len(looks) < 70
        plugged.append(radio)
        while not source.connected:
            source.read(0.2)


def test_a_peer_that_hangs_up_at_once_is_not_called_in_a_loop(port) -> None:
    listener = socket.create_server(("127.0.0.1", 0))
    clock = FakeClock()
    address = parse_link(f"tcp:127.0.0.1:{listener.getsockname()[1]}")
    source = open_source(address, clock=clock)
    calls = 0
    listener.setblocking(False)
    for _ in range(600):
        source.read(0.0 if source.connected else 0.05)
        with contextlib.suppress(BlockingIOError):
            listener.accept()[0].close()
            calls += 1
    assert clock.now > 20.0
    assert 5 < calls <= 8 + clock.now / 5.0
    source.close()
    listener.close()


def test_a_tcp_connection_comes_back(frames) -> None:
    end = tcp_end(None, None)
    source = make(end)
    first, second = frames(2)
    end.send(first)
    assert received(source, len(first)) == first
    port_number = source.address.port
    end.close()
    ended = [chunk for _ in range(3) for chunk in source.read(0.05)]
    assert [chunk.data for chunk in ended] == [b""]  # this stream has ended
    assert "connection closed" in source.state
    listener = socket.create_server(("127.0.0.1", port_number))
    thread = threading.Thread(target=lambda: listener.accept()[0].sendall(second))
    thread.start()
    assert received(source, len(second)) == second
    source.close()
    listener.close()


@pytest.mark.skipif(sys.platform == "win32", reason="no pseudo-terminals on Windows")
def test_a_serial_port_is_found_again_under_another_name(frames) -> None:
    """Unplugged, and back as another device: known by its USB serial number."""
    first_master, first_slave = os.openpty()
    second_master, second_slave = os.openpty()
    first, second = os.ttyname(first_slave), os.ttyname(second_slave)

    def port(device: str, number: str) -> SimpleNamespace:
        return SimpleNamespace(device=device, serial_number=number, vid=0x0403, pid=0x6015)

    plugged = [port(first, "AB12"), port("/dev/other", "ZZ99")]
    address = parse_link(f"serial:{first}:57600")
    source = open_source(address, clock=HostClock(), ports=lambda: list(plugged))
    one, two = frames(2)
    source.open()
    os.write(first_master, one)
    assert received(source, len(one)) == one
    os.close(first_slave)
    os.close(first_master)  # unplugged
    plugged.pop(0)
    ended = [chunk for _ in range(3) for chunk in source.read(0.05)]
    assert [chunk.data for chunk in ended] == [b""]
    for _ in range(4):
        source.read(0.1)
    assert "unplugged" in source.state
    plugged.append(port(second, "AB12"))
    while not source.connected:
        source.read(0.1)
    os.write(second_master, two)
    assert received(source, len(two)) == two
    assert second in source.state
    source.close()
    os.close(second_slave)
    os.close(second_master)


def refused(link: str) -> str:
    source = open_source(link)
    with pytest.raises(LinkError) as caught:
        source.open()
    assert not isinstance(caught.value, LinkUnavailableError)
    assert source.state == str(caught.value)
    source.close()
    return str(caught.value)


def test_ports_in_use_get_a_sentence(port) -> None:
    for kind, protocol in (("udpin", socket.SOCK_DGRAM), ("tcpin", socket.SOCK_STREAM)):
        link = f"{kind}:127.0.0.1:{port(protocol)}"
        holder = open_source(link)
        holder.open()
        assert "in use" in refused(link)
        holder.close()


def test_a_port_is_not_shared_with_who_asks_for_it(port) -> None:
    """As other ground stations do; Windows would let them in, and the data out."""
    for kind, protocol in (("udpin", socket.SOCK_DGRAM), ("tcpin", socket.SOCK_STREAM)):
        source = open_source(f"{kind}:127.0.0.1:{port(protocol)}")
        source.open()
        with socket.socket(socket.AF_INET, protocol) as other:
            other.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            with pytest.raises(OSError, match=r"in use|forbidden|10013|10048"):
                other.bind(("127.0.0.1", source.address.port))
        source.close()


def test_a_port_that_windows_keeps_back_gets_a_sentence() -> None:
    class RefusedError(OSError):
        winerror = 10013

    error = RefusedError(errno.EACCES, "An attempt was made to access a socket")
    problem = str(network_error(parse_link("udpin:14550"), error))
    assert "UDP port 14550" in problem
    assert "choose another port" in problem
    assert "1024" not in problem


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (OSError(errno.ECONNREFUSED, "Connection refused"), "10.0.0.5 port 576 refuses"),
        (OSError(errno.EHOSTUNREACH, "No route to host"), "nothing answers at 10.0.0.5 port 576"),
        (TimeoutError("timed out"), "nothing answers at 10.0.0.5 port 576"),
        (OSError(errno.ENOBUFS, "No buffer space"), "No buffer space; retrying"),
        (OSError("odd"), "odd; retrying"),
    ],
)
def test_what_may_pass_by_itself_is_waited_for(error: OSError, words: str) -> None:
    problem = network_error(parse_link("tcp:10.0.0.5:576"), error)
    assert isinstance(problem, LinkUnavailableError)
    assert words in str(problem)


def test_a_port_can_be_listened_on_again_after_a_call(port) -> None:
    link = f"tcpin:127.0.0.1:{port(socket.SOCK_STREAM)}"
    source = open_source(link)
    source.open()
    with socket.create_connection(("127.0.0.1", source.address.port), timeout=5) as caller:
        caller.sendall(b"here")
        assert collect(source, 4)
        source.close()
        assert caller.recv(1) == b""
    again = open_source(link)
    again.open()
    again.close()


@pytest.mark.skipif(not hasattr(socket, "TCP_KEEPIDLE"), reason="needs the usual name to look")
@pytest.mark.parametrize("system", ["here", "macOS"])
def test_a_peer_that_vanishes_is_missed_soon(port, monkeypatch, patience, system) -> None:
    """After 5 s of silence the system asks for it; macOS has another name for that option."""
    idle = socket.TCP_KEEPIDLE
    if system == "macOS":
        monkeypatch.delattr(socket, "TCP_KEEPIDLE")
        monkeypatch.setattr(socket, "TCP_KEEPALIVE", idle, raising=False)
    called = open_source(f"tcpin:127.0.0.1:{port(socket.SOCK_STREAM)}")
    called.open()
    calling = open_source(f"tcp:127.0.0.1:{called.address.port}")
    calling.open()
    patience(lambda: called.read(0.01) or called._clients)
    for connection in (*called._clients, calling._socket):
        assert connection.getsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE)
        assert connection.getsockopt(socket.IPPROTO_TCP, idle) == 5
        assert connection.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)
    calling.close()
    called.close()


@pytest.mark.skipif(sys.platform == "win32", reason="no pseudo-terminals on Windows")
def test_a_serial_port_in_use_gets_a_sentence() -> None:
    end = serial_end(None, None)
    holder = open_source(end.link)
    holder.open()
    assert "in use" in refused(end.link)
    holder.close()
    end.close()


def test_names_and_addresses_that_lead_nowhere_get_a_sentence() -> None:
    assert "not known" in refused("udpin:no-such-host.invalid:14550")
    assert "of this computer" in refused("udpin:192.0.2.1:14550")


def test_denied_ports_get_a_sentence() -> None:
    denied = OSError(errno.EACCES, "could not open port: Permission denied")

    def opener(path: str, baud: int):
        raise denied

    source = serial_port("/dev/ttyUSB0:57600", opener)
    with pytest.raises(LinkError, match="to the group"):
        source.open()


@pytest.mark.parametrize(
    ("raised", "words"),
    [
        (  # as pyserial words what Windows says, in the language of the user
            "could not open port 'COM5': PermissionError(13, 'Zugriff verweigert', None, 5)",
            "in use by another program",
        ),
        (
            "could not open port 'COM5': FileNotFoundError(2, 'Nicht gefunden', None, 2)",
            "there is no serial port",
        ),
        (
            "Cannot configure port, something went wrong. Original message: "
            "OSError(22, 'Falscher Parameter.', None, 87)",
            "cannot run at 57600 baud",
        ),
        (
            "ClearCommError failed (PermissionError(13, 'Zugriff verweigert', None, 5))",
            "is gone; plug it in again",
        ),
        (  # as on macOS
            "Could not configure port: (19, 'Operation not supported by device')",
            "is not a serial port",
        ),
    ],
)
def test_what_other_systems_say_of_a_port_gets_its_own_sentence(raised: str, words: str) -> None:
    def opener(path: str, baud: int):
        raise OSError(raised)

    source = serial_port("COM5:57600", opener)
    with pytest.raises(LinkError, match=words):
        source.open()


def test_a_port_of_macos_is_known_by_either_name() -> None:
    assert is_same_port("/dev/tty.usbserial-A1", "/dev/cu.usbserial-A1")
    assert not is_same_port("/dev/tty.usbserial-A1", "/dev/cu.usbserial-A2")
    assert not is_same_port("/dev/ttyUSB0", "/dev/ttyUSB1")
    radio = SimpleNamespace(device="/dev/cu.usbserial-A1", serial_number="A1", vid=1, pid=2)
    opened: list[str] = []

    def opener(path: str, baud: int) -> SimpleNamespace:
        opened.append(path)
        return SimpleNamespace(close=lambda: None)

    source = serial_port("/dev/tty.usbserial-A1:57600", opener, lambda: [radio])
    source.open()
    source._lose("pulled out")
    source.open()
    radio.device = "/dev/cu.usbserial-B7"
    source._lose("pulled out")
    source.open()
    assert opened == ["/dev/tty.usbserial-A1"] * 2 + ["/dev/cu.usbserial-B7"]
    source.close()


def test_whatever_a_serial_driver_raises_is_a_loss_not_a_crash() -> None:
    """Drivers raise more than they say: `termios.error` is no OSError."""

    class Port:
        timeout = 0.0

        def read(self, _count: int) -> bytes:
            raise TypeError("an integer is required")

        def write(self, _data: bytes) -> int:
            raise TypeError("closed meanwhile")

        def close(self) -> None:
            raise TypeError("closed already")

    source = serial_port("/dev/ttyUSB0:57600", lambda _path, _baud: Port())
    source.open()
    source.write(b"sign of life")
    assert "closed meanwhile" in source.unsent
    assert [chunk.data for chunk in source.read(0.01)] == [b""]
    assert "plug it in" in source.state
    source.open()
    assert source.unsent == ""  # nothing was refused by the port that came back
    source.close()


def test_ports_that_cannot_be_listed_do_not_keep_one_from_being_opened() -> None:
    def ports():
        raise TypeError("unsupported operand type(s) for >>: 'NoneType' and 'int'")

    opened = []

    def opener(path: str, _baud: int) -> SimpleNamespace:
        if path == "/dev/ttyUSB9":
            raise OSError(errno.ENOENT, "could not open port")
        opened.append(path)
        return SimpleNamespace(close=opened.clear)

    source = serial_port("/dev/ttyUSB0:57600", opener, ports)
    source.open()
    assert opened == ["/dev/ttyUSB0"]
    source._lose("pulled out")
    assert opened == []
    source.open()
    assert source.connected
    source.close()
    other = serial_port("/dev/ttyUSB9:57600", opener, ports)
    with pytest.raises(LinkUnavailableError, match="/dev/ttyUSB9"):
        other.open()


def test_a_serial_port_is_not_set_up_anew_by_every_read() -> None:
    """Setting the timeout makes the driver do that, on Windows with all its settings."""
    settings = []

    class Port:
        in_waiting = 0

        def __setattr__(self, name: str, value: float) -> None:
            settings.append((name, value))
            super().__setattr__(name, value)

        def read(self, _count: int) -> bytes:
            return b"x"

        def close(self) -> None:
            pass

    port = Port()
    port.timeout = 0
    source = serial_port("/dev/ttyUSB0:57600", lambda _path, _baud: port)
    source.open()
    for timeout in (0.2, 0.2, 0.2, 0.1):
        assert [chunk.data for chunk in source.read(timeout)] == [b"x"]
    assert settings == [("timeout", 0), ("timeout", 0.2), ("timeout", 0.1)]
    source.close()


def test_a_rate_that_a_port_cannot_run_at_gets_a_sentence() -> None:
    def opener(path: str, baud: int):
        raise OSError(errno.EINVAL, "invalid baud rate: 300")

    source = serial_port("/dev/ttyUSB0:300", opener)
    with pytest.raises(LinkError, match="300 baud"):
        source.open()


def two_peers(port) -> tuple[LinkSource, int, list[socket.socket]]:
    number = port(socket.SOCK_DGRAM)
    source = open_source(f"udpin:127.0.0.1:{number}")
    source.open()
    senders = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2)]
    for sender in senders:
        sender.settimeout(5)
    return source, number, senders


def test_several_peers_are_told_apart_and_all_answered(port, frames) -> None:
    source, number, senders = two_peers(port)
    for sender in senders:
        sender.sendto(frames(1)[0], ("127.0.0.1", number))
    chunks = collect(source, 2 * len(frames(1)[0]))
    assert len({chunk.peer for chunk in chunks}) == 2
    source.write(b"both")
    assert [sender.recv(100) for sender in senders] == [b"both", b"both"]
    source.close()
    for sender in senders:
        sender.close()


def test_a_peer_that_cannot_be_reached_is_named_and_the_others_hear(port, monkeypatch) -> None:
    source, number, senders = two_peers(port)
    names = []
    for sender in senders:
        sender.bind(("127.0.0.1", 0))
        sender.sendto(b"here", ("127.0.0.1", number))
        collect(source, 4)
        names.append(sender.getsockname())

    class Refusing:
        def __init__(self, real: socket.socket) -> None:
            self.real = real

        def __getattr__(self, name: str):
            return getattr(self.real, name)

        def sendto(self, data: bytes, peer: tuple[str, int]) -> int:
            if peer == names[0]:
                raise OSError(errno.ENETUNREACH, "Network is unreachable")
            return self.real.sendto(data, peer)

    monkeypatch.setattr(source, "_socket", Refusing(source._socket))
    source.write(b"sign of life")
    assert senders[1].recv(100) == b"sign of life"
    where = f"{names[0][0]}:{names[0][1]}"
    assert source.unsent == f"cannot send to {where} (Network is unreachable)"
    names[0] = None
    source.write(b"again")
    assert senders[0].recv(100) == b"again"
    assert source.unsent == ""
    source.close()
    for sender in senders:
        sender.close()


@pytest.mark.skipif(sys.platform == "win32", reason="Windows lets a program send to all")
def test_what_the_system_refuses_to_send_is_said() -> None:
    source = open_source("udpout:255.255.255.255:14550")
    source.open()
    source.write(b"sign of life")
    assert source.unsent.startswith("cannot send to 255.255.255.255:14550 (")
    source.close()


def test_pymavlink_is_a_peer_both_ways(port) -> None:
    from pymavlink import mavutil

    for kind in ("udpin", "tcpin"):
        protocol = socket.SOCK_DGRAM if kind == "udpin" else socket.SOCK_STREAM
        link = f"{kind}:127.0.0.1:{port(protocol)}"
        source = open_source(link)
        source.open()
        if kind == "udpin":
            # On Windows pymavlink takes the port that it is given for its own end as well.
            peer = mavutil.mavlink_connection("udpout:127.0.0.1:0")
            peer.destination_addr = ("127.0.0.1", source.address.port)
        else:
            peer = mavutil.mavlink_connection(f"tcp:127.0.0.1:{source.address.port}")
        peer.mav.heartbeat_send(1, 3, 0, 0, 4)
        chunks = collect(source, 12)
        frame = b"".join(chunk.data for chunk in chunks)
        assert frame[0] in (0xFD, 0xFE)
        source.write(frame)
        assert peer.recv_match(type="HEARTBEAT", blocking=True, timeout=5) is not None
        peer.close()
        source.close()


def recorded(folder: Path, frames: list[bytes], period_us: int) -> str:
    writer, framer = RawWriter(folder), Framer()
    for index, frame in enumerate(frames):
        writer.append(STAMP + index * period_us, framer.feed(frame) + framer.flush_complete())
    writer.close()
    return str(folder)


@pytest.mark.parametrize(("speed", "seconds"), [(1.0, 9.9), (10.0, 0.99)])
def test_a_recorded_flight_keeps_its_pace(tmp_path: Path, frames, speed, seconds) -> None:
    path = recorded(tmp_path / "flight", frames(100), 100_000)
    clock = FakeClock()
    clock.now = begun = 500.0
    address = LinkAddress(kind="flight", path=path)
    source = open_source(address, clock=clock, speed=speed)
    chunks = []
    while not source.finished:
        chunks += source.read(0.05)
        assert source.connected is not source.finished
    assert b"".join(chunk.data for chunk in chunks) == b"".join(frames(100))
    assert clock.now - begun == pytest.approx(seconds, rel=0.01)
    assert "at its end" in source.state


def test_a_long_pause_of_a_recorded_flight_is_cut(tmp_path: Path, frames) -> None:
    path = recorded(tmp_path / "flight", frames(3), 3_600_000_000)
    address = LinkAddress(kind="flight", path=path)
    clock = FakeClock()
    source = open_source(address, clock=clock, speed=2.0)
    while not source.finished:
        source.read(0.2)
    assert clock.now == pytest.approx(2 * 10.0 / 2.0, rel=0.01)


def test_recorded_lines_are_played_as_lines(tmp_path: Path) -> None:
    writer = RawWriter(tmp_path / "flight")
    writer.append(STAMP, LineFramer().feed(b"1,2,3\n4,5,6\n"))
    writer.close()
    source = open_source(str(tmp_path / "flight"))
    assert received(source, 12) == b"1,2,3\n4,5,6\n"
    assert source.framing == "text"


def test_a_recorded_flight_as_fast_as_it_can(tmp_path: Path, frames) -> None:
    sent = frames(100)
    source = open_source(recorded(tmp_path / "flight", sent, 1_000_000), speed=float("inf"))
    start = time.monotonic()
    assert received(source, sum(map(len, sent))) == b"".join(sent)
    assert time.monotonic() - start < 2.0


def test_what_is_no_record_is_refused_with_a_sentence(tmp_path: Path) -> None:
    assert "no raw record" in refused(str(tmp_path))
    (tmp_path / "notes.txt").write_text("")
    assert ".tlog" in refused(str(tmp_path / "notes.txt"))


def test_a_host_clock_set_back_does_not_send_stamps_back() -> None:
    wall = [1_000_000]
    clock = HostClock(wall_us=lambda: wall[0])
    first = clock.now_us()
    wall[0] -= 500_000
    second = clock.now_us()
    wall[0] += 10
    third = clock.now_us()
    assert first < second < third <= first + 20
    wall[0] += 60_000_000  # and a leap forward is followed
    assert clock.now_us() - third == 60_000_000
    assert clock.correction_us > 0


def test_a_host_clock_with_coarse_ticks_is_not_pushed_ahead() -> None:
    start, tick = STAMP, 16_000
    true = [start]
    clock = HostClock(wall_us=lambda: true[0] // tick * tick)
    stamps = []
    for _ in range(200_000):
        true[0] += 100
        stamps.append(clock.now_us())
    assert all(one < two for one, two in itertools.pairwise(stamps))
    assert abs(stamps[-1] - true[0]) <= tick
    assert clock.correction_us == 0


def test_a_flight_continued_after_the_clock_was_set_back_goes_on_from_its_last_stamp() -> None:
    wall = [STAMP]
    clock = HostClock(after_us=STAMP + 3_600_000_000, wall_us=lambda: wall[0])
    assert clock.now_us() == STAMP + 3_600_000_001
    wall[0] += 10_000
    assert clock.now_us() == STAMP + 3_600_010_000

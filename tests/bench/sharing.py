"""One flight shared with eight clients, one of which never reads: bytes lost, CPU of the recorder.

250 messages a second for SECONDS (60), recorded by a process of its own, first without clients and
then with eight: MAVProxy, pymavlink over TCP and over UDP, a second recorder that joins after a
third of the time, three sockets, and one that never reads. Last, MAVProxy shares the same flight
with eight UDP ports. MAVProxy is installed as for ``peers``.
"""

import os
import random
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path

from gsapp.decoding.dialect import dialect
from gsapp.flight.raw_files import RawTail, read_tlog
from gsapp.telemetry.recorder_control import RecorderHandle, start_recorder
from gsapp.telemetry.stream_server import ShareRequest, request_shares
from tests.bench.peers import install
from tests.bench.sender_process import send_in_real_time, sending
from tests.telemetry.conftest import free_port

RATE = 250


def frames(seconds: float) -> Iterator[tuple[float, bytes]]:
    """Yield frames of an aircraft with their times, s: heartbeats, attitudes, sensors, text."""
    names, chance = dialect(), random.Random(1)
    packer = names.MAVLink(None, srcSystem=1, srcComponent=1)
    for number in range(round(seconds * RATE)):
        values = [chance.uniform(-1.0, 1.0) for _ in range(6)]
        counts = [round(1000 * value) for value in values]
        if number % RATE == 0:
            message = names.MAVLink_heartbeat_message(1, 3, 0, 0, 4, 3)
        elif number % 2:
            message = names.MAVLink_attitude_message(number * 4, *values)
        else:
            message = names.MAVLink_scaled_imu2_message(number * 4, *counts, 0, 0, 0)
        yield number / RATE, bytes(message.pack(packer))
        packer.seq = (packer.seq + 1) % 256


class SocketClient(threading.Thread):
    """Reads all that a TCP share sends."""

    def __init__(self, port: int) -> None:
        super().__init__(daemon=True)
        self.received = b""
        self._socket = socket.create_connection(("127.0.0.1", port))
        self.start()

    def run(self) -> None:
        parts = []
        while data := self._socket.recv(65536):
            parts.append(data)
        self.received = b"".join(parts)


class PymavlinkClient(threading.Thread):
    """Reads messages by pymavlink until all came, or none for a while."""

    def __init__(self, link: str, expected: int) -> None:
        super().__init__(daemon=True)
        os.environ["MAVLINK20"] = "1"
        from pymavlink import mavutil

        self.count, self._expected = 0, expected
        self._link = mavutil.mavlink_connection(link, dialect="all")
        self.start()

    def run(self) -> None:
        while self.count < self._expected and self._link.recv_match(blocking=True, timeout=30.0):
            self.count += 1


def cpu_seconds(pid: int) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def wait_until_recorded(folder: Path, count: int) -> list[bytes]:
    tail, found, deadline = RawTail(folder), [], time.monotonic() + 20.0
    while len(found) < count and time.monotonic() < deadline:
        found += [record.data for record in tail.poll()]
        time.sleep(0.1)
    return found


def core_share(pid: int, port: int, seconds: float) -> float:
    """Send frames to a port; return the share of a core that a process used meanwhile."""
    with sending(__file__, port, seconds) as sender:
        time.sleep(2.0)
        begin, used = time.monotonic(), cpu_seconds(pid)
        time.sleep(seconds - 4.0)
        share = (cpu_seconds(pid) - used) / (time.monotonic() - begin)
        sender.wait()
    return share


def fly(recorder: RecorderHandle, port: int, seconds: float) -> tuple[float, list[bytes]]:
    """Send frames; return the share of a core that the recorder used, and what it recorded."""
    share = core_share(recorder.pid, port, seconds)
    return share, wait_until_recorded(recorder.folder, round(seconds * RATE))


def tell_recorded(recorded: list[bytes], sent: list[bytes], share: float) -> None:
    lost = sum(map(len, sent)) - sum(map(len, recorded))
    same = "the same bytes" if recorded == sent else "OTHER BYTES"
    print(f"  recorded {len(recorded):,} of {len(sent):,} messages, {same}, {lost} bytes lost")
    print(f"  CPU of the recorder: {100 * share:.1f} % of a core")


def main(seconds: str = "60", *_: str) -> None:
    """Record alone, then with eight clients."""
    span = float(seconds)
    sent = [frame for _, frame in frames(span)]
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        os.environ["GSAPP_RUNTIME_FOLDER"] = str(folder / "run")
        environment = install(folder / "site")
        port = free_port(socket.SOCK_DGRAM)
        print(f"{RATE} messages/s for {span:.0f} s, without clients")
        recorder = start_recorder(f"udpin:127.0.0.1:{port}", folder / "alone")
        share, recorded = fly(recorder, port, span)
        recorder.stop()
        tell_recorded(recorded, sent, share)
        fly_shared(folder, environment, port, span, sent)
        fly_mavproxy(folder, environment, port, span, sent)


def start_mavproxy(
    folder: Path, environment: dict[str, str], *links: str
) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [
            sys.executable, str(folder / "site/bin/mavproxy.py"), *links,
            "--daemon", "--non-interactive", f"--state-basedir={folder}",
            f"--logfile={folder / 'proxy.tlog'}", "--streamrate=-1", "--default-modules=",
        ],
        cwd=folder, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip


def stop_mavproxy(proxy: subprocess.Popen[bytes]) -> None:
    proxy.send_signal(signal.SIGINT)
    try:
        proxy.wait(timeout=10)
    except subprocess.TimeoutExpired:
        proxy.kill()


class PortClient(threading.Thread):
    """Counts the messages that come to a UDP port until none came for a while."""

    def __init__(self, known: set[bytes]) -> None:
        super().__init__(daemon=True)
        self.count, self._known = 0, known
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", 0))
        self._socket.settimeout(10.0)
        self.port = self._socket.getsockname()[1]

    def run(self) -> None:
        while True:
            try:
                self.count += self._socket.recv(65536) in self._known
            except TimeoutError:
                return


def fly_mavproxy(
    folder: Path, environment: dict[str, str], port: int, span: float, sent: list[bytes]
) -> None:
    print("shared by MAVProxy with eight UDP ports")
    clients = [PortClient(set(sent)) for _ in range(8)]
    outs = (f"--out=udpout:127.0.0.1:{client.port}" for client in clients)
    proxy = start_mavproxy(folder, environment, f"--master=udpin:127.0.0.1:{port}", *outs)
    time.sleep(5.0)  # until it listens
    for client in clients:
        client.start()
    share = core_share(proxy.pid, port, span)
    for client in clients:
        client.join()
    stop_mavproxy(proxy)
    print(f"  messages received: {', '.join(f'{client.count:,}' for client in clients)}")
    print(f"  CPU of MAVProxy: {100 * share:.1f} % of a core")


def fly_shared(
    folder: Path, environment: dict[str, str], port: int, span: float, sent: list[bytes]
) -> None:
    tcp, udp = free_port(socket.SOCK_STREAM), free_port(socket.SOCK_DGRAM)
    recorder = start_recorder(f"udpin:127.0.0.1:{port}", folder / "shared")
    links = (f"tcpin:127.0.0.1:{tcp}", f"udpout:127.0.0.1:{udp}")
    request_shares(recorder.folder, ShareRequest(links=links))
    while len(recorder.status().shares) < len(links):
        time.sleep(0.1)
    print("with MAVProxy, pymavlink over TCP and UDP, a late recorder, three sockets, one stuck")
    stuck = socket.socket()
    stuck.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    stuck.connect(("127.0.0.1", tcp))
    proxy = start_mavproxy(folder, environment, f"--master=tcp:127.0.0.1:{tcp}")
    by_tcp = PymavlinkClient(f"tcp:127.0.0.1:{tcp}", len(sent))
    by_udp = PymavlinkClient(f"udpin:127.0.0.1:{udp}", len(sent))
    sockets = [SocketClient(tcp) for _ in range(3)]
    while len(recorder.status().shares[0].clients) < 6:
        time.sleep(0.1)
    copies: list[RecorderHandle] = []
    joining = threading.Timer(
        span / 3, lambda: copies.append(start_recorder(f"gsapp:127.0.0.1:{tcp}", folder / "copy"))
    )
    joining.start()
    share, recorded = fly(recorder, port, span)
    copied = wait_until_recorded(folder / "copy", len(sent))
    time.sleep(2.0)
    status = recorder.status()
    stop_mavproxy(proxy)
    for client in (by_tcp, by_udp):
        client.join(timeout=40.0)
    recorder.stop()
    copies[0].stop()
    for client in sockets:
        client.join(timeout=10.0)
    tell_recorded(recorded, sent, share)
    same = (folder / "copy/raw.tlog").read_bytes() == (folder / "shared/raw.tlog").read_bytes()
    print(f"  late recorder: {len(copied):,} messages, the same file: {same}")
    whole = [client.received == b"".join(sent) for client in sockets]
    print(f"  sockets that received the same bytes: {sum(whole)} of {len(whole)}")
    print(f"  pymavlink over TCP: {by_tcp.count:,} messages, over UDP: {by_udp.count:,}")
    logged = [one.data for one in read_tlog(folder / "proxy.tlog")]
    known = set(sent)
    own = [one for one in logged if one in known]
    print(f"  MAVProxy logged {len(own):,} of them (and {len(logged) - len(own)} others)")
    for one in status.shares:
        print(f"  {one.describe()}; {one.sent_bytes:,} bytes sent, {one.dropped_bytes:,} dropped")
    stuck.close()


if __name__ == "__main__":
    send_in_real_time(int(sys.argv[2]), frames(float(sys.argv[3])))

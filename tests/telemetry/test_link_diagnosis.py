"""The LINK grammar; wrong ports, rates and kinds of link: what the recorder and a test find."""

import os
import pty
import random
import socket
import sys
import threading
import time
import tty
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gsapp.cli.record import record
from gsapp.decoding.dialect import dialect
from gsapp.flight.file_names import STATUS_FILE, STOP_FILE
from gsapp.foundation import LinkError
from gsapp.telemetry.link_diagnosis import LinkTest, diagnose_link
from gsapp.telemetry.link_kinds import LinkAddress, describe_port
from gsapp.telemetry.link_registry import parse_link
from gsapp.telemetry.recorder_process import record_link
from gsapp.telemetry.recorder_status import RecorderStatus


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("udpin:0.0.0.0:14550", LinkAddress(kind="udpin", host="0.0.0.0", port=14550)),  # noqa: S104
        ("udpin:14550", LinkAddress(kind="udpin", host="127.0.0.1", port=14550)),
        ("udpin::14550", LinkAddress(kind="udpin", host="127.0.0.1", port=14550)),
        ("udpout:field-pc:14551", LinkAddress(kind="udpout", host="field-pc", port=14551)),
        ("tcp:10.1.2.3:5760", LinkAddress(kind="tcp", host="10.1.2.3", port=5760)),
        ("tcpin:[::1]:5760", LinkAddress(kind="tcpin", host="::1", port=5760)),
        ("serial:/dev/ttyUSB0:57600", LinkAddress(kind="serial", path="/dev/ttyUSB0", baud=57600)),
        ("serial:COM3:115200", LinkAddress(kind="serial", path="COM3", baud=115200)),
        ("text:/dev/ttyACM0:9600", LinkAddress(kind="text", path="/dev/ttyACM0", baud=9600)),
        (" virtual ", LinkAddress(kind="virtual")),
    ],
)
def test_every_form_is_read(text: str, address: LinkAddress) -> None:
    assert parse_link(text) == address
    assert parse_link(str(address)) == address


def test_a_path_that_exists_is_a_flight(tmp_path: Path) -> None:
    assert parse_link(str(tmp_path)) == LinkAddress(kind="flight", path=str(tmp_path))


@pytest.mark.parametrize(
    ("text", "remedy"),
    [
        ("", "a link is missing; write udpin:HOST:PORT"),
        ("udpin", "write for example udpin:127.0.0.1:14550"),
        ("udpin:localhost", "udpin:localhost:14550"),
        ("udpin:localhost:70000", "1 to 65535, usually 14550"),
        ("tcp:a b:5760", "not a host name"),
        ("udp:localhost:14550", "did you mean 'udpi?n?o?u?t?:localhost:14550'"),
        ("seriel:/dev/ttyUSB0:57600", "did you mean 'serial:/dev/ttyUSB0:57600'"),
        ("serial:/dev/ttyUSB0", "serial:/dev/ttyUSB0:57600"),
        ("serial:/dev/ttyUSB0:1", "300 to 12000000, usually 57600"),
        ("udpin:localhost:²", "'²' is not a whole number; write for example udpin:localhost:14550"),
        ("udpin:localhost:" + "9" * 5000, "1 to 65535"),
        ("serial:/dev/ttyUSB0:5760²", "is not a whole number"),
        ("x" * 300, "; write udpin:HOST:PORT"),
        ("flights/none", "neither a link nor a flight that exists"),
    ],
)
def test_every_mistake_names_its_remedy(text: str, remedy: str) -> None:
    with pytest.raises(LinkError, match=remedy.replace("(", r"\(")):
        parse_link(text)


@given(st.text(max_size=40).filter(lambda text: "\0" not in text and not Path(text).exists()))
def test_any_text_is_a_link_or_gets_a_sentence(text: str) -> None:
    try:
        address = parse_link(text)
    except LinkError:
        return
    assert parse_link(str(address)) == address


if sys.platform == "win32":
    pytest.skip("Windows has no pseudo-terminals", allow_module_level=True)

TEXT = b"12.50,0.31,-1.7,220\r\n" * 40
HEARTBEAT = bytes(
    dialect().MAVLink_heartbeat_message(1, 3, 0, 0, 4, 3).pack(dialect().MAVLink(None, 1, 1))
)
NOISE = random.Random(3).randbytes(900)


@pytest.fixture
def port() -> Iterator[tuple[int, str]]:
    inner, outer = pty.openpty()
    tty.setraw(outer)
    yield inner, os.ttyname(outer)
    os.close(inner)
    os.close(outer)


def listened(link: str, until: Callable[[LinkTest], object], sent: Callable[[], Any]) -> LinkTest:
    test = LinkTest(link)
    deadline = time.monotonic() + 10.0
    while not until(test):
        assert time.monotonic() < deadline
        sent()
        time.sleep(0.05)
    return test


@pytest.mark.parametrize(
    ("kind", "sends", "problem", "words"),
    [
        ("serial", b"", "no-data", "57,600 baud"),
        ("text", b"", "no-data", "57,600 baud"),
        ("serial", NOISE, "unreadable", "baud is probably wrong"),
        ("text", NOISE, "unreadable", "baud is probably wrong"),
        ("serial", TEXT, "text", "text:"),
        ("text", b"mavlink", "mavlink", "serial:"),
        ("serial", b"mavlink", None, ""),
        ("text", TEXT, None, ""),
    ],
)
def test_what_comes_over_a_serial_port_is_told(
    port: tuple[int, str], kind: str, sends: bytes, problem: str | None, words: str
) -> None:
    inner, path = port
    data = 20 * HEARTBEAT if sends == b"mavlink" else sends

    def sent() -> None:
        if data:
            os.write(inner, data)

    def known(test: LinkTest) -> bool:
        found, report = test.diagnosis(), test.report()
        if problem is None:
            return bool(report.vehicles or report.lines)
        return found is not None and found.problem == problem

    test = listened(f"{kind}:{path}:57600", known, sent)
    found = test.diagnosis()
    test.close()
    if problem is not None:
        assert path in found.found
        assert words in str(found)
    else:
        assert found is None


def test_ports_on_the_network_are_named_with_what_to_try() -> None:
    def status(link: str, **values: Any) -> RecorderStatus:
        given = {
            "pid": 1, "link": link, "folder": "", "state": "recording", "started_us": 0,
            "updated_us": 40_000_000, "connected": True,
        }  # fmt: skip
        return RecorderStatus(**{**given, **values})

    local = diagnose_link(status("udpin:127.0.0.1:14551"))
    assert "UDP port 14551" in local.found
    assert "udpin:0.0.0.0:14551" in local.remedy
    everywhere = diagnose_link(status("tcpin:0.0.0.0:5760"))
    assert "firewall" in everywhere.remedy
    assert diagnose_link(status("virtual")) is None
    assert (
        diagnose_link(status("udpin:127.0.0.1:14550", received_bytes=9, content="mavlink")) is None
    )


def test_a_refused_connection_is_told_with_its_cause() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as taken:
        taken.bind(("127.0.0.1", 0))  # bound, but nobody listens
        number = taken.getsockname()[1]
        test = listened(
            f"tcp:127.0.0.1:{number}", lambda test: "refuses" in str(test.diagnosis()), int
        )
        found = test.diagnosis()
        test.close()
    assert found.problem == "closed"
    assert f"port {number}" in found.found


def test_a_port_that_cannot_be_opened_is_refused_at_once(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    test = listened(f"serial:{tmp_path / 'file'}:57600", lambda test: test.open_error, int)
    test.close()
    assert "not a serial port" in str(test.diagnosis())


def test_a_port_tells_what_its_usb_device_is() -> None:
    port = SimpleNamespace(
        device="/dev/ttyUSB0", description="FT231X USB UART", manufacturer="FTDI",
        serial_number="D30GZ7",
    )  # fmt: skip
    assert describe_port(port) == "/dev/ttyUSB0 (FT231X USB UART, FTDI, serial number D30GZ7)"
    assert describe_port(SimpleNamespace(device="/dev/ttyS0", description="n/a")) == "/dev/ttyS0"


@pytest.mark.long
def test_recording_without_a_window_says_what_is_wrong(
    port: tuple[int, str],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("gsapp.cli.record._FIRST_DIAGNOSIS", 1.0)
    _inner, path = port
    folder = tmp_path / "flight"

    def stop() -> None:
        while not (folder / STATUS_FILE).exists():
            time.sleep(0.05)
        time.sleep(3.0)
        (folder / STOP_FILE).touch()

    threading.Thread(target=stop, daemon=True).start()
    record(f"serial:{path}:57600", folder, channel_map="ardupilot-plane", aircraft="b777")
    text = " ".join(capsys.readouterr().out.split())
    assert f"{path} (57,600 baud)" in text
    assert "aircraft is on" in text


def test_the_recorder_tells_what_came_last(
    port: tuple[int, str], tmp_path: Path, frames: Callable[..., list[bytes]]
) -> None:
    inner, path = port
    stop, seen = threading.Event(), []

    def look(status: RecorderStatus) -> None:
        seen.append(status.content)
        if len(seen) == 1:
            os.write(inner, b"".join(frames(60)))
        elif status.content == "mavlink":
            for _ in range(5):
                os.write(inner, NOISE)
        if "unreadable" in seen or len(seen) > 20:
            stop.set()

    record_link(parse_link(f"serial:{path}:57600"), tmp_path, stop=stop, on_status=look)
    assert seen.index("mavlink") < seen.index("unreadable")

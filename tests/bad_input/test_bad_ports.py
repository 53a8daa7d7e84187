"""Ports that are taken or go away, through ``gsapp record`` as a process."""

import os
import signal
import socket
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from gsapp.flight.raw_files import RawTail
from tests.bad_input.bad_input_kit import GSAPP, Box, refused, wait_for

POSIX = pytest.mark.skipif(sys.platform == "win32", reason="no pseudo-terminals there")


@pytest.mark.parametrize(
    ("kind", "link", "protocol"),
    [(socket.SOCK_DGRAM, "udpin", "UDP"), (socket.SOCK_STREAM, "tcpin", "TCP")],
)
def test_a_network_port_in_use(
    tmp_path: Path, kind: socket.SocketKind, link: str, protocol: str
) -> None:
    with socket.socket(socket.AF_INET, kind) as taken:
        taken.bind(("127.0.0.1", 0))
        if kind == socket.SOCK_STREAM:
            taken.listen()
        port = taken.getsockname()[1]
        sentence = refused(
            ("record", f"{link}:127.0.0.1:{port}", "--out", "flights/new"), cwd=tmp_path
        )
    assert f"{protocol} port {port}" in sentence
    assert "another port" in sentence


@POSIX
def test_a_serial_port_in_use(tmp_path: Path) -> None:
    import serial

    master, slave = os.openpty()
    path = os.ttyname(slave)
    try:
        with serial.Serial(path, 57600, exclusive=True):
            refused(
                ("record", f"serial:{path}:57600", "--out", "new"),
                f"{path} is in use by another program; close that",
                cwd=tmp_path,
            )
    finally:
        os.close(master)
        os.close(slave)


@POSIX
def test_a_file_that_is_no_serial_port(tmp_path: Path) -> None:
    refused(
        ("record", "serial:/dev/null:57600", "--out", "new"),
        "/dev/null is not a serial port; choose one",
        cwd=tmp_path,
    )


@POSIX
def test_a_port_that_vanishes_and_comes_back(tmp_path: Path) -> None:
    """What came before and after is recorded by one recorder, which tells of both changes."""
    box, link = Box(), tmp_path / "radio"
    before = [box.array(1_000_000 + 10_000 * k) for k in range(20)]
    after = [box.array(3_000_000 + 10_000 * k) for k in range(20)]
    folder = tmp_path / "flight"

    def plug_in() -> tuple[int, int]:
        ends = os.openpty()
        link.unlink(missing_ok=True)
        link.symlink_to(os.ttyname(ends[1]))
        return ends

    master, slave = plug_in()
    command = [*GSAPP, "record", f"serial:{link}:57600", "--out", str(folder)]
    recorder = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, encoding="utf-8",
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )  # fmt: skip
    said: list[str] = []
    listening = threading.Thread(target=lambda: said.extend(recorder.stdout or ()), daemon=True)
    listening.start()
    tail, kept = RawTail(folder), bytearray()

    def recorded(count: int) -> bool:
        for record in tail.poll():
            kept.extend(record.data)
        return len(kept) >= count

    def told(word: str) -> bool:
        return any(word in line for line in said)

    wait_for(lambda: told(": open"))
    os.write(master, b"".join(before))
    wait_for(lambda: recorded(len(b"".join(before))))
    os.close(slave)
    os.close(master)
    link.unlink()
    wait_for(lambda: told("plug it in"))
    said_before = len(said)
    master, slave = plug_in()
    wait_for(lambda: any(": open" in line for line in said[said_before:]))
    os.write(master, b"".join(after))
    wait_for(lambda: recorded(len(b"".join(before + after))))
    recorder.send_signal(signal.SIGINT)
    assert recorder.wait(30) == 0
    listening.join(10)
    os.close(slave)
    os.close(master)
    assert bytes(kept) == b"".join(before + after)
    assert not told("Traceback")
    assert any("Recorded 40 frames" in line for line in said)

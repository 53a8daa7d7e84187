"""What the tests of links and recorder share: frames, free ports, patience."""

import os
import random
import socket
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from gsapp.decoding.dialect import dialect


def make_frames(count: int, *, seed: int = 0, system: int = 1) -> list[bytes]:
    module, choose = dialect(), random.Random(seed)
    packer = module.MAVLink(None, srcSystem=system)
    frames = []
    for number in range(count):
        if number % 3:
            angles = [choose.uniform(-1.0, 1.0) for _ in range(6)]
            message = module.MAVLink_attitude_message(number, *angles)
        else:
            message = module.MAVLink_statustext_message(6, f"message {number}".encode())
        frames.append(bytes(message.pack(packer, force_mavlink1=number % 2 == 1)))
        packer.seq = (packer.seq + 1) % 256
    return frames


def free_port(kind: socket.SocketKind) -> int:
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def wait_until(condition: Callable[[], object], seconds: float = 30.0) -> object:
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        if value := condition():
            return value
        time.sleep(0.005)
    raise AssertionError(f"{condition} did not come true in {seconds} s")


@pytest.fixture
def frames() -> Callable[..., list[bytes]]:
    return make_frames


@pytest.fixture
def port() -> Callable[[socket.SocketKind], int]:
    return free_port


@pytest.fixture
def patience() -> Callable[..., object]:
    return wait_until


@pytest.fixture
def own_runtime(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "runtime"
    monkeypatch.setenv("GSAPP_RUNTIME_FOLDER", str(folder))
    return folder


@pytest.fixture
def real_log() -> Path:
    given = os.environ.get("GSAPP_SHARED_DATA")
    folder = Path(given) if given else Path(__file__).parents[3] / "shared" / "data"
    path = folder / "alfa_carbonz_engine_failure.tlog"
    if not path.is_file():
        pytest.skip(f"the real flight is not at {path}")
    return path

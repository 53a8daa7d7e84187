"""What the tests of sessions share: an aircraft's stream, a recorder to take it, patience."""

import math
import socket
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from gsapp.decoding.dialect import dialect
from gsapp.telemetry.recorder_control import RecorderHandle, start_recorder


class Box:
    """The frames of an aircraft's box: volts at 100 Hz, attitude at 50 Hz, a heartbeat."""

    def __init__(self) -> None:
        self._module = dialect()
        self._packer = self._module.MAVLink(None, srcSystem=1, srcComponent=1)

    def _pack(self, message: object) -> bytes:
        frame = bytes(message.pack(self._packer))
        self._packer.seq = (self._packer.seq + 1) % 256
        return frame

    def say(self, text: str) -> bytes:
        return self._pack(self._module.MAVLink_statustext_message(6, text.encode()))

    def tick(self, k: int) -> list[bytes]:
        """Return the frames of one hundredth of a second."""
        module = self._module
        volts = [2.5 + 0.5 * math.sin(0.01 * k * (1 + number)) for number in range(20)]
        volts[18], volts[19] = 5.0, 2.4
        frames = [
            self._pack(
                module.MAVLink_debug_float_array_message(
                    1_000_000 + 10_000 * k, b"daq", 0, volts + [0.0] * 38
                )
            )
        ]
        if k % 2 == 0:
            angles = (0.1 * math.sin(0.01 * k), 0.02, 0.5, 0.0, 0.0, 0.0)
            frames.append(self._pack(module.MAVLink_attitude_message(1000 + 10 * k, *angles)))
        if k % 100 == 0:
            frames.append(self._pack(module.MAVLink_heartbeat_message(1, 0, 0, 0, 4, 3)))
        return frames


class Aircraft:
    """Sends a box's frames over UDP."""

    def __init__(self, port: int) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._target = ("127.0.0.1", port)
        self._box = Box()
        self.k = 0
        self.sent = 0

    def send(self, ticks: int) -> None:
        for _ in range(ticks):
            for frame in self._box.tick(self.k):
                self._socket.sendto(frame, self._target)
                self.sent += 1
            self.k += 1
            if self.k % 10 == 0:
                time.sleep(0.005)

    def close(self) -> None:
        self._socket.close()


class Field:
    """A recorder in its own process on a UDP port, and the aircraft that sends to it."""

    def __init__(self, folder: Path) -> None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = probe.getsockname()[1]
        self.folder = folder
        self.recorder: RecorderHandle | None = None
        self.aircraft = Aircraft(self.port)

    def record(self) -> RecorderHandle:
        self.recorder = start_recorder(f"udpin:127.0.0.1:{self.port}", self.folder)
        return self.recorder

    def close(self) -> None:
        self.aircraft.close()
        if self.recorder is not None:
            self.recorder.stop()


def wait_until(condition: Callable[[], object], seconds: float = 30.0) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, f"{condition} did not come true in {seconds} s"
        time.sleep(0.002)


@pytest.fixture
def box() -> Box:
    return Box()


@pytest.fixture
def patience() -> Callable[..., None]:
    return wait_until


@pytest.fixture
def field(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Field]:
    monkeypatch.setenv("GSAPP_RUNTIME_FOLDER", str(tmp_path / "runtime"))
    place = Field(tmp_path / "flight")
    yield place
    place.close()

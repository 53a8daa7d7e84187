"""What these tests share: the command line as a process, its sentences, and a box that sends."""

import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from struct import pack

import pytest
from fastcrc.crc16 import mcrf4xx

from calibration import load_certificates
from gsapp.decoding.dialect import dialect
from tests.cli.command_kit import gsapp

GSAPP = (sys.executable, "-m", "gsapp.cli")
UNKNOWN_ID = 15_000_000
_ARRAY = ("elevator_left", "elevator_right", "aileron_left", "aileron_right", "rudder", "alpha",
          "beta", "p", "q", "r")  # fmt: skip


def everything_in(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes() if path.is_file() else b""
        for path in folder.rglob("*")
    }


def refused(
    call: tuple[str, ...],
    *words: str,
    cwd: Path,
    before: Callable[[], None] | None = None,
    environment: dict[str, str] | None = None,
) -> str:
    """Run a command that cannot be done; return its one sentence.

    It ends with exit code 1, without a stack trace, and leaves every file as it was. Mistakes in
    a file are one sentence per mistake, each on a line of its own under the name of the file.
    """
    there = everything_in(cwd)
    if before is None and environment is None:
        done = gsapp(*call, folder=cwd)
    else:
        done = subprocess.run(
            [*GSAPP, *call], capture_output=True, encoding="utf-8", timeout=240, cwd=cwd,
            env=environment, preexec_fn=before,
        )  # fmt: skip
    assert done.returncode == 1, done.stderr
    assert "Traceback" not in done.stdout + done.stderr
    assert done.stdout.strip() == ""
    lines = done.stderr.strip().splitlines()
    assert lines[0].startswith("gsapp: ")
    if lines[0].endswith(("problem", "problems")):
        assert len(lines) - 1 == int(lines[0].split()[-2])
        assert all(line.startswith("  ") for line in lines[1:])
    else:
        assert len(lines) == 1, done.stderr
    for word in words:
        assert word in done.stderr
    assert everything_in(cwd) == there
    return done.stderr


def wait_for(condition: Callable[[], object], seconds: float = 120.0) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, f"{condition} did not come true in {seconds} s"
        time.sleep(0.01)


def without_rights() -> None:
    if os.geteuid() == 0:
        import ctypes

        drop_from_bounding_set = 24
        for override in (1, 2):  # CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH
            if ctypes.CDLL(None).prctl(drop_from_bounding_set, override, 0, 0, 0):
                os._exit(99)


def use_reader(monkeypatch: pytest.MonkeyPatch, folder: Path, body: str) -> None:
    """Let the process read with a function of this body."""
    lines = "".join(f"    {line}\n" for line in body.splitlines())
    (folder / "sitecustomize.py").write_text(
        "import os, signal, sys, time, types\n"
        f"def read_mat_content(path, limit, progress):\n{lines}"
        "sys.modules['gsapp.flight.readers.mat_file'] = sys.modules[__name__]\n"
    )
    former = os.environ.get("PYTHONPATH", "")
    monkeypatch.setenv("PYTHONPATH", f"{folder}{os.pathsep}{former}")


def use_endless_reader(monkeypatch: pytest.MonkeyPatch, folder: Path) -> Path:
    """Let the process read half and go on; return the file that will hold its number."""
    note = folder / "pid"
    use_reader(
        monkeypatch, folder,
        f"open({str(note)!r}, 'w').write(str(os.getpid()))\nprogress(0.5)\ntime.sleep(600)",
    )  # fmt: skip
    return note


def is_running(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except OSError:
        return False
    return True


class Box:
    """The box of the B777: one array of volts, and an attitude."""

    def __init__(self, system: int = 1, alpha: float = 0.05) -> None:
        self._names = dialect()
        self._packer = self._names.MAVLink(None, srcSystem=system, srcComponent=1)
        certificates = load_certificates("b777")
        volts = [float(certificates[name].volts(alpha)) for name in _ARRAY]
        self._data = [*volts, *[2.5] * 10, *[0.0] * 38]

    def array(self, time_us: int) -> bytes:
        return self._pack(
            self._names.MAVLink_debug_float_array_message(time_us, b"daq", 0, self._data)
        )

    def attitude(self, time_ms: int, *, old: bool = False) -> bytes:
        angles = (0.1, 0.2, 0.3, 0.0, 0.0, 0.0)
        return self._pack(self._names.MAVLink_attitude_message(time_ms, *angles), old=old)

    def pressure(self, time_ms: int) -> bytes:
        return self._pack(self._names.MAVLink_scaled_pressure_message(time_ms, 980.0, 1.0, 1500))

    def _pack(self, message: object, *, old: bool = False) -> bytes:
        frame = bytes(message.pack(self._packer, force_mavlink1=old))  # type: ignore[attr-defined]
        self._packer.seq = (self._packer.seq + 1) % 256
        return frame


def foreign(frame: bytes) -> bytes:
    body = frame[1:-2]
    return frame[:1] + body + pack("<H", mcrf4xx(body + b"\x63"))


def unknown(sequence: int) -> bytes:
    body = bytes((9, 0, 0, sequence % 256, 1, 7)) + UNKNOWN_ID.to_bytes(3, "little") + b"123456789"
    return b"\xfd" + body + pack("<H", mcrf4xx(body + b"\x4d"))

"""Bad streams over a real socket: all of it is recorded, and the replay says what was wrong."""

import json
import random
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from time import sleep
from typing import Any

import pytest

from gsapp.flight.file_names import STOP_FILE
from gsapp.flight.raw_files import RawTail
from tests.bad_input.bad_input_kit import GSAPP, UNKNOWN_ID, Box, foreign, unknown, wait_for

FRAMES = 200


def damaged() -> Iterator[bytes]:
    box, choose = Box(), random.Random(1)
    for k in range(FRAMES):
        frame = box.array(1_000_000 + 10_000 * k)
        yield frame[:50] if k % 10 == 5 else frame + choose.randbytes(40 if k % 10 == 0 else 0)


def noise() -> Iterator[bytes]:
    choose = random.Random(2)
    for _ in range(FRAMES):
        yield choose.randbytes(50)


def strange() -> Iterator[bytes]:
    box = Box()
    for k in range(FRAMES):
        yield box.array(1_000_000 + 10_000 * k) + box.attitude(1000 + 10 * k, old=k % 2 == 0)
        yield foreign(box.pressure(1000 + 10 * k))
        if k % 10 == 0:
            yield unknown(k // 10)


def backwards() -> Iterator[bytes]:
    one, other = Box(1, 0.05), Box(2, 0.15)
    for k in range(FRAMES):
        begun = 20_000_000 if k < FRAMES // 2 else 500_000 - 10_000 * FRAMES // 2
        yield one.array(begun + 10_000 * k) + other.array(7_000_000 + 10_000 * k)


STREAMS = (damaged, noise, strange, backwards)


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    sent: bytes
    kept: bytes
    said: str
    code: int
    summary: dict[str, Any]

    @property
    def frames(self) -> dict[str, int]:
        return self.summary["frames"]

    def channel(self, name: str) -> dict[str, Any]:
        return self.summary["channels"][name]


def attempt(stream: Any, folder: Path) -> Trial:
    """Record a stream over UDP, end the recorder (as Ctrl-C does, where it can be sent), replay."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    command = [*GSAPP, "record", f"udpin:127.0.0.1:{port}", "--out", str(folder)]
    recorder = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    wait_for((folder / "recorder.json").exists)
    sent = list(stream())
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        for data in sent:
            sender.sendto(data, ("127.0.0.1", port))
            sleep(0.001)
    sleep(0.1)
    if sys.platform == "win32":
        (folder / STOP_FILE).touch()
    else:
        recorder.send_signal(signal.SIGINT)
    text, _ = recorder.communicate(timeout=120)
    assert recorder.returncode == 0, text
    assert b"Traceback" not in text
    kept = [record.data for record in RawTail(folder).poll()]
    command = [*GSAPP, "replay", str(folder), "--headless", "--json", str(folder / "sum.json")]
    done = subprocess.run(command, capture_output=True, encoding="utf-8", timeout=240)
    assert "Traceback" not in done.stderr
    made = folder / "sum.json"
    summary = json.loads(made.read_text()) if made.exists() else {}
    return Trial(
        sent=b"".join(sent),
        kept=b"".join(kept),
        said=done.stdout + done.stderr,
        code=done.returncode,
        summary=summary,
    )


@pytest.fixture(scope="module")
def trials(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    place = tmp_path_factory.mktemp("links")
    with ThreadPoolExecutor(2) as pool:
        running = {
            stream.__name__: pool.submit(attempt, stream, place / stream.__name__)
            for stream in STREAMS
        }
        yield lambda name: running[name].result()


@pytest.mark.parametrize("name", [stream.__name__ for stream in STREAMS])
def test_every_byte_is_recorded(trials: Any, name: str) -> None:
    trial = trials(name)
    assert len(trial.kept) == len(trial.sent)
    assert sorted(trial.kept) == sorted(trial.sent)


def test_garbage_between_frames_costs_no_frame(trials: Any) -> None:
    trial = trials("damaged")
    assert trial.code == 0
    assert trial.frames["good"] == FRAMES * 9 // 10
    assert trial.frames["damaged"] >= FRAMES // 10
    assert f"frames: {FRAMES * 9 // 10} good, {trial.frames['damaged']} damaged" in trial.said


def test_truncated_frames_cost_only_themselves(trials: Any) -> None:
    trial = trials("damaged")
    assert trial.frames["lost"] == FRAMES // 10
    assert trial.channel("alpha")["count"] >= FRAMES * 9 // 10


def test_noise_alone_is_told_as_such(trials: Any) -> None:
    trial = trials("noise")
    assert trial.code == 1
    assert "MAVLink frame" in trial.said
    assert "baud rate" in trial.said
    assert trial.said.strip().count("\n") == 0


def test_both_versions_of_mavlink_are_read_side_by_side(trials: Any) -> None:
    trial = trials("strange")
    assert trial.code == 0
    assert trial.frames["good"] == 2 * FRAMES
    assert trial.channel("alpha")["count"] == FRAMES
    assert trial.channel("phi")["count"] == FRAMES


def test_another_dialect_is_named(trials: Any) -> None:
    trial = trials("strange")
    assert "static_pressure.2" not in trial.summary["channels"]
    assert "SCALED_PRESSURE" in trial.said
    assert "another dialect" in trial.said


def test_an_unknown_message_is_named(trials: Any) -> None:
    trial = trials("strange")
    assert trial.frames["unknown"] == FRAMES // 10
    assert f"UNKNOWN_{UNKNOWN_ID}" in trial.said


def test_a_clock_that_runs_backwards_is_told(trials: Any) -> None:
    trial = trials("backwards")
    assert trial.code == 0
    assert "21.0 to 0.5 s" in trial.said
    assert trial.frames["good"] == 2 * FRAMES
    assert trial.channel("alpha")["count"] >= FRAMES - 1
    assert trial.summary["duration"] >= 0.01 * (FRAMES - 2)


def test_two_aircraft_are_told_apart(trials: Any) -> None:
    trial = trials("backwards")
    assert "system 2" in trial.said
    assert "system = 2" in trial.said
    alpha = trial.channel("alpha")
    assert alpha["max"] == pytest.approx(0.05, abs=0.002)
    assert alpha["min"] == pytest.approx(0.05, abs=0.002)

"""A window that stands still, for whatever reason, loses nothing: the recorder goes on.

``GSAPP_FREEZE_SECONDS=20`` freezes it for as long as the specification says.
"""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from gsapp.flight.folder_setup import prepare_flight_folder
from gsapp.telemetry.recorder_control import RecorderHandle, start_recorder
from tests.ui.window_kit import Aircraft, free_port

FROZEN = float(os.environ.get("GSAPP_FREEZE_SECONDS", "4"))


class RememberingAircraft(Aircraft):
    def __init__(self, port: int) -> None:
        super().__init__(port)
        self.frames: list[bytes] = []

    def _pack(self, message: object) -> bytes:
        frame = super()._pack(message)
        self.frames.append(frame)
        return frame


@pytest.fixture
def recorder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[RecorderHandle]:
    monkeypatch.setenv("GSAPP_RUNTIME_FOLDER", str(tmp_path / "run"))
    link, folder = f"udpin:127.0.0.1:{free_port()}", tmp_path / "flight"
    prepare_flight_folder(folder, aircraft="b777", channel_map="b777", source=link)
    handle = start_recorder(link, folder)
    yield handle
    handle.stop()


def wait_for(condition: Callable[[], bool], seconds: float = 180.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it did not happen in time"
        time.sleep(0.02)


@pytest.mark.long
@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="no SIGSTOP on Windows")
def test_a_frozen_window_loses_no_byte_and_draws_what_came_meanwhile(
    recorder: RecorderHandle, tmp_path: Path
) -> None:
    """A real window's process is stopped while a real recorder writes a real link, and goes on."""
    text = tmp_path / "told.json"
    folder = recorder.folder
    raw = folder / "raw.tlog"
    status = json.loads((folder / "recorder.json").read_text(encoding="utf-8"))
    port = int(status["link"].rpartition(":")[2])

    def state() -> dict[str, list[float]]:
        return json.loads(text.read_text(encoding="utf-8")) if text.exists() else {"times": []}

    program = Path(__file__).with_name("watched_window.py")
    with (tmp_path / "window.log").open("wb") as log:
        window = subprocess.Popen(
            [sys.executable, str(program), str(tmp_path / "settings"), str(folder), str(text)],
            env={**os.environ, "QT_QPA_PLATFORM": "offscreen"}, stdout=log, stderr=log,
        )  # fmt: skip
    try:
        with RememberingAircraft(port) as aircraft:
            wait_for(lambda: len(state()["times"]) > 100)
            os.kill(window.pid, signal.SIGSTOP)
            time.sleep(0.1)
            before, size, first = text.read_bytes(), raw.stat().st_size, state()["times"][-1]
            time.sleep(FROZEN)
            assert text.read_bytes() == before, "the window was not frozen"
            assert (
                raw.stat().st_size > size + 0.9 * FROZEN * 100 * 100
            )  # frames of 100 bytes and more
            os.kill(window.pid, signal.SIGCONT)
            going_on = time.monotonic()
            last = first + FROZEN
            wait_for(lambda: state()["times"][-1] > last + 0.5)
            caught_up = time.monotonic() - going_on
            sys.stdout.write(f"caught up {caught_up:.2f} s after going on\n")
            # The newest paint may be a little older than the newest sample.
            wait_for(lambda: state()["columns"][-1][0] > last + 0.3)
            shown = state()
            assert not {"link", "recorder", "disk"} & set(shown["alarms"])
        wait_for(lambda: raw.stat().st_size >= sum(len(frame) + 8 for frame in aircraft.frames))
    finally:
        window.send_signal(signal.SIGCONT)
        window.terminate()
        window.wait(10.0)
    # Every frame that was sent is in the file, byte for byte.
    data, place = raw.read_bytes(), 0
    for frame in aircraft.frames:
        assert data[place + 8 : place + 8 + len(frame)] == frame
        place += 8 + len(frame)
    assert place == len(data)
    assert not (folder / "residue.bin").exists() or not (folder / "residue.bin").stat().st_size
    # The window has every sample of the time in which it stood, and its chart shows them all.
    times = np.array(shown["times"])
    within = times[(times > first - 0.5) & (times < last + 0.3)]
    assert np.diff(within).max() < 0.0101
    assert within.size > 100 * FROZEN
    columns = np.array(shown["columns"])
    frozen = columns[(columns[:, 0] > first) & (columns[:, 0] < last)]
    assert len(frozen) > 10
    assert frozen[:, 1].all()

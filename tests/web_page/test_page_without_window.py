"""`gsapp replay --headless --share`: a flight that is being recorded, without a display."""

import http.client
import json
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from gsapp.telemetry.recorder_control import start_recorder
from gsapp.telemetry.recorder_status import RUNTIME_VARIABLE
from gsapp.telemetry.recording_settings import RecordingSettings
from tests.telemetry.conftest import free_port
from tests.ui.window_kit import Aircraft
from tests.ui.window_kit import free_port as free_udp_port


def test_a_flight_is_followed_until_its_recorder_stops(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(RUNTIME_VARIABLE, str(tmp_path / "run"))
    port, page, folder = free_udp_port(), free_port(socket.SOCK_STREAM), tmp_path / "flight"
    link = f"udpin:127.0.0.1:{port}"
    settings = RecordingSettings(aircraft="b777", channel_map="b777", calibration="b777")
    settings.prepare_folder(folder, link)
    recorder = start_recorder(link, folder)
    command = [
        sys.executable, "-m", "gsapp", "replay", str(folder), "--headless",
        "--share", f"http:127.0.0.1:{page}", "--json", str(tmp_path / "all.json"),
    ]  # fmt: skip
    with Aircraft(port), subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as follower:
        try:
            assert f"http://127.0.0.1:{page}/" in follower.stdout.readline()
            connection = http.client.HTTPConnection("127.0.0.1", page, timeout=60.0)
            connection.request("GET", "/frames")
            with connection.getresponse() as answer:
                frame = {}
                while len(frame.get("strips", ())) < 4:
                    frame = json.loads(answer.readline())
            assert (frame["mode"], frame["flight"]) == ("LIVE", "flight")
            recorder.stop()
            assert follower.wait(60.0) == 0
        finally:
            recorder.stop()
            follower.kill()
    assert json.loads((tmp_path / "all.json").read_text())["duration"] > 0.5


@pytest.mark.parametrize("more", [(), ("--headless", "--share-open")])
def test_a_page_needs_a_command_without_a_window_and_an_address(
    tmp_path: Path, more: tuple[str, ...]
) -> None:
    (tmp_path / "fl.csv").write_text("time [s],V [m/s]\n0,30\n1,30\n")
    link = "http:127.0.0.1:8080" if not more else "tcpin:127.0.0.1:8080"
    command = [sys.executable, "-m", "gsapp", "replay", "fl.csv", "--share", link, *more]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode in (1, 2)
    assert ("--headless" if not more else "http:HOST:PORT") in done.stderr

"""``gsapp fly``: a flight folder that all else can read, or nothing at all."""

import os
import signal
import subprocess
import sys
import time
from json import loads
from pathlib import Path

import numpy as np
import pytest

os.environ.setdefault("MAVLINK20", "1")

from pymavlink import mavutil

from gsapp.cli._usage_errors import CommandUsageError
from gsapp.cli.fly import fly
from gsapp.flight.flight_loader import load_flight
from gsapp.foundation import FlightError
from gsapp.virtual.downlink import flight_recording

DEG = np.pi / 180.0


def test_a_flight_folder_is_as_if_recorded(tmp_path: Path) -> None:
    out, truth, json = tmp_path / "flight", tmp_path / "truth.csv", tmp_path / "flown.json"
    fly(out=out, plan="short", seed=3, truth=truth, json=json)
    flight = load_flight(out)
    told = loads(json.read_text(encoding="utf-8"))
    assert (told["flight"], told["link"], told["truth"]) == (str(out), None, str(truth))
    assert (told["plan"], told["seed"], told["hide"]) == ("short", 3, [])
    assert told["duration"] == pytest.approx(flight.block.times[-1], abs=2.5)
    assert told["sent_bytes"] == (out / "raw.tlog").stat().st_size - 8 * flight.frames.good
    assert flight.frames.good > 30_000
    assert flight.frames.damaged == flight.frames.lost == 0
    assert (out / "aircraft.toml").exists()
    assert (out / "channel_map.toml").exists()
    assert len(list((out / "calibration").glob("*.toml"))) == 18
    true = load_flight(truth).block
    count = min(len(true), len(flight.block))
    for name, tolerance in (("q", 1.5 * DEG), ("de", 0.3 * DEG), ("dr", 0.3 * DEG)):
        error = flight.block[name][:count] - true[name][:count]
        assert np.nanstd(error) < tolerance, name
    airspeed = flight.block["V"][:count] - true["V"][:count]
    assert np.nanstd(airspeed[true["V"][:count] > 20.0]) < 1.0
    assert not list(tmp_path.glob(".flight*")), "nothing half written is left"
    assert _announcements(out / "raw.tlog") == [
        "Telemetry on, recording", "Engines running", "Range check", "Take-off run", "Airborne",
        "In the pattern", "Approach", "Landed", "Engines off",
    ]  # fmt: skip


def _announcements(tlog: Path) -> list[str]:
    reader = mavutil.mavlink_connection(str(tlog), dialect="all")
    texts = []
    while (message := reader.recv_match(type="STATUSTEXT")) is not None:
        texts.append(message.text)
    reader.close()
    return texts


def test_an_interrupted_flight_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    told = []

    def interrupt(progress: object) -> None:
        told.append(progress)
        raise KeyboardInterrupt

    real = flight_recording.write_record

    def interrupted(*arguments: object, **options: object) -> None:
        options["progress"] = interrupt
        real(*arguments, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(flight_recording, "write_record", interrupted)
    with pytest.raises(KeyboardInterrupt):
        fly(out=tmp_path / "flight", plan="short")
    assert told
    assert list(tmp_path.iterdir()) == []


@pytest.mark.long
@pytest.mark.skipif(os.name == "nt", reason="no such signals on Windows")
@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP"])
def test_a_flight_that_is_asked_to_end_leaves_nothing(name: str, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "gsapp.cli", "fly", "--out", str(tmp_path / "flight")]
    number = getattr(signal, name)
    process = subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
        # The tests themselves may run under nohup.
        preexec_fn=lambda: signal.signal(number, signal.SIG_DFL),  # noqa: PLW1509 - it locks nothing
    )  # fmt: skip
    try:
        deadline = time.monotonic() + 60.0
        while not any(path.stat().st_size for path in tmp_path.rglob("raw.tlog")):
            assert time.monotonic() < deadline
            time.sleep(0.05)
        process.send_signal(number)
        _, complaint = process.communicate(timeout=20.0)
    finally:
        process.kill()
        process.wait()
    assert process.returncode == 128 + number
    assert b"Traceback" not in complaint
    assert list(tmp_path.iterdir()) == []


def test_a_place_that_is_taken_is_not_touched(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(FlightError, match="exists already"):
        fly(out=tmp_path, plan="short")
    assert (tmp_path / "notes.txt").read_text() == "mine"


@pytest.mark.parametrize(
    ("to", "speed", "words"),
    [
        ("virtual", 1.0, "cannot send"),
        ("udpout:127.0.0.1:14550", 0.0, "is not possible"),
        ("upd:127.0.0.1:14550", 1.0, "neither a link"),
    ],
)
def test_a_link_that_makes_no_sense_is_refused(to: str, speed: float, words: str) -> None:
    with pytest.raises(CommandUsageError, match=words):
        fly(to=to, plan="short", speed=speed)


def test_it_is_said_that_the_aircraft_crashed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "flight"
    fly(out=out, seed=9, turbulence=3.0)
    end = load_flight(out).block.times[-1]
    assert end < 10.0
    assert f"crashed after {end:.1f} s" in capsys.readouterr().err

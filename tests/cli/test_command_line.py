"""Commands are quick to ask, exit with the right code, and say one sentence when they fail."""

from __future__ import annotations

import os
import struct
import subprocess
import sys
from pathlib import Path

import pytest

from gsapp.cli import fly, replay
from gsapp.decoding.dialect import dialect
from gsapp.flight.preparing import prepare_flight
from gsapp.foundation import UnknownNameError

HEAVY = ("numpy", "pydantic", "pint", "PySide6", "matplotlib", "scipy", "pymavlink", "rich")


def gsapp(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "gsapp.cli", *arguments],
        capture_output=True,
        encoding="utf-8",
        timeout=240,
    )


def test_help_imports_nothing_heavy() -> None:
    program = (
        "import sys; sys.argv = ['gsapp', '--help']\n"
        "from gsapp.cli.main import app\n"
        "try: app()\n"
        "except SystemExit: pass\n"
        f"print([name for name in {HEAVY} if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, encoding="utf-8")
    assert done.stdout.splitlines()[-1] == "[]"


@pytest.mark.parametrize("command", ["demo", "fly", "record", "replay", "import", "export"])
def test_every_command_explains_itself_with_an_example(command: str) -> None:
    done = gsapp(command, "--help")
    assert done.returncode == 0
    assert f"Example: gsapp {command}" in done.stdout


def test_no_character_ends_a_command_whose_words_go_to_a_pipe(tmp_path: Path) -> None:
    """As on Windows, which hands over pipes in a code page that lacks most characters."""
    flight, cut = tmp_path / "flight.csv", tmp_path / "cut-λ.csv"
    flight.write_text("time [s],alpha [deg]\n0,1\n0.01,2\n0.02,3\n", encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-m", "gsapp.cli", "cut", flight, "--window", "0:1", "--out", cut],
        capture_output=True, timeout=240, env={**os.environ, "PYTHONIOENCODING": "cp1252"},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "cut-λ.csv" in done.stdout.decode("utf-8")


@pytest.mark.parametrize("call", [("dance",), ("record",), ("fly",), ("replay",)])
def test_a_wrong_call_exits_with_2(call: tuple[str, ...]) -> None:
    done = gsapp(*call)
    assert done.returncode == 2
    assert "Usage:" in done.stderr


def test_suspicious_numbers_of_an_aircraft_are_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """By the commands that read its file: the inertias of the source are those of no fuselage."""
    doubt = "B777: ixx + iyy - izz says that the mass lies"
    with pytest.raises(UnknownNameError, match="absent"):
        fly.run(out=tmp_path / "x", plan="absent")
    assert capsys.readouterr().err.count(doubt) == 1
    folder = prepare_flight(tmp_path / "flight", aircraft="b777", channel_map="b777")
    frame = dialect().MAVLink(None, srcSystem=1).heartbeat_encode(1, 3, 0, 0, 4)
    packed = frame.pack(dialect().MAVLink(None, srcSystem=1))
    folder.tlog_file.write_bytes(struct.pack(">Q", 1_760_000_000_000_000) + packed)
    replay.run(flight=folder.path)
    assert capsys.readouterr().out.count(doubt) == 1
    again = str(tmp_path / "again")
    recorded = gsapp("record", str(folder.path), "--aircraft", "b777", "--out", again)
    assert recorded.stdout.count(doubt) == 1


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (("record", "udpin:nowhere", "--out", "x"), "lacks its port"),
        (("replay", "absent-flight", "--headless"), "absent-flight"),
        (("export", "absent.csv", "--to", "mat", "--out", "x.mat"), "absent.csv"),
        (("import", "absent.bin", "--map", "ardupilot-log", "--out", "x"), "absent.bin"),
        (("fly", "--out", "x", "--plan", "absent-plan"), "absent-plan"),
    ],
)
def test_a_failure_exits_with_1_and_says_why_without_a_stack_trace(
    tmp_path: Path, call: tuple[str, ...], sentence: str
) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "gsapp.cli", *call],
        capture_output=True, encoding="utf-8", timeout=240, cwd=tmp_path,
    )  # fmt: skip
    assert done.returncode == 1, done.stderr
    assert sentence in done.stderr
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []

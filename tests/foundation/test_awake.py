"""The computer is kept awake for as long as something must go on, and no longer."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from gsapp.foundation.process_control import inhibit_sleep

pytestmark = pytest.mark.skipif(
    sys.platform in ("win32", "darwin"), reason="what keeps Linux awake is asked for by a program"
)

INHIBITOR = """#!/bin/sh
while [ "${1#--}" != "$1" ]; do echo "$1" >> "$HERE/asked"; shift; done
echo $$ > "$HERE/process"
"$@"
echo over > "$HERE/over"
"""
"""Does what systemd-inhibit does to the program that it is given, and writes down what is asked."""


@pytest.fixture
def inhibitor(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    program = tmp_path / "bin" / "systemd-inhibit"
    program.parent.mkdir()
    program.write_text(INHIBITOR)
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{program.parent}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.setenv("HERE", str(tmp_path))
    return tmp_path


def until(done: Callable[[], bool]) -> None:
    deadline = time.monotonic() + 20.0
    while not done():
        assert time.monotonic() < deadline
        time.sleep(0.02)


def test_the_login_manager_is_asked_and_let_go(inhibitor: Path) -> None:
    with inhibit_sleep("recording 2026-05-12-a"):
        until((inhibitor / "process").exists)
        until(lambda: bool((inhibitor / "process").read_text().strip()))
        process = int((inhibitor / "process").read_text())
        os.kill(process, 0)
    with pytest.raises(ProcessLookupError):
        os.kill(process, 0)
    asked = (inhibitor / "asked").read_text().splitlines()
    assert "--why=recording 2026-05-12-a" in asked
    assert "--what=sleep:idle" in asked


def test_it_is_let_go_however_the_process_ends(inhibitor: Path) -> None:
    program = (
        "import time; from gsapp.foundation.process_control import inhibit_sleep\n"
        "with inhibit_sleep('recording'): time.sleep(60)"
    )
    process = subprocess.Popen([sys.executable, "-c", program])
    until((inhibitor / "process").exists)
    process.send_signal(signal.SIGKILL)
    process.wait()
    until((inhibitor / "over").exists)


def test_nothing_happens_where_nobody_can_be_asked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with inhibit_sleep("recording"):
        pass
    (tmp_path / "systemd-inhibit").write_text("no program")
    (tmp_path / "systemd-inhibit").chmod(0o755)
    with inhibit_sleep("recording"):
        pass

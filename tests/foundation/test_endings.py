"""A process asked to end does so in time, whatever it waits for; one behind yields to others."""

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from multiprocessing.connection import Connection
from pathlib import Path

import pytest

from gsapp.foundation.process_control import block_sigint

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="SIGTERM ends a process at once")


def run(body: str, log: Path) -> subprocess.Popen[bytes]:
    code = (
        "import sys, threading, time\n"
        "from pathlib import Path\n"
        "from gsapp.foundation.process_control import on_termination_signal, exit_deadline\n"
        "end = threading.Event()\n"
        "with on_termination_signal(lambda _: end.set()), exit_deadline(1.0, Path(sys.argv[1])):\n"
        "    print('ready', flush=True)\n"
        f"    {body}\n"
    )
    child = subprocess.Popen([sys.executable, "-c", code, str(log)], stdout=subprocess.PIPE)
    assert child.stdout.readline().strip() == b"ready"
    return child


@pytest.mark.parametrize(
    "body",
    [
        # Python itself waits for a thread as it exits.
        "threading.Thread(target=time.sleep, args=(60,)).start(); end.wait()",
        # The main thread is where it hears no signal: this wait is begun again after each.
        "import ctypes; c = ctypes.CDLL(None); [c.usleep(900_000) for _ in iter(int, 1)]",
    ],
    ids=["thread", "main thread"],
)
def test_what_waits_for_ever_is_ended_and_says_where(tmp_path: Path, body: str) -> None:
    child = run(body, tmp_path / "log")
    time.sleep(0.2)
    child.send_signal(signal.SIGTERM)
    assert child.wait(15.0) == 1
    assert "Thread 0x" in (tmp_path / "log").read_text()


def test_what_ends_in_time_is_left_alone(tmp_path: Path) -> None:
    child = run("end.wait()", tmp_path / "log")
    child.send_signal(signal.SIGTERM)
    assert child.wait(15.0) == 0
    assert not (tmp_path / "log").exists() or not (tmp_path / "log").read_text()


def blocked(answer: Connection) -> None:
    answer.send(signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, ()))


def test_ctrl_c_does_not_reach_a_process_that_still_starts() -> None:
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=blocked, args=(theirs,))
    with block_sigint():
        process.start()
    assert ours.poll(60.0)
    assert ours.recv()
    process.join(60.0)
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, ())


@pytest.mark.skipif(not hasattr(os, "nice"), reason="read where the system tells it by a number")
def test_a_process_that_stands_back_yields_to_others() -> None:
    code = (
        "import os; from gsapp.foundation.process_control import lower_priority\n"
        "before = os.nice(0); lower_priority(3); print(min(before + 3, 19) == os.nice(0))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout.split() == ["True"], done.stderr

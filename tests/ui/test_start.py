"""A window starts with what its first picture needs, and loads the rest beside the flight."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.ui.window_kit import write_flight

SLOW = ("scipy.signal", "scipy.stats", "matplotlib")
"""Packages that take a third of a second and more to load."""
PROGRAM = f"""
import sys, time
from pathlib import Path
from PySide6.QtCore import QTimer
from tests.ui.window_kit import open_window
from ui.app import create_application

def loaded():
    return " ".join(name for name in {SLOW!r} if name in sys.modules) or "none"

application = create_application()
window = open_window(Path(sys.argv[1]))
window.flight_controller.changed.connect(lambda: print(loaded()))
window.flight_controller.flight_opener.open_flight(Path(sys.argv[2]))
deadline = time.monotonic() + 30.0

def poll():
    if "scipy.signal" in sys.modules or time.monotonic() > deadline:
        application.quit()

timer = QTimer()
timer.timeout.connect(poll)
timer.start(50)
application.exec()
window.flight_controller.close()
print(loaded())
"""

WAITING = """
import sys
from pathlib import Path
from PySide6.QtCore import QTimer
from ui.app import create_application, run_window
from ui.preflight.preflight_steps import PREFLIGHT_STEPS
from ui.review.review_steps import REVIEW_STEPS
from ui.main_window import MainWindow

OURS = ("calibration", "gsapp", "ui.preflight", "ui.review", "pyqtgraph", "scipy")
application = create_application()

def poll():
    if "scipy.signal" not in sys.modules or "ui.review.summary_page" not in sys.modules:
        return
    there = set(sys.modules)
    (window,) = (one for one in application.topLevelWidgets() if isinstance(one, MainWindow))
    pages = ((window.preflight_page, PREFLIGHT_STEPS), (window.review_page, REVIEW_STEPS))
    for page, steps in pages:
        for one in steps:
            page.go_to_step(one.id)
    print(*(name for name in set(sys.modules) - there if name.startswith(OURS)))
    application.quit()

timer = QTimer()
timer.timeout.connect(poll)
timer.start(50)
run_window(settings=Path(sys.argv[1]) / "window.toml")
"""


def test_charts_do_not_wait_for_what_only_maneuvers_need(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, str(tmp_path), str(write_flight(tmp_path / "flights"))],
        check=True,
        capture_output=True,
        text=True,
    )
    at_first, *_, in_the_end = done.stdout.split("\n")[:-1]
    assert at_first == "none"
    assert "scipy.signal" in in_the_end.split()


@pytest.mark.long
def test_a_window_that_waits_for_a_flight_gets_ready_for_what_may_come(tmp_path: Path) -> None:
    homes = {f"XDG_{name}_HOME": str(tmp_path) for name in ("CONFIG", "STATE", "CACHE", "DATA")}
    done = subprocess.run(
        [sys.executable, "-c", WAITING, str(tmp_path)],
        check=True,
        capture_output=True,
        text=True,
        timeout=60.0,
        env={**os.environ, **homes},
    )
    assert done.stdout.split() == []


@pytest.mark.skipif(os.name == "nt", reason="SIGTERM ends a process at once on Windows")
def test_a_window_that_is_asked_to_end_is_closed_in_order(tmp_path: Path) -> None:
    homes = {f"XDG_{name}_HOME": str(tmp_path) for name in ("CONFIG", "STATE", "CACHE", "DATA")}
    command = [sys.executable, "-m", "gsapp.cli"]
    process = subprocess.Popen(command, env={**os.environ, **homes})
    try:
        deadline = time.monotonic() + 30.0
        while not any("window opened" in log.read_text() for log in tmp_path.rglob("*.log")):
            assert time.monotonic() < deadline
            time.sleep(0.1)
        process.send_signal(signal.SIGTERM)
        assert process.wait(20.0) == 0
    finally:
        process.kill()
        process.wait()
    (log,) = tmp_path.rglob("*.log")
    assert "window closed" in log.read_text()


_BUSY = """
import threading, time
from PySide6.QtCore import QCoreApplication, QObject, Signal
from gsapp.foundation.process_control import exit_process

class Work(QObject):
    told = Signal(object)

application, work = QCoreApplication([]), Work()

def tell():
    while True:
        work.told.emit(1)

for _ in range(2):
    threading.Thread(target=tell, daemon=True).start()
time.sleep(0.2)
exit_process(3)
"""


def test_a_process_ends_in_order_while_a_thread_is_within_qt() -> None:
    ended = subprocess.run([sys.executable, "-P", "-c", _BUSY], check=False, timeout=60.0)
    assert ended.returncode == 3

"""The on-board log in the window: taken by keys, fetched behind it, stopped, taken back."""

from __future__ import annotations

import json
import os
import shutil
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest
from PySide6.QtCore import Qt, QTimer
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from gsapp.flight.folder import FlightFolder
from gsapp.flight.loading import load_flight
from gsapp.telemetry.recorder_control import find_recorders
from gsapp.telemetry.status import RUNTIME_VARIABLE
from ui.review.onboard_dialog import OnboardDialog

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(Path(__file__).parents[1] / "flight"))

from onboard_kit import fly_thin
from window_kit import free_port, open_window

AUTOPILOT = Path(__file__).parents[1] / "telemetry" / "foreign_autopilot.py"
OFFSET = 3.7


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """Return a flight's first seconds over the thin link, and the log of its box."""
    folder = tmp_path_factory.mktemp("thin")
    fly_thin(folder / "f", folder / "box.tlog", seconds=26.0, offset=OFFSET)
    return folder


@pytest.fixture
def reviewed(flown, tmp_path, qtbot, monkeypatch):
    """Return a window that reviews a copy of the flight, the flight and the log."""
    monkeypatch.setenv(RUNTIME_VARIABLE, str(tmp_path / "run"))
    shutil.copytree(flown / "f", tmp_path / "f")
    log = tmp_path / "box.tlog"
    shutil.copy(flown / "box.tlog", log)
    window = open_window(tmp_path, review_flights=(str(tmp_path / "f"),))
    qtbot.addWidget(window)
    window.show_place("review")
    qtbot.waitUntil(lambda: bool(window.review.review.flights), timeout=20_000)
    yield window, FlightFolder.open(tmp_path / "f"), log
    window.review.close_work()


def press(window, sequence, answer):
    """Press keys that open the dialog, and answer it."""

    def look() -> None:
        dialog = QApplication.activeModalWidget()
        if isinstance(dialog, OnboardDialog):
            try:
                answer(dialog)
            finally:
                if dialog.isVisible():
                    dialog.reject()
        else:
            QTimer.singleShot(20, look)

    window.activateWindow()
    assert QTest.qWaitForWindowActive(window)
    QTimer.singleShot(0, look)
    QTest.keyClick(window, *sequence)


KEYS = (Qt.Key.Key_L, Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier)


def banners(window):
    return [banner.label.text() for banner in window.banners.banners]


def test_a_log_is_taken_by_keys_and_taken_back(reviewed, qtbot):
    """Ctrl+Shift+L, a file, Enter: the flight under review has the log's samples, and not.

    The banner says offset and drift in numbers; one press takes it back.
    """
    window, folder, log = reviewed
    before = window.review.review.flights[0].flight
    assert before.onboard is None

    def answer(dialog) -> None:
        assert dialog.focusWidget() is dialog.origin
        assert not dialog.button.isEnabled()
        QTest.keyClick(dialog.origin, Qt.Key.Key_Tab)
        QTest.keyClicks(dialog.file.edit, str(log))
        assert dialog.focusWidget() is dialog.file.edit
        QTest.keyClick(dialog.file.edit, Qt.Key.Key_Return)

    press(window, KEYS, answer)
    qtbot.waitUntil(
        lambda: window.review.review.flights[0].flight.onboard is not None, timeout=15_000
    )
    after = window.review.review.flights[0].flight
    assert after.onboard.clock.offset == pytest.approx(OFFSET, abs=0.005)
    assert folder.info().onboard_log == "box.tlog"
    assert (after.sources["q"].rate, before.sources["q"].rate) == (
        pytest.approx(100.0, abs=1.0), pytest.approx(20.0, abs=0.5),
    )  # fmt: skip
    said = next(words for words in banners(window) if "box.tlog" in words)
    assert "3.70" in said
    assert "drift" in said
    banner = next(one for one in window.banners.banners if one.label.text() == said)
    assert [button.text() for button in banner.buttons] == ["Take back"]
    QTest.mouseClick(banner.buttons[0], Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: window.review.review.flights[0].flight.onboard is None, timeout=15_000)
    assert folder.info().onboard_log == ""


def test_a_fetch_is_stopped_and_its_process_killed(reviewed, qtbot, tmp_path):
    """Over the link from a foreign autopilot: told as it goes, stopped, killed, then whole.

    Whatever ends it, the flight stands as it stood, the window tells, and the next one goes on.
    """
    window, folder, log = reviewed
    port = free_port()
    # So slow that there is time to stop it.
    served = subprocess.Popen(
        [sys.executable, AUTOPILOT, str(port), str(log), str(tmp_path / "heard"), "0.0", "3"]
    )
    card = folder.info_file.read_bytes()
    desk = window.review.onboard

    def answer(dialog) -> None:
        dialog.origin.setFocus()
        QTest.keyClick(dialog.origin, Qt.Key.Key_Down)
        dialog.link.text.setEditText(f"udpin:127.0.0.1:{port}")
        QTest.keyClick(dialog, Qt.Key.Key_Return)

    def coming() -> bool:
        return any("kB/s" in words for words in banners(window))

    note = folder.cache_folder / "download" / "onboard-8.json"

    def missing() -> int:
        return sum(b - a for a, b in json.loads(note.read_bytes())["missing"])

    try:
        press(window, KEYS, answer)
        qtbot.waitUntil(coming, timeout=20_000)
        window.commands.actions["review_onboard_stop"].trigger()
        qtbot.waitUntil(lambda: not desk.work.running, timeout=10_000)
        assert any("stopped" in words for words in banners(window))
        left = missing()
        assert 0 < left < log.stat().st_size
        press(window, KEYS, answer)
        qtbot.waitUntil(lambda: note.exists() and missing() < left, timeout=20_000)
        os.kill(desk.work._engine.pid, signal.SIGKILL)
        qtbot.waitUntil(lambda: not desk.work.running, timeout=10_000)
        # An error is told a moment after the work has ended.
        qtbot.waitUntil(
            lambda: any("what came of a log is kept" in words for words in banners(window))
        )
        assert folder.info_file.read_bytes() == card
        press(window, KEYS, answer)
        qtbot.waitUntil(
            lambda: window.review.review.flights[0].flight.onboard is not None, timeout=60_000
        )
    finally:
        served.kill()
        served.wait()
    assert folder.info().onboard_log == "onboard-8.tlog"
    assert (folder.path / "onboard-8.tlog").read_bytes() == log.read_bytes()
    qtbot.waitUntil(lambda: not find_recorders(), timeout=10_000)
    assert load_flight(folder.path).onboard.in_place
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", port))  # the link was given back

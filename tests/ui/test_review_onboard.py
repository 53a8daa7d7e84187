"""The on-board log in the window: asked for by keys, fetched behind it, stopped, taken back."""

import json
import os
import shutil
import socket
import subprocess
import sys
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QDialog

from gsapp.flight.folder import FlightFolder
from gsapp.flight.onboard_log import OnboardLogState
from gsapp.telemetry.log_download import parse_log_link
from gsapp.telemetry.recorder_control import find_recorders
from gsapp.telemetry.recorder_status import RUNTIME_VARIABLE
from tests.flight.onboard_kit import fly_thin
from tests.ui.window_kit import KILL, answer_dialog, free_port, open_window
from ui.display_style import DisplayStyle
from ui.review.onboard_log_dialog import FlightLogs, OnboardLogDialog
from ui.review.onboard_log_worker import OnboardLogJob

AUTOPILOT = Path(__file__).parents[1] / "telemetry" / "foreign_autopilot.py"
OFFSET = 3.7


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    folder = tmp_path_factory.mktemp("thin")
    fly_thin(folder / "f", folder / "box.tlog", seconds=26.0, offset=OFFSET)
    return folder


@pytest.fixture
def reviewed(flown, tmp_path, qtbot, monkeypatch):
    monkeypatch.setenv(RUNTIME_VARIABLE, str(tmp_path / "run"))
    shutil.copytree(flown / "f", tmp_path / "f")
    log = tmp_path / "box.tlog"
    shutil.copy(flown / "box.tlog", log)
    window = open_window(tmp_path, review_flights=(str(tmp_path / "f"),))
    qtbot.addWidget(window)
    window.show_page("review")
    qtbot.waitUntil(lambda: bool(window.review_page.review.flights), timeout=60_000)
    yield window, FlightFolder.open(tmp_path / "f"), log
    window.review_page.close_work()


def press(window, sequence, answer):
    window.activateWindow()
    assert QTest.qWaitForWindowActive(window)
    answer_dialog(OnboardLogDialog, answer)
    QTest.keyClick(window, *sequence)


KEYS = (Qt.Key.Key_L, Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier)


def banners(window):
    return [banner.label.text() for banner in window.banners.banners]


def test_the_dialog_asks_for_what_is_there(tmp_path, qtbot):
    """A file that is there, a link, a log of the folder, or none: each gives its job, by keys."""
    (tmp_path / "box.tlog").touch()
    state = OnboardLogState(file="now.bin", in_place=False, why="it moves otherwise")
    logs = FlightLogs(
        path=tmp_path, name="f", in_force="now.bin", state=state,
        stored_logs=("now.bin", "old.bin"), link="udpin:127.0.0.1:15000",
    )  # fmt: skip
    dialog = OnboardLogDialog(DisplayStyle(), (logs,), (), parse_log_link, tuple)
    qtbot.addWidget(dialog)
    dialog.show()
    assert "it moves otherwise" in dialog.now.text()
    assert dialog.focusWidget() is dialog.origin
    assert not dialog.button.isEnabled()
    QTest.keyClick(dialog.origin, Qt.Key.Key_Tab)
    assert dialog.focusWidget() is dialog.file.edit
    QTest.keyClicks(dialog.file.edit, str(tmp_path / "box.tlo"))
    assert not dialog.button.isEnabled()
    assert "no file" in dialog.verdict.text()
    QTest.keyClicks(dialog.file.edit, "g")
    assert dialog.job == OnboardLogJob(flight=tmp_path, file=tmp_path / "box.tlog")
    wanted = [
        OnboardLogJob(flight=tmp_path, link="udpin:127.0.0.1:15000"),
        OnboardLogJob(flight=tmp_path, use="old.bin"),
        OnboardLogJob(flight=tmp_path, use=""),
    ]
    for job in wanted:
        QTest.keyClick(dialog.origin, Qt.Key.Key_Down)
        assert dialog.button.isEnabled()
        assert dialog.job == job
    QTest.keyClick(dialog, Qt.Key.Key_Return)
    assert dialog.result() == QDialog.DialogCode.Accepted


def test_tab_goes_through_the_link_as_one_reads(tmp_path, qtbot):
    """Its fields are laid out only once the link is chosen."""
    logs = FlightLogs(path=tmp_path, name="f", link="udpin:127.0.0.1:15000")
    dialog = OnboardLogDialog(DisplayStyle(), (logs,), (), parse_log_link, tuple)
    qtbot.addWidget(dialog)
    dialog.show()
    QTest.keyClick(dialog.origin, Qt.Key.Key_Down)
    link = dialog.link
    for field in (link.kind, link.host, link.port, link.text):
        QTest.keyClick(dialog.focusWidget(), Qt.Key.Key_Tab)
        assert dialog.focusWidget() is field


@pytest.mark.parametrize("link", ["text:/dev/ttyACM0:9600", "box.tlog"])
def test_no_log_is_asked_for_where_nobody_can_be_asked(tmp_path, qtbot, monkeypatch, link):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "box.tlog").touch()
    dialog = OnboardLogDialog(
        DisplayStyle(), (FlightLogs(path=tmp_path, name="f"),), (link,), parse_log_link, tuple
    )
    qtbot.addWidget(dialog)
    dialog.origin.setCurrentIndex(1)
    assert not dialog.button.isEnabled()
    assert dialog.link.message.property("state") == "warning"


@pytest.mark.long
def test_a_log_is_fetched_stopped_killed_and_taken_back(reviewed, qtbot, tmp_path):
    """Over the link from a foreign autopilot, by keys: told as it goes, stopped, killed, whole.

    Whatever ends it, the flight stands as it stood, the window tells, and the next one goes on. At
    the end the flight under review has the log's samples; one press takes them back.
    """
    window, folder, log = reviewed
    port = free_port()
    command = [sys.executable, AUTOPILOT, str(port), str(log), str(tmp_path / "heard"), "0.0"]
    # So slow that there is time to stop it.
    served = subprocess.Popen([*command, "2"])
    card = folder.info_file.read_bytes()
    controller = window.review_page.onboard

    def answer(dialog) -> None:
        dialog.origin.setFocus()
        QTest.keyClick(dialog.origin, Qt.Key.Key_Down)
        dialog.link.text.setEditText(f"udpin:127.0.0.1:{port}")
        QTest.keyClick(dialog, Qt.Key.Key_Return)

    def coming() -> bool:
        return any("kB/s" in text for text in banners(window))

    note = folder.cache_folder / "download" / "onboard-8.json"

    def missing() -> int:
        return sum(b - a for a, b in json.loads(note.read_bytes())["missing"])

    try:
        press(window, KEYS, answer)
        qtbot.waitUntil(coming, timeout=60_000)
        window.commands.actions["review_onboard_stop"].trigger()
        qtbot.waitUntil(lambda: not controller.work.running, timeout=40_000)
        assert any("stopped" in text for text in banners(window))
        left = missing()
        assert 0 < left < log.stat().st_size
        press(window, KEYS, answer)
        qtbot.waitUntil(lambda: note.exists() and missing() < left, timeout=60_000)
        os.kill(controller.work._job_runner.pid, KILL)
        qtbot.waitUntil(lambda: not controller.work.running, timeout=40_000)
        # An error is told a moment after the work has ended.
        qtbot.waitUntil(
            lambda: any("received part of the log is kept" in text for text in banners(window))
        )
        assert folder.info_file.read_bytes() == card
        served.kill()
        served.wait()
        served = subprocess.Popen([*command, "16"])
        press(window, KEYS, answer)
        qtbot.waitUntil(
            lambda: window.review_page.review.flights[0].flight.onboard is not None, timeout=60_000
        )
    finally:
        served.kill()
        served.wait()
    after = window.review_page.review.flights[0].flight
    assert after.onboard.clock.offset == pytest.approx(OFFSET, abs=0.005)
    assert after.sources["q"].rate == pytest.approx(100.0, abs=1.0)
    assert folder.info().onboard_log == "onboard-8.tlog"
    assert (folder.path / "onboard-8.tlog").read_bytes() == log.read_bytes()
    qtbot.waitUntil(lambda: not find_recorders(), timeout=40_000)
    said = next(one for one in window.banners.banners if "onboard-8.tlog" in one.label.text())
    assert "3.70" in said.label.text()
    assert "drift" in said.label.text()
    assert [button.text() for button in said.buttons] == ["Take back"]
    QTest.mouseClick(said.buttons[0], Qt.MouseButton.LeftButton)
    qtbot.waitUntil(
        lambda: window.review_page.review.flights[0].flight.onboard is None, timeout=60_000
    )
    assert folder.info().onboard_log == ""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", port))  # the link was given back

"""Windows for the tests, which run without a screen."""

import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import ui.main_window
from gsapp.telemetry.recorder_control import find_recorders
from gsapp.telemetry.recorder_status import RUNTIME_VARIABLE
from tests.ui.window_kit import activate, open_window, opened_window
from ui.main_window import MainWindow


@pytest.fixture
def alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """See no recorder of others, be asked nothing on closing, and leave no recorder behind."""
    monkeypatch.setenv(RUNTIME_VARIABLE, str(tmp_path / "run"))
    monkeypatch.setattr(ui.main_window, "ask_closing", lambda *_: "leave")
    yield
    for recorder in find_recorders():
        recorder.stop()


@pytest.fixture
def window(qtbot: QtBot, tmp_path: Path, alone: None) -> Iterator[MainWindow]:
    """Return a new window that has the keyboard."""
    made = open_window(tmp_path)
    qtbot.addWidget(made)
    activate(qtbot, made)
    yield made
    made.flight_controller.close()


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory, qapp: QApplication) -> Iterator[MainWindow]:
    """Return one window for all tests of a module: styling a window takes a second."""
    with opened_window(tmp_path_factory.mktemp("window")) as window:
        yield window

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
    monkeypatch.setenv(RUNTIME_VARIABLE, str(tmp_path / "run"))
    monkeypatch.setattr(ui.main_window, "ask_closing", lambda *_: "leave")
    yield
    for recorder in find_recorders():
        recorder.stop()


@pytest.fixture
def window(qtbot: QtBot, tmp_path: Path, alone: None) -> Iterator[MainWindow]:
    made = open_window(tmp_path)
    qtbot.addWidget(made)
    activate(qtbot, made)
    yield made
    made.flight_controller.close()


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory, qapp: QApplication) -> Iterator[MainWindow]:
    with opened_window(tmp_path_factory.mktemp("window")) as window:
        yield window

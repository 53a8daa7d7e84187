"""Recorders and the window: finished flights stay apart, recorders are shown and attached to."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from pytestqt.qtbot import QtBot

sys.path.insert(0, str(Path(__file__).parent))

from window_kit import Aircraft, free_port, open_window, until

import ui.opening
from gsapp.flight.raw import RawTail
from gsapp.telemetry.recorder_control import find_recorder, find_recorders
from gsapp.telemetry.status import RUNTIME_VARIABLE
from ui.dialogs.requests import ConnectRequest
from ui.window import MainWindow


@pytest.fixture(autouse=True)
def _own_recorders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setenv(RUNTIME_VARIABLE, str(tmp_path / "run"))
    yield
    for recorder in find_recorders():
        recorder.stop()


@pytest.fixture
def window(tmp_path: Path, qtbot: QtBot) -> Iterator[MainWindow]:
    made = open_window(tmp_path)
    made.ask_nothing()
    qtbot.addWidget(made)
    yield made
    made.close()


def records_in(folder: Path) -> int:
    return len(RawTail(folder).poll()) if folder.is_dir() else 0


def connect(window: MainWindow, port: int, folder: Path, *, append: bool = False) -> None:
    window.desk.starter.connect_aircraft(
        ConnectRequest(
            link=f"udpin:127.0.0.1:{port}", folder=folder, channel_map="b777", aircraft="b777",
            calibration="b777", append=append,
        )
    )  # fmt: skip


def fly(window: MainWindow, qtbot: QtBot, port: int, folder: Path, *, append: bool = False) -> int:
    """Record half a second of flight and end it; return how many records the folder holds."""
    before = records_in(folder)
    connect(window, port, folder, append=append)
    until(qtbot, lambda: window.desk.is_open and window.desk.session.path == folder)
    with Aircraft(port):
        until(qtbot, lambda: records_in(folder) > before + 50)
    window.desk.stop_now()
    return records_in(folder)


def test_a_finished_flight_is_not_appended_to_without_asking(
    window: MainWindow, qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    port, folder = free_port(), tmp_path / "flights" / "first"
    count = fly(window, qtbot, port, folder)
    window.desk.close_flight()
    connect(window, port, folder)
    until(qtbot, lambda: any("finished flight" in text for text in window.banners.texts()))
    assert find_recorder(folder) is None
    # The dialog asks, and offers the next free name.
    asked: list[tuple[str, str]] = []

    def answer(_parent: object, name: str, new: str) -> bool | None:
        asked.append((name, new))
        return answers.pop(0)

    monkeypatch.setattr(ui.opening, "ask_append", answer)
    answers: list[bool | None] = [None, False, True]
    places = [window.opening._where_to_record(folder) for _ in range(3)]
    assert asked == [("first", "first-2")] * 3
    assert places == [None, (folder.with_name("first-2"), False), (folder, True)]
    assert fly(window, qtbot, port, folder, append=True) > count

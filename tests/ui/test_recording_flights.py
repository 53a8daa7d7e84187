"""Recorders and the window: finished flights stay apart, recorders are shown and attached to."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from pytestqt.qtbot import QtBot

sys.path.insert(0, str(Path(__file__).parent))

from window_kit import Aircraft, free_port, open_window, until

import ui.opening
from gsapp.flight.raw import RawTail
from gsapp.telemetry.recorder_control import find_recorder, find_recorders, start_recorder
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


def test_the_bar_shows_a_recorder_of_a_closed_flight_and_attaches_with_a_click(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    port, folder = free_port(), tmp_path / "flights" / "first"
    rec = window.bar.views["record"]
    stop = window.bar._buttons["record"]
    assert rec.part.value == "off"
    assert not stop.isVisible()
    with Aircraft(port):
        connect(window, port, folder)
        until(qtbot, lambda: window.desk.is_open and rec.part.note.startswith("growing"))
        assert stop.isVisible()
        window.desk.close_flight()
        until(qtbot, lambda: rec.part.value == "first")
        assert not stop.isVisible()
        qtbot.mouseClick(rec, Qt.MouseButton.LeftButton)
        until(qtbot, lambda: window.desk.is_open and window.desk.session.path == folder)
        # Another that runs beside the open flight is counted.
        other = start_recorder(f"udpin:127.0.0.1:{free_port()}", tmp_path / "flights" / "second")
        until(qtbot, lambda: "+1" in rec.part.word)
        assert "second" in rec.part.detail
        other.stop()
        until(qtbot, lambda: "+1" not in rec.part.word)


def test_a_flight_ends_with_its_alarms_and_goes_to_review(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    port, folder = free_port(), tmp_path / "flights" / "first"
    with Aircraft(port):
        connect(window, port, folder)
        until(qtbot, lambda: window.desk.is_open and (window.desk.time or 0.0) > 1.5)
    # Switched off: silent, with an alarm.
    until(qtbot, lambda: window.desk.session.board.get("link") is not None)
    assert window.bar.views["link"].part.state == "warning"
    # Were it known to have landed, the silence would be none.
    window.desk.session.landing.landed_at = 1.2
    until(qtbot, lambda: window.bar.views["link"].part.state != "warning")
    until(qtbot, lambda: any("landed" in text for text in window.banners.texts()))
    (banner,) = [one for one in window.banners.banners if "landed" in one.label.text()]
    qtbot.mouseClick(banner.buttons[0], Qt.MouseButton.LeftButton)
    until(qtbot, window.review.isVisible)
    until(qtbot, lambda: find_recorder(folder) is None)
    session = window.desk.session
    assert session.board.standing == ()
    assert any(one.key == "link" for one in session.board.episodes)
    assert window.bar.views["alarms"].part.state == "good"
    assert window.bar.views["record"].part.value == "stopped"
    until(qtbot, lambda: [one.flight.path for one in window.review.review.flights] == [folder])

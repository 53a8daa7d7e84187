"""Notes between two laptops, as the windows show them."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QMenu
from pytestqt.qtbot import QtBot

from gsapp.decoding.channel_map import load_channel_map
from gsapp.flight.events import AUTHOR_KEY, Event, EventLog, events_path
from gsapp.telemetry.recorder_control import find_recorders, start_recorder
from gsapp.telemetry.recorder_status import RUNTIME_VARIABLE
from gsapp.telemetry.recording_settings import RecordingSettings
from gsapp.telemetry.stream_server import ShareRequest, request_shares
from tests.ui.window_kit import Aircraft, connect, free_port, is_followed, open_window, until
from ui.main_window import MainWindow


@pytest.fixture
def window(tmp_path: Path, qtbot: QtBot, monkeypatch: pytest.MonkeyPatch) -> Iterator[MainWindow]:
    monkeypatch.setenv(RUNTIME_VARIABLE, str(tmp_path / "run"))
    made = open_window(tmp_path, shares=(f"tcpin:127.0.0.1:{free_port()}",))
    made.disable_close_questions()
    qtbot.addWidget(made)
    yield made
    made.close()
    for recorder in find_recorders():
        recorder.stop()


def follow(window: MainWindow, qtbot: QtBot, port: int, folder: Path, kind: str) -> None:
    connect(window, port, folder, kind=kind)
    until(qtbot, lambda: is_followed(window, folder) and window.flight_controller.is_recording)


def trigger(window: MainWindow, qtbot: QtBot, text: str) -> bool:
    """Switch what the menu at REC calls so, and return whether it was on."""
    qtbot.mouseClick(window.status_bar.item_widgets["record"], Qt.MouseButton.LeftButton)
    menu = window.findChild(QMenu, "recorders")
    until(qtbot, menu.isVisible)
    (action,) = [one for one in menu.actions() if text in one.text()]
    was_on = action.isChecked()
    action.trigger()
    menu.close()
    until(qtbot, lambda: window.findChild(QMenu, "recorders") is None)
    return was_on


def test_the_crew_takes_notes_by_a_switch_that_is_off_at_first(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    port, folder = free_port(), tmp_path / "flights" / "first"
    with Aircraft(port):
        follow(window, qtbot, port, folder, "udpin")
        recorder = window.flight_controller.recorders.current

        def state() -> tuple[int, bool]:
            status = recorder.status()
            return len(status.shares), status.share_notes

        assert not trigger(window, qtbot, window.store.current.shares[0].rpartition(":")[2])
        rec = window.status_bar.item_widgets["record"]
        until(qtbot, lambda: "SHARED" in rec.item.title)
        assert state() == (1, False)
        assert not trigger(window, qtbot, "Take notes")
        until(qtbot, lambda: state() == (1, True))
        until(qtbot, lambda: window.flight_controller.session.equipment.recorder.share_notes)
        assert trigger(window, qtbot, "Take notes")
        until(qtbot, lambda: state() == (1, False))
        data = {"id": "a1", AUTHOR_KEY: "laptop2 (192.0.2.7)"}
        EventLog(events_path(folder)).append(Event(kind="note", text="gusty", time=1.0, data=data))
        marks = window.view.marks.view.model()
        until(qtbot, lambda: marks.rowCount() == 1)
        tip = marks.index(0, 1).data(Qt.ItemDataRole.ToolTipRole)
        assert "laptop2 (192.0.2.7)" in tip
        assert marks.index(0, 1).data() == "gusty"


def test_the_files_of_the_flight_count_and_not_those_used_last(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    port, shared, first = free_port(), free_port(), tmp_path / "other laptop"
    link = f"udpin:127.0.0.1:{port}"
    settings = RecordingSettings(aircraft="b777", channel_map="b777-thin", calibration="b777")
    settings.prepare_folder(first, link)
    start_recorder(link, first)
    request_shares(first, ShareRequest(links=(f"tcpin:127.0.0.1:{shared}",)))
    until(qtbot, lambda: bool(find_recorders()[0].status().shares))
    second = tmp_path / "flights" / "second"
    follow(window, qtbot, shared, second, "gsapp")  # which names b777
    found = window.flight_controller.session.decoder.channel_map
    assert found.name == load_channel_map("b777-thin").name
    assert found.name != load_channel_map("b777").name


@pytest.mark.parametrize("takes_notes", [False, True])
def test_a_laptop_says_once_where_its_notes_stay(
    window: MainWindow, qtbot: QtBot, tmp_path: Path, takes_notes: bool
) -> None:
    port, shared, first = free_port(), free_port(), tmp_path / "other laptop"
    start_recorder(f"udpin:127.0.0.1:{port}", first)
    links = (f"tcpin:127.0.0.1:{shared}",)
    request_shares(first, ShareRequest(links=links, takes_notes=takes_notes))
    second = tmp_path / "flights" / "second"
    with Aircraft(port):
        follow(window, qtbot, shared, second, "gsapp")
        controller = window.flight_controller
        until(
            qtbot,
            lambda: (
                controller.session.equipment.recorder.sends_notes is takes_notes
                and controller.time is not None
            ),
        )
        for _ in range(2):
            controller.mark(None, "gusty")
        said = [text for text in window.banners.texts() if "stay on this computer" in text]
        assert len(said) == (0 if takes_notes else 1)
        if takes_notes:
            path = events_path(first)
            until(qtbot, lambda: path.is_file() and path.read_text().count('"gusty"') == 2)

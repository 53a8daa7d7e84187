"""Recorders and the window: finished flights stay apart, recorders are shown and attached to."""

import os
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QFontMetricsF
from PySide6.QtWidgets import QApplication, QMenu, QMessageBox, QPushButton
from pytestqt.qtbot import QtBot

from gsapp.decoding.dialect import dialect
from gsapp.flight.raw_files import RawTail
from gsapp.telemetry.recorder_control import find_recorder, find_recorders, start_recorder
from gsapp.telemetry.recorder_folder import record_state
from gsapp.telemetry.recorder_status import HEARTBEAT_END, RUNTIME_VARIABLE
from tests.ui.window_kit import (
    KILL,
    Aircraft,
    answer_dialog,
    connect,
    free_port,
    is_followed,
    open_window,
    until,
)
from ui.dialogs.connect import ConnectDialog
from ui.main_window import MainWindow
from ui.sharing_menu import ShareDialog
from ui.window_frame.status_bar import _break_text

_GCS = 6  # MAV_TYPE_GCS, what a ground station calls itself in its heartbeats


@pytest.fixture(autouse=True)
def _own_recorders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setenv(RUNTIME_VARIABLE, str(tmp_path / "run"))
    yield
    for recorder in find_recorders():
        recorder.stop()


@pytest.fixture
def window(tmp_path: Path, qtbot: QtBot) -> Iterator[MainWindow]:
    made = open_window(tmp_path)
    made.disable_close_questions()
    qtbot.addWidget(made)
    yield made
    made.close()


def records_in(folder: Path) -> int:
    return len(RawTail(folder).poll()) if folder.is_dir() else 0


def fly(window: MainWindow, qtbot: QtBot, port: int, folder: Path, *, append: bool = False) -> int:
    before = records_in(folder)
    connect(window, port, folder, append=append)
    until(qtbot, lambda: is_followed(window, folder))
    with Aircraft(port):
        until(qtbot, lambda: records_in(folder) > before + 50)
    window.flight_controller.recorders.stop_recording_and_wait()
    return records_in(folder)


def test_a_finished_flight_is_not_appended_to_without_asking(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    port, folder = free_port(), tmp_path / "flights" / "first"
    count = fly(window, qtbot, port, folder)
    window.flight_controller.close_flight()
    connect(window, port, folder)
    until(qtbot, lambda: any("finished flight" in text for text in window.banners.texts()))
    assert find_recorder(folder) is None
    assert fly(window, qtbot, port, folder, append=True) > count


@pytest.mark.parametrize(
    ("answer", "recorded"),
    [
        ("New flight", "first-2"),
        ("Append", "first"),
        ("Cancel", None),
        (Qt.Key.Key_Return, "first-2"),
        (Qt.Key.Key_Escape, None),
    ],
)
def test_a_name_of_a_finished_flight_asks_for_a_new_flight_or_appends(
    window: MainWindow, qtbot: QtBot, tmp_path: Path, answer: str | Qt.Key, recorded: str | None
) -> None:
    """By mouse or key; the dialog stays, with all that was typed, where neither is wanted."""
    folder = tmp_path / "flights" / "first"
    folder.mkdir(parents=True)
    (folder / "raw.tlog").write_bytes(b"flown")
    assert record_state(folder) == "finished"

    def reply(box: QMessageBox) -> None:
        if isinstance(answer, Qt.Key):
            qtbot.keyClick(box, answer)
        else:
            (button,) = [one for one in box.buttons() if one.text() == answer]
            qtbot.mouseClick(button, Qt.MouseButton.LeftButton)

    def fill(dialog: ConnectDialog) -> None:
        dialog.link.text.setEditText(f"udpin:127.0.0.1:{free_port()}")
        dialog.folder_field.name.setText("first")
        answer_dialog(QMessageBox, reply)
        qtbot.mouseClick(dialog.button, Qt.MouseButton.LeftButton)
        until(qtbot, lambda: not dialog.is_connecting or not dialog.isVisible())
        stays = (dialog.isVisible(), dialog.button.isEnabled(), dialog.folder_field.name.text())
        assert stays == (recorded is None, recorded is None, "first")

    answer_dialog(ConnectDialog, fill)
    window.commands.actions["connect"].trigger()
    running = [found.folder for found in find_recorders()]
    assert running == ([] if recorded is None else [folder.with_name(recorded)])
    assert window.flight_controller.is_open == (recorded is not None)


@pytest.mark.parametrize("by_key", [False, True])
def test_several_recorders_are_chosen_from_a_menu_on_the_record_tile(
    window: MainWindow, qtbot: QtBot, tmp_path: Path, by_key: bool
) -> None:
    """Esc attaches to none; a line attaches to its recorder, and is not listed beside it."""
    controller = window.flight_controller
    rec = window.status_bar.item_widgets["record"]
    links = {
        start_recorder(f"udpin:127.0.0.1:{free_port()}", tmp_path / name).folder: name
        for name in ("one", "two", "three")
    }
    until(qtbot, lambda: len(controller.recorders.others) == 3)

    def menu() -> QMenu:
        qtbot.mouseClick(rec, Qt.MouseButton.LeftButton)
        until(qtbot, lambda: isinstance(QApplication.activePopupWidget(), QMenu))
        return QApplication.activePopupWidget()

    opened = menu()
    assert len(opened.actions()) == 3
    qtbot.keyClick(opened, Qt.Key.Key_Escape)
    assert (opened.isVisible(), controller.is_open) == (False, False)
    for others in (3, 2):
        opened = menu()
        attach = [one for one in opened.actions() if one.text().startswith("Attach")]
        assert attach == opened.actions()[:others]
        row = others - 2
        wanted = controller.recorders.others[row].handle.folder
        assert links[wanted] in opened.actions()[row].text()
        if by_key:
            for _ in range(row + 1):
                qtbot.keyClick(opened, Qt.Key.Key_Down)
            qtbot.keyClick(opened, Qt.Key.Key_Return)
        else:
            place = opened.actionGeometry(opened.actions()[row]).center()
            qtbot.mouseClick(opened, Qt.MouseButton.LeftButton, pos=place)
        until(qtbot, lambda wanted=wanted: controller.is_open
              and controller.session.path == wanted)  # fmt: skip
    assert len(find_recorders()) == 3


def heard_heartbeats(vehicle: socket.socket) -> int:
    """Return how many heartbeats of a ground station have arrived since the last call."""
    parser, found = dialect().MAVLink(None), 0
    while True:
        try:
            data = vehicle.recv(2048)
        except BlockingIOError:
            return found
        messages = parser.parse_buffer(data) or ()
        found += sum(one.get_type() == "HEARTBEAT" and one.type == _GCS for one in messages)


@pytest.mark.parametrize("sends", [True, False])
@pytest.mark.parametrize("way", ["button", "close", "close without the flight"])
def test_the_end_of_heartbeats_is_cautioned_against(
    qtbot: QtBot, tmp_path: Path, way: str, sends: bool
) -> None:
    """Of a recording that sends none, nothing of it is said."""
    window = open_window(tmp_path)
    qtbot.addWidget(window)
    controller, folder = window.flight_controller, tmp_path / "flights" / "first"
    asked: list[str] = []

    def stop(box: QMessageBox) -> None:
        asked.append(box.informativeText())
        (button,) = [one for one in box.buttons() if one.text() == "Stop recording"]
        qtbot.mouseClick(button, Qt.MouseButton.LeftButton)

    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as vehicle:
        vehicle.bind(("127.0.0.1", 0))
        vehicle.setblocking(False)
        port = vehicle.getsockname()[1] if sends else free_port()
        connect(window, port, folder, kind="udpout" if sends else "udpin")
        until(qtbot, lambda: is_followed(window, folder))
        if sends:
            until(qtbot, lambda: heard_heartbeats(vehicle) > 0)
            until(qtbot, lambda: bool(controller.stop_caution))
        else:
            until(qtbot, window.status_bar._buttons["record"].isVisible)
        if way == "close without the flight":
            controller.close_flight()
            until(qtbot, lambda: [one.sends_heartbeats for one in controller.recorders.left_running]
                  == [sends])  # fmt: skip
        answer_dialog(QMessageBox, stop)
        if way == "button":
            qtbot.mouseClick(window.status_bar._buttons["record"], Qt.MouseButton.LeftButton)
        else:
            assert window.close()
        assert [HEARTBEAT_END in text for text in asked] == [sends]
        until(qtbot, lambda: find_recorder(folder) is None)
        heard_heartbeats(vehicle)
        qtbot.wait(2_500)
        assert heard_heartbeats(vehicle) == 0
    window.disable_close_questions()
    window.close()


def test_a_landed_flight_that_ends_cautions_against_the_end_of_heartbeats(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    """Its button stops without a question."""
    folder = tmp_path / "flights" / "first"
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as vehicle:
        vehicle.bind(("127.0.0.1", 0))
        connect(window, vehicle.getsockname()[1], folder, kind="udpout")
        until(qtbot, lambda: bool(window.flight_controller.stop_caution))
        window.flight_controller.landed.emit(10.0)
        buttons = window.banners.findChildren(QPushButton)
        (end,) = [one for one in buttons if one.text() == "End flight and review"]
        qtbot.mouseClick(end, Qt.MouseButton.LeftButton)
        assert any(HEARTBEAT_END in text for text in window.banners.texts())
        until(qtbot, lambda: find_recorder(folder) is None)


def test_the_bar_shows_a_recorder_of_a_closed_flight_and_attaches_with_a_click(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    port, folder = free_port(), tmp_path / "flights" / "first"
    rec = window.status_bar.item_widgets["record"]
    stop = window.status_bar._buttons["record"]
    assert rec.item.value == "off"
    assert not stop.isVisible()
    with Aircraft(port):
        connect(window, port, folder)
        until(
            qtbot, lambda: window.flight_controller.is_open and rec.item.note.startswith("growing")
        )
        assert stop.isVisible()
        window.flight_controller.close_flight()
        until(qtbot, lambda: rec.item.value == "first")
        assert not stop.isVisible()
        qtbot.mouseClick(rec, Qt.MouseButton.LeftButton)
        until(qtbot, lambda: is_followed(window, folder))
        # Another that runs beside the open flight is counted.
        other = start_recorder(f"udpin:127.0.0.1:{free_port()}", tmp_path / "flights" / "second")
        until(qtbot, lambda: "+1" in rec.item.title)
        assert "second" in rec.item.detail
        other.stop()
        until(qtbot, lambda: "+1" not in rec.item.title)


def switch_share(window: MainWindow, qtbot: QtBot, link: str) -> None:
    rec = window.status_bar.item_widgets["record"]
    qtbot.mouseClick(rec, Qt.MouseButton.LeftButton)
    menu = window.findChild(QMenu, "recorders")
    until(qtbot, menu.isVisible)
    port = link.rpartition(":")[2]
    (switch,) = [one for one in menu.actions() if one.isCheckable() and port in one.text()]
    switch.trigger()
    menu.close()
    until(qtbot, lambda: window.findChild(QMenu, "recorders") is None)


def test_the_flight_is_shared_by_a_switch_at_the_recorder(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    port, folder = free_port(), tmp_path / "flights" / "first"
    with socket.create_server(("127.0.0.1", 0)) as probe:
        shared = probe.getsockname()[1]
    link, refused = f"tcpin:127.0.0.1:{shared}", "udpout:192.0.2.1:14550"
    window.store.replace(window.store.current.with_values(shares=(link, refused)))
    rec = window.status_bar.item_widgets["record"]
    with Aircraft(port):
        connect(window, port, folder)
        until(
            qtbot, lambda: window.flight_controller.is_open and rec.item.note.startswith("growing")
        )
        assert "SHARED" not in rec.item.title
        switch_share(window, qtbot, link)
        until(qtbot, lambda: "SHARED" in rec.item.title)
        with socket.create_connection(("127.0.0.1", shared)) as client:
            client.settimeout(10.0)
            assert client.recv(1) in (b"\xfd", b"\xfe")  # a frame begins
            until(qtbot, lambda: "1 client" in rec.item.detail)
            # One that cannot be used leaves the other as it is, and is said.
            switch_share(window, qtbot, refused)
            until(qtbot, lambda: any(refused in text for text in window.banners.texts()))
            assert client.recv(1)
        status = window.flight_controller.recorders.current.status()
        assert [bool(share.error) for share in status.shares] == [False, True]
        switch_share(window, qtbot, link)
        until(qtbot, lambda: "SHARED" not in rec.item.title)
        with pytest.raises(ConnectionRefusedError):
            socket.create_connection(("127.0.0.1", shared))


def test_another_address_is_shared_with_and_remembered(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    port, folder, shared = free_port(), tmp_path / "flights" / "first", free_port()
    link = f"udpout:127.0.0.1:{shared}"
    with Aircraft(port), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        connect(window, port, folder)
        until(qtbot, lambda: is_followed(window, folder))
        until(qtbot, lambda: window.flight_controller.is_recording)

        def type_address(dialog: ShareDialog) -> None:
            dialog.edit.setText("serial:/dev/ttyUSB0:57600")
            assert not dialog.button.isEnabled()
            dialog.edit.setText(link)
            assert dialog.button.isEnabled()
            dialog.accept()

        other.bind(("127.0.0.1", shared))
        other.settimeout(20.0)
        answer_dialog(ShareDialog, type_address)
        window.file_menu.sharing.ask_address()
        assert window.store.current.shares[0] == link
        until(qtbot, lambda: window.flight_controller.recorders.current.status().shares != [])
        assert other.recv(1000)


def test_a_flight_ends_with_its_alarms_and_goes_to_review(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    controller = window.flight_controller
    port, folder = free_port(), tmp_path / "flights" / "first"
    with Aircraft(port):
        connect(window, port, folder)
        until(qtbot, lambda: controller.is_open and (controller.time or 0.0) > 1.5)
    # Switched off: silent, with an alarm.
    until(qtbot, lambda: controller.session.alarm_registry.get("link") is not None)
    assert window.status_bar.item_widgets["link"].item.state == "warning"
    # Words that the tile cuts off are in its tool tip, also under a pointer that rests on it.
    alarms = window.status_bar.item_widgets["alarms"]
    until(qtbot, lambda: alarms.item.state == "warning")
    assert alarms.item.value in alarms.toolTip()
    # The most urgent of all alarms is whole on two lines of the tile.
    metrics = QFontMetricsF(window.display_style.font("label", strong=True))
    wide = alarms.width() - 2 * window.display_style.px(8)
    _, rest = _break_text(alarms.item.value, metrics, wide)
    assert rest
    assert metrics.horizontalAdvance(rest) <= wide
    # Were it known to have landed, the silence would be none.
    controller.session.landing.landed_at = 1.2
    until(qtbot, lambda: window.status_bar.item_widgets["link"].item.state != "warning")
    until(qtbot, lambda: any("landed" in text for text in window.banners.texts()))
    (banner,) = [one for one in window.banners.banners if "landed" in one.label.text()]
    qtbot.mouseClick(banner.buttons[0], Qt.MouseButton.LeftButton)
    until(qtbot, window.review_page.isVisible)
    until(qtbot, lambda: find_recorder(folder) is None)
    session = controller.session
    assert session.alarm_registry.current_alarms == ()
    assert any(one.key == "link" for one in session.alarm_registry.episodes)
    assert window.status_bar.item_widgets["alarms"].item.state == "good"
    assert window.status_bar.item_widgets["record"].item.value == "stopped"
    until(qtbot, lambda: [one.flight.path for one in window.review_page.review.flights] == [folder])


def test_a_recorder_that_dies_is_restarted_and_one_that_is_stopped_is_not(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    folder, port = tmp_path / "flight", free_port()
    controller = window.flight_controller
    connect(window, port, folder)
    until(qtbot, lambda: is_followed(window, folder))
    with Aircraft(port):
        until(qtbot, lambda: records_in(folder) > 50)
        died = find_recorder(folder)
        os.kill(died.pid, KILL)
        until(qtbot, lambda: (find_recorder(folder) or died).pid != died.pid)
        before = records_in(folder)
        until(qtbot, lambda: records_in(folder) > before + 50)
        until(qtbot, lambda: controller.snapshot.recorder.state == "recording")
        assert controller.session.alarm_registry.get("recorder") is not None
        controller.recorders.stop_recording()
        until(qtbot, lambda: controller.snapshot.recorder.state == "stopped")
        qtbot.wait(1000)
    assert find_recorder(folder) is None
    assert len(controller.recorders._restarts) == 1

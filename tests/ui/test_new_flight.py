"""Title and folder of a new flight: fresh each time, and remembered once a recording began."""

import os
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from pytestqt.qtbot import QtBot

from gsapp.flight.folder import FlightFolder
from tests.ui.window_kit import answer_dialog, free_port, is_followed, until
from ui.dialogs.connect import ConnectDialog
from ui.dialogs.virtual_flight import VirtualFlightDialog
from ui.main_window import MainWindow


def connect(window: MainWindow, qtbot: QtBot, title: str = "", parent: Path | None = None) -> Path:
    folders: list[Path] = []

    def answer(dialog: ConnectDialog) -> None:
        dialog.link.text.setEditText(f"udpin:127.0.0.1:{free_port()}")
        dialog.folder_field.title.setText(title)
        if parent is not None:
            dialog.folder_field.parent_folder.edit.setText(str(parent))
        folders.append(dialog.folder_field.folder)
        dialog.button.click()
        until(qtbot, lambda: not dialog.isVisible() or not dialog.is_connecting)

    answer_dialog(ConnectDialog, answer)
    window.commands.actions["connect"].trigger()
    return folders[0]


def test_a_title_names_one_flight_and_no_folder(window: MainWindow, qtbot: QtBot) -> None:
    controller = window.flight_controller
    first = connect(window, qtbot, "Maiden flight")
    until(qtbot, lambda: controller.is_recording)
    assert first.name.endswith("-a")
    assert FlightFolder(path=first).name == controller.name == "Maiden flight"
    controller.recorders.stop_recording_and_wait()
    second = connect(window, qtbot)
    until(qtbot, lambda: is_followed(window, second))
    until(qtbot, lambda: controller.is_recording)
    assert second.name.endswith("-b")
    assert controller.name == second.name


def test_a_folder_is_remembered_once_a_recording_began_in_it(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    before = window.store.current.flights
    blocked = connect_and_block(window, qtbot, tmp_path / "refused")
    assert not blocked.is_dir()
    assert window.store.current.flights == before
    folder = connect(window, qtbot, parent=tmp_path / "mine")
    until(qtbot, lambda: window.flight_controller.is_recording)
    assert folder.is_dir()
    assert window.store.current.flights == str(tmp_path / "mine")


def connect_and_block(window: MainWindow, qtbot: QtBot, parent: Path) -> Path:
    folders: list[Path] = []

    def answer(dialog: ConnectDialog) -> None:
        dialog.link.text.setEditText(f"udpin:127.0.0.1:{free_port()}")
        dialog.folder_field.parent_folder.edit.setText(str(parent))
        folders.append(dialog.folder_field.folder)
        parent.touch()
        dialog.button.click()
        until(qtbot, lambda: not dialog.is_connecting)
        assert dialog.isVisible()

    answer_dialog(ConnectDialog, answer)
    window.commands.actions["connect"].trigger()
    return folders[0]


@pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid() == 0, reason="root writes everywhere")
@pytest.mark.parametrize(("command", "kind"), [("connect", ConnectDialog),
                                               ("virtual", VirtualFlightDialog)])  # fmt: skip
def test_a_folder_without_permission_is_refused_beside_its_field(
    window: MainWindow,
    qtbot: QtBot,
    tmp_path: Path,
    command: str,
    kind: type[ConnectDialog | VirtualFlightDialog],
) -> None:
    """Typed, of an existing flight, or locked while the dialog is open."""
    locked, late = tmp_path / "locked", tmp_path / "late"
    (tmp_path / "flights" / "old").mkdir(parents=True, mode=0o555)
    locked.mkdir(mode=0o555)
    late.mkdir()
    before = window.store.current.flights

    def answer(dialog: ConnectDialog | VirtualFlightDialog) -> None:
        place = dialog.folder_field
        if isinstance(dialog, ConnectDialog):
            dialog.link.text.setEditText(f"udpin:127.0.0.1:{free_port()}")
        for parent, name in ((locked / "below", "new"), (tmp_path / "flights", "old")):
            place.parent_folder.edit.selectAll()
            qtbot.keyClicks(place.parent_folder.edit, str(parent))
            place.name.setText(name)
            assert (place.input_check.state, dialog.button.isEnabled()) == ("warning", False)
        place.parent_folder.edit.setText(str(late))
        place.title.setText("Maiden flight")
        late.chmod(0o555)
        assert place.input_check.is_valid
        qtbot.mouseClick(dialog.button, Qt.MouseButton.LeftButton)
        until(qtbot, lambda: not dialog.is_connecting)
        assert dialog.isVisible()
        assert str(late) in place.message.text()
        assert place.message.property("state") == "warning"
        assert (place.folder, place.title.text()) == (late / "old", "Maiden flight")

    answer_dialog(kind, answer)
    window.commands.actions[command].trigger()
    assert window.store.current.flights == before
    assert (window.flight_controller.is_open, window.banners.texts()) == (False, ())

"""The dialog that connects an aircraft: a failure keeps what was typed, a test hears systems."""

import socket
import sys
from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QAbstractButton
from pytestqt.qtbot import QtBot

from gsapp.decoding.dialect import dialect
from gsapp.telemetry.signing import derive_key, read_signing_key
from tests.ui.window_kit import Aircraft, answer_dialog, free_port, until
from ui.dialogs.connect import ConnectDialog, connection_options
from ui.display_style import DisplayStyle
from ui.main_window import MainWindow
from ui.settings import Settings


def test_a_failed_connection_leaves_all_that_was_typed_and_no_recent_link(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    """The dialog stays with the error beside the link; a port that works closes it."""
    seen: list[tuple[bool, str, str, str]] = []
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))
        taken = other.getsockname()[1]
        good = free_port()

        def fill(dialog: ConnectDialog) -> None:
            dialog.link.text.setEditText(f"udpin:127.0.0.1:{taken}")
            dialog.folder_field.name.setText("typed by hand")
            dialog.folder_field.parent_folder.edit.setText(str(tmp_path / "elsewhere"))
            qtbot.mouseClick(dialog.button, Qt.MouseButton.LeftButton)
            until(qtbot, lambda: "in use" in dialog.link.message.text())
            seen.append((
                dialog.isVisible(), dialog.link.value, dialog.folder_field.name.text(),
                window.store.current.flights,
            ))  # fmt: skip
            dialog.link.text.setEditText(f"udpin:127.0.0.1:{good}")
            qtbot.mouseClick(dialog.button, Qt.MouseButton.LeftButton)
            until(qtbot, lambda: not dialog.isVisible())

        former = window.store.current.flights
        answer_dialog(ConnectDialog, fill)
        window.file_menu.connect_aircraft()
    assert seen == [(True, f"udpin:127.0.0.1:{taken}", "typed by hand", former)]
    assert window.flight_controller.name == "typed by hand"
    assert window.store.current.flights == str(tmp_path / "elsewhere")
    # Over it nothing has come yet.
    assert window.store.current.links == ()
    with Aircraft(good):
        until(qtbot, lambda: window.store.current.links == (f"udpin:127.0.0.1:{good}",))
    window.flight_controller.recorders.stop_recording_and_wait()


def test_a_recent_link_that_fails_opens_the_dialog_with_its_reason(
    window: MainWindow, qtbot: QtBot
) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))
        link = f"udpin:127.0.0.1:{other.getsockname()[1]}"
        window.store.change(links=(link,))
        window.flight_page.start.show_links((link,))
        seen: list[tuple[str, bool, bool]] = []

        def read(dialog: ConnectDialog) -> None:
            reason = "in use" in dialog.link.message.text()
            seen.append((dialog.link.value, reason, dialog.button.isEnabled()))

        answer_dialog(ConnectDialog, read)
        (button,) = [
            one
            for one in window.flight_page.start.findChildren(QAbstractButton)
            if link in one.text()
        ]
        qtbot.mouseClick(button, Qt.MouseButton.LeftButton)
        until(qtbot, lambda: bool(seen))
    assert seen == [(link, True, True)]
    assert (window.banners.texts(), window.store.current.links) == ((), (link,))


def test_a_link_is_tested_in_the_dialog_and_the_flown_system_chosen_among_those_heard(
    qtbot: QtBot, tmp_path: Path
) -> None:
    port = free_port()
    dialog = ConnectDialog(
        Settings(links=(f"udpin:127.0.0.1:{port}",)), DisplayStyle(), connection_options(), tmp_path
    )
    qtbot.addWidget(dialog)
    test = dialog.test
    assert dialog.request.system is None
    qtbot.mouseClick(test.button, Qt.MouseButton.LeftButton)
    until(qtbot, lambda: f"No data on UDP port {port}" in test.message.text())
    beat = dialect().MAVLink_heartbeat_message(1, 3, 0, 0, 4, 3)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        for system in (1, 7):
            data = bytes(beat.pack(dialect().MAVLink(None, system, 1)))
            sender.sendto(data, ("127.0.0.1", port))
    until(qtbot, lambda: test.systems.count() == 3)
    assert test.systems.itemData(0) is None
    test.systems.setCurrentIndex(2)
    assert (dialog.request.system, dialog.request.address) == (7, "127.0.0.1")
    # What was heard on one link says nothing of another; the port is free again.
    dialog.link.port.set_value(free_port())
    assert (test.systems.count(), dialog.request.system) == (1, None)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as again:
        again.bind(("127.0.0.1", port))


def test_listen_only_and_the_signing_key_are_remembered_but_no_key_is_in_the_settings(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    """The passphrase makes a key file beside the settings, for the user alone."""

    def fill(dialog: ConnectDialog) -> None:
        dialog.link.text.setEditText(f"udpin:127.0.0.1:{free_port()}")
        dialog.folder_field.parent_folder.edit.setText(str(tmp_path / "flights"))
        dialog.listen_only.setChecked(True)
        dialog.signing_key.use_passphrase("words of the crew")
        qtbot.mouseClick(dialog.button, Qt.MouseButton.LeftButton)
        until(qtbot, lambda: not dialog.isVisible())

    answer_dialog(ConnectDialog, fill)
    window.file_menu.connect_aircraft()
    key = window.store.path.parent / "signing.key"
    kept = window.store.current
    assert (kept.listen_only, kept.signing_key) == (True, str(key))
    assert read_signing_key(key) == derive_key("words of the crew")
    assert sys.platform == "win32" or key.stat().st_mode & 0o777 == 0o600
    assert derive_key("words of the crew").hex() not in window.store.path.read_text()
    recorder = window.flight_controller.recorders.current
    assert recorder is not None
    until(qtbot, lambda: (status := recorder.status()) is not None and status.listen_only)
    window.flight_controller.recorders.stop_recording_and_wait()


def test_a_key_file_that_cannot_be_used_is_refused_in_the_dialog(
    qtbot: QtBot, tmp_path: Path
) -> None:
    dialog = ConnectDialog(
        Settings(links=("udpin:127.0.0.1:14550",)), DisplayStyle(), connection_options(), tmp_path
    )
    qtbot.addWidget(dialog)
    assert dialog.is_valid
    dialog.signing_key.edit.setText(str(tmp_path / "missing"))
    assert not dialog.is_valid
    assert not dialog.button.isEnabled()


def test_a_link_test_sends_nothing_where_the_dialog_listens_only(
    qtbot: QtBot, tmp_path: Path
) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as aircraft:
        aircraft.bind(("127.0.0.1", 0))
        link = f"udpout:127.0.0.1:{aircraft.getsockname()[1]}"
        dialog = ConnectDialog(
            Settings(links=(link,), listen_only=True),
            DisplayStyle(), connection_options(), tmp_path,
        )  # fmt: skip
        qtbot.addWidget(dialog)
        aircraft.settimeout(0.0)
        for listen_only, silent in ((True, True), (False, False)):
            dialog.listen_only.setChecked(listen_only)
            qtbot.mouseClick(dialog.test.button, Qt.MouseButton.LeftButton)
            qtbot.wait(1500)
            try:
                heard = len(aircraft.recv(4096))
            except BlockingIOError:
                heard = 0
            assert (heard == 0) is silent
        dialog.test.stop()

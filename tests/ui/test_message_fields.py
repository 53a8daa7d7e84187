"""Fields of a message that no map names, charted from the MAVLink inspector."""

import struct
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QPushButton
from pytestqt.qtbot import QtBot

from gsapp.aircraft.aircraft_loader import SHIPPED_AIRCRAFT
from gsapp.decoding.channel_map import SHIPPED_CHANNEL_MAPS as MAPS
from gsapp.flight.folder import FlightFolder
from tests.flight.box_kit import START_US, box_tlog, dialect
from tests.ui.window_kit import answer_dialog, open_window, until
from ui.dialogs.mavlink_inspector import MavlinkInspector
from ui.main_window import MainWindow

FIELD = "VIBRATION.vibration_y"


def vibration_tlog(seconds: float) -> bytes:
    """Return VIBRATION ten times a second; vibration_y are the seconds since its first."""
    sender = dialect.MAVLink(None, srcSystem=1, srcComponent=1)
    data = bytearray()
    for k in range(round(10 * seconds)):
        message = sender.vibration_encode(round((10.0 + k / 10) * 1e6), 0.0, k / 10, 0.0, 0, 0, 0)
        data += struct.pack(">Q", START_US + 100_000 * k + 1) + message.pack(sender)
        sender.seq = (sender.seq + 1) % 256
    return bytes(data)


def records(data: bytes) -> Iterator[tuple[int, bytes]]:
    while data:
        size = 8 + 12 + data[9]
        yield int.from_bytes(data[:8], "big"), data[:size]
        data = data[size:]


@pytest.fixture
def opened(qtbot: QtBot, tmp_path: Path, alone: None) -> Iterator[MainWindow]:
    folder = FlightFolder.create(tmp_path / "flight")
    both = sorted([*records(box_tlog(5.0)), *records(vibration_tlog(5.0))])
    folder.tlog_file.write_bytes(b"".join(record for _, record in both))
    folder.store_channel_map(MAPS.find("b777"))
    folder.store_aircraft(SHIPPED_AIRCRAFT.find("b777"))
    window = open_window(tmp_path)
    qtbot.addWidget(window)
    window.flight_controller.flight_opener.open_flight(folder.path, playing=False)
    until(qtbot, lambda: window.flight_controller.is_loaded)
    window.flight_controller.seek(13.0)
    until(qtbot, lambda: window.flight_controller.is_up_to_date)
    yield window
    window.close()


def test_fields_of_a_message_become_channels(opened: MainWindow, qtbot: QtBot) -> None:
    controller = opened.flight_controller
    assert FIELD not in controller.history.channels

    def press(dialog: MavlinkInspector) -> None:
        rows = dialog.messages.view.row_model.rows
        place = [row.cells[0] for row in rows].index("VIBRATION")
        dialog.messages.view.setCurrentIndex(dialog.messages.view.model().index(place, 0))
        (button,) = dialog.messages.view.parent().parent().findChildren(QPushButton)
        QTest.mouseClick(button, Qt.MouseButton.LeftButton)

    answer_dialog(MavlinkInspector, press)
    opened.commands.actions["link"].trigger()
    until(qtbot, lambda: controller.is_loaded and FIELD in controller.history.channels)
    until(qtbot, lambda: controller.time == pytest.approx(13.0, abs=0.05))
    samples = controller.history.samples(FIELD, 1100, 1300)
    np.testing.assert_allclose(samples, np.arange(1.0, 3.0, 0.01), atol=0.11)
    # It is found in the list of channels, and drawn when it is checked.
    panel = opened.view.channels
    assert panel.search.text() == "VIBRATION."
    until(qtbot, lambda: FIELD in panel._available)
    QTest.keyClick(panel.search, Qt.Key.Key_Return)
    until(
        qtbot,
        lambda: any(
            name.startswith("VIBRATION.") for name in opened.view.charts.strip_layout.channels
        ),
    )

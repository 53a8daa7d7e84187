"""A stranger on the network: alarm, LINK tile, and the choice of the crew."""

import sys
import threading
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QMenu
from pytestqt.qtbot import QtBot

from gsapp.session.limits import Severity
from tests.session.test_strangers import AIRCRAFT, STRANGER, Transmitter
from tests.ui.window_kit import free_port, until
from ui.dialogs.flight_requests import ConnectRequest
from ui.main_window import MainWindow

pytestmark = pytest.mark.skipif(
    sys.platform != "linux", reason="only Linux has every address of 127.0.0.0/8 at once"
)


def test_a_stranger_raises_an_alarm_and_is_chosen_on_the_link_tile(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    """Here the stranger was heard first, and the aircraft is what the crew chooses."""
    controller = window.flight_controller
    port = free_port()
    controller.flight_opener.connect_aircraft(
        ConnectRequest(
            link=f"udpin:0.0.0.0:{port}", folder=tmp_path / "flights" / "first",
            channel_map="ardupilot-plane", aircraft="b777", calibration="",
        )
    )  # fmt: skip
    until(qtbot, lambda: controller.is_open)
    stop = threading.Event()

    def transmit() -> None:
        senders = [(Transmitter(STRANGER, port), 0.9), (Transmitter(AIRCRAFT, port), 0.1)]
        while not stop.wait(0.02):
            for sender, roll in senders:
                sender.heartbeat()
                sender.attitude(roll)

    transmitter = threading.Thread(target=transmit)
    transmitter.start()
    try:
        tile = window.status_bar.item_widgets["link"]
        until(qtbot, lambda: tile.item.title == "LINK  SYSTEM 1")
        former = controller.session
        assert former is not None
        until(qtbot, lambda: former.equipment.link.assumed_address.startswith(STRANGER))
        assert former.equipment.link.assumed_address in tile.item.detail
        until(qtbot, lambda: former.alarm_registry.severity("stranger") is Severity.WARNING)
        qtbot.mouseClick(tile, Qt.MouseButton.LeftButton)
        menu = window.findChild(QMenu, "flown_system")
        until(qtbot, menu.isVisible)
        choices = [action for action in menu.actions() if action.isCheckable()]
        assert [action.isChecked() for action in choices] == [True, False]
        choices[1].trigger()
        menu.close()
        until(qtbot, lambda: controller.session is not former)
        until(qtbot, lambda: controller.session.history.has("phi"))
        until(qtbot, lambda: controller.session.history.last("phi")[1] == pytest.approx(0.1))
        link = controller.session.equipment.link
        assert (link.system, link.assumed_address) == (1, "")
        alarms = controller.session.alarm_registry
        until(qtbot, lambda: alarms.severity("stranger") is Severity.WARNING)
        assert STRANGER in alarms.get("stranger").message
    finally:
        stop.set()
        transmitter.join()
        controller.recorders.stop_recording_and_wait()

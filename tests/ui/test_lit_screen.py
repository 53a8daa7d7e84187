"""The desktop is asked to keep the screen lit while a flight is recorded: over a real bus."""

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtCore import ClassInfo, QObject, Signal, Slot
from pytestqt.qtbot import QtBot

from tests.ui.window_kit import until
from ui.screen_saver_inhibitor import ScreenSaverInhibitor

pytestmark = pytest.mark.skipif(
    shutil.which("dbus-daemon") is None, reason="there is no bus on this computer"
)


@pytest.fixture
def bus(monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    command = ["dbus-daemon", "--session", "--nofork", "--print-address=1"]
    daemon = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    address = daemon.stdout.readline().strip()
    monkeypatch.setenv("DBUS_SESSION_BUS_ADDRESS", address)
    yield address
    daemon.terminate()
    daemon.wait()
    daemon.stdout.close()


@ClassInfo({"D-Bus Interface": "org.freedesktop.ScreenSaver"})
class Saver(QObject):
    def __init__(self) -> None:
        super().__init__()
        self.asked: list[tuple[str, str]] = []

    @Slot(str, str, result=int)
    def Inhibit(self, who: str, why: str) -> int:  # noqa: N802  its name on the bus
        self.asked.append((who, why))
        return 1


SAVERS: list[Saver] = []
"""Kept to the end: the bus's own thread holds what was exported for longer than its connection."""


class Desk(QObject):
    changed = Signal()
    recording_ended = Signal(object)
    is_recording = False


@pytest.mark.parametrize("how", ["another flight", "the recording ends", "the window closes"])
def test_the_screen_stays_lit_for_as_long_as_a_flight_is_recorded(
    bus: str, qtbot: QtBot, how: str
) -> None:
    """What was asked for ends with the connection over which it was asked."""
    from PySide6.QtDBus import QDBusConnection

    saver = Saver()
    SAVERS.append(saver)
    desktop = QDBusConnection.connectToBus(bus, "desktop")
    try:
        flags = QDBusConnection.RegisterOption.ExportAllSlots
        assert desktop.registerObject("/org/freedesktop/ScreenSaver", saver, flags)
        assert desktop.registerService("org.freedesktop.ScreenSaver")

        def connections() -> int:
            return len(desktop.interface().registeredServiceNames().value())

        alone = connections()
        controller = Desk()
        screen = ScreenSaverInhibitor(controller)
        controller.changed.emit()
        assert connections() == alone
        controller.is_recording = True
        controller.changed.emit()
        until(qtbot, lambda: bool(saver.asked))
        assert saver.asked == [("Ground station", "a flight is being recorded")]
        assert connections() > alone
        if how == "another flight":
            controller.is_recording = False
            controller.changed.emit()
        elif how == "the recording ends":
            controller.recording_ended.emit(None)
        else:
            screen.close()
        until(qtbot, lambda: connections() == alone)
    finally:
        QDBusConnection.disconnectFromBus("desktop")


_AS_ANOTHER_USER = """
import os
from PySide6.QtCore import QObject, Signal
from ui.screen_saver_inhibitor import ScreenSaverInhibitor
class Desk(QObject):
    changed, recording_ended = Signal(), Signal(object)
    is_recording = True
desk = Desk()
screen = ScreenSaverInhibitor(desk)
if os.getuid() == 0:
    os.setgid(65534); os.setuid(65534)
desk.changed.emit()
print("goes on")
"""


def test_a_folder_of_another_user_is_no_desktop(tmp_path: Path) -> None:
    run = tmp_path / "run"
    run.mkdir()
    run.chmod(0o000)
    environment = {**os.environ, "XDG_RUNTIME_DIR": str(run)}
    environment.pop("DBUS_SESSION_BUS_ADDRESS", None)
    done = subprocess.run(
        [sys.executable, "-c", _AS_ANOTHER_USER],
        env=environment, capture_output=True, text=True, timeout=240,
    )  # fmt: skip
    run.chmod(0o755)
    assert (done.stdout, done.stderr) == ("goes on\n", "")

"""The screen stays lit while a flight is being recorded: nobody has a hand for the mouse."""

from __future__ import annotations

import logging
import os
import sys
from contextlib import ExitStack
from pathlib import Path
from typing import Final

from PySide6.QtCore import QObject

from gsapp.foundation.process_control import inhibit_sleep
from ui.flight_controller import FlightController

_APPLICATION_NAME: Final = "Ground station"
_INHIBIT_REASON: Final = "a flight is being recorded"
_SAVER: Final = "org.freedesktop.ScreenSaver"
_BUS: Final = "gsapp-lit-screen"

log = logging.getLogger(__name__)


class ScreenSaverInhibitor(QObject):
    """Asks the desktop not to darken the screen while the open flight is being recorded.

    It may refuse, and then nothing happens.
    """

    def __init__(self, controller: FlightController) -> None:
        super().__init__(controller)
        self._controller = controller
        self._requests = ExitStack()
        self._lit = False
        controller.changed.connect(lambda: self._set_inhibited(lit=controller.is_recording))
        controller.recording_ended.connect(lambda _folder: self._set_inhibited(lit=False))

    def close(self) -> None:
        self._set_inhibited(lit=False)

    def _set_inhibited(self, *, lit: bool) -> None:
        if lit == self._lit:
            return
        self._lit = lit
        if not lit:
            self._requests.close()
        elif sys.platform in ("win32", "darwin"):
            self._requests.enter_context(inhibit_sleep(_INHIBIT_REASON, screen=True))
        elif address := _desktop_bus():
            self._inhibit_desktop(address)

    def _inhibit_desktop(self, address: str) -> None:
        """Ask over a connection of its own: what was asked for ends with it."""
        from PySide6.QtDBus import QDBusConnection, QDBusMessage

        bus = QDBusConnection.connectToBus(address, _BUS)
        self._requests.callback(QDBusConnection.disconnectFromBus, _BUS)
        if not bus.isConnected():
            log.info("the desktop does not offer to keep the screen on")
            return
        path = f"/{_SAVER.replace('.', '/')}"
        call = QDBusMessage.createMethodCall(_SAVER, path, _SAVER, "Inhibit")
        call.setArguments([_APPLICATION_NAME, _INHIBIT_REASON])
        bus.send(call)


def _desktop_bus() -> str:
    """Return the address of the desktop's bus; empty where there is none."""
    address = os.environ.get("DBUS_SESSION_BUS_ADDRESS", "")
    usual = Path(os.environ.get("XDG_RUNTIME_DIR") or "/nowhere") / "bus"
    # Not its existence: after su, the folder is that of another user, which may not be looked into.
    return address or (f"unix:path={usual}" if os.access(usual, os.R_OK | os.W_OK) else "")

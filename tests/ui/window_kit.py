"""What the window tests share: a window of its own, small flights, an aircraft that sends."""

from __future__ import annotations

import signal
import socket
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Self, TypeVar

import numpy as np
from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication, QDialog

from calibration import load_certificates
from gsapp.decoding.dialect import dialect
from gsapp.flight.writers import write_flight_csv
from gsapp.quantities import Block, FloatArray
from ui.faults import FaultDesk
from ui.settings import SettingsStore
from ui.window import MainWindow

# Places of the box's array that the tests look at.
_ARRAY = ("elevator_left", "elevator_right", "aileron_left", "aileron_right", "rudder", "alpha",
          "beta", "p", "q", "r")  # fmt: skip
_SWITCHED_ON = 1.0
"""Seconds that the box had been on when it began to send."""

_OPENS = 10.0
"""Seconds that a dialog may take to open."""

KILL = getattr(signal, "SIGKILL", signal.SIGTERM)
"""Ends a process at once; Windows has no SIGKILL, and there SIGTERM does."""

Dialog = TypeVar("Dialog", bound=QDialog)


def alpha_sent(times: FloatArray) -> FloatArray:
    """Return the angle of attack (rad) that the aircraft sends at flight times (s)."""
    return 0.05 * np.sin(2 * np.pi * (times - _SWITCHED_ON))


def open_window(folder: Path, **settings: object) -> MainWindow:
    """Return a window whose settings and flights lie in a folder of the test."""
    store = SettingsStore(folder / "settings" / "window.toml")
    store.change(flights=str(folder / "flights"), muted=True, **settings)
    window = MainWindow(store, FaultDesk())
    window.resize(1280, 800)
    window.show()
    return window


def write_flight(folder: Path, seconds: float = 20.0) -> Path:
    """Write a small Flight CSV: alpha and q swing, V is steady and the elevator steps."""
    times = np.arange(round(seconds * 50)) / 50.0
    alpha = 0.05 + 0.03 * np.sin(2 * np.pi * 0.5 * times)
    values = np.column_stack(
        [alpha, 0.2 * np.cos(2 * np.pi * 0.5 * times), np.full(times.size, 30.48),
         np.where((times > 5) & (times < 6), -0.1, 0.0)]
    )  # fmt: skip
    block = Block(channels=("alpha", "q", "V", "de"), times=times, values=values)
    folder.mkdir(parents=True, exist_ok=True)
    return write_flight_csv(folder / "small.csv", block, "us")


def free_port() -> int:
    """Return a UDP port that nobody listens on."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


class Aircraft:
    """The box of the B777, reduced to one message at 100 Hz, in a thread."""

    def __init__(self, port: int) -> None:
        self._address = ("127.0.0.1", port)
        self._names = dialect()
        self._packer = self._names.MAVLink(None, srcSystem=1, srcComponent=1)
        self._certificates = load_certificates("b777")
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._send, daemon=True)
        self.sent = 0

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._thread.join()

    def _send(self) -> None:
        begin = time.monotonic()
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as link:
            while not self._stop.is_set():
                due = begin + self.sent * 0.01
                time.sleep(max(due - time.monotonic(), 0.0))
                link.sendto(self._frame(self.sent), self._address)
                if self.sent % 100 == 0:
                    link.sendto(self._text("Engines running"), self._address)
                self.sent += 1

    def _frame(self, count: int) -> bytes:
        stamp = round(_SWITCHED_ON * 1e6) + count * 10_000
        swing = float(alpha_sent(np.array([stamp * 1e-6]))[0])
        volts = [float(self._certificates[name].volts(swing)) for name in _ARRAY]
        data = volts + [2.5] * (20 - len(volts)) + [0.0] * 38
        message = self._names.MAVLink_debug_float_array_message(stamp, b"daq", 0, data)
        return self._pack(message)

    def _text(self, words: str) -> bytes:
        severity = self._names.MAV_SEVERITY_WARNING
        return self._pack(self._names.MAVLink_statustext_message(severity, words.encode()))

    def _pack(self, message: object) -> bytes:
        frame = bytes(message.pack(self._packer))  # type: ignore[attr-defined]
        self._packer.seq = (self._packer.seq + 1) % 256
        return frame


def answer_dialog(kind: type[Dialog], answer: Callable[[Dialog], object]) -> None:
    """Answer the next dialog of a kind once it has the keys; to be said before it opens.

    It is closed in the end: left open, it would hold the test for ever.
    """
    deadline = time.monotonic() + _OPENS

    def look() -> None:
        dialog = QApplication.activeModalWidget()
        if isinstance(dialog, kind) and dialog.isAncestorOf(QApplication.focusWidget()):
            try:
                answer(dialog)
            finally:
                if dialog.isVisible():
                    dialog.reject()
        else:
            assert time.monotonic() < deadline, f"no {kind.__name__} has opened"
            QTimer.singleShot(10, look)

    QTimer.singleShot(0, look)


def until(qtbot: object, condition: Callable[[], bool], milliseconds: int = 30_000) -> None:
    """Let the window work until something holds."""
    qtbot.waitUntil(condition, timeout=milliseconds)  # type: ignore[attr-defined]

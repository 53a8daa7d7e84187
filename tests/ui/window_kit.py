"""What the window tests share: windows, small flights, an aircraft that sends, keys, pixels."""

import signal
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Self, TypeVar

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPoint, QRect, Qt, QTimer
from PySide6.QtGui import QGuiApplication, QImage
from PySide6.QtWidgets import QApplication, QDialog, QPushButton, QWidget
from pytestqt.qtbot import QtBot

import ui.main_window
from calibration import load_certificates
from gsapp.decoding.dialect import dialect
from gsapp.flight.writers import write_flight_csv
from gsapp.quantities import Block, FloatArray
from gsapp.telemetry.recorder_status import RUNTIME_VARIABLE
from ui.dialogs.flight_requests import ConnectRequest
from ui.error_reporter import ErrorReporter
from ui.main_window import MainWindow
from ui.settings import SettingsStore
from ui.voice.sound_output import Speaker
from ui.voice.speech_queue import Utterance

# Places of the box's array that the tests look at.
_ARRAY = ("elevator_left", "elevator_right", "aileron_left", "aileron_right", "rudder", "alpha",
          "beta", "p", "q", "r")  # fmt: skip
_SWITCHED_ON = 1.0
"""Seconds that the box had been on when it began to send."""

_OPENS = 10.0
"""Seconds that a dialog may take to open."""

KILL = getattr(signal, "SIGKILL", signal.SIGTERM)
"""Ends a process at once; Windows has no SIGKILL, and there SIGTERM does."""

FIGURE_MENU = ["Copy picture", "Copy numbers", "Save as…", "Reset zoom"]
"""Of every figure."""

ALT, CONTROL = Qt.KeyboardModifier.AltModifier, Qt.KeyboardModifier.ControlModifier
SHIFT = Qt.KeyboardModifier.ShiftModifier

LOOKS = (((1280, 800), 100, "daylight"), ((1280, 800), 200, "dark"),
         ((2560, 1600), 200, "high-contrast"))  # fmt: skip
"""Size of the window, scale and theme."""

Dialog = TypeVar("Dialog", bound=QDialog)


def alpha_sent(times: FloatArray) -> FloatArray:
    return 0.05 * np.sin(2 * np.pi * (times - _SWITCHED_ON))


def open_window(folder: Path, /, **settings: object) -> MainWindow:
    _clear_style_sheet()
    store = SettingsStore(folder / "settings" / "window.toml")
    store.change(**{"flights": str(folder / "flights"), "muted": True, **settings})
    window = MainWindow(store, ErrorReporter())
    window.resize(1280, 800)
    window.show()
    return window


def _clear_style_sheet() -> None:
    """Let a window be built as the first one is; with a sheet each part is styled many times."""
    application = QApplication.instance()
    assert isinstance(application, QApplication)
    application.sendPostedEvents(None, QEvent.Type.DeferredDelete)
    if not any(isinstance(one, MainWindow) for one in application.topLevelWidgets()):
        application.setStyleSheet("")


@contextmanager
def opened_window(folder: Path, /, **settings: object) -> Iterator[MainWindow]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(RUNTIME_VARIABLE, str(folder / "run"))
        patch.setattr(ui.main_window, "ask_closing", lambda *_: "leave")
        made = open_window(folder, **settings)
        yield made
        made.close()
        made.deleteLater()


def activate(qtbot: QtBot, window: QWidget) -> None:
    window.activateWindow()
    until(qtbot, lambda: QGuiApplication.focusWindow() is window.windowHandle())


def write_flight(folder: Path, seconds: float = 20.0) -> Path:
    times = np.arange(round(seconds * 50)) / 50.0
    alpha = 0.05 + 0.03 * np.sin(2 * np.pi * 0.5 * times)
    values = np.column_stack(
        [alpha, 0.2 * np.cos(2 * np.pi * 0.5 * times), np.full(times.size, 30.48),
         np.where((times > 5) & (times < 6), -0.1, 0.0)]
    )  # fmt: skip
    block = Block(channels=("alpha", "q", "V", "de"), times=times, values=values)
    folder.mkdir(parents=True, exist_ok=True)
    return write_flight_csv(folder / "small.csv", block, "us")


def open_small_flight(
    window: MainWindow, qtbot: QtBot, folder: Path, seconds: float = 20.0
) -> MainWindow:
    """Open a replay that stands at its beginning, and return the window."""
    path = write_flight(folder, seconds)
    window.flight_controller.flight_opener.open_flight(path, playing=False)
    until(qtbot, lambda: window.flight_controller.is_loaded)
    return window


def connect(
    window: MainWindow, port: int, folder: Path, kind: str = "udpin", **options: Any
) -> None:
    request = ConnectRequest(
        link=f"{kind}:127.0.0.1:{port}", folder=folder, channel_map="b777", aircraft="b777",
        calibration="b777", **options,
    )  # fmt: skip
    window.flight_controller.flight_opener.connect_aircraft(request)


def is_followed(window: MainWindow, folder: Path) -> bool:
    session = window.flight_controller.session
    return session is not None and session.path == folder


def free_port() -> int:
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
        self.sent = self.texts = 0

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
                    self.texts += 1
                self.sent += 1

    def _frame(self, count: int) -> bytes:
        stamp = round(_SWITCHED_ON * 1e6) + count * 10_000
        swing = float(alpha_sent(np.array([stamp * 1e-6]))[0])
        volts = [float(self._certificates[name].volts(swing)) for name in _ARRAY]
        data = volts + [2.5] * (20 - len(volts)) + [0.0] * 38
        message = self._names.MAVLink_debug_float_array_message(stamp, b"daq", 0, data)
        return self._pack(message)

    def _text(self, text: str) -> bytes:
        severity = self._names.MAV_SEVERITY_WARNING
        return self._pack(self._names.MAVLink_statustext_message(severity, text.encode()))

    def _pack(self, message: object) -> bytes:
        frame = bytes(message.pack(self._packer))  # type: ignore[attr-defined]
        self._packer.seq = (self._packer.seq + 1) % 256
        return frame


class Loudspeaker:
    def __init__(self) -> None:
        self.tones: list[str] = []

    def play(self, name: str) -> None:
        self.tones.append(name)

    def stop(self) -> None:
        self.tones.append("stop")


class Mouth(Speaker):
    """Speaks until it is told that it has done so."""

    def __init__(self) -> None:
        super().__init__()
        self.spoken: list[str] = []
        self.now: Utterance | None = None

    def speak(self, utterance: Utterance) -> None:
        self.now = utterance
        self.spoken.append(utterance.text)

    def stop(self) -> None:
        self.now = None

    def end(self) -> None:
        spoken, self.now = self.now, None
        if spoken is not None:
            self.done.emit(spoken)


def answer_dialog(kind: type[Dialog], answer: Callable[[Dialog], object]) -> None:
    """Answer the next dialog of a kind once it has the keys; to be said before it opens.

    It is closed in the end: left open, it would hold the test for ever.
    """
    deadline = time.monotonic() + _OPENS

    def poll() -> None:
        dialog = QApplication.activeModalWidget()
        if isinstance(dialog, kind) and dialog.isAncestorOf(QApplication.focusWidget()):
            try:
                answer(dialog)
            finally:
                if dialog.isVisible():
                    dialog.reject()
        else:
            assert time.monotonic() < deadline, f"no {kind.__name__} has opened"
            QTimer.singleShot(10, poll)

    QTimer.singleShot(0, poll)


def until(qtbot: QtBot, condition: Callable[[], bool], milliseconds: int = 30_000) -> None:
    qtbot.waitUntil(condition, timeout=milliseconds)


def press(
    qtbot: QtBot,
    key: Qt.Key,
    modifier: Qt.KeyboardModifier = Qt.KeyboardModifier.NoModifier,
    times: int = 1,
) -> None:
    for _ in range(times):
        focus = QApplication.focusWidget()
        assert focus is not None
        qtbot.keyClick(focus, key, modifier)


def type_into(qtbot: QtBot, field: QWidget, text: str) -> None:
    field.setFocus()
    edit = QApplication.focusWidget()
    assert edit is not None
    qtbot.keyClick(edit, Qt.Key.Key_A, Qt.KeyboardModifier.ControlModifier)
    qtbot.keyClick(edit, Qt.Key.Key_Delete)
    qtbot.keyClicks(edit, text)


def pixels(widget: QWidget, box: QRect | None = None) -> np.ndarray:
    QApplication.processEvents()
    image = widget.grab(box or widget.rect()).toImage()
    image = image.convertToFormat(QImage.Format.Format_RGB32)
    flat = np.frombuffer(image.constBits(), dtype=np.uint32)
    return (flat.reshape(image.height(), -1)[:, : image.width()] & 0xFFFFFF).copy()


def count(widget: QWidget, color: str, box: QRect | None = None) -> int:
    return int((pixels(widget, box) == int(color[1:], 16)).sum())


def settled_places(qtbot: QtBot, window: QWidget, *parts: QWidget) -> list[QRect]:
    """Return where parts of a window are once its layout has stopped moving them."""
    places = [in_window(part, window) for part in parts]
    while True:
        qtbot.wait(300)  # two ticks of the window
        former, places = places, [in_window(part, window) for part in parts]
        if former == places:
            return places


def in_window(widget: QWidget, window: QWidget) -> QRect:
    return QRect(widget.mapTo(window, QPoint(0, 0)), widget.size())


def check_labels(page: QWidget) -> None:
    """Assert that nothing that a page says is cut, and that no two of its words overlap."""
    labels = [one for one in page.findChildren(QWidget) if one.isVisibleTo(page)]
    labels = [one for one in labels if not one.findChildren(QWidget)]
    said = [(in_window(one, page), one) for one in labels if getattr(one, "text", str)()]
    assert said
    for index, (box, widget) in enumerate(said):
        text = widget.text()
        assert page.rect().contains(box), text
        assert box.height() >= widget.heightForWidth(box.width()) - 1, text
        wraps = getattr(widget, "wordWrap", lambda: True)()
        if not wraps or isinstance(widget, QPushButton):
            assert box.width() >= widget.sizeHint().width() - 1, text
        for other, neighbor in said[index + 1 :]:
            assert not box.intersects(other), (text, neighbor.text())

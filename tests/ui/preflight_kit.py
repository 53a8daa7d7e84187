"""What the tests of the place Preflight share: keys, pixels, a window as it was when opened."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QRect, Qt
from PySide6.QtGui import QGuiApplication, QImage
from PySide6.QtWidgets import QApplication, QWidget
from pytestqt.qtbot import QtBot
from window_kit import open_window, until

import ui.window
from ui.window import MainWindow

CONTROL, ALT = Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.AltModifier
SHIFT = Qt.KeyboardModifier.ShiftModifier


def opened_window(tmp_path_factory: pytest.TempPathFactory) -> Iterator[MainWindow]:
    """Open one window for all tests of a module: styling a window takes a second."""
    folder = tmp_path_factory.mktemp("window")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("GSAPP_RUNTIME_FOLDER", str(folder / "run"))
        patch.setattr(ui.window, "ask_closing", lambda *_: "leave")
        made = open_window(folder)
        yield made
        made.close()
        made.deleteLater()


def as_opened(made: MainWindow, qtbot: QtBot) -> Iterator[MainWindow]:
    """Bring the window back to how it was when it was opened, with nothing prepared."""
    dress(made, "daylight", 100)
    made.look.set_units("US")
    made.resize(1280, 800)
    for banner in list(made.banners.banners):
        made.banners.remove(banner)
    made.show_place("flight")
    shutil.rmtree(waiting(made), ignore_errors=True)
    (made.store.path.parent / "checklist.toml").unlink(missing_ok=True)
    made.desk.changed.emit()
    made.activateWindow()
    until(qtbot, lambda: QGuiApplication.focusWindow() is made.windowHandle())
    yield made
    made.desk.close_flight()


def dress(window: MainWindow, theme: str, scale: int) -> None:
    """Change theme and scale at once: each change styles every widget anew."""
    look = window.look
    if (look.theme.name, look.scale) != (theme, scale):
        look.blockSignals(True)
        look.set_theme(theme)
        look.set_scale(scale)
        look.blockSignals(False)
        look.changed.emit()


def waiting(window: MainWindow) -> Path:
    """Return the folder of what waits for the next flight."""
    return window.store.path.parent / "next flight"


def go(window: MainWindow, qtbot: QtBot, step: int) -> QWidget:
    """Go to a step by keys and return its page."""
    qtbot.keyClick(window, Qt.Key.Key_F1)
    press(qtbot, Qt.Key(Qt.Key.Key_0 + step), ALT)
    QApplication.processEvents()
    return window.preflight.pages[window.preflight.step]


def press(
    qtbot: QtBot,
    key: Qt.Key,
    modifier: Qt.KeyboardModifier = Qt.KeyboardModifier.NoModifier,
    times: int = 1,
) -> None:
    """Press a key where the keyboard is."""
    for _ in range(times):
        focus = QApplication.focusWidget()
        assert focus is not None
        qtbot.keyClick(focus, key, modifier)


def type_into(qtbot: QtBot, field: QWidget, text: str) -> None:
    """Put the keyboard into a field and type in place of what stands there."""
    field.setFocus()
    edit = QApplication.focusWidget()
    assert edit is not None
    qtbot.keyClick(edit, Qt.Key.Key_A, CONTROL)
    qtbot.keyClick(edit, Qt.Key.Key_Delete)
    qtbot.keyClicks(edit, text)


def pixels(widget: QWidget, box: QRect | None = None) -> np.ndarray:
    """Return what a widget shows, shape (height, width), each 0xRRGGBB."""
    QApplication.processEvents()
    image = widget.grab(box or widget.rect()).toImage()
    image = image.convertToFormat(QImage.Format.Format_RGB32)
    flat = np.frombuffer(image.constBits(), dtype=np.uint32)
    return (flat.reshape(image.height(), -1)[:, : image.width()] & 0xFFFFFF).copy()


def count(widget: QWidget, color: str, box: QRect | None = None) -> int:
    """Return the number of pixels of a color, ``#rrggbb``."""
    return int((pixels(widget, box) == int(color[1:], 16)).sum())


def in_window(widget: QWidget, window: QWidget) -> QRect:
    """Return where a widget stands in the window."""
    return QRect(widget.mapTo(window, QPoint(0, 0)), widget.size())

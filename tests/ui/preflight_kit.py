"""What the tests of the place Preflight share: keys, pixels, a window as it was when opened."""

import shutil
from collections.abc import Iterator
from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QWidget
from pytestqt.qtbot import QtBot

from tests.ui.window_kit import activate, press
from ui.main_window import MainWindow

CONTROL, ALT = Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.AltModifier
SHIFT = Qt.KeyboardModifier.ShiftModifier


def as_opened(made: MainWindow, qtbot: QtBot) -> Iterator[MainWindow]:
    dress(made, "daylight", 100)
    made.display_style.set_units("US")
    made.resize(1280, 800)
    for banner in list(made.banners.banners):
        made.banners.remove(banner)
    made.show_page("flight")
    shutil.rmtree(waiting(made), ignore_errors=True)
    (made.store.path.parent / "checklist.toml").unlink(missing_ok=True)
    made.flight_controller.changed.emit()
    activate(qtbot, made)
    yield made
    made.flight_controller.close_flight()


def dress(window: MainWindow, theme: str, scale: int) -> None:
    style = window.display_style
    if (style.theme.name, style.scale) != (theme, scale):
        style.blockSignals(True)
        style.set_theme(theme)
        style.set_scale(scale)
        style.blockSignals(False)
        style.changed.emit()


def waiting(window: MainWindow) -> Path:
    return window.store.path.parent / "next flight"


def go(window: MainWindow, qtbot: QtBot, step: int) -> QWidget:
    qtbot.keyClick(window, Qt.Key.Key_F1)
    press(qtbot, Qt.Key(Qt.Key.Key_0 + step), ALT)
    QApplication.processEvents()
    return window.preflight_page.pages[window.preflight_page.step]

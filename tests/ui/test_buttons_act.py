"""Every button and command that looks enabled does something; every gray button says why."""

import time
from collections.abc import Callable, Collection, Iterator
from pathlib import Path

import pytest
import shiboken6
from PySide6.QtGui import QAction, QDesktopServices, QGuiApplication
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QAbstractButton,
    QApplication,
    QDialog,
    QFileDialog,
    QInputDialog,
    QMenu,
    QMessageBox,
    QToolTip,
    QWidget,
)
from pytestqt.qtbot import QtBot

import ui.main_window
from tests.ui.window_kit import open_small_flight, open_window, until
from ui.main_window import MainWindow

PAGES = {
    "preflight": ("card", "calibration", "checklist", "cards"),
    "flight": (),
    "pilot": ("page", "debrief"),
    "review": ("maneuvers", "estimate", "figures", "summary"),
    "gap": ("find", "name", "add", "show"),
}
"""The places with their parts, as the ids of commands name them."""


FLIES = ("virtual", "Train", "hidden effect")
"""Words on buttons that start processes; other tests press these."""


class Watcher:
    """Notices whether anything happened: on screen, on the clipboard, in the settings, asked."""

    def __init__(self, window: MainWindow, monkeypatch: pytest.MonkeyPatch) -> None:
        self.window = window
        self.asked = 0

        def asks(answer: object) -> Callable[..., object]:
            def ask(*_: object, **__: object) -> object:
                self.asked += 1
                return answer

            return ask

        for owner, name, answer in (
            (QDialog, "exec", 0), (QDialog, "open", None), (QMenu, "exec", None),
            (QMenu, "popup", None), (QMessageBox, "exec", 0),
            (QFileDialog, "getOpenFileName", ("", "")), (QFileDialog, "getOpenFileNames", ([], "")),
            (QFileDialog, "getSaveFileName", ("", "")), (QFileDialog, "getExistingDirectory", ""),
            (QFileDialog, "exec", 0), (QInputDialog, "getText", ("", False)),
            (QDesktopServices, "openUrl", True),
        ):  # fmt: skip
            monkeypatch.setattr(owner, name, asks(answer))

    def state(self) -> tuple[object, ...]:
        window, controller = self.window, self.window.flight_controller
        tops = [one for one in QApplication.topLevelWidgets() if one.isVisible()]
        focus = QApplication.focusWidget()
        return (
            QGuiApplication.clipboard().text(), len(tops), self.asked, window.store.current,
            id(controller.session), window.windowState(), None if focus is None else id(focus),
            QToolTip.text(),
        )  # fmt: skip

    def acts(self, act: Callable[[], object]) -> bool:
        QApplication.processEvents()
        before, image = self.state(), self.window.grab().toImage()
        act()
        # Some pictures are drawn in a thread.
        deadline = time.monotonic() + 0.5
        while self.state() == before and self.window.grab().toImage() == image:
            if time.monotonic() > deadline:
                return False
            QTest.qWait(20)
        return True


@pytest.fixture
def window(qtbot: QtBot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[MainWindow]:
    monkeypatch.setenv("GSAPP_RUNTIME_FOLDER", str(tmp_path / "run"))
    monkeypatch.setattr(ui.main_window, "ask_closing", lambda *_: "leave")
    QApplication.setCursorFlashTime(0)
    made = open_window(tmp_path)
    qtbot.addWidget(made)
    made.activateWindow()
    until(qtbot, lambda: QApplication.activeWindow() is made)
    yield made
    made.flight_controller.close()


def parts(pages: Collection[str]) -> Iterator[tuple[str, str]]:
    for page in pages:
        for part in PAGES[page] or ("",):
            yield page, f"{page}_{part}" if part else ""


def go(window: MainWindow, page: str, command: str) -> None:
    window.commands.actions[f"place_{page}"].trigger()
    if command and window.commands.actions[command].isEnabled():
        window.commands.actions[command].trigger()
    for _ in range(3):
        QApplication.processEvents()


def buttons(window: MainWindow, *, enabled: bool) -> list[QAbstractButton]:
    return [
        one for one in window.findChildren(QAbstractButton)
        if one.isVisible() and one.isEnabled() == enabled and not one.visibleRegion().isEmpty()
    ]  # fmt: skip


def name_of(widget: QWidget | QAction) -> str:
    named = widget.accessibleName() if isinstance(widget, QWidget) else ""
    return named or widget.text()


def walk(
    window: MainWindow, watcher: Watcher, pages: Collection[str]
) -> tuple[list[str], list[str]]:
    """Press every button of pages; return those without effect, and gray ones unexplained."""
    dead: list[str] = []
    unexplained: list[str] = []
    for page, command in parts(pages):
        go(window, page, command)
        hints = {name_of(one) for one in window.commands.actions.values()}
        unexplained += [
            f"{command or page}: {name_of(one)}"
            for one in buttons(window, enabled=False)
            if one.toolTip() in {"", one.text(), name_of(one)} | hints
        ]
        for one in buttons(window, enabled=True):
            if not shiboken6.isValid(one) or not one.isVisible() or not one.isEnabled():
                continue
            if one.isChecked():
                continue
            name = name_of(one)
            if any(word in name for word in FLIES):
                continue
            if not watcher.acts(one.click):
                dead.append(f"{command or page}: {name}")
            go(window, page, command)
    return dead, unexplained


@pytest.mark.parametrize("pages", [("flight",), pytest.param((*PAGES,), marks=pytest.mark.long)])
def test_no_button_is_dead_and_gray_ones_say_why(
    window: MainWindow,
    qtbot: QtBot,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    pages: tuple[str, ...],
) -> None:
    watcher = Watcher(window, monkeypatch)
    assert walk(window, watcher, pages) == ([], [])
    open_small_flight(window, qtbot, tmp_path, 90.0)
    assert walk(window, watcher, pages) == ([], [])


def test_keys_about_marks_and_alarms_wait_for_them(
    window: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    open_small_flight(window, qtbot, tmp_path)
    actions = window.commands.actions
    until(qtbot, actions["mark"].isEnabled)
    for name in ("previous_mark", "next_mark", "acknowledge"):
        assert not actions[name].isEnabled(), name
        assert actions[name].toolTip().startswith("No ")
    actions["mark"].trigger()
    until(qtbot, actions["previous_mark"].isEnabled)

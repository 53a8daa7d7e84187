"""Makes pictures of the window for the documents: a window of its own, keys, what is on screen."""

from __future__ import annotations

import argparse
import contextlib
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from gsapp.foundation import GroundStationError
from gsapp.telemetry.recorder_status import RUNTIME_VARIABLE
from ui.theme import THEMES

if TYPE_CHECKING:
    from ui.main_window import MainWindow

_TIMEOUT = 60.0
"""Seconds that something may take."""


@dataclass(frozen=True)
class WindowAppearance:
    """How a window looks in a picture."""

    theme: str = "daylight"
    scale: int = 100  # Percent, 100 to 250.
    size: tuple[int, int] = (1280, 800)

    @classmethod
    def from_arguments(cls, arguments: argparse.Namespace) -> WindowAppearance:
        """Return what was asked for on the command line; see `screenshot_parser`."""
        return cls(theme=arguments.theme, scale=arguments.scale, size=arguments.size)


class ScreenshotTaker:
    """A window, the keys pressed in it, and the pictures taken of it.

    It works `settles` seconds before a picture is taken; nothing may take more than `patience`.
    """

    def __init__(
        self, window: MainWindow, folder: Path, *, settles: float = 0.0, patience: float = _TIMEOUT
    ) -> None:
        from PySide6.QtWidgets import QApplication

        self.window = window
        self._folder = folder
        self._settles = settles
        self._patience = patience
        self._work = QApplication.processEvents

    def wait_until(self, done: Callable[[], object], what: str) -> None:
        """Let the window work until something holds."""
        wait_until(self._work, lambda: bool(done()), what, self._patience)

    def wait_for_focus(self) -> None:
        """Let the window work until it has the keyboard: only then keys mean something."""
        from PySide6.QtGui import QGuiApplication

        self.window.activateWindow()
        handle = self.window.windowHandle()
        self.wait_until(lambda: QGuiApplication.focusWindow() is handle, "the keyboard")

    def press_key(self, keys: str) -> None:
        """Press a key where the keyboard is, as ``F1``, ``H`` or ``Alt+3``."""
        from PySide6.QtGui import QKeySequence
        from PySide6.QtTest import QTest
        from PySide6.QtWidgets import QApplication

        pressed = QKeySequence(keys)[0]
        target = QApplication.focusWidget() or self.window
        QTest.keyClick(target, pressed.key(), pressed.keyboardModifiers())
        self._work()

    def pause(self, seconds: float) -> None:
        """Let the window work for a while."""
        end = time.monotonic() + seconds
        self.wait_until(lambda: time.monotonic() > end, "time")

    def take_screenshot(self, name: str) -> Path:
        """Save what is on screen."""
        return self.save_screenshot(self._folder / f"{name}.png")

    def save_screenshot(self, path: Path) -> Path:
        """Save what is on screen in a file; see `take_screenshot`."""
        self.pause(self._settles)
        path.parent.mkdir(parents=True, exist_ok=True)
        if not self.window.grab().save(str(path)):
            raise GroundStationError(f"{path} cannot be written; check folder and permissions")
        return path


@contextlib.contextmanager
def hide_recorders(folder: Path) -> Iterator[None]:
    """See no recorders that happen to run on this computer."""
    before = os.environ.get(RUNTIME_VARIABLE)
    os.environ[RUNTIME_VARIABLE] = str(folder)
    try:
        yield
    finally:
        if before is None:
            del os.environ[RUNTIME_VARIABLE]
        else:
            os.environ[RUNTIME_VARIABLE] = before


def wait_until(
    work: Callable[[], object], done: Callable[[], bool], what: str, patience: float = _TIMEOUT
) -> None:
    """Let a window work until something is done, for so many seconds at most."""
    end = time.monotonic() + patience
    while not done():
        if time.monotonic() > end:
            raise GroundStationError(f"waited {patience:.0f} s for {what} in vain")
        work()
        time.sleep(0.005)


@contextlib.contextmanager
def screenshot_window(
    guise: WindowAppearance, *, prepare: Callable[[Path], object] | None = None
) -> Iterator[MainWindow]:
    """Open a window with settings of its own, and close it whatever happens.

    `prepare` is called with the folder of the settings before the window opens.
    """
    from ui.app import create_application
    from ui.error_reporter import ErrorReporter
    from ui.main_window import MainWindow
    from ui.settings import SettingsStore

    application = create_application()
    with tempfile.TemporaryDirectory() as home, hide_recorders(Path(home)):
        store = SettingsStore(Path(home) / "window.toml")
        store.change(theme=guise.theme, scale=guise.scale, flights=str(Path(home) / "flights"))
        if prepare is not None:
            prepare(Path(home))
        window = MainWindow(store, ErrorReporter(), offer_recorders=False)
        try:
            window.resize(*guise.size)
            window.show()
            window.activateWindow()
            yield window
        finally:
            window.flight_controller.recorders.stop_recording_and_wait()
            window.flight_controller.close()  # so that the window does not ask about the recording
            window.close()
            window.deleteLater()
            application.processEvents()


def screenshot_parser(
    module: str, about: str | None, out: str = "folder of the pictures"
) -> argparse.ArgumentParser:
    """Return what reads the arguments that all programs for pictures share."""
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    parser = argparse.ArgumentParser(prog=f"python -m {module}", description=about)
    parser.add_argument("--out", type=Path, required=True, help=out)
    parser.add_argument("--theme", choices=sorted(THEMES), default=WindowAppearance.theme)
    parser.add_argument(
        "--scale", type=int, default=WindowAppearance.scale, help="percent, 100 to 250"
    )
    parser.add_argument(
        "--size", type=parse_window_size, default=WindowAppearance.size, help="1280x800, ..."
    )
    return parser


@contextlib.contextmanager
def exit_with_message() -> Iterator[None]:
    """End the program with what was wrong, in one sentence."""
    try:
        yield
    except GroundStationError as error:
        sys.exit(str(error))


def parse_window_size(text: str) -> tuple[int, int]:
    """Return width and height of ``1280x800``."""
    width, _, height = text.partition("x")
    return int(width), int(height)

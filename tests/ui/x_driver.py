"""Drive the program in a real X server with the mouse and keys of xdotool.

The script runs in a thread of its own. It asks the window for facts and positions through the
event loop, and acts only as a person could: by pointer and keys.
"""

import os
import shutil
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

from PySide6.QtCore import QObject, QPoint, QRect, Qt, QTimer, Signal
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QApplication,
    QLineEdit,
    QMenu,
    QMenuBar,
    QTabBar,
    QWidget,
)

from ui.app import create_application, run_window
from ui.main_window import MainWindow

Result = TypeVar("Result")

_WAIT = 30.0


class _EventLoop(QObject):
    """Runs functions in the thread of the window."""

    _asked = Signal(object)

    def __init__(self) -> None:
        super().__init__()
        self._asked.connect(lambda run: run(), Qt.ConnectionType.QueuedConnection)

    def call(self, function: Callable[[], Result], timeout: float = _WAIT) -> Result:
        """Return what a function returns there; its exceptions are raised here."""
        done = threading.Event()
        answer: list[Any] = [None, None]

        def run() -> None:
            try:
                answer[0] = function()
            except BaseException as error:
                answer[1] = error
            done.set()

        self._asked.emit(run)
        if not done.wait(timeout):
            raise TimeoutError(f"the event loop did not answer for {timeout:g} s")
        if answer[1] is not None:
            raise answer[1]
        return answer[0]  # type: ignore[no-any-return]


class XDriver:
    """A person at the window.

    Parameters
    ----------
    pictures : Path
        Folder for screenshots.
    """

    def __init__(self, pictures: Path) -> None:
        self._loop = _EventLoop()
        self._pictures = pictures
        self.facts: dict[str, object] = {}
        pictures.mkdir(parents=True, exist_ok=True)

    def ask(self, function: Callable[[], Result]) -> Result:
        return self._loop.call(function)

    def until(self, condition: Callable[[], object], what: str, seconds: float = _WAIT) -> None:
        deadline = time.monotonic() + seconds
        while not self.ask(condition):
            if time.monotonic() > deadline:
                self.picture("failed")
                raise TimeoutError(f"not within {seconds:g} s: {what}")
            time.sleep(0.05)

    def changes(self, value: Callable[[], object], seconds: float) -> None:
        before, deadline = self.ask(value), time.monotonic() + seconds
        while self.ask(value) == before and time.monotonic() < deadline:
            time.sleep(0.05)

    # Pointer and keys

    def click(self, widget: QWidget, button: int = 1, at: QPoint | None = None) -> None:
        """Press the pointer on a widget, at its middle or at a point of it."""

        def place() -> QPoint | None:
            if not (widget.isVisible() and widget.isEnabled()):
                return None
            inside = widget.visibleRegion().boundingRect()
            if inside.isEmpty():
                return None
            return widget.mapToGlobal(inside.center() if at is None else at)

        seen: list[QPoint | None] = [None]

        def is_still() -> bool:
            seen.append(place())
            return seen[-1] is not None and seen[-1] == seen[-2]

        self.until(is_still, f"{_name(widget)} can be clicked")
        point = seen[-1]
        assert point is not None
        self._point(point, button)

    def _point(self, point: QPoint, button: int = 1) -> None:
        _xdotool("mousemove", "--sync", str(point.x()), str(point.y()))
        _xdotool("click", str(button))

    def press(self, text: str, within: QWidget | None = None) -> None:
        self.click(self.find(QAbstractButton, lambda it: _plain(it.text()) == text, text, within))

    def menu(self, bar: QMenuBar, *path: str) -> None:
        """Choose from the menu bar by the words of its entries."""
        level: QMenuBar | QMenu = bar
        for text in path:
            here = level
            self.until(here.isVisible, f"the menu of {text}")

            def entry(here: QMenuBar | QMenu = here, text: str = text) -> tuple[QRect, QMenu]:
                for action in here.actions():
                    if _plain(action.text()) == text and action.isEnabled():
                        return here.actionGeometry(action), action.menu()  # type: ignore[return-value]
                raise LookupError(f"no enabled entry {text!r}")

            area, below = self.ask(entry)
            self._point(self.ask(lambda here=here, area=area: here.mapToGlobal(area.center())))
            if below is not None:
                level = below

    def tab(self, bar: QTabBar, text: str) -> None:
        indices = [at for at in range(bar.count()) if _plain(bar.tabText(at)).startswith(text)]
        self.click(bar, at=self.ask(lambda: bar.tabRect(indices[0]).center()))

    def row(self, view: QAbstractItemView, row: int, column: int = 0, button: int = 1) -> None:
        def middle() -> QPoint:
            index = view.model().index(row, column)
            view.scrollTo(index)
            return view.visualRect(index).center()

        self.click(view.viewport(), button, self.ask(middle))

    def keys(self, *names: str) -> None:
        self.until(lambda: QApplication.focusWindow() is not None, "a window has the keyboard")
        for name in names:
            _xdotool("key", "--clearmodifiers", name)

    def fill(self, field: QLineEdit, text: str) -> None:
        self.click(field)
        self.until(field.hasFocus, f"{_name(field)} has the keyboard")
        self.keys("ctrl+a")
        self.until(lambda: field.selectedText() == field.text(), "the former text is selected")
        _xdotool("type", "--delay", "8", text)
        self.until(lambda: field.text() == text, f"{text} is typed")

    def close(self, window: QWidget) -> None:
        ends = threading.Event()
        self.ask(lambda: QApplication.instance().aboutToQuit.connect(ends.set))  # type: ignore[union-attr]
        self.until(window.isActiveWindow, "the window has the keyboard")
        self.keys("alt+F4")
        if not ends.wait(_WAIT):
            self.picture("failed")
            raise TimeoutError(f"the window did not close within {_WAIT:g} s")

    # What is on screen

    def find(
        self,
        kind: type[Any],
        fits: Callable[[Any], bool],
        what: str,
        within: QWidget | None = None,
        seconds: float = _WAIT,
    ) -> Any:
        found: list[Any] = []

        def is_shown() -> bool:
            roots = [within] if within is not None else _windows_on_top()
            found[:] = [
                child
                for root in roots
                for child in [root, *root.findChildren(kind)]
                if isinstance(child, kind) and child.isVisible() and fits(child)
            ]
            return bool(found)

        self.until(is_shown, f"{what} is on screen", seconds)
        return found[0]

    def dialog(self, kind: type[Any]) -> Any:
        return self.find(kind, lambda _it: True, kind.__name__)

    def picture(self, name: str) -> None:
        def grab() -> None:
            screen = QApplication.primaryScreen()
            screen.grabWindow(0).save(str(self._pictures / f"{name}.png"))

        self.ask(grab)

    def note(self, **facts: object) -> None:
        self.facts.update(facts)


def run_program(
    settings: Path, script: Callable[[XDriver, MainWindow], None], driver: XDriver
) -> None:
    """Run the program with a person at its window, until that has closed it.

    Parameters
    ----------
    settings : Path
        Settings file of the program.
    script : callable
        What the person does; the window is closed after it.
    driver : XDriver

    Raises
    ------
    Exception
        Whatever the script raises.
    """
    failed: list[BaseException] = []

    def work(window: MainWindow) -> None:
        try:
            driver.until(window.isVisible, "the window")
            script(driver, window)
            driver.close(window)
        except BaseException as error:
            failed.append(error)
            driver.ask(lambda: QApplication.exit(1))

    def begin() -> None:
        (window,) = (one for one in QApplication.topLevelWidgets() if isinstance(one, MainWindow))
        threading.Thread(target=work, args=(window,), daemon=True).start()

    application = create_application()
    QTimer.singleShot(0, application, begin)
    run_window(settings=settings)
    if failed:
        raise failed[0]


def missing_programs() -> list[str]:
    return [name for name in ("Xvfb", "openbox", "xdotool") if shutil.which(name) is None]


@contextmanager
def x_server(folder: Path) -> Iterator[dict[str, str]]:
    """Hold an X server with a window manager.

    Parameters
    ----------
    folder : Path
        Home of the programs in it.

    Yields
    ------
    dict of str to str
        The environment of these programs.
    """
    reader, writer = os.pipe()
    command = ["Xvfb", "-displayfd", str(writer), "-screen", "0", "1440x900x24", "-nolisten", "tcp"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    running = [subprocess.Popen(command, pass_fds=(writer,), **quiet)]
    os.close(writer)
    try:
        with os.fdopen(reader) as lines:
            display = f":{lines.readline().strip()}"
        where = {
            **os.environ, "DISPLAY": display, "QT_QPA_PLATFORM": "xcb", "HOME": str(folder),
            "GSAPP_RUNTIME_FOLDER": str(folder / "run"),
        }  # fmt: skip
        for name in ("CONFIG", "DATA", "STATE", "CACHE"):
            where[f"XDG_{name}_HOME"] = str(folder / "home" / name.lower())
        running.append(subprocess.Popen(["openbox"], env=where, **quiet))  # noqa: S607
        yield where
    finally:
        for process in reversed(running):
            process.terminate()
            process.wait()


def left_running(folder: Path, seconds: float = 10.0) -> list[str]:
    mark = f"GSAPP_RUNTIME_FOLDER={folder / 'run'}".encode()
    deadline = time.monotonic() + seconds
    while found := _processes_with(mark):
        if time.monotonic() > deadline:
            break
        time.sleep(0.1)
    return found


def _processes_with(mark: bytes) -> list[str]:
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if mark in (process / "environ").read_bytes().split(b"\0"):
                found.append((process / "cmdline").read_text().replace("\0", " "))
        except OSError:
            continue  # it has ended, or is another user's
    return [command for command in found if command and "openbox" not in command]


def _windows_on_top() -> list[QWidget]:
    on_top = [QApplication.activePopupWidget(), QApplication.activeModalWidget()]
    return [it for it in on_top if it is not None] or QApplication.topLevelWidgets()


def _plain(text: str) -> str:
    return text.replace("&&", "\0").replace("&", "").replace("\0", "&").split("\t")[0].strip()


def _name(widget: QWidget) -> str:
    return widget.accessibleName() or widget.objectName() or type(widget).__name__


def _xdotool(*arguments: str) -> None:
    command = ["xdotool", *arguments]
    ran = subprocess.run(command, check=False, capture_output=True, text=True, timeout=_WAIT)
    if ran.returncode:
        raise RuntimeError(f"xdotool {arguments[0]}: {ran.stderr.strip()}")

"""Pictures of what a crew does before a flight, made by the window itself.

``python -m ui.preflight.screenshots --out docs/images/preflight`` opens a window of its own with
the virtual aircraft on the ground, calibrates an instrument of it with keys, goes from step to
step, and saves what is on screen.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from gsapp.foundation import GroundStationError, write_toml
from ui.screenshot import no_recorders, wait
from ui.theme import THEMES

if TYPE_CHECKING:
    from calibration.wizard import WizardView
    from ui.preflight.wizard_page import WizardPage
    from ui.window import MainWindow

_SPEED = 3.0
"""Of the bench, times real time: a hand takes its time."""
_POINTS = 6
"""Taken when the picture of the points is."""
_CARD = {
    "name": "2026-05-12-a",
    "takeoff_weight": "46.9 lb",
    "fuel": "2.4 lb",
    "crew": {"pilot": "B. Jones", "engineer": "C. Poe", "ground_station": "D. Lee"},
    "weather": {
        "temperature": "61 degF", "pressure": "29.1 inHg", "wind_speed": "4 mph",
        "wind_from": "200 deg", "remarks": "light, steady",
    },
}  # fmt: skip


class Photographer:
    """A window, the keys pressed in it, and the pictures taken of it.

    Parameters
    ----------
    window : MainWindow
    folder : Path
        Where pictures go.
    """

    def __init__(self, window: MainWindow, folder: Path) -> None:
        from PySide6.QtWidgets import QApplication

        self.window = window
        self._folder = folder
        self._work = QApplication.processEvents

    def wait(self, done: Callable[[], object], what: str) -> None:
        """Let the window work until something holds."""
        wait(self._work, lambda: bool(done()), what)

    def press(self, keys: str) -> None:
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
        self.wait(lambda: time.monotonic() > end, "time")

    def take(self, name: str) -> Path:
        """Save what is on screen.

        Raises
        ------
        GroundStationError
            If the picture cannot be written.
        """
        self._work()
        path = self._folder / f"{name}.png"
        path.parent.mkdir(parents=True, exist_ok=True)
        if not self.window.grab().save(str(path)):
            raise GroundStationError(f"{path} cannot be written; check folder and permissions")
        return path


def photograph(out: Path, *, theme: str, scale: int, size: tuple[int, int]) -> tuple[Path, ...]:
    """Go through the steps before a flight and save a picture of each.

    Parameters
    ----------
    out : Path
        Folder of the pictures.
    theme : str
        Name of a theme.
    scale : int
        Percent, 100 to 250.
    size : tuple of int
        Width and height of the window.

    Raises
    ------
    GroundStationError
        If a step does not come in time, or a picture cannot be written.
    """
    from ui.app import make_application
    from ui.faults import FaultDesk
    from ui.settings import SettingsStore
    from ui.window import MainWindow

    application = make_application()
    with tempfile.TemporaryDirectory() as home, no_recorders(Path(home)):
        store = SettingsStore(Path(home) / "window.toml")
        store.change(theme=theme, scale=scale, flights=str(Path(home) / "flights"))
        write_toml(Path(home) / "next flight" / "flight.toml", _CARD)
        window = MainWindow(store, FaultDesk(), offer_recorders=False)
        try:
            window.resize(*size)
            window.show()
            window.activateWindow()
            return (*_pictures(Photographer(window, out)), _certificate(out))
        finally:
            window.desk.stop_now()
            window.desk.close()  # so that the window does not ask about the recording
            window.close()
            window.deleteLater()
            application.processEvents()


def _pictures(crew: Photographer) -> Iterator[Path]:
    """Go from step to step."""
    from PySide6.QtGui import QGuiApplication

    # Keys mean something in the window that has the keyboard only.
    crew.wait(lambda: QGuiApplication.focusWindow() is crew.window.windowHandle(), "the keyboard")
    crew.press("F1")
    crew.press("Alt+1")
    yield crew.take("card")
    crew.press("Alt+2")
    page = crew.window.preflight.pages["calibration"]
    page.practice.speed = _SPEED
    crew.press("P")
    crew.wait(lambda: page.practice.running and crew.window.desk.history.end, "the bench")
    crew.wait(lambda: crew.window.desk.is_settled, "the bench")
    crew.press("Alt+2")  # the flight that opened took the keyboard
    yield crew.take("calibration")
    crew.press("Space")
    crew.wait(lambda: page.run is not None, "the calibration")
    _set_surfaces(crew, page, lambda view: view.phase == "sign")
    yield crew.take("sign")
    _set_surfaces(crew, page, lambda view: len(view.points) == _POINTS)
    yield crew.take("points")
    crew.press("Alt+3")
    crew.pause(3.0)
    yield crew.take("checklist")
    crew.press("Alt+4")
    yield crew.take("cards")


def _certificate(folder: Path) -> Path:
    """Save what the page of a shipped certificate draws."""
    from calibration.overview import overview
    from gsapp.foundation import write_atomically
    from gsapp.report.certificate_report import certificate_document
    from gsapp.report.document import picture_png

    standing = {one.certificate.channel: one for one in overview("b777").standing}
    (picture,) = certificate_document(standing["elevator_left"]).pictures
    return write_atomically(folder / "certificate.png", picture_png(picture))


def _set_surfaces(
    crew: Photographer, page: WizardPage, enough: Callable[[WizardView], bool]
) -> None:
    """Let the helper at the bench do what is asked for, with a key for each setting."""
    asked: tuple[object, ...] = ()

    def goes_on() -> bool:
        nonlocal asked
        view = page.run.view
        if enough(view):
            return True
        channel = None if view.instrument is None else view.instrument.channel
        wanted = (channel, view.phase, view.target, view.direction)
        if channel is not None and wanted != asked:
            asked = wanted
            crew.press("H")
        return False

    crew.wait(goes_on, "the helper at the bench")


def main(arguments: Sequence[str] | None = None) -> int:
    """Take the pictures; see the module's text."""
    parser = argparse.ArgumentParser(prog="python -m ui.preflight.screenshots", description=__doc__)
    parser.add_argument("--out", type=Path, required=True, help="folder of the pictures")
    parser.add_argument("--theme", choices=sorted(THEMES), default="daylight")
    parser.add_argument("--scale", type=int, default=100, help="percent, 100 to 250")
    parser.add_argument("--size", default="1280x800", help="of the window")
    given = parser.parse_args(arguments)
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    width, _, height = given.size.partition("x")
    try:
        photograph(given.out, theme=given.theme, scale=given.scale, size=(int(width), int(height)))
    except GroundStationError as error:
        sys.exit(str(error))
    return 0


if __name__ == "__main__":
    sys.exit(main())

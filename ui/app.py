"""Starting the window: the display, Qt, the log, the settings."""

from __future__ import annotations

import gc
import importlib
import logging
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from gsapp.foundation import GroundStationError
from gsapp.foundation.process_control import exit_deadline, on_termination_signal
from ui.display_check import offscreen_font_folder, require_display
from ui.translation import install_translator, tr

if TYPE_CHECKING:
    from PySide6.QtWidgets import QApplication

_QT_PACKAGES = "libgl1 libegl1 libxkbcommon0 libdbus-1-3 libfontconfig1 libglib2.0-0"

_COLLECT_SECONDS = 1.0
_SHUTDOWN_SECONDS = 12.0
"""From a signal that asks the program to end until it is ended, whatever it still waits for."""
_IDLE_MS = 500  # From the opening of a window without a flight until it gets ready for one.

log = logging.getLogger(__name__)


def _require_qt() -> None:
    try:
        importlib.import_module("PySide6.QtWidgets")
    except ImportError as error:
        raise GroundStationError(
            f"Qt cannot be loaded ({error}). On Debian or Ubuntu type: "
            f"sudo apt install {_QT_PACKAGES}; elsewhere: pip install PySide6-Essentials"
        ) from error


def create_application() -> QApplication:
    """Return the one application of the process, made if there is none yet.

    From then on cyclic garbage is collected by its event loop alone. Python collects in whichever
    thread happens to allocate, and a window that is destroyed in another thread than its own ends
    the process.

    Raises
    ------
    NoDisplayError
        If there is no display: Qt would abort the process.
    GroundStationError
        If Qt cannot be loaded.
    """
    require_display()
    _require_qt()
    if (fonts := offscreen_font_folder()) is not None:
        os.environ.setdefault("QT_QPA_FONTDIR", fonts)
    from pyqtgraph.util.garbage_collector import GarbageCollector
    from PySide6.QtCore import Qt
    from PySide6.QtGui import QGuiApplication
    from PySide6.QtWidgets import QApplication

    known = QApplication.instance()
    if isinstance(known, QApplication):
        return known
    QGuiApplication.setHighDpiScaleFactorRoundingPolicy(
        Qt.HighDpiScaleFactorRoundingPolicy.PassThrough
    )
    application = QApplication([sys.argv[0] if sys.argv else "gsapp"])
    install_translator(application)
    application.setApplicationName("gsapp")
    application.setApplicationDisplayName(tr("Ground station"))
    application.setDesktopFileName("gsapp")
    # The same on all systems; the style sheet does the rest.
    application.setStyle("Fusion")
    # It works for as long as it is held.
    application.setProperty("collector", GarbageCollector(interval=_COLLECT_SECONDS))
    return application


def run_window(
    flight: Path | None = None,
    link: str | None = None,
    *,
    channel_map: str | None = None,
    calibration: str | None = None,
    aircraft: str | None = None,
    speed: float | str = 1.0,
    settings: Path | None = None,
    place: str = "",
) -> int:
    """Open the ground station window and run until it is closed.

    Parameters
    ----------
    flight : Path, optional
        Flight folder or file to open; a folder that a recorder is writing is followed live.
    channel_map, aircraft : str, optional
        Names or paths, in place of those used last.
    calibration : str, optional
        Certificates that a recorded flight is read with in place of its own.
    speed : float or str
        Of a replay, times real time, 0.1 to 50; ``max`` for as fast as it can.
    place : str
        Where to begin, as `ui.window_frame.navigation_rail` names it; the usual one where empty.

    Raises
    ------
    FlightError
        If the speed is none.
    """
    # The start is a tenth shorter without looking for garbage: nearly all that it makes stays.
    gc.disable()
    from gsapp.session.feeds import parse_speed

    times = parse_speed(speed)
    application = create_application()
    from PySide6.QtCore import QTimer

    from ui.error_reporter import ErrorReporter, start_logging
    from ui.main_window import MainWindow
    from ui.module_preloader import ModulePreloader
    from ui.screen_saver_inhibitor import ScreenSaverInhibitor
    from ui.settings import SettingsStore, log_path, settings_path

    start_logging(log_path())
    store = SettingsStore(settings or settings_path())
    error_reporter = ErrorReporter()
    error_reporter.install()
    window = MainWindow(store, error_reporter, offer_recorders=flight is None and link is None)
    lit_screen = ScreenSaverInhibitor(window.flight_controller)
    window.show()
    QTimer.singleShot(0, lambda: log.info("window opened, process %d", os.getpid()))
    # What it made is not looked through later either.
    gc.freeze()
    if place:
        QTimer.singleShot(0, lambda: window.show_page(place))
    if flight is not None:
        QTimer.singleShot(
            0,
            lambda: window.flight_controller.flight_opener.open_flight(
                flight, channel_map=channel_map, calibration=calibration, speed=times
            ),
        )
    elif link is not None:
        QTimer.singleShot(
            0,
            lambda: window.flight_controller.flight_opener.connect_link(
                link, channel_map=channel_map, aircraft=aircraft
            ),
        )
    else:
        # Nothing moves yet, so nobody sees the hitch.
        loader = ModulePreloader(lambda: not window.flight_controller.is_open, window)
        QTimer.singleShot(_IDLE_MS, loader, loader.start)
    try:
        # Python only sees a signal between its own steps, which the window's timer provides.
        with (
            on_termination_signal(lambda _signal: window.close_without_asking()),
            exit_deadline(_SHUTDOWN_SECONDS, log_path()),
        ):
            return int(application.exec())
    finally:
        lit_screen.close()
        window.flight_controller.close()
        error_reporter.remove()
        log.info("window closed, process %d", os.getpid())

"""A ground station window in a process of its own that tells a file what it holds and shows.

Arguments: folder of the settings, flight folder, file to write.
"""

import json
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from PySide6.QtCore import QTimer
from PySide6.QtGui import QImage

from gsapp.foundation import write_atomically
from ui.app import create_application
from ui.error_reporter import ErrorReporter
from ui.main_window import MainWindow
from ui.settings import SettingsStore


def alpha_columns(window: MainWindow) -> list[list[float]]:
    charts = window.view.charts
    image = charts.grab().toImage().convertToFormat(QImage.Format.Format_RGB32)
    geometry = charts.geometry_in_pixels
    names = charts.strip_layout.channels
    if geometry is None or "alpha" not in names:
        return []
    box = geometry.charts[geometry.numbers.index(names.index("alpha"))]
    pixels = np.frombuffer(image.constBits(), dtype=np.uint32).reshape(image.height(), -1)
    part = pixels[box.y : box.bottom, geometry.plot.x : geometry.plot.x + geometry.plot.width]
    colors = [int(color[1:], 16) for color in window.display_style.theme.traces.values()]
    seen = np.isin(part & 0xFFFFFF, colors).any(axis=0)
    return [[charts.view.time(x), int(one)] for x, one in enumerate(seen)]


def show_window(
    settings: Path,
    flight: Path,
    told: Path,
    describe: Callable[[MainWindow], dict[str, object]],
    milliseconds: int = 200,
    **changes: object,
) -> None:
    """Show a flight until killed, and write what a function tells of the window to a file."""
    application = create_application()
    store = SettingsStore(settings / "window.toml")
    store.change(muted=True, **changes)
    window = MainWindow(store, ErrorReporter(), offer_recorders=False)
    window.resize(1280, 800)
    window.show()
    window.flight_controller.flight_opener.open_flight(flight)

    def tell() -> None:
        if found := describe(window):
            write_atomically(told, json.dumps({"at": time.monotonic(), **found}))

    timer = QTimer()
    timer.timeout.connect(tell)
    timer.start(milliseconds)
    application.exec()


def describe(window: MainWindow) -> dict[str, object]:
    history = window.flight_controller.history
    if history is None or history.end is None or "alpha" not in history.channels:
        return {}
    block = history.block(("alpha",), 0.0, history.end)
    known = ~np.isnan(block["alpha"])
    return {
        "alarms": [one.key for one in window.flight_controller.unacknowledged_alarms()],
        "settled": window.flight_controller.is_up_to_date,
        "times": block.times[known].tolist(),
        "columns": alpha_columns(window),
    }


if __name__ == "__main__":
    show_window(*map(Path, sys.argv[1:]), describe, side_panel=False)

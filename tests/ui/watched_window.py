"""A ground station window in a process of its own that tells a file what it holds and shows.

Arguments: folder of the settings, flight folder, file to write.
"""

import json
import sys
import time
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


def main() -> None:
    """Show the flight until told to end."""
    settings, flight, told = map(Path, sys.argv[1:])
    application = create_application()
    store = SettingsStore(settings / "window.toml")
    store.change(muted=True, side_panel=False)
    window = MainWindow(store, ErrorReporter(), offer_recorders=False)
    window.resize(1280, 800)
    window.show()
    window.flight_controller.flight_opener.open_flight(flight)

    def tell() -> None:
        history = window.flight_controller.history
        if history is None or history.end is None or "alpha" not in history.channels:
            return
        block = history.block(("alpha",), 0.0, history.end)
        known = ~np.isnan(block["alpha"])
        state = {
            "at": time.monotonic(),
            "alarms": [one.key for one in window.flight_controller.unacknowledged_alarms()],
            "settled": window.flight_controller.is_up_to_date,
            "times": block.times[known].tolist(),
            "columns": alpha_columns(window),
        }
        write_atomically(told, json.dumps(state))

    timer = QTimer()
    timer.timeout.connect(tell)
    timer.start(200)
    application.exec()


main()

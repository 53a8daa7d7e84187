"""From the start of the program to the first useful picture; goal 2 s.

Each start is a process of its own: Python, imports, Qt, window. Counted is the wall time from
before the process is made until the window was flushed for the first time, and, where a flight is
opened with it, until it was flushed with samples in the charts.
"""

import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

STARTS = 5
_PATIENCE = 60.0


def start(scratch: Path, flight: Path | None) -> None:
    """Open the window as the program does; print the host times of its first pictures."""
    from PySide6.QtCore import QEvent, QTimer

    from ui.app import create_application
    from ui.error_reporter import ErrorReporter
    from ui.main_window import MainWindow
    from ui.settings import SettingsStore

    class Watched(MainWindow):
        pictures = 0

        def event(self, event: QEvent) -> bool:
            done = super().event(event)
            if event.type() == QEvent.Type.UpdateRequest:
                self.flushed()
            return done

        def flushed(self) -> None:
            if self.pictures == 0 or (self.pictures == 1 and self.view.charts.view.now is not None):
                self.pictures += 1
                print(time.time(), flush=True)
            if self.pictures == (1 if flight is None else 2):
                application.quit()

    application = create_application()
    store = SettingsStore(scratch / "window.toml")
    window = Watched(store, ErrorReporter(), offer_recorders=False)
    window.show()
    if flight is not None:
        QTimer.singleShot(0, lambda: window.flight_controller.flight_opener.open_flight(flight))
    QTimer.singleShot(round(1000 * _PATIENCE), application.quit)
    application.exec()
    window.flight_controller.close()


def seconds_to_pictures(scratch: Path, flight: Path | None) -> list[float]:
    begin = time.time()
    done = subprocess.run(
        [sys.executable, __file__, "start", str(scratch), *([str(flight)] if flight else [])],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)},
        capture_output=True,
        text=True,
        check=True,
    )
    return [float(line) - begin for line in done.stdout.split()]


def main(*options: str) -> None:
    """Start the window some times, without a flight and with one."""
    from tests.screenshots.virtual_flight import write_virtual_flight

    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    starts = 2 if "--quick" in options else STARTS
    with tempfile.TemporaryDirectory() as place:
        scratch = Path(place)
        os.environ["GSAPP_RUNTIME_FOLDER"] = str(scratch / "runtime")
        flight = write_virtual_flight(scratch)
        for text, opened in (("nothing open", None), ("a flight of 2 min opened", flight)):
            runs = [seconds_to_pictures(scratch, opened) for _ in range(starts)]
            first = statistics.median(run[0] for run in runs)
            print(f"{text:28} window {first:5.2f} s", end="")
            if opened is not None:
                print(f", charts {statistics.median(run[1] for run in runs):5.2f} s", end="")
            load = f", load {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
            print(f"   (median of {starts}, goal 2 s{load})", flush=True)


if __name__ == "__main__":
    if sys.argv[1:2] == ["start"]:
        start(Path(sys.argv[2]), Path(sys.argv[3]) if sys.argv[3:] else None)
    else:
        main(*sys.argv[1:])

"""A whole aircraft calibrated through the wizard's page: presses, time, bounds.

``python tests/bench/wizard_window.py [--seeds N]`` lets a simulated crew work through all surfaces
and vanes of so many virtual aircraft, and holds every curve against the truth.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from pathlib import Path

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
sys.path.insert(0, str(Path(__file__).parents[1] / "ui"))

import numpy as np
from bench_kit import BenchWindow, work_through
from PySide6.QtCore import Qt

from gsapp.dynamics.pilot.bench import VirtualBench
from gsapp.quantities import from_si
from ui.app import make_application


def calibrate(seed: int) -> None:
    """Calibrate one aircraft and print what it cost and what came of it."""
    with tempfile.TemporaryDirectory() as folder:
        window = BenchWindow(Path(folder), VirtualBench(seed))
        window.press(Qt.Key.Key_Space)
        window.desk.pass_time(4.0)
        work_through(window)
        points = inside = asked = 0
        for name, certificate in window.view.certificates.items():
            potentiometer = window.bench.potentiometers[name]
            points += len(certificate.points)
            angles = np.linspace(-18.0, 18.0, 73)
            for side in (-0.5, 0.5):
                volts = potentiometer.volts(angles + side * potentiometer.play, 4.9)
                found = from_si(certificate.evaluate(volts, 4.9), "deg", "angle")
                bound = from_si(certificate.uncertainty(volts, 4.9), "deg", "angle")
                inside += int(np.sum(np.abs(found - angles) <= bound))
                asked += angles.size
        print(
            f"seed {seed}: {len(window.view.certificates)} channels, {points} points, "
            f"{window.keys} presses, {window.bench.time / 60:.1f} min at the aircraft, "
            f"{100 * inside / asked:.1f} % of angles within their bounds"
        )
        window.leave()


def main() -> None:
    """Run the seeds."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=5)
    given = parser.parse_args()
    application = make_application()
    for seed in range(given.seeds):
        calibrate(seed)
    application.quit()


if __name__ == "__main__":
    main()

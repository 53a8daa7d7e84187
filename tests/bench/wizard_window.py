"""The calibration wizard through its page: whole aircraft and every fault, by keys.

A simulated crew works through all surfaces and vanes of one virtual aircraft after the other in
the real page, and every curve is held against the truth: 200 aircraft, seven potentiometers each,
with a protractor that is set exactly and with one that is set by hand. Then each kind of fault in
50 aircraft, another instrument each time: whether the page named it, and nothing else.
``--quick`` takes a tenth.
"""

import os
import sys
import tempfile
from pathlib import Path

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import numpy as np
from PySide6.QtCore import Qt

from gsapp.virtual.bench import BENCH_FAULT_KINDS, POTENTIOMETERS, BenchFault, VirtualBench
from gsapp.virtual.settings import VIRTUAL
from tests.calibration.wizard.bench_truth import within
from tests.ui.bench_kit import BenchWindow, leave_only, try_out, work_through
from ui.app import create_application


def whole_aircraft(seeds: int, setting_error: float) -> None:
    """Calibrate aircraft after aircraft, and print what it cost and what came of it.

    Parameters
    ----------
    seeds : int
    setting_error : float
        Standard deviation with which the protractor is set, deg.
    """
    keys, minutes, shares, slops, curves = [], [], [], [], 0
    for seed in range(seeds):
        with tempfile.TemporaryDirectory() as folder:
            window = BenchWindow(Path(folder), VirtualBench(seed, setting_error=setting_error))
            window.press(Qt.Key.Key_Space)
            window.controller.pass_time(4.0)
            work_through(window)
            random = np.random.default_rng(seed)
            for name, certificate in window.view.certificates.items():
                truth = window.bench.potentiometers[name]
                curves += 1
                shares.append(within(certificate, truth, random))
                bound = certificate.quality.hysteresis_uncertainty
                slops.append((certificate.hysteresis, truth.play, bound))
            keys.append(window.keys)
            minutes.append(window.bench.time / 60.0)
            window.leave()
    found, true, bounds = np.array(slops).T
    print(f"{seeds} aircraft, {curves} curves, protractor set to {setting_error:g} deg")
    print(f"presses an aircraft: {np.mean(keys):.2f} on average, {max(keys)} at most")
    print(f"minutes an aircraft, hands included: {np.mean(minutes):.1f}")
    print(
        f"angles within the stated 95 %: {100.0 * np.mean(shares):.1f} % of all; "
        f"at least 95 % of a curve's angles in {100.0 * np.mean(np.array(shares) >= 0.95):.1f} % "
        "of curves"
    )
    print(
        f"slop found: {100.0 * (found.sum() / true.sum() - 1.0):+.1f} % over all, within 10 % in "
        f"{100.0 * np.mean(np.abs(found / true - 1.0) <= 0.1):.1f} % of curves, within its stated "
        f"bound in {100.0 * np.mean(np.abs(found - true) <= bounds):.1f} %",
        flush=True,
    )


def faults(trials: int) -> None:
    """Move faulty instruments."""
    for kind in (*BENCH_FAULT_KINDS, None):
        right = 0
        for seed in range(trials):
            channel = POTENTIOMETERS[seed % 7]
            other = POTENTIOMETERS[(seed + 1 + seed // 7 % 6) % 7]
            fault = kind and BenchFault(
                channel=channel, kind=kind, other=other if kind == "swapped" else ""
            )
            with tempfile.TemporaryDirectory() as folder:
                leave_only(Path(folder), channel, other)
                bench = VirtualBench(1000 + seed, faults=[fault] if fault else [])
                window = BenchWindow(Path(folder), bench)
                right += try_out(window, channel) == (
                    [(kind, channel, fault.other)] if fault else []
                )
                window.leave()
        print(f"{kind or 'no fault':9} named right in {right} of {trials}", flush=True)


def main(*arguments: str) -> None:
    quick = "--quick" in arguments
    application = create_application()
    for setting_error in (0.0, VIRTUAL.angle_setting_std):
        whole_aircraft(20 if quick else 200, setting_error)
    faults(5 if quick else 50)
    application.quit()


if __name__ == "__main__":
    main(*sys.argv[1:])

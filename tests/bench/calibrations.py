"""Calibrations of drawn potentiometers against the truth.

A person at the virtual aircraft sets each surface upward and downward, five settings each; slope,
curvature, play, noise and supply are drawn, the converter has 12 bits, and a point is taken when
the volts are at rest. Then the surface goes anywhere, and single samples are turned into angles:
an uncertainty is honest where 95 of 100 lie within it. How well the protractor was read is varied;
nothing but points tells of the play, so that errors of reading limit how well its width is known.

Besides: faults of each kind named while one surface is moved; drift between two calibrations, and
the three-point check, found and not found.
"""

import datetime as dt
import sys
import time
from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import numpy as np

from calibration.curve_selection import create_certificate, fit_calibration
from calibration.drift import check_certificate, compute_drift
from calibration.points import CalibrationPoint
from calibration.voltage_monitor import VoltageMonitor
from gsapp.virtual.bench import POTENTIOMETERS
from tests.calibration.potentiometer_kit import (
    Sweep,
    fault_trial,
    named_right,
    quick_sweep,
    recovered,
    sweep,
)

FIRST_SEED = 5000
PROTRACTORS = (0.0, 0.05, 0.1, 0.2)
"""Standard deviations of reading one, deg."""
KINDS = ("", "dead", "noisy", "clipped", "swapped", "reversed")
STAMP = dt.datetime(2026, 1, 1, tzinfo=dt.UTC)


@dataclass
class Tally:
    """What many calibrations come to."""

    inside: list[float] = field(default_factory=list)
    widths: list[float] = field(default_factory=list)
    loops: list[float] = field(default_factory=list)
    bounded: list[bool] = field(default_factory=list)
    degrees: list[int] = field(default_factory=list)

    def add(self, points: list[CalibrationPoint], taken: Sweep, seed: int) -> None:
        made = fit_calibration(points)
        errors, widths = recovered(made, taken.potentiometer, seed)
        self.inside.append(float(np.mean(np.abs(errors) < widths)))
        self.widths.append(float(np.mean(widths)))
        self.degrees.append(made.degree)
        play, quality = taken.potentiometer.play, made.quality
        self.loops.append(quality.hysteresis / play - 1.0)
        self.bounded.append(abs(quality.hysteresis - play) < quality.hysteresis_uncertainty)

    @property
    def coverage(self) -> float:
        return 100.0 * float(np.mean(self.inside))

    @property
    def within_a_tenth(self) -> float:
        return 100.0 * float(np.mean(np.abs(self.loops) < 0.1))

    def row(self, title: str) -> str:
        chosen = [self.degrees.count(degree) for degree in (1, 2, 3)]
        return (
            f"{title:44} {len(self.inside):4d} {self.coverage:9.1f} {np.mean(self.widths):8.2f}"
            f" {self.within_a_tenth:10.1f} {100.0 * np.median(np.abs(self.loops)):9.1f}"
            f" {100.0 * np.mean(self.bounded):9.1f}   {'/'.join(str(n) for n in chosen)}"
        )


def recoveries(seeds: Iterable[int]) -> dict[str, Tally]:
    tallies: dict[str, Tally] = {}
    for seed in seeds:
        taken = sweep(seed, POTENTIOMETERS[seed % len(POTENTIOMETERS)])
        for error in PROTRACTORS:
            title = f"protractor read to {error:.2f} deg" if error else "protractor exact"
            tallies.setdefault(title, Tally()).add(taken.points(error, seed), taken, seed)
        title = "set and read by the virtual hand (0.08 deg)"
        tallies.setdefault(title, Tally()).add(taken.points(), taken, seed)
    return tallies


def faults(trials: int) -> dict[str, int]:
    return {
        kind or "none": sum(
            named_right(fault_trial(FIRST_SEED + trial, kind)) for trial in range(trials)
        )
        for kind in KINDS
    }


def drifts(seeds: Iterable[int], error: float) -> None:
    """Print how often a shift of zero is found by a second calibration, and by three points."""
    for zero in (0.0, 0.3, 0.5, 1.0):
        significant, failed = [], []
        for seed in seeds:
            taken = quick_sweep(seed, "rudder")
            former, later = (taken.points(error, seed + again) for again in (0, 10**6))
            later = [replace(point, value=point.value + zero) for point in later]
            certificates = [
                create_certificate(fit_calibration(points), points, channel_id="rudder",
                unit="deg", who="",
                        stamp=STAMP)
                for points in (former, later)
            ]  # fmt: skip
            significant.append(compute_drift(certificates[1], certificates[0]).significant)
            failed.append(not check_certificate(certificates[0], later[1:4]).passed)
        print(
            f"zero moved by {zero:3.1f} deg, protractor read to {error:.2f} deg: found by a new "
            f"calibration in {100.0 * np.mean(significant):5.1f} %, by the three-point check in "
            f"{100.0 * np.mean(failed):5.1f} % of {len(failed)}"
        )


def cost() -> tuple[float, float]:
    points = quick_sweep(FIRST_SEED, "rudder").points()
    start = time.process_time()
    for _ in range(20):
        fit_calibration(points)
    once = 1e3 * (time.process_time() - start) / 20.0
    watch = VoltageMonitor()
    times = np.arange(6000) / 100.0
    volts = np.random.default_rng(1).normal(2.5, 0.002, times.size)
    start = time.process_time()
    for low in range(0, times.size, 10):
        watch.feed(times[low : low + 10], volts[low : low + 10])
    return once, (time.process_time() - start) / 60.0


def main(*options: str) -> dict[str, float]:
    """Measure and print; return the figures that are asked for."""
    quick = "--quick" in options
    seeds = range(FIRST_SEED, FIRST_SEED + (20 if quick else 200))
    print(
        f"{'five settings up, five down':44} {'n':>4} {'inside, %':>9} {'U95, deg':>8} "
        f"{'loop 10 %':>10} {'median %':>9} {'bound, %':>9}   degrees 1/2/3"
    )
    tallies = recoveries(seeds)
    for title, tally in tallies.items():
        print(tally.row(title))
    print(
        "inside: samples within the stated 95 %; loop: width within 10 % of the play, and the "
        "median of its error; bound: width within its stated 95 %"
    )
    trials = 5 if quick else 50
    named = faults(trials)
    print("faults named right: " + ", ".join(f"{k} {n} of {trials}" for k, n in named.items()))
    drifts(seeds[:50], 0.1)
    once, share = cost()
    print(f"one calibration {once:.1f} ms of CPU; one watch {100.0 * share:.2f} % of a core")
    return {
        "least coverage, %": min(tally.coverage for tally in tallies.values()),
        "loops within a tenth, exact protractor, %": tallies["protractor exact"].within_a_tenth,
        "faults named right, %": 100.0 * sum(named.values()) / (trials * len(KINDS)),
    }


if __name__ == "__main__":
    main(*sys.argv[1:])

"""Gyros, accelerometers, pressures: errors over stated uncertainties, on many virtual benches.

Each seed is another aircraft, laid and turned by another crew. Half widths at 95 % are stated: so
many errors must lie within as would by chance in all but one of a hundred such tables. The rms of
error over the standard deviation that a half width stands for is shown too: 1 where it is exact,
less where it is careful (a crew lays the aircraft better than it is trusted to).
"""

import math
import sys
import time
from collections import defaultdict

import numpy as np
from scipy.stats import binom

from calibration import load_certificates
from calibration.inertial.accelerometers import ACCELEROMETERS
from calibration.inertial.gyros import GYROS, gyro_scale
from calibration.pressures import (
    PitotBlowDetector,
    create_covered_pitot_monitor,
    dynamic_pressure_zero,
)
from gsapp.virtual.bench import VirtualBench, parse_bench_fault
from tests.calibration.ground_crew import STAMP, gyro_work, rest, six_work

SEEDS, QUICK = 200, 20
FIRST_SEED = 5000
FAULTS = {"dead": "", "reversed": "", "swapped": ":with="}
TRIALS, QUICK_TRIALS = 50, 5

Errors = dict[str, list[tuple[float, float]]]
"""By what is measured: each error with its stated half width."""


def gyros(bench: VirtualBench, channel: str, errors: Errors) -> None:
    """Take one gyro of a bench: its zero at rest, its scale from a turn to either side."""
    axis = GYROS.index(channel)
    truth = bench.gyros
    work = gyro_work(bench, channel)
    zero = float(truth.zero[axis] + work.zero_time * truth.drift[axis])
    per_unit = float(truth.matrix[axis, axis])
    errors["gyro zero, deg/s"].append(
        ((work.zero.volts - zero) / per_unit, work.zero.uncertainty / abs(per_unit))
    )
    scale = gyro_scale(work.turns)
    errors["gyro scale, %"].append(
        (100.0 * (scale.sensitivity / per_unit - 1.0), 100.0 * scale.uncertainty / abs(per_unit))
    )


def accelerometers(bench: VirtualBench, errors: Errors) -> str:
    found = six_work(bench)
    truth = bench.accelerometers
    for index, name in enumerate(ACCELEROMETERS):
        fit, k = found.fits[name], float(truth.matrix[index, index])
        errors["accelerometer zero, mg"].append(
            (1e3 * (fit.zero - float(truth.zero[index])) / k, 1e3 * fit.zero_uncertainty / k)
        )
        errors["accelerometer scale, %"].append(
            (100.0 * (fit.sensitivity / k - 1.0), 100.0 * fit.sensitivity_uncertainty / k)
        )
        for other, lean in fit.cross.items():
            true = math.degrees(math.atan(truth.matrix[index, ACCELEROMETERS.index(other)] / k))
            errors["misalignment, deg"].append((lean - true, fit.cross_uncertainty[other]))
    return found.issue


def pressures(bench: VirtualBench, errors: Errors) -> bool:
    """Take the zero with the pitot covered, then blow; return whether it went green."""
    shipped = load_certificates("b777")
    dynamic, static = shipped["dynamic_pressure"], shipped["static_pressure"]
    truth = bench.pressures["dynamic_pressure"]
    bench.cover()
    zero = dynamic_pressure_zero(
        rest(bench, create_covered_pitot_monitor(dynamic, static)), dynamic, who="crew", stamp=STAMP
    )
    errors["covered pitot, Pa"].append(
        ((zero.volts - truth.zero) / truth.slope, zero.uncertainty / truth.slope)
    )
    detector = PitotBlowDetector(zero.certificate, static)
    bench.uncover()
    states = []
    for seconds in (lambda: 8.0, lambda: bench.blow() + 1.0):
        block = bench.step(seconds())
        detector.feed(
            block.times,
            {name: block[f"{name}_volts"] for name in ("dynamic_pressure", "static_pressure")},
        )
        states.append(detector.status.state)
    return states == ["waiting", "green"]


def forgotten(bench: VirtualBench) -> bool:
    shipped = load_certificates("b777")
    watch = create_covered_pitot_monitor(shipped["dynamic_pressure"], shipped["static_pressure"])
    for _ in range(60):
        block = bench.step(0.5)
        watch.feed(block.times, {name: block[f"{name}_volts"] for name in watch.channels})
        if watch.status.state == "rested":
            return True
    return False


def faults(trials: int) -> dict[str, tuple[int, int]]:
    """Return how many faults of gyros and accelerometers were named right, of how many."""
    right: dict[str, list[bool]] = defaultdict(list)
    for trial in range(trials):
        for kind, more in FAULTS.items():
            one, other = _pair(GYROS, trial)
            text = f"{one}:{kind}" + (f"{more}{other}" if more else "")
            bench = VirtualBench(FIRST_SEED + trial, faults=[parse_bench_fault(text)])
            right[f"gyro {kind}"].append(_gyro_verdict(bench, one) == kind)
            one, other = _pair(ACCELEROMETERS, trial)
            text = f"{one}:{kind}" + (f"{more}{other}" if more else "")
            bench = VirtualBench(FIRST_SEED + trial, faults=[parse_bench_fault(text)])
            wrong = {one, other} if more else {one}
            verdicts = {n: fit.verdict.kind for n, fit in six_work(bench).fits.items()}
            named = {n for n, verdict in verdicts.items() if verdict == kind}
            right[f"accelerometer {kind}"].append(named == wrong)
    return {what: (sum(found), len(found)) for what, found in right.items()}


def _pair(names: tuple[str, ...], trial: int) -> tuple[str, str]:
    return names[trial % 3], names[(trial + 1 + trial // 3 % 2) % 3]


def _gyro_verdict(bench: VirtualBench, channel: str) -> str:
    from calibration.inertial.gyros import evaluate_turn

    bench.step(bench.rotate(channel, 0.0, seconds=0.01) + 0.5)
    stop = bench.time + bench.rotate(channel, 360.0)
    start = stop - 12.0
    block = bench.step(stop + 2.0 - bench.time)
    volts = {name: block[f"{name}_volts"] for name in GYROS}
    turn = evaluate_turn(channel, block.times, volts, angle=360.0, turning=(start, stop))
    return turn.verdict.kind


def main(*options: str) -> None:
    """Print the table."""
    quick = "--quick" in options
    seeds = range(FIRST_SEED, FIRST_SEED + (QUICK if quick else SEEDS))
    errors: Errors = defaultdict(list)
    doubts, green, without = 0, 0, 0
    began = time.process_time()
    for seed in seeds:
        gyros(VirtualBench(seed), GYROS[seed % 3], errors)
        doubts += bool(accelerometers(VirtualBench(seed), errors))
        green += pressures(VirtualBench(seed), errors)
        without += forgotten(VirtualBench(seed))
    cpu = (time.process_time() - began) / len(seeds)
    print(f"{'':24}{'errors':>8}{'95 % of errors':>16}{'stated':>10}{'inside':>9}{'rms':>7}")
    for what, pairs in errors.items():
        error, stated = np.abs(np.array(pairs)).T
        ratio = error / stated
        print(
            f"{what:24}{len(pairs):8}{np.quantile(error, 0.95):16.3f}{np.median(stated):10.3f}"
            f"{100.0 * np.mean(ratio < 1.0):8.1f}%{1.96 * math.sqrt(np.mean(ratio**2)):7.2f}"
            f"{'' if np.sum(ratio < 1.0) >= binom.ppf(0.01, len(ratio), 0.95) else '   TOO FEW'}"
        )
    print(f"six positions doubted though well laid: {doubts} of {len(seeds)}")
    print(
        f"breaths that turned green by themselves, and wind that did not: {green} of {len(seeds)}"
    )
    print(f"pitots without their cover taken for covered in 30 s: {without} of {len(seeds)}")
    for what, (right, whole) in faults(QUICK_TRIALS if quick else TRIALS).items():
        print(f"{what:24} named right {right} of {whole}")
    print(f"CPU per aircraft: {cpu:.2f} s")


if __name__ == "__main__":
    main(*sys.argv[1:])

"""The calibration wizard on virtual aircraft: keys, errors over bounds, faults named.

For each seed a crew at the virtual bench does what the wizard asks, for seven potentiometers and
five settings up and down. Shown: keys pressed (a key each would be 70), minutes it took, how often
the true angle lies within the stated uncertainty, how the slop found compares with the true one.
Then each kind of fault, on another instrument each time: whether it was named, and nothing else.
Last the check of three points, between flights: surfaces stand about neutral, and either nothing
has moved, or all seven zeros have (by one and by two of their certificate's 95 % bounds), or all
slopes.

The crew sets a protractor to 0.05 deg (standard deviation), moves a surface in 1.2 s and 25 deg/s,
and stays at each angle until the tone, 0.6 s at least. It is at the next surface at once: how long
a protractor takes to be carried there is not in the minutes.
"""

import sys
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from calibration.certificate import Certificate
from calibration.plan import load_calibration_plan
from gsapp.virtual.bench import (
    BENCH_FAULT_KINDS,
    POTENTIOMETERS,
    BenchFault,
    Potentiometer,
    VirtualBench,
)
from tests.calibration.wizard.bench_crew import BenchCrew
from tests.calibration.wizard.bench_truth import within

PLAN = load_calibration_plan("b777").select_kinds(("surface", "vane"))


def whole_aircraft(seeds: int) -> None:
    """Calibrate aircraft after aircraft."""
    keys, minutes, shares, slops = [], [], [], []
    for seed in range(seeds):
        with tempfile.TemporaryDirectory() as folder:
            crew = BenchCrew(Path(folder), PLAN, VirtualBench(seed))
            crew.finish()
            keys.append(crew.keys)
            minutes.append(crew.bench.time / 60.0)
            random = np.random.default_rng(seed)
            for name, certificate in crew.field.store.in_force().items():
                truth = crew.bench.potentiometers[name]
                shares.append(within(certificate, truth, random))
                slops.append((certificate.hysteresis, truth.play))
    print(f"{seeds} aircraft, {', '.join(PLAN.channels)}")
    print(f"keys an aircraft: {np.mean(keys):.2f} on average, {max(keys)} at most; 70 would be one")
    print("                  for each point; each was for a curve that asked for a look")
    print(f"minutes an aircraft, hands included: {np.mean(minutes):.1f}")
    print(f"angles within the stated 95 %: {100.0 * np.mean(shares):.1f} %")
    found, true = np.array(slops).T
    print(
        f"slop found: {100.0 * (found.sum() / true.sum() - 1.0):+.1f} % of the true one over all, "
        f"{np.sqrt(np.mean((found - true) ** 2)):.3f} deg rms; a setting is off by 0.08 deg"
    )


def faults(trials: int) -> None:
    for kind in (*BENCH_FAULT_KINDS, None):
        right = 0
        for seed in range(trials):
            channel = POTENTIOMETERS[seed % 7]
            other = POTENTIOMETERS[(seed + 1 + seed // 7 % 6) % 7] if kind == "swapped" else ""
            found = [BenchFault(channel=channel, kind=kind, other=other)] if kind else []
            with tempfile.TemporaryDirectory() as folder:
                crew = BenchCrew(Path(folder), PLAN, VirtualBench(1000 + seed, faults=found))
                crew.try_out(channel)
            right += crew.named == ([(kind, channel, other)] if kind else [])
        print(f"{kind or 'no fault':9} named right in {right} of {trials}")


def _zero(bounds: float) -> Callable[[Potentiometer, Certificate], Potentiometer]:
    def moved(one: Potentiometer, certificate: Certificate) -> Potentiometer:
        quality = certificate.quality
        return replace(one, center=one.center + bounds * quality.uncertainty * one.slope)

    return moved


CHANGES: dict[str, Callable[[Potentiometer, Certificate], Potentiometer]] = {
    "nothing": lambda one, _: one,
    "zero, by the bound": _zero(1.0),
    "zero, by two bounds": _zero(2.0),
    "slope, by 3 %": lambda one, _: replace(one, slope=1.03 * one.slope),
}


def checks(seeds: int) -> None:
    """Calibrate aircraft after aircraft, change them, and check their certificates."""
    failed = dict.fromkeys(CHANGES, 0)
    seconds, keys, bounds = [], [], []
    for seed in range(seeds):
        with tempfile.TemporaryDirectory() as folder:
            crew = BenchCrew(Path(folder), PLAN, VirtualBench(2000 + seed))
            crew.finish()
            certificates = crew.field.store.in_force()
            bounds += [one.quality.uncertainty for one in certificates.values() if one.quality]
            truth = dict(crew.bench.potentiometers)
            left = np.random.default_rng(seed)
            for change, changed in CHANGES.items():
                for name in PLAN.channels:
                    crew.bench.potentiometers[name] = changed(truth[name], certificates[name])
                    crew.bench.set_angle(name, float(left.uniform(-2.0, 2.0)))
                crew.bench.step(4.0)
                crew.wizard = crew.field.begin(mode="check").wizard
                started, pressed = crew.bench.time, crew.keys
                crew.finish()
                failed[change] += sum(not one.passed for one in crew.view.accepted_checks.values())
                if change == "nothing":
                    seconds.append(crew.bench.time - started)
                    keys.append(crew.keys - pressed)
    count = 7 * seeds
    print(f"three points against the certificate in force, {seeds} aircraft; its bounds are")
    print(f"{np.median(bounds):.2f} deg in the middle, {min(bounds):.2f} to {max(bounds):.2f}")
    print(
        f"seconds an aircraft: {np.mean(seconds):.1f} on average, {max(seconds):.1f} at most; "
        f"keys: {np.mean(keys):.2f}, one for each certificate said not to hold"
    )
    for change, number in failed.items():
        share = 100.0 * number / count
        print(f"moved: {change:20} said not to hold {number} of {count}, {share:.1f} %")


def main(*arguments: str) -> None:
    quick = "--quick" in arguments
    whole_aircraft(4 if quick else 40)
    faults(5 if quick else 50)
    checks(20 if quick else 200)


if __name__ == "__main__":
    main(*sys.argv[1:])

"""The calibration wizard on virtual aircraft: keys, errors over bounds, faults named.

For each seed a crew at the virtual bench does what the wizard asks, for seven potentiometers and
five settings up and down. Shown: keys pressed (a key each would be 70), minutes it took, how often
the true angle lies within the stated uncertainty, how the slop found compares with the true one.
Then each kind of fault, on another instrument each time: whether it was named, and nothing else.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np

from calibration.plan import load_plan
from gsapp.dynamics.pilot.bench import (
    KINDS,
    POTENTIOMETERS,
    BenchFault,
    VirtualBench,
)

sys.path.insert(0, str(Path(__file__).parents[1] / "calibration" / "wizard"))
from bench_crew import BenchCrew
from bench_truth import within

PLAN = load_plan("b777").only(("surface", "vane"))


def whole_aircraft(seeds: int) -> None:
    """Calibrate aircraft after aircraft."""
    keys, minutes, waiting, shares, slops = [], [], 0, [], []
    for seed in range(seeds):
        with tempfile.TemporaryDirectory() as folder:
            crew = BenchCrew(Path(folder), PLAN, VirtualBench(seed))
            fits = 0
            while crew.view.phase != "done":
                key = crew.wizard.state.key
                crew.obey()
                fits = fits + 1 if crew.view.phase == "fit" and crew.wizard.state.key == key else 0
                if fits > 10:
                    # It will not be accepted by itself; the crew looks, and says yes.
                    waiting += 1
                    crew.press("accept")
            keys.append(crew.keys)
            minutes.append(crew.bench.time / 60.0)
            random = np.random.default_rng(seed)
            for name, certificate in crew.field.store.in_force().items():
                truth = crew.bench.potentiometers[name]
                shares.append(within(certificate, truth, random))
                slops.append((certificate.hysteresis, truth.play))
    print(f"{seeds} aircraft, {PLAN.listing}")
    print(f"keys an aircraft: {np.mean(keys):.2f} on average, {max(keys)} at most; 70 would be one")
    print(f"                  for each point; {waiting} of {7 * seeds} curves asked for a look")
    print(f"minutes an aircraft, hands included: {np.mean(minutes):.1f}")
    print(f"angles within the stated 95 %: {100.0 * np.mean(shares):.1f} %")
    found, true = np.array(slops).T
    print(
        f"slop found: {100.0 * (found.sum() / true.sum() - 1.0):+.1f} % of the true one over all, "
        f"{np.sqrt(np.mean((found - true) ** 2)):.3f} deg rms; a setting is off by 0.08 deg"
    )


def faults(trials: int) -> None:
    """Move faulty instruments."""
    for kind in (*KINDS, None):
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


def main(*arguments: str) -> None:
    """Run all; a tenth of it with ``--quick``."""
    quick = "--quick" in arguments
    whole_aircraft(4 if quick else 40)
    faults(5 if quick else 50)


if __name__ == "__main__":
    main(*sys.argv[1:])

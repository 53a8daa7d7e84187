"""What a search for a missing effect costs: CPU by phase, with and without something to find.

16 maneuvers of 10 s at 100 Hz that JSBSim flew, the same for both cases; 12 name the effect and 4
judge it. CPU time is that of this process with one thread for linear algebra, best of a few runs.
A fixed piece of work, done before and after, tells one machine, or one load of it, from another.

    python discrepancy_speed.py [--quick]
"""

import os
import sys
import time
from itertools import pairwise

# Read by numpy when it is first imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from gsapp.discrepancy.investigation import Investigation
from gsapp.discrepancy.settings import DiscrepancySettings, SearchProgress
from tests.discrepancy.blind.cases import Case, hidden
from tests.discrepancy.blind.flying import FlownCase, fly_case

GOAL = 10.0
"""CPU for 16 maneuvers with one effect found, s."""
EFFECT = "aero.Cm.alpha2"
SIZE, PRODUCTS = 400, 40


def yardstick() -> float:
    matrix = np.random.default_rng(0).standard_normal((SIZE, SIZE)) / SIZE**0.5
    started = time.process_time()
    product = matrix
    for _ in range(PRODUCTS):
        product = matrix @ product
    return time.process_time() - started


def searched(flown: FlownCase) -> tuple[dict[str, float], str]:
    marks: list[tuple[str, float]] = [("making maneuvers ready", time.process_time())]

    def told(progress: SearchProgress) -> None:
        marks.append((progress.activity, time.process_time()))

    investigation = Investigation(flown.maneuvers, flown.aircraft, flown.model)
    found = investigation.run(DiscrepancySettings(), progress=told)
    phases: dict[str, float] = {}
    for (doing, start), (_, end) in pairwise(marks):
        phases[doing] = phases.get(doing, 0.0) + end - start
    names = ", ".join(one.effect for one in found.effects) or "no effect"
    return phases, f"{found.verdict}, {names}"


def shown(title: str, flown: FlownCase, runs: int) -> None:
    found = [searched(flown) for _ in range(runs)]
    phases, verdict = min(found, key=lambda one: sum(one[0].values()))
    samples = sum(len(one.block.times) for one in flown.maneuvers)
    print(f"\n{title}: {len(flown.maneuvers)} maneuvers, {samples} samples; {verdict}")
    for doing, seconds in phases.items():
        print(f"  {seconds:6.2f} s  {doing}")
    total = sum(phases.values())
    print(f"  {total:6.2f} s  in all (goal {GOAL:.0f} s)")


def main(*arguments: str) -> None:
    runs = 1 if "--quick" in arguments else 3
    before = yardstick()
    shown("Nothing hidden", fly_case(Case(id="clean", group="nothing", verdicts=())), runs)
    shown(f"Hidden: {EFFECT}", fly_case(hidden(EFFECT)), runs)
    after = yardstick()
    print(
        f"\n{PRODUCTS} products of {SIZE} x {SIZE} matrices: {before:.2f} s of CPU before, "
        f"{after:.2f} s after"
    )


if __name__ == "__main__":
    main(*sys.argv[1:])

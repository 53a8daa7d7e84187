"""The trim cue over 300 flights towards trim and away from it: is GO given, and given rightly.

Truth are the states of the simulator over the last second against the tolerances that
`gsapp.excitation.trim.trim_cue` states (five degrees of bank with attitude, eight without;
rates, climb, change of speed, unrest over three seconds) and those of the test point (5 ft/s,
1.5 deg). Moments within 10 % of a boundary are counted apart. The aircraft appears in mid-air, so
the first eight seconds do not count, and nothing does once the input begins.
"""

import sys
import time

import numpy as np

from tests.virtual.approaches import fly_approach
from tests.virtual.trim_truth import IN_TIME, INSTRUMENTS, Score, score

FLIGHTS = 300
AIR = (0.0, 0.3, 0.6, 1.0)
"""Gusts, m/s, flown in turn."""
_HEADINGS = ("GO right", "edge", "wrong", "trimmed", f"in {IN_TIME:g} s", "late", "over", "gusty")


def main(*options: str) -> None:
    """Fly, and print what the cues were worth by air and by instruments."""
    count = FLIGHTS // 10 if "--quick" in options else FLIGHTS
    scores = {(air, name): Score() for air in AIR for name in INSTRUMENTS}
    cost = 0.0
    for seed in range(count):
        air = AIR[seed % len(AIR)]
        flown = fly_approach(seed, turbulence=air)
        began = time.process_time()
        for name in INSTRUMENTS:
            scores[air, name].add(score(flown, name))
        cost += time.process_time() - began
    print(f"{count} flights, seeds 0 to {count - 1}, each judged with three sets of instruments")
    print(f"{'gusts, instruments':31}{'  '.join(f'{name:>8}' for name in _HEADINGS)}   changes/min")
    whole = Score()
    for (air, name), one in scores.items():
        print(f"{air:.1f} m/s  {name:22}{_line(one)}")
        whole.add(one)
    for name in INSTRUMENTS:
        together = Score()
        for air in AIR:
            together.add(scores[air, name])
        print(f"all air  {name:22}{_line(together)}")
    print(f"{'everything':31}{_line(whole)}")
    delays = np.array(whole.delays)
    print(
        f"GO after trim: median {np.median(delays):.2f} s, 95 % within "
        f"{np.quantile(delays, 0.95):.2f} s of flight time"
    )
    print(f"GO stood for {whole.go:.0f} s, {whole.overstayed:.0f} s of it with trim lost already")
    print(f"states left within 0.6 s, GO apart: {whole.hasty} of {whole.changes} changes")
    print(f"judging and scoring: {100.0 * cost / whole.seconds:.2f} % of the time flown")


def _line(one: Score) -> str:
    share = f"{100.0 * one.in_time / one.trimmed:.1f} %" if one.trimmed else "-"
    cells = (
        one.right,
        one.edge,
        one.wrong,
        one.trimmed,
        share,
        one.trimmed - one.in_time,
        f"{one.overstayed:.1f} s",
        f"{100.0 * one.gusty / one.seconds:.0f} %",
    )
    return "  ".join(f"{cell:>8}" for cell in cells) + f"   {60.0 * one.changes / one.seconds:.1f}"


if __name__ == "__main__":
    main(*sys.argv[1:])

"""Verdicts on 300 virtual inputs against the truth of the simulator.

Each input is flown with a drawn surface, amplitude, width, symmetry, trim, second stick, rest of
the stick, hands-off time, turbulence, noise, with attitude or without (`tests/virtual/inputs.py`),
after eight seconds on the ground with the engines running. In seven of ten the crew has said what
comes. The label is drawn from the true states at the CG and these stated bands, in this order; the
first that is beyond its limit is the label:

- too large, clipped: a true rate beyond the gyro's range for 0.03 s;
- not trimmed: a mean over the last true second beyond twice the stated tolerances of GO
  (`TrimTolerances`; bank as stated for the instruments at hand), or airspeed beyond twice 5 ft/s;
- invalid by a stick: another true surface beyond 35 % of the main one, both as shares of travel;
  the moved one left beyond 40 % of its amplitude; hands off for less than half of the interval
  that `TargetInput` states, until the pilot's hand moves a true surface by 0.3 deg;
- too small: a true surface's amplitude below the band that `TargetInput` states for the true model
  and the noise of the day;
- too large: true alpha, beta or a_n out of the linear range for 0.1 s;
- invalid by gusts: what gusts add to the true answer (against a second run of the same sticks in
  air that stays as it was when the input began) beyond half of the answer without them, root mean
  square over what answers to the surfaces (elevator alpha, q, a_n; aileron p, r; rudder beta, p, r,
  a_y) until the hands-off interval ends;
- too fast, too slow: true width of a step out of the band that `TargetInput` states;
- else good.

Where a criterion that counts lies within 10 % of its limit the case is scored apart.
"""

import math
import sys
import time
from collections import Counter

import numpy as np

from tests.excitation.verdict_kit import Heard, first_move, label, listen, own, wanted_of
from tests.virtual.inputs import FlownInput, fly_input

SEEDS = range(18_000, 18_300)
"""Those below 17,000 were looked at while the watch was built, these only when it was done."""


class Score:
    """Counts what was said of what was flown."""

    def __init__(self) -> None:
        self.pairs: Counter[tuple[str, str]] = Counter()
        self.apart: Counter[bool] = Counter()
        self.false = 0
        self.missed = 0
        self.flown = 0.0
        self.delays: list[float] = []
        self.countdowns: list[float] = []
        self.latencies: list[float] = []
        self.cpu = 0.0
        self.worst: list[str] = []

    def add(self, seed: int) -> None:
        flown = fly_input(seed, ground=8.0)
        wanted = wanted_of(flown)
        truth = label(flown, wanted)
        started = time.process_time()
        heard = listen(flown, expected=seed % 10 < 7)
        self.cpu += time.process_time() - started
        self.flown += float(flown.truth.times[-1] - flown.truth.times[0])
        said = self._said(flown, heard, wanted.hands_off)
        if truth.near:
            self.apart[said == truth.result] += 1
        else:
            self.pairs[truth.result, said] += 1
            if said != truth.result:
                self.worst.append(f"seed {seed}: {truth.result}, said {said}; {truth.values}")

    def _said(self, flown: FlownInput, heard: Heard, hands_off: float) -> str:
        if math.isfinite(heard.recognized):
            self.delays.append(heard.recognized - first_move(flown))
        mine = own(flown, heard.verdicts)
        self.false += len(heard.verdicts) - len(mine)
        if not mine:
            self.missed += 1
            return "missed"
        verdict = mine[0]
        ends = min(verdict.t_input_end + hands_off, verdict.t_end)
        self.latencies.append(verdict.given_at - ends)
        if math.isfinite(heard.countdown):
            self.countdowns.append(heard.countdown - verdict.t_input_end)
        return verdict.result


def main(*options: str) -> dict[str, float]:
    """Fly, print and return the agreement, and how late things were said."""
    score = Score()
    for seed in SEEDS[: 30 if "--quick" in options else 300]:
        score.add(seed)
    right = sum(count for (truth, said), count in score.pairs.items() if truth == said)
    clear, near = sum(score.pairs.values()), sum(score.apart.values())
    results = {
        "agreement": right / clear,
        "agreement near a boundary": score.apart[True] / max(near, 1),
        "cases": clear,
        "cases near a boundary": near,
        "missed": score.missed,
        "false inputs": score.false,
        "share of a core": score.cpu / score.flown,
    }
    print(f"{right} of {clear} clear cases agree ({100.0 * right / clear:.1f} %; goal 97 %); "
          f"within 10 % of a boundary {score.apart[True]} of {near}")  # fmt: skip
    _confusion(score.pairs)
    print(f"missed {score.missed}; said of no input {score.false} in {score.flown / 60.0:.0f} min")
    for text, values, key in (
        ("first true motion to recognized", score.delays, "recognized"),
        ("sticks back to hands off told", score.countdowns, "hands off"),
        ("end of the hands-off interval to the verdict", score.latencies, "latency"),
    ):
        median, late, last = np.quantile(values, (0.5, 0.95, 1.0))
        results[f"{key}, 95 %"] = float(late)
        print(f"{text:46} median {median:6.3f}  95 % {late:6.3f}  longest {last:6.3f} s")
    print(f"{'watching':46} {100.0 * results['share of a core']:.2f} % of a core")
    print("\n".join(score.worst))
    return results


def _confusion(pairs: Counter[tuple[str, str]]) -> None:
    names = sorted({name for pair in pairs for name in pair})
    truths = [name for name in names if name != "missed"]
    print(f"{'truth, said':14}" + "".join(f"{name:>13}" for name in names))
    for truth in truths:
        print(f"{truth:14}" + "".join(f"{pairs[truth, said] or '.':>13}" for said in names))


if __name__ == "__main__":
    main(*sys.argv[1:])

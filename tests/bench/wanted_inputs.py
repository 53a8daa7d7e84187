"""Inputs asked for at a test point, flown open loop on the nonlinear simulator.

A hundred aircraft: each derivative of the B777's model drawn anew (a factor with a standard
deviation of 15 %), a speed from 75 to 120 ft/s, and an elevator, aileron, rudder or combined
doublet. What was asked for is flown without noise and gusts, and compared with what it promises:

- the largest amplitude reaches the first of the limits (linear range, load factor, 90 % of a
  sensor's range), with either side first and the worse one counting;
- the least amplitude brings the rate about its axis 12 times and the best channel 25 times out
  of the noise of the aircraft file;
- no other width leaves more motion behind for each degree of amplitude: a scan over widths.
"""

import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gsapp.dynamics.model import Model
from gsapp.excitation.test_points.point import TargetInput
from gsapp.excitation.test_points.target_selection import select_target_input
from gsapp.quantities.constants import DEGREE
from tests.excitation.points_kit import BEFORE, DT, b777, flown, nearest_limit, point, standing_out

SEEDS = 100
_SURFACES = (("de",), ("da",), ("dr",), ("da", "dr"))
_SPREAD = 0.15
_ANSWER = {"de": "q", "da": "p", "dr": "beta"}
_SCAN = np.array([0.4, 0.55, 0.7, 0.8, 0.9, 1.0, 1.1, 1.25, 1.4, 1.6])


@dataclass(frozen=True, slots=True, kw_only=True)
class _Case:
    """One aircraft at one speed, and how its input did.

    Attributes
    ----------
    surfaces : tuple of str
    limit : float
        Share of the first limit that the largest amplitude used.
    noise : float
        Answer of the least amplitude over what it promises; NaN for combined inputs.
    best : float
        Width that left the most motion behind over the one asked for; NaN for combined inputs.
    left : float
        Motion left behind by the width asked for over the most; NaN for combined inputs.
    cost : float
        CPU time of asking, s.
    """

    surfaces: tuple[str, ...]
    limit: float
    noise: float
    best: float
    left: float
    cost: float


def main(*arguments: str) -> None:
    """Fly all, print shares."""
    seeds = range(SEEDS // 10 if "--quick" in arguments else SEEDS)
    cases = [_case(seed) for seed in seeds]
    print(f"{len(cases)} aircraft, seeds 0 to {len(cases) - 1}")
    print(f"{'':16}{'limit used at the high end':>36}{'over the noise at the low end':>36}")
    for surfaces in (*_SURFACES, ()):
        chosen = [case for case in cases if case.surfaces == surfaces or not surfaces]
        name = " and ".join(surfaces) or "all"
        print(f"{name:16}", _spread([c.limit for c in chosen]), _spread([c.noise for c in chosen]))
    print(f"\n{'':16}{'best width of a scan over asked for':>36}{'answer left over the most':>36}")
    for surfaces in (*_SURFACES[:3], ()):
        chosen = [case for case in cases if case.surfaces == surfaces or not surfaces]
        name = " and ".join(surfaces) or "all"
        print(f"{name:16}", _spread([c.best for c in chosen]), _spread([c.left for c in chosen]))
    cost = 1e3 * float(np.median([case.cost for case in cases]))
    print(f"\nasking takes {cost:.1f} ms of CPU (median)")


def _spread(values: Sequence[float]) -> str:
    known = np.array([value for value in values if np.isfinite(value)])
    if not known.size:
        return f"{'':>36}"
    low, middle, high = np.quantile(known, (0.05, 0.5, 0.95))
    near = 100.0 * float(np.mean(np.abs(known - 1.0) <= 0.25))
    return f"{middle:8.2f} ({low:.2f} to {high:.2f}), {near:3.0f} % near"


def _case(seed: int) -> _Case:
    random = np.random.default_rng(seed)
    aircraft, usual = b777()
    factors = {
        name: value * float(np.exp(_SPREAD * random.standard_normal()))
        for name, value in usual.derivatives.items()
        if not name.endswith("_0")
    }
    model = usual.with_derivatives(factors)
    speed = float(random.uniform(75.0, 120.0))
    surfaces = _SURFACES[seed % len(_SURFACES)]
    began = time.process_time()
    wanted = select_target_input(
        surfaces, "doublet", aircraft=aircraft, model=model, point=point(speed)
    )
    cost = time.process_time() - began
    noise = best = left = float("nan")
    if len(surfaces) == 1:
        noise = _noise(wanted, speed, model)
        best, left = _scanned(wanted, speed, model)
    return _Case(
        surfaces=surfaces,
        limit=_limit(wanted, speed, model),
        noise=noise,
        best=best,
        left=left,
        cost=cost,
    )


def _limit(wanted: TargetInput, speed: float, model: Model) -> float:
    used = []
    for sign in (1.0, -1.0):
        sizes = {name: band.high for name, band in wanted.amplitudes.items()}
        sizes[wanted.surfaces[-1]] *= sign
        used.append(nearest_limit(flown(speed, sizes, wanted.width.best, model=model)))
    return max(used)


def _noise(wanted: TargetInput, speed: float, model: Model) -> float:
    (surface,) = wanted.surfaces
    play = 0.5 * getattr(b777()[0].controls, surface).slop
    size, width = wanted.amplitudes[surface].low + play, wanted.width.best
    return standing_out(flown(speed, {surface: size}, width, model=model), surface, width)


def _scanned(wanted: TargetInput, speed: float, model: Model) -> tuple[float, float]:
    (surface,) = wanted.surfaces
    left = []
    for width in (wanted.width.best * _SCAN).tolist():
        motion = flown(speed, {surface: 3.0 * DEGREE}, width, after=1.5, model=model)
        free = motion[_ANSWER[surface]][round((BEFORE + 2.0 * width) / DT) :]
        left.append(float(np.ptp(free)))
    asked = left[int(np.flatnonzero(_SCAN == 1.0)[0])]
    return float(_SCAN[int(np.argmax(left))]), asked / max(left)


if __name__ == "__main__":
    main(*sys.argv[1:])

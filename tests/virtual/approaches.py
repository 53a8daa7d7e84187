"""Flights towards trim and away from it: what a trim cue has to follow.

A scripted pilot is twice far from what is wanted and twice comes close to it: with bank, speed and
nose as they were drawn, now well within any tolerance, now at its edge. Then an input ends it.

::

    flown = fly_approach(7, turbulence=0.3)
"""

import math
from dataclasses import replace
from itertools import accumulate

import numpy as np

from gsapp.quantities.constants import DEGREE, FOOT
from tests.virtual.input_plan import InputPlan, draw
from tests.virtual.inputs import FlownInput, InputFlight

_NOSE_STICK = 0.12
"""Pitch stick by which the nose is held too high or too low, of full stick."""


class _Approach(InputFlight):
    """Corrects towards one goal after the other."""

    def __init__(self, plan: InputPlan, random: np.random.Generator) -> None:
        super().__init__(plan, random)
        goals = random.spawn(1)[0]
        lengths = (
            goals.uniform(6.0, 8.0),
            goals.uniform(4.0, 8.0),
            goals.uniform(2.0, 4.0),
            goals.uniform(4.0, 8.0),
        )
        self._until = list(accumulate(float(length) for length in lengths))
        self._goals = [_goal(goals, far=place % 2 == 0) for place in range(4)]
        self.plan = replace(plan, approach=self._until[-1], bank=0.0, speed_off=0.0)

    def beside(self, time: float) -> tuple[float, float, float]:
        return self._goals[sum(time >= until for until in self._until[:-1])]


def _goal(random: np.random.Generator, *, far: bool) -> tuple[float, float, float]:
    if not far:
        return (
            2.5 * DEGREE * float(random.standard_normal()),
            2.0 * FOOT * float(random.standard_normal()),
            0.01 * float(random.standard_normal()),
        )
    side = -1.0 if random.random() < 0.5 else 1.0
    what = int(random.integers(4))
    bank = side * random.uniform(6.0, 35.0) * DEGREE if what in (0, 3) else 0.0
    fast = side * random.uniform(6.0, 15.0) * FOOT if what in (1, 3) else 0.0
    nose = side * random.uniform(0.3, 1.0) * _NOSE_STICK if what == 2 else 0.0
    return float(bank), float(fast), float(nose)


def fly_approach(seed: int, *, turbulence: float) -> FlownInput:
    """Fly towards trim, away from it and back, then an input; all that is random from the seed.

    Parameters
    ----------
    seed : int
    turbulence : float
        Standard deviation of the gusts, m/s.

    Returns
    -------
    FlownInput
        With attitude; the approach ends at ``t_input``.
    """
    random = np.random.default_rng((seed, 8))
    plan = replace(
        draw(seed), turbulence=turbulence, attitude=True, still=0.8, hands_off=0.3, meddling=()
    )
    start = (math.copysign(random.uniform(3.0, 30.0), random.uniform(-1, 1)) * DEGREE,)
    plan = replace(plan, start=(*start, *plan.start[1:]))
    return _Approach(plan, random).fly()

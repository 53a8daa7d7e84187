"""The search for a missing effect during a flight: named before landing, and falsely.

After every third maneuver of a blind flight (`tests/discrepancy/blind`, the reported seeds) the
search of the Derivatives panel runs over all maneuvers so far. Effects of 10 sigma a flight should
be named in 80 %, and nothing in flights with nothing hidden. Its CPU is that of a process of its
own.

Alone: ``python tests/bench/live_search.py [HIDDEN CLEAN [PROCESSES]]``, how many flights of each;
about a minute of CPU a flight.
"""

import sys
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass

import numpy as np

from gsapp.session.live_estimation.live_search import (
    LiveSearchRequest,
    LiveSearchResult,
    confirm_names,
    run_search_request,
)
from tests.discrepancy.blind.cases import MISSING, WHOLE, Case, all_cases
from tests.discrepancy.blind.flying import fly_case
from tests.discrepancy.blind.sensitivity import with_sizes

FIRST, EVERY = 4, 3  # Maneuvers before the first search, and between searches.


@dataclass(frozen=True, slots=True, kw_only=True)
class Flight:
    case: Case
    steps: tuple[LiveSearchResult, ...]
    cpu: float  # s, of all searches.

    @property
    def right(self) -> tuple[str, ...]:
        return self.case.accepted[0] if self.case.accepted else ()

    @property
    def named_after(self) -> int | None:
        """Return the number of maneuvers after which the effect was named; None if never."""
        return next(
            (one.maneuvers for one in self.steps if any(name in self.right for name in one.named)),
            None,
        )

    @property
    def false_names(self) -> tuple[str, ...]:
        every = dict.fromkeys(name for one in self.steps for name in one.named)
        return tuple(name for name in every if name not in self.right)


def flights(hidden: int, clean: int) -> list[Case]:
    """Return cases evenly over kinds, seeds and air; without what a fitted model cannot lack."""
    every = all_cases("report")
    strong = [
        one
        for one in every
        if one.group == "hidden"
        and one.sigma == 10.0
        and one.kind not in MISSING
        and not one.kind.endswith(WHOLE)
    ]
    still = [one for one in every if one.verdicts == ("model-adequate",)]
    return [*_spread(strong, hidden), *_spread(still, clean)]


def _spread(cases: Sequence[Case], count: int) -> list[Case]:
    places = np.linspace(0, len(cases), min(count, len(cases)), endpoint=False).astype(int)
    return [cases[place] for place in places]


def fly(case: Case) -> Flight:
    maneuvers = fly_case(with_sizes(case)).maneuvers
    started = time.process_time()
    steps: list[LiveSearchResult] = []
    for count in range(FIRST, len(maneuvers) + 1, EVERY):
        step = run_search_request(LiveSearchRequest(maneuvers=tuple(maneuvers[:count])))
        steps.append(confirm_names(steps, step))
    return Flight(case=case, steps=tuple(steps), cpu=time.process_time() - started)


def main(*arguments: str) -> None:
    """Run and print."""
    hidden, clean, processes = (*(int(one) for one in arguments), *(33, 66, 2)[len(arguments) :])
    named, nothing = [], []
    with ProcessPoolExecutor(max_workers=processes) as pool:
        for one in pool.map(fly, flights(hidden, clean)):
            (named if one.right else nothing).append(one)
            after = f"named after {one.named_after}" if one.named_after else "not named"
            print(
                f"{one.case.id} ({one.case.air}): {after if one.right else 'nothing hidden'}, "
                f"false {', '.join(one.false_names) or 'none'}, last "
                f"{one.steps[-1].verdict or one.steps[-1].why}, CPU {one.cpu:.0f} s",
                flush=True,
            )
    late = [one.named_after for one in named if one.named_after]
    print(
        f"hidden, 10 sigma: {len(late)} of {len(named)} named before landing, after "
        f"{np.median(late):.0f} maneuvers (median); false names in "
        f"{sum(bool(one.false_names) for one in named)}"
    )
    print(
        f"clean: false names in {sum(bool(one.false_names) for one in nothing)} of {len(nothing)}"
    )
    each = [one.cpu / len(one.steps) for one in (*named, *nothing)]
    print(f"CPU of a search: median {np.median(each):.1f} s, longest mean {max(each):.1f} s")


if __name__ == "__main__":
    main(*sys.argv[1:])

"""Experiments that decide: searches that end open, the cards designed for them, flown and searched.

A first flight of seven small maneuvers at one speed, with one effect hidden, flown by JSBSim
(`tests/discrepancy/blind`). Where the search cannot tell the effect from others, the cards that it
designs are flown with the same hidden truth by hands that miss sizes and times by 10 to 15 %, and
the search runs again over all maneuvers. It has decided where it names an effect outright; rightly
where that is the hidden one. Separations are the root of twice a difference in log-likelihood, of
which of lag and delay a part counts.

Alone: ``python tests/bench/deciding_experiment.py [FIRST [LAST]]``, seeds; minutes of CPU each.
"""

import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from gsapp.discrepancy.investigation import Investigation
from gsapp.discrepancy.results import DecidingExperiment, DiscrepancyResult
from gsapp.discrepancy.settings import SEARCH, DiscrepancySettings
from gsapp.flight.cards import TestCard
from gsapp.quantities.constants import DEGREE, FOOT
from tests.discrepancy.blind.cases import Case, Recording, hidden, neutral, typical
from tests.discrepancy.blind.flying import fly_case
from tests.discrepancy.blind.plan import Move, Planned

KINDS = (
    "aero.Cm.speed", "aero.CX.speed", "aero.CZ.speed", "aero.Cl.alpha_beta", "aero.Cn.alpha_beta",
    "aero.Cn.beta3", "aero.Cl.beta3", "aero.Cm.alphadot", "propulsion.thrust.scale",
    "propulsion.Cm.throttle", "sensor.alpha.delay", "sensor.beta.lag",
)  # fmt: skip
"""Effects that look like others at one speed."""
SIZES = (0.7, 1.5)
"""Of what is typical."""
RECORDINGS = (
    Recording(noise=2.0),
    Recording(noise=2.0, rate=50, attitude=False),
    Recording(gust=0.3),
)
"""What goes round with the seeds."""


def doublets(first: int, count: int, channel: str, size: float, width: float) -> Iterator[Planned]:
    for number in range(first, first + count):
        moves = tuple(
            Move(channel=channel, shape="doublet", size=size * DEGREE, width=width, start=start)
            for start in (1.0, 5.5)
        )
        yield Planned(id=str(number), flight="A", kind="doublet", speed=95.0, moves=moves)


FIRST_FLIGHT = (
    *doublets(1, 3, "de", 3.0, 0.4),
    *doublets(4, 2, "da", 4.0, 0.4),
    *doublets(6, 2, "dr", 8.0, 0.5),
)


def planned(cards: Sequence[TestCard], first: int) -> Iterator[Planned]:
    """Yield the maneuvers that cards ask for."""
    number = first
    for card in cards:
        ((channel, size),) = card.amplitudes.items()
        moves = [Move(channel=channel, shape=card.kind, size=size, width=card.width)]
        if card.throttle_step:
            end = 1.0 + card.duration
            moves.append(
                Move(channel="throttle", shape="lever", size=card.throttle_step, start=end)
            )
        for _ in range(card.repeats):
            yield Planned(
                id=str(number), flight="B", kind=card.kind, speed=card.speed / FOOT,
                moves=tuple(moves), flap=card.flap / DEGREE,
            )  # fmt: skip
            number += 1


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """One search that ended open, and what its experiment brought."""

    case: Case
    experiment: DecidingExperiment
    verdict: str
    named: tuple[str, ...]  # Named outright after the experiment.
    reached: float

    @property
    def accepted(self) -> tuple[str, ...]:
        return self.case.accepted[0]

    @property
    def decided(self) -> bool:
        return bool(self.named)

    @property
    def is_right(self) -> bool:
        return any(one in self.accepted for one in self.named)


def search(case: Case, maneuvers: Sequence[Planned]) -> DiscrepancyResult:
    flown = fly_case(case, maneuvers)
    return Investigation(flown.maneuvers, flown.aircraft, flown.model).run(DiscrepancySettings())


def reached_separation(found: DiscrepancyResult, among: Sequence[str]) -> float:
    """Return by how much the best of these effects is ahead of the next, standard deviations."""
    scores = [
        sorted((one.score for one in step.ranking if one.effect in among), reverse=True)
        for step in found.steps
    ]
    best = max(scores, key=lambda step: step[0] if step else 0.0)
    # What is no longer among the first twelve is as far behind as the last of them, or more.
    if not best:
        return 0.0
    ahead = 2.0 * max(best[0] - (best[1] if len(best) > 1 else 0.0), 0.0)
    if {one.rpartition(".")[2] for one in among} == {"lag", "delay"}:
        ahead *= SEARCH.lag_delay_factor
    return float(np.sqrt(ahead))


def attempt(case: Case) -> Trial | None:
    """Return what the experiment for a case brought; None where the first search is not open."""
    first = search(case, FIRST_FLIGHT)
    one = first.experiment
    if one is None or one.purpose != "separate":
        return None
    more = tuple(planned(one.cards, len(FIRST_FLIGHT) + 1))
    then = search(case, (*FIRST_FLIGHT, *more))
    return Trial(
        case=case,
        experiment=one,
        verdict=then.verdict,
        named=tuple(effect.effect for effect in then.effects if effect.named and not effect.one_of),
        reached=reached_separation(then, one.effects),
    )


def cases(seeds: Sequence[int]) -> Iterator[Case]:
    for plan in seeds:
        for kind in KINDS:
            for share in SIZES:
                size = neutral(kind) + share * (typical(kind) - neutral(kind))
                case = hidden(
                    kind, size, id=f"{kind}-{share:g}-{plan}", plan=plan, seed=9000 + plan
                )
                yield case.recorded_as(RECORDINGS[plan % len(RECORDINGS)], "fitted")


def report(trials: Sequence[Trial]) -> None:
    sure = [one for one in trials if one.experiment.decides]
    for title, group in (("all", trials), ("said to decide", sure)):
        if not group:
            continue
        decided = np.mean([one.decided for one in group])
        right = np.mean([one.is_right for one in group])
        ratio = [one.reached / one.experiment.separation for one in group]
        print(
            f"{title}: {len(group)} experiments, decided {decided:.0%}, rightly {right:.0%}; "
            f"separation reached over predicted: median {np.median(ratio):.2f}, "
            f"quartiles {np.quantile(ratio, 0.25):.2f} to {np.quantile(ratio, 0.75):.2f}"
        )


def main(*arguments: str) -> None:
    """Run and print."""
    numbers = [int(one) for one in arguments if one.isdigit()]
    first = numbers[0] if numbers else 70
    last = numbers[1] if len(numbers) > 1 else first + 9
    trials = []
    for case in cases(range(first, last + 1)):
        started = time.process_time()
        one = attempt(case)
        spent = time.process_time() - started
        if one is None:
            print(f"{case.id}: not open, CPU {spent:.0f} s", flush=True)
            continue
        trials.append(one)
        plan = one.experiment
        flown = ", ".join(
            f"{card.repeats} {card.surfaces[0]} {card.kind} "
            f"{next(iter(card.amplitudes.values())) / DEGREE:.1f} deg {card.speed / FOOT:.0f} ft/s"
            f"{f' flap {card.flap / DEGREE:.0f}' if card.flap else ''}"
            f"{f' throttle {card.throttle_step:+.1f}' if card.throttle_step else ''}"
            for card in plan.cards
        )
        print(
            f"{case.id}: among {', '.join(plan.effects)}\n    fly {flown}; predicted "
            f"{plan.separation_now:.1f} -> {plan.separation:.1f}, reached {one.reached:.1f}; "
            f"{one.verdict}, named {', '.join(one.named) or 'nothing'}, CPU {spent:.0f} s",
            flush=True,
        )
    report(trials)


if __name__ == "__main__":
    main(*sys.argv[1:])

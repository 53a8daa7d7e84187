"""Models on the way to an answer, and names that are taken back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gsapp.discrepancy.filtering.fitting import Fit
from gsapp.discrepancy.naming import Decision
from gsapp.discrepancy.screening import Screening

_MUCH = 0.15
"""Share of its own gain that a name may leave to structure without one."""
_ALIKE = 0.95
"""Cosine from which two effects explain the same, so that either can stand for both."""
_CROWD = 3
"""So many names for one coefficient are none."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Stage:
    """One model on the way, with the competition that it faced.

    Attributes
    ----------
    fit : Fit
    added : str
        The effect that it has and the stage before has not; empty for the baseline.
    screening : Screening
    decision : Decision
    forced : bool
        Whether the effect was put in by hand.
    proven : bool
        Whether kinematics alone prove it.
    among : tuple of str
        The set that the effect stands for, itself with it, where these flights cannot tell which.
    """

    fit: Fit
    added: str
    screening: Screening
    decision: Decision
    forced: bool = False
    proven: bool = False
    among: tuple[str, ...] = ()

    def left_unexplained(self) -> Stage:
        """Return the stage with the answer that its best explanation is none."""
        return replace(self, decision=replace(self.decision, kind="unexplained"))


def standing_for_all(stage: Stage) -> tuple[str, ...]:
    """Return the set that the best of a stage's decision can stand for; empty where it cannot.

    What cannot be told apart because it looks the same leaves the same behind, and the search can
    go on; a set of different things leaves its rests to be misnamed.
    """
    decision = stage.decision
    if decision.kind != "ambiguous" or decision.best is None:
        return ()
    cosines = np.abs(stage.screening.cosines(decision.best.id))
    ids = tuple(one.id for one in decision.alternatives)
    alike = all(cosines[stage.screening.place(one)] >= _ALIKE for one in ids)
    return ids if alike else ()


def without_misnomers(stages: Sequence[Stage], forced: int) -> list[Stage]:
    """Take back names that leave much of their own structure unexplained.

    Parameters
    ----------
    stages : sequence of Stage
        The baseline first.
    forced : int
        So many after it were put in by hand, and stay.
    """
    kept = list(stages)
    crowded = _crowded(kept)
    if crowded:
        return [*kept[: crowded - 1], kept[crowded - 1].left_unexplained()]
    while len(kept) > 1 + forced:
        before, last = kept[-2], kept[-1]
        if last.proven or last.decision.kind != "unexplained" or last.decision.best is None:
            break
        left = float(last.decision.gain.max())
        explained = float(before.decision.gain.max())
        if left < _MUCH * explained or not _same_place(last.added, last.decision.best.id):
            break
        kept = [*kept[:-2], before.left_unexplained()]
    return kept


def _crowded(stages: Sequence[Stage]) -> int:
    """Return the first of many names for one coefficient; 0 if no coefficient has many.

    What takes so many terms of the catalog is something that is not in it.
    """
    places: dict[str, list[int]] = {}
    for number, one in enumerate(stages):
        if number and not one.forced and one.added.split(".")[0] != "sensor":
            places.setdefault(one.added.split(".")[1], []).append(number)
    return min((found[0] for found in places.values() if len(found) >= _CROWD), default=0)


def _same_place(effect: str, other: str) -> bool:
    """Return whether structure without a name may be what an effect stood for."""
    group, target = effect.split(".")[:2]
    return group != "aero" or target == other.split(".")[1]

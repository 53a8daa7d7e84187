"""What a search sets aside: effects that are no part of the model, and how they still count."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

from gsapp.discrepancy.candidates import CandidateEffect, coefficient_of
from gsapp.discrepancy.effect_selection import EffectDecision
from gsapp.discrepancy.search_stages import SearchStage
from gsapp.discrepancy.settings import SEARCH
from gsapp.dynamics.effects.unnamed_terms import is_unnamed


@dataclass(slots=True)
class RejectedEffects:
    """Effects that compete no longer."""

    failed: set[str] = field(default_factory=set)
    """Ids of those that are wrong: the others compete as if there were none of them."""
    closed: set[str] = field(default_factory=set)
    """Coefficients of which something has no shape that holds on other maneuvers. Names take what
    that cannot explain whatever its shape."""
    rests: dict[str, CandidateEffect] = field(default_factory=dict)
    """Too small to be added: the others compete for what these cannot explain."""
    refuted: dict[str, EffectDecision] = field(default_factory=dict)
    """Contradicted by maneuvers kept out, with the decision for them: the others compete for what
    these cannot explain."""

    @property
    def is_full(self) -> bool:
        """Return whether so much is set aside that a search among the rest would be blind."""
        return len(self.rests) + len(self.refuted) >= SEARCH.max_rests

    def is_projected(self, one: CandidateEffect) -> bool:
        """Return whether the others compete for what a candidate cannot explain."""
        group, target, *_ = one.id.split(".")
        is_closed = group in ("aero", "unnamed") and coefficient_of(target) in self.closed
        return is_closed or one.id in self.rests or one.id in self.refuted

    def close_crowded(self, found: Sequence[str]) -> None:
        """Close the coefficients that have taken many terms without a name."""
        counts = Counter(one.split(".")[1] for one in found if is_unnamed(one))
        self.closed |= {
            target for target, count in counts.items() if count >= SEARCH.max_unnamed_terms
        }

    def explain(self, last: SearchStage) -> SearchStage:
        """Return the last stage with what was set aside, where nothing else is missing."""
        if last.decision.kind != "nothing":
            return last
        if self.refuted:
            strongest = max(self.refuted.values(), key=lambda one: float(one.gain.max()))
            decision = replace(
                last.decision,
                kind=strongest.kind,
                best=strongest.best,
                alternatives=strongest.alternatives,
                contradicted=True,
            )
            return replace(last, decision=decision)
        lacking = [
            one for name, one in self.rests.items() if not one.named and not is_unnamed(name)
        ]
        if not lacking:
            return last
        decision = replace(
            last.decision, kind="unexplained", best=lacking[0], alternatives=(lacking[0],)
        )
        return replace(last, decision=decision)


def is_rest(one: CandidateEffect, stages: Sequence[SearchStage]) -> bool:
    """Return whether what would be added next is no part of the model.

    No term makes an instrument ring, and what is small beside the effects found is how these
    differ from their form in the catalog.
    """
    if not one.named and not is_unnamed(one.id):
        return True
    explained = [float(earlier.decision.gain.max()) for earlier, _ in pairwise(stages)]
    share = SEARCH.min_name_share if one.named else SEARCH.min_rest_share
    return stages[-1].gain_of(one.id) < share * max(explained, default=0.0)

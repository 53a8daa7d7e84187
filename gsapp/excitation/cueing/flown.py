"""Verdicts as maneuvers that belong to test cards."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from gsapp.excitation.doublets.verdict import Verdict
from gsapp.flight.cards import CardSet, CardsFlown, match_cards
from gsapp.flight.maneuvers import FoundManeuver


def as_maneuver(verdict: Verdict) -> FoundManeuver:
    """Return what was judged as a maneuver that cards can be matched with.

    Only a good one is fit: cards ask for repeats that are worth having.
    """
    main = next(iter(verdict.amplitudes), None)
    return FoundManeuver(
        id=verdict.id,
        t_start=verdict.t_start,
        t_end=verdict.t_end,
        inputs=verdict.surfaces,
        kind=verdict.kind,
        amplitude=None if main is None else verdict.amplitudes[main],
        grade="A" if verdict.result == "good" else "D",
        reasons=tuple(finding.words for finding in verdict.findings),
        V=verdict.V,
        alpha=verdict.alpha,
        t_input=verdict.t_input,
        t_input_end=verdict.t_input_end,
        amplitudes=verdict.amplitudes,
    )


def cards_flown(cards: CardSet, verdicts: Sequence[Verdict]) -> CardsFlown:
    """Return how the cards stand after these verdicts."""
    return match_cards(cards, [as_maneuver(verdict) for verdict in verdicts])


def with_card(verdict: Verdict, flown: CardsFlown) -> Verdict:
    """Return a verdict with the card that it was flown for, and whether it counts."""
    for progress in flown.cards:
        for attempt in progress.attempts:
            if attempt.maneuver.id == verdict.id:
                return replace(verdict, card=progress.card.id, counts=attempt.counts)
    return replace(verdict, card="", counts=False)

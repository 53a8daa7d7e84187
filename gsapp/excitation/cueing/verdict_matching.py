"""Verdicts as maneuvers that belong to test cards."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from gsapp.excitation.doublets.verdict import InputVerdict
from gsapp.flight.cards import CardSet, CardSetProgress, match_cards
from gsapp.flight.maneuvers import DetectedManeuver


def maneuver_from_verdict(verdict: InputVerdict) -> DetectedManeuver:
    """Return what was judged as a maneuver that cards can be matched with.

    Only a good one is fit: cards ask for repeats that are worth having.
    """
    main = next(iter(verdict.amplitudes), None)
    return DetectedManeuver(
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


def evaluate_cards(cards: CardSet, verdicts: Sequence[InputVerdict]) -> CardSetProgress:
    """Return how the cards stand after these verdicts."""
    return match_cards(cards, [maneuver_from_verdict(verdict) for verdict in verdicts])


def assign_card(verdict: InputVerdict, flown: CardSetProgress) -> InputVerdict:
    """Return a verdict with the card that it was flown for, and whether it counts."""
    for progress in flown.cards:
        for attempt in progress.attempts:
            if attempt.maneuver.id == verdict.id:
                return replace(verdict, card=progress.card.id, counts=attempt.is_counted)
    return replace(verdict, card="", counts=False)

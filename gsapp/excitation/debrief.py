"""The debrief of a flight: every input with its verdict, and how the test cards were flown."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from gsapp.excitation.announcer import Announcement
from gsapp.excitation.cues import CueEvent
from gsapp.excitation.debrief_maneuver import EvaluatedManeuver
from gsapp.flight.cards import CardSetProgress
from gsapp.flight.catalog import CardScore, StoredVerdict

if TYPE_CHECKING:
    from gsapp.excitation.cueing import CueGenerator


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Debrief:
    """What there is to say of a flight afterwards."""

    flight: str
    maneuvers: tuple[EvaluatedManeuver, ...]
    """Every input, by time."""
    cards: tuple[CardScore, ...] = ()
    """In the order of the cards; empty without cards."""
    events: tuple[CueEvent, ...] = ()
    """All that changed for the crew."""
    announcements: tuple[Announcement, ...] = ()
    """All that was to be heard."""
    limitations: tuple[str, ...] = ()
    """What could not be judged, in words."""

    @property
    def good(self) -> int:
        """Return how many inputs were good."""
        return sum(one.verdict.result == "good" for one in self.maneuvers)

    @property
    def results(self) -> dict[str, int]:
        """Return how many inputs came to each verdict, the most frequent first."""
        return dict(Counter(one.verdict.result for one in self.maneuvers).most_common())

    @property
    def score(self) -> float | None:
        """Return the share of the repeats asked for that were flown well, 0 to 1.

        None without cards.
        """
        wanted = sum(one.requested for one in self.cards)
        return sum(min(one.good, one.requested) for one in self.cards) / wanted if wanted else None

    def to_stored_verdicts(self) -> tuple[StoredVerdict, ...]:
        """Return the verdicts for a catalog."""
        return tuple(
            StoredVerdict(
                name=one.verdict.id,
                t_input=one.verdict.t_input,
                t_end=one.verdict.t_end,
                surfaces=one.verdict.surfaces,
                kind=one.verdict.kind,
                V=one.verdict.V,
                result=one.verdict.result,
                advice=one.verdict.advice,
                card=one.verdict.card,
                is_counted=one.verdict.counts,
                record=one.to_record(),
            )
            for one in self.maneuvers
        )

    def cues_json(self) -> list[dict[str, Any]]:
        """Return what changed and what was heard, by time, for programs."""
        cues = [event.to_json() for event in self.events]
        cues += [
            {
                "time": round(one.time, 6),
                "kind": "spoken",
                "state": one.priority,
                "words": one.text,
                "data": {"tone": one.tone} if one.tone else {},
            }
            for one in self.announcements
        ]
        return sorted(cues, key=lambda cue: cue["time"])

    def to_json(self) -> dict[str, Any]:
        """Return what a program reads: SI, absent = None."""
        return {
            "flight": self.flight,
            "score": self.score,
            "good": self.good,
            "results": self.results,
            "cards": [
                {name: getattr(card, name) for name in CardScore.__slots__} for card in self.cards
            ],
            "maneuvers": [one.to_json() for one in self.maneuvers],
            "missing": list(self.limitations),
        }


def create_debrief(name: str, cueing: CueGenerator) -> Debrief:
    """Return the debrief of a flight that was followed."""
    return Debrief(
        flight=name,
        maneuvers=tuple(cueing.maneuvers),
        cards=score_cards(cueing.card_progress),
        events=tuple(cueing.log),
        announcements=tuple(cueing.announcements),
        limitations=cueing.snapshot().limitations,
    )


def score_cards(flown: CardSetProgress | None) -> tuple[CardScore, ...]:
    """Return how the cards were flown; empty without cards."""
    return tuple(
        CardScore(
            card=one.card.id,
            title=one.card.display_title,
            good=one.good_count,
            flown=len(one.attempts),
            requested=one.card.repeats,
        )
        for one in (() if flown is None else flown.cards)
    )

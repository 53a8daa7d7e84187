"""Which of the maneuvers flown belong to which test card, and what is still open."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from gsapp.flight.cards.card import STEP_COUNTS, CardSet, TestCard
from gsapp.flight.maneuvers.detected_maneuver import DetectedManeuver
from gsapp.quantities import SURFACE_NAMES, from_si

CardState = Literal["open", "begun", "done"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Attempt:
    """A maneuver flown for a card."""

    maneuver: DetectedManeuver
    deviations: Mapping[str, float]
    """By how many tolerances ``speed``, ``alpha``, ``amplitude`` and ``width`` missed the card,
    signed (positive: too fast, too large, too long); what was not measured is left out."""
    reasons: tuple[str, ...] = ()
    """Why it does not count, in words; empty if it does."""

    @property
    def is_counted(self) -> bool:
        """Return whether it is one of the repeats that the card asks for."""
        return not self.reasons


@dataclass(frozen=True, slots=True, kw_only=True)
class CardProgress:
    """A card and what was flown for it."""

    card: TestCard
    attempts: tuple[Attempt, ...] = ()
    """In order of time, good and bad."""

    @property
    def good_count(self) -> int:
        """Return how many attempts count."""
        return sum(attempt.is_counted for attempt in self.attempts)

    @property
    def remaining_count(self) -> int:
        """Return how many good ones are still wanted."""
        return max(self.card.repeats - self.good_count, 0)

    @property
    def state(self) -> CardState:
        """Return ``done``, ``begun`` (some good ones) or ``open``."""
        if not self.remaining_count:
            return "done"
        return "begun" if self.good_count else "open"


@dataclass(frozen=True, slots=True, kw_only=True)
class CardSetProgress:
    """A whole set of cards and a flight's maneuvers."""

    cards: tuple[CardProgress, ...]
    """In the order of the set."""
    unplanned: tuple[DetectedManeuver, ...] = ()
    """Those that no card asks for."""

    @property
    def next_card(self) -> TestCard | None:
        """Return the first card with repeats missing; None once all are done."""
        return next((one.card for one in self.cards if one.remaining_count), None)

    @property
    def is_complete(self) -> bool:
        """Return whether every card has its repeats."""
        return self.next_card is None


def match_cards(cards: CardSet, maneuvers: Sequence[DetectedManeuver]) -> CardSetProgress:
    """Give each maneuver to the card that it comes nearest to.

    A maneuver belongs to a card of the same surfaces and the same shape. Among several it goes to
    one that it satisfies and that still misses repeats, else to the nearest. It counts if it lies
    within the card's tolerances and was not graded unfit (D).
    """
    attempts: dict[str, list[Attempt]] = {card.id: [] for card in cards.cards}
    good = dict.fromkeys(attempts, 0)
    unplanned: list[DetectedManeuver] = []
    for maneuver in maneuvers:
        fits = [
            (card, compare_with_card(card, maneuver))
            for card in cards.cards
            if _requests_maneuver(card, maneuver)
        ]
        if not fits:
            unplanned.append(maneuver)
            continue
        card, attempt = min(
            fits,
            key=lambda fit: (
                bool(fit[1].reasons),
                good[fit[0].id] >= fit[0].repeats,
                _distance(fit[1]),
            ),
        )
        attempts[card.id].append(attempt)
        good[card.id] += attempt.is_counted
    return CardSetProgress(
        cards=tuple(
            CardProgress(card=card, attempts=tuple(attempts[card.id])) for card in cards.cards
        ),
        unplanned=tuple(unplanned),
    )


def compare_with_card(card: TestCard, maneuver: DetectedManeuver) -> Attempt:
    """Return how well a maneuver meets a card, whatever its surfaces."""
    off = dict(_deviations(card, maneuver))
    reasons = [
        _deviation_text(name, share, card) for name, share in off.items() if abs(share) > 1.0
    ]
    if maneuver.grade == "D":
        reasons.append(f"graded unfit ({'; '.join(maneuver.reasons) or 'no reason given'})")
    return Attempt(maneuver=maneuver, deviations=off, reasons=tuple(reasons))


def _requests_maneuver(card: TestCard, maneuver: DetectedManeuver) -> bool:
    return set(card.surfaces) == set(maneuver.inputs) and card.kind == maneuver.kind


def _deviations(card: TestCard, maneuver: DetectedManeuver) -> Iterator[tuple[str, float]]:
    allowed = card.tolerance
    if maneuver.V is not None:
        yield "speed", (maneuver.V - card.speed) / allowed.speed
    if card.alpha is not None and maneuver.alpha is not None:
        yield "alpha", (maneuver.alpha - card.alpha) / allowed.alpha
    sizes = maneuver.amplitudes or _main_amplitude(card, maneuver)
    for name, wanted in card.amplitudes.items():
        if name in sizes:
            yield (
                f"amplitude of the {SURFACE_NAMES[name]}",
                (sizes[name] / wanted - 1.0) / (allowed.amplitude),
            )
    width = _width(card, maneuver)
    if width is not None:
        yield "width", (width / card.width - 1.0) / allowed.width


def _main_amplitude(card: TestCard, maneuver: DetectedManeuver) -> Mapping[str, float]:
    if maneuver.amplitude is None or len(card.surfaces) != 1:
        return {}
    return {card.surfaces[0]: maneuver.amplitude}


def _width(card: TestCard, maneuver: DetectedManeuver) -> float | None:
    """Return the length of one step, s; of staggered inputs it cannot be told from their span."""
    span = maneuver.t_input_end - maneuver.t_input
    if not math.isfinite(span) or card.kind not in STEP_COUNTS or len(card.surfaces) != 1:
        return None
    return span / STEP_COUNTS[card.kind]


def _distance(attempt: Attempt) -> float:
    return math.hypot(*attempt.deviations.values())


def _deviation_text(name: str, share: float, card: TestCard) -> str:
    """Return by how much a card was missed: ``7.0 ft/s too fast, 5.0 ft/s allowed``."""
    allowed = card.tolerance
    if name == "speed":
        room, unit, sides = from_si(allowed.speed, "ft/s", "speed"), "ft/s", ("slow", "fast")
    elif name == "alpha":
        room, unit, sides = from_si(allowed.alpha, "deg", "angle"), "deg", ("small", "large")
    elif name == "width":
        room, unit, sides = 100.0 * allowed.width, "%", ("short", "long")
    else:
        room, unit, sides = 100.0 * allowed.amplitude, "%", ("small", "large")
    digits = 0 if unit == "%" else 1
    missed = f"{abs(share) * room:.{digits}f} {unit} too {sides[share > 0.0]}"
    return f"{name} {missed}, {room:.{digits}f} {unit} allowed"

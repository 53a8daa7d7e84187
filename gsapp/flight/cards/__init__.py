"""Test cards: what a flight is to bring home, and what of it was flown."""

from gsapp.flight.cards.card import (
    SHIPPED_CARDS,
    CardSet,
    TestCard,
    Tolerance,
    load_cards,
    save_cards,
    shipped_cards,
)
from gsapp.flight.cards.card_matching import (
    Attempt,
    CardProgress,
    CardSetProgress,
    compare_with_card,
    match_cards,
)

__all__ = [
    "SHIPPED_CARDS",
    "Attempt",
    "CardProgress",
    "CardSet",
    "CardSetProgress",
    "TestCard",
    "Tolerance",
    "compare_with_card",
    "load_cards",
    "match_cards",
    "save_cards",
    "shipped_cards",
]

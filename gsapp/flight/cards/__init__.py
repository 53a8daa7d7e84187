"""Test cards: what a flight is to bring home, and what of it was flown."""

from gsapp.flight.cards.card import (
    SHIPPED,
    CardSet,
    TestCard,
    Tolerance,
    load_cards,
    save_cards,
    shipped_cards,
)
from gsapp.flight.cards.matching import (
    Attempt,
    CardProgress,
    CardsFlown,
    compare,
    match_cards,
)

__all__ = [
    "SHIPPED",
    "Attempt",
    "CardProgress",
    "CardSet",
    "CardsFlown",
    "TestCard",
    "Tolerance",
    "compare",
    "load_cards",
    "match_cards",
    "save_cards",
    "shipped_cards",
]

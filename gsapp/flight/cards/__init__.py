"""Test cards: what a flight is to bring home, and what of it was flown."""

from gsapp.flight.cards.card import (
    SHIPPED_CARDS,
    CardProgress,
    CardSet,
    CardSetProgress,
    TestCard,
    Tolerance,
    compare_with_card,
    load_cards,
    match_cards,
    save_cards,
    shipped_cards,
)

__all__ = [
    "SHIPPED_CARDS",
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

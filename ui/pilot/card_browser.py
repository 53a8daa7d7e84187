"""Going through the test cards by keys, and taking one. No Qt."""

from __future__ import annotations

from gsapp.excitation.cues import CueSnapshot
from gsapp.flight.cards import CardSet, TestCard


class CardBrowser:
    """The card that the crew is looking at, which need not be the one to be flown."""

    def __init__(self) -> None:
        self._id = ""

    def reset(self) -> None:
        self._id = ""

    def browsed_card(self, cards: CardSet | None) -> TestCard | None:
        """Return the card that is looked at; None for that which is to be flown."""
        return None if cards is None or not self._id else cards.card(self._id)

    def step(self, cards: CardSet | None, cues: CueSnapshot | None, steps: int) -> None:
        """Look at a card farther on, around the end; from that which is to be flown first."""
        if cards is None:
            return
        ids = [card.id for card in cards.cards]
        flown = cues.card.card.id if cues is not None and cues.card is not None else ""
        here = self._id or flown
        place = ids.index(here) + steps if here in ids else min(steps - 1, 0)
        self._id = ids[place % len(ids)]
        if self._id == flown:
            self._id = ""

    def selected_card_id(self, cues: CueSnapshot | None) -> str:
        """Return the id of the card to be flown from now on; empty if there is none."""
        if self._id:
            return self._id
        return cues.card.card.id if cues is not None and cues.card is not None else ""


def find_last_flown_card(cues: CueSnapshot | None, cards: CardSet | None) -> str:
    """Return the id of the card that the latest maneuver was flown for; empty for none."""
    flown = cues.verdict.card if cues is not None and cues.verdict is not None else ""
    return flown if cards is not None and cards.card(flown) is not None else ""

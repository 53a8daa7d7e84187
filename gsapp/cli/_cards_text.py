"""Test cards of a flight in words: what is done, what is open, and why attempts do not count."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from gsapp.cli._console import print_sentence
from gsapp.cli._tables import print_unwrapped

if TYPE_CHECKING:
    from rich.console import Console

    from gsapp.flight.maneuvers import DetectedManeuver

_COLORS = {"done": "green", "begun": "yellow", "open": "red"}


def print_card_status(
    console: Console, flight: Path, maneuvers: Sequence[DetectedManeuver]
) -> None:
    """Print how the test cards kept with a flight stand; nothing where it has none.

    Raises
    ------
    FileProblemsError
        If the cards hold mistakes.
    """
    from rich import box
    from rich.table import Table
    from rich.text import Text

    from gsapp.flight.cards import match_cards
    from gsapp.flight.folder import FlightFolder

    cards = FlightFolder(path=flight).cards() if flight.is_dir() else None
    if cards is None:
        return
    flown = match_cards(cards, maneuvers)
    title = f"test cards {cards.name}".rstrip()
    table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
    for heading in ("card", "what", "flown", "state"):
        table.add_column(heading)
    for one in flown.cards:
        table.add_row(
            one.card.id,
            one.card.display_title,
            f"{one.good_count} of {one.card.repeats}",
            Text(one.state, _COLORS[one.state]),
        )
    print_unwrapped(console, table)
    told = [
        f"{one.card.id}: maneuver {attempt.maneuver.id} not counted: {'; '.join(attempt.reasons)}"
        for one in flown.cards
        for attempt in one.attempts
        if not attempt.is_counted
    ]
    if flown.unplanned:
        told.append(f"not on a card: {', '.join(one.id for one in flown.unplanned)}")
    for sentence in told:
        print_sentence(console, sentence)

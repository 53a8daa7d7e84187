"""What is suspicious about an aircraft, on the screen."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from gsapp.cli._console import print_sentence

if TYPE_CHECKING:
    from rich.console import Console

    from gsapp.aircraft import Aircraft


def print_aircraft_warnings(console: Console, aircraft: Iterable[Aircraft | None]) -> None:
    """Print a line for each possible but suspicious value of the user's own aircraft files.

    Parameters
    ----------
    console : Console
    aircraft : iterable of Aircraft or None
        As their files say; one that comes twice is warned about once.
    """
    from gsapp.aircraft import file_warnings

    sentences = [
        f"{one.name}: {sentence}"
        for one in aircraft
        if one is not None
        for sentence in file_warnings(one)
    ]
    for sentence in dict.fromkeys(sentences):
        print_sentence(console, sentence, "yellow")

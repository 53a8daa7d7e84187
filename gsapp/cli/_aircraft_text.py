"""What is suspicious about an aircraft, on the screen."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

    from gsapp.aircraft import Aircraft


def warn_of_aircraft(
    console: Console, aircraft: Iterable[Aircraft | None], *, rests_on_it: bool
) -> None:
    """Print a line for each value of an aircraft file that is possible but suspicious.

    A file of the user's own is always told of. The inertias of the shipped example are those of
    its source, and doubtful: that is told where results rest on them, and not with every command.

    Parameters
    ----------
    console : Console
    aircraft : iterable of Aircraft or None
        Those of the flights; one that comes twice is told of once.
    rests_on_it : bool
        Whether what the command gives rests on mass and inertia.
    """
    told: list[Aircraft] = []
    for one in aircraft:
        if one is None or one in told or (not rests_on_it and _is_shipped(one)):
            continue
        told.append(one)
        for sentence in one.warnings():
            console.print(
                f"{one.name}: {sentence}",
                style="yellow", highlight=False, soft_wrap=True,
            )  # fmt: skip


def _is_shipped(aircraft: Aircraft) -> bool:
    """Return whether the file, or the copy in a flight, is as it comes with the program."""
    from gsapp.aircraft import load_aircraft, shipped_aircraft

    return any(aircraft == load_aircraft(name) for name in shipped_aircraft())

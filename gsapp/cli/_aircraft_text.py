"""What is suspicious about an aircraft, on the screen."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

    from gsapp.aircraft import Aircraft


def warn_of_aircraft(console: Console, aircraft: Aircraft | None) -> None:
    """Print a line for each value of an aircraft file that is possible but suspicious."""
    for sentence in () if aircraft is None else aircraft.warnings():
        console.print(
            f"{aircraft.name if aircraft else ''}: {sentence}",
            style="yellow", highlight=False, markup=False, soft_wrap=True,
        )  # fmt: skip

"""What is wrong with the words of a call, whatever the files hold: exit code 2."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from gsapp.foundation import GroundStationError


class WrongCallError(GroundStationError, ValueError):
    """A command cannot be called with these words."""


@contextmanager
def wrong_call() -> Iterator[None]:
    """Let an error in reading what was typed be a wrong call."""
    try:
        yield
    except GroundStationError as error:
        raise WrongCallError(str(error)) from error


def check_pace(speed: float | None) -> None:
    """Raise `WrongCallError` where nothing can go at a speed, times real time."""
    if speed is not None and not speed > 0.0:
        raise WrongCallError(f"a speed of {speed:g} leads nowhere; choose one above 0")


def check_windows(texts: Sequence[str], flights: Sequence[Path]) -> None:
    """Raise `WrongCallError` where ``--maneuver`` says no stretch of one of the flights."""
    from gsapp.flight.maneuvers.given import parse_windows

    with wrong_call():
        parse_windows(texts, len(flights))

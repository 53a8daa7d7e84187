"""What is wrong with the words of a call, whatever the files hold: exit code 2."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from gsapp.foundation import GroundStationError


class CommandUsageError(GroundStationError, ValueError):
    """A command cannot be called with these words."""


@contextmanager
def as_usage_error() -> Iterator[None]:
    """Let an error in reading what was typed be a wrong call."""
    try:
        yield
    except GroundStationError as error:
        raise CommandUsageError(str(error)) from error


def check_speed(speed: float | None) -> None:
    """Raise `CommandUsageError` where nothing can go at a speed, times real time."""
    if speed is not None and not speed > 0.0:
        raise CommandUsageError(f"a speed of {speed:g} is not possible; use a speed above 0")


def check_windows(texts: Sequence[str], flights: Sequence[Path]) -> None:
    """Raise `CommandUsageError` where ``--maneuver`` says no stretch of one of the flights."""
    from gsapp.flight.maneuvers.flight_maneuvers import parse_maneuver_windows

    with as_usage_error():
        parse_maneuver_windows(texts, len(flights))

"""Settings of a search for a missing effect: options of ``gsapp discrepancy``, form, report."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from gsapp.flight.maneuver_settings import ManeuverSettings
from gsapp.foundation import GroundStationError
from gsapp.foundation.settings import Names, OptionalNames, setting


class SearchStoppedError(GroundStationError):
    """The user stopped the search; nothing was written."""


class DiscrepancySettings(ManeuverSettings):
    """What a user can choose of one search."""

    # fmt: off
    model: str = setting(
        "", "Current model",
        "Model to test: a file, or the name of a shipped one; default: fitted linear build-up. "
        "Its values are trusted.",
        option="--model", metavar="FILE")
    refused: Names = setting(
        (), "Refused", "Never name this effect.",
        option="--refuse", metavar="ID", is_repeatable=True)
    forced: Names = setting(
        (), "Forced", "Add this effect regardless of evidence. Several: in this order.",
        option="--force", metavar="ID", is_repeatable=True)
    held_out: OptionalNames = setting(
        None, "Held out",
        "Hold out this maneuver; default: one of each kind, about a quarter. It takes no part in "
        "naming and fitting.",
        option="--held-out", metavar="MANEUVER", is_repeatable=True)
    most_effects: int = setting(
        4, "Most effects", "Maximum number of effects.",
        option="--most-effects", metavar="N", ge=0)
    check_instruments: bool = setting(
        False, "Check instruments",
        "Compare instruments by kinematics, even where the model explains the flights: seconds, "
        "ten of them with colored noise.")
    false_alarm: float = setting(
        0.001, "Chance of a false name",
        "Chance of naming anything where nothing is missing, over all places and candidates.")
    # fmt: on


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchProgress:
    """How far a search has come: share done (0 to 1) and what it is doing."""

    share: float
    activity: str


SearchProgressCallback = Callable[[SearchProgress], bool | None]
"""Called often; returning False stops the search with `SearchStoppedError`."""

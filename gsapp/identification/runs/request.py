"""What an estimation is asked for: flights, maneuvers with their edges, and settings."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from pydantic import ConfigDict, Field

from gsapp.flight.maneuvers.detected_maneuver import DetectedManeuver
from gsapp.identification.campaign import CampaignSettings


@dataclass(frozen=True, slots=True, kw_only=True)
class SelectedManeuver:
    """A maneuver to estimate from, with its edges as they are now."""

    __pydantic_config__ = ConfigDict(extra="forbid")

    flight: Path  # One of the request's flights.
    id: str  # Within its flight.
    t_start: float
    t_end: float
    """First and last sample, s of flight time."""
    inputs: tuple[str, ...]  # Surfaces moved, of ``de``, ``da``, ``dr``.
    kind: str = ""  # ``doublet`` ...
    found: DetectedManeuver | None = field(default=None, compare=False, repr=False)
    """All that is known of it, where it is at hand: for the catalog, which wants its grade. It
    changes no number, and is not kept with a run."""


class RunRequest(CampaignSettings):
    """One estimation: the settings, flights and maneuvers.

    `maneuver_windows`, `every_grade` and `as_found` choose among the maneuvers that stand in the
    flights; where `maneuvers` are named, they only tell where those came from. So do `weights`
    and `model` where the content of these files is given.
    """

    flights: tuple[Path, ...] = Field(
        description="Flight folders or files, in the order in which they are numbered."
    )
    maneuvers: tuple[SelectedManeuver, ...] = Field(
        (), description="Those to be used, in order. Empty: all in the flights that are not unfit."
    )
    without: tuple[str, ...] = Field(
        (),
        description="Maneuvers excluded from the means, as the outcome calls them: M4, of several "
        "flights 2:M4. They are fitted all the same.",
    )

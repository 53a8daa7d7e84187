"""Flights on the command line made into maneuvers: what estimation commands begin with."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

    from gsapp.flight.maneuver_settings import ManeuverSettings
    from gsapp.identification.maneuver import FlightWithManeuvers


def load_flown_flights(
    paths: Sequence[Path], settings: ManeuverSettings, console: Console
) -> tuple[FlightWithManeuvers, ...]:
    """Open flights and cut their maneuvers, telling a console what is being done."""
    from gsapp.identification import maneuver

    with console.status("reading") as status:
        return maneuver.open_flights_with_maneuvers(paths, settings, doing=status.update)

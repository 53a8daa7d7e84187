"""Flights on the command line made into maneuvers: what estimation commands begin with."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

    from gsapp.identification.maneuver_extraction import FlightWithManeuvers


def load_flown_flights(
    paths: Sequence[Path],
    *,
    aircraft: str | None,
    channel_map: str | None = None,
    calibration: str | None = None,
    given: Sequence[str] = (),
    every_grade: bool = False,
    as_found: bool = False,
    console: Console,
) -> tuple[FlightWithManeuvers, ...]:
    """Open flights and cut their maneuvers, telling a console what is being done.

    See `gsapp.identification.maneuver_extraction.open_flights_with_maneuvers` for the rest.
    """
    from gsapp.identification import maneuver_extraction

    with console.status("reading") as status:
        return maneuver_extraction.open_flights_with_maneuvers(
            paths,
            aircraft=aircraft,
            channel_map=channel_map,
            calibration=calibration,
            given=given,
            every_grade=every_grade,
            as_found=as_found,
            doing=status.update,
        )

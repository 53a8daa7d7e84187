"""A flight as a file for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from gsapp.aircraft import Aircraft
from gsapp.flight.air_data_histories import add_air_data
from gsapp.flight.flight import Flight
from gsapp.flight.flown_aircraft import apply_flight_info
from gsapp.flight.read_settings import NameOrPath, find_aircraft
from gsapp.flight.sidpac import write_sidpac
from gsapp.flight.writers import WRITERS, ColumnUnits, check_format, write_block
from gsapp.foundation import FlightError

SIDPAC: Final = "sidpac"


def check_export(out: Path, to: str, units: str) -> None:
    """Raise `GroundStationError` where a file cannot have that format, name or units."""
    suffix = "mat" if to == SIDPAC else to
    if to != SIDPAC:
        check_format(to)
    ending = out.suffix.casefold().lstrip(".")
    if ending in WRITERS and ending != suffix:
        raise FlightError(
            f"{out.name} has the ending of another format than --to {to}; make them agree"
        )
    ColumnUnits.from_channels((), units)


def export_flight(
    flight: Flight,
    out: Path,
    to: str,
    units: str = "us",
    aircraft: Aircraft | NameOrPath | None = None,
) -> None:
    """Write a flight as ``csv``, ``mat``, ``parquet`` or ``sidpac``, atomically.

    Parameters
    ----------
    units : {"us", "si", "base"}
        Of the columns; those of SIDPAC are fixed.
    aircraft : Aircraft, str or Path, optional
        For SIDPAC, in place of the one in the flight folder.

    Raises
    ------
    FlightError
        If there are no samples, or SIDPAC cannot have them.
    """
    if not len(flight.block):
        raise FlightError(f"{flight.path} holds no samples, so that there is nothing to export")
    if to != SIDPAC:
        write_block(out, flight.block, to, units)
        return
    flown = find_aircraft(flight.path, aircraft)
    write_sidpac(
        out,
        add_air_data(flight.block, None if flight.info is None else flight.info.weather),
        None if flown is None else apply_flight_info(flown, flight.info).aircraft,
    )

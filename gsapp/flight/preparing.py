"""Preparing a flight folder: copies of all that is in force, before the first byte comes."""

from __future__ import annotations

from pathlib import Path

from calibration import certificate_files, load_certificates
from gsapp.aircraft import load_aircraft
from gsapp.aircraft.reading import SHIPPED as AIRCRAFT
from gsapp.decoding.channel_map import SHIPPED as CHANNEL_MAPS
from gsapp.decoding.channel_map import load_channel_map
from gsapp.flight.folder import FlightFolder
from gsapp.flight.info import FlightInfo


def prepare_flight(
    path: Path | str,
    *,
    name: str = "",
    aircraft: str | Path | None = None,
    channel_map: str | Path | None = None,
    calibration: str | Path | None = None,
    source: str = "",
    notes: str = "",
) -> FlightFolder:
    """Make a flight folder that holds what its record is to be read with.

    A folder that has some of it already keeps what the flight began with.

    Parameters
    ----------
    path : Path or str
        The folder; made if missing.
    name : str
        What the crew calls the flight; empty takes the folder's name.
    aircraft, channel_map : str, Path or None
        Names of shipped files, or paths; None keeps no copy.
    calibration : str, Path or None
        Name of a shipped set of certificates, or a folder of them; None takes the set that the
        channel map names, if any.
    source : str
        LINK that the flight comes over.
    notes : str
        For people.

    Raises
    ------
    GroundStationError
        If the folder cannot be made, or one of the files holds mistakes.
    """
    aircraft_file = None if aircraft is None else AIRCRAFT.find(aircraft)
    if aircraft_file is not None:
        load_aircraft(aircraft_file)
    map_file = None if channel_map is None else CHANNEL_MAPS.find(channel_map)
    if map_file is not None:
        named = load_channel_map(map_file).certificates
        calibration = named if calibration is None else calibration
    if calibration:
        load_certificates(calibration)
    folder = FlightFolder.create(
        path,
        FlightInfo(
            name=name,
            source=source,
            aircraft=aircraft_file.stem if aircraft_file else "",
            channel_map=map_file.stem if map_file else "",
            notes=notes,
        ),
    )
    if aircraft_file is not None and not folder.aircraft_file.exists():
        folder.keep_aircraft(aircraft_file)
    if map_file is not None and not folder.channel_map_file.exists():
        folder.keep_channel_map(map_file)
    if calibration and not folder.certificate_files():
        folder.keep_certificates(certificate_files(calibration))
    return folder

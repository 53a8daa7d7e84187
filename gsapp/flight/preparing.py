"""Preparing a flight folder: copies of all that is in force, before the first byte comes."""

from __future__ import annotations

from pathlib import Path

from calibration import load_certificates
from calibration.reading import FOLDER as CERTIFICATES
from gsapp.aircraft import load_aircraft
from gsapp.aircraft.reading import SHIPPED as AIRCRAFT
from gsapp.decoding.channel_map import SHIPPED as CHANNEL_MAPS
from gsapp.decoding.channel_map import load_channel_map
from gsapp.flight.folder import FlightFolder
from gsapp.flight.info import FlightInfo, current_versions


def prepare_flight(
    path: Path | str,
    *,
    aircraft: str | Path,
    channel_map: str | Path,
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
    aircraft, channel_map : str or Path
        Names of shipped files, or paths.
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
    aircraft_file, map_file = AIRCRAFT.find(aircraft), CHANNEL_MAPS.find(channel_map)
    load_aircraft(aircraft_file)
    chosen = load_channel_map(map_file)
    wanted = calibration if calibration is not None else chosen.certificates
    certificates = certificate_files(wanted) if wanted else ()
    target = Path(path)
    folder = FlightFolder.create(
        target,
        FlightInfo(
            name=target.resolve().name,
            source=source,
            aircraft=aircraft_file.stem,
            channel_map=map_file.stem,
            notes=notes,
            versions=current_versions(),
        ),
    )
    if not folder.aircraft_file.exists():
        folder.keep_aircraft(aircraft_file)
    if not folder.channel_map_file.exists():
        folder.keep_channel_map(map_file)
    if certificates and not folder.certificate_files():
        folder.keep_certificates(certificates)
    return folder


def certificate_files(calibration: str | Path) -> tuple[Path, ...]:
    """Return the certificates of a shipped set or of a folder, sorted; all are valid.

    Raises
    ------
    GroundStationError
        If there is no such set, or a certificate holds mistakes.
    """
    load_certificates(calibration)
    folder = Path(calibration)
    if not folder.is_dir():
        folder = CERTIFICATES / calibration
    return tuple(sorted(folder.glob("*.toml")))

"""What a flight is read with: channel map, certificates, aircraft, limits, rate of the grid."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from calibration import Certificate, load_certificates
from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.decoding.channel_map import ChannelMap, load_channel_map
from gsapp.flight.folder import FlightFolder
from gsapp.session.limits import LIMIT_TABLES, LimitRule, load_limits

LIMITS_NAME = "limits.toml"
DEFAULT_RATE = 100.0

Name = str | Path


@dataclass(frozen=True, slots=True, kw_only=True)
class Setting:
    """What shapes the numbers of a flight, beside the record itself.

    Attributes
    ----------
    channel_map : ChannelMap or None
        None leaves it to be guessed from the record.
    certificates : mapping of str to Certificate, or None
        By channel; None takes those that the map names.
    aircraft : Aircraft or None
        For limits and instrument ranges.
    rate : float
        Of the grid, Hz.
    limits : tuple of LimitRule
        The crew's own.
    """

    channel_map: ChannelMap | None = None
    certificates: Mapping[str, Certificate] | None = None
    aircraft: Aircraft | None = None
    rate: float = DEFAULT_RATE
    limits: tuple[LimitRule, ...] = ()

    def certificates_for(self, channel_map: ChannelMap) -> Mapping[str, Certificate]:
        """Return the certificates in force with a map."""
        if self.certificates is not None:
            return self.certificates
        return load_certificates(channel_map.certificates) if channel_map.certificates else {}


def setting_for(
    path: Path,
    *,
    channel_map: ChannelMap | Name | None = None,
    certificates: Name | None = None,
    aircraft: Aircraft | Name | None = None,
    rate: float | None = None,
    limits: Name | None = None,
) -> Setting:
    """Find what a flight is read with: what is given, else what lies in its folder.

    Parameters
    ----------
    path : Path
        Flight folder or file. The folder need not hold anything yet.
    channel_map, certificates, aircraft, limits : name, path or object
        In place of those in the folder.
    rate : float, optional
        In place of that of ``flight.toml``.

    Raises
    ------
    FileProblemsError
        If one of the files holds mistakes.
    UnknownNameError
        If something of a given name does not exist.
    """
    folder = FlightFolder(path=path)
    info = folder.info() if path.is_dir() else None
    if channel_map is None and folder.channel_map_file.is_file():
        channel_map = folder.channel_map_file
    if certificates is None and folder.certificate_files():
        certificates = folder.calibration_folder
    if aircraft is None and folder.aircraft_file.is_file():
        aircraft = folder.aircraft_file
    if isinstance(aircraft, (str, Path)):
        aircraft = load_aircraft(aircraft)
    if limits is None:
        limits = _limits_of(path, aircraft)
    return Setting(
        channel_map=load_channel_map(channel_map)
        if isinstance(channel_map, (str, Path))
        else channel_map,
        certificates=None if certificates is None else load_certificates(certificates),
        aircraft=aircraft,
        rate=rate or (info.grid_rate if info else None) or DEFAULT_RATE,
        limits=() if limits is None else load_limits(limits).rules(),
    )


def _limits_of(path: Path, aircraft: Aircraft | None) -> Name | None:
    """Return the folder's own limits, else those shipped for the aircraft."""
    own = path / LIMITS_NAME
    if own.is_file():
        return own
    if aircraft is not None and aircraft.name.casefold() in LIMIT_TABLES.names():
        return aircraft.name.casefold()
    return None

"""What a flight is watched with: what it is read with, and its limits."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from gsapp.aircraft import Aircraft
from gsapp.decoding.channel_map import ChannelMap
from gsapp.flight.names import LIMITS_FILE
from gsapp.flight.setting import Name, Setting
from gsapp.session.limits import LIMIT_TABLES, LimitRule, load_limits


@dataclass(frozen=True, slots=True, kw_only=True)
class SessionSetting(Setting):
    """What a flight is read with, and the limits in force.

    Attributes
    ----------
    limits : tuple of LimitRule
        The crew's own.
    """

    limits: tuple[LimitRule, ...] = ()


def setting_for(
    path: Path,
    *,
    channel_map: ChannelMap | Name | None = None,
    certificates: Name | None = None,
    aircraft: Aircraft | Name | None = None,
    rate: float | None = None,
    limits: Name | None = None,
) -> SessionSetting:
    """Find what a flight is watched with: what is given, else what lies in its folder.

    Parameters
    ----------
    path : Path
        Flight folder or file. The folder need not hold anything yet.
    channel_map, certificates, aircraft, rate
        See `gsapp.flight.setting.Setting.find`.
    limits : name or path, optional
        In place of those in the folder, or shipped for the aircraft.

    Raises
    ------
    FileProblemsError
        If one of the files holds mistakes.
    UnknownNameError
        If something of a given name does not exist.
    """
    read_with = Setting.find(
        path,
        channel_map=channel_map,
        certificates=certificates,
        aircraft=aircraft,
        rate=rate,
    )
    if limits is None:
        limits = _limits_of(path, read_with.aircraft)
    return SessionSetting(
        channel_map=read_with.channel_map,
        certificates=read_with.certificates,
        aircraft=read_with.aircraft,
        rate=read_with.rate,
        limits=() if limits is None else load_limits(limits).rules(),
    )


def _limits_of(path: Path, aircraft: Aircraft | None) -> Name | None:
    """Return the folder's own limits, else those shipped for the aircraft."""
    own = path / LIMITS_FILE
    if own.is_file():
        return own
    if aircraft is not None and aircraft.name.casefold() in LIMIT_TABLES.names():
        return aircraft.name.casefold()
    return None

"""What a flight is watched with: what it is read with, its limits, and who watches."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypedDict

from gsapp.aircraft import Aircraft
from gsapp.decoding.channel_map import ChannelMap
from gsapp.flight.names import LIMITS_FILE
from gsapp.flight.setting import Name, Setting
from gsapp.session.feeds import Consumer
from gsapp.session.limits import LIMIT_TABLES, LimitRule, load_limits


class Chosen(TypedDict, total=False):
    """What a flight is watched with in place of what lies in its folder; all may be left out.

    Attributes
    ----------
    channel_map, certificates, aircraft : name, path or object
        See `gsapp.flight.setting.Setting.find`.
    rate : float
        Of the grid, Hz; by default as the flight says.
    limits : name or path
        In place of those in the folder, or shipped for the aircraft.
    """

    channel_map: ChannelMap | Name | None
    certificates: Name | None
    aircraft: Aircraft | Name | None
    rate: float | None
    limits: Name | None


class Options(Chosen, total=False):
    """Everything that may be said of a session beside its flight; all may be left out.

    Attributes
    ----------
    consumers : sequence of Consumer
        Estimators and the like, fed with all samples in order, after the alarms.
    clock : callable
        Seconds of a clock that never goes back.
    wall_us : callable
        Microseconds since 1970.
    """

    consumers: Sequence[Consumer]
    clock: Callable[[], float]
    wall_us: Callable[[], int]


@dataclass(frozen=True, slots=True, kw_only=True)
class SessionSetting(Setting):
    """What a flight is read with, and the limits in force.

    Attributes
    ----------
    limits : tuple of LimitRule
        The crew's own.
    """

    limits: tuple[LimitRule, ...] = ()


def setting_for(path: Path, chosen: Chosen | None = None) -> SessionSetting:
    """Find what a flight is watched with: what is given, else what lies in its folder.

    Parameters
    ----------
    path : Path
        Flight folder or file. The folder need not hold anything yet.
    chosen : Chosen, optional
        What is given.

    Raises
    ------
    FileProblemsError
        If one of the files holds mistakes.
    UnknownNameError
        If something of a given name does not exist.
    """
    given = chosen or {}
    read_with = Setting.find(
        path,
        channel_map=given.get("channel_map"),
        certificates=given.get("certificates"),
        aircraft=given.get("aircraft"),
        rate=given.get("rate"),
    )
    limits = given.get("limits")
    if limits is None:
        limits = _limits_of(path, read_with.aircraft)
    return SessionSetting(
        channel_map=read_with.channel_map,
        certificates=read_with.certificates,
        given=read_with.given,
        own=read_with.own,
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

"""Opening the flight that a session watches, and what it is read and watched with."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, TypedDict, TypeVar

from gsapp.aircraft import Aircraft
from gsapp.decoding.channel_map import ChannelMap
from gsapp.flight.cards import CardSet, load_cards
from gsapp.flight.file_names import FENCE_FILE, LIMITS_FILE
from gsapp.flight.flight import Flight
from gsapp.flight.flight_loader import load_flight
from gsapp.flight.folder import FlightFolder
from gsapp.flight.raw_files import RawDamage
from gsapp.flight.read_settings import FlightReadSettings, NameOrPath
from gsapp.foundation import FileProblemsError
from gsapp.session.consumer_scheduler import Consumer
from gsapp.session.file_worker import FileWorker
from gsapp.session.limits import LIMIT_TABLES, LimitRule, load_limits
from gsapp.session.readers import (
    FlightReader,
    RecordReader,
    create_folder_reader,
    create_tlog_reader,
)

if TYPE_CHECKING:
    from gsapp.dynamics.model import Model
    from gsapp.excitation.alerts.geofence import Geofence
    from gsapp.session.live_estimation.fit_workers import FitWorker

T = TypeVar("T")


class SettingOverrides(TypedDict, total=False):
    """What a flight is watched with in place of what lies in its folder; all may be left out."""

    channel_map: ChannelMap | NameOrPath | None
    certificates: NameOrPath | None
    aircraft: Aircraft | NameOrPath | None
    """See `gsapp.flight.read_settings.FlightReadSettings.find`."""
    rate: float | None
    """Of the grid, Hz; by default as the flight says."""
    limits: NameOrPath | None
    """In place of those in the folder, or shipped for the aircraft."""
    model: Model | NameOrPath | None
    """In place of the one shipped for the aircraft: what cues and bounds go by."""
    cards: CardSet | NameOrPath | None
    """Test cards in place of those in the folder."""


class SessionOptions(SettingOverrides, total=False):
    """Everything that may be said of a session beside its flight; all may be left out."""

    consumers: Sequence[Consumer]
    """Estimators and the like, fed with all samples in order, after the alarms."""
    clock: Callable[[], float]
    wall_us: Callable[[], int]
    cues: bool
    """Whether the crew is to be told what to fly and how it was; by default it is."""
    system: str
    workers: FitWorker
    """Where maneuvers are fitted as they end; without it no derivatives are estimated."""
    search_worker: FitWorker | None
    """Where a missing effect is searched for after each maneuver; without it none is."""
    in_background: bool
    """Whether files are read and written in a thread, so that `Session.update` waits for no disk.
    What is taken in follows a moment later."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SessionSetting(FlightReadSettings):
    """What a flight is read with, and the limits in force."""

    limits: tuple[LimitRule, ...] = ()
    model: Model | None = None
    """Of the aerodynamics, as far as it is known before the flight."""
    cards: CardSet | None = None
    fence: Geofence | None = None
    """Where the aircraft may fly; None for the usual space."""
    remarks: tuple[str, ...] = ()
    """What of the folder could not be used, in words: bad test cards must not keep a flight from
    being watched."""


def find_session_setting(path: Path, chosen: SettingOverrides | None = None) -> SessionSetting:
    """Find what a flight is watched with: what is given, else what lies in its folder.

    Parameters
    ----------
    path : Path
        Flight folder or file. The folder need not hold anything yet.

    Raises
    ------
    FileProblemsError
        If one of the files holds mistakes.
    UnknownNameError
        If something of a given name does not exist.
    """
    given = chosen or {}
    read_with = FlightReadSettings.load(
        path,
        channel_map=given.get("channel_map"),
        certificates=given.get("certificates"),
        aircraft=given.get("aircraft"),
        rate=given.get("rate"),
    )
    limits = given.get("limits")
    if limits is None:
        limits = _find_limits(path, read_with.aircraft)
    cards, remarks = _cards_for(path, given.get("cards"))
    fence, more = _find_fence(path)
    return SessionSetting(
        **{one.name: getattr(read_with, one.name) for one in fields(read_with)},
        limits=() if limits is None else load_limits(limits).rules(),
        model=_model_for(read_with.aircraft, given.get("model")),
        cards=cards,
        fence=fence,
        remarks=(*remarks, *more),
    )


def _model_for(aircraft: Aircraft | None, given: Model | NameOrPath | None) -> Model | None:
    """Return the model given, else the one shipped for an aircraft; None where there is none."""
    from gsapp.dynamics.model import load_model, shipped_models  # the window starts without it

    if given is not None:
        return load_model(given) if isinstance(given, (str, Path)) else given
    name = "" if aircraft is None else aircraft.name.casefold()
    return load_model(name) if name in shipped_models() else None


def _cards_for(
    path: Path, given: CardSet | NameOrPath | None
) -> tuple[CardSet | None, tuple[str, ...]]:
    """Return the cards given, else those of the folder, and why those cannot be used."""
    if given is not None:
        return (load_cards(given) if isinstance(given, (str, Path)) else given), ()
    if not path.is_dir():
        return None, ()
    try:
        return FlightFolder(path=path).cards(), ()
    except FileProblemsError as error:
        return None, (f"the test cards are not used: {error}",)


def _find_fence(path: Path) -> tuple[Geofence | None, tuple[str, ...]]:
    """Return the folder's own fence, and why it cannot be used."""
    own = path / FENCE_FILE
    if not own.is_file():
        return None, ()
    from gsapp.excitation.alerts.geofence import load_geofence  # the window starts without it

    try:
        return load_geofence(own), ()
    except FileProblemsError as error:
        return None, (f"using the default geofence, not the flight's: {error}",)


def _find_limits(path: Path, aircraft: Aircraft | None) -> NameOrPath | None:
    """Return the folder's own limits, else those shipped for the aircraft."""
    own = path / LIMITS_FILE
    if own.is_file():
        return own
    if aircraft is not None and aircraft.name.casefold() in LIMIT_TABLES.names():
        return aircraft.name.casefold()
    return None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SessionFlight:
    """A flight that was opened, and where its samples come from."""

    path: Path
    reader: RecordReader | FlightReader
    setting: SessionSetting
    rate: float
    loaded_flight: Flight | None = None
    find_damage: Callable[[], Sequence[RawDamage]] = tuple
    has_grown: Callable[[], bool] = lambda: True
    """Returns whether the record may hold something new."""
    worker: FileWorker | None = None
    """In whose thread its files are read and written; None where that is done at once."""

    def poll(self, read: Callable[[], T], every: float) -> Callable[[], T]:
        """Return what gives the newest of something on the disk, without waiting for it."""
        return read if self.worker is None else self.worker.poll_periodically(read, every)


def open_live_flight(folder: Path | str, options: SessionOptions) -> SessionFlight:
    """Open a flight that is being recorded; see `gsapp.session.Session.follow`."""
    path = FlightFolder.open(folder).path
    return _open_record(path, find_session_setting(path, options), _worker(options), grows=True)


def open_recorded_flight(path: Path, options: SessionOptions) -> SessionFlight:
    """Open a flight that was recorded; see `gsapp.session.Session.replay`."""
    folder = FlightFolder.open(path) if path.is_dir() else None
    setting = find_session_setting(path, options)
    if folder is not None and folder.nonempty_raw_files:
        return _open_record(path, setting, _worker(options), grows=False)
    if path.is_file() and path.suffix.casefold() == ".tlog":
        worker = _worker(options)
        reader, stepped_over = create_tlog_reader(path, setting, worker)
        return SessionFlight(
            worker=worker,
            path=path,
            reader=reader,
            setting=setting,
            rate=setting.grid_rate,
            find_damage=lambda: (stepped_over,) if stepped_over else (),
        )
    return _open_loaded_flight(path, setting, options)


def _worker(options: SessionOptions) -> FileWorker | None:
    return FileWorker() if options.get("in_background", False) else None


def _open_record(
    path: Path, setting: SessionSetting, worker: FileWorker | None, *, grows: bool
) -> SessionFlight:
    reader, tail, has_grown = create_folder_reader(path, setting, grows=grows, worker=worker)
    return SessionFlight(
        worker=worker,
        path=path,
        reader=reader,
        setting=setting,
        rate=setting.grid_rate,
        find_damage=lambda: tail.damage,
        has_grown=has_grown if grows else lambda: True,
    )


def _open_loaded_flight(
    path: Path, setting: SessionSetting, options: SessionOptions
) -> SessionFlight:
    whole = load_flight(
        path,
        channel_map=setting.channel_map,
        rate=options.get("rate"),
        certificates=options.get("certificates"),
        aircraft=setting.aircraft,
    )
    return SessionFlight(
        worker=_worker(options),
        path=path,
        reader=FlightReader(whole),
        setting=setting,
        rate=whole.rate if math.isfinite(whole.rate) else setting.grid_rate,
        loaded_flight=whole,
    )

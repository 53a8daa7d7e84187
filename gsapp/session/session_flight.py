"""Opening the flight that a session watches: growing, recorded, or read whole."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from gsapp.flight.flight import Flight
from gsapp.flight.flight_loader import load_flight
from gsapp.flight.folder import FlightFolder
from gsapp.flight.raw_files import RawDamage
from gsapp.session.file_worker import FileWorker
from gsapp.session.readers import (
    FlightReader,
    RecordReader,
    create_folder_reader,
    create_tlog_reader,
)
from gsapp.session.session_setting import SessionOptions, SessionSetting, find_session_setting

T = TypeVar("T")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SessionFlight:
    """A flight that was opened, and where its samples come from."""

    path: Path
    """Its folder or file."""
    reader: RecordReader | FlightReader
    setting: SessionSetting
    """What it is read and watched with."""
    rate: float
    """Of the grid, Hz."""
    loaded_flight: Flight | None = None
    """A flight that was read whole."""
    find_damage: Callable[[], Sequence[RawDamage]] = tuple
    """Returns what was lost of the record."""
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

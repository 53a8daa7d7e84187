"""Putting an on-board log into a flight folder, whole or not at all, and taking it out again.

A log is tried before it is kept: only one that moves as the live record does becomes the log in
force. What was in force before stays in the folder, so that everything can be undone; what changes
is one line of ``flight.toml``.
"""

from __future__ import annotations

import filecmp
import shutil
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from gsapp.flight.atomic_files import copy_atomically
from gsapp.flight.file_names import FLIGHT_FOLDER_FILES, FRAMES_FILE
from gsapp.flight.flight import Flight
from gsapp.flight.flight_loader import LOG_SUFFIXES, load_flight, load_with_log
from gsapp.flight.folder import FlightFolder
from gsapp.flight.raw_files import read_tlog
from gsapp.flight.settings import ALIGNMENT
from gsapp.foundation import FlightError
from gsapp.foundation.files import list_files, move_into_place
from gsapp.foundation.name_suggestions import did_you_mean

_INCOMING = "incoming"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class InstalledLog:
    """An on-board log that has been put in force."""

    flight: Flight
    """As it opens now."""
    previous_name: str
    """Name of the log that was in force before; empty for none."""
    remark: str = ""
    """What is odd about it, in words; empty where nothing is."""


def install_log(
    flight: Path | str, log: Path | str, *, begun: datetime | None = None
) -> InstalledLog:
    """Put an on-board log into a flight folder with a live record, and in force.

    `begun` is when the box began it, with its time zone; a ``.tlog`` says so itself. `FlightError`
    if it is not the log of this flight, cannot be read or cannot be kept: the folder then stands as
    it stood.
    """
    folder, source = FlightFolder.open(flight), Path(log)
    _check_log_file(source)
    if not folder.nonempty_raw_files:
        raise FlightError(
            f"{folder.path} contains no live record to compare with; import the log as a "
            f"flight: gsapp import {source} --out NEW"
        )
    if any(source.samefile(record) for record in folder.nonempty_raw_files):
        raise FlightError(f"{source} is the live record itself; name the on-board log")
    name = _unused_name(folder, source)
    kept = folder.path / name
    if kept.is_file():
        return _activate_checked_log(folder, kept, begun, source)
    incoming = folder.cache_folder / _INCOMING / name
    try:
        copy_atomically(source, incoming)
        return _activate_checked_log(folder, incoming, begun, source)
    finally:
        # With what one left that was killed.
        shutil.rmtree(incoming.parent, ignore_errors=True)


def activate_log(flight: Path | str, name: str) -> Flight:
    """Put a log that lies in the flight folder in force; without a name, none."""
    folder = FlightFolder.open(flight)
    if not name:
        if not folder.nonempty_raw_files:
            raise FlightError(f"{folder.path} contains only its on-board log; keep it")
        folder.update_info(onboard_log=None)
        return load_flight(folder.path)
    if name not in list_logs(folder):
        there = list_logs(folder)
        hint = did_you_mean(name, there, f"it has {', '.join(there) or 'none'}")
        raise FlightError(f"{folder.path} has no on-board log '{name}'; {hint}")
    return _activate_checked_log(folder, folder.path / name, None, Path(name)).flight


def list_logs(folder: FlightFolder) -> tuple[str, ...]:
    """Return the names of the logs in a flight folder, in force or not."""
    return tuple(
        sorted(
            path.name
            for path in list_files(folder.path)
            if path.suffix.casefold() in LOG_SUFFIXES
            and path.is_file()
            and path.name not in FLIGHT_FOLDER_FILES
            and not path.name.startswith(".")
        )
    )


def read_log_start(log: Path) -> datetime | None:
    """Return when a log was begun by its own stamps; None where it does not say."""
    if log.suffix.casefold() != ".tlog":
        return None
    first = next(iter(read_tlog(log)), None)
    return None if first is None else datetime.fromtimestamp(first.stamp_us * 1e-6, UTC)


def _activate_checked_log(
    folder: FlightFolder, log: Path, begun: datetime | None, given: Path
) -> InstalledLog:
    """Put a log in force if it is one of this flight; `given` is what the user calls it."""
    info = folder.info()
    former = info.onboard_log if info is not None else ""
    with_log = load_with_log(folder, log)
    state = with_log.onboard
    apart = _date_mismatch_text(folder, begun or read_log_start(log))
    if state is None or not state.in_place:
        why = state.why if state is not None else "nothing could be read from it"
        why = why.replace(str(log), str(given))  # the copy is gone when this is read
        beside = f" ({apart})" if apart else ""
        raise FlightError(f"{given} is not accepted as the on-board log: {why}{beside}")
    kept = folder.path / log.name
    if kept != log:
        try:
            move_into_place(log, kept)
        except OSError as error:
            raise FlightError(
                f"{kept} cannot be written ({error.strerror or error}); check the permissions"
            ) from error
    folder.update_info(onboard_log=kept.name)
    remark = f"its motion matches this flight, although {apart}" if apart else ""
    return InstalledLog(flight=load_flight(folder.path), previous_name=former, remark=remark)


def _check_log_file(source: Path) -> None:
    if source.is_dir():
        raise FlightError(f"{source} is a folder; name the log file")
    if not source.is_file():
        raise FlightError(f"there is no log {source}; check the path")
    if source.suffix.casefold() not in LOG_SUFFIXES:
        raise FlightError(
            f"{source.name} has an unknown file ending; on-board logs are {', '.join(LOG_SUFFIXES)}"
        )


def _unused_name(folder: FlightFolder, source: Path) -> str:
    """Return the name that a log gets: its own, or another where that is taken by other bytes."""
    stem = "onboard" if source.name == FRAMES_FILE else source.stem.lstrip(".") or "onboard"
    for number in range(1, 1000):
        name = f"{stem}{f'-{number}' if number > 1 else ''}{source.suffix}"
        taken = folder.path / name
        if not taken.exists() or (taken.is_file() and filecmp.cmp(taken, source, shallow=False)):
            return name
    raise FlightError(f"{folder.path} holds a thousand logs called {source.name}; tidy up")


def _date_mismatch_text(folder: FlightFolder, begun: datetime | None) -> str:
    """Return in words that a log was begun on another day; empty where it was not."""
    first = next(iter(read_tlog(folder.tlog_file)), None) if folder.tlog_file.is_file() else None
    if first is None or begun is None:
        return ""
    flown = datetime.fromtimestamp(first.stamp_us * 1e-6, UTC)
    if abs((begun - flown).total_seconds()) < ALIGNMENT.max_date_difference:
        return ""
    return f"it started on {begun:%Y-%m-%d}; the flight was on {flown:%Y-%m-%d}"

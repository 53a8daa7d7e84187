"""The flight folder: one flight, with everything needed to read it again years later.

::

    flight.toml            facts (`FlightInfo`)
    raw.tlog raw.txt residue.bin      what arrived, byte for byte
    aircraft.toml          the aircraft file in force
    channel_map.toml       the channel map in force
    calibration/*.toml     the certificates in force, named by their instruments
    limits.toml            the crew's own limits, if any
    cards.toml             the test cards of the flight, if any
    fence.toml             where the aircraft may fly, if not in the usual space
    events.jsonl           marks, notes, alarms
    <on-board log>         named in flight.toml
    recorder.*             state, lock and words of the recorder
    cache/                 engineering units; may be deleted at any time
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import tomlkit

from gsapp.aircraft import Aircraft, load_aircraft
from gsapp.flight.atomic_files import copy_atomically, write_flight_file
from gsapp.flight.events import EventLog
from gsapp.flight.file_names import (
    AIRCRAFT_FILE,
    CACHE_FOLDER,
    CALIBRATION_FOLDER,
    CARDS_FILE,
    CHANNEL_MAP_FILE,
    EVENTS_FILE,
    FLIGHT_FOLDER_FILES,
    FRAMES_FILE,
    INFO_FILE,
    LINES_FILE,
    LOCK_FILE,
    RESIDUE_FILE,
    SEND_FILE,
    STATUS_FILE,
)
from gsapp.flight.info import FlightInfo, current_versions, local_timestamp
from gsapp.foundation import FlightError, GroundStationError, read_toml, read_toml_table
from gsapp.foundation.errors import format_os_error
from gsapp.foundation.files import (
    is_system_file,
    list_files,
    list_names,
    make_group_folder,
    path_lexists,
)
from gsapp.foundation.toml import validate_content

if TYPE_CHECKING:
    # A recorder, which must start fast, needs neither cards nor the dynamics behind them.
    from gsapp.flight.cards.card import CardSet

_FLIGHT_FILES = (
    INFO_FILE,
    FRAMES_FILE,
    LINES_FILE,
    RESIDUE_FILE,
    EVENTS_FILE,
    # Of a recorder that has begun and received nothing yet.
    STATUS_FILE,
    LOCK_FILE,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightFolder:
    """A flight folder on disk. Nothing is held in memory but its path."""

    path: Path

    @staticmethod
    def create(path: Path | str, info: FlightInfo | None = None) -> FlightFolder:
        """Make a flight folder, or go on in one that is already there.

        A missing date becomes the present, missing versions the present ones. In a folder that has
        a ``flight.toml`` that file is left as it is. A folder of other things is refused.
        """
        folder = FlightFolder(path=Path(path))
        _check_not_file(folder.path)
        if folder.path.is_dir():
            if is_flight_folder(folder.path):
                _check_writable(folder.path)
                if not folder.info_file.exists():
                    folder._write_new_info(info)
                return folder
            if not all(map(is_system_file, _entries(folder.path))):
                raise FlightError(
                    f"{folder.path} is a folder that holds other files; name a new folder for "
                    "the flight"
                )
        try:
            make_group_folder(folder.path)
        except OSError as error:
            what = f"the flight folder {folder.path}"
            raise FlightError(
                format_os_error(what, error, "choose a folder with write permission", verb="made")
            ) from error
        _check_writable(folder.path)
        folder._write_new_info(info)
        return folder

    @staticmethod
    def open(path: Path | str) -> FlightFolder:
        """Open a flight folder.

        `FlightError` if there is none, and where a pipe or device in the place of a file would be
        waited for.
        """
        folder = Path(path)
        if not folder.exists():
            raise FlightError(f"there is no flight folder {folder}; check the path")
        _check_not_file(folder)
        if not is_flight_folder(folder):
            names = ", ".join((INFO_FILE, FRAMES_FILE, LINES_FILE))
            raise FlightError(
                f"{folder} is a folder, but not a flight: it has none of {names}; name the "
                "folder that 'gsapp record --out' or 'gsapp import --out' made"
            )
        _check_plain_files(folder)
        return FlightFolder(path=folder)

    @property
    def name(self) -> str:
        """Return what the crew calls the flight, else the name of the folder."""
        info = self.info()
        return (info.name if info else "") or self.path.resolve().name

    @property
    def info_file(self) -> Path:
        """Return the path of ``flight.toml``."""
        return self.path / INFO_FILE

    @property
    def tlog_file(self) -> Path:
        return self.path / FRAMES_FILE

    @property
    def raw_files(self) -> tuple[Path, ...]:
        names = (FRAMES_FILE, LINES_FILE, RESIDUE_FILE)
        return tuple(self.path / name for name in names if (self.path / name).is_file())

    @property
    def nonempty_raw_files(self) -> tuple[Path, ...]:
        return tuple(path for path in self.raw_files if path.stat().st_size)

    @property
    def aircraft_file(self) -> Path:
        return self.path / AIRCRAFT_FILE

    @property
    def channel_map_file(self) -> Path:
        return self.path / CHANNEL_MAP_FILE

    @property
    def calibration_folder(self) -> Path:
        return self.path / CALIBRATION_FOLDER

    @property
    def cards_file(self) -> Path:
        return self.path / CARDS_FILE

    @property
    def cache_folder(self) -> Path:
        return self.path / CACHE_FOLDER

    @property
    def events(self) -> EventLog:
        return EventLog(self.path / EVENTS_FILE)

    def info(self) -> FlightInfo | None:
        """Read ``flight.toml``; None if there is none."""
        if not self.path.is_dir() or INFO_FILE not in _entries(self.path):
            return None
        return read_toml(self.info_file, FlightInfo)

    def update_info(self, **changes: Any) -> FlightInfo:
        """Change some facts, and leave what people wrote, comments included, where it is.

        `changes` are fields of `FlightInfo`, as they stand in the file (``takeoff_weight="64.5
        lb"``); None takes one out. If the result would not be valid, the file stands unchanged.
        """
        text = ""
        if self.info_file.exists():
            read_toml_table(self.info_file)  # Its errors name the line.
            text = self.info_file.read_text(encoding="utf-8")
        document = tomlkit.parse(text)
        for key, value in changes.items():
            if value is None:
                document.pop(key, None)
            else:
                document[key] = value
        info = validate_content(self.info_file, document.unwrap(), FlightInfo)
        write_flight_file(self.info_file, tomlkit.dumps(document))
        return info

    def onboard_log(self) -> Path | None:
        """Return the path of the on-board log, which must be there; None if the flight has none."""
        info = self.info()
        if info is None or not info.onboard_log:
            return None
        path = self.path / info.onboard_log
        if not path.is_file():
            raise FlightError(
                f"{self.info_file} names the on-board log '{info.onboard_log}', but it is not "
                "in the folder; copy it there or remove onboard_log"
            )
        return path

    def store_aircraft(self, path: Path | str) -> Path:
        return self._keep(Path(path), self.aircraft_file)

    def store_channel_map(self, path: Path | str) -> Path:
        return self._keep(Path(path), self.channel_map_file)

    def store_certificates(self, paths: Iterable[Path | str]) -> tuple[Path, ...]:
        """Copy the certificates in force into the folder; those that were there go."""
        sources = [Path(path) for path in paths]
        contents = {source.name: self._content(source) for source in sources}
        if len(contents) != len(sources):
            raise FlightError("two calibration certificates have the same file name; rename one")
        kept = tuple(
            write_flight_file(self.calibration_folder / name, content)
            for name, content in contents.items()
        )
        for old in self.certificate_files():
            if old.name not in contents:
                with contextlib.suppress(OSError):
                    old.unlink()
        return kept

    def store_onboard_log(self, path: Path | str, name: str | None = None) -> Path:
        """Copy an on-board log into the folder and name it in ``flight.toml``."""
        source = Path(path)
        target = self.path / (name or source.name)
        if target.name in (*_FLIGHT_FILES, AIRCRAFT_FILE, CHANNEL_MAP_FILE):
            target = self.path / f"onboard-{target.name}"
        if not (target.exists() and target.samefile(source)):
            copy_atomically(source, target)
        self.update_info(onboard_log=target.name)
        return target

    def store_cards(self, cards: CardSet) -> Path:
        """Write the test cards of the flight into the folder; those that were there go."""
        from gsapp.flight.cards.card import save_cards

        return save_cards(self.cards_file, cards)

    def cards(self) -> CardSet | None:
        """Read the test cards of the flight; None if it has none."""
        from gsapp.flight.cards.card import load_cards

        return load_cards(self.cards_file) if path_lexists(self.cards_file) else None

    def certificate_files(self) -> tuple[Path, ...]:
        """Return the copies of the certificates, sorted."""
        return list_files(self.calibration_folder, "*.toml")

    def aircraft(self) -> Aircraft | None:
        """Read the copy of the aircraft file; None if there is none."""
        # A link to nothing is a copy that is lost, not one that never was.
        return load_aircraft(self.aircraft_file) if path_lexists(self.aircraft_file) else None

    def _keep(self, source: Path, target: Path) -> Path:
        return write_flight_file(target, self._content(source))

    @staticmethod
    def _content(source: Path) -> bytes:
        try:
            return source.read_bytes()
        except OSError as error:
            raise FlightError(
                f"{source} cannot be copied into the flight folder ({error.strerror}); check the "
                "path and the permissions"
            ) from error

    def _write_new_info(self, info: FlightInfo | None) -> None:
        given = info or FlightInfo()
        filled = given.model_copy(
            update={
                "name": given.name or self.path.resolve().name,
                "date": given.date or local_timestamp(),
                "versions": dict(given.versions) or current_versions(),
            }
        )
        write_flight_file(self.info_file, tomlkit.dumps(filled.content()))


def is_flight_folder(path: Path | str) -> bool:
    """Return whether a path is a folder, which may be read, that holds a flight."""
    folder = Path(path)
    if not folder.is_dir():
        return False
    return not set(_FLIGHT_FILES).isdisjoint(_entries(folder))


def _entries(folder: Path) -> list[str]:
    try:
        return list_names(folder)
    except GroundStationError as error:
        raise FlightError(str(error)) from error


def _check_plain_files(folder: Path) -> None:
    for name in sorted(FLIGHT_FOLDER_FILES - {SEND_FILE}):
        path = folder / name
        if path.exists() and not (path.is_file() or path.is_dir()):
            raise FlightError(f"{path} is a pipe or a device, not a file; remove it")


def _check_not_file(path: Path) -> None:
    if path.exists() and not path.is_dir():
        raise FlightError(f"{path} is a file; name a flight folder")


def _check_writable(path: Path) -> None:
    if not os.access(path, os.W_OK | os.X_OK):
        raise FlightError(
            f"the flight folder {path} may not be written; change its permissions or choose "
            "another place"
        )

"""Flights kept open from one run to the next."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from calibration import certificate_paths
from gsapp.aircraft.aircraft_loader import SHIPPED_AIRCRAFT as AIRCRAFT_FILES
from gsapp.decoding.channel_map import SHIPPED_CHANNEL_MAPS as MAPS
from gsapp.flight.events import events_path
from gsapp.flight.file_names import CACHE_FOLDER
from gsapp.flight.maneuvers import FlightManeuvers, collect_maneuvers
from gsapp.flight.provenance import NON_DATA_FILES, InputFile, hash_input_file
from gsapp.foundation import FlightError
from gsapp.foundation.files import is_system_file
from gsapp.identification.maneuver_extraction import OpenedFlight, open_flight

_MAX_FLIGHTS: Final = 40
"""Flights kept open. Ten minutes of one take some 12 MB."""

_IGNORED_NAMES: Final = NON_DATA_FILES | {CACHE_FOLDER}
"""Files and folders in a flight folder that say nothing of the record."""

FileStamps = tuple[tuple[str, int, int], ...]
"""Name, time of change (ns) and size of files."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightOpenRequest:
    """What a flight is opened with; names or paths, empty where the flight says it itself."""

    path: Path
    aircraft: str = ""
    channel_map: str = ""
    calibration: str = ""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CachedFlight:
    """An open flight."""

    opened: OpenedFlight
    file: InputFile  # With its sum when it was read.


@dataclass(slots=True, kw_only=True, eq=False)
class _CacheEntry:
    stamps: FileStamps
    flight: CachedFlight
    surveys: dict[tuple[tuple[str, ...], bool], tuple[FileStamps, FlightManeuvers]] = field(
        default_factory=dict
    )


class FlightCache:
    """Keeps opened flights as long as their files stay as they are.

    Not for several threads at once.
    """

    def __init__(self) -> None:
        self._entries: dict[FlightOpenRequest, _CacheEntry] = {}

    def open(
        self, opening: FlightOpenRequest, *, doing: Callable[[str], object] | None = None
    ) -> CachedFlight:
        """Return a flight, read only if it was not before or has changed since.

        `doing`: told what is being done, in words.

        Raises
        ------
        GroundStationError
            If it cannot be read.
        """
        return self._entry(opening, doing).flight

    def detected_maneuvers(
        self,
        opening: FlightOpenRequest,
        *,
        windows: tuple[str, ...] = (),
        as_found: bool = False,
        latest: bool = True,
        doing: Callable[[str], object] | None = None,
    ) -> FlightManeuvers:
        """Return the maneuvers of a flight.

        Parameters
        ----------
        windows : tuple of str
            ``START:STOP`` in place of what would be found.
        as_found : bool
            Whether to leave out what was changed by hand.
        latest : bool
            Whether changes by hand since the last call matter.

        Raises
        ------
        GroundStationError
            If it cannot be read, or a window cannot.
        """
        entry = self._entry(opening, doing)
        asked = (windows, as_found)
        known = entry.surveys.get(asked)
        stamps = _file_stamps((events_path(opening.path),))
        if known is not None and (known[0] == stamps or not latest):
            return known[1]
        if doing is not None:
            doing(f"looking for maneuvers in {opening.path.name}")
        opened = entry.flight.opened
        found = collect_maneuvers(opened.flight, opened.aircraft, given=windows, as_found=as_found)
        entry.surveys[asked] = (stamps, found)
        return found

    def _entry(
        self, opening: FlightOpenRequest, doing: Callable[[str], object] | None
    ) -> _CacheEntry:
        stamps = _file_stamps(_tracked_files(opening))
        known = self._entries.pop(opening, None)
        if known is None or known.stamps != stamps:
            if doing is not None:
                doing(f"reading {opening.path.name}")
            known = _open_entry(opening, stamps)
        # The last one used stands last.
        self._entries[opening] = known
        while len(self._entries) > _MAX_FLIGHTS:
            del self._entries[next(iter(self._entries))]
        return known


def _open_entry(opening: FlightOpenRequest, stamps: FileStamps) -> _CacheEntry:
    path = opening.path
    opened = open_flight(
        path,
        aircraft=opening.aircraft or None,
        channel_map=opening.channel_map or None,
        calibration=opening.calibration or None,
    )
    try:
        file = hash_input_file("flight", path)
    except OSError as error:
        raise FlightError(
            f"{path} cannot be read ({error.strerror or error}); check the path and permissions"
        ) from error
    return _CacheEntry(stamps=stamps, flight=CachedFlight(opened=opened, file=file))


def _tracked_files(opening: FlightOpenRequest) -> list[Path]:
    """Return the files that shape the numbers of a flight and may change under way."""
    found = _folder_files(opening.path)
    for name, shipped in ((opening.aircraft, AIRCRAFT_FILES), (opening.channel_map, MAPS)):
        if name and name not in shipped.names():
            found.append(Path(name))
    return found + list(certificate_paths(opening.calibration) if opening.calibration else ())


def _folder_files(path: Path) -> list[Path]:
    """Return a file, or those of a folder but for what can be made again and notes."""
    if not path.is_dir():
        return [path]
    return [
        inner
        for inner in sorted(path.rglob("*"))
        if inner.relative_to(path).parts[0] not in _IGNORED_NAMES
        and inner.is_file()
        and not is_system_file(inner)
    ]


def _file_stamps(files: list[Path] | tuple[Path, ...]) -> FileStamps:
    found = []
    for file in files:
        try:
            state = file.stat()
        except OSError:
            # Not there: told by whatever reads it.
            continue
        found.append((str(file), state.st_mtime_ns, state.st_size))
    return tuple(found)

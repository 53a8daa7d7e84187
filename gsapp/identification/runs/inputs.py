"""What a run is made from: flights kept open, files with their sums, maneuvers."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from calibration import certificate_paths
from gsapp.aircraft import file_warnings
from gsapp.aircraft.aircraft_loader import SHIPPED_AIRCRAFT as AIRCRAFT_FILES
from gsapp.decoding.channel_map import SHIPPED_CHANNEL_MAPS as MAPS
from gsapp.dynamics.model import SHIPPED_MODELS as MODELS
from gsapp.flight.catalog import FlightEntry
from gsapp.flight.events import events_path
from gsapp.flight.file_names import CACHE_FOLDER
from gsapp.flight.folder import FlightFolder
from gsapp.flight.info import current_versions
from gsapp.flight.maneuvers import (
    DetectedManeuver,
    FlightManeuvers,
    ManeuverAssessor,
    collect_maneuvers,
    parse_maneuver_windows,
    uncalibrated_text,
)
from gsapp.flight.provenance import NON_DATA_FILES, InputFile, hash_input_file
from gsapp.flight.read_settings import DEFAULT_AIRCRAFT
from gsapp.foundation import FlightError
from gsapp.foundation.files import is_system_file
from gsapp.identification.maneuver import (
    Maneuver,
    OpenedFlight,
    StatusCallback,
    cut_flight_maneuvers,
    open_flight,
)
from gsapp.identification.runs.request import RunRequest, SelectedManeuver
from gsapp.identification.weights import SHIPPED_WEIGHTS as WEIGHTS
from gsapp.identification.weights import Weights, load_weights
from gsapp.quantities import Block
from gsapp.quantities.stored_block import block_in_file

_MAX_FLIGHTS: Final = 40
"""Flights that a window keeps open. Ten minutes of one take some 12 MB."""

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
    """Keeps opened flights as long as their files stay as they are; several, with samples in files.

    Not for several threads at once.

    `max_flights`: kept open; those used last.
    """

    def __init__(self, max_flights: int = _MAX_FLIGHTS) -> None:
        self._max_flights = max_flights
        self._entries: dict[FlightOpenRequest, _CacheEntry] = {}

    def open(
        self, opening: FlightOpenRequest, *, doing: Callable[[str], object] | None = None
    ) -> CachedFlight:
        """Return a flight, read only if it was not before or has changed since.

        `doing`: told what is being done, in words.

        Raises `GroundStationError` if it cannot be read.
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
            known = _open_entry(opening, stamps, in_file=self._max_flights > 1)
        # The last one used stands last.
        self._entries[opening] = known
        while len(self._entries) > self._max_flights:
            del self._entries[next(iter(self._entries))]
        return known


def _open_entry(opening: FlightOpenRequest, stamps: FileStamps, *, in_file: bool) -> _CacheEntry:
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
    if in_file:
        flight = replace(opened.flight, block=block_in_file(opened.flight.block))
        opened = replace(opened, flight=flight)
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


def flight_open_requests(request: RunRequest) -> tuple[FlightOpenRequest, ...]:
    """Return what the flights of a run are opened with, in their order."""
    return tuple(
        FlightOpenRequest(
            path=path,
            aircraft=request.aircraft,
            channel_map=request.channel_map,
            calibration=request.calibration,
        )
        for path in request.flights
    )


def run_versions() -> dict[str, str]:
    """Return the versions of what the last bit of a number depends on."""
    return {**current_versions(), "machine": f"{platform.system()} {platform.machine()}"}


def with_absolute_paths(request: RunRequest) -> RunRequest:
    """Return a request that means the same wherever the program is started.

    Raises `FlightError` if it names no flight.
    """
    if not request.flights:
        raise FlightError("no flight to estimate from; name one")
    return request.with_changes(
        flights=tuple(path.absolute() for path in request.flights),
        maneuvers=tuple(replace(one, flight=one.flight.absolute()) for one in request.maneuvers),
        aircraft=_absolute_path(request.aircraft),
        channel_map=_absolute_path(request.channel_map),
        calibration=_absolute_path(request.calibration),
        weights=_absolute_path(request.weights),
        model=_absolute_path(request.model),
    )


def _absolute_path(name: str) -> str:
    """Return the whole path of what is a file or folder, else the name as it is."""
    return str(Path(name).absolute()) if name and Path(name).exists() else name


def weights_file(request: RunRequest) -> Weights | None:
    """Return the weights file of a run; None where its settings hold weights, or there is none."""
    if request.response_weights is not None or not request.weights:
        return None
    return load_weights(request.weights)


def input_files(request: RunRequest, flown: Sequence[FlightSelection]) -> tuple[InputFile, ...]:
    """Return the files of a run with their sums when they were read.

    Files of a model or of weights are among them only if the settings did not hold these already.

    `request`: as it was asked, with whole paths.
    `flown`: its flights.

    Raises `FlightError` if one cannot be read.
    """
    aircraft = request.aircraft
    if not aircraft and not all(_has_aircraft(path) for path in request.flights):
        aircraft = DEFAULT_AIRCRAFT
    named = (
        ("aircraft", aircraft, AIRCRAFT_FILES),
        ("model", request.model if request.known_model is None else "", MODELS),
        ("weights", request.weights if request.response_weights is None else "", WEIGHTS),
        ("channel map", request.channel_map, MAPS),
    )
    certificates = certificate_paths(request.calibration) if request.calibration else ()
    try:
        return (
            *(one.file for one in flown),
            *(
                hash_input_file(role, shipped.find(name), name=name)
                for role, name, shipped in named
                if name
            ),
            *(hash_input_file("certificate", path) for path in certificates),
        )
    except OSError as error:
        raise FlightError(f"a file of the run cannot be read ({error}); check it") from error


def _has_aircraft(path: Path) -> bool:
    return path.is_dir() and FlightFolder(path=path).aircraft_file.is_file()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FlightSelection:
    """The maneuvers of one flight of a run, and what the run says of the flight: no samples."""

    name: str
    file: InputFile  # With its sum when it was read.
    aircraft: str  # Name of the one that flew.
    cut: tuple[Maneuver, ...]  # To be used.
    detected: tuple[DetectedManeuver, ...]  # The same, as they stand in the flight.
    entry: FlightEntry
    """What a catalog is told of: all maneuvers of the flight, or those that were named."""
    remarks: tuple[str, ...]
    doubts: tuple[str, ...]  # What is suspicious about the aircraft file.
    uncalibrated: tuple[str, ...]  # Which inputs and answers were volts only, in words.
    calibration: Mapping[str, Any]  # `Flight.calibration_json`.
    digest: str  # Of the samples: the same for copies of one flight.
    no_maneuvers_text: str = ""  # Why none was cut; empty where one was.


def check_requested_maneuvers(request: RunRequest) -> None:
    """Raise `FlightError` if a window or a named maneuver belongs to no flight of the request."""
    if not request.maneuvers:
        parse_maneuver_windows(request.maneuver_windows, len(request.flights))
    strange = {one.flight for one in request.maneuvers} - set(request.flights)
    if strange:
        raise FlightError(
            f"the maneuvers of {', '.join(sorted(map(str, strange)))} cannot be used: it is not "
            "among the flights of this run; add it"
        )


def select_flight_maneuvers(
    request: RunRequest,
    number: int,
    flights: FlightCache | None = None,
    doing: StatusCallback | None = None,
) -> FlightSelection:
    """Return the maneuvers of one flight of a run.

    `request`: with whole paths.
    `number`: of the flight, from 1.

    Raises `GroundStationError` if the flight cannot be read, or a maneuver is not where it should
    be.
    """
    flight_cache = FlightCache(max_flights=1) if flights is None else flights
    opening = flight_open_requests(request)[number - 1]
    select = _requested_maneuvers if request.maneuvers else _all_flight_maneuvers
    return select(request, number, opening, flight_cache, doing)


def selected_maneuvers(
    request: RunRequest, flown: Sequence[FlightSelection]
) -> tuple[SelectedManeuver, ...]:
    """Return the maneuvers of a run by name, with their edges."""
    if request.maneuvers:
        return request.maneuvers
    return tuple(
        SelectedManeuver(
            flight=path,
            id=one.id,
            t_start=one.t_start,
            t_end=one.t_end,
            inputs=one.inputs,
            kind=one.kind,
            found=one,
        )
        for path, own in zip(request.flights, flown, strict=True)
        for one in own.detected
    )


def _all_flight_maneuvers(
    request: RunRequest,
    number: int,
    opening: FlightOpenRequest,
    flight_cache: FlightCache,
    doing: StatusCallback | None,
) -> FlightSelection:
    """Return all maneuvers that stand in a flight, or those of the windows given."""
    windows = tuple(
        f"{window.start!r}:{window.stop!r}"
        for window in parse_maneuver_windows(request.maneuver_windows, len(request.flights))
        if window.flight == number
    )
    surveyed = flight_cache.detected_maneuvers(
        opening, windows=windows, as_found=request.as_found, doing=doing
    )
    every = request.every_grade or bool(windows)
    prefix = _prefix(request, number)
    cached = flight_cache.open(opening)
    own = cut_flight_maneuvers(cached.opened, surveyed, prefix=prefix, every_grade=every)
    ids = {one.id.removeprefix(prefix) for one in own.maneuvers}
    return _selection(
        request,
        cached,
        own.maneuvers,
        detected=tuple(found for found in surveyed.maneuvers if found.id in ids),
        stored=surveyed.maneuvers,
        remarks=own.remarks,
        no_maneuvers_text=own.no_maneuvers_text,
    )


def _requested_maneuvers(
    request: RunRequest,
    number: int,
    opening: FlightOpenRequest,
    flight_cache: FlightCache,
    doing: StatusCallback | None,
) -> FlightSelection:
    """Return the maneuvers of a flight that were named, with exactly their edges."""
    cached = flight_cache.open(opening, doing=doing)
    opened = cached.opened
    named = [own for own in request.maneuvers if own.flight == request.flights[number - 1]]
    cut = tuple(
        opened.cut(_prefix(request, number) + own.id, own.t_start, own.t_end, own.inputs, own.kind)
        for own in named
    )
    found = tuple(
        own.found for own in named if own.found is not None and _is_same_maneuver(own.found, own)
    )
    if len(found) < len(named):
        surveyed = flight_cache.detected_maneuvers(opening, latest=False, doing=doing)
        found = tuple(_detected_maneuver(own, surveyed, opened) for own in named)
    return _selection(request, cached, cut, detected=found, stored=found, remarks=opened.remarks)


def _selection(
    request: RunRequest,
    cached: CachedFlight,
    cut: tuple[Maneuver, ...],
    *,
    detected: tuple[DetectedManeuver, ...],
    stored: tuple[DetectedManeuver, ...],
    remarks: tuple[str, ...],
    no_maneuvers_text: str = "",
) -> FlightSelection:
    opened = cached.opened
    flight, aircraft = opened.flight, opened.aircraft.name
    return FlightSelection(
        name=flight.name,
        file=cached.file,
        aircraft=aircraft,
        cut=cut,
        detected=detected,
        entry=FlightEntry.from_flight(
            flight,
            stored,
            aircraft=opened.aircraft,
            complete=not (request.maneuvers or request.maneuver_windows),
        ),
        remarks=tuple(f"{flight.name}: {remark}" for remark in remarks),
        doubts=tuple(
            f"{opened.file_aircraft.name}: {doubt}" for doubt in file_warnings(opened.file_aircraft)
        ),
        uncalibrated=tuple(f"{flight.name}: {text}" for text in uncalibrated_text(flight)),
        calibration=flight.calibration_json(),
        digest=_samples_digest(flight.block),
        no_maneuvers_text=no_maneuvers_text,
    )


def _samples_digest(block: Block) -> str:
    found = hashlib.blake2b(repr(block.channels).encode(), digest_size=16)
    for samples in (block.times, block.values):
        found.update(np.ascontiguousarray(samples).data)
    return found.hexdigest()


def _detected_maneuver(
    own: SelectedManeuver, surveyed: FlightManeuvers, opened: OpenedFlight
) -> DetectedManeuver:
    """Return all that is known of a maneuver that was named."""
    for one in (own.found, *surveyed.maneuvers):
        if one is not None and _is_same_maneuver(one, own):
            return one
    assessor = ManeuverAssessor(opened.flight, opened.aircraft, surveyed.noise)
    seen = assessor.assess(own.id, own.t_start, own.t_end)
    return replace(seen, inputs=own.inputs or seen.inputs, kind=own.kind or seen.kind)


def _is_same_maneuver(found: DetectedManeuver, own: SelectedManeuver) -> bool:
    return (found.id, found.t_start, found.t_end) == (own.id, own.t_start, own.t_end)


def in_requested_order(request: RunRequest, flown: Sequence[FlightSelection]) -> list[Maneuver]:
    """Return the maneuvers that were cut, in the order asked for."""
    cut = [one for own in flown for one in own.cut]
    if not request.maneuvers:
        return cut
    by_id = {one.id: one for one in cut}
    numbers = {path: number for number, path in enumerate(request.flights, start=1)}
    return [by_id[_prefix(request, numbers[one.flight]) + one.id] for one in request.maneuvers]


def _prefix(request: RunRequest, number: int) -> str:
    return f"{number}:" if len(request.flights) > 1 else ""

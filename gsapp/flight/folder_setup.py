"""Preparing a flight folder: copies of all that is in force, and what was entered beforehand."""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, Final

from calibration import certificate_paths, load_certificates
from gsapp.aircraft import load_aircraft
from gsapp.aircraft.aircraft_loader import SHIPPED_AIRCRAFT as AIRCRAFT
from gsapp.decoding.channel_map import SHIPPED_CHANNEL_MAPS as CHANNEL_MAPS
from gsapp.decoding.channel_map import load_channel_map
from gsapp.flight.atomic_files import copy_atomically
from gsapp.flight.events import read_events
from gsapp.flight.file_names import CARDS_FILE
from gsapp.flight.folder import FlightFolder
from gsapp.flight.info import FlightInfo
from gsapp.flight.toml_document import FlightInfoFile, KeyPath

log = logging.getLogger(__name__)


def prepare_flight_folder(
    path: Path | str,
    *,
    name: str = "",
    aircraft: str | Path | None = None,
    channel_map: str | Path | None = None,
    calibration: str | Path | None = None,
    source: str = "",
    notes: str = "",
    tell: Callable[[str], object] = log.warning,
) -> FlightFolder:
    """Make a flight folder that holds what its record is to be read with.

    A folder that has some of it already keeps what the flight began with; `tell` takes a sentence
    for each thing asked for that differs. Of an aircraft or map that is None no copy is kept;
    certificates (the name of a shipped set, or a folder) that are None are those that the map
    names, if any. Without a name the flight is called like its folder.
    """
    aircraft_file = None if aircraft is None else AIRCRAFT.find(aircraft)
    if aircraft_file is not None:
        load_aircraft(aircraft_file)
    map_file = None if channel_map is None else CHANNEL_MAPS.find(channel_map)
    asked = bool(calibration)
    if map_file is not None:
        named = load_channel_map(map_file).certificates
        calibration = named if calibration is None else calibration
    if calibration:
        load_certificates(calibration)
    folder = FlightFolder.create(
        path,
        FlightInfo(
            name=name,
            source=source,
            aircraft=aircraft_file.stem if aircraft_file else "",
            channel_map=map_file.stem if map_file else "",
            notes=notes,
        ),
    )
    if aircraft_file is not None and _needs_copy(
        folder, "aircraft", [folder.aircraft_file], [aircraft_file], aircraft_file.stem, tell
    ):
        folder.store_aircraft(aircraft_file)
    if map_file is not None and _needs_copy(
        folder, "channel map", [folder.channel_map_file], [map_file], map_file.stem, tell
    ):
        folder.store_channel_map(map_file)
    if calibration:
        files = certificate_paths(calibration)
        # The set that a map names was not asked for by anybody.
        listen = tell if asked else _ignore_message
        kept = folder.certificate_files()
        if _needs_copy(folder, "certificates", kept, files, str(calibration), listen):
            folder.store_certificates(files)
    return folder


def _needs_copy(
    folder: FlightFolder,
    what: str,
    kept: Iterable[Path],
    wanted: Iterable[Path],
    asked: str,
    tell: Callable[[str], object],
) -> bool:
    """Return whether the folder holds no copy yet; tell if the one it holds is another."""
    held = sorted(path.read_bytes() for path in kept if path.is_file())
    if held and held != sorted(path.read_bytes() for path in wanted):
        tell(_kept_copy_text(folder, what, asked))
    return not held


def _ignore_message(_sentence: str) -> None:
    """Tell nobody."""


def _kept_copy_text(folder: FlightFolder, what: str, asked: str) -> str:
    known = folder.info()
    began = {"aircraft": known.aircraft, "channel map": known.channel_map} if known else {}
    name = f" '{began[what]}'" if began.get(what) and began[what] != asked else ""
    return (
        f"{folder.path} keeps the {what}{name} of its start: '{asked}' differs and is ignored; "
        "record into a new folder to use it"
    )


# It lies in a folder of its own under the same names as in a flight folder, and goes into the
# flight's when recording starts.

CARRIED_OVER_KEYS: Final = ("airframe", "crew", "flap", "loading", "transmitter")
"""What the card of the flight after begins with."""


def apply_draft(
    waiting: Path, folder: FlightFolder, *, keep: bool = False, named: bool = True
) -> bool:
    """Put what waits for the next flight into its folder, and begin the one after.

    What the folder knows already stays; a flight that has a record began with its own card and gets
    nothing. With `keep` all of it waits for another flight as well: this one is only for trial. The
    flight takes the name that waits if it is `named`. If a card holds mistakes nothing is handed
    over. Returns whether anything was.
    """
    if not waiting.is_dir() or folder.nonempty_raw_files:
        return False
    prepared = FlightInfoFile(FlightFolder(path=waiting))
    card = FlightInfoFile(folder)
    named_by_itself = card.value(("name",)) in (None, folder.path.resolve().name)
    values: dict[KeyPath, Any] = {
        (key,): value
        for key, value in prepared.content.items()
        if (named and named_by_itself if key == "name" else key not in card.content)
    }
    card.change(values)
    card.save()
    ticks = read_events(FlightFolder(path=waiting).events.path).events
    for event in ticks:
        folder.events.append(event)
    plan = waiting / CARDS_FILE
    planned = plan.is_file() and not (folder.path / CARDS_FILE).exists()
    if planned:
        copy_atomically(plan, folder.path / CARDS_FILE)
    if not keep:
        reset_draft(waiting)
    return bool(values or ticks or planned)


def reset_draft(waiting: Path) -> None:
    """Leave of what waits only what stays from flight to flight: the rest was handed over."""
    prepared = FlightInfoFile(FlightFolder(path=waiting))
    prepared.restore(
        {key: value for key, value in prepared.content.items() if key in CARRIED_OVER_KEYS}
    )
    prepared.save()
    with contextlib.suppress(FileNotFoundError):
        prepared.folder.events.path.unlink()

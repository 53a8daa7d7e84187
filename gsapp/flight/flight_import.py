"""Making a flight folder from the log of another program."""

from __future__ import annotations

import re
import shutil
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from tempfile import TemporaryDirectory

from calibration import certificate_paths
from gsapp.decoding.channel_map import TABLE, ChannelMap, load_channel_map
from gsapp.flight.atomic_files import atomic_flight_folder, copy_atomically
from gsapp.flight.events import events_path
from gsapp.flight.flight import Flight
from gsapp.flight.flight_loader import default_channel_map, load_flight
from gsapp.flight.folder import FlightFolder
from gsapp.flight.info import FlightInfo
from gsapp.flight.raw_files import read_tlog
from gsapp.flight.readers.tables import MatPart, read_mat_parts
from gsapp.foundation import FlightError, GroundStationError
from gsapp.foundation.files import list_files


def import_flight(
    file: Path | str, out: Path | str, *, channel_map: str | Path | None = None
) -> Flight:
    """Make a flight folder of a file, with the file itself kept inside.

    A ``.tlog`` becomes the folder's ``raw.tlog``, byte for byte; any other file its on-board log,
    named in ``flight.toml``. The map (by default the shipped one that fits) and the certificates it
    names are copied, so that the flight can be read again, with these or with others. Marks, notes
    and maneuvers corrected by hand lay beside the file, and come along. The folder appears whole or
    not at all.
    """
    source, target = Path(file), Path(out)
    _check_places(source, target)
    chosen = _find_map(source, channel_map)
    # Read it first: what cannot be read is not imported.
    flight = load_flight(source, channel_map=chosen)
    info = FlightInfo(
        name=target.resolve().name,
        source=source.name,
        channel_map=chosen.name if chosen else "",
    )
    with atomic_flight_folder(target) as made:
        _write_folder(made, info, source, chosen)
    return replace(flight, name=info.name, path=target, info=FlightFolder.open(target).info())


def import_flights(
    file: Path | str, out: Path | str, *, channel_map: str | Path | None = None
) -> tuple[tuple[Flight, ...], tuple[str, ...]]:
    """Make flight folders in the folder `out` of a ``.mat`` file that holds several flights.

    Each has the structure or matrix that is the flight as its on-board log, all its variables
    included. Also returned is what was left out, in words; no flights where the file does not hold
    several.
    """
    source, target = Path(file), Path(out)
    _check_places(source, target)
    chosen = _find_map(source, channel_map)
    if source.suffix.casefold() != ".mat" or chosen is None or chosen.format != TABLE:
        return (), ()
    parts, remarks = read_mat_parts(source, chosen)
    if not parts:
        return (), ()
    skipped: dict[str, str] = {}
    names = {part.name: re.sub(r"\W+", "_", part.name).strip("_") for part in parts}
    with atomic_flight_folder(target) as made:
        for part in parts:
            try:
                _write_part(made / names[part.name], source, part, chosen)
            except GroundStationError as error:
                skipped[part.name] = f"'{part.name}' was skipped: {error}"
                shutil.rmtree(made / names[part.name])
        if len(skipped) == len(parts):
            raise FlightError(
                f"{source} holds no flight that can be read; {skipped[parts[0].name]}"
            )
    flights = tuple(load_flight(target / names[p.name]) for p in parts if p.name not in skipped)
    return flights, (*remarks, *skipped.values())


def _write_part(folder: Path, source: Path, part: MatPart, channel_map: ChannelMap) -> None:
    """Write the flight folder of one part, and read it."""
    from scipy.io import savemat  # a tenth of a second

    info = FlightInfo(
        name=folder.name, source=f"{source.name}: {part.name}", channel_map=channel_map.name
    )
    folder.mkdir()
    with TemporaryDirectory() as scratch:
        log = Path(scratch) / f"{folder.name}.mat"
        savemat(log, part.variables, long_field_names=True, do_compression=True)
        _write_folder(folder, info, log, channel_map)
    load_flight(folder)


def _check_places(source: Path, target: Path) -> None:
    if source.is_dir():
        raise FlightError(f"{source} is a folder; name the log file that is to be imported")
    if target.exists() and (not target.is_dir() or list_files(target)):
        raise FlightError(f"{target} is taken; name a new folder for the flight")


def _find_map(source: Path, channel_map: str | Path | None) -> ChannelMap | None:
    return default_channel_map(source) if channel_map is None else load_channel_map(channel_map)


def _write_folder(made: Path, info: FlightInfo, source: Path, chosen: ChannelMap | None) -> None:
    """Write all that belongs to the flight into its folder."""
    folder = FlightFolder.create(made, info)
    if chosen is not None:
        _store_channel_map(folder, chosen)
    if source.suffix.casefold() == ".tlog":
        copy_atomically(source, folder.tlog_file)
        folder.update_info(date=_start_date(source))
    else:
        folder.store_onboard_log(source)
        # When the log was made is not known; that of the import would mislead.
        folder.update_info(date=None)
    if events_path(source).is_file():
        copy_atomically(events_path(source), events_path(made))


def _store_channel_map(folder: FlightFolder, channel_map: ChannelMap) -> None:
    if channel_map.path is not None:
        folder.store_channel_map(channel_map.path)
    if channel_map.certificates is not None:
        folder.store_certificates(certificate_paths(channel_map.certificates))


def _start_date(tlog: Path) -> datetime | None:
    first = next(iter(read_tlog(tlog)), None)
    if first is None:
        return None
    return datetime.fromtimestamp(first.stamp_us // 1_000_000, UTC)

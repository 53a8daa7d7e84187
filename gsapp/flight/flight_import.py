"""Making a flight folder from the log of another program."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

from calibration import certificate_paths
from gsapp.decoding.channel_map import ChannelMap, load_channel_map
from gsapp.flight.atomic_files import atomic_flight_folder, copy_atomically
from gsapp.flight.events import events_path
from gsapp.flight.flight import Flight
from gsapp.flight.flight_loader import default_channel_map, load_flight
from gsapp.flight.folder import FlightFolder
from gsapp.flight.info import FlightInfo
from gsapp.flight.raw_files import read_tlog
from gsapp.foundation import FlightError
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
    if source.is_dir():
        raise FlightError(f"{source} is a folder; name the log file that is to be imported")
    if target.exists() and (not target.is_dir() or list_files(target)):
        raise FlightError(f"{target} is taken; name a new folder for the flight")
    chosen = default_channel_map(source) if channel_map is None else load_channel_map(channel_map)
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

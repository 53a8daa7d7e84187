"""Opening a flight, whatever it is: folder, Flight CSV, MAVLink log, on-board log, table."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import chain, islice
from pathlib import Path
from typing import Any

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.decoding.channel_map import ChannelMap, load_channel_map, shipped_channel_maps
from gsapp.decoding.decoder import ChannelSource
from gsapp.decoding.derived_channels import SURFACE_DERIVATIONS, select_derivations
from gsapp.decoding.health import LinkHealth
from gsapp.decoding.notices import NoticeLog
from gsapp.decoding.sender_filter import RawRecordLike, SenderFilter
from gsapp.flight.cache import DecodedFlight, cache_key, load_cached, store_cached
from gsapp.flight.certificates import calibration_remarks, uncalibrated_columns
from gsapp.flight.events import convert_to_flown_clock, event_from_notice, read_events, sort_events
from gsapp.flight.file_names import EVENTS_FILE, SENDERS_FILE
from gsapp.flight.flight import Flight, FrameCounts
from gsapp.flight.folder import FlightFolder, is_flight_folder
from gsapp.flight.parameter_events import parameter_events
from gsapp.flight.raw_files import RawDamage, RawTail, read_nonempty_tlog
from gsapp.flight.raw_files.record_files import RawRecord
from gsapp.flight.read_limits import NUMBER_BYTES, check_grid_size, count_grid_rows, read_limit
from gsapp.flight.read_settings import FlightReadSettings, NameOrPath
from gsapp.flight.readers.columns import (
    ColumnFlight,
    build_flight_from_columns,
    fastest_rate,
    read_flight_csv,
)
from gsapp.flight.readers.dataflash import read_dataflash
from gsapp.flight.readers.log_mapping import (
    clipped_remarks,
    map_log,
    resample_to_grid,
    vehicle_remarks,
)
from gsapp.flight.readers.log_tables import ForeignLog
from gsapp.flight.readers.tables import read_mat_columns, read_parquet_columns, read_table
from gsapp.flight.readers.ulog import read_ulog
from gsapp.flight.settings import FLIGHT_DATA
from gsapp.flight.uniform_grid import combine_on_grid, find_uniform_grid, median_step
from gsapp.foundation import FlightError, GroundStationError, UnmappedError
from gsapp.foundation.files import list_files
from gsapp.foundation.name_suggestions import did_you_mean, format_names
from gsapp.quantities import Block

_RECORDS_AT_ONCE = 20_000
_USUAL_RATES = (1, 2, 5, 10, 20, 25, 50, 60, 100, 125, 200, 250, 400, 500, 1000)
_LOG_MAPS = {".bin": "ardupilot-log", ".log": "ardupilot-log", ".ulg": "px4-log"}
_MAPPED = (".tlog", *_LOG_MAPS)
TABLE_SUFFIXES = (".csv", ".txt", ".asc", ".dat", ".tsv", ".mat", ".parquet")
"""Of files whose columns are channels."""
LOG_SUFFIXES = (".tlog", *_LOG_MAPS, *(ending for ending in TABLE_SUFFIXES if ending != ".txt"))
"""Of files that may be the on-board log of a flight."""
_FORMATS = {
    ".tlog": "mavlink",
    **_LOG_MAPS,
    **dict.fromkeys(TABLE_SUFFIXES, "table"),
}
_HEARTBEAT = 0
_AUTOPILOT = 5  # place in the payload of HEARTBEAT
_MAP_OF_AUTOPILOT = {3: "ardupilot-plane", 12: "px4"}
_NO_AIRPLANES = frozenset(
    {
        "quadrotor", "coaxial", "helicopter", "hexarotor", "octorotor", "tricopter", "dodecarotor",
        "decarotor", "ground rover", "surface boat", "submarine",
    }
)  # fmt: skip
"""MAV_TYPE in words."""
_ARRAY = 350
_ARRAY_NAME = 10  # place in the payload of DEBUG_FLOAT_ARRAY


def load_flight(
    name_or_path: NameOrPath,
    *,
    channel_map: ChannelMap | NameOrPath | None = None,
    rate: float | None = None,
    certificates: NameOrPath | None = None,
    aircraft: Aircraft | NameOrPath | None = None,
    raw: Sequence[str] = (),
    native: bool = False,
) -> Flight:
    """Open a flight.

    Parameters
    ----------
    name_or_path : str or Path
        A flight folder; or a ``.csv`` (Flight CSV, or any table with a map; also ``.txt``,
        ``.asc``, ``.dat``, ``.tsv``), ``.tlog``, ``.bin``, ``.log``, ``.ulg``, ``.mat`` or
        ``.parquet`` file.
    channel_map : ChannelMap, str or Path, optional
        In place of the one in the folder; for logs that have none, by default the shipped one
        that fits.
    rate : float, optional
        Samples per second of the grid. By default that of ``flight.toml``, else 100 for logs;
        columns that are even keep their own.
    certificates : str or Path, optional
        In place of those in the folder; a folder, or the name of a shipped set. `Flight.remarks`
        then says so.
    aircraft : Aircraft, str or Path, optional
        In place of the one in the folder.
    raw : sequence of str, optional
        Fields of messages to keep as they are, beside those of the map: ``ATT.DesRoll``,
        ``NKF1.*``.
    native : bool, optional
        Keep samples at their own times: `Flight.block` then has a row for each time at which any
        channel has one, NaN elsewhere, and no derived channels.

    Returns
    -------
    Flight
        Whole, as far as the files are good; what was lost stands in `Flight.remarks`.

    Raises
    ------
    FlightError
        If it cannot be read, or certificates are given and it holds no volts to apply them to.
    FileProblemsError
        If a file holds mistakes; each is named with its place.
    UnknownNameError
        If a map or aircraft of that name does not exist.
    """
    path = Path(name_or_path)
    if rate is not None and not 0.01 <= rate <= 10_000.0:
        raise FlightError(f"grid rate of {rate:g} Hz is out of range (1 to 10,000 Hz)")
    folder = FlightFolder.open(path) if path.is_dir() else None
    setting = FlightReadSettings.load(
        path,
        channel_map=channel_map,
        certificates=certificates,
        aircraft=aircraft,
        rate=rate,
        raw=raw,
        native=native,
    )
    if folder is not None:
        return _load_folder(folder, setting)
    check_flight_exists(path)
    if path.suffix.casefold() in _MAPPED and setting.channel_map is None:
        setting = replace(setting, channel_map=default_channel_map(path))
    decoded = _decode_file(path, setting)
    used = setting.applied_certificates(setting.channel_map)
    return Flight(
        name=path.stem,
        path=path,
        block=decoded.block,
        sources=decoded.sources,
        frames=decoded.frames,
        events=decoded.vehicle_messages,
        remarks=(*calibration_remarks(used, decoded.sources, decoded.block), *decoded.remarks),
        certificates=used,
        native=native,
    )


def check_flight_exists(path: Path) -> None:
    """Raise `FlightError` if there is no such flight; names what has a like name in its folder."""
    if not path.exists():
        folder = path.absolute().parent
        there = [one.name for one in folder.iterdir()] if folder.is_dir() else []
        hint = did_you_mean(path.name, there, "check the path", most=1)
        raise FlightError(f"there is no flight {path}; {hint}")


def find_flights(paths: Sequence[Path]) -> tuple[Path, ...]:
    """Return the flights among some paths, and those in folders that are no flight themselves.

    Raises
    ------
    FlightError
        If a folder holds none.
    """
    found: list[Path] = []
    for path in paths:
        if not path.is_dir() or is_flight_folder(path):
            found.append(path)
            continue
        inside = [
            one
            for one in list_files(path)
            if (one.is_dir() and is_flight_folder(one)) or one.suffix.casefold() in LOG_SUFFIXES
        ]
        if not inside:
            raise FlightError(
                f"the folder {path} holds no flight; give a flight folder, a file, or a folder "
                "with flights in it"
            )
        found += inside
    return tuple(found)


def load_with_log(folder: FlightFolder, log: Path) -> Flight:
    """Open a flight as it would be with another on-board log; `Flight.onboard`: whether it fits.

    If the log is put into the folder under its name, the flight opens at once.
    """
    return _load_folder(folder, FlightReadSettings.load(folder.path), log)


def _load_folder(
    folder: FlightFolder, setting: FlightReadSettings, log: Path | None = None
) -> Flight:
    record = read_events(folder.path / EVENTS_FILE)
    remarks: tuple[str, ...] = ()
    if record.damaged:
        remarks = (damaged_events_text(record.damaged),)
    if folder.nonempty_raw_files and setting.channel_map is None:
        first = RawTail(folder.path).poll(_RECORDS_AT_ONCE)
        setting = replace(setting, channel_map=guess_channel_map(first, folder.path, setting))
    decoded = _decode_folder(folder, setting, log)
    used = setting.applied_certificates(setting.channel_map)
    return Flight(
        name=folder.name,
        path=folder.path,
        block=decoded.block,
        sources=decoded.sources,
        info=folder.info(),
        frames=decoded.frames,
        events=sort_events((*convert_to_flown_clock(record.events), *decoded.vehicle_messages)),
        remarks=(
            *remarks,
            *calibration_remarks(used, decoded.sources, decoded.block),
            *decoded.remarks,
        ),
        certificates=used,
        onboard=decoded.onboard,
        native=setting.native,
    )


def damaged_events_text(count: int) -> str:
    """Return the sentence for damaged lines of ``events.jsonl``."""
    lines = "1 line" if count == 1 else f"{count} lines"
    return f"{EVENTS_FILE}: {lines} of marks and notes could not be read and were skipped."


def _decode_folder(
    folder: FlightFolder, setting: FlightReadSettings, log: Path | None
) -> DecodedFlight:
    """Decode raw files and on-board log, or another; from the cache where it still holds."""
    raw = folder.nonempty_raw_files
    missing = ""
    try:
        onboard = folder.onboard_log() if log is None else log
    except FlightError as error:
        if not raw:
            raise
        onboard, missing = None, str(error)
    if not raw and onboard is None:
        return DecodedFlight(
            block=Block(channels=(), times=np.empty(0), values=np.empty((0, 0))),
            sources={},
            remarks=("this flight contains no record",),
        )
    senders = folder.path / SENDERS_FILE
    files = [
        *raw,
        *([senders] if raw and senders.is_file() else []),
        *(file for file in (onboard,) if file is not None),
    ]
    key = _cache_key(files, setting)
    decoded = None if setting.native else load_cached(folder.cache_folder, key)
    if decoded is None:
        if raw:
            decoded = _decode_folder_records(folder.path, setting)
            if onboard is not None:
                decoded = _merge_log(decoded, onboard, setting, folder.path)
        else:
            decoded = _decode_file(files[0], setting)
        fits = log is None or (decoded.onboard is not None and decoded.onboard.in_place)
        if fits and not setting.override_source and not setting.native:
            # Trying other certificates or logs does not cost the flight the cache of its own.
            store_cached(folder.cache_folder, key, decoded)
    return replace(decoded, remarks=(missing, *decoded.remarks)) if missing else decoded


def _merge_log(
    live: DecodedFlight, onboard: Path, setting: FlightReadSettings, folder: Path
) -> DecodedFlight:
    """Let the on-board log replace the live record, if it can be read."""
    # SciPy's transforms take a third of a second.
    from gsapp.flight.onboard_log.log_merge import (
        merge_native_samples,
        merge_onboard_log,
        reject_onboard_log,
    )

    channel_map = setting.channel_map
    ending = onboard.suffix.casefold()
    if channel_map is not None and channel_map.format != _FORMATS.get(ending):
        # The map in force is that of the link; the log is read by its own. That of an autopilot
        # has nothing to calibrate, so certificates given are no fault; a table has former ones in
        # it, and stays out.
        given = "" if ending in _LOG_MAPS else setting.override_source
        setting = replace(setting, channel_map=None, override_source=given)
    try:
        log = _decode_file(onboard, setting)
    except GroundStationError as error:
        return reject_onboard_log(live, onboard.name, str(error))
    if setting.native:
        return merge_native_samples(live, log, load_flight(folder).onboard)
    return merge_onboard_log(live, log, setting.grid_rate, onboard.name)


def _cache_key(files: list[Path], setting: FlightReadSettings) -> str:
    channel_map = setting.channel_map
    certificates = setting.certificates_for(channel_map) if channel_map else setting.certificates
    return cache_key(
        files,
        {
            "map": repr(replace(channel_map, path=None)) if channel_map else None,
            "certificates": repr(sorted((certificates or {}).items())),
            "aircraft": setting.aircraft.model_dump(mode="json") if setting.aircraft else None,
            "rate": setting.rate,
            "raw": setting.raw,
            "system": setting.system,
            "address": setting.address,
        },
    )


def default_channel_map(path: Path) -> ChannelMap | None:
    """Return the shipped map by which a file is read where none is named; None for columns."""
    ending = path.suffix.casefold()
    if ending in _LOG_MAPS:
        return load_channel_map(_LOG_MAPS[ending])
    if ending == ".tlog":
        return guess_channel_map(list(islice(read_nonempty_tlog(path), _RECORDS_AT_ONCE)), path)
    return None


def _decode_file(path: Path, setting: FlightReadSettings) -> DecodedFlight:
    ending = path.suffix.casefold()
    if setting.channel_map is not None and ending in _FORMATS:
        _check_map_format(path, setting.channel_map, _FORMATS[ending])
    if ending == ".tlog":
        return _decode_tlog(path, setting)
    if ending in _LOG_MAPS:
        channel_map = setting.channel_map or load_channel_map(_LOG_MAPS[ending])
        return _decode_log(_read_log(path), channel_map, setting)
    if ending not in TABLE_SUFFIXES:
        raise FlightError(
            f"{path} has an unknown file ending; flights are folders, {', '.join(LOG_SUFFIXES)} "
            "and .txt"
        )
    if setting.channel_map is not None:
        log = read_table(path, setting.channel_map)
        return _decode_log(log, setting.channel_map, setting)
    if ending == ".mat":
        columns = _read_native_columns(path, read_mat_columns)
    elif ending == ".parquet":
        columns = _read_native_columns(path, read_parquet_columns)
    else:
        columns = read_flight_csv(path)
    if setting.override_source:
        raise FlightError(
            f"the certificates of '{setting.override_source}' cannot be applied to {path.name}: "
            "its columns "
            "were calibrated when it was written; give the flight folder with the raw record"
        )
    return _decode_columns(path, columns, setting)


def _read_log(path: Path) -> ForeignLog:
    return read_ulog(path) if path.suffix.casefold() == ".ulg" else read_dataflash(path)


def read_onboard_log(path: Path) -> ForeignLog | None:
    """Read the log of an autopilot; None for another kind of file."""
    return _read_log(path) if path.suffix.casefold() in _LOG_MAPS else None


def _check_map_format(path: Path, channel_map: ChannelMap, wanted: str) -> None:
    if channel_map.format == wanted:
        return
    fitting = [name for name in shipped_channel_maps() if load_channel_map(name).format == wanted]
    shipped = f"; shipped are: {', '.join(fitting)}" if fitting else ""
    raise FlightError(
        f"the channel map '{channel_map.name}' is of format {channel_map.format}, and {path.name} "
        f"needs one of format {wanted}{shipped}"
    )


def _read_native_columns(path: Path, read: Callable[[Path], Any]) -> ColumnFlight:
    """Read columns that name channels and units, as this program writes them."""
    arrays, units = read(path)
    if not arrays:
        raise FlightError(f"{path} holds no arrays of numbers; export the flight again")
    if not units and not any("[" in name for name in arrays):
        raise UnmappedError(
            f"{path} does not assign variables to channels and units; give a channel map of "
            f"format 'table' with --map. Variables: {format_names(list(arrays), 12)}"
        )
    return build_flight_from_columns(path, arrays, units)


def _decode_columns(path: Path, flight: ColumnFlight, setting: FlightReadSettings) -> DecodedFlight:
    block, rate = flight.block, setting.rate
    remarks = list(flight.remarks)
    fastest = fastest_rate(block)
    # Instruments that are sampled in turn, a microsecond apart, lie on no grid worth having.
    in_turn = fastest * median_step(block.times) * FLIGHT_DATA.max_idle_rows < 1.0
    usual = 1.0 / median_step(block.times) if len(block) > 1 else 1.0
    needed = count_grid_rows(block.times, usual) * len(block.channels) * NUMBER_BYTES
    crowded = needed > read_limit(path.stat().st_size)
    found = None if in_turn or crowded else find_uniform_grid(block.times)
    if setting.native:
        pass
    elif rate is None and found is not None:
        grid, index = found
        if grid.size != block.times.size or not np.array_equal(grid, block.times):
            values = np.full((grid.size, len(block.channels)), np.nan)
            values[index] = block.values
            block = Block(channels=block.channels, times=grid, values=values)
    else:
        chosen = rate or _nearest_rate(fastest)
        if not FLIGHT_DATA.min_grid_rate <= chosen:
            raise FlightError(
                f"{path} has a sample every {1.0 / chosen:.2g} s; is the time in another unit than "
                "its header says? correct the unit, or remove wrong times"
            )
        if rate is None:
            remarks.append(
                f"the times are uneven; resampled to a grid of {chosen:g} samples per second"
            )
        block = resample_to_grid(path, block, chosen)
    units = {column.id: column.unit for column in flight.columns}
    lacking = uncalibrated_columns(block.channels)
    sources = {
        name: ChannelSource(
            source=f"column {name} [{units[name]}]",
            kind="measured",
            calibrated=name not in lacking,
            uncalibrated_channel=lacking.get(name, ""),
        )
        for name in block.channels
    }
    for derivation in select_derivations(block.channels, SURFACE_DERIVATIONS):
        combined = derivation.compute(*(block[name] for name in derivation.inputs))
        block = Block(
            channels=(*block.channels, derivation.output),
            times=block.times,
            values=np.column_stack((block.values, combined)),
        )
        sources[derivation.output] = ChannelSource(
            source=derivation.description, kind="derived", calibrated=True
        )
    return DecodedFlight(block=block, sources=sources, remarks=tuple(remarks))


def _nearest_rate(rate: float) -> float:
    near = min(_USUAL_RATES, key=lambda each: abs(each - rate))
    return float(near) if abs(near - rate) <= 0.02 * near else float(f"{rate:.3g}")


def _decode_log(
    log: ForeignLog, channel_map: ChannelMap, setting: FlightReadSettings
) -> DecodedFlight:
    mapped = map_log(
        log,
        setting.with_raw(channel_map),
        certificates=setting.certificates_for(channel_map),
        aircraft=setting.aircraft,
        rate=setting.grid_rate,
        native=setting.native,
    )
    return DecodedFlight(
        block=mapped.block,
        sources=mapped.sources,
        vehicle_messages=log.events,
        remarks=(*log.remarks, *mapped.remarks),
    )


def _decode_tlog(path: Path, setting: FlightReadSettings) -> DecodedFlight:
    damage = RawDamage(name=path.name)
    decoded = _decode_records(_batches(read_nonempty_tlog(path, damage)), setting, path)
    if decoded.frames is not None and damage:
        frames = replace(decoded.frames, damaged=decoded.frames.damaged + damage.location_count)
        decoded = replace(decoded, frames=frames, remarks=(damage.describe(), *decoded.remarks))
    return decoded


def _decode_folder_records(folder: Path, setting: FlightReadSettings) -> DecodedFlight:
    tail = RawTail(folder)
    decoded = _decode_records(_poll_records(tail), setting, folder)
    return replace(
        decoded, remarks=(*(damage.describe() for damage in tail.damage), *decoded.remarks)
    )


def _poll_records(tail: RawTail) -> Iterator[list[RawRecord]]:
    while records := tail.poll(_RECORDS_AT_ONCE):
        yield records


def _batches(records: Iterator[RawRecord]) -> Iterator[list[RawRecord]]:
    while batch := list(islice(records, _RECORDS_AT_ONCE)):
        yield batch


def _decode_records(
    batches: Iterator[list[RawRecord]], setting: FlightReadSettings, path: Path
) -> DecodedFlight:
    first = next(batches, [])
    channel_map = setting.channel_map or guess_channel_map(first, path, setting)
    decoder = setting.decoder(channel_map)

    def blocks() -> Iterator[Block]:
        records = 0
        sparse = numbers = 0.0
        for batch in chain([first], batches):
            # Before they are decoded: a batch of records a minute apart fills any memory.
            records += len(batch)
            stamps = np.array([one.stamp_us for one in batch]) / 1e6
            sparse += count_grid_rows(stamps, decoder.rate) * len(channel_map.entries)
            check_grid_size(path, sparse, decoder.rate, records)
            for block in decoder.feed(batch):
                numbers += block.values.size
                check_grid_size(path, numbers, decoder.rate, records)
                yield block
        yield from decoder.finish()

    if setting.native:
        for _ in blocks():
            pass
        block = decoder.native_samples()
    else:
        block = combine_on_grid(blocks(), decoder.rate)
    health, report = decoder.health, decoder.health.report()
    vehicle = "" if report.flown is None else report.flown.vehicle_type
    vehicle = vehicle if vehicle in _NO_AIRPLANES else ""
    counted = decoder.counted_sources()
    return DecodedFlight(
        block=block,
        sources={name: counted[name] for name in block.channels},
        frames=FrameCounts(
            good=health.good,
            damaged=health.damaged,
            unknown=health.unknown,
            lost=health.lost,
            lines=decoder.lines,
            bad_lines=decoder.bad_lines,
        ),
        vehicle_messages=(
            *(
                event_from_notice(notice)
                for notice in (*decoder.messages, *decoder.modes, *decoder.notices)
            ),
            *parameter_events(decoder.parameters),
        ),
        remarks=(
            *report.warnings,
            *vehicle_remarks(
                vehicle if vehicle in _NO_AIRPLANES else "", channel_map, block.channels
            ),
            *decoder.remarks,
            *clipped_remarks(decoder.clipped),
        ),
    )


def guess_channel_map(
    records: Sequence[RawRecord],
    path: Path,
    setting: FlightReadSettings | None = None,
) -> ChannelMap:
    """Return the shipped map that fits what a record begins with.

    The box of the B777 sends an array called ``daq``; other autopilots name themselves in their
    heartbeats. What a stranger sends does not count. `UnmappedError` if none is known to fit.
    """
    chosen = setting or FlightReadSettings()
    senders = SenderFilter(
        LinkHealth(), NoticeLog(lambda _stamp: None), chosen.system, chosen.address
    )
    accepted: list[RawRecordLike] = [*senders.feed(records), *senders.finish()]
    autopilots: Counter[int] = Counter()
    for record in accepted:
        if record.kind != "frame":
            continue
        message, payload = _message(record.data)
        if message == _ARRAY and payload[_ARRAY_NAME : _ARRAY_NAME + 4] == b"daq\0":
            return load_channel_map("b777")
        if message == _HEARTBEAT and len(payload) > _AUTOPILOT:
            autopilots[payload[_AUTOPILOT]] += 1
    for autopilot, _ in autopilots.most_common():
        if autopilot in _MAP_OF_AUTOPILOT:
            return load_channel_map(_MAP_OF_AUTOPILOT[autopilot])
    kinds = Counter(record.kind for record in records)
    fitting = [
        name for name in shipped_channel_maps() if load_channel_map(name).format == "mavlink"
    ]
    named = f"name one with --map: {', '.join(fitting)}, or a file"
    if kinds["frame"]:
        raise UnmappedError(f"{path} matches no single channel map; {named}")
    if kinds["line"]:
        raise UnmappedError(
            f"{path} contains lines of text; give a channel map with --map that assigns "
            "line[0], line[1] and so on"
        )
    if kinds["residue"]:
        raise UnmappedError(
            f"{path} contains no complete MAVLink frame; check the baud rate, the wiring and "
            f"the protocol of the sender, or {named}"
        )
    raise FlightError(f"{path} contains no readable record")


def frame_message(frame: bytes) -> int:
    """Return the number of the message in a MAVLink frame."""
    return _message(frame)[0]


def _message(frame: bytes) -> tuple[int, bytes]:
    if frame[0] == 0xFD:
        return frame[7] | frame[8] << 8 | frame[9] << 16, frame[10 : 10 + frame[1]]
    return frame[5], frame[6 : 6 + frame[1]]

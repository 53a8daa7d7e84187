"""From the tables of a foreign log to channels on the grid.

The numbers take the road of the live decoder (`gsapp.decoding.pipeline`): scale, unit and
calibration, linear interpolation, nothing across more than 2.5 sample periods, the better source
while it lives, derived channels where nobody measures them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from calibration.certificate import Certificate
from gsapp.aircraft import Aircraft
from gsapp.decoding.channel_map import TABLE, ChannelMap, FieldRef, MapEntry
from gsapp.decoding.conversions import CONVERSIONS
from gsapp.decoding.message_stream import is_valid
from gsapp.decoding.pipeline import ChannelSource, Pipeline
from gsapp.decoding.raw_channels import RawPatterns, raw_entry
from gsapp.flight.read_limits import check_grid_size, count_grid_rows
from gsapp.flight.readers.log_tables import ForeignLog, LogTable
from gsapp.flight.uniform_grid import combine_on_grid
from gsapp.foundation import FlightError, UnitError, UnmappedError
from gsapp.foundation.name_suggestions import did_you_mean, format_names
from gsapp.quantities import (
    SURFACE_NAMES,
    Block,
    FloatArray,
    base_id,
    channel,
    is_raw_channel,
    normalize_unit,
)

_STAMPS = frozenset({"TimeUS", "TimeMS", "timestamp"})
"""Fields that hold the time of a message."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MappedLog:
    """What a map finds in a log."""

    block: Block
    """On the grid ``k / rate``."""
    sources: Mapping[str, ChannelSource]
    """Of every channel in it."""
    remarks: tuple[str, ...]
    """What was noticed, in words."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _MatchedEntry:
    """One entry of the map, fitted to the log."""

    entry: MapEntry
    times: FloatArray
    fields: Mapping[str, FloatArray]
    by_order: bool


def map_log(
    log: ForeignLog,
    channel_map: ChannelMap,
    *,
    certificates: Mapping[str, Certificate],
    rate: float,
    aircraft: Aircraft | None = None,
    native: bool = False,
) -> MappedLog:
    """Lay the channels that a map names in a log on the grid; those that the log lacks are absent.

    With `native` the samples stay at their own times instead, and none are derived.

    Where the log states a unit itself, and the map neither scales nor converts, the log is
    believed. `FlightError` if the log holds nothing of what the map names.
    """
    remarks: list[str] = []
    raw = _raw_entries(log, channel_map.raw, remarks)
    found = [
        each
        for index, entry in enumerate((*channel_map.entries, *raw))
        if (each := _match_entry(log, entry, index, remarks)) is not None
    ]
    if not found:
        holds = f". It holds: {format_names(log.messages, 20)}" if log.messages else ""
        raise UnmappedError(
            f"{log.path} contains no message of the channel map '{channel_map.name}'; give "
            f"another with --map{holds}"
        )
    homes = {(each.entry.message, each.entry.selector, each.entry.time): each for each in found}
    pipeline = Pipeline(
        replace(channel_map, entries=tuple(each.entry for each in found)),
        certificates=certificates,
        aircraft=aircraft,
        rate=rate,
        vehicle_time=lambda entry: not homes[entry.message, entry.selector, entry.time].by_order,
        keep_samples=native,
    )
    numbers = sum(
        count_grid_rows(homes[one.message, one.selector, one.time].times, rate)
        for one in (each.entry for each in found)
    )
    if not native:
        check_grid_size(log.path, numbers, rate)
    first, last = np.inf, -np.inf
    for number, stream in enumerate(pipeline.streams):
        entry = stream.outputs[0].entry
        home = homes[entry.message, entry.selector, entry.time]
        first, last = min(first, home.times[0]), max(last, home.times[-1])
        micros = np.rint(home.times * 1e6).astype(np.int64).tolist()
        pipeline.push(number, micros, micros, home.fields)
    blocks = pipeline.pull(round(first * 1e6), round(last * 1e6), final=True)
    block = pipeline.native_samples() if native else combine_on_grid(blocks, pipeline.grid.rate)
    counted = pipeline.counted_sources()
    return MappedLog(
        block=block,
        sources={name: counted[name] for name in block.channels},
        remarks=(
            *vehicle_remarks(log.vehicle, channel_map, block.channels),
            *dict.fromkeys(remarks),
            *clipped_remarks(pipeline.clipped),
        ),
    )


def log_numbers(log: ForeignLog) -> list[MapEntry]:
    """Return the entries of all numbers of a log."""
    return [
        raw_entry(message, selector, name, index)
        for (message, selector), table in log.tables.items()
        for name, values in table.fields.items()
        if name not in _STAMPS
        for index in ((None,) if values.ndim == 1 else range(values.shape[1]))
    ]


def _raw_entries(log: ForeignLog, patterns: Sequence[str], remarks: list[str]) -> list[MapEntry]:
    """Return the entries of all numbers of a log that fit patterns of raw channels."""
    if not patterns:
        return []
    entries = log_numbers(log)
    found: dict[str, MapEntry] = {}
    for pattern in patterns:
        fits = RawPatterns([pattern]).matches
        wanted = {one.channel: one for one in entries if fits(one.channel)}
        if not wanted:
            known = [*log.messages, *(one.channel for one in entries)]
            remedy = did_you_mean(pattern, known, f"it has {format_names(log.messages, 20)}")
            remarks.append(f"{log.path.name} has no field '{pattern}'; {remedy}")
        found |= wanted
    return [one for name, one in found.items() if is_raw_channel(name)]


def vehicle_remarks(
    vehicle: str, channel_map: ChannelMap, channels: Iterable[str]
) -> tuple[str, ...]:
    """Return in words that a map looks for control surfaces on a vehicle that has none.

    `vehicle` is empty for an airplane.
    """
    mapped = {name for name in channel_map.channels if _is_surface(name)}
    if not vehicle or not mapped:
        return ()
    surfaces = ", ".join(sorted(mapped.intersection(channels)))
    what = f": {surfaces} are no control surfaces here" if surfaces else ""
    return (
        f"this is a record of a {vehicle}, and the channel map '{channel_map.name}' is for "
        f"airplanes{what}; give a map of your own with --map",
    )


def _is_surface(name: str) -> bool:
    return base_id(name).removesuffix("_command") in SURFACE_NAMES


def clipped_remarks(clipped: Mapping[str, int]) -> tuple[str, ...]:
    """Return in words how many samples lay outside calibration or instrument range."""
    return tuple(
        f"{name} outside its calibrated range ({count} sample{'s' if count != 1 else ''})"
        for name, count in sorted(clipped.items())
    )


def resample_to_grid(path: Path, block: Block, rate: float) -> Block:
    """Lay columns with uneven times, or another rate, on the grid ``k / rate``.

    Each channel by its own samples: one that is missing in every other row is not a gap.
    """
    entries = tuple(
        MapEntry(
            channel=name,
            source=name,
            message=TABLE,
            inputs=(FieldRef(field=name),),
            unit=channel(name).unit,
        )
        for name in block.channels
        if not np.isnan(block[name]).all()
    )
    if not entries:
        raise FlightError(f"{path} contains no samples")
    table = LogTable(times=block.times, fields={name: block[name] for name in block.channels})
    mapped = map_log(
        ForeignLog(path=path, tables={(TABLE, ""): table}),
        ChannelMap(name=path.name, entries=entries, format="table"),
        certificates={},
        rate=rate,
    )
    # Columns are engineering data: nothing is derived that their author left out.
    return mapped.block.select([entry.channel for entry in entries])


def _match_entry(
    log: ForeignLog, entry: MapEntry, place: int, remarks: list[str]
) -> _MatchedEntry | None:
    """Fit an entry to the log; None if the log does not have it."""
    table = _table(log, entry)
    if table is None:
        return None
    inputs = _inputs(table, entry)
    if inputs is None:
        return None
    fitted = replace(
        entry,
        inputs=tuple(inputs),
        unit=_unit(entry, table, remarks),
        time=entry.time or "",
        valid=None,
    )
    there = np.ones(table.times.size, dtype=bool)
    # Not every release writes the field that tells.
    if entry.valid is not None and entry.valid in table.fields:
        there &= is_valid(table.fields[entry.valid], entry.valid_from)
    for values in inputs.values():
        there &= np.isfinite(values) & ~np.isin(values, entry.missing)
    remarks += [table.remark] if table.remark else []
    if not there.any():
        return None
    if there.all():
        return _MatchedEntry(
            entry=fitted, times=table.times, fields=table.fields, by_order=table.by_order
        )
    # A stream of its own: samples missing of one field are no gap in another, nor in this one if
    # it merely comes in every tenth row.
    return _MatchedEntry(
        entry=replace(fitted, time=f"{fitted.time}#{place}"),
        times=table.times[there],
        fields={ref.field: table.fields[ref.field][there] for ref in inputs},
        by_order=table.by_order,
    )


def _table(log: ForeignLog, entry: MapEntry) -> LogTable | None:
    selector = entry.selector
    if entry.message == TABLE:
        return log.table(TABLE, entry.time or "")
    if selector is None or not selector.field:
        return log.table(entry.message, selector.value if selector else "")
    table = log.table(entry.message, "")
    if table is None or selector.field not in table.fields or not _is_number(selector.value):
        return None
    rows = table.fields[selector.field] == float(selector.value)
    return table.where(rows) if rows.any() else None


def _is_number(text: str) -> bool:
    return text.replace(".", "", 1).isdigit()


def _inputs(table: LogTable, entry: MapEntry) -> dict[FieldRef, FloatArray] | None:
    """Return the numbers that an entry takes, a whole array spread to its elements."""
    refs = list(entry.inputs)
    if entry.convert is not None and len(refs) == 1 and refs[0].index is None:
        name = refs[0].field
        if CONVERSIONS[entry.convert].inputs > 1:
            count = CONVERSIONS[entry.convert].inputs
            refs = [FieldRef(field=name, index=index) for index in range(count)]
    found: dict[FieldRef, FloatArray] = {}
    for ref in refs:
        values = table.fields.get(ref.field)
        if values is None:
            return None
        if ref.index is None:
            if values.ndim != 1:
                return None
            found[ref] = values
        elif values.ndim == 2 and ref.index < values.shape[1]:
            found[ref] = values[:, ref.index]
        else:
            return None
    return found


def _unit(entry: MapEntry, table: LogTable, remarks: list[str]) -> str:
    """Return the unit of the field: that of the log, where it states one that fits."""
    stated = table.units.get(entry.inputs[0].field, "")
    changed = entry.convert is not None or entry.curve is not None
    if not stated or entry.scale != 1.0 or entry.offset != 0.0 or changed or entry.calibration:
        return entry.unit
    try:
        unit = normalize_unit(stated, channel(entry.channel).quantity)
    except UnitError:
        return entry.unit
    if unit != entry.unit:
        remarks.append(
            f"the log gives {entry.source} in {unit}, the channel map in {entry.unit}; the unit "
            "of the log is used"
        )
    return unit

"""Channel maps: which field of which message is which channel.

A map is a TOML file::

    name = "my aircraft"
    system = 1                 # optional: the flown system; else the first autopilot heard
    component = 1              # optional; else the first that sends a message
    fallback = "1 s"           # how long a better source may be silent before the next one counts
    certificates = "b777"      # optional: calibration in force when none is given
    raw = ["ATTITUDE.*"]       # optional: fields kept as they are, under their own names
    format = "mavlink"         # or "ardupilot-log", "px4-log", "table"

    [[channels]]
    id = "elevator_left"
    source = "DEBUG_FLOAT_ARRAY[daq].data[0]"
    unit = "V"
    calibration = "elevator_left"

``source`` is ``MESSAGE[selector].field[index]``. The selector picks one of several senders: text
is compared with the field ``name``, a number with the field that numbers the instances;
``[field=value]`` names the field. ``line[3]`` is the fourth column of a line of text. SI value =
unit(scale * field + offset); with ``table = [[1000, -21.0], [2000, 19.5]]`` or
``polynomial = [c0, c1, c2]`` the field is what the table or polynomial makes of it. ``missing``
lists raw values that mean "not known"; ``valid`` names a field that is zero, or less than
``valid_from``, where the value does not count.

Text links may list their columns instead, as the Flight CSV does::

    [text]
    columns = ["time [s]", "alpha [deg]", "", "q [deg/s]"]      # "" is passed over

In a map of format ``table``, for the CSV, ``.mat`` and Parquet files of other programs, ``source``
is the name of a column or variable (``gyro.q`` inside a structure, ``rates[1]`` of an array of
several columns), and the head may name the clock::

    time = "GPS time (ms)"     # else a column called time, t, timestamp ...
    time_unit = "ms"           # else s
    unfilled = 0               # a column that holds nothing but this was not measured
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, get_args

from pydantic import BaseModel, ConfigDict, Field, field_validator

from calibration.signals import find_signal
from gsapp.decoding.conversions import CONVERSIONS
from gsapp.decoding.curves import Curve
from gsapp.decoding.messages import MessageLayout, message_id, message_layout, stamp_field_of
from gsapp.foundation import (
    FileProblem,
    FileProblemsError,
    StrictModel,
    UnitError,
    UnknownNameError,
    read_toml,
    toml_problems_error,
)
from gsapp.foundation.files import ShippedFiles
from gsapp.foundation.name_suggestions import close_matches, did_you_mean
from gsapp.foundation.toml import validate_content
from gsapp.quantities import INSTRUMENTS, base_id, channel, normalize_unit
from gsapp.quantities.fields import Time

SHIPPED_CHANNEL_MAPS = ShippedFiles(folder=Path(__file__).parent / "maps", kind="channel map")

SourceKind = Literal["measured", "estimated"]
Format = Literal["mavlink", "ardupilot-log", "px4-log", "table"]
LINE = "line"
TABLE = "table"
ARRIVAL = "arrival"

_SOURCE = re.compile(
    r"(?P<message>[A-Za-z]\w*)(?:\[(?P<selector>[^\[\]]+)\])?\.(?P<field>\w+)(?:\[(?P<index>\d+)\])?"
)
_LINE = re.compile(r"line\[(?P<index>\d+)\]")
_COLUMN = re.compile(r"\s*(?P<id>[\w.]+)\s*\[(?P<unit>[^\]]*)\]\s*")


@dataclass(frozen=True, slots=True, kw_only=True)
class FieldRef:
    """One number of a message."""

    field: str  # Name of the field; empty for a column of a text line.
    index: int | None = None
    """Element of an array field, or column of the line; None for a single value, or for the whole
    array where a conversion takes it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Selector:
    """Which of several senders of one message is meant."""

    field: str  # The field that tells them apart; empty where the log keeps instances apart itself.
    value: str  # What it must hold; text, or a number as text.


@dataclass(frozen=True, slots=True, kw_only=True)
class MapEntry:
    """One source of one channel."""

    channel: str  # Id of the channel that results, calibrated if `calibration` is given.
    source: str  # As written in the file.
    message: str  # Name of the message; ``line`` for text, ``table`` for a column of a table.
    inputs: tuple[FieldRef, ...]
    """One, or as many as the conversion takes (an array field counts for its elements)."""
    unit: str  # Unit of ``scale * field + offset``; of the signal where `calibration` is given.
    selector: Selector | None = None
    scale: float = 1.0
    offset: float = 0.0
    """See `unit`."""
    priority: int = 1  # Lower goes first.
    kind: SourceKind = "measured"  # What the vehicle does for it.
    calibration: str | None = None  # Channel of the certificate that gives this channel.
    time: str | None = None
    """Field with the vehicle's time, ``arrival``, or None for the message's own."""
    convert: str | None = None  # Name in `gsapp.decoding.conversions.CONVERSIONS`.
    curve: Curve | None = None  # From the field to what `scale` and `offset` apply to.
    missing: tuple[float, ...] = ()  # Raw values that mean "not known".
    valid: str | None = None
    """Field of the same message that is zero where the value does not count, ..."""
    valid_from: float | None = None
    """... or less than this."""

    @property
    def volts_channel(self) -> str:
        """Return the channel that keeps what is calibrated: ``q_volts.2`` of ``q.2``.

        It is raw, ``signal.de_command``, where no instrument of the channel gives volts.
        """
        base = base_id(self.channel)
        if base in INSTRUMENTS and find_signal(self.unit).unit == "V":
            return f"{base}_volts{self.channel[len(base) :]}"
        return f"signal.{self.channel.replace('.', '_')}"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ChannelMap:
    """A channel map, read and checked."""

    name: str
    entries: tuple[MapEntry, ...]
    """In the order of the file."""
    format: Format = "mavlink"  # Where its sources are found.
    system: int | None = None
    component: int | None = None
    """Which sender; None takes the first heard."""
    fallback: float = 1.0  # Seconds that a better source may be silent before the next one counts.
    certificates: str | None = None  # Shipped set of certificates to use where none is given.
    raw: tuple[str, ...] = ()
    """Patterns of fields to keep as raw channels; ``*`` stands for anything."""
    delimiter: str = ","  # Between the columns of a text line.
    text_time: int | None = None  # Column with the vehicle's time in a text line; None for none.
    text_scale: int = 1_000_000  # Microseconds per count in that column.
    table_time: str | None = None
    """Column of a table with the time; None for one of the usual names."""
    table_time_unit: str = "s"
    unfilled: float | None = None
    """Of a table: value of all samples of a column that was not measured."""
    path: Path | None = None
    by_channel: Mapping[str, tuple[MapEntry, ...]] = field(init=False)
    """The sources of each channel, the best first."""

    def __post_init__(self) -> None:
        groups: dict[str, list[MapEntry]] = {}
        for entry in self.entries:
            groups.setdefault(entry.channel, []).append(entry)
        ordered = {
            key: tuple(sorted(group, key=lambda entry: entry.priority))
            for key, group in groups.items()
        }
        object.__setattr__(self, "by_channel", ordered)

    @property
    def channels(self) -> tuple[str, ...]:
        return tuple(self.by_channel)

    @property
    def messages(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys(entry.message for entry in self.entries))


def shipped_channel_maps() -> tuple[str, ...]:
    """Return the names of the channel maps that come with the program."""
    return SHIPPED_CHANNEL_MAPS.names()


def load_channel_map(name_or_path: str | Path) -> ChannelMap:
    """Read a channel map: a path, or the name of a shipped map such as ``b777``.

    Raise FileProblemsError if it holds mistakes; all are named, with key path and remedy. Raise
    UnknownNameError if there is neither such a file nor such a shipped map.
    """
    path = SHIPPED_CHANNEL_MAPS.find(name_or_path)
    raw = read_toml(path, _AnyTable).model_extra or {}
    reader = _Reader(path, raw)
    return reader.read()


class _AnyTable(BaseModel):
    model_config = ConfigDict(extra="allow")


class _EntryTable(StrictModel):
    id: str
    source: str | list[str]
    unit: str
    scale: float = 1.0
    offset: float = 0.0
    priority: int = 1
    kind: SourceKind = "measured"
    calibration: str | None = None
    time: str | None = None
    convert: str | None = None
    table: list[tuple[float, float]] = Field(default_factory=list)
    polynomial: list[float] = Field(default_factory=list)
    missing: list[float] = Field(default_factory=list)
    valid: str | None = None
    valid_from: float | None = None


class _TextTable(StrictModel):
    columns: list[str]
    delimiter: str = Field(default=",", min_length=1, max_length=1)


class _MapHeader(StrictModel):
    name: str
    format: Format = "mavlink"
    system: int | None = Field(default=None, ge=1, le=255)
    component: int | None = Field(default=None, ge=1, le=255)
    fallback: Time = 1.0
    certificates: str | None = None
    notes: str = ""
    raw: list[str] = Field(default_factory=list)
    time: str | None = None
    time_unit: str = "s"
    unfilled: float | None = None

    @field_validator("time_unit")
    @classmethod
    def _must_be_a_time(cls, value: str) -> str:
        return normalize_unit(value, "time")


class _Reader:
    """Reads one map and gathers its mistakes."""

    def __init__(self, path: Path, raw: Mapping[str, Any]) -> None:
        self._path = path
        self._raw = raw
        self._problems: list[FileProblem] = []

    def read(self) -> ChannelMap:
        head = self._head()
        meant = _guess_format(self._raw) if head is None else head.format
        layouts = meant == "mavlink"
        # Of a format that nobody knows, any source may be one.
        self._table = meant in (TABLE, None)
        entries = self._text_entries()
        text = self._text
        for index, table in enumerate(self._tables()):
            entry = self._entry(f"channels[{index}]", table, mavlink=layouts)
            if entry is not None:
                entries.append((f"channels[{index}]", entry))
        self._check_priorities(entries)
        if not entries and not self._problems:
            self._report("channels", "names no channel", "add [[channels]] or [text]")
        if self._problems or head is None:
            raise toml_problems_error(self._path, self._problems)
        return ChannelMap(
            name=head.name,
            format=head.format,
            entries=tuple(entry for _, entry in entries),
            system=head.system,
            component=head.component,
            fallback=head.fallback,
            certificates=head.certificates,
            raw=tuple(head.raw),
            delimiter=text.delimiter if text else ",",
            text_time=self._text_time,
            text_scale=self._text_scale,
            table_time=head.time,
            table_time_unit=head.time_unit,
            unfilled=head.unfilled,
            path=self._path,
        )

    def _report(self, where: str, what: str, remedy: str = "") -> None:
        self._problems.append(FileProblem(where=where, what=what, remedy=remedy))

    def _report_error(self, where: str, error: Exception) -> None:
        self._problems.append(FileProblem.from_error(where, error))

    def _head(self) -> _MapHeader | None:
        known = {key: value for key, value in self._raw.items() if key not in ("channels", "text")}
        try:
            return validate_content(self._path, known, _MapHeader)
        except FileProblemsError as error:
            self._problems.extend(error.problems)
            return None

    def _tables(self) -> list[Any]:
        tables = self._raw.get("channels", [])
        if not isinstance(tables, list):
            self._report("channels", "is not a list of tables", "write [[channels]], doubled")
            return []
        return tables

    def _text_entries(self) -> list[tuple[str, MapEntry]]:
        self._text: _TextTable | None = None
        self._text_time: int | None = None
        self._text_scale = 1_000_000
        if "text" not in self._raw:
            return []
        try:
            self._text = validate_content(self._path, self._raw["text"], _TextTable)
        except FileProblemsError as error:
            self._problems.extend(_prefix_problem("text", problem) for problem in error.problems)
            return []
        entries = []
        for index, column in enumerate(self._text.columns):
            if not column.strip():
                continue
            where = f"text.columns[{index}]"
            match = _COLUMN.fullmatch(column)
            if match is None:
                self._report(where, f"'{column}' has no unit", 'write "id [unit]", or "" to skip')
            elif match["id"] == "time":
                self._text_clock(where, index, match["unit"])
            elif (unit := self._unit(where, match["id"], match["unit"], volts=False)) is not None:
                entry = MapEntry(
                    channel=match["id"],
                    source=f"line[{index}]",
                    message=LINE,
                    inputs=(FieldRef(field="", index=index),),
                    unit=unit,
                )
                entries.append((where, entry))
        return entries

    def _text_clock(self, where: str, index: int, unit: str) -> None:
        scales = {"s": 1_000_000, "ms": 1000, "us": 1}
        if unit not in scales:
            self._report(where, f"'{unit}' is not a unit of the clock", "use s, ms or us")
        elif self._text_time is not None:
            self._report(where, "is a second column of time", 'write "" to skip it')
        else:
            self._text_time, self._text_scale = index, scales[unit]

    def _entry(self, where: str, table: Any, *, mavlink: bool) -> MapEntry | None:
        before = len(self._problems)
        try:
            row = validate_content(self._path, table, _EntryTable)
        except FileProblemsError as error:
            self._problems.extend(_prefix_problem(where, problem) for problem in error.problems)
            # One mistake must not hide the others.
            wrong = {re.split(r"[.\[]", problem.where)[0] for problem in error.problems}
            keys = [] if wrong == {"file"} else _EntryTable.model_fields.keys() - wrong
            rest = {key: table[key] for key in keys if key in table}
            if not {"id", "source", "unit"} <= rest.keys():
                return None
            row = validate_content(self._path, rest, _EntryTable)
        unit = self._unit(where, row.id, row.unit, volts=row.calibration is not None)
        self._check_calibration(where, row)
        parsed = self._sources(f"{where}.source", row.source)
        if parsed is None:
            return None
        message, selector, inputs = parsed
        layout: MessageLayout | None = None
        if mavlink and message != LINE:
            try:
                layout = message_layout(message_id(message))
            except UnknownNameError as error:
                self._report_error(f"{where}.source", error)
                return None
            inputs = self._check_fields(f"{where}.source", layout, inputs, row.convert)
            self._check_time(where, layout, row.time)
            self._check_valid(where, layout, row.valid)
        if row.valid_from is not None and row.valid is None:
            self._report(f"{where}.valid_from", "no field is named", 'write valid = "FIELD" too')
        chosen = self._selector(f"{where}.source", layout, selector) if selector else None
        self._check_convert(where, row, layout, inputs)
        curve = self._curve(where, row)
        if len(self._problems) > before or unit is None:
            return None
        return MapEntry(
            channel=row.id,
            source=row.source if isinstance(row.source, str) else " ".join(row.source),
            message=message,
            selector=chosen,
            inputs=inputs,
            unit=unit,
            scale=row.scale,
            offset=row.offset,
            priority=row.priority,
            kind=row.kind,
            calibration=row.calibration,
            time=row.time,
            convert=row.convert,
            curve=curve,
            missing=tuple(row.missing),
            valid=row.valid,
            valid_from=row.valid_from,
        )

    def _unit(self, where: str, channel_id: str, unit: str, *, volts: bool) -> str | None:
        """Check channel and unit; return the unit as listed."""
        in_text = where.startswith("text.")
        try:
            spec = channel(channel_id)
        except UnknownNameError as error:
            self._report_error(where if in_text else f"{where}.id", error)
            return None
        try:
            if volts:
                find_signal(unit)
                return unit.strip()
            return normalize_unit(unit, spec.quantity)
        except UnitError as error:
            self._report_error(where if in_text else f"{where}.unit", error)
            return None

    def _check_calibration(self, where: str, row: _EntryTable) -> None:
        if row.calibration is None:
            return
        try:
            channel(row.calibration)
        except UnknownNameError as error:
            self._report_error(f"{where}.calibration", error)

    def _sources(
        self, where: str, source: str | list[str]
    ) -> tuple[str, str | None, tuple[FieldRef, ...]] | None:
        texts = [source] if isinstance(source, str) else source
        if not texts or not all(text.strip() for text in texts):
            column = "a column of the table" if self._table else "a field as MESSAGE.field"
            self._report(where, "is empty", f"name {column}, or remove the channel")
            return None
        if self._table:
            return TABLE, None, tuple(FieldRef(field=text) for text in texts)
        found: list[tuple[str, str | None]] = []
        inputs: list[FieldRef] = []
        for text in texts:
            line = _LINE.fullmatch(text.strip())
            match = _SOURCE.fullmatch(text.strip())
            if line is not None:
                found.append((LINE, None))
                inputs.append(FieldRef(field="", index=int(line["index"])))
            elif match is not None:
                found.append((match["message"], match["selector"]))
                index = match["index"]
                inputs.append(
                    FieldRef(field=match["field"], index=None if index is None else int(index))
                )
            else:
                self._report(
                    where,
                    f"'{text}' is not a source",
                    "write MESSAGE.field, MESSAGE[selector].field[index] or line[column]",
                )
                return None
        if len(set(found)) != 1:
            self._report(where, "uses fields of different messages", "use one message")
            return None
        message, selector = found[0]
        return message, selector, tuple(inputs)

    def _check_fields(
        self,
        where: str,
        layout: MessageLayout,
        inputs: tuple[FieldRef, ...],
        convert: str | None,
    ) -> tuple[FieldRef, ...]:
        """Check fields against the dialect; spread a whole array over the inputs of `convert`."""
        spread: list[FieldRef] = []
        for ref in inputs:
            if ref.field not in layout.fields:
                known = f"{layout.name} has {', '.join(layout.fields)}"
                remedy = did_you_mean(ref.field, layout.fields, known, most=2)
                self._report(where, f"{layout.name} has no field '{ref.field}'", remedy)
                continue
            length = layout.length(ref.field)
            if layout.is_text(ref.field):
                self._report(where, f"{ref.field} is text, not a number", "use another field")
            elif length == 0 and ref.index is not None:
                self._report(
                    where, f"{ref.field} is one number, not an array", f"leave [{ref.index}] out"
                )
            elif length and ref.index is None and convert is None:
                self._report(where, f"{ref.field} is an array of {length}", f"write {ref.field}[0]")
            elif ref.index is not None and ref.index >= length:
                self._report(
                    where,
                    f"index {ref.index} is out of range",
                    f"{ref.field} has {length} elements, 0 to {length - 1}",
                )
            elif length and ref.index is None:
                spread.extend(FieldRef(field=ref.field, index=i) for i in range(length))
                continue
            spread.append(ref)
        return tuple(spread)

    def _check_convert(
        self,
        where: str,
        row: _EntryTable,
        layout: MessageLayout | None,
        inputs: Sequence[FieldRef],
    ) -> None:
        if row.convert is None:
            if len(inputs) > 1:
                self._report(
                    f"{where}.source", "has several fields", "name a conversion: convert = ..."
                )
            return
        conversion = CONVERSIONS.get(row.convert)
        if conversion is None:
            known = f"known are {', '.join(CONVERSIONS)}"
            remedy = did_you_mean(row.convert, CONVERSIONS, known, most=1)
            self._report(f"{where}.convert", f"no conversion is called '{row.convert}'", remedy)
            return
        # Without a layout a single array field may hold all of the numbers.
        whole_array = layout is None and len(inputs) == 1 and inputs[0].index is None
        if len(inputs) != conversion.inputs and not whole_array:
            self._report(
                f"{where}.source",
                f"gives {len(inputs)} numbers, and {row.convert} takes {conversion.inputs}",
                conversion.meaning,
            )

    def _curve(self, where: str, row: _EntryTable) -> Curve | None:
        given = [key for key in ("table", "polynomial") if getattr(row, key)]
        if not given:
            return None
        others = [key for key in ("convert", "calibration") if getattr(row, key) is not None]
        if len(given) + len(others) > 1:
            names = " and ".join((*given, *others))
            self._report(f"{where}.{given[0]}", f"{names} exclude each other", "keep one of them")
        points = sorted(row.table)
        if given[0] == "table" and len({raw for raw, _ in points}) < max(len(points), 2):
            self._report(
                f"{where}.table",
                "has fewer than two points, or two for one raw value",
                "write [[raw, value], [raw, value]]",
            )
        return Curve(points=tuple(points), coefficients=tuple(row.polynomial))

    def _check_time(self, where: str, layout: MessageLayout, time: str | None) -> None:
        if time in (None, ARRIVAL):
            return
        if time not in layout.fields:
            remedy = did_you_mean(str(time), layout.fields, f'write time = "{ARRIVAL}"', most=1)
            self._report(f"{where}.time", f"{layout.name} has no field '{time}'", remedy)
        elif stamp_field_of(layout, str(time)) is None:
            self._report(
                f"{where}.time",
                f"{time} does not count milliseconds or microseconds",
                f'leave it out, or write time = "{ARRIVAL}"',
            )

    def _check_valid(self, where: str, layout: MessageLayout, valid: str | None) -> None:
        if valid is None or (
            valid in layout.fields and not layout.is_text(valid) and not layout.length(valid)
        ):
            return
        self._report(
            f"{where}.valid",
            f"{layout.name} has no number '{valid}'",
            did_you_mean(valid, layout.fields, "leave it out", most=1),
        )

    def _selector(self, where: str, layout: MessageLayout | None, text: str) -> Selector | None:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not equals:
            name, value = "", text.strip()
        if layout is None:
            return Selector(field=name, value=value)
        if not name:
            name = _selector_field(layout, number=value.isdigit())
        if not name or name not in layout.fields:
            named = f"has no field '{name}'" if name else "has no field that identifies the sender"
            self._report(
                where, f"{layout.name} {named}", f"leave [{text}] out, or write [field=value]"
            )
            return None
        if not layout.is_text(name) and not value.isdigit():
            self._report(
                where, f"{layout.name} is selected by {name}, a number", f"not by '{value}'"
            )
            return None
        return Selector(field=name, value=value)

    def _check_priorities(self, entries: Sequence[tuple[str, MapEntry]]) -> None:
        seen: dict[tuple[str, int], str] = {}
        for where, entry in entries:
            first = seen.setdefault((entry.channel, entry.priority), where)
            if first != where:
                key = where if where.startswith("text.") else f"{where}.priority"
                self._report(
                    key,
                    f"'{entry.channel}' already has a source of priority {entry.priority}, "
                    f"in {first}",
                    "give each source of a channel its own priority; lower is first",
                )


def _guess_format(raw: Mapping[str, Any]) -> str | None:
    written = raw.get("format", "mavlink")
    near = close_matches(str(written), get_args(Format), most=1)
    return near[0] if near else None


def _selector_field(layout: MessageLayout, *, number: bool) -> str:
    if not number and "name" in layout.fields:
        return "name"
    candidates = (layout.instance_field, "index", "id", "instance", "name")
    for name in candidates:
        if name is not None and name in layout.fields and not (number and layout.is_text(name)):
            return name
    return "name" if "name" in layout.fields else ""


def _prefix_problem(where: str, problem: FileProblem) -> FileProblem:
    inner = where if problem.where == "file" else f"{where}.{problem.where}"
    return FileProblem(where=inner, what=problem.what, remedy=problem.remedy)

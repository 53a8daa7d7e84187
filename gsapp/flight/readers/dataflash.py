"""ArduPilot's on-board log, ``.bin`` or text: records that describe themselves.

Every record begins with ``A3 95`` and a type. Type 128 (FMT) gives the length, name, format and
columns of another type; FMTU, UNIT and MULT add units, multipliers and which column numbers the
instance. There is no checksum: a record counts as whole if another header, or the end of the
file, follows it. Format letters and the meaning of multipliers: ArduPilot, libraries/AP_Logger,
LogStructure.h.
"""

from __future__ import annotations

import contextlib
import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from gsapp.decoding.flight_modes import ardupilot_mode
from gsapp.flight.events import Event
from gsapp.flight.parameter_events import parameter_events
from gsapp.flight.readers.boot_clock import BootClock, IndexArray, MessageKey, RecordTimes
from gsapp.flight.readers.dataflash_text import TEXT_LETTERS, is_text_log, scan_text
from gsapp.flight.readers.log_tables import ForeignLog, LazyFields, LogTable, gather_records
from gsapp.foundation import FlightError

_HEADER = b"\xa3\x95"
_FMT = 128
_FMT_LENGTH = 89

_HEADER_FIELD = "_header"
_STAMPS = {"TimeUS": 1e-6, "TimeMS": 1e-3}
"""Columns that hold the time, and the seconds of one count."""
_NOT_MEASURED = frozenset({"FMT", "FMTU", "UNIT", "MULT", "PARM", "MSG"})

# Letter: type in the file, and the factor that the letter itself implies.
_LETTERS: dict[str, tuple[Any, float]] = {
    "a": (("<i2", (32,)), 1.0),
    "b": ("i1", 1.0),
    "B": ("u1", 1.0),
    "g": ("<f2", 1.0),
    "h": ("<i2", 1.0),
    "H": ("<u2", 1.0),
    "i": ("<i4", 1.0),
    "I": ("<u4", 1.0),
    "f": ("<f4", 1.0),
    "d": ("<f8", 1.0),
    "n": ("S4", 1.0),
    "N": ("S16", 1.0),
    "Z": ("S64", 1.0),
    "c": ("<i2", 1e-2),
    "C": ("<u2", 1e-2),
    "e": ("<i4", 1e-2),
    "E": ("<u4", 1e-2),
    "L": ("<i4", 1e-7),
    "M": ("u1", 1.0),
    "q": ("<i8", 1.0),
    "Q": ("<u8", 1.0),
}

# What the log calls units, where it differs from the vocabulary.
_UNIT_NAMES = {
    "m/s/s": "m/s^2",
    "degheading": "deg",
    "deglatitude": "deg",
    "deglongitude": "deg",
    "deg/s/s": "deg/s^2",
    "rad/s/s": "rad/s^2",
    "RPM": "rpm",
    "Pa": "Pa",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class _Format:
    """What one FMT record says."""

    type: int
    length: int
    name: str
    letters: str
    columns: tuple[str, ...]
    scaled: bool = False
    """Whether the factors of the letters are in the values already."""

    @property
    def dtype(self) -> np.dtype[np.void] | None:
        """Return the type of a whole record; None if it does not fit its stated length."""
        if len(self.letters) != len(self.columns) or any(c not in _LETTERS for c in self.letters):
            return None
        if len({_HEADER_FIELD, *self.columns}) != 1 + len(self.columns):
            return None
        fields: list[Any] = [(_HEADER_FIELD, "S3")]
        for column, letter in zip(self.columns, self.letters, strict=True):
            kind = _LETTERS[letter][0]
            fields.append((column, *kind) if isinstance(kind, tuple) else (column, kind))
        whole: np.dtype[np.void] = np.dtype(fields)
        return whole if whole.itemsize == self.length else None


_Records = dict[str, tuple[_Format, npt.NDArray[np.void], IndexArray]]
"""Format, values, and where each stands in the file, by name of the message."""


def read_dataflash(path: Path | str) -> ForeignLog:
    """Read an ArduPilot log: all messages that are measured; texts, modes and parameters as events.

    A ``.bin``, or the text that ground stations make of it, whatever the ending says. Damaged
    stretches are passed over and remarked on. Values are in the units that the log states: raw
    value times the multiplier of FMTU where there is one, else times the factor of the format
    letter.
    """
    file = Path(path)
    try:
        data = file.read_bytes()
    except OSError as error:
        raise FlightError(
            f"{file} cannot be read ({error.strerror}); check the path and the permissions"
        ) from error
    if not data:
        raise FlightError(f"{file} is empty; copy the log from the aircraft again")
    return _read_text(file, data) if is_text_log(data) else _read(file, data)


def _read_text(file: Path, data: bytes) -> ForeignLog:
    messages, lost = scan_text(data)
    records: _Records = {}
    for name, message in messages.items():
        if not _LETTERS.keys() >= set(message.letters):
            lost += len(message.lines)
            continue
        rows, places = message.rows()
        form = _Format(
            type=message.type,
            length=0,
            name=name,
            letters=message.letters,
            columns=message.columns,
            scaled=True,
        )
        records[name] = form, rows, places
        lost += len(message.lines) - places.size
    remarks = [f"{lost} lines of {file.name} were damaged and skipped"] if lost else []
    return _log_of(file, records, remarks)


def _read(file: Path, data: bytes) -> ForeignLog:
    positions, formats, lost, torn = _scan(data)
    if len(formats) < 2:
        raise FlightError(
            f"{file} holds no format descriptions; not an ArduPilot log, or its start is "
            "missing; download it again, or name another file"
        )
    records = {
        formats[kind].name: (
            formats[kind],
            gather_records(data, places, dtype),
            np.array(places, dtype=np.int64),
        )
        for kind, places in positions.items()
        if kind in formats and (dtype := formats[kind].dtype) is not None
    }
    remarks: list[str] = []
    if torn:
        remarks.append(f"the last record of {file.name} is incomplete and was skipped")
    if lost:
        remarks.append(f"{lost} bytes of {file.name} were damaged and skipped")
    return _log_of(file, records, remarks)


def _log_of(file: Path, records: _Records, remarks: list[str]) -> ForeignLog:
    groups = _instance_groups(records)
    clock = BootClock.of({key: group.stated_times() for key, group in groups.items()})
    tables = {
        key: group.table(clock.times[key])
        for key, group in groups.items()
        if key[0] not in _NOT_MEASURED
    }
    events = _events(groups, clock)
    vehicle = _vehicle([event.text for event in events if event.kind == "status"])
    return ForeignLog(
        path=file,
        tables=tables,
        events=events,
        remarks=tuple(remarks),
        vehicle="" if vehicle == "plane" else vehicle,
    )


def _scan(
    data: bytes,
) -> tuple[dict[int, list[int]], dict[int, _Format], int, bool]:
    """Find all whole records: places by type, formats, bytes lost, whether the end is torn."""
    lengths = [0] * 256
    lengths[_FMT] = _FMT_LENGTH
    formats: dict[int, _Format] = {}
    positions: dict[int, list[int]] = {}
    size, place, lost = len(data), 0, 0
    while place < size:
        if not _is_whole_record(data, place, lengths):
            follows = _next_whole_record(data, place + 1, lengths)
            if follows == size and _is_cut_short(data, place, lengths):
                return positions, formats, lost, True
            lost += follows - place
            place = follows
            continue
        kind = data[place + 2]
        after = place + lengths[kind]
        positions.setdefault(kind, []).append(place)
        if kind == _FMT:
            form = _format(data[place + 3 : after])
            # A damaged one may describe descriptions themselves otherwise.
            if form is not None and (form.type != _FMT or form.length == _FMT_LENGTH):
                formats[form.type] = form
                lengths[form.type] = form.length
        place = after
    return positions, formats, lost, False


def _is_whole_record(data: bytes, place: int, lengths: list[int]) -> bool:
    """Return whether a whole record stands at `place`.

    It does if another header, or the end, follows it; with stray bytes behind it, it does if no
    header stands inside it, as one would had the record lost bytes.
    """
    if data[place : place + 2] != _HEADER or place + 2 >= len(data):
        return False
    length = lengths[data[place + 2]]
    left = len(data) - place - length
    if not length or left < 0:
        return False
    if data[place + length : place + length + 2] == _HEADER[:left]:
        return True
    inside = data.find(_HEADER, place + 1, place + length + 1)
    while 0 <= inside < len(data) - 2:
        if lengths[data[inside + 2]]:
            return False
        inside = data.find(_HEADER, inside + 1, place + length + 1)
    return True


def _next_whole_record(data: bytes, start: int, lengths: list[int]) -> int:
    index = data.find(_HEADER, start)
    while index >= 0 and not _is_whole_record(data, index, lengths):
        index = data.find(_HEADER, index + 1)
    return index if index >= 0 else len(data)


def _is_cut_short(data: bytes, place: int, lengths: list[int]) -> bool:
    """Return whether the end of the file cuts off what begins at `place` as a record does."""
    rest = data[place : place + 3]
    if len(rest) < 3:
        return rest == _HEADER[: len(rest)]
    return rest[:2] == _HEADER and place + lengths[rest[2]] > len(data)


def _format(payload: bytes) -> _Format | None:
    kind, length, name, letters, columns = struct.unpack("<BB4s16s64s", payload)
    if length < 3:
        return None
    try:
        return _Format(
            type=kind,
            length=length,
            name=_text(name),
            letters=_text(letters),
            columns=tuple(part for part in _text(columns).split(",") if part),
        )
    except UnicodeDecodeError:
        return None


def _text(data: bytes) -> str:
    return data.split(b"\0")[0].decode("ascii")


@dataclass(frozen=True, slots=True, kw_only=True)
class _Scales:
    """What UNIT, MULT and FMTU say: ids to units and factors, types to their ids."""

    units: dict[str, str]
    factors: dict[str, float]
    columns: dict[int, tuple[str, str]]

    @staticmethod
    def of(records: _Records) -> _Scales:
        """Collect them from the records of a log; old logs have none."""
        units: dict[str, str] = {}
        factors: dict[str, float] = {}
        columns: dict[int, tuple[str, str]] = {}
        with contextlib.suppress(KeyError, ValueError):
            for row in records["UNIT"][1]:
                label = bytes(row["Label"]).decode("latin-1")
                units[chr(int(row["Id"]) & 0x7F)] = _UNIT_NAMES.get(label, label)
        with contextlib.suppress(KeyError, ValueError):
            for row in records["MULT"][1]:
                # ArduPilot computes in single precision and stores that as a double: what it
                # means by 1.0000000117e-07 is 1e-07, which is 5 cm of latitude.
                factors[chr(int(row["Id"]) & 0x7F)] = float(f"{row['Mult']:.7g}")
        with contextlib.suppress(KeyError, ValueError):
            for row in records["FMTU"][1]:
                columns[int(row["FmtType"])] = (
                    bytes(row["UnitIds"]).decode("latin-1"),
                    bytes(row["MultIds"]).decode("latin-1"),
                )
        return _Scales(units=units, factors=factors, columns=columns)

    def factor(self, form: _Format, column: int) -> float:
        """Return what the raw value is multiplied by.

        A multiplier that is zero or not given leaves the format letter's own factor. It is the
        only factor where it is given, since it speaks of the raw value.
        """
        _, ids = self.columns.get(form.type, ("", ""))
        stated = self.factors.get(ids[column], 0.0) if column < len(ids) else 0.0
        of_letter = _LETTERS[form.letters[column]][1]
        # '?' says that nobody has told; ArduPilot writes 1 for it.
        factor = stated if stated and ids[column] != "?" else of_letter
        return factor / of_letter if form.scaled else factor

    def unit(self, form: _Format, column: int) -> str:
        ids, _ = self.columns.get(form.type, ("", ""))
        return self.units.get(ids[column], "") if column < len(ids) else ""

    def instance_column(self, form: _Format) -> str | None:
        """Return the column that numbers the sensor."""
        ids, _ = self.columns.get(form.type, ("", ""))
        index = ids.find("#")
        return form.columns[index] if 0 <= index < len(form.columns) else None


def _holds_number(rows: npt.NDArray[np.void], column: str) -> bool:
    """Return whether records have a column of that name with one number in each."""
    fields: Mapping[str, Any] = rows.dtype.fields or {}
    return column in fields and fields[column][0].kind in "iuf"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Group:
    """The records of one message and instance."""

    form: _Format
    rows: npt.NDArray[np.void]
    places: npt.NDArray[np.int64]
    scales: _Scales
    selector: str

    def stated_times(self) -> RecordTimes:
        for stamp, unit in _STAMPS.items():
            if _holds_number(self.rows, stamp):
                return RecordTimes(places=self.places, times=self.rows[stamp] * unit)
        return RecordTimes(
            places=self.places, times=np.full(self.places.size, np.nan), stamped=False
        )

    def table(self, placed: RecordTimes) -> LogTable:
        form, rows = self.form, self.rows[placed.valid]
        numbers = {
            column: index
            for index, column in enumerate(form.columns)
            if form.letters[index] not in TEXT_LETTERS
        }
        units = {name: self.scales.unit(form, index) for name, index in numbers.items()}
        label = f"{form.name}[{self.selector}]" if self.selector else form.name
        return LogTable(
            times=placed.times[placed.valid],
            fields=LazyFields(
                numbers,
                lambda name: (
                    rows[name].astype(np.float64) * self.scales.factor(form, numbers[name])
                ),
            ),
            units={name: unit for name, unit in units.items() if unit},
            by_order=placed.by_order,
            remark=placed.remark(label),
        )


def _instance_groups(records: _Records) -> dict[MessageKey, _Group]:
    """Return the records by name and instance number, as text; empty where they have none."""
    scales = _Scales.of(records)
    groups: dict[MessageKey, _Group] = {}
    for name, (form, rows, places) in records.items():
        instance = scales.instance_column(form)
        chosen: dict[str, Any] = {"": slice(None)}
        if instance is not None and _holds_number(rows, instance):
            numbers = rows[instance]
            known = np.unique(numbers[np.isfinite(numbers)]).tolist()
            chosen = {str(int(number)): numbers == number for number in known}
        for selector, which in chosen.items():
            groups[name, selector] = _Group(
                form=form,
                rows=rows[which],
                places=places[which],
                scales=scales,
                selector=selector,
            )
    return groups


def _events(groups: Mapping[MessageKey, _Group], clock: BootClock) -> tuple[Event, ...]:
    """Return texts (MSG), flight modes and parameters as events."""
    said = [(time, _words(row["Message"])) for time, row in _rows(groups, clock, "MSG", "Message")]
    vehicle = _vehicle([text for _, text in said])
    modes: list[Event] = []
    for time, row in _rows(groups, clock, "MODE", "Mode"):
        named = row["Mode"]
        if not (isinstance(named, bytes) or np.isfinite(named)):
            continue
        mode = _words(named) if isinstance(named, bytes) else ardupilot_mode(int(named), vehicle)
        if not modes or modes[-1].text != f"Flight mode {mode}":
            modes.append(Event(kind="mode", text=f"Flight mode {mode}", time=time))
    parameters = [
        (time, _words(row["Name"]), float(row["Value"]))
        for time, row in _rows(groups, clock, "PARM", "Name", "Value")
        if _holds_number(row, "Value")
    ]
    return (
        *(Event(kind="status", text=text, time=time) for time, text in said),
        *modes,
        *parameter_events(parameters),
    )


def _rows(
    groups: Mapping[MessageKey, _Group], clock: BootClock, name: str, *columns: str
) -> Iterator[tuple[float | None, npt.NDArray[np.void]]]:
    """Yield the records of a message that has these columns, with their times (s) if known."""
    found = groups.get((name, ""))
    if found is not None and set(columns) <= set(found.form.columns):
        yield from zip(clock.event_times(found.stated_times()), found.rows, strict=True)


def _words(text: Any) -> str:
    return bytes(text).decode("utf-8", "replace")


def _vehicle(texts: Sequence[str]) -> str:
    """Return what kind of vehicle a log is of, by what it says when it starts."""
    for text in texts:
        for vehicle in ("plane", "copter", "rover", "sub"):
            if vehicle in text.casefold().partition(" ")[0]:
                return vehicle
    return "plane"

"""PX4's on-board log, ``.ulg``.

A message is two bytes of length, one of its type, and so many bytes. Types ``F`` and ``A`` describe
topics and number them; ``D`` is a sample of one. There is no checksum: a sample counts as whole if
it has the length of its topic, another message if one follows it. The format: PX4 user guide, "ULog
file format".
"""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from gsapp.decoding.flight_modes import px4_state
from gsapp.flight.events import Event
from gsapp.flight.parameter_events import parameter_events
from gsapp.flight.readers.boot_clock import BootClock, IndexArray, MessageKey, RecordTimes
from gsapp.flight.readers.log_tables import ForeignLog, LazyFields, LogTable, gather_records
from gsapp.foundation import FlightError
from gsapp.quantities import FloatArray

_MAGIC = b"ULog\x01\x12\x35"
_STATUS = "vehicle_status"
"""Topic that holds the flight mode."""
_START = 16
"""Bytes before the first message."""
_HEAD = struct.Struct("<HBH")
"""Length and type of a message; the number of its topic where it is a sample."""
_SAMPLE = ord("D")
_KINDS = frozenset(b"ABCDFILMOPQRS")
_APPENDED = struct.Struct("<HB8xB7x3Q")
"""The message of flags: whether data were appended after a crash, and where."""
_TEXTS = {ord("L"): 1, ord("C"): 3}
"""Messages that say something: where their time of eight bytes begins; the text follows it."""
_CLOCK = "timestamp"
_PADDING = "_padding"
_HEAD_FIELD = "_head"
_LARGEST_STATE = 256
_DEEPEST = 8  # Formats inside formats.
_MOST_FIELDS = 65535  # Of one byte each: no message is longer.
_FIELD = re.compile(r"(?P<type>\w+)(?:\[(?P<count>[0-9]{1,5})\])? +(?P<name>\w+)")
_TYPES = {
    "int8_t": "i1", "uint8_t": "u1", "int16_t": "<i2", "uint16_t": "<u2", "int32_t": "<i4",
    "uint32_t": "<u4", "int64_t": "<i8", "uint64_t": "<u8", "float": "<f4", "double": "<f8",
    "bool": "?", "char": "S1",
}  # fmt: skip


def read_ulog(path: Path | str) -> ForeignLog:
    """Read a PX4 ``.ulg`` log: one table for each topic and instance.

    A torn end and damaged stretches are passed over and remarked on.
    """
    file = Path(path)
    try:
        data = file.read_bytes()
    except OSError as error:
        raise FlightError(
            f"{file} cannot be read ({error.strerror}); check the path and the permissions"
        ) from error
    if len(data) < _START or not data.startswith(_MAGIC):
        raise FlightError(f"{file} is not a PX4 .ulg log; download it again, or name another file")
    scan = _Scan(data)
    remarks: list[str] = []
    if scan.damaged:
        remarks.append(f"parts of {file.name} were damaged and skipped")
    elif scan.torn:
        remarks.append(f"the last message of {file.name} is incomplete and was skipped")
    if scan.dropouts:
        often = "once" if len(scan.dropouts) == 1 else f"{len(scan.dropouts)} times"
        remarks.append(
            f"the logger of {file.name} dropped out {often}, "
            f"{sum(scan.dropouts) / 1000.0:.1f} s in all"
        )
    records = scan.records()
    clock = BootClock.of({topic: samples.stated_times() for topic, samples in records.items()})
    tables = {topic: one.table(topic, clock.times[topic]) for topic, one in records.items()}
    return ForeignLog(
        path=file,
        tables=tables,
        events=(*_text_events(scan, clock), *_modes(tables), *_parameters(scan, clock)),
        remarks=tuple(remarks),
        vehicle=_vehicle(tables.get((_STATUS, "0"))),
    )


def _modes(tables: Mapping[tuple[str, str], LogTable]) -> Iterator[Event]:
    """Yield the changes of the navigation state."""
    table = tables.get((_STATUS, "0"))
    states = None if table is None else _state_numbers(table, "nav_state")
    if table is None or states is None:
        return
    changed = np.flatnonzero(np.diff(states, prepend=-1.0))
    for time, state in zip(table.times[changed].tolist(), states[changed].tolist(), strict=True):
        yield Event(kind="mode", text=f"Flight mode {px4_state(int(state))}", time=time)


def _state_numbers(table: LogTable, name: str) -> FloatArray | None:
    """Return a field of one number in each sample, -1 for what is none; None for any other."""
    values = table.fields.get(name)
    if values is None or values.ndim != 1:
        return None
    return np.where(np.abs(values) < _LARGEST_STATE, values, -1.0)


def _parameters(scan: _Scan, clock: BootClock) -> tuple[Event, ...]:
    values: list[tuple[float | None, str, float]] = []
    places = np.array(scan.parameters, dtype=np.int64)
    times = clock.event_times(RecordTimes(places=places, times=np.full(places.size, np.nan)))
    for place, time in zip(scan.parameters, times, strict=True):
        length = scan.data[place] | scan.data[place + 1] << 8
        start = place + 4 + scan.data[place + 3]
        kind, _, name = scan.data[place + 4 : start].decode("ascii", "replace").partition(" ")
        form = {"int32_t": "<i", "float": "<f"}.get(kind)
        if form is not None and start + 4 == place + 3 + length:
            values.append((time, name, float(struct.unpack_from(form, scan.data, start)[0])))
    return parameter_events(values)


def _vehicle(status: LogTable | None) -> str:
    """Return what PX4 last flew as; empty for an airplane, or if unknown."""
    if status is None or not status.times.size:
        return ""
    # Both are 1 for rotors; the name changed from release to release.
    rotors = _state_numbers(status, "vehicle_type")
    if rotors is None:
        rotors = _state_numbers(status, "is_rotary_wing")
    hybrid = _state_numbers(status, "is_vtol")
    if rotors is None or rotors[-1] != 1 or (hybrid is not None and hybrid[-1]):
        return ""
    return "copter"


class _Scan:
    """Finds all messages of a log.

    Attributes
    ----------
    texts, parameters, dropouts : list of int
        Where texts and parameters begin; how long the logger paused, ms.
    torn, damaged : bool
        Whether the end is cut off; whether bytes were passed over.
    """

    def __init__(self, data: bytes) -> None:
        self.data = data
        self.texts: list[int] = []
        self.dropouts: list[int] = []
        self.parameters: list[int] = []
        self.torn = self.damaged = False
        self._formats: dict[str, str] = {}
        self._spread: dict[tuple[str, int], list[tuple[Any, ...]]] = {}
        self._topics: dict[int, tuple[MessageKey, np.dtype[np.void]]] = {}
        self._unread_topics: dict[int, tuple[int, int]] = {}
        self._samples: dict[int, list[int]] = {}
        # By number of the topic: bytes of a sample behind the head, and what takes its place.
        self._lengths = [-1] * 65536
        self._take: list[Callable[[int], None]] = [self.texts.append] * 65536
        self._readers: dict[int, Callable[[int, int], None]] = {
            ord("F"): self._read_format,
            ord("A"): self._note_topic,
            ord("O"): self._read_dropout,
            ord("P"): lambda place, _: self.parameters.append(place),
            **dict.fromkeys(_TEXTS, lambda place, _: self.texts.append(place)),
        }
        for start, end in _segments(data):
            self.torn = self._scan(start, end)

    def _scan(self, start: int, end: int) -> bool:
        """Find the messages of a stretch; return whether its last one is cut off."""
        data, lengths, take, unpack = self.data, self._lengths, self._take, _HEAD.unpack_from
        place, last = start, end - _HEAD.size
        while place <= last:
            length, kind, topic = unpack(data, place)
            after = place + 3 + length
            if kind == _SAMPLE and length == lengths[topic]:
                if after > end:
                    return True
                take[topic](place)
            elif self._is_message(kind, after, end):
                reader = self._readers.get(kind)
                if reader is not None and length > 1:
                    reader(place, after)
            elif kind == _SAMPLE and topic in self._unread_topics:
                self._read_topic(topic, *self._unread_topics.pop(topic))
                continue
            else:
                follows = self._next_sample(place + 1, end)
                if follows == end and kind in _KINDS and after > end and kind != _SAMPLE:
                    return True
                self.damaged = True
                after = follows
            place = after
        return place < end

    def _is_message(self, kind: int, after: int, end: int) -> bool:
        """Return whether another message than a sample can end at a place."""
        if kind not in _KINDS or kind == _SAMPLE or after > end:
            return False
        return after + 2 >= end or self.data[after + 2] in _KINDS

    def _next_sample(self, start: int, end: int) -> int:
        """Return where the next sample begins in a damaged stretch, or its end."""
        data, unpack = self.data, _HEAD.unpack_from
        found = data.find(b"D", start + 2, end - 2)
        while found >= 0:
            length, _, topic = unpack(data, found - 2)
            if length == self._lengths[topic]:
                return found - 2
            found = data.find(b"D", found + 1, end - 2)
        return end

    def _read_format(self, place: int, after: int) -> None:
        name, _, fields = self.data[place + 3 : after].decode("ascii", "replace").partition(":")
        self._formats[name] = fields
        self._spread.clear()

    def _read_dropout(self, place: int, _: int) -> None:
        self.dropouts.append(self.data[place + 3] | self.data[place + 4] << 8)

    def _note_topic(self, place: int, after: int) -> None:
        if after - place >= 7:
            number = self.data[place + 4] | self.data[place + 5] << 8
            self._unread_topics[number] = place, after
            self._lengths[number] = -1

    def _read_topic(self, number: int, place: int, after: int) -> None:
        """Learn what samples of a topic look like, when the first comes: of most there are none."""
        name = self.data[place + 6 : after].decode("ascii", "replace")
        fields = list(self._fields(name))
        while fields and fields[-1][0].startswith(_PADDING):
            fields.pop()  # the logger leaves these out
        names = [one[0] for one in fields]
        if not 0 < len(names) <= _MOST_FIELDS or len({_HEAD_FIELD, *names}) <= len(names):
            return
        dtype: np.dtype[np.void] = np.dtype([(_HEAD_FIELD, f"V{_HEAD.size}"), *fields])
        self._topics[number] = (name, str(self.data[place + 3])), dtype
        self._lengths[number] = dtype.itemsize - 3
        self._take[number] = self._samples.setdefault(number, []).append

    def _fields(self, form: str, depth: int = 0) -> list[tuple[Any, ...]]:
        """Return name, type and count of a format's fields, those of formats inside it spread.

        One more than a message holds at most: damaged formats contain themselves.
        """
        if (form, depth) in self._spread:
            return self._spread[form, depth]
        fields: list[tuple[Any, ...]] = []
        for text in self._formats.get(form, "").split(";"):
            match = _FIELD.fullmatch(text.strip())
            if match is None:
                continue
            kind, count, name = match["type"], int(match["count"] or 0), match["name"]
            if kind in _TYPES:
                fields.append((name, _TYPES[kind], count) if count else (name, _TYPES[kind]))
            elif depth < _DEEPEST and (inner := self._fields(kind, depth + 1)):
                for index in range(count or 1):
                    prefix = f"{name}[{index}]." if count else f"{name}."
                    fields += [(prefix + one, *rest) for one, *rest in inner]
                    if len(fields) > _MOST_FIELDS:
                        break
        self._spread[form, depth] = fields[: _MOST_FIELDS + 1]
        return self._spread[form, depth]

    def records(self) -> dict[MessageKey, _Samples]:
        """Return the samples of each topic that has any."""
        gathered: dict[MessageKey, tuple[np.dtype[np.void], list[int]]] = {}
        for number, (topic, dtype) in self._topics.items():
            # A topic that was given a second number goes on under it.
            first, places = gathered.setdefault(topic, (dtype, []))
            if dtype == first:
                places += self._samples[number]
        return {
            topic: _Samples(data=self.data, places=np.array(sorted(places)), dtype=dtype)
            for topic, (dtype, places) in gathered.items()
            if places
        }


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Samples:
    """The samples of one topic."""

    data: bytes
    places: IndexArray
    """Where each begins."""
    dtype: np.dtype[np.void]

    def stated_times(self) -> RecordTimes:
        places = self.places
        fields: Mapping[str, Any] = self.dtype.fields or {}
        kind, offset = fields.get(_CLOCK, (np.dtype("S1"), 0))[:2]
        if kind.kind not in "iuf":  # none, or an array
            return RecordTimes(places=places, times=np.full(places.size, np.nan), stamped=False)
        # 0 says that nothing was published.
        stamps = gather_records(self.data, places + offset, kind)
        return RecordTimes(places=places, times=np.where(stamps > 0, stamps * 1e-6, np.nan))

    def table(self, topic: MessageKey, placed: RecordTimes) -> LogTable:
        places = self.places[placed.valid]
        rows: list[npt.NDArray[Any]] = []

        def load(name: str) -> FloatArray:
            rows[:] = rows or [gather_records(self.data, places, self.dtype)]
            return rows[0][name].astype(np.float64)

        names = [
            name
            for name, (kind, *_) in (self.dtype.fields or {}).items()
            if name not in (_CLOCK, _HEAD_FIELD) and kind.base.kind in "fiub"
        ]
        return LogTable(
            times=placed.times[placed.valid],
            fields=LazyFields(names, load),
            by_order=placed.by_order,
            remark=placed.remark("{}[{}]".format(*topic)),
        )


def _segments(data: bytes) -> Iterator[tuple[int, int]]:
    """Yield start and end of the stretches of a log: what a crash left was appended later."""
    starts = [_START]
    if len(data) >= _START + _APPENDED.size:
        _, kind, flags, *offsets = _APPENDED.unpack_from(data, _START)
        if kind == ord("B") and flags & 1:
            starts += sorted(offset for offset in offsets if _START < offset < len(data))
    yield from zip(starts, [*starts[1:], len(data)], strict=True)


def _text_events(scan: _Scan, clock: BootClock) -> tuple[Event, ...]:
    data = scan.data
    texts: list[str] = []
    stamps: list[int] = []
    for place in scan.texts:
        length, kind, _ = _HEAD.unpack_from(data, place)
        start = place + 3 + _TEXTS[kind]
        stamps.append(int.from_bytes(data[start : start + 8], "little"))
        texts.append(data[start + 8 : place + 3 + length].decode("utf-8", "replace"))
    times = clock.event_times(
        RecordTimes(places=np.array(scan.texts, dtype=np.int64), times=np.array(stamps) * 1e-6)
    )
    return tuple(
        Event(kind="status", text=text, time=time) for text, time in zip(texts, times, strict=True)
    )

"""From raw records to blocks on the grid of flight time.

What comes out is a function of the records alone, however they are fed: all at once from a file,
or a few at a time from a link. A row is handed out as soon as the next sample of its message is
there.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, NamedTuple, Protocol, cast

import numpy as np

from calibration import Certificate, load_certificates
from gsapp.aircraft import Aircraft
from gsapp.decoding.channel_map import ARRIVAL, LINE, ChannelMap, MapEntry
from gsapp.decoding.flight_clock import FlightClock
from gsapp.decoding.grid import Numbers
from gsapp.decoding.health import (
    AUTOPILOT_COMPONENT,
    FIRST_GROUND_SYSTEM,
    HEARTBEAT_ID,
    RADIO_MESSAGES,
    LinkHealth,
    is_vehicle,
)
from gsapp.decoding.landed_state import STATE_MESSAGES, LandedState
from gsapp.decoding.message_stream import MessageColumns, MessageStream
from gsapp.decoding.messages import (
    StampField,
    decode_columns,
    is_known,
    message_id,
    message_layout,
    message_name,
    number_reader,
    stamp_field_of,
)
from gsapp.decoding.pipeline import ChannelSource, Pipeline
from gsapp.decoding.status_text import StatusText, StatusTextAssembler
from gsapp.foundation import FlightError
from gsapp.foundation.number_parsing import parse_finite_number
from gsapp.quantities import Block

_STATUSTEXT = 253
_SYSTEM_TIME = 2
_MANY = 1000
_GIVE_UP_EVERY = 30_000_000
_AUTOPILOT_PATIENCE = 3_000_000
"""How long measurements of other components wait for an autopilot, us: it sends a heartbeat every
second."""


class RawRecordLike(Protocol):
    """What is fed: a `gsapp.flight.raw_record.RawRecord`, or anything like it."""

    @property
    def stamp_us(self) -> int:
        """Host time of arrival, microseconds since 1970."""

    @property
    def kind(self) -> str:
        """``frame``, ``line`` or ``residue``."""

    @property
    def data(self) -> bytes:
        """The bytes."""


NOTICE_KINDS: Final = frozenset({
    "restart", "step", "outlier", "other-clock", "frozen-clock", "no-clock", "host-step",
    "other-system", "other-component", "unknown-message", "bad-line",
})  # fmt: skip
"""Kinds of notices about what was recorded, beside what the vehicle says itself."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Notice:
    """Something said by the vehicle, or noticed about it, while decoding.

    Attributes
    ----------
    kind : str
        ``statustext`` for what the vehicle says; ``restart``, ``step``, ``outlier``,
        ``other-clock``, ``frozen-clock``, ``no-clock``, ``host-step`` of its clock (see
        `gsapp.decoding.flight_clock.ClockEvent`); ``other-system``, ``other-component``,
        ``unknown-message``, ``bad-line`` of what was left out.
    time : float or None
        Flight time, s; None if no clock was known yet.
    stamp_us : int
        Host time of the record, microseconds since 1970.
    text : str
        In words.
    severity : int or None
        MAVLink's severity, 0 emergency to 7 debug, of what the vehicle says.
    system, component : int or None
        Who.
    """

    kind: str
    time: float | None
    stamp_us: int
    text: str
    severity: int | None = None
    system: int | None = None
    component: int | None = None


class _Route(NamedTuple):
    """How frames of one message reach one stream."""

    stream: int
    message: str
    select_at: slice | None
    selected: bytes
    stamp_at: slice | None
    stamp_scale: int
    stamp_period: int


class _Pending:
    """Samples of one stream since the last pull."""

    __slots__ = ("items", "nows", "times")

    def __init__(self) -> None:
        self.times: list[int] = []
        self.nows: list[int] = []
        self.items: list[bytes | list[float]] = []


class Decoder:
    """Decodes raw records of one aircraft, the flown one, with a channel map.

    That is the system chosen, or else the first whose autopilot is heard: by its heartbeat, or by
    any other message of component 1. In a record without an autopilot it is the first system that
    sends a mapped message. Once found it stays. Ground stations are never flown.

    Parameters
    ----------
    channel_map : ChannelMap
        Which field is which channel; of format ``mavlink``.
    certificates : mapping of str to Certificate, optional
        Calibration in force, by channel; else the shipped set that the map names. A calibrated
        source without its certificate yields volts only.
    aircraft : Aircraft, optional
        For the ranges of its instruments: samples at their ends are counted in `clipped`.
    rate : float, optional
        Rows per second.
    system : int, optional
        The flown system; else that of the channel map, or the first autopilot heard.

    Attributes
    ----------
    sources : dict of str to ChannelSource
        Every channel that it can yield, and where it comes from.
    health : LinkHealth
        Counts of the link.
    messages : list of Notice
        What the vehicle said (STATUSTEXT).
    notices : list of Notice
        What was noticed: restarts, outliers, other aircraft, unknown messages.
    clock : FlightClock
        Flight time and host time.
    landed_state : LandedState
        What the autopilot reports of flight and ground.
    unknown : Counter of int
        Frames of each message id that the dialect does not have.
    data_stamp : int or None
        Host time of the last frame or line that was decoded, microseconds since 1970.

    Raises
    ------
    FlightError
        If the map is for files, not for a link.
    """

    def __init__(
        self,
        channel_map: ChannelMap,
        *,
        certificates: Mapping[str, Certificate] | None = None,
        aircraft: Aircraft | None = None,
        rate: float = 100.0,
        system: int | None = None,
    ) -> None:
        if channel_map.format != "mavlink":
            raise FlightError(
                f"the channel map '{channel_map.name}' is for files of format "
                f"{channel_map.format}; choose one for a link, such as b777 or ardupilot-plane"
            )
        if certificates is None:
            name = channel_map.certificates
            certificates = load_certificates(name) if name else {}
        self.channel_map = channel_map
        self.health = LinkHealth()
        self.clock = FlightClock()
        self.messages: list[Notice] = []
        self.notices: list[Notice] = []
        self.unknown: Counter[int] = Counter()
        self.lines = 0
        self.bad_lines = 0
        self._pipeline = Pipeline(
            channel_map,
            certificates=certificates,
            aircraft=aircraft,
            rate=rate,
            vehicle_time=self._has_vehicle_time,
        )
        self.sources: dict[str, ChannelSource] = self._pipeline.sources
        self._pending = [_Pending() for _ in self._pipeline.streams]
        self._ids = [
            None if stream.message == LINE else message_id(stream.message)
            for stream in self._pipeline.streams
        ]
        self._readers = [_sample_reader(stream) for stream in self._pipeline.streams]
        self._next_give_up = 0
        self._routes: dict[int, list[_Route]] = {}
        # By system, component and message, as they stand in a header.
        self._settled: dict[bytes, list[_Route]] = {}
        self._lines: list[int] = []
        self._line_columns = 0
        self._line_used: frozenset[int] = frozenset()
        self._make_routes()
        self._system = system or channel_map.system
        self._flown_heard = self._autopilot_heard = False
        self._undecided: list[tuple[int, bytes]] = []  # frames, until the flown system is known
        if self._system is not None:
            self.health.chosen = True
            self.health.flown = self._system, channel_map.component or AUTOPILOT_COMPONENT
        self.data_stamp: int | None = None
        self._components: dict[int, int] = {}
        self._left_out: set[tuple[str, int, int]] = set()
        self._texts = StatusTextAssembler()
        self.landed_state = LandedState()

    @property
    def channels(self) -> tuple[str, ...]:
        """Return the ids of the channels that it can yield."""
        return tuple(self.sources)

    @property
    def rate(self) -> float:
        """Return the rows per second of the grid."""
        return self._pipeline.grid.rate

    @property
    def clipped(self) -> dict[str, int]:
        """Return how many samples lay outside calibration or instrument range, by channel."""
        return self._pipeline.clipped

    @property
    def duplicates(self) -> int:
        """Return how many samples repeated the stamp of their predecessor."""
        return self._pipeline.duplicates

    @property
    def reordered(self) -> int:
        """Return how many samples came after a later one of their message, and were left out."""
        return self._pipeline.reordered

    @property
    def remarks(self) -> tuple[str, ...]:
        """Return what of the data was left out so far, in words."""
        lines, samples = self.bad_lines, self.reordered
        return (
            *([f"{lines} of {self.lines + lines} lines of text were left out"] if lines else []),
            *(
                [f"{samples} samples came after a later one of their message, and were left out"]
                if samples
                else []
            ),
        )

    @property
    def system(self) -> int | None:
        """Return the flown system; None before it is known."""
        return self._system

    def counted_sources(self) -> dict[str, ChannelSource]:
        """Return `sources` with what arrived of each so far."""
        return self._pipeline.counted_sources()

    def feed(self, records: Sequence[RawRecordLike]) -> list[Block]:
        """Take records in the order of their arrival; return the rows that they complete.

        Parameters
        ----------
        records : sequence of RawRecord
            Frames, lines, residue.

        Returns
        -------
        list of Block
            Each with the channels of one message (or of one choice of sources). Blocks of a
            channel follow each other without gap or overlap, but for pauses longer than
            `gsapp.decoding.grid.MAX_FILLED_PAUSE`.
        """
        blocks: list[Block] = []
        self.health.feed(records)  # type: ignore[arg-type]
        clock = self.clock
        for record in records:
            kind = record.kind
            if kind == "frame":
                self._frame(record.stamp_us, record.data)
            elif kind == "line":
                self._line(record.stamp_us, record.data)
            if clock.now >= self._next_give_up:
                # At moments that depend on the record alone, not on how it is fed.
                blocks += self._pull(final=False)
                self._pipeline.drop_overdue(clock.now)
                self._next_give_up = clock.now + _GIVE_UP_EVERY
        return blocks + self._pull(final=False)

    def finish(self) -> list[Block]:
        """Return the rows that still waited for something better; nothing more will come."""
        self._decide()
        self.clock.finish()
        self._take_released(self.health.last_stamp or 0)
        self._say(self._texts.flush_overdue())
        return self._pull(final=True)

    def _pull(self, *, final: bool) -> list[Block]:
        for stream, pending in enumerate(self._pending):
            if not pending.times:
                continue
            times, nows, items = pending.times, pending.nows, pending.items
            number = self._ids[stream]
            if len(times) <= self._pipeline.streams[stream].few:
                samples = list(map(self._readers[stream], items))
                self._pipeline.push_few(stream, times, nows, samples)
            elif number is None:
                self._pipeline.push(stream, times, nows, {"": np.array(items)})
            else:
                columns = cast(MessageColumns, decode_columns(number, cast(list[bytes], items)))
                self._pipeline.push(stream, times, nows, columns)
            times.clear()
            nows.clear()
            items.clear()
        return self._pipeline.pull(self.clock.first, self.clock.now, final=final)

    def _frame(self, host: int, data: bytes) -> None:
        if data[0] == 0xFD:
            head, payload = data[5:10], data[10 : 10 + data[1]]
        else:
            head, payload = data[3:6], data[6 : 6 + data[1]]
        routes = self._settled.get(head)
        if routes is None:
            routes = self._find_routes(head, host, payload, data)
        if routes:
            self.data_stamp = host
        if head[2:] in STATE_MESSAGES and head[0] == self._system:
            number = int.from_bytes(head[2:], "little")
            self.landed_state.update(number, head[1], payload, self.flight_time_at(host))
        clock = self.clock
        for stream, _, select_at, selected, stamp_at, stamp_scale, stamp_period in routes:
            # Zero bytes at the end are not always sent.
            if select_at is not None and payload[select_at].rstrip(b"\0") != selected:
                continue
            now = clock.now
            if stamp_at is None:
                time = clock.assign_arrival_time(host, (stream, payload))
            else:
                stamp = int.from_bytes(payload[stamp_at], "little") * stamp_scale
                time = clock.assign_time(
                    head[1], stamp, host, (stream, payload), period=stamp_period
                )
            if clock.released or clock.events:
                # They came before this one.
                self._take_released(host)
            if time is not None:
                pending = self._pending[stream]
                pending.times.append(time)
                pending.nows.append(now)
                pending.items.append(payload)

    def _find_routes(self, head: bytes, host: int, payload: bytes, data: bytes) -> list[_Route]:
        """Return the routes that a frame takes: system, component and message of its header."""
        system, component, number = head[0], head[1], int.from_bytes(head[2:], "little")
        routes = self._routes.get(number)
        if routes is None:
            self._unmapped(host, system, component, number, payload)
            return []
        if number not in RADIO_MESSAGES:  # those tell of the link, whatever system they name
            if system != self._system and not self._follow(host, system, component, data):
                return []
            self._hear_flown(component, autopilot=component == AUTOPILOT_COMPONENT)
        taken = [
            route
            for route in routes
            if (route.select_at is None or payload[route.select_at].rstrip(b"\0") == route.selected)
            and (
                component == self._components.get(route.stream)
                or self._follow_component(host, system, component, route)
            )
        ]
        if all(component == self._components.get(route.stream) for route in routes):
            # Whom it follows never changes.
            self._settled[head] = routes
        return taken

    def _take_released(self, host: int) -> None:
        clock = self.clock
        for placed in clock.released:
            stream, item = placed.item
            pending = self._pending[stream]
            pending.times.append(placed.time)
            pending.nows.append(clock.now)
            pending.items.append(item)
        clock.released.clear()
        for event in clock.events:
            self.notices.append(
                Notice(kind=event.kind, time=event.time / 1e6, stamp_us=host, text=event.text)
            )
        clock.events.clear()

    def _follow(self, host: int, system: int, component: int, data: bytes) -> bool:
        """Return whether a mapped message of a system not followed so far is to be decoded.

        While no system is flown, messages of other components than the autopilot wait.
        """
        if system >= FIRST_GROUND_SYSTEM:
            return False
        if self._system is None:
            if component == AUTOPILOT_COMPONENT:
                self._fly(system)
                return True
            if not self._undecided or host - self._undecided[0][0] <= _AUTOPILOT_PATIENCE:
                self._undecided.append((host, data))
                return False
            self._decide()
        if system == self._system:
            return True
        self._notice_once(
            ("other-system", system, 0),
            host,
            f"another aircraft is on the link: messages of system {system} are ignored, because "
            f"system {self._system} is flown; to fly system {system}, choose it on the LINK tile "
            f"or write system = {system} in the channel map",
            system=system,
        )
        return False

    def _fly(self, system: int) -> None:
        """Take a system for the flown aircraft, and decode what it has sent so far."""
        self._system = system
        undecided, self._undecided = self._undecided, []
        for host, data in undecided:
            self._frame(host, data)

    def _decide(self) -> None:
        """Fly the first system that sends measurements: no autopilot was heard."""
        if self._undecided:
            data = self._undecided[0][1]
            self._fly(data[5] if data[0] == 0xFD else data[3])

    def _hear_flown(self, component: int, *, autopilot: bool) -> None:
        """Let the link be judged by the autopilot, or by the component that the map names."""
        if self._system is None or self._autopilot_heard or (self._flown_heard and not autopilot):
            return
        self._flown_heard, self._autopilot_heard = True, autopilot
        self.health.flown = self._system, self.channel_map.component or component

    def _follow_component(self, host: int, system: int, component: int, route: _Route) -> bool:
        chosen = self._components.setdefault(route.stream, self.channel_map.component or component)
        if component == chosen:
            return True
        self._notice_once(
            ("other-component", component, route.stream),
            host,
            f"{route.message} of component {component} is left out: it is taken from component "
            f"{chosen}; write component = {component} in the map to take it from there",
            system=system,
            component=component,
        )
        return False

    def _unmapped(
        self, host: int, system: int, component: int, number: int, payload: bytes
    ) -> None:
        if self._texts.has_pending:
            self._say(self._texts.flush_overdue(host))
        if system < FIRST_GROUND_SYSTEM and (
            is_vehicle(component, payload)
            if number == HEARTBEAT_ID
            else component == AUTOPILOT_COMPONENT
            and number not in RADIO_MESSAGES
            and is_known(number)
        ):
            if self._system is None:
                self._fly(system)
            if system == self._system:
                self._hear_flown(component, autopilot=True)
        if number == _SYSTEM_TIME:
            if system == self._system and len(payload) > 8:
                unix = int.from_bytes(payload[:8], "little")
                boot = int.from_bytes(payload[8:12], "little") * 1000
                self.clock.set_unix_offset(unix, boot)
        elif number == _STATUSTEXT:
            if self._system in (None, system):
                self._text(host, system, component, payload)
        elif not is_known(number):
            self.unknown[number] += 1
            self._notice_once(
                ("unknown-message", number, 0),
                host,
                f"{message_name(number)} is no message of the dialect: recorded, not decoded; "
                "the sender uses another dialect",
                system=system,
                component=component,
            )

    def _text(self, host: int, system: int, component: int, payload: bytes) -> None:
        """Take one STATUSTEXT; long ones come in numbered pieces."""
        row = decode_columns(_STATUSTEXT, [payload])[0]
        number, place, severity = int(row["id"]), int(row["chunk_seq"]), int(row["severity"])
        piece = bytes(row["text"])
        self._say(self._texts.add_chunk(host, system, component, severity, number, place, piece))

    def _say(self, texts: Iterable[StatusText]) -> None:
        self.messages.extend(
            Notice(
                kind="statustext",
                time=self.flight_time_at(text.stamp_us),
                stamp_us=text.stamp_us,
                text=text.text,
                severity=text.severity,
                system=text.system,
                component=text.component,
            )
            for text in texts
        )

    def flight_time_at(self, host: int) -> float | None:
        """Return the flight time (s) at a host stamp (us); None before the first is known."""
        return None if self.clock.first is None else self.clock.flight_time(host) / 1e6

    def _notice_once(
        self,
        key: tuple[str, int, int],
        host: int,
        text: str,
        *,
        system: int | None = None,
        component: int | None = None,
    ) -> None:
        if key in self._left_out or len(self._left_out) >= _MANY:
            return
        self._left_out.add(key)
        self.notices.append(
            Notice(
                kind=key[0],
                time=self.flight_time_at(host),
                stamp_us=host,
                text=text,
                system=system,
                component=component,
            )
        )

    def _line(self, host: int, data: bytes) -> None:
        """Take one line of text: numbers between delimiters; an empty cell is missing."""
        if not self._lines:
            name = self.channel_map.name
            self._leave_out(host, data, f"the channel map '{name}' says nothing of its columns")
            return
        cells = data.decode("utf-8", "replace").strip().split(self.channel_map.delimiter)
        numbers = (
            parse_finite_number(cell) if place in self._line_used else math.nan
            for place, cell in enumerate(cells[: self._line_columns])
        )
        item = [number for number in numbers if number is not None]
        if len(item) < self._line_columns:
            self._leave_out(host, data, f"it does not hold {self._line_columns} numbers")
            return
        column = self.channel_map.text_time
        stamp = None if column is None else item[column]
        if stamp is not None and not 0.0 <= stamp * self.channel_map.text_scale < 2.0**62:
            self._leave_out(host, data, "its time is missing, negative or too great")
            return
        self.lines += 1
        self.data_stamp = host
        for stream in self._lines:
            now = self.clock.now
            if stamp is None or not self._pipeline.streams[stream].vehicle_time:
                time = self.clock.assign_arrival_time(host, (stream, item))
            else:
                micros = round(stamp * self.channel_map.text_scale)
                time = self.clock.assign_time(0, micros, host, (stream, item))
            if self.clock.released or self.clock.events:
                self._take_released(host)
            if time is not None:
                pending = self._pending[stream]
                pending.times.append(time)
                pending.nows.append(now)
                pending.items.append(item)

    def _leave_out(self, host: int, line: bytes, why: str) -> None:
        self.bad_lines += 1
        shown = line[:60].decode("utf-8", "replace")
        self._notice_once(
            ("bad-line", 0, 0),
            host,
            f"a line is left out, since {why}: '{shown}'; lines like it are counted",
        )

    def _has_vehicle_time(self, entry: MapEntry) -> bool:
        if entry.time == ARRIVAL:
            return False
        if entry.message == LINE:
            return self.channel_map.text_time is not None
        return self._stamp(entry) is not None

    @staticmethod
    def _stamp(entry: MapEntry) -> StampField | None:
        layout = message_layout(message_id(entry.message))
        if entry.time == ARRIVAL:
            return None
        return layout.stamp if entry.time is None else stamp_field_of(layout, entry.time)

    def _make_routes(self) -> None:
        for number, stream in enumerate(self._pipeline.streams):
            entry = stream.outputs[0].entry
            if stream.message == LINE:
                self._lines.append(number)
                continue
            layout = message_layout(message_id(stream.message))
            stamp = self._stamp(entry)
            select_at: slice | None = None
            selected = b""
            if stream.selector is not None:
                field, value = stream.selector.field, stream.selector.value
                start = layout.offset(field)
                select_at = slice(start, start + layout.dtype[field].itemsize)
                selected = (
                    value.encode() if layout.is_text(field) else _stripped_payload_bytes(int(value))
                )
            route = _Route(
                stream=number,
                message=stream.message,
                select_at=select_at,
                selected=selected,
                stamp_at=None if stamp is None else slice(stamp.offset, stamp.offset + stamp.size),
                stamp_scale=1 if stamp is None else stamp.scale,
                stamp_period=2**32 * stamp.scale if stamp is not None and stamp.size == 4 else 0,
            )
            self._routes.setdefault(layout.id, []).append(route)
        columns = [
            ref.index or 0
            for entry in self.channel_map.entries
            if entry.message == LINE
            for ref in entry.inputs
        ]
        if self.channel_map.text_time is not None:
            columns.append(self.channel_map.text_time)
        self._line_columns = max(columns) + 1 if columns else 0
        # What no channel takes may be words.
        self._line_used = frozenset(columns)


def _stripped_payload_bytes(number: int) -> bytes:
    """Return a number as the bytes of a payload, without zero bytes at the end."""
    return number.to_bytes(number.bit_length() // 8 + 1, "little").rstrip(b"\0")


def _sample_reader(stream: MessageStream) -> Callable[[Any], Numbers]:
    """Return what takes the numbers that a stream wants out of its items."""
    if stream.message == LINE:
        places = [ref.index or 0 for ref in stream.wanted]
        return lambda cells: [cells[place] for place in places]
    wanted = [(ref.field, ref.index) for ref in stream.wanted]
    return number_reader(message_id(stream.message), wanted)


__all__ = ["NOTICE_KINDS", "ChannelSource", "Decoder", "Notice"]

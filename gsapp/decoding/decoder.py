"""From raw records to blocks on the grid of flight time.

What comes out is a function of the records alone, however they are fed: all at once from a file,
or a few at a time from a link. A row is handed out as soon as the next sample of its message is
there.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, cast

import numpy as np

from calibration import Certificate, load_certificates
from gsapp.aircraft import Aircraft
from gsapp.decoding.burst_timing import BurstSpreader, SpreadItem
from gsapp.decoding.channel_map import LINE, ChannelMap
from gsapp.decoding.flight_clock import FlightClock
from gsapp.decoding.flight_modes import PARAM_VALUE_ID, PX4, heartbeat_mode, parameter_of
from gsapp.decoding.grid import Numbers
from gsapp.decoding.health import HEARTBEAT_ID, LinkHealth, is_vehicle
from gsapp.decoding.message_stream import MessageColumns, MessageStream
from gsapp.decoding.messages import (
    decode_columns,
    is_known,
    message_id,
    message_name,
    number_reader,
)
from gsapp.decoding.notices import NOTICE_KINDS, STATUSTEXT_ID, Notice, NoticeLog
from gsapp.decoding.pipeline import ChannelSource, Pipeline
from gsapp.decoding.raw_channels import mavlink_raw_entries
from gsapp.decoding.sender_filter import RawRecordLike, SenderFilter
from gsapp.decoding.settings import DECODING
from gsapp.decoding.vehicle_selection import (
    STATE_MESSAGES,
    LandedState,
    MessageRoute,
    TextLineParser,
    VehicleSelector,
    has_vehicle_time,
    routes_by_message,
)
from gsapp.foundation import FlightError
from gsapp.quantities import Block

_SYSTEM_TIME = 2
_AUTOPILOT = 5  # place in the payload of HEARTBEAT


class _Pending:
    """Samples of one stream since the last pull."""

    __slots__ = ("items", "nows", "times")

    def __init__(self) -> None:
        self.times: list[int] = []
        self.nows: list[int] = []
        self.items: list[bytes | list[float]] = []

    def append(self, time: int, now: int, item: bytes | list[float]) -> None:
        self.times.append(time)
        self.nows.append(now)
        self.items.append(item)


class Decoder:
    """Decodes raw records of one aircraft, the flown one, with a channel map.

    Which aircraft that is, `gsapp.decoding.vehicle_selection.VehicleSelector` finds out.

    Parameters
    ----------
    channel_map : ChannelMap
        Of format ``mavlink``; raise FlightError if it is for files.
    certificates : mapping of str to Certificate, optional
        Calibration in force, by channel; else the shipped set that the map names. A calibrated
        source without its certificate yields volts only.
    aircraft : Aircraft, optional
        For the ranges of its instruments: samples at their ends are counted in `clipped`.
    rate : float, optional
        Rows per second.
    system : int, optional
        The flown system; else that of the channel map, or the first autopilot heard.
    address : str, optional
        Network address that it sends from, HOST or HOST:PORT; else that of its first heartbeat.
    keep_samples : bool, optional
        Whether samples are kept for `native_samples`.
    """

    def __init__(
        self,
        channel_map: ChannelMap,
        *,
        certificates: Mapping[str, Certificate] | None = None,
        aircraft: Aircraft | None = None,
        rate: float = 100.0,
        system: int | None = None,
        address: str = "",
        keep_samples: bool = False,
    ) -> None:
        if channel_map.format != "mavlink":
            raise FlightError(
                f"the channel map '{channel_map.name}' is for files of format "
                f"{channel_map.format}; choose one for a link, such as b777 or ardupilot-plane"
            )
        if certificates is None:
            name = channel_map.certificates
            certificates = load_certificates(name) if name else {}
        if channel_map.raw:
            entries = (*channel_map.entries, *mavlink_raw_entries(channel_map))
            channel_map = replace(channel_map, entries=entries)
        self.channel_map = channel_map
        self.health = LinkHealth()
        self.clock = FlightClock()
        self._bursts = BurstSpreader()
        self._log = NoticeLog(self.flight_time_at)
        self.messages: list[Notice] = self._log.messages
        self.modes: list[Notice] = self._log.modes
        self.notices: list[Notice] = self._log.notices
        self.unknown: Counter[int] = Counter()
        self.lines = 0
        self.bad_lines = 0
        self._pipeline = Pipeline(
            channel_map,
            certificates=certificates,
            aircraft=aircraft,
            rate=rate,
            vehicle_time=lambda entry: has_vehicle_time(channel_map, entry),
            keep_samples=keep_samples,
        )
        self.sources: dict[str, ChannelSource] = self._pipeline.sources
        self._pending = [_Pending() for _ in self._pipeline.streams]
        self._ids = [
            None if stream.message == LINE else message_id(stream.message)
            for stream in self._pipeline.streams
        ]
        self._readers = [_sample_reader(stream) for stream in self._pipeline.streams]
        self._next_give_up = 0
        self._routes = routes_by_message(self._pipeline.streams)
        # By system, component and message, as they stand in a header.
        self._settled: dict[bytes, list[MessageRoute]] = {}
        self._line_streams = [k for k, number in enumerate(self._ids) if number is None]
        self._line_parser = TextLineParser(channel_map)
        self._selector = VehicleSelector(channel_map, system, self.health, self._log, self._frame)
        self._sender_filter = SenderFilter(self.health, self._log, self.system, address)
        self.address = address
        self.parameters: list[tuple[float | None, str, float]] = []
        self._mode = ""
        self._is_px4 = False
        self.data_stamp: int | None = None
        self.landed_state = LandedState()

    @property
    def channels(self) -> tuple[str, ...]:
        return tuple(self.sources)

    @property
    def rate(self) -> float:
        return self._pipeline.grid.rate

    @property
    def clipped(self) -> dict[str, int]:
        return self._pipeline.clipped

    @property
    def duplicates(self) -> int:
        return self._pipeline.duplicates

    @property
    def reordered(self) -> int:
        """Return how many samples came after a later one of their message, and were left out."""
        return self._pipeline.reordered

    @property
    def remarks(self) -> tuple[str, ...]:
        lines, samples = self.bad_lines, self.reordered
        return (
            *([f"{lines} of {self.lines + lines} lines of text were skipped"] if lines else []),
            *([f"{samples} samples arrived out of order and were skipped"] if samples else []),
        )

    @property
    def system(self) -> int | None:
        return self._selector.system

    def counted_sources(self) -> dict[str, ChannelSource]:
        """Return `sources` with what arrived of each so far."""
        return self._pipeline.counted_sources()

    def native_samples(self) -> Block:
        """Return all samples so far at their own times, see `Pipeline.native_samples`."""
        return self._pipeline.native_samples()

    def feed(self, records: Sequence[RawRecordLike]) -> list[Block]:
        """Take records in the order of their arrival; return the rows that they complete.

        Each block has the channels of one message (or of one choice of sources). Blocks of a
        channel follow each other without gap or overlap, but for pauses longer than
        `DECODING.max_filled_pause`.
        """
        return self._feed_accepted(self._sender_filter.feed(records))

    def _feed_accepted(self, records: Sequence[RawRecordLike]) -> list[Block]:
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
                self._next_give_up = clock.now + DECODING.give_up_interval
        return blocks + self._pull(final=False)

    def finish(self) -> list[Block]:
        """Return the rows that still waited for something better; nothing more will come."""
        blocks = self._feed_accepted(self._sender_filter.finish())
        self._selector.decide()
        self.clock.finish()
        self._take_released(self.health.last_stamp or 0)
        self._take_spread(self._bursts.release_all())
        self._log.flush_overdue()
        return blocks + self._pull(final=True)

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
                columns = cast("MessageColumns", decode_columns(number, cast("list[bytes]", items)))
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
        if head[2:] in STATE_MESSAGES and head[0] == self._selector.system:
            number = int.from_bytes(head[2:], "little")
            self.landed_state.update(number, head[1], payload, self.flight_time_at(host))
            if number == HEARTBEAT_ID and is_vehicle(head[1], payload):
                self._take_mode(host, head, payload)
        clock = self.clock
        for stream, _, select_at, selected, stamp_at, stamp_scale, stamp_period in routes:
            # Zero bytes at the end are not always sent.
            if select_at is not None and payload[select_at].rstrip(b"\0") != selected:
                continue
            now = clock.now
            if stamp_at is None:
                time = self._arrival_time(stream, host, payload)
            else:
                stamp = int.from_bytes(payload[stamp_at], "little") * stamp_scale
                time = clock.assign_time(
                    head[1], stamp, host, (stream, payload), period=stamp_period
                )
            if clock.released or clock.events:
                # They came before this one.
                self._take_released(host)
            if time is not None:
                self._pending[stream].append(time, now, payload)
        self._release_bursts()

    def _arrival_time(self, stream: int, host: int, item: Any) -> int | None:
        """Return the flight time of an item without a stamp; None if it waits."""
        time = self.clock.assign_arrival_time(host, (stream, item))
        return None if time is None else self._bursts.add(stream, time, item)

    def _release_bursts(self) -> None:
        if self.clock.now >= self._bursts.due:
            self._take_spread(self._bursts.release(self.clock.now))

    def _take_spread(self, items: Sequence[SpreadItem]) -> None:
        for stream, time, item in items:
            self._pending[stream].append(time, self.clock.now, item)

    def _take_mode(self, host: int, head: bytes, payload: bytes) -> None:
        self._is_px4 = payload[_AUTOPILOT : _AUTOPILOT + 1] == bytes([PX4])
        mode = heartbeat_mode(payload)
        if mode and mode != self._mode:
            self._mode = mode
            self._log.add_mode(host, head[0], head[1], mode)

    def _find_routes(
        self, head: bytes, host: int, payload: bytes, data: bytes
    ) -> list[MessageRoute]:
        """Return the routes that a frame takes: system, component and message of its header."""
        system, component, number = head[0], head[1], int.from_bytes(head[2:], "little")
        routes = self._routes.get(number)
        if routes is None:
            self._unmapped(host, system, component, number, payload)
            return []
        selector = self._selector
        if not selector.accepts(host, system, component, number, data):
            return []
        taken = [
            route
            for route in routes
            if (route.select_at is None or payload[route.select_at].rstrip(b"\0") == route.selected)
            and (
                selector.takes_from(component, route)
                or selector.follow_component(host, system, component, route)
            )
        ]
        if all(selector.takes_from(component, route) for route in routes):
            # Whom it follows never changes.
            self._settled[head] = routes
        return taken

    def _take_released(self, host: int) -> None:
        clock = self.clock
        for placed in clock.released:
            stream, item = placed.item
            self._pending[stream].append(placed.time, clock.now, item)
        clock.released.clear()
        for event in clock.events:
            self._log.add_clock_event(event, host)
        clock.events.clear()

    def _unmapped(
        self, host: int, system: int, component: int, number: int, payload: bytes
    ) -> None:
        self._log.flush_overdue(host)
        self._selector.hear_unmapped(system, component, number, payload)
        if number == _SYSTEM_TIME:
            if system == self.system and len(payload) > 8:
                unix = int.from_bytes(payload[:8], "little")
                boot = int.from_bytes(payload[8:12], "little") * 1000
                self.clock.set_unix_offset(unix, boot)
        elif number == PARAM_VALUE_ID:
            if self.system in (None, system):
                name, value = parameter_of(payload, bytewise=self._is_px4)
                self.parameters.append((self.flight_time_at(host), name, value))
        elif number == STATUSTEXT_ID:
            if self.system in (None, system):
                self._log.add_status_text(host, system, component, payload)
        elif not is_known(number):
            self.unknown[number] += 1
            self._log.add_once(
                ("unknown-message", number, 0),
                host,
                f"{message_name(number)} is no message of the dialect: recorded, not decoded; "
                "the sender uses another dialect",
                system=system,
                component=component,
            )

    def flight_time_at(self, host: int) -> float | None:
        """Return the flight time (s) at a host stamp (us); None before the first is known."""
        return None if self.clock.first is None else self.clock.flight_time(host) / 1e6

    def _line(self, host: int, data: bytes) -> None:
        parsed = self._line_parser.parse(data)
        if isinstance(parsed, str):
            self._leave_out(host, data, parsed)
            return
        item, stamp = parsed
        self.lines += 1
        self.data_stamp = host
        for stream in self._line_streams:
            now = self.clock.now
            if stamp is None or not self._pipeline.streams[stream].vehicle_time:
                time = self._arrival_time(stream, host, item)
            else:
                time = self.clock.assign_time(0, stamp, host, (stream, item))
            if self.clock.released or self.clock.events:
                self._take_released(host)
            if time is not None:
                self._pending[stream].append(time, now, item)
        self._release_bursts()

    def _leave_out(self, host: int, line: bytes, why: str) -> None:
        self.bad_lines += 1
        shown = line[:60].decode("utf-8", "replace")
        self._log.add_once(
            ("bad-line", 0, 0),
            host,
            f"line skipped: {why}: '{shown}'; similar lines are counted",
        )


def _sample_reader(stream: MessageStream) -> Callable[[Any], Numbers]:
    """Return what takes the numbers that a stream wants out of its items."""
    if stream.message == LINE:
        places = [ref.index or 0 for ref in stream.wanted]
        return lambda cells: [cells[place] for place in places]
    wanted = [(ref.field, ref.index) for ref in stream.wanted]
    return number_reader(message_id(stream.message), wanted)


__all__ = ["NOTICE_KINDS", "ChannelSource", "Decoder", "Notice"]

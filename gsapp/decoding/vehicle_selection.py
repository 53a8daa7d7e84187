"""Which system of a link is decoded, if it is on the ground, which streams its frames reach."""

from __future__ import annotations

import bisect
import math
from collections.abc import Callable, Sequence
from typing import Final, NamedTuple

from gsapp.decoding.channel_map import ARRIVAL, LINE, ChannelMap, MapEntry
from gsapp.decoding.health import (
    AUTOPILOT_COMPONENT,
    FIRST_GROUND_SYSTEM,
    HEARTBEAT_ID,
    RADIO_MESSAGES,
    LinkHealth,
    is_vehicle,
)
from gsapp.decoding.message_stream import MessageStream
from gsapp.decoding.messages import StampField, is_known, message_id, message_layout, stamp_field_of
from gsapp.decoding.notices import NoticeLog
from gsapp.decoding.settings import DECODING
from gsapp.quantities.units import parse_finite_number


class TextLineParser:
    """Parses lines of text; an empty cell is missing, and what no channel takes may be words."""

    def __init__(self, channel_map: ChannelMap) -> None:
        self._map = channel_map
        columns = [
            ref.index or 0
            for entry in channel_map.entries
            if entry.message == LINE
            for ref in entry.inputs
        ]
        self._mapped = bool(columns)
        if channel_map.text_time is not None:
            columns.append(channel_map.text_time)
        self._count = max(columns) + 1 if columns else 0
        self._used = frozenset(columns)

    def parse(self, data: bytes) -> tuple[list[float], int | None] | str:
        """Return the numbers of a line and its stamp (us), or why it is left out."""
        if not self._mapped:
            return f"the channel map '{self._map.name}' does not define its columns"
        cells = data.decode("utf-8", "replace").strip().split(self._map.delimiter)
        numbers = (
            parse_finite_number(cell) if index in self._used else math.nan
            for index, cell in enumerate(cells[: self._count])
        )
        item = [number for number in numbers if number is not None]
        if len(item) < self._count:
            return f"it does not hold {self._count} numbers"
        column = self._map.text_time
        if column is None:
            return item, None
        if not 0.0 <= item[column] * self._map.text_scale < 2.0**62:
            return "its time is missing, negative or too great"
        return item, round(item[column] * self._map.text_scale)


class MessageRoute(NamedTuple):
    """How frames of one message reach one stream."""

    stream: int
    message: str
    select_at: slice | None
    selected: bytes
    stamp_at: slice | None
    stamp_scale: int
    stamp_period: int


def has_vehicle_time(channel_map: ChannelMap, entry: MapEntry) -> bool:
    """Return whether a message or line carries a stamp of the vehicle."""
    if entry.time == ARRIVAL:
        return False
    if entry.message == LINE:
        return channel_map.text_time is not None
    return _stamp_field(entry) is not None


def _stamp_field(entry: MapEntry) -> StampField | None:
    layout = message_layout(message_id(entry.message))
    if entry.time == ARRIVAL:
        return None
    return layout.stamp if entry.time is None else stamp_field_of(layout, entry.time)


def routes_by_message(streams: Sequence[MessageStream]) -> dict[int, list[MessageRoute]]:
    """Return the routes to all streams that take frames, by message id."""
    routes: dict[int, list[MessageRoute]] = {}
    for index, stream in enumerate(streams):
        if stream.message == LINE:
            continue
        layout = message_layout(message_id(stream.message))
        stamp = _stamp_field(stream.outputs[0].entry)
        select_at: slice | None = None
        selected = b""
        if stream.selector is not None:
            field, value = stream.selector.field, stream.selector.value
            start = layout.offset(field)
            select_at = slice(start, start + layout.dtype[field].itemsize)
            selected = (
                value.encode() if layout.is_text(field) else _stripped_payload_bytes(int(value))
            )
        route = MessageRoute(
            stream=index,
            message=stream.message,
            select_at=select_at,
            selected=selected,
            stamp_at=None if stamp is None else slice(stamp.offset, stamp.offset + stamp.size),
            stamp_scale=1 if stamp is None else stamp.scale,
            stamp_period=2**32 * stamp.scale if stamp is not None and stamp.size == 4 else 0,
        )
        routes.setdefault(layout.id, []).append(route)
    return routes


def _stripped_payload_bytes(number: int) -> bytes:
    return number.to_bytes(number.bit_length() // 8 + 1, "little").rstrip(b"\0")


class VehicleSelector:
    """Finds the flown system of a link, and the component that each message is taken from.

    That is the system chosen, or else the first whose autopilot is heard: by its heartbeat, or by
    any other message of component 1. In a record without an autopilot it is the first system that
    sends a mapped message. Once found it stays. Ground stations are never flown. `decode` decodes a
    frame (host stamp, bytes) that waited until the flown system was known.
    """

    def __init__(
        self,
        channel_map: ChannelMap,
        system: int | None,
        health: LinkHealth,
        log: NoticeLog,
        decode: Callable[[int, bytes], None],
    ) -> None:
        self._map_component = channel_map.component
        self.system = system or channel_map.system
        self._health = health
        self._log = log
        self._decode = decode
        self._flown_heard = self._autopilot_heard = False
        self._undecided: list[tuple[int, bytes]] = []
        self._components: dict[int, int] = {}
        if self.system is not None:
            health.chosen = True
            health.flown = self.system, channel_map.component or AUTOPILOT_COMPONENT

    def accepts(self, host: int, system: int, component: int, number: int, data: bytes) -> bool:
        """Return whether a mapped message is to be decoded, by the system that sent it."""
        if number in RADIO_MESSAGES:  # those tell of the link, whatever system they name
            return True
        if system != self.system and not self._follow(host, system, component, data):
            return False
        self._judge_link_by(component, autopilot=component == AUTOPILOT_COMPONENT)
        return True

    def _follow(self, host: int, system: int, component: int, data: bytes) -> bool:
        """Return whether a mapped message of a system not followed so far is to be decoded.

        While no system is flown, messages of other components than the autopilot wait.
        """
        if system >= FIRST_GROUND_SYSTEM:
            return False
        if self.system is None:
            if component == AUTOPILOT_COMPONENT:
                self._fly(system)
                return True
            if not self._undecided or host - self._undecided[0][0] <= DECODING.autopilot_timeout:
                self._undecided.append((host, data))
                return False
            self.decide()
        if system == self.system:
            return True
        self._log.add_once(
            ("other-system", system, 0),
            host,
            f"another aircraft is on the link: messages of system {system} are ignored: system "
            f"{self.system} is flown; to fly system {system}, choose it on the LINK tile or "
            f"write system = {system} in the channel map",
            system=system,
        )
        return False

    def _fly(self, system: int) -> None:
        """Take a system for the flown aircraft, and decode what it has sent so far."""
        self.system = system
        if address := self._health.addresses.get(system):
            self._log.add_once(
                ("flown-system", system, 0),
                self._health.last_stamp or 0,
                f"system {system} at {address} is taken as the aircraft: its autopilot was "
                "received first; to fly another, choose it on the LINK tile",
                system=system,
            )
        undecided, self._undecided = self._undecided, []
        for host, data in undecided:
            self._decode(host, data)

    def decide(self) -> None:
        """Fly the first system that sends measurements: no autopilot was heard."""
        if self._undecided:
            data = self._undecided[0][1]
            self._fly(data[5] if data[0] == 0xFD else data[3])

    def _judge_link_by(self, component: int, *, autopilot: bool) -> None:
        """Let the link be judged by the autopilot, or by the component that the map names."""
        if self.system is None or self._autopilot_heard or (self._flown_heard and not autopilot):
            return
        self._flown_heard, self._autopilot_heard = True, autopilot
        self._health.flown = self.system, self._map_component or component

    def hear_unmapped(self, system: int, component: int, number: int, payload: bytes) -> None:
        """Fly the system of an autopilot that is heard by a message without a channel."""
        if system >= FIRST_GROUND_SYSTEM or not (
            is_vehicle(component, payload)
            if number == HEARTBEAT_ID
            else component == AUTOPILOT_COMPONENT
            and number not in RADIO_MESSAGES
            and is_known(number)
        ):
            return
        if self.system is None:
            self._fly(system)
        if system == self.system:
            self._judge_link_by(component, autopilot=True)

    def takes_from(self, component: int, route: MessageRoute) -> bool:
        """Return whether a component is known to be the one that a route takes messages from."""
        return component == self._components.get(route.stream)

    def follow_component(self, host: int, system: int, component: int, route: MessageRoute) -> bool:
        """Return whether a route takes messages from a component; the first one heard stays."""
        chosen = self._components.setdefault(route.stream, self._map_component or component)
        if component == chosen:
            return True
        self._log.add_once(
            ("other-component", component, route.stream),
            host,
            f"{route.message} of component {component} is ignored: taken from component "
            f"{chosen}; write component = {component} in the map to take it from there",
            system=system,
            component=component,
        )
        return False


EXTENDED_SYS_STATE: Final = 245
STATE_MESSAGES: Final = frozenset(
    number.to_bytes(size, "little")
    for number in (HEARTBEAT_ID, EXTENDED_SYS_STATE)
    for size in (1, 3)
)
"""Ids as they stand in headers: one byte in MAVLink 1, three in MAVLink 2."""

_BASE_MODE, _ARMED = 6, 0x80
_LANDED_STATE, _ON_GROUND = 1, 1


class LandedState:
    """Whether the autopilot reports ground, by flight time.

    It does with MAV_LANDED_STATE_ON_GROUND. One that sends no landed state does once it disarms;
    before it was ever armed nothing is known.
    """

    def __init__(self) -> None:
        self._armed: bool | None = None
        self._landed_state = 0
        self._times: list[float] = []
        self._states: list[bool | None] = []

    def update(self, number: int, component: int, payload: bytes, time: float | None) -> None:
        """Take in a message of the flown system, with the flight time of its arrival (s), if any.

        Other messages than the two are ignored; zero bytes at the end of a payload may be missing.
        """
        if number == HEARTBEAT_ID and is_vehicle(component, payload) and len(payload) > _BASE_MODE:
            armed = bool(payload[_BASE_MODE] & _ARMED)
            if armed or self._armed is not None:
                self._armed = armed
        elif number == EXTENDED_SYS_STATE and component == AUTOPILOT_COMPONENT:
            self._landed_state = payload[_LANDED_STATE] if len(payload) > _LANDED_STATE else 0
        state = self._state()
        if time is not None and state != (self._states[-1] if self._states else None):
            self._times.append(time)
            self._states.append(state)

    def _state(self) -> bool | None:
        if self._landed_state:
            return self._landed_state == _ON_GROUND
        return None if self._armed is None else not self._armed

    def on_ground(self, time: float) -> bool | None:
        """Return whether ground was reported last by a flight time, s; None if nothing was."""
        index = bisect.bisect_right(self._times, time)
        return self._states[index - 1] if index else None

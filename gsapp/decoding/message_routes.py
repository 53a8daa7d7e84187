"""How frames of a message reach the streams of the pipeline."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from gsapp.decoding.channel_map import ARRIVAL, LINE, ChannelMap, MapEntry
from gsapp.decoding.message_stream import MessageStream
from gsapp.decoding.messages import StampField, message_id, message_layout, stamp_field_of
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
            parse_finite_number(cell) if place in self._used else math.nan
            for place, cell in enumerate(cells[: self._count])
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
    for number, stream in enumerate(streams):
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
            stream=number,
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

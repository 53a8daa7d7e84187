"""Raw channels: fields of messages kept under their own names, ``ATT.DesRoll``, as they are.

Which, the patterns `ChannelMap.raw` say. No name of a message that the decoder follows itself
(status texts, heartbeats) is taken by ``*``.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence

from gsapp.decoding.channel_map import ChannelMap, FieldRef, MapEntry, Selector
from gsapp.decoding.messages import (
    MessageLayout,
    is_known,
    message_id,
    message_layout,
    message_names,
)
from gsapp.foundation import UnknownNameError
from gsapp.foundation.name_suggestions import did_you_mean

_FOLLOWED = frozenset({"HEARTBEAT", "PARAM_VALUE", "STATUSTEXT", "SYSTEM_TIME"})
_SELECTOR = re.compile(r"\[\w+\](?=\.)")


class RawPatterns:
    """Patterns of raw channels; ``*`` stands for anything, all else for itself.

    A pattern without an instance means all instances: ``IMU.GyrX`` is ``IMU[0].GyrX`` too.
    """

    def __init__(self, patterns: Sequence[str]) -> None:
        texts = [re.escape(pattern.strip()).replace(r"\*", ".*") for pattern in patterns]
        self._pattern = re.compile("|".join(texts))

    def matches(self, name: str) -> bool:
        return (
            self._pattern.fullmatch(name) is not None
            or self._pattern.fullmatch(_SELECTOR.sub("", name)) is not None
        )


def raw_entry(message: str, selector: str, field: str, index: int | None = None) -> MapEntry:
    """Return the entry of one number of a message; its channel is called as the number is."""
    element = "" if index is None else f"[{index}]"
    name = f"{message}{f'[{selector}]' if selector else ''}.{field}{element}"
    return MapEntry(
        channel=name,
        source=name,
        message=message,
        selector=Selector(field="", value=selector) if selector else None,
        inputs=(FieldRef(field=field, index=index),),
        unit="",
    )


def mavlink_raw_entries(channel_map: ChannelMap) -> tuple[MapEntry, ...]:
    """Return the entries of all fields of MAVLink messages that a map wants raw.

    Raise UnknownNameError for a pattern that no field of the dialect fits.
    """
    found: dict[str, MapEntry] = {}
    for text in channel_map.raw:
        patterns = RawPatterns([text])
        before = len(found)
        for layout in _layouts(text):
            entries = list(_numbers(layout))
            found |= {one.channel: one for one in entries if patterns.matches(one.channel)}
        if len(found) == before:
            hint = did_you_mean(text.partition(".")[0].upper(), message_names(), "see MAVLink")
            raise UnknownNameError(
                f"the channel map '{channel_map.name}' wants '{text}' raw, which is no field of a "
                f"MAVLink message; {hint}"
            )
    mapped = {entry.channel for entry in channel_map.entries}
    return tuple(entry for entry in found.values() if entry.channel not in mapped)


def mavlink_numbers(messages: Collection[int]) -> list[MapEntry]:
    """Return the entries of all numbers in some messages, by their numbers."""
    return [
        entry
        for one in sorted(messages)
        if is_known(one)
        for entry in _numbers(message_layout(one))
    ]


def _layouts(pattern: str) -> list[MessageLayout]:
    message = pattern.partition(".")[0].strip()
    every = message_names()
    names = [message] if message in every else [name for name in every if name not in _FOLLOWED]
    return [message_layout(message_id(name)) for name in names]


def _numbers(layout: MessageLayout) -> Iterator[MapEntry]:
    for field in layout.fields:
        length = layout.length(field)
        if layout.is_text(field) or (layout.stamp is not None and field == layout.stamp.field):
            continue
        for index in range(length) if length else (None,):
            yield raw_entry(layout.name, "", field, index)

"""The MAVLink dialect, loaded when first needed: its import takes a moment.

The checksum of a frame is seeded with a byte that depends on the fields of its message (the
"CRC extra"). Extension fields do not enter it, which is how their start is found here: MAVLink 1
sends a message without them.
"""

from __future__ import annotations

import os
from functools import cache
from types import ModuleType
from typing import Any, NamedTuple

from fastcrc import crc16


class WireFormat(NamedTuple):
    """What a framer must know of a message."""

    crc_extra: bytes  # The one byte that seeds the checksum.
    size: int  # Payload bytes without extension fields: the length of every MAVLink 1 frame.
    full_size: int  # Payload bytes with extension fields; MAVLink 2 cuts trailing zero bytes.


@cache
def dialect() -> ModuleType:
    """Return pymavlink's MAVLink 2 dialect with the messages of all projects."""
    os.environ.setdefault("MAVLINK20", "1")
    from pymavlink.dialects.v20 import all as module

    return module  # type: ignore[no-any-return]


@cache
def wire_formats() -> dict[int, WireFormat]:
    """Return the wire format of every message of the dialect, by message id."""
    return {
        message_id: WireFormat(
            bytes((message.crc_extra,)), _base_size(message), message.unpacker.size
        )
        for message_id, message in dialect().mavlink_map.items()
    }


_SIZES = {
    "double": 8, "uint64_t": 8, "int64_t": 8, "float": 4, "uint32_t": 4, "int32_t": 4,
    "uint16_t": 2, "int16_t": 2, "uint8_t": 1, "int8_t": 1, "char": 1,
}  # fmt: skip


def _base_size(message: Any) -> int:
    """Return the size without extension fields: the fields that reproduce the CRC extra."""
    types = dict(zip(message.fieldnames, message.fieldtypes, strict=True))
    checksum = crc16.mcrf4xx(f"{message.msgname} ".encode())
    size = base = 0
    for name, length in zip(message.ordered_fieldnames, message.array_lengths, strict=True):
        text = f"{types[name]} {name} ".encode()
        checksum = crc16.mcrf4xx(text + bytes((length,)) if length else text, checksum)
        size += _SIZES[types[name]] * (length or 1)
        if (checksum & 0xFF) ^ (checksum >> 8) == message.crc_extra:
            base = size  # an earlier match was chance
    return base or size


class TimeField(NamedTuple):
    """Where a message holds its sender's stamp."""

    offset: int
    size: int
    """Place in the payload, bytes (little-endian, unsigned)."""
    microseconds: int  # What one count means.
    since_boot: bool  # Whether the field always counts from the sender's boot (``time_boot_ms``).


_TIME_FIELDS = {"time_boot_ms": 1000, "time_usec": 1, "timestamp": 1, "time_unix_usec": 1}


@cache
def time_fields() -> dict[int, TimeField]:
    """Return where each message that is stamped by its sender holds the stamp, by message id."""
    fields: dict[int, TimeField] = {}
    for message_id, message in dialect().mavlink_map.items():
        types = dict(zip(message.fieldnames, message.fieldtypes, strict=True))
        offset = 0
        for name, length in zip(message.ordered_fieldnames, message.array_lengths, strict=True):
            size = _SIZES[types[name]]
            if name in _TIME_FIELDS and types[name] in ("uint32_t", "uint64_t"):
                scale = _TIME_FIELDS[name]
                fields[message_id] = TimeField(offset, size, scale, name == "time_boot_ms")
                break
            offset += size * (length or 1)
    return fields

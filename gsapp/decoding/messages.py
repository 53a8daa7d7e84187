"""MAVLink messages decoded by columns: many payloads of one message in one step.

The layouts are taken from the classes of pymavlink's ``v20.all``, so that the dialect is never
written down twice. Field names are MAVLink's. Importing this module is cheap; pymavlink is
imported when the first layout is asked for.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from operator import itemgetter
from struct import Struct
from typing import Any

import numpy as np
import numpy.typing as npt

from gsapp.decoding.dialect import dialect
from gsapp.foundation import UnknownNameError
from gsapp.foundation.name_suggestions import did_you_mean

# The codes of Python's struct module, as pymavlink writes them, in NumPy's words.
_CODES = {
    "b": "i1", "B": "u1", "h": "<i2", "H": "<u2", "i": "<i4", "I": "<u4",
    "q": "<i8", "Q": "<u8", "f": "<f4", "d": "<f8",
}  # fmt: skip

_STRUCT_CODES = {np.dtype(text): code for code, text in _CODES.items()}

_STAMP_FIELD_NAMES = ("time_boot_ms", "time_boot_us", "time_usec", "timestamp")
_MICROSECONDS = {"ms": 1000, "us": 1}


@dataclass(frozen=True, slots=True, kw_only=True)
class StampField:
    """Where a message carries the vehicle's time."""

    field: str  # Name of the field.
    offset: int
    size: int
    """Place in the payload, bytes. Unsigned, little-endian."""
    scale: int  # Microseconds per count.


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MessageLayout:
    """How the payload of one message is laid out."""

    id: int
    name: str
    """Such as ``ATTITUDE``."""
    dtype: np.dtype[np.void]  # Structured, packed, in the order of the wire, extensions included.
    units: Mapping[str, str]  # Units that the dialect states, by field.
    instance_field: str | None  # The field that tells several senders of the same message apart.
    stamp: StampField | None  # The vehicle's time; None where the message carries none.

    @property
    def fields(self) -> tuple[str, ...]:
        return tuple(self.dtype.names or ())

    def offset(self, field: str) -> int:
        return _offset(self.dtype, field)

    def is_text(self, field: str) -> bool:
        return self.dtype[field].kind == "S"

    def length(self, field: str) -> int:
        shape = self.dtype[field].shape
        return int(shape[0]) if shape else 0


@cache
def _ids() -> dict[str, int]:
    return {str(kind.msgname): int(number) for number, kind in dialect().mavlink_map.items()}


def message_names() -> tuple[str, ...]:
    """Return the names of all messages of the dialect."""
    return tuple(_ids())


def is_known(message_id: int) -> bool:
    """Return whether the dialect has a message of that id."""
    return message_id in dialect().mavlink_map


def message_name(message_id: int) -> str:
    """Return the name of a message; ``UNKNOWN_n`` for an id outside the dialect."""
    kind = dialect().mavlink_map.get(message_id)
    return f"UNKNOWN_{message_id}" if kind is None else str(kind.msgname)


def message_id(name: str) -> int:
    """Return the id of a message.

    Raise UnknownNameError if the dialect has no such message; near names are proposed.
    """
    found = _ids().get(name)
    if found is None:
        hint = did_you_mean(name.upper(), _ids(), "see the MAVLink common dialect")
        raise UnknownNameError(f"no MAVLink message is called '{name}'; {hint}")
    return found


@cache
def message_layout(message_id: int) -> MessageLayout:
    """Return the layout of a message.

    Raise UnknownNameError if the dialect has no message of that id.
    """
    kind = dialect().mavlink_map.get(message_id)
    if kind is None:
        raise UnknownNameError(
            f"no MAVLink message has the id {message_id}; the sender uses another dialect"
        )
    codes = bytes(kind.native_format).decode("ascii").lstrip("<")
    fields: list[Any] = []
    for name, code, length in zip(kind.ordered_fieldnames, codes, kind.array_lengths, strict=True):
        if code == "c":
            fields.append((name, f"S{max(length, 1)}"))
        elif length:
            fields.append((name, _CODES[code], (length,)))
        else:
            fields.append((name, _CODES[code]))
    dtype = np.dtype(fields)
    units = dict(kind.fieldunits_by_name)
    return MessageLayout(
        id=message_id,
        name=str(kind.msgname),
        dtype=dtype,
        units=units,
        instance_field=kind.instance_field,
        stamp=_find_stamp(dtype, units),
    )


def stamp_field_of(layout: MessageLayout, field: str) -> StampField | None:
    """Return a field as the vehicle's time; None if it is no unsigned count of ms or us."""
    return _make_stamp_field(layout.dtype, layout.units, field)


def _find_stamp(dtype: np.dtype[np.void], units: Mapping[str, str]) -> StampField | None:
    for name in _STAMP_FIELD_NAMES:
        found = _make_stamp_field(dtype, units, name)
        if found is not None:
            return found
    return None


def _make_stamp_field(
    dtype: np.dtype[np.void], units: Mapping[str, str], field: str
) -> StampField | None:
    if field not in (dtype.names or ()):
        return None
    scale = _MICROSECONDS.get(units.get(field, ""))
    if scale is None or dtype[field].kind != "u" or dtype[field].itemsize < 4:
        return None
    return StampField(
        field=field, offset=_offset(dtype, field), size=dtype[field].itemsize, scale=scale
    )


def _offset(dtype: np.dtype[np.void], field: str) -> int:
    places: Mapping[str, Any] = dtype.fields or {}
    return int(places[field][1])


def decode_columns(message_id: int, payloads: Sequence[bytes]) -> npt.NDArray[np.void]:
    """Decode payloads of one message, as sent, to a structured array of shape (n,), read-only.

    One field for each MAVLink field; arrays have shape (n, length). MAVLink 2 cuts trailing zeros,
    MAVLink 1 has no extensions: what is missing is zero. What is longer than the layout (a newer
    dialect) is cut. Text ends at its trailing zeros. Raise UnknownNameError if the dialect has no
    message of that id.
    """
    dtype = message_layout(message_id).dtype
    size = dtype.itemsize
    whole = b"".join(
        [
            payload if len(payload) == size else payload[:size].ljust(size, b"\0")
            for payload in payloads
        ]
    )
    return np.frombuffer(whole, dtype=dtype)


def number_reader(
    message_id: int, wanted: Sequence[tuple[str, int | None]]
) -> Callable[[bytes], tuple[float, ...]]:
    """Return a function that takes numbers, in the order wanted, out of one payload of a message.

    The quick way for the few payloads that a live link gives at a time. Wanted are fields, and the
    element of each that is an array; a number may be wanted more than once. Raise UnknownNameError
    if the dialect has no message of that id, ValueError if a field is text.
    """
    layout = message_layout(message_id)
    places = []
    for field, element in wanted:
        if layout.is_text(field):
            raise ValueError(f"{layout.name}.{field} is text, not a number")
        kind = layout.dtype[field].base
        places.append((layout.offset(field) + (element or 0) * kind.itemsize, kind))
    slots = sorted(set(places), key=itemgetter(0))
    form, end = "<", 0
    for offset, kind in slots:
        form += f"{offset - end}x{_STRUCT_CODES[kind]}"
        end = offset + kind.itemsize
    size, unpack = end, Struct(form).unpack_from
    order = [slots.index(place) for place in places]
    # Of a single number `itemgetter` would make no tuple; a tuple stays itself.
    pick = tuple if order == list(range(len(slots))) else itemgetter(*order)
    floats = all(kind.kind == "f" for _, kind in slots)

    def read(payload: bytes) -> tuple[float, ...]:
        numbers = pick(unpack(payload if len(payload) >= size else payload.ljust(size, b"\0")))
        return numbers if floats else tuple(map(float, numbers))

    return read

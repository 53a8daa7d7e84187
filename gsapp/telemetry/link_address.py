"""The address of a link, such as ``udpin:0.0.0.0:14550``, and the fields it is made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

from gsapp.foundation import LinkError

LOOPBACK: Final = "127.0.0.1"


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkAddress:
    """A link, taken apart."""

    kind: str  # Name of its `LinkKind`.
    host: str = ""  # Host name or address of a network link.
    port: int = 0  # Its port; 0 for other kinds.
    path: str = ""  # Serial port, flight, or whatever else a kind writes there.
    baud: int = 0  # Symbols per second of a serial port; 0 for other kinds.

    def __str__(self) -> str:
        if self.kind == "flight":
            return self.path
        host = f"[{self.host}]" if ":" in self.host else self.host
        parts = (self.kind, host, self.port, self.path, self.baud)
        return ":".join(str(part) for part in parts if part)


@dataclass(frozen=True, slots=True, kw_only=True)
class AddressField:
    """One field of an address."""

    name: Literal["host", "port", "path", "baud"]
    """Attribute of `LinkAddress` that it fills. A kind lists its fields in this order."""
    metavar: str  # The field in the grammar, ``HOST``.
    label: str  # The field in a dialog.
    example: str  # A usual value. A host that is left out is this computer.
    limits: tuple[int, int] = (1, 65535)  # Lowest and highest value of a number.
    choices: tuple[int, ...] = ()
    """Values that a dialog offers for a number; none for any within the limits."""

    @property
    def is_number(self) -> bool:
        return self.name in ("port", "baud")

    def parse(self, text: str) -> str | int:
        """Return the value of the field.

        Raise LinkError if it has none; says what the value must be.
        """
        what = self.label.lower()
        if self.is_number:
            low, high = self.limits
            if not text:
                raise LinkError(f"the {what} is missing")
            if not (text.isascii() and text.isdigit()):
                raise LinkError(f"{what} '{text}' is not a whole number")
            # No port and no rate is as long, and Python refuses to read thousands of digits.
            number = int(text[:20])
            if not low <= number <= high:
                raise LinkError(
                    f"{what} {text[:20]} is out of range ({low} to {high}, usually {self.example})"
                )
            return number
        if self.name == "host":
            text = text.removeprefix("[").removesuffix("]") or LOOPBACK
            if any(character.isspace() or character in "/\\" for character in text):
                raise LinkError(f"'{text}' is not a host name")
        elif not text:
            raise LinkError(f"the {what} is missing")
        return text


HOST: Final = AddressField(name="host", metavar="HOST", label="Address", example=LOOPBACK)
UDP_PORT: Final = AddressField(name="port", metavar="PORT", label="Port", example="14550")
TCP_PORT: Final = replace(UDP_PORT, example="5760")
SERIAL_PORT: Final = AddressField(
    name="path", metavar="PATH", label="Serial port", example="/dev/ttyUSB0"
)
BAUD: Final = AddressField(
    name="baud", metavar="BAUD", label="Baud rate", example="57600", limits=(300, 12_000_000),
    choices=(57_600, 115_200, 230_400, 460_800, 921_600, 38_400, 9_600),
)  # fmt: skip


def split_fields(fields: Sequence[AddressField], text: str) -> list[str]:
    """Return the text of each field, empty where it is missing; the first may hold colons."""
    texts: list[str] = []
    for field in reversed(fields[1:]):
        head, colon, last = text.rpartition(":")
        if not colon and field.is_number and not last.isdigit():
            head, last = last, ""
        text = head
        texts.insert(0, last)
    return [text, *texts] if fields else []


def parse_fields(kind: str, fields: Sequence[AddressField], text: str) -> LinkAddress:
    """Read what follows the kind in an address.

    Raise LinkError if a field is missing or wrong; gives an example.
    """
    values: dict[str, str | int] = {}
    example, problem = [kind], ""
    for field, part in zip(fields, split_fields(fields, text), strict=True):
        try:
            values[field.name] = field.parse(part)
            example.append(part or field.example)
        except LinkError as error:
            problem = problem or str(error)
            example.append(field.example)
    if problem:
        raise LinkError(f"'{kind}:{text}': {problem}; write for example {':'.join(example)}")
    return LinkAddress(kind=kind, **values)  # type: ignore[arg-type]

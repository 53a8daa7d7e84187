"""The LINK grammar: how a link is named everywhere in the program."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

from gsapp.foundation import LinkError
from gsapp.foundation.name_suggestions import close_matches

LinkKind = Literal["udpin", "udpout", "tcp", "tcpin", "serial", "text", "virtual", "flight"]

LOOPBACK: Final = "127.0.0.1"
LINK_GRAMMAR: Final = (
    "udpin:HOST:PORT, udpout:HOST:PORT, tcp:HOST:PORT, tcpin:HOST:PORT, serial:PATH:BAUD, "
    "text:PATH:BAUD, virtual, or the path of a flight"
)
_NETWORK: Final = {"udpin": 14550, "udpout": 14550, "tcp": 5760, "tcpin": 5760}
_SERIAL: Final = ("serial", "text")
_LOWEST_BAUD, _HIGHEST_BAUD = 300, 12_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkAddress:
    """A link, taken apart.

    Attributes
    ----------
    kind : str
        ``udpin``, ``udpout``, ``tcp``, ``tcpin``, ``serial``, ``text``, ``virtual`` or
        ``flight``.
    host : str
        Host name or address of a network link.
    port : int
        Its port; 0 for other kinds.
    path : str
        Serial port or flight.
    baud : int
        Symbols per second of a serial port; 0 for other kinds.
    """

    kind: LinkKind
    host: str = ""
    port: int = 0
    path: str = ""
    baud: int = 0

    def __str__(self) -> str:
        """Return the address as it would be written."""
        if self.kind in _NETWORK:
            host = f"[{self.host}]" if ":" in self.host else self.host
            return f"{self.kind}:{host}:{self.port}"
        if self.kind in _SERIAL:
            return f"{self.kind}:{self.path}:{self.baud}"
        return self.path if self.kind == "flight" else self.kind


def parse_link(text: str) -> LinkAddress:
    """Read a LINK.

    Parameters
    ----------
    text : str
        For example ``udpin:0.0.0.0:14550`` or ``serial:/dev/ttyUSB0:57600``. A network link
        without a host (``udpin:14550``) is on this computer only. A path that exists is a
        flight.

    Returns
    -------
    LinkAddress
        The parts.

    Raises
    ------
    LinkError
        If it is none of these; says what to write instead.
    """
    text = text.strip()
    kind, colon, rest = text.partition(":")
    if kind in _NETWORK:
        return _network(kind, rest)
    if kind in _SERIAL:
        return _serial(kind, rest)
    if text == "virtual":
        return LinkAddress(kind="virtual")
    if text and _path_exists(text):
        return LinkAddress(kind="flight", path=text)
    if not text:
        raise LinkError(f"a link is missing; write {LINK_GRAMMAR}")
    near = close_matches(kind, (*_NETWORK, *_SERIAL, "virtual"), most=1)
    if near:
        example = near[0] + (f":{rest}" if colon and near[0] != "virtual" else "")
        raise LinkError(
            f"'{text}' is not a link; did you mean '{example}'? A link is {LINK_GRAMMAR}"
        )
    raise LinkError(f"'{text}' is neither a link nor a flight that exists; write {LINK_GRAMMAR}")


def _path_exists(text: str) -> bool:
    try:
        return Path(text).exists()
    except OSError as error:
        raise LinkError(
            f"'{text}' is not a link, and as the path of a flight it cannot be opened "
            f"({error.strerror}); write {LINK_GRAMMAR}"
        ) from error


def _parse_int(text: str) -> int | None:
    """Return a whole number of plain digits; None where it is none."""
    if not (text.isascii() and text.isdigit()):
        return None
    # No port and no rate is as long, and Python refuses to read thousands of digits.
    return int(text[:20])


def _network(kind: str, rest: str) -> LinkAddress:
    host, _, port = rest.rpartition(":")
    usual = _NETWORK[kind]
    number = _parse_int(port)
    if number is None:
        raise LinkError(
            f"'{kind}:{rest}' lacks its port; write for example {kind}:{rest or LOOPBACK}:{usual}"
        )
    if not 1 <= number <= 65535:
        raise LinkError(
            f"port {port} of '{kind}:{rest}' does not exist; choose one between 1 and 65535, "
            f"usually {usual}"
        )
    host = host.removeprefix("[").removesuffix("]")
    if any(character.isspace() or character in "/\\" for character in host):
        raise LinkError(
            f"'{host}' in '{kind}:{rest}' is not a host name; write for example "
            f"{kind}:{LOOPBACK}:{number}"
        )
    return LinkAddress(kind=kind, host=host or LOOPBACK, port=number)  # type: ignore[arg-type]


def _serial(kind: str, rest: str) -> LinkAddress:
    path, _, baud = rest.rpartition(":")
    number = _parse_int(baud)
    if not path or number is None:
        example = rest.rstrip(":") or "/dev/ttyUSB0"
        raise LinkError(
            f"'{kind}:{rest}' lacks its baud rate; write for example {kind}:{example}:57600"
        )
    if not _LOWEST_BAUD <= number <= _HIGHEST_BAUD:
        raise LinkError(
            f"{baud} baud in '{kind}:{rest}' is not a rate of a serial port; usual are 57600, "
            "115200 and 460800"
        )
    return LinkAddress(kind=kind, path=path, baud=number)  # type: ignore[arg-type]

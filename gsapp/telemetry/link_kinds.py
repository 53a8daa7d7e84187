"""Kinds of links and their addresses: how each is written, opened, recorded, diagnosed and shown.

Further kinds come from other packages, see `gsapp.telemetry.link_registry`.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from os.path import normcase
from pathlib import Path
from typing import TYPE_CHECKING, Final, Literal, Protocol

from gsapp.foundation import LinkError

if TYPE_CHECKING:
    from gsapp.telemetry.sources.link_source import LinkSource


class PortInfo(Protocol):
    """What is known of a serial port that is plugged in."""

    device: str
    serial_number: str | None
    vid: int | None
    pid: int | None


def is_same_port(one: str, other: str) -> bool:
    """Return whether two names are those of one serial port.

    Windows calls it COM5 however the user wrote it; macOS has two devices for each, of which it
    lists ``/dev/cu.*`` only.
    """
    first, second = (normcase(name.replace("/dev/tty.", "/dev/cu.")) for name in (one, other))
    return first == second


def list_serial_ports() -> Iterable[PortInfo]:
    """Return the serial ports of this computer."""
    from serial.tools import list_ports

    ports: Iterable[PortInfo] = list_ports.comports()
    return ports


def describe_port(port: object) -> str:
    """Return a port's name and what its USB device says of itself: product, maker, serial number.

    The port has some of the attributes of a `serial.tools.list_ports_common.ListPortInfo`.
    """
    name = str(getattr(port, "device", ""))
    known = [str(getattr(port, key, None) or "") for key in ("description", "manufacturer")]
    words = [each for each in known if each not in ("", "n/a", name)]
    if number := getattr(port, "serial_number", None):
        words.append(f"serial number {number}")
    return f"{name} ({', '.join(dict.fromkeys(words))})" if words else name


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


# ruff: noqa: ARG002 - overridden methods, which use their arguments or not


Framing = Literal["mavlink", "text"]
PortLister = Callable[[], Iterable[object]]
"""Gives the serial ports of this computer."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkKind:
    """A kind of link."""

    name: str  # What its addresses begin with.
    fields: tuple[AddressField, ...]  # What follows in an address, separated by colons.
    source: str  # ``module:class`` of its `LinkSource`, imported when a link is opened.
    framing: Framing = "mavlink"
    """What is recorded: MAVLink frames (``raw.tlog``) or lines of text (``raw.txt``)."""
    title: str = ""  # What the connect dialog calls it; empty where the dialog does not offer it.
    help: str = ""  # What it does, in a sentence.
    channel_map: str = ""
    """Channel map where the user names none: the name of a shipped one, or a path."""
    needs_heartbeat: bool = False
    """Whether nothing comes before the ground station has sent something."""
    is_copy: bool = False
    """Whether it copies what another recorder records, with the stamps of that one."""
    is_physical: bool = True
    """Whether there is something at the other end. False for data made on this computer, whose
    speed can be chosen."""

    @property
    def grammar(self) -> str:
        """Return how an address is written: ``udpin:HOST:PORT``."""
        return ":".join([self.name, *(field.metavar for field in self.fields)])

    @property
    def example(self) -> str:
        return ":".join([self.name, *(field.example for field in self.fields)])

    @property
    def accepts_commands(self) -> bool:
        """Return whether MAVLink that is sent can reach an autopilot."""
        return self.framing == "mavlink" and self is not RECORDED_FLIGHT and not self.is_copy

    def parse(self, text: str) -> LinkAddress:
        """Read what follows the name in an address; raise LinkError if it is none."""
        return parse_fields(self.name, self.fields, text)

    def source_class(self) -> type[LinkSource]:
        module, _, name = self.source.partition(":")
        try:
            found: type[LinkSource] = getattr(importlib.import_module(module), name)
        except (ImportError, AttributeError) as error:
            raise LinkError(f"link kind '{self.name}' cannot be opened: {error}") from error
        return found

    def location(self, address: LinkAddress) -> str:
        """Return the port in words."""
        return str(address)

    def no_data_remedy(self, address: LinkAddress, list_ports: PortLister) -> str:
        """Return what to try where nothing comes at all."""
        return "Check that the sender is switched on and connected."

    def content_remedy(self, address: LinkAddress, content: str) -> str:
        """Return what to try where something else comes than is recorded."""
        return f"Set the sender to {'MAVLink' if self.framing == 'mavlink' else 'lines of text'}."

    def conflicts_with(
        self,
        address: LinkAddress,
        other_kind: LinkKind,
        other: LinkAddress,
    ) -> bool:
        """Return whether two links need one port of this computer for themselves."""
        return False

    def caution(self, address: LinkAddress, ports: Iterable[str]) -> str:
        """Return what to consider before connecting, given the serial ports; empty for nothing."""
        return ""

    def description(self, address: LinkAddress) -> str:
        """Return what such a link does, in a sentence."""
        return self.help


@dataclass(frozen=True, slots=True, kw_only=True)
class NetworkLink(LinkKind):
    """A link over the network; `listens` if the aircraft contacts this computer."""

    protocol: Literal["UDP", "TCP"]
    listens: bool = False

    def location(self, address: LinkAddress) -> str:
        if self.listens:
            return f"{self.protocol} port {address.port} of {address.host}"
        return f"{self.protocol} {address.host} port {address.port}"

    def no_data_remedy(self, address: LinkAddress, list_ports: PortLister) -> str:
        if self.is_copy:
            return "Check that the recorder there receives data."
        if not self.listens:
            return (
                f"Check that the aircraft is on the network, and that it uses port {address.port}."
            )
        does = "send to" if self.protocol == "UDP" else "connect to"
        if _is_loopback(address):
            return (
                f"Only programs on this computer can {does} {address.host}; for a sender on the "
                f"network use {replace(address, host='0.0.0.0')}."  # noqa: S104
            )
        return (
            f"Let the aircraft {does} this computer, port {address.port} "
            f"({self.fields[-1].example} is usual), and allow it in the firewall."
        )

    def conflicts_with(
        self, address: LinkAddress, other_kind: LinkKind, other: LinkAddress
    ) -> bool:
        return (
            isinstance(other_kind, NetworkLink)
            and self.listens
            and other_kind.listens
            and (self.protocol, address.port) == (other_kind.protocol, other.port)
        )

    def caution(self, address: LinkAddress, ports: Iterable[str]) -> str:
        if self.listens and address.host == "0.0.0.0":  # noqa: S104
            return "Listens on the whole network: anyone on it can send."
        return ""

    def description(self, address: LinkAddress) -> str:
        if self.listens and _is_loopback(address):
            return "Listens on this computer only; address 0.0.0.0 listens on the network."
        return self.help


def _is_loopback(address: LinkAddress) -> bool:
    return address.host.startswith("127.") or address.host in ("localhost", "::1")


@dataclass(frozen=True, slots=True, kw_only=True)
class SerialLink(LinkKind):
    """A link over a serial port."""

    fields: tuple[AddressField, ...] = (SERIAL_PORT, BAUD)
    source: str = "gsapp.telemetry.sources.serial_port:SerialSource"

    def location(self, address: LinkAddress) -> str:
        return f"{address.path} ({address.baud:,} baud)"

    def no_data_remedy(self, address: LinkAddress, list_ports: PortLister) -> str:
        try:
            others = [
                describe_port(port)
                for port in list_ports()
                if not is_same_port(str(getattr(port, "device", "")), address.path)
            ]
        except OSError:
            others = []
        listed = f"Other ports: {'; '.join(others)}." if others else "There is no other port."
        return (
            "Check that the aircraft is on and its radio linked, and that this is the right port. "
            + listed
        )

    def content_remedy(self, address: LinkAddress, content: str) -> str:
        if content == "mavlink":
            return f"To record MAVLink, use {replace(address, kind='serial')}."
        if content == "text":
            return (
                f"To record text, use {replace(address, kind='text')}. Otherwise set the sender to "
                "MAVLink (ArduPilot: SERIALn_PROTOCOL = 2)."
            )
        return (
            f"{address.baud:,} baud is probably wrong: set the rate of the radio or autopilot (SiK "
            "radio 57,600; USB 115,200). Otherwise check the wiring."
        )

    def conflicts_with(
        self, address: LinkAddress, other_kind: LinkKind, other: LinkAddress
    ) -> bool:
        return isinstance(other_kind, SerialLink) and is_same_port(address.path, other.path)

    def caution(self, address: LinkAddress, ports: Iterable[str]) -> str:
        # Not every port is listed: a name that the system's rules give it is a link to it.
        if any(is_same_port(address.path, port) for port in ports) or Path(address.path).exists():
            return ""
        return f"{address.path} is not connected; it opens as soon as it is plugged in."


BUILT_IN_KINDS: Final[tuple[LinkKind, ...]] = (
    NetworkLink(
        name="udpin", fields=(HOST, UDP_PORT), protocol="UDP", listens=True,
        source="gsapp.telemetry.sources.network:UdpInSource",
        title="UDP: the aircraft sends here",
        help="Listens on this port until the aircraft sends.",
    ),
    NetworkLink(
        name="udpout", fields=(HOST, UDP_PORT), protocol="UDP", needs_heartbeat=True,
        source="gsapp.telemetry.sources.network:UdpOutSource",
        title="UDP: call the aircraft",
        help="Calls this address until the aircraft answers.",
    ),
    NetworkLink(
        name="tcp", fields=(HOST, TCP_PORT), protocol="TCP",
        source="gsapp.telemetry.sources.network:TcpSource",
        title="TCP: connect to it",
        help="Connects, and reconnects when the link is lost.",
    ),
    NetworkLink(
        name="tcpin", fields=(HOST, TCP_PORT), protocol="TCP", listens=True,
        source="gsapp.telemetry.sources.network:TcpInSource",
        title="TCP: it connects here",
        help="Waits for the aircraft to connect.",
    ),
    SerialLink(
        name="serial",
        title="Serial port, MAVLink",
        help="MAVLink over the serial port; reconnects after it was unplugged.",
    ),
    SerialLink(
        name="text", framing="text",
        title="Serial port, lines of text",
        help="Comma-separated text over the serial port; your channel map assigns its columns.",
    ),
    NetworkLink(
        name="gsapp", fields=(HOST, replace(TCP_PORT, example="5770")), protocol="TCP",
        is_copy=True, source="gsapp.telemetry.sources.flight_copy:FlightCopySource",
        title="Another recording of this program",
        help="Copies a flight that another computer records and shares, from its beginning.",
    ),
    LinkKind(
        name="virtual", fields=(), is_physical=False,
        source="gsapp.virtual.downlink.virtual_source:VirtualSource",
        help="The virtual aircraft of this program.",
    ),
)  # fmt: skip

RECORDED_FLIGHT: Final = LinkKind(
    name="flight",
    fields=(),
    source="gsapp.telemetry.sources.recorded_flight:RecordedSource",
    help="A recorded flight.",
    is_physical=False,
)
"""A path that exists, without a kind before it."""

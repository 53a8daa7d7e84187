"""Kinds of links: one record says how each is written, opened, recorded, diagnosed and shown.

Further kinds come from other packages, see `gsapp.telemetry.link_registry`.
"""

# ruff: noqa: ARG002 - overridden methods, which use their arguments or not

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final, Literal

from gsapp.foundation import LinkError
from gsapp.telemetry.link_address import (
    BAUD,
    HOST,
    SERIAL_PORT,
    TCP_PORT,
    UDP_PORT,
    AddressField,
    LinkAddress,
    parse_fields,
)
from gsapp.telemetry.serial_ports import describe_port, is_same_port

if TYPE_CHECKING:
    from gsapp.telemetry.sources.link_source import LinkSource

Framing = Literal["mavlink", "text"]


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
        return self.framing == "mavlink" and self is not RECORDED_FLIGHT

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

    def no_data_remedy(
        self,
        address: LinkAddress,
        list_ports: Callable[[], Iterable[object]],
    ) -> str:
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

    def no_data_remedy(
        self, address: LinkAddress, list_ports: Callable[[], Iterable[object]]
    ) -> str:
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

    def no_data_remedy(
        self, address: LinkAddress, list_ports: Callable[[], Iterable[object]]
    ) -> str:
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
        source="gsapp.telemetry.sources.udp:UdpInSource",
        title="UDP: the aircraft sends here",
        help="Listens on this port until the aircraft sends.",
    ),
    NetworkLink(
        name="udpout", fields=(HOST, UDP_PORT), protocol="UDP", needs_heartbeat=True,
        source="gsapp.telemetry.sources.udp:UdpOutSource",
        title="UDP: call the aircraft",
        help="Calls this address until the aircraft answers.",
    ),
    NetworkLink(
        name="tcp", fields=(HOST, TCP_PORT), protocol="TCP",
        source="gsapp.telemetry.sources.tcp:TcpSource",
        title="TCP: connect to it",
        help="Connects, and reconnects when the link is lost.",
    ),
    NetworkLink(
        name="tcpin", fields=(HOST, TCP_PORT), protocol="TCP", listens=True,
        source="gsapp.telemetry.sources.tcp:TcpInSource",
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

"""What is wrong with a link over which no aircraft is heard, and what to try."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Final, Literal

from gsapp.decoding.frames import MavlinkFrame
from gsapp.decoding.framing import Framer
from gsapp.telemetry.link_address import LinkAddress, parse_link
from gsapp.telemetry.recorder_status import LinkContent, RecorderStatus
from gsapp.telemetry.sources.serial_port import describe_port, is_same_port, list_serial_ports

LinkProblem = Literal["closed", "no-data", "unreadable", "text", "mavlink", "no-aircraft"]

_SAMPLE_BYTES: Final = 4096
_ENOUGH_BYTES: Final = 64
"""Fewer bytes say nothing of what they are."""
_PRINTABLE: Final = frozenset((*range(0x20, 0x7F), *b"\t\r\n"))
_PRINTABLE_SHARE: Final = 0.95


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkDiagnosis:
    """Why no aircraft is heard.

    Attributes
    ----------
    problem : str
        ``closed``: the port is not open; ``no-data``: it is, and nothing comes; ``unreadable``,
        ``text``, ``mavlink``: something else comes than the link is for; ``no-aircraft``: MAVLink,
        but not of an aircraft.
    found : str
        What has come, where and for how long, in a sentence.
    remedy : str
        What to try, in sentences; empty where `found` says it.
    """

    problem: LinkProblem
    found: str
    remedy: str = ""

    def __str__(self) -> str:
        """Return all of it."""
        return f"{self.found} {self.remedy}".strip()


class ContentSample:
    """The last bytes of a link, kept to tell what they are."""

    def __init__(self) -> None:
        self._data = b""

    def feed(self, data: bytes) -> None:
        """Keep the next bytes of the stream."""
        # One thread feeds and another asks: bytes do not change while they are looked at.
        self._data = (self._data + data)[-_SAMPLE_BYTES:]

    @property
    def kind(self) -> LinkContent:
        """Return what the bytes are; empty while they are too few to tell."""
        return _kind_of(self._data)


def _kind_of(data: bytes) -> LinkContent:
    framer = Framer()
    if any(
        isinstance(item, MavlinkFrame) and item.known
        for item in (*framer.feed(data), *framer.flush())
    ):
        return "mavlink"
    if len(data) < _ENOUGH_BYTES:
        return ""
    printable = sum(byte in _PRINTABLE for byte in data)
    return "text" if printable >= _PRINTABLE_SHARE * len(data) else "unreadable"


def diagnose_link(
    status: RecorderStatus,
    *,
    others: Iterable[str] = (),
    list_ports: Callable[[], Iterable[object]] = list_serial_ports,
) -> LinkDiagnosis | None:
    """Return why no aircraft is heard; None where the link carries what it is for.

    Parameters
    ----------
    status : RecorderStatus
        How the link fares.
    others : iterable of str
        Who is heard in place of an aircraft, in words; for MAVLink.
    list_ports : callable
        Gives the serial ports of this computer.
    """
    address = parse_link(status.link)
    if address.kind in ("virtual", "flight"):
        return None
    if not status.connected:
        return LinkDiagnosis(problem="closed", found=f"{status.source_state}.")
    text = address.kind == "text"
    if not status.received_bytes:
        since = (status.updated_us - status.started_us) / 1e6
        return LinkDiagnosis(
            problem="no-data",
            found=f"No data on {_port(address)} for {_seconds(since)}.",
            remedy=_no_data_remedy(address, list_ports),
        )
    amount = _bytes(status.received_bytes)
    if status.content == "text" and not text:
        return LinkDiagnosis(
            problem="text",
            found=f"{_port(address)} sends lines of text, not MAVLink ({amount}).",
            remedy=f"To record text, use text:{address.path}:{address.baud}. Otherwise set the "
            "sender to MAVLink (ArduPilot: SERIALn_PROTOCOL = 2)."
            if address.kind == "serial"
            else "Set the sender to MAVLink.",
        )
    if status.content == "mavlink" and text:
        return LinkDiagnosis(
            problem="mavlink",
            found=f"{_port(address)} sends MAVLink, not lines of text ({amount}).",
            remedy=f"To record MAVLink, use serial:{address.path}:{address.baud}.",
        )
    if status.content == "unreadable":
        wanted = "line of text" if text else "MAVLink frame"
        return LinkDiagnosis(
            problem="unreadable",
            found=f"{_port(address)} has sent {amount}, but no {wanted}.",
            remedy=f"{address.baud:,} baud is probably wrong: set the rate of the radio or "
            "autopilot (SiK radio 57,600; USB 115,200). Otherwise check the wiring."
            if address.baud
            else "Set the sender to MAVLink.",
        )
    if heard := ", ".join(others):
        return LinkDiagnosis(
            problem="no-aircraft",
            found=f"No aircraft on {_port(address)}: only {heard}.",
            remedy="Switch on the aircraft, and check that its radio is linked.",
        )
    return None


def _port(address: LinkAddress) -> str:
    if address.baud:
        return f"{address.path} ({address.baud:,} baud)"
    protocol = "UDP" if address.kind.startswith("udp") else "TCP"
    if address.kind in ("udpin", "tcpin"):
        return f"{protocol} port {address.port} of {address.host}"
    return f"{protocol} {address.host} port {address.port}"


def _no_data_remedy(address: LinkAddress, list_ports: Callable[[], Iterable[object]]) -> str:
    """Return what to try where nothing comes at all."""
    if address.baud:
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
    if address.kind in ("udpin", "tcpin"):
        does = "send to" if address.kind == "udpin" else "connect to"
        if address.host in ("127.0.0.1", "localhost", "::1"):
            return (
                f"Only programs on this computer can {does} {address.host}; for a sender on the "
                f"network use {address.kind}:0.0.0.0:{address.port}."
            )
        return (
            f"Let the aircraft {does} this computer, port {address.port} (14550 is usual), and "
            "allow it in the firewall."
        )
    return f"Check that the aircraft is on the network, and that it uses port {address.port}."


def _seconds(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 120.0 else f"{seconds / 60.0:.0f} min"


def _bytes(count: int) -> str:
    return f"{count:,} bytes" if count < 100_000 else f"{count / 1e6:.1f} MB"

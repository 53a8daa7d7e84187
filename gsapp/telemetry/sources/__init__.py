"""Where data come from: one registry of sources, loaded when they are needed."""

from __future__ import annotations

import importlib
from typing import Any, Final

from gsapp.telemetry.clock import Clock, HostClock
from gsapp.telemetry.link_address import LinkAddress, parse_link
from gsapp.telemetry.sources.link_source import Chunk, LinkSource, LinkUnavailableError

__all__ = ["SOURCES", "Chunk", "LinkSource", "LinkUnavailableError", "open_source", "source_class"]

SOURCES: Final[dict[str, tuple[str, str]]] = {
    "udpin": ("gsapp.telemetry.sources.udp", "UdpInSource"),
    "udpout": ("gsapp.telemetry.sources.udp", "UdpOutSource"),
    "tcp": ("gsapp.telemetry.sources.tcp", "TcpSource"),
    "tcpin": ("gsapp.telemetry.sources.tcp", "TcpInSource"),
    "serial": ("gsapp.telemetry.sources.serial_port", "SerialSource"),
    "text": ("gsapp.telemetry.sources.serial_port", "TextSerialSource"),
    "flight": ("gsapp.telemetry.sources.recorded_flight", "RecordedSource"),
    "virtual": ("gsapp.virtual.downlink.virtual_source", "VirtualSource"),
}


def source_class(kind: str) -> type[LinkSource]:
    """Return the class of a kind of link, importing its module."""
    module, name = SOURCES[kind]
    found: type[LinkSource] = getattr(importlib.import_module(module), name)
    return found


def open_source(
    address: LinkAddress | str, *, clock: Clock | None = None, **options: Any
) -> LinkSource:
    """Make the source of a link. It connects with its first `read`, or with `open`.

    Parameters
    ----------
    address : LinkAddress or str
        The link.
    clock : Clock, optional
        Where stamps and waits come from; the computer's clock by default.
    **options
        Handed to the source, for example ``speed`` of a recorded flight.

    Raises
    ------
    LinkError
        If the address is none.
    """
    link = parse_link(address) if isinstance(address, str) else address
    return source_class(link.kind)(link, clock=clock or HostClock(), **options)

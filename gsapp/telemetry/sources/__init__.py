"""Where data come from: a source for each kind of link, imported when it is opened."""

from __future__ import annotations

from typing import Any

from gsapp.telemetry.clock import Clock, HostClock
from gsapp.telemetry.link_kinds import LinkAddress
from gsapp.telemetry.link_registry import kind_of, parse_link
from gsapp.telemetry.sources.link_source import Chunk, LinkSource, LinkUnavailableError

__all__ = ["Chunk", "LinkSource", "LinkUnavailableError", "open_source"]


def open_source(
    address: LinkAddress | str, *, clock: Clock | None = None, **options: Any
) -> LinkSource:
    """Make the source of a link. It connects with its first `read`, or with `open`.

    Options are handed to the source, for example ``speed`` of a recorded flight. Stamps and waits
    come from the computer's clock by default. Raise LinkError if the address is none.
    """
    link = parse_link(address) if isinstance(address, str) else address
    kind = kind_of(link)
    source = kind.source_class()(link, clock=clock or HostClock(), **options)
    source.framing = kind.framing
    return source

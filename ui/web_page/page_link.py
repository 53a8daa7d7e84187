"""The address of a page for browsers, written as a link."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from gsapp.foundation import LinkError
from gsapp.telemetry.link_kinds import HOST, TCP_PORT, LinkAddress, parse_fields
from ui.translation import tr

_KIND: Final = "http"
_FIELDS: Final = (HOST, replace(TCP_PORT, example="8080"))


def is_page_link(link: str) -> bool:
    """Return whether a text is meant as the address of a page."""
    return link.strip().partition(":")[0] == _KIND


def parse_page_link(link: str) -> LinkAddress:
    """Read ``http:HOST:PORT``; raise LinkError if it is none."""
    kind, _, rest = link.strip().partition(":")
    if kind != _KIND:
        raise LinkError(
            tr("'{link}' is not the address of a page; write http:HOST:PORT").format(link=link)
        )
    return parse_fields(_KIND, _FIELDS, rest)

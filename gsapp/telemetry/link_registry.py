"""The kinds of links: those of the program, and those of installed packages.

A package adds a kind with an entry point of the group ``gsapp.links``, whose name is that of the
kind and whose object is its `LinkKind`. It is imported when such a link is named, or all kinds are
listed.
"""

from __future__ import annotations

import logging
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Final

from gsapp.foundation import LinkError
from gsapp.foundation.name_suggestions import close_matches
from gsapp.telemetry.link_kinds import BUILT_IN_KINDS, RECORDED_FLIGHT, LinkAddress, LinkKind

log = logging.getLogger(__name__)

GROUP: Final = "gsapp.links"
_BUILT_IN: Final = {kind.name: kind for kind in (*BUILT_IN_KINDS, RECORDED_FLIGHT)}


@cache
def _entry_points() -> dict[str, EntryPoint]:
    return {point.name: point for point in entry_points(group=GROUP) if point.name not in _BUILT_IN}


@cache
def _load(name: str) -> LinkKind:
    point = _entry_points()[name]
    try:
        kind = point.load()
    except Exception as error:  # whatever a package of others does as it is imported
        raise LinkError(f"link kind '{name}' of {point.value} cannot be loaded: {error}") from error
    if not isinstance(kind, LinkKind) or kind.name != name:
        raise LinkError(f"{point.value} is not a LinkKind called '{name}'")
    return kind


def forget_packages() -> None:
    """Look for the kinds of other packages again."""
    _entry_points.cache_clear()
    _load.cache_clear()


def find_link_kind(name: str) -> LinkKind | None:
    """Return a kind of link, None if there is none of the name.

    Raise LinkError if it is one of another package, and cannot be loaded.
    """
    if name in _BUILT_IN:
        return _BUILT_IN[name]
    return _load(name) if name.isidentifier() and name in _entry_points() else None


def kind_of(address: LinkAddress) -> LinkKind:
    """Return the kind of a link."""
    kind = find_link_kind(address.kind)
    if kind is None:
        raise LinkError(f"'{address}' is not a link; write {link_grammar()}")
    return kind


def link_kinds() -> tuple[LinkKind, ...]:
    """Return all kinds, those of the program first; one that cannot be loaded is left out."""
    found = list(BUILT_IN_KINDS)
    for name in sorted(_entry_points()):
        try:
            found.append(_load(name))
        except LinkError as error:
            log.warning("%s", error)
    return tuple(found)


def link_grammar() -> str:
    """Return how links are written."""
    return ", ".join([*(kind.grammar for kind in link_kinds()), "or the path of a flight"])


def parse_link(text: str) -> LinkAddress:
    """Read a LINK, such as ``udpin:0.0.0.0:14550`` or ``serial:/dev/ttyUSB0:57600``.

    A network link without a host (``udpin:14550``) is on this computer only. A path that exists is
    a flight. Raise LinkError if it is none of these; says what to write instead.
    """
    text = text.strip()
    name, colon, rest = text.partition(":")
    kind = None if name == RECORDED_FLIGHT.name else find_link_kind(name)
    if kind is not None and (kind.fields or not colon):
        return kind.parse(rest)
    if text and _path_exists(text):
        return LinkAddress(kind=RECORDED_FLIGHT.name, path=text)
    if not text:
        raise LinkError(f"a link is missing; write {link_grammar()}")
    near = close_matches(name, [kind.name for kind in link_kinds()], most=1)
    if near:
        near_kind = find_link_kind(near[0])
        example = near[0] + (f":{rest}" if colon and near_kind and near_kind.fields else "")
        raise LinkError(
            f"'{text}' is not a link; did you mean '{example}'? A link is {link_grammar()}"
        )
    raise LinkError(f"'{text}' is neither a link nor a flight that exists; write {link_grammar()}")


def _path_exists(text: str) -> bool:
    try:
        return Path(text).exists()
    except OSError as error:
        raise LinkError(
            f"'{text}' is not a link, and as the path of a flight it cannot be opened "
            f"({error.strerror}); write {link_grammar()}"
        ) from error

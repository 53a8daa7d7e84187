"""Putting together what a vehicle says in words: a long text comes in numbered pieces."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final, NamedTuple

CHUNK_BYTES: Final = 50
"""Bytes of a piece after which another follows."""
_MISSING_CHUNK_MARK: Final = "…".encode()
_CHUNK_TIMEOUT_US: Final = 5_000_000
_MANY: Final = 1000


class StatusText(NamedTuple):
    """One text."""

    stamp_us: int
    """Host time of its last piece."""
    system: int
    component: int
    """Who said it."""
    severity: int
    """MAVLink's."""
    text: str
    """In words, with an ellipsis where pieces are missing."""


@dataclass(slots=True)
class _PartialText:
    stamp_us: int
    severity: int
    pieces: dict[int, bytes] = field(default_factory=dict)


class StatusTextAssembler:
    """Joins the pieces of texts by sender and number.

    A vehicle that restarts begins its numbers anew, and any piece may be lost: a text ends with a
    piece that is not full, when another of its number begins, or when nothing more of it comes for
    five seconds.
    """

    def __init__(self) -> None:
        self._parts: dict[tuple[int, int, int], _PartialText] = {}

    @property
    def has_pending(self) -> bool:
        """Return whether some text is not whole."""
        return bool(self._parts)

    def add_chunk(
        self,
        stamp_us: int,
        system: int,
        component: int,
        severity: int,
        number: int,
        place: int,
        piece: bytes,
    ) -> list[StatusText]:
        """Take one piece; return the texts that end by it.

        Parameters
        ----------
        stamp_us : int
            Host time of its arrival.
        system, component, severity : int
            See `StatusText`.
        number, place : int
            Of the text, 0 where it has one piece only, and of the piece in it.
        piece : bytes
            Without zero bytes at its end.
        """
        key = (system, component, number)
        ended: list[StatusText] = []
        parts = self._parts.get(key)
        if parts is not None and number and parts.pieces.get(place, piece) != piece:
            ended.append(self._end(key, whole=False))
            parts = None
        if parts is None:
            parts = self._parts[key] = _PartialText(stamp_us, severity)
        parts.stamp_us, parts.severity = stamp_us, severity
        parts.pieces[place] = piece
        if not number or len(piece) < CHUNK_BYTES:
            ended.append(self._end(key, whole=True))
        elif len(self._parts) > _MANY:
            ended.append(self._end(next(iter(self._parts)), whole=False))
        return ended

    def flush_overdue(self, now_us: int | None = None) -> list[StatusText]:
        """Return the texts of which nothing more came for long by a time; by default all."""
        late = [
            key
            for key, parts in self._parts.items()
            if now_us is None or now_us - parts.stamp_us > _CHUNK_TIMEOUT_US
        ]
        return [self._end(key, whole=False) for key in late]

    def _end(self, key: tuple[int, int, int], *, whole: bool) -> StatusText:
        parts = self._parts.pop(key)
        data, due = b"", 0
        for place in sorted(parts.pieces):
            data += (_MISSING_CHUNK_MARK if place != due else b"") + parts.pieces[place]
            due = place + 1
        if not whole:
            data += _MISSING_CHUNK_MARK
        words = data.decode("utf-8", "replace").strip()
        return StatusText(parts.stamp_us, key[0], key[1], parts.severity, words)

"""What the vehicle says, and what is noticed about it, while decoding."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Final, NamedTuple

from gsapp.decoding.flight_clock import ClockEvent
from gsapp.decoding.messages import decode_columns
from gsapp.decoding.settings import DECODING

CHUNK_BYTES: Final = 50
"""Bytes of a piece after which another follows."""
_MISSING_CHUNK_MARK: Final = "…".encode()
_MANY: Final = 1000


class StatusText(NamedTuple):
    """One text."""

    stamp_us: int  # Host time of its last piece.
    system: int
    component: int
    """Who said it."""
    severity: int  # MAVLink's.
    text: str  # In words, with an ellipsis where pieces are missing.


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
        """Take one piece that came at a host time; return the texts that end by it.

        `number` is that of the text, 0 where it has one piece only, `place` that of the piece in
        it. The piece has no zero bytes at its end.
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
        late = [
            key
            for key, parts in self._parts.items()
            if now_us is None or now_us - parts.stamp_us > DECODING.chunk_timeout
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
        text = data.decode("utf-8", "replace").strip()
        return StatusText(parts.stamp_us, key[0], key[1], parts.severity, text)


STATUSTEXT_ID: Final = 253
_MAX_KEYS = 1000

NOTICE_KINDS: Final = frozenset({
    "restart", "step", "outlier", "other-clock", "frozen-clock", "no-clock", "host-step",
    "other-system", "other-component", "unknown-message", "bad-line", "flown-system",
    "rejected-address", "rejected-unsigned", "rejected-false", "rejected-replayed",
})  # fmt: skip
"""Kinds of notices about what was recorded, beside what the vehicle says itself."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Notice:
    """Something said by the vehicle, or noticed about it, while decoding."""

    kind: str
    """``statustext`` for what the vehicle says, ``mode`` for a change of its flight mode, else one
    of `NOTICE_KINDS`; those of the clock are in `gsapp.decoding.flight_clock.ClockEvent`."""
    time: float | None  # Flight time, s; None if no clock was known yet.
    stamp_us: int  # Host time of the record, microseconds since 1970.
    text: str
    severity: int | None = None
    """MAVLink's severity, 0 emergency to 7 debug, of what the vehicle says."""
    system: int | None = None
    component: int | None = None


class NoticeLog:
    """Status messages of the vehicle, and notices, each kind of notice once per sender."""

    def __init__(self, flight_time_at: Callable[[int], float | None]) -> None:
        self.messages: list[Notice] = []
        self.modes: list[Notice] = []
        self.notices: list[Notice] = []
        self._flight_time_at = flight_time_at
        self._keys: set[tuple[str, int, int]] = set()
        self._texts = StatusTextAssembler()

    def add_status_text(self, host: int, system: int, component: int, payload: bytes) -> None:
        """Add a STATUSTEXT; long ones come in numbered chunks."""
        row = decode_columns(STATUSTEXT_ID, [payload])[0]
        number, place, severity = int(row["id"]), int(row["chunk_seq"]), int(row["severity"])
        chunk = bytes(row["text"])
        self._add_texts(
            self._texts.add_chunk(host, system, component, severity, number, place, chunk)
        )

    def flush_overdue(self, host: int | None = None) -> None:
        """Give texts out whose further chunks did not come in time; without a stamp, all."""
        if self._texts.has_pending:
            self._add_texts(self._texts.flush_overdue(host))

    def _add_texts(self, texts: Iterable[StatusText]) -> None:
        self.messages.extend(
            Notice(
                kind="statustext",
                time=self._flight_time_at(text.stamp_us),
                stamp_us=text.stamp_us,
                text=text.text,
                severity=text.severity,
                system=text.system,
                component=text.component,
            )
            for text in texts
        )

    def add_mode(self, host: int, system: int, component: int, mode: str) -> None:
        """Add that the vehicle changed its flight mode."""
        self.modes.append(
            Notice(
                kind="mode",
                time=self._flight_time_at(host),
                stamp_us=host,
                text=f"Flight mode {mode}",
                system=system,
                component=component,
            )
        )

    def add_clock_event(self, event: ClockEvent, host: int) -> None:
        self.notices.append(
            Notice(kind=event.kind, time=event.time / 1e6, stamp_us=host, text=event.text)
        )

    def add_once(
        self,
        key: tuple[str, int, int],
        host: int,
        text: str,
        *,
        system: int | None = None,
        component: int | None = None,
    ) -> None:
        """Add a notice of kind ``key[0]``, unless one with this key was added before."""
        if key in self._keys or len(self._keys) >= _MAX_KEYS:
            return
        self._keys.add(key)
        self.notices.append(
            Notice(
                kind=key[0],
                time=self._flight_time_at(host),
                stamp_us=host,
                text=text,
                system=system,
                component=component,
            )
        )

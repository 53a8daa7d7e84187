"""What the vehicle says, and what is noticed about it, while decoding."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Final

from gsapp.decoding.flight_clock import ClockEvent
from gsapp.decoding.messages import decode_columns
from gsapp.decoding.status_text import StatusText, StatusTextAssembler

STATUSTEXT_ID: Final = 253
_MAX_KEYS = 1000

NOTICE_KINDS: Final = frozenset({
    "restart", "step", "outlier", "other-clock", "frozen-clock", "no-clock", "host-step",
    "other-system", "other-component", "unknown-message", "bad-line",
})  # fmt: skip
"""Kinds of notices about what was recorded, beside what the vehicle says itself."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Notice:
    """Something said by the vehicle, or noticed about it, while decoding."""

    kind: str
    """``statustext`` for what the vehicle says, else one of `NOTICE_KINDS`; those of the clock are
    in `gsapp.decoding.flight_clock.ClockEvent`."""
    time: float | None
    """Flight time, s; None if no clock was known yet."""
    stamp_us: int
    """Host time of the record, microseconds since 1970."""
    text: str
    severity: int | None = None
    """MAVLink's severity, 0 emergency to 7 debug, of what the vehicle says."""
    system: int | None = None
    component: int | None = None


class NoticeLog:
    """Status messages of the vehicle, and notices, each kind of notice once per sender."""

    def __init__(self, flight_time_at: Callable[[int], float | None]) -> None:
        self.messages: list[Notice] = []
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

    def add_clock_event(self, event: ClockEvent, host: int) -> None:
        """Add what the clock of the vehicle did."""
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

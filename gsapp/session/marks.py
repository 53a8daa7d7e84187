"""Marks and notes on the time axis, kept in the flight's events file.

The file only grows, so an edit, a deletion and an undo are events of their own, and what stands
is found by going through them in order. Every window that watches the flight follows the same
file, so all of them show the same marks.
"""

from __future__ import annotations

import contextlib
import math
import uuid
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any, Final, Literal

from gsapp.decoding.decoder import Decoder
from gsapp.decoding.sender_filter import host_of
from gsapp.flight.events import (
    AUTHOR_KEY,
    MARK_EVENTS,
    Event,
    EventLog,
    clock_event,
    clock_readings,
    convert_to_flown_clock,
    event_address,
    event_system,
    selection_stamp,
    vehicle_event,
)
from gsapp.foundation import FlightError

MARK_EVENT: Final = "mark"
NOTE_EVENT: Final = "note"
EDIT_EVENT: Final = "edit"
DELETE_EVENT: Final = "delete"
UNDO_EVENT: Final = "undo"

MarkKind = Literal["mark", "note"]


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightMark:
    """A mark or a note as it stands."""

    id: str
    kind: MarkKind
    """A note has more to say than a label."""
    time: float | None
    """Flight time, s."""
    end: float | None
    """Where a span ends, s; None for a moment."""
    text: str
    host_time_us: int
    """When it was made, host time, microseconds since 1970."""
    author: str = ""
    """Name and network address of another computer on which it was made; empty for this one."""


class MarkStore:
    """The marks of a flight, for reading, making and changing.

    Parameters
    ----------
    clock_us : callable
        Host time in microseconds since 1970, for new events; None takes the system's.
    clock_at : callable
        Returns the flight time (s) of the system that a choice chose, at the host stamp (us) of
        that: what was written before waits for it. None as long as the record is not read so far;
        NaN where nobody knows.

    Attributes
    ----------
    other_events : list of Event
        Events of other kinds, in the order in which they were written.
    """

    def __init__(
        self,
        log: EventLog,
        clock_us: Callable[[], int] | None = None,
        clock_at: Callable[[Event, int], float | None] = lambda _choice, _stamp: math.nan,
    ) -> None:
        self._log = log
        self._clock_us = clock_us
        self._clock_at = clock_at
        self._waiting: list[Event] = []
        self.other_events: list[Event] = []
        self._all: list[Event] = []
        self._events: list[tuple[str, Event]] = []
        self._own: list[str] = []
        self._marks: tuple[FlightMark, ...] = ()
        self._undone: set[str] = set()

    @property
    def marks(self) -> tuple[FlightMark, ...]:
        """Return the marks that stand, by flight time; those without one come first."""
        return self._marks

    @property
    def events(self) -> tuple[Event, ...]:
        """Return every event of the file, in the order in which they were written."""
        return tuple(self._all)

    @property
    def damaged(self) -> int:
        """Return the number of lines of the file that could not be read."""
        return self._log.damaged

    def refresh(self) -> None:
        """See to it that `poll` takes in what other windows wrote until now."""
        self._log.refresh()

    def poll(self) -> list[Event]:
        """Take in what this and other windows wrote; return the events of other kinds."""
        others: list[Event] = []
        fresh = False
        self._waiting += self._log.poll()
        if not self._write_clock_readings():
            return others
        placed = convert_to_flown_clock(self._waiting)
        self._waiting.clear()
        for event in placed:
            self._all.append(event)
            if event.kind in MARK_EVENTS:
                self._events.append((self._id_of(event), event))
                fresh = True
            else:
                others.append(event)
        self.other_events += others
        if fresh:
            self._rebuild_marks()
        return others

    def add(
        self,
        time: float | None,
        text: str = "",
        *,
        end: float | None = None,
        kind: MarkKind = MARK_EVENT,
    ) -> FlightMark:
        """Make a mark at a flight time, or over a span of it.

        Raises
        ------
        FlightError
            If the file cannot be written.
        """
        data = {} if end is None else {"end": end}
        mark_id = self._write(kind, text, time, data)
        made = FlightMark(
            id=mark_id, kind=kind, time=time, end=end, text=text, host_time_us=self._now()
        )
        return next((mark for mark in self._marks if mark.id == mark_id), made)

    def edit(
        self,
        mark_id: str,
        *,
        text: str | None = None,
        time: float | None = None,
        end: float | None = None,
    ) -> None:
        """Change what is given of a mark."""
        data: dict[str, Any] = {"of": mark_id}
        if text is not None:
            data["text"] = text
        if time is not None:
            data["time"] = time
        if end is not None:
            data["end"] = end
        self._write(EDIT_EVENT, text or "", None, data)

    def delete(self, mark_id: str) -> None:
        """Take a mark away. It stays in the file, and `undo` brings it back."""
        self._write(DELETE_EVENT, "", None, {"of": mark_id})

    def undo(self) -> bool:
        """Take back the latest change made here that still stands; return whether there was one."""
        while self._own:
            event_id = self._own.pop()
            if event_id not in self._undone:
                self._write(UNDO_EVENT, "", None, {"of": event_id}, remember=False)
                return True
        return False

    def write(self, event: Event) -> None:
        """Append an event of another kind, for all windows to see."""
        self._log.append(replace(event, host_time_us=event.host_time_us or self._now()))

    def _write_clock_readings(self) -> bool:
        """Write which time it was, by its own clock, as a system was chosen.

        False while nobody knows yet.
        """
        told = clock_readings(self._waiting)
        for event in tuple(self._waiting):
            stamp = selection_stamp(event)
            if stamp is None or stamp in told:
                continue
            time = self._clock_at(event, stamp)
            if time is None:
                return False
            if math.isfinite(time):
                clock = clock_event(stamp, time)
                self._waiting.append(clock)
                with contextlib.suppress(FlightError):  # a full disk: its own alarm says so
                    self.write(clock)
        return True

    def _now(self) -> int:
        return 0 if self._clock_us is None else self._clock_us()

    def _write(
        self,
        kind: str,
        text: str,
        time: float | None,
        data: dict[str, Any],
        *,
        remember: bool = True,
    ) -> str:
        event_id = uuid.uuid4().hex
        self._log.append(
            Event(
                kind=kind,
                text=text,
                time=time,
                host_time_us=self._now(),
                data={"id": event_id, **data},
            )
        )
        if remember:
            self._own.append(event_id)
        # Read back rather than remembered, so that all windows fold the same file.
        self.poll()
        return event_id

    def _id_of(self, event: Event) -> str:
        given = event.data.get("id")
        return given if isinstance(given, str) and given else f"line-{len(self._events)}"

    def _rebuild_marks(self) -> None:
        self._undone = _undone_event_ids(self._events)
        marks: dict[str, FlightMark] = {}
        for event_id, event in self._events:
            if event_id in self._undone:
                continue
            if event.kind == MARK_EVENT or event.kind == NOTE_EVENT:
                marks[event_id] = FlightMark(
                    id=event_id,
                    kind=NOTE_EVENT if event.kind == NOTE_EVENT else MARK_EVENT,
                    time=event.time,
                    end=_number(event.data.get("end")),
                    text=event.text,
                    host_time_us=event.host_time_us,
                    author=str(event.data.get(AUTHOR_KEY, "")),
                )
                continue
            target = str(event.data.get("of", ""))
            if event.kind == DELETE_EVENT:
                marks.pop(target, None)
            elif event.kind == EDIT_EVENT and target in marks:
                marks[target] = _apply_edit(marks[target], event)
        self._marks = tuple(
            sorted(
                marks.values(),
                key=lambda mark: (
                    mark.time is not None,
                    mark.time or 0.0,
                    mark.host_time_us,
                    mark.id,
                ),
            )
        )


def _undone_event_ids(events: Iterable[tuple[str, Event]]) -> set[str]:
    """Return the events taken back; an undo may be taken back itself."""
    undone: set[str] = set()
    # From the last one on: whether an undo counts is settled by later ones.
    for event_id, event in reversed(list(events)):
        if event.kind == UNDO_EVENT and event_id not in undone:
            undone.add(str(event.data.get("of", "")))
    return undone


def _apply_edit(mark: FlightMark, event: Event) -> FlightMark:
    text = event.data.get("text")
    time = _number(event.data.get("time"))
    end = _number(event.data.get("end"))
    return replace(
        mark,
        text=text if isinstance(text, str) else mark.text,
        time=mark.time if time is None else time,
        end=mark.end if end is None else end,
    )


def _number(value: object) -> float | None:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return None
    return float(value)


class SystemSelection:
    """The flown system: that of the flight's settings, or what the crew chose in any window."""

    def __init__(
        self, system: int | None, address: str, decoder: Callable[[], Decoder | None]
    ) -> None:
        self._initial = self._chosen = (system, address)
        self._decoder = decoder

    @property
    def pending(self) -> tuple[int, str] | None:
        """Return the system that the crew has chosen since this session began, and its address.

        None where it has not, or chose the one that is decoded: else the flight is to be opened
        again, since all of it is read for the system chosen.
        """
        system, address = self._chosen
        return None if system is None or self._is_decoded(system, address) else (system, address)

    def _is_decoded(self, system: int | None, address: str) -> bool:
        decoder = self._decoder()
        if decoder is None:
            return (system, address) == self._initial
        found = decoder.health.addresses.get(system or 0, "")
        return decoder.system == system and address in ("", decoder.address, found, host_of(found))

    def select(self, system: int, address: str, marks: MarkStore) -> None:
        """Make a system the flown one, of the whole flight, for all windows and replays."""
        decoder, time, stamp = self._decoder(), None, 0
        is_known = decoder is not None and decoder.system is not None
        if decoder is not None and is_known and not self._is_decoded(system, address):
            stamp = decoder.health.last_stamp or 0
            time = decoder.flight_time_at(stamp)
        marks.write(vehicle_event(system, address, time=time, stamp_us=stamp))

    def apply_event(self, event: Event) -> None:
        """Take in a choice that this or another window wrote."""
        chosen = event_system(event)
        if chosen is not None:
            self._chosen = (chosen, event_address(event))
            decoder = self._decoder()
            if decoder is not None and self._is_decoded(*self._chosen):
                decoder.health.chosen = True  # which of several was in question

    def time_of(self, choice: Event, stamp_us: int) -> float | None:
        """Return the time by the clock of the system chosen; see `MarkStore`."""
        decoder = self._decoder()
        if decoder is None or (decoder.health.last_stamp or 0) < stamp_us:
            return None
        time = decoder.flight_time_at(stamp_us)
        is_decoded = self._is_decoded(event_system(choice), event_address(choice))
        return time if is_decoded and time is not None else math.nan

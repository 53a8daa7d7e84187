"""Marks and notes made where a flight is copied, on their way back to where it is recorded."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

from gsapp.flight.events import AUTHOR_KEY, MARK_EVENTS, Event, EventLog, events_path, mark_event_id
from gsapp.flight.settings import FLIGHT_DATA
from gsapp.telemetry.settings import TELEMETRY
from gsapp.telemetry.sources.link_source import LinkSource

_MADE: Final = MARK_EVENTS[:2]
"""Kinds that make a mark; the others change one."""
_TIMES: Final = ("time", "end")
_NAME_KEY: Final = "computer"


def encode_note(event: Event, computer: str) -> bytes:
    """Return what is sent of a mark or note, or of a change of one."""
    return json.dumps({**event.to_json(), _NAME_KEY: computer}).encode()


class NoteReceiver:
    """Writes the notes of another computer into the events of a flight.

    It may change what came from other computers, never what the crew made here.
    """

    def __init__(self, folder: Path, address: str) -> None:
        self._log = EventLog(events_path(folder))
        self._known: set[str] = set()
        self._foreign: set[str] = set()
        self._address = address
        self._credit = float(TELEMETRY.note_burst)
        self._counted = time.monotonic()

    def may_take(self) -> bool:
        """Return whether the rate allows another note now."""
        now = time.monotonic()
        earned = (now - self._counted) * TELEMETRY.note_rate
        self._credit = min(self._credit + earned, float(TELEMETRY.note_burst))
        self._counted = now
        return self._credit >= 1.0

    def take(self, content: bytes) -> None:
        """Write a note; raise ValueError where it is none, FlightError where the disk refuses."""
        self._credit -= 1.0
        for event in self._log.poll():
            if name := mark_event_id(event):
                self._known.add(name)
                if event.data.get(AUTHOR_KEY):
                    self._foreign.add(name)
        try:
            parsed = json.loads(content)
            event = Event.from_json(parsed)
        except RecursionError as error:
            raise ValueError("a note nests too deeply") from error
        name, target = mark_event_id(event), str(event.data.get("of"))
        if event.kind not in MARK_EVENTS or not name:
            raise ValueError("neither a mark nor a note")
        changes_own = event.kind not in _MADE and target not in self._foreign
        if name not in self._known and not changes_own:
            self._log.append(self._clean(event, name, parsed.get(_NAME_KEY)))

    def _clean(self, event: Event, name: str, computer: object) -> Event:
        """Return an event with nothing in it but a note."""
        computer = _plain_text(computer, TELEMETRY.max_author_length)
        author = f"{computer} ({self._address})" if computer else self._address
        data: dict[str, Any] = {"id": name, AUTHOR_KEY: author}
        for key in _TIMES:
            value = event.data.get(key)
            if isinstance(value, bool) or not isinstance(value, (int, float)):
                continue
            if abs(value) <= FLIGHT_DATA.max_time:
                data[key] = float(value)
        if event.kind not in _MADE:
            data["of"] = str(event.data["of"])
        if isinstance(event.data.get("text"), str):
            data["text"] = _plain_text(event.data["text"], TELEMETRY.max_note_length)
        moment = event.time if event.time is not None and math.isfinite(event.time) else None
        text = _plain_text(event.text, TELEMETRY.max_note_length)
        return Event(kind=event.kind, text=text, time=moment, data=data)


def _plain_text(text: object, length: int) -> str:
    """Return one line of what can be printed; empty where it is no text."""
    if not isinstance(text, str):
        return ""
    return "".join(one if one.isprintable() else " " for one in text[:length]).strip()


class EventExchange:
    """Events of a flight that is copied: those of its recorder are written, own notes offered."""

    def __init__(self, source: LinkSource) -> None:
        self._source = source
        self._log: EventLog | None = None
        self._events: list[Event] = []  # in the file
        self._names: set[str] = set()
        self._received: set[str] = set()

    def update(self, folder: Path) -> None:
        """Write what came, and offer what is new here; raise FlightError where that fails."""
        if self._source.sends_notes is None:
            return
        path = events_path(folder)
        if self._log is None or self._log.path != path:
            self._log, self._events, self._names = EventLog(path), [], set()
        is_complete = self._source.has_events
        self._read(self._log)
        while self._source.events:
            event = self._source.events[0]
            name = mark_event_id(event)
            self._received.add(name)
            if event not in self._events and not (name and name in self._names):
                self._log.append(event)
            self._source.events.popleft()  # written: where that fails it is tried again
        self._read(self._log)
        if is_complete:
            self._source.offer_notes(self._own_notes())

    def _read(self, log: EventLog) -> None:
        new = log.poll()
        self._events += new
        self._names |= {name for name in map(mark_event_id, new) if name}

    def _own_notes(self) -> Sequence[Event]:
        return [
            event
            for event in self._events
            if event.kind in MARK_EVENTS
            and (name := mark_event_id(event))
            and name not in self._received
        ]

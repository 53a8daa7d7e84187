"""Events of a flight: marks, notes, alarms, acknowledgments, one JSON object to a line.

The file only grows. Several windows and the recorder may append at once, and each may be killed
at any byte: a writer first closes a line that another left torn, and a reader skips what is
damaged and counts it.
"""

from __future__ import annotations

import json
import math
import os
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from gsapp.flight.file_names import EVENTS_FILE
from gsapp.flight.settings import FLIGHT_DATA
from gsapp.foundation import FlightError
from gsapp.foundation.errors import format_os_error
from gsapp.foundation.file_lock import exclusive_lock
from gsapp.foundation.files import GROUP_FILE_MODE, flush_to_disk

if TYPE_CHECKING:
    from gsapp.decoding.decoder import Notice


VEHICLE_EVENT: Final = "vehicle"
"""Kind of the event that chooses the flown system, in ``data["system"]``."""

CLOCK_EVENT: Final = "clock"
"""Kind of the event that tells the flight time of the system chosen, see `clock_event`."""

MARK_EVENTS: Final = ("mark", "note", "edit", "delete", "undo")
"""Kinds of the events that make marks and notes, and of those that change them."""

AUTHOR_KEY: Final = "from"
"""Among the data of a mark that was made on another computer: its name and network address."""

_TIME_KEYS: Final = frozenset({"end", "time", "raised", "t_input"})
"""Flight times among the data of an event."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Event:
    """Something that happened in a flight."""

    kind: str
    """``mark``, ``note``, ``alarm``, ``acknowledge``, ``vehicle`` (the flown system is chosen),
    ``status`` (said by the vehicle), ``mode``, ``parameters``, ``parameter`` (see
    `gsapp.flight.parameter_events`) ..."""
    text: str = ""
    time: float | None = None
    """Flight time, s; None where no vehicle time was known."""
    host_time_us: int = 0
    """Host time, microseconds since 1970 (UTC)."""
    data: Mapping[str, Any] = field(default_factory=dict)
    """Further values that JSON can hold."""

    def __post_init__(self) -> None:
        if not self.kind:
            raise ValueError("an event needs a kind, such as mark or note")
        object.__setattr__(self, "data", MappingProxyType(dict(self.data)))

    def to_json(self) -> dict[str, Any]:
        """Return what a line of the file holds; a time that is no number becomes null."""
        known = self.time is not None and math.isfinite(self.time)
        return {
            "time": self.time if known else None,
            "host_time_us": self.host_time_us,
            "kind": self.kind,
            "text": self.text,
            "data": dict(self.data),
        }

    @staticmethod
    def from_json(content: object) -> Event:
        """Return the event of a parsed line."""
        if not isinstance(content, dict):
            raise ValueError("a line of events holds no JSON object")
        kind, text = content.get("kind"), content.get("text", "")
        moment, host = content.get("time"), content.get("host_time_us", 0)
        data = content.get("data", {})
        if not (
            isinstance(kind, str) and kind and isinstance(text, str) and isinstance(data, dict)
        ):
            raise ValueError("an event needs a kind, a text and data")
        if moment is not None and (
            isinstance(moment, bool) or not isinstance(moment, (int, float))
        ):
            raise ValueError("the time of an event is a number or null")
        # Compared as it is: an int may have more digits than a float can hold.
        if moment is not None and not abs(moment) <= FLIGHT_DATA.max_time:
            raise ValueError("the time of an event is out of range")
        if isinstance(host, bool) or not isinstance(host, int) or not abs(host) < 1 << 63:
            raise ValueError("the host time of an event counts microseconds")
        return Event(
            kind=kind,
            text=text,
            time=None if moment is None else float(moment),
            host_time_us=host,
            data=data,
        )


def mark_event_id(event: Event) -> str:
    """Return the id of an event that makes or changes a mark; empty for other events."""
    name = event.data.get("id")
    valid = isinstance(name, str) and name.isalnum() and len(name) <= FLIGHT_DATA.max_id_length
    return str(name) if valid and event.kind in MARK_EVENTS else ""


def event_from_notice(notice: Notice) -> Event:
    """Return what the vehicle said, or was noticed about it, as an event."""
    return Event(
        kind="status" if notice.kind == "statustext" else notice.kind,
        text=notice.text,
        time=notice.time,
        host_time_us=notice.stamp_us,
        data={} if notice.severity is None else {"severity": notice.severity},
    )


def vehicle_event(
    system: int, address: str = "", *, time: float | None = None, stamp_us: int = 0
) -> Event:
    """Return the event by which the crew chooses the flown system of the whole flight.

    With a network address, HOST or HOST:PORT, only what comes from there is that system's.
    `time` is that of the system flown so far at the host stamp `stamp_us`, us: it relates the
    events before to the clock of the system chosen, see `convert_to_flown_clock`.
    """
    data: dict[str, Any] = {"system": system}
    if address:
        data["address"] = address
    if time is not None:
        data["stamp_us"] = stamp_us
    at = f" at {address}" if address else ""
    return Event(kind=VEHICLE_EVENT, text=f"Flown system: {system}{at}", time=time, data=data)


def event_system(event: Event) -> int | None:
    """Return the flown system that an event chooses; None for other events."""
    system = event.data.get("system") if event.kind == VEHICLE_EVENT else None
    valid = isinstance(system, int) and not isinstance(system, bool) and 0 < system < 256
    return system if valid else None


def event_address(event: Event) -> str:
    """Return the network address that an event chooses for the flown system; empty for any."""
    address = event.data.get("address", "")
    return address if isinstance(address, str) else ""


def read_selected_system(path: Path) -> tuple[int | None, str]:
    """Return the flown system that the crew chose last in an events file, and its address.

    None and an empty address if it never did.
    """
    try:
        events = read_events(path).events
    except FlightError:
        return None, ""  # whoever reads marks and notes reports it
    for event in reversed(events):
        if (system := event_system(event)) is not None:
            return system, event_address(event)
    return None, ""


def selection_stamp(event: Event) -> int | None:
    """Return the host stamp (us) at which another system was chosen; None for other events."""
    stamp = event.data.get("stamp_us")
    is_choice = event_system(event) is not None and event.time is not None
    return stamp if is_choice and isinstance(stamp, int) else None


def clock_event(stamp_us: int, time: float) -> Event:
    """Return the event that tells the flight time (s) of the system chosen at a host stamp (us)."""
    return Event(kind=CLOCK_EVENT, time=time, data={"stamp_us": stamp_us})


def clock_readings(events: Iterable[Event]) -> dict[int, float]:
    """Return the flight times (s) of the systems chosen, by the host stamp (us) of the choice."""
    told: dict[int, float] = {}
    for event in events:
        stamp = event.data.get("stamp_us")
        if event.kind == CLOCK_EVENT and event.time is not None and isinstance(stamp, int):
            told.setdefault(stamp, event.time)
    return told


def convert_to_flown_clock(events: Sequence[Event]) -> tuple[Event, ...]:
    """Return events, in the order written, by the clock of the system flown now.

    Flight time is the clock of the flown system: what was written before another was chosen carries
    the clock of the former one, and is moved where both are known at the choice.
    """
    told = clock_readings(events)
    shift = 0.0
    moved: list[Event] = []
    for event in reversed(events):
        stamp = selection_stamp(event)
        if stamp in told and event.time is not None:
            shift += told[stamp] - event.time
        moved.append(
            event if abs(shift) < FLIGHT_DATA.same_clock_tolerance else _shift_event(event, shift)
        )
    return tuple(reversed(moved))


def _shift_event(event: Event, shift: float) -> Event:
    times = {
        key: value + shift
        for key, value in event.data.items()
        if key in _TIME_KEYS and isinstance(value, (int, float)) and not isinstance(value, bool)
    }
    time = None if event.time is None else event.time + shift
    return replace(event, time=time, data={**event.data, **times})


def sort_events(events: Iterable[Event]) -> tuple[Event, ...]:
    """Return events by flight time.

    Those without one come first where they came before it was known by the host's time, else last.
    """
    every = tuple(events)
    hosts = (event.host_time_us for event in every if event.time is not None)
    known = min((host for host in hosts if host), default=math.inf)

    def place(event: Event) -> tuple[int, float]:
        if event.time is not None:
            return 0, event.time
        return (-1 if 0 < event.host_time_us < known else 1), event.host_time_us

    return tuple(sorted(every, key=place))


def events_path(flight: Path) -> Path:
    """Return the events file of a flight: in its folder, or beside its single file."""
    return flight / EVENTS_FILE if flight.is_dir() else Path(f"{flight}.{EVENTS_FILE}")


class EventLog:
    """An events file, which need not exist yet, for appending and following.

    `damaged` counts the lines that `poll` had to skip so far.
    """

    def __init__(self, path: Path | str) -> None:
        self.path = Path(path)
        self.damaged = 0
        self._position = 0

    def append(self, event: Event) -> Event:
        """Write one event at the end of the file, whole, and see it onto the disk.

        An event without a host time gets the present one.
        """
        if not event.host_time_us:
            event = replace(event, host_time_us=time.time_ns() // 1000)
        try:
            line = json.dumps(event.to_json(), ensure_ascii=False, allow_nan=False)
        except (TypeError, ValueError) as error:
            raise FlightError(
                f"the event '{event.text or event.kind}' cannot be written as JSON ({error}); "
                "put numbers, texts, lists and tables in its data, and null for NaN"
            ) from error
        self.write_line(event, line)
        return event

    def write_line(self, event: Event, line: str) -> None:
        """Write the line of an event."""
        try:
            _append_line(self.path, f"{line}\n".encode())
        except OSError as error:
            raise FlightError(
                format_os_error(
                    f"the event '{event.text or event.kind}' of {self.path}",
                    error,
                    "check the permissions",
                )
            ) from error

    def refresh(self) -> None:
        """See to it that `poll` returns what others wrote until now."""

    def poll(self) -> list[Event]:
        """Return the events that were appended since the last call.

        A last line without its end is left for the next call: somebody may be writing it.
        """
        try:
            with self.path.open("rb") as stream:
                stream.seek(self._position)
                data = stream.read()
        except FileNotFoundError:
            return []
        except OSError as error:
            raise FlightError(
                f"{self.path} cannot be read ({error.strerror}); check its permissions"
            ) from error
        whole = data[: data.rfind(b"\n") + 1]
        self._position += len(whole)
        events, damaged = _parse(whole)
        self.damaged += damaged
        return events


@dataclass(frozen=True, slots=True, kw_only=True)
class EventFileContent:
    """The events of a file, in the order written, and how many lines were damaged."""

    events: tuple[Event, ...]
    damaged: int


def read_events(path: Path | str) -> EventFileContent:
    """Read a whole events file; a missing one holds no events, a torn last line is counted."""
    try:
        data = Path(path).read_bytes()
    except FileNotFoundError:
        return EventFileContent(events=(), damaged=0)
    except OSError as error:
        raise FlightError(f"{path} cannot be read ({error.strerror}); check it") from error
    events, damaged = _parse(data)
    return EventFileContent(events=tuple(events), damaged=damaged)


def _parse(data: bytes) -> tuple[list[Event], int]:
    events: list[Event] = []
    damaged = 0
    for line in data.split(b"\n"):
        if not line.strip():
            continue
        try:
            events.append(Event.from_json(json.loads(line.decode("utf-8"))))
        except (ValueError, RecursionError):
            damaged += 1
    return events, damaged


def _append_line(path: Path, line: bytes) -> None:
    flags = os.O_RDWR | os.O_CREAT | os.O_APPEND | getattr(os, "O_BINARY", 0)
    handle = os.open(path, flags, GROUP_FILE_MODE)
    try:
        with exclusive_lock(handle):
            end = os.lseek(handle, 0, os.SEEK_END)
            if end:
                os.lseek(handle, end - 1, os.SEEK_SET)
                if os.read(handle, 1) != b"\n":
                    line = b"\n" + line
            os.lseek(handle, 0, os.SEEK_END)
            while line:
                line = line[os.write(handle, line) :]
            flush_to_disk(handle)
    finally:
        os.close(handle)

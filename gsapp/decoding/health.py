"""How well a link carries: what came, what was lost, how late and how long ago.

All numbers are a function of the recorded bytes and stamps, whatever the pieces in which they
are fed. Loss is counted from the sequence numbers, which every (system, component) counts for
itself: a duplicate is not a loss, and a frame that comes late takes its loss back.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any

from gsapp.decoding.dialect import TimeField, dialect, time_fields, wire_formats
from gsapp.decoding.framing import MAX_FRAME_LENGTH
from gsapp.decoding.settings import DECODING

HEARTBEAT_ID = 0
AUTOPILOT_COMPONENT = 1
"""The component of an autopilot (MAV_COMP_ID_AUTOPILOT1)."""
FIRST_GROUND_SYSTEM = 250
"""By convention, ground stations use system ids from here on."""
RADIO_MESSAGES = frozenset({109, 166})
"""RADIO_STATUS and RADIO: they come from the radio itself, whatever system it names."""
_NO_AUTOPILOT = 8
_GROUND_STATION = 6
# Heartbeats of these types are no vehicle: antenna tracker, ground station, onboard computer,
# gimbal, ADS-B, camera, and the like.
_NOT_VEHICLES = frozenset({5, 6, 18, 26, 27, 30, 31, 32, 33, 34, 36, 38, 39})


@dataclass(frozen=True, slots=True, kw_only=True)
class MessageHealth:
    """One message of one sender."""

    system: int
    component: int
    message_id: int
    """Who sent what."""
    name: str  # Name of the message; ``UNKNOWN_<id>`` where the dialect does not hold it.
    count: int  # Frames, without duplicates.
    rate: float  # Frames per second over the last two seconds or so; 0 once it has stopped.
    age: float  # Seconds since the last one.
    delay: float | None
    """Seconds by which the last one came later than the fastest of the last minutes; None where the
    sender does not stamp it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SenderHealth:
    """One (system, component) on the link; attributes as in `LinkReport`."""

    system: int
    component: int
    good: int
    unknown: int
    lost: int
    duplicates: int
    reordered: int
    rate: float
    age: float
    """Seconds since its last frame; frames of a radio do not count."""
    is_vehicle: bool  # Whether its heartbeat is that of a vehicle.
    vehicle_type: str = ""
    autopilot: str = ""
    """What its heartbeat says it is; empty before the first."""
    radio: bool = False  # Whether all that it sends is the status of a radio.
    address: str = ""  # Network address that its system is taken from, if it has one.

    def __str__(self) -> str:
        kind = "radio" if self.radio else self.vehicle_type.replace("gcs", "ground station")
        what = ", ".join(filter(None, (kind, self.autopilot if self.is_vehicle else "")))
        return f"system {self.system}, component {self.component}" + (f" ({what})" if what else "")

    @property
    def can_be_flown_aircraft(self) -> bool:
        return self.system < FIRST_GROUND_SYSTEM and (
            self.is_vehicle
            or (self.component == AUTOPILOT_COMPONENT and not self.vehicle_type and not self.radio)
        )

    @property
    def arrived(self) -> int:
        return self.good + self.unknown - self.duplicates


_REJECTION_REASONS = {
    "unsigned": "they are not signed",
    "false": "their signature is false",
    "replayed": "their signature is out of date: replayed, or a clock is wrong",
}


@dataclass(slots=True, kw_only=True)
class RejectedSender:
    """Frames that carry the id of a system and are not taken as that system's."""

    system: int
    address: str  # Network address; empty where the link has none.
    reason: str  # "address", or the state of the signature: "unsigned", "false", "replayed".
    count: int = 0
    last_stamp: int = 0  # Host stamp of the last, us.
    is_vehicle: bool = False  # Whether a heartbeat of an autopilot was among them.

    def describe(self, pinned: str = "") -> str:
        """Return what is ignored and why; `pinned` is the address of the system."""
        sender = f" from {self.address}" if self.address else ""
        if self.reason != "address":
            why = _REJECTION_REASONS.get(self.reason, self.reason)
            return f"Messages of system {self.system}{sender} are ignored: {why}."
        return (
            f"Messages of system {self.system}{sender} are ignored: the aircraft sends from "
            f"{pinned or 'another address'}. If {self.address} is the aircraft, choose it on the "
            "LINK tile."
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkReport:
    """The state of a link at one moment."""

    good: int  # Frames whose checksum fitted, duplicates included.
    damaged: int  # Damaged frames, as far as the residue lets them be told apart.
    unknown: int  # Frames of unknown id, recorded but not decoded.
    lost: int
    """Frames missing in the sequence numbers of their senders. Ground stations do not count: a log
    holds only some of what they send."""
    duplicates: int
    reordered: int
    """Frames that came twice, and frames that came late."""
    lines: int  # Text lines.
    residue_bytes: int  # Bytes that belong to no frame.
    rate: float  # Frames of the flown aircraft, or lines, per second.
    age: float | None  # Seconds since the last of them; None before the first.
    loss: float  # Share of its frames lost since the beginning, 0 to 1.
    system: int | None
    """The flown system, heard or chosen; None before it is known, and for lines of text."""
    is_system_selected: bool  # Whether the crew or the channel map has named it.
    is_address_selected: bool  # Whether the crew has named the address that it sends from.
    flown: SenderHealth | None
    """The flown aircraft; None before it is heard, and for lines of text."""
    senders: tuple[SenderHealth, ...]
    messages: tuple[MessageHealth, ...]
    """The same by sender and by message, of those of whom one frame was good."""
    rejected: tuple[RejectedSender, ...]  # Whose frames are recorded, but not decoded.
    recently_rejected: tuple[str, ...]  # What is said of those of the last seconds.
    warnings: tuple[str, ...]  # What the crew should know, in words.
    unreadable: str
    """The one of them that says that nothing of what arrives can be read; empty where it can."""

    @property
    def arrived(self) -> int:
        """Return how many frames came, each counted once."""
        return self.good + self.unknown - self.duplicates

    @property
    def rejected_vehicles(self) -> tuple[RejectedSender, ...]:
        """Return those that can be the flown aircraft, sending from another address."""
        return tuple(one for one in self.rejected if one.is_vehicle and one.reason == "address")

    @property
    def vehicles(self) -> tuple[SenderHealth, ...]:
        """Return those that can be the flown aircraft, one for each system."""
        found: dict[int, SenderHealth] = {}
        for sender in self.senders:
            if sender == self.flown or (
                sender.can_be_flown_aircraft and sender.system not in found
            ):
                found[sender.system] = sender
        return tuple(found.values())


@dataclass(slots=True)
class _Rate:
    """Events per second over the last closed span."""

    start: int
    count: int = 0
    value: float = 0.0
    spans: deque[float] = field(default_factory=lambda: deque(maxlen=DECODING.usual_spans))

    @property
    def usual(self) -> float:
        """Return the median of the rates of late: neither a burst nor a silence counts."""
        return sorted(self.spans)[len(self.spans) // 2] if self.spans else self.value

    def close(self, stamp: int) -> None:
        """Take the rate of the span at hand, and begin another."""
        elapsed = stamp - self.start
        self.value = self.count * 1e6 / elapsed if elapsed > 0 else 0.0
        self.spans.append(self.value)
        self.start, self.count = stamp, 0

    def at(self, stamp: int, last: int) -> float:
        """Return the rate at a moment, 0 when nothing came for long."""
        elapsed = (last - self.start) / 1e6
        value = self.value or (self.count / elapsed if elapsed > 0 else 0.0)
        silent = (stamp - last) / 1e6
        return 0.0 if value == 0.0 or silent > max(3.0, 3.0 / value) else value


@dataclass(slots=True)
class _ClockOffset:
    """Smallest difference between arrival and the sender's stamp, over one to two minutes.

    The clocks drift apart, so that the smallest of all times would age.
    """

    start: int
    current: int
    former: int

    def update(self, stamp: int, difference: int) -> int:
        """Take in one difference; return by how much it exceeds the smallest (microseconds)."""
        if stamp - self.start > DECODING.offset_span or stamp < self.start:
            self.start, self.former, self.current = stamp, self.current, difference
        elif difference < self.current:
            self.current = difference
        least = self.current if self.current < self.former else self.former
        return difference - least


@dataclass(slots=True)
class _Message:
    last: int
    rate: _Rate
    time: TimeField | None
    known: bool
    heartbeat: bool
    offset: _ClockOffset | None = None  # where stamps count from the boot, the sender's
    count: int = 0
    delay: int = 0


@dataclass(slots=True)
class _Silence:
    """Frames lost in a silence so long that their numbers may have started over."""

    gap: int  # Of the numbers, as they are sent: less than 256.
    lost: int  # As taken for lost by the time that passed here.
    rate: float  # Of the sender before.


@dataclass(slots=True)
class _Sender:
    last: int
    rate: _Rate
    expected: int  # the next number, not wrapped at 256; `missing` likewise
    recent: list[bytes] = field(default_factory=lambda: [b""] * 256)
    missing: set[int] = field(default_factory=set)
    messages: dict[int, _Message] = field(default_factory=dict)
    boot: _ClockOffset | None = None
    boot_time: int | None = None  # its latest stamp since it was switched on, us
    since_boot_time: int = 0  # frames that came since
    silence: _Silence | None = None
    good: int = 0
    unknown: int = 0
    lost: int = 0
    duplicates: int = 0
    reordered: int = 0
    strays: int = 0  # frames that fit neither the sequence nor its window, of late
    repeats: int = 0  # those of them that bear the number of the one before
    span: int = 0
    mixed: bool = False
    uncounted: bool = False
    aircraft: bool = False
    ground: bool = False
    kind: int | None = None  # MAV_TYPE and MAV_AUTOPILOT of its heartbeat
    autopilot: int | None = None

    @property
    def heard(self) -> int:
        """Return when its last frame came that no radio has put in."""
        own = (one.last for number, one in self.messages.items() if number not in RADIO_MESSAGES)
        return max(own, default=0)


_COUNTS = ("good", "unknown", "lost", "duplicates", "reordered")


class LinkHealth:
    """Count what a link carries.

    Feed it raw records in their order; ask for a `report` whenever one is wanted. Who decodes the
    frames sets `flown`, system and component of the aircraft of which age, rate and loss are
    reported, and `chosen`, whether the crew or the channel map has named that system. A
    `gsapp.decoding.sender_filter.SenderFilter` sets `addresses`, by system, `rejected`, and
    `address_chosen`, whether the crew has named that of the flown system.
    """

    def __init__(self) -> None:
        self.flown: tuple[int, int] | None = None
        self.chosen = False
        self.addresses: dict[int, str] = {}
        self.address_chosen = False
        self.rejected: dict[tuple[int, str, str], RejectedSender] = {}
        self._known = wire_formats()
        self._times = time_fields()
        self._senders: dict[int, _Sender] = {}
        # By system, component and message, as they stand in a header.
        self._heard: dict[bytes, tuple[_Sender, _Message]] = {}
        self._line_rate: _Rate | None = None
        self._line_stamp: int | None = None
        self._run = b""  # end of the residue at hand: a header may be cut across two pieces
        self._in_residue = False
        self._run_heads = 0
        self._heads: Counter[int] = Counter()  # in the residue, by message
        # All of whom no frame was good: one of unknown id has no checksum to prove its sender.
        self._strangers = _Sender(0, _Rate(0), 0)
        self._unread = 0  # bytes of residue since something could be read
        self._read_stamp = 0
        self.damaged = 0
        self.lines = 0
        self.residue_bytes = 0
        self.last_stamp: int | None = None

    @property
    def good(self) -> int:
        return sum(sender.good for sender in self._senders.values())

    @property
    def unknown(self) -> int:
        return self._strangers.unknown + sum(sender.unknown for sender in self._senders.values())

    @property
    def lost(self) -> int:
        """Return how many frames are missing, in all sequences but those of ground stations."""
        return sum(sender.lost for sender in self._senders.values() if not sender.ground)

    def feed(self, records: Iterable[tuple[Any, ...]]) -> None:
        """Count records in the order of their stamps.

        Each begins with a stamp in microseconds, a kind (``frame``, ``line``, ``residue``) and
        bytes, as a `gsapp.flight.raw_files.record_files.RawRecord` does.
        """
        for record in records:
            stamp, kind, data = record[:3]
            if self.last_stamp is None:
                self._read_stamp = stamp
            if kind == "residue":
                self._residue(data)
            elif kind == "frame":
                self._in_residue = False
                self._frame(stamp, data)
            else:
                self._in_residue = False
                self.lines += 1
                self._line_stamp = stamp
                self._line_rate = self._line_rate or _Rate(stamp)
                _count_event(self._line_rate, stamp)
                self._maybe_read(data)
            self.last_stamp = stamp

    @property
    def unreadable(self) -> str:
        """Return that nothing of what arrives can be read, in words; empty where it can."""
        since = (self.last_stamp or 0) - self._read_stamp
        if self._unread < DECODING.unreadable_bytes or since < DECODING.unreadable_time:
            return ""
        what = "The latest data cannot be read" if self.good else "Received data cannot be read"
        return (
            f"{what}: check the baud rate, the wiring and the protocol of the sender; the data "
            "are neither MAVLink nor lines of text."
        )

    def _read_again(self) -> None:
        if self.unreadable:
            self._heads.clear()  # what looked like headers was chance
        self._unread = 0

    def _maybe_read(self, data: bytes) -> None:
        self._unread = max(0, self._unread - DECODING.chance_factor * len(data))

    def _residue(self, data: bytes) -> None:
        """Count the damaged frames in residue: its plausible headers, but at least one."""
        self.residue_bytes += len(data)
        self._unread += len(data)
        if not self._in_residue:
            self._in_residue = True
            self._run = b""
            self._run_heads = 0
            self.damaged += 1
        joined = self._run + data
        position = 0
        while position + 10 <= len(joined):
            head, number = self._plausible_head(joined, position)
            if head:
                self._heads[number] += 1
                self._run_heads += 1
                if self._run_heads > 1:
                    self.damaged += 1
                position += head
            else:
                position += 1
        self._run = joined[position:]

    def _plausible_head(self, data: bytes, position: int) -> tuple[int, int]:
        """Return length and message of the header of a known message that stands here, or 0."""
        magic = data[position]
        if magic == 0xFD and data[position + 2] <= 1:
            number = int.from_bytes(data[position + 7 : position + 10], "little")
            return (10, number) if number in self._known else (0, 0)
        if magic == 0xFE:
            number = data[position + 5]
            wire = self._known.get(number)
            if wire is not None and data[position + 1] in (wire.size, wire.full_size):
                return 6, number
        return 0, 0

    def _frame(self, stamp: int, data: bytes) -> None:
        if data[0] == 0xFD:
            head, sequence, header = data[5:10], data[4], 10
        else:
            head, sequence, header = data[3:6], data[2], 6
        sender, message = self._heard.get(head) or self._hear(head, stamp, sequence)
        if message.known:
            sender.good += 1
            if self._unread:
                self._read_again()
            self._read_stamp = stamp
        else:
            sender.unknown += 1
            self._maybe_read(data)
        sender.span += 1
        gap = (sequence - sender.expected) & 0xFF
        if not gap:
            sender.expected += 1
        elif not self._resolve_gap(sender, stamp, sequence, gap, data):
            return
        sender.recent[sequence] = data
        sender.since_boot_time += 1
        if sender.span >= DECODING.mixed_frames:
            sender.uncounted = sender.repeats > DECODING.uncounted_share * sender.span
            sender.mixed = (
                not sender.uncounted and sender.strays > DECODING.mixed_share * sender.span
            )
            sender.span = sender.strays = sender.repeats = 0
        if stamp > sender.last:
            sender.last = stamp
        message.count += 1
        message.last = stamp
        for rate in (sender.rate, message.rate):
            rate.count += 1
            if not 0 <= stamp - rate.start < DECODING.rate_span:
                rate.close(stamp)
        if message.time is not None:
            _measure_delay(sender, message, message.time, stamp, data, header)
        elif message.heartbeat:
            _read_heartbeat(sender, head[1], data, header)

    def _hear(self, head: bytes, stamp: int, sequence: int) -> tuple[_Sender, _Message]:
        """Take up system, component and message as they stand in a header."""
        key, number = head[0] << 8 | head[1], int.from_bytes(head[2:], "little")
        sender, known = self._senders.get(key), number in self._known
        message = None if sender is None else sender.messages.get(number)
        if message is None:
            message = _Message(
                last=stamp,
                rate=_Rate(stamp),
                time=self._times.get(number),
                known=known,
                heartbeat=number == HEARTBEAT_ID,
            )
        if sender is None:
            if not known:
                return self._strangers, message
            self._senders[key] = sender = _Sender(stamp, _Rate(stamp), sequence)
        sender.messages[number] = message
        self._heard[head] = sender, message
        return sender, message

    def _resolve_gap(
        self, sender: _Sender, stamp: int, sequence: int, gap: int, data: bytes
    ) -> bool:
        """Settle a sequence number other than the next; return False for a duplicate."""
        silent = (stamp - sender.last) / 1e6
        rate = sender.rate.usual
        if rate * silent >= DECODING.sequence_window / 2 and not sender.uncounted:
            # Silent for so long that the counter may have gone round: the rate tells how often.
            sender.missing.clear()
            lost = _complete_gap(gap, rate * silent)
            sender.silence = _Silence(gap, lost, rate)
            gap = lost
            sender.lost += gap
        elif gap >= 256 - DECODING.sequence_window:
            return self._behind(sender, sequence, 256 - gap, data)
        else:
            if gap > DECODING.max_sequence_step:
                sender.strays += 1
            oldest = sender.expected - DECODING.sequence_window
            sender.missing = {number for number in sender.missing if number >= oldest}
            sender.missing.update(range(sender.expected, sender.expected + gap))
            sender.lost += gap
        sender.expected += gap + 1
        return True

    def _behind(self, sender: _Sender, sequence: int, behind: int, data: bytes) -> bool:
        """Settle a number that lies behind the newest; return False for a duplicate."""
        number = sender.expected - behind
        if number in sender.missing:
            sender.missing.discard(number)
            sender.lost -= 1
            sender.reordered += 1
            if behind > DECODING.max_sequence_step:
                sender.strays += 1
        elif sender.recent[sequence] == data and not sender.uncounted:
            sender.duplicates += 1
            return False
        else:
            # The sender counts anew or not at all, or two senders share one number.
            sender.strays += 1
            sender.repeats += behind == 1
            sender.missing.clear()
            sender.expected = sequence + 1
        return True

    def report(self, now_us: int | None = None) -> LinkReport:
        """Return the state of the link at a host time (us), by default that of the last record."""
        now = now_us if now_us is not None else self.last_stamp or 0
        senders = tuple(
            self._sender_report(key, sender, now) for key, sender in sorted(self._senders.items())
        )
        flown = next((one for one in senders if (one.system, one.component) == self.flown), None)
        if flown is None:
            last = self._line_stamp
            age = None if last is None else max(0.0, (now - last) / 1e6)
            rate = self._line_rate.at(now, last or 0) if self._line_rate else 0.0
            loss = 0.0
        else:
            age, rate = flown.age, flown.rate
            # A frame that came twice came once: on a doubled link half of the share would be told.
            whole = flown.arrived + flown.lost
            loss = flown.lost / whole if whole else 0.0
        return LinkReport(
            good=sum(sender.good for sender in senders),
            damaged=self.damaged,
            unknown=self.unknown,
            lost=self.lost,
            duplicates=sum(sender.duplicates for sender in senders),
            reordered=sum(sender.reordered for sender in senders),
            lines=self.lines,
            residue_bytes=self.residue_bytes,
            rate=rate,
            age=age,
            loss=loss,
            system=None if self.flown is None else self.flown[0],
            is_system_selected=self.chosen,
            is_address_selected=self.address_chosen,
            flown=flown,
            senders=senders,
            messages=tuple(self._message_reports(now)),
            rejected=tuple(replace(one) for one in self.rejected.values()),
            recently_rejected=tuple(
                one.describe(self.addresses.get(one.system, ""))
                for one in self.rejected.values()
                if one.system < FIRST_GROUND_SYSTEM
                and now - one.last_stamp <= DECODING.rejection_time
            ),
            warnings=self.warnings(),
            unreadable=self.unreadable,
        )

    def _sender_report(self, key: int, sender: _Sender, now: int) -> SenderHealth:
        return SenderHealth(
            system=key >> 8,
            component=key & 0xFF,
            **{name: getattr(sender, name) for name in _COUNTS},
            rate=sender.rate.at(now, sender.heard),
            age=max(0.0, (now - (sender.heard or sender.last)) / 1e6),
            is_vehicle=sender.aircraft,
            vehicle_type=_enum_text("MAV_TYPE", sender.kind),
            autopilot=_enum_text("MAV_AUTOPILOT", sender.autopilot),
            radio=RADIO_MESSAGES.issuperset(sender.messages),
            address=self.addresses.get(key >> 8, ""),
        )

    def _message_reports(self, now: int) -> Iterable[MessageHealth]:
        names = dialect().mavlink_map
        for key, sender in sorted(self._senders.items()):
            for number, message in sorted(sender.messages.items()):
                known = names.get(number)
                yield MessageHealth(
                    system=key >> 8,
                    component=key & 0xFF,
                    message_id=number,
                    name=known.msgname if known else f"UNKNOWN_{number}",
                    count=message.count,
                    rate=message.rate.at(now, message.last),
                    age=max(0.0, (now - message.last) / 1e6),
                    delay=None if message.time is None else message.delay / 1e6,
                )

    def warnings(self) -> tuple[str, ...]:
        """Return what the crew should know, in words; empty when all is well."""
        found = []
        aircraft = sorted({key >> 8 for key, sender in self._senders.items() if sender.aircraft})
        if len(aircraft) > 1 and not self.chosen:
            numbers = ", ".join(map(str, aircraft[:-1])) + f" and {aircraft[-1]}"
            shown = "" if self.flown is None else f" System {self.flown[0]} is shown."
            found.append(
                f"{len(aircraft)} aircraft are on this link: systems {numbers}.{shown} Choose the "
                "flown system on the LINK tile, or set it in the channel map (system = "
                f"{aircraft[0]})."
            )
        found.extend(
            f"System {key >> 8}, component {key & 0xFF} sends two frame sequences: two aircraft "
            "use the same system id; change one."
            for key, sender in sorted(self._senders.items())
            if sender.mixed
        )
        found.extend(
            f"System {key >> 8}, component {key & 0xFF} does not number its frames: losses are "
            "unknown."
            for key, sender in sorted(self._senders.items())
            if sender.uncounted
        )
        if unreadable := self.unreadable:
            found.append(unreadable)
        if foreign := self._foreign():
            names = dialect().mavlink_map
            listed = ", ".join(names[number].msgname for number in foreign[:4])
            more = " and others" if len(foreign) > 4 else ""
            found.append(
                f"No {listed}{more} has a valid checksum: another MAVLink dialect or a damaging "
                "link; recorded, not decoded."
            )
        return tuple(found)

    def _foreign(self) -> list[int]:
        """Return the messages that come often and never whole."""
        # Where most of what came belongs to no header, the headers were chance.
        if self.unreadable and self._heads.total() * MAX_FRAME_LENGTH < self.residue_bytes:
            return []
        often = {
            number for number, count in self._heads.items() if count >= DECODING.foreign_headers
        }
        whole = {number for sender in self._senders.values() for number in sender.messages}
        return sorted(often - whole)


def _complete_gap(gap: int, expected: float) -> int:
    """Return how many frames were lost, of which numbers tell but the last byte."""
    return gap + 256 * max(0, round((expected - gap) / 256))


def _tell_time(sender: _Sender, time: int) -> None:
    """Correct what was lost in a silence by the sender's own clock: a link may have kept it back.

    `time` is a stamp of the sender, us since it was switched on.
    """
    silence, before = sender.silence, sender.boot_time
    if silence is not None:
        sender.silence = None
        if before is not None and time - before > 0:
            expected = silence.rate * (time - before) / 1e6 - sender.since_boot_time
            sender.lost += _complete_gap(silence.gap, expected) - silence.lost
    sender.boot_time, sender.since_boot_time = time, 0


def _count_event(rate: _Rate, stamp: int) -> None:
    rate.count += 1
    if not 0 <= stamp - rate.start < DECODING.rate_span:
        rate.close(stamp)


def is_vehicle(component: int, heartbeat: bytes) -> bool:
    """Return whether a heartbeat's payload is that of a vehicle's autopilot.

    Component 1 is, unless it calls itself a ground station, a camera, or the like; any other
    component has to name its autopilot.
    """
    kind, autopilot = heartbeat[4:5], heartbeat[5:6]
    if not kind or kind[0] in _NOT_VEHICLES:
        return False
    return component == AUTOPILOT_COMPONENT or bool(autopilot and autopilot[0] != _NO_AUTOPILOT)


def _read_heartbeat(sender: _Sender, component: int, data: bytes, header: int) -> None:
    body = data[header : header + 6]
    if len(body) == 6:
        sender.kind, sender.autopilot = body[4], body[5]
        sender.ground = body[4] == _GROUND_STATION
        sender.aircraft = is_vehicle(component, body)


def _enum_text(enum: str, value: int | None) -> str:
    """Return the name of a MAVLink enum's value in words: "fixed wing"."""
    known = None if value is None else dialect().enums[enum].get(value)
    if known is None:
        return ""
    return str(known.name).removeprefix(f"{enum}_").replace("_", " ").lower()


def _measure_delay(
    sender: _Sender, message: _Message, place: TimeField, stamp: int, data: bytes, header: int
) -> None:
    """Tell how late a frame came by the stamp that it carries."""
    start = header + place.offset
    stop = start + place.size
    sent = header + data[1]  # zero bytes at the end are not
    time = int.from_bytes(data[start : stop if stop < sent else sent], "little")
    difference = stamp - time * place.microseconds
    offset = message.offset or (sender.boot if place.since_boot else None)
    if offset is None:
        offset = _ClockOffset(stamp, difference, difference)
        if place.since_boot:
            sender.boot = offset
    if place.since_boot:
        _tell_time(sender, time * place.microseconds)
    message.offset = offset
    message.delay = offset.update(stamp, difference)

"""Frames of each system from one network address only, and only those that are signed as asked.

Anyone on a network can send frames that carry the id of the aircraft. They are recorded like all
that arrives, with the address that sent them; what is decoded is decided here, from the record
alone.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Final, Literal, NamedTuple, Protocol, TypeVar

from gsapp.decoding.framing import (
    MAGIC_2,
    frame_component,
    frame_message_id,
    frame_system,
)
from gsapp.decoding.health import (
    FIRST_GROUND_SYSTEM,
    HEARTBEAT_ID,
    RADIO_MESSAGES,
    LinkHealth,
    RejectedSender,
    is_vehicle,
)
from gsapp.decoding.notices import NoticeLog
from gsapp.decoding.settings import DECODING

SignatureState = Literal["", "valid", "unsigned", "false", "replayed"]
"""Of a frame: not checked, or what the check of a MAVLink 2 signature found."""
_ACCEPTED: Final = frozenset(("", "valid"))
REJECTED_SIGNATURES: Final = frozenset(("unsigned", "false", "replayed"))


class FrameOrigin(NamedTuple):
    """Where a frame came from."""

    address: str = ""  # Network address HOST:PORT; empty for links without any.
    signature: str = ""  # A `SignatureState`.

    def format(self) -> bytes:
        return f"{self.address}\t{self.signature}".encode()

    @classmethod
    def parse(cls, line: bytes) -> FrameOrigin:
        address, _, signature = line.decode("utf-8", "replace").partition("\t")
        return cls(address, signature)


UNKNOWN_ORIGIN: Final = FrameOrigin()


class RawRecordLike(Protocol):
    """What is fed: a `gsapp.flight.raw_files.record_files.RawRecord`, or anything like it."""

    @property
    def stamp_us(self) -> int:
        """Host time of arrival, microseconds since 1970."""

    @property
    def kind(self) -> str:
        """``frame``, ``line`` or ``residue``."""

    @property
    def data(self) -> bytes:
        """The bytes."""

    @property
    def origin(self) -> FrameOrigin:
        """Who sent a frame, as far as it is known."""


RecordT = TypeVar("RecordT", bound=RawRecordLike)


def host_of(address: str) -> str:
    """Return the host of a network address with or without a port."""
    host, colon, port = address.rpartition(":")
    return host if colon and port.isdigit() and not host.endswith(":") else address


@dataclass(slots=True)
class _Port:
    """Where a component sends from."""

    address: str
    last_stamp: int  # Host stamp of its last frame, us.


@dataclass(slots=True)
class _Pin:
    """The address that a system is taken from."""

    address: str
    confirmed: bool  # By a heartbeat of an autopilot, or by the choice of the crew.
    is_exact: bool = False  # Whether the port counts too: chosen between two of one host.
    ports: dict[int, _Port] = field(default_factory=dict)  # By component.

    def accepts(self, address: str, component: int, stamp: int) -> bool:
        if self.is_exact:
            return address == self.address
        if host_of(address) != host_of(self.address):
            return False
        former = self.ports.get(component)
        if former is None:
            self.ports[component] = _Port(address, stamp)
            return True
        # A program that started again has another port; one that speaks still has not.
        if address != former.address and stamp - former.last_stamp < DECODING.sender_timeout:
            return False
        former.address, former.last_stamp = address, stamp
        return True


class SenderFilter:
    """Pins every system to a network address, and rejects its frames from elsewhere.

    A system is pinned to where the first heartbeat of its autopilot came from; its frames before
    that wait. Without a heartbeat for `DECODING.autopilot_timeout` it is pinned to the first
    sender. Another port of the same host takes over where the former falls silent, another host
    never does. Frames without an address, of ground stations and of text lines pass.

    Parameters
    ----------
    health : LinkHealth
        Gets the addresses, and what was rejected.
    log : NoticeLog
        Gets a notice for every sender that is rejected.
    system, address : int, str, optional
        System and address, HOST or HOST:PORT, that the crew chose.
    """

    def __init__(
        self, health: LinkHealth, log: NoticeLog, system: int | None = None, address: str = ""
    ) -> None:
        self._health = health
        self._log = log
        self._pins: dict[int, _Pin] = {}
        self._held: dict[int, list[RawRecordLike]] = {}
        # Of components of confirmed systems, by system and component as they stand in a header.
        self._settled: dict[bytes, _Port] = {}
        if system is not None and address:
            exact = host_of(address) != address
            self._pins[system] = _Pin(address, confirmed=True, is_exact=exact)
            health.addresses[system] = address
            health.address_chosen = True

    def feed(self, records: Iterable[RecordT]) -> list[RecordT]:
        """Return the records that are accepted, those that waited before what follows them."""
        accepted: list[RecordT] = []
        for record in records:
            origin = record.origin
            if origin is UNKNOWN_ORIGIN or record.kind != "frame":
                accepted.append(record)
                continue
            data = record.data
            port = self._settled.get(data[5:7] if data[0] == MAGIC_2 else data[3:5])
            if port is not None and port.address == origin[0] and origin[1] in _ACCEPTED:
                port.last_stamp = record.stamp_us
                accepted.append(record)
            else:
                accepted += self._take(record)
        return accepted

    def finish(self) -> list[RawRecordLike]:
        """Return what waits still; nothing more will come."""
        return [
            record
            for system, held in list(self._held.items())
            for record in self._pin(system, held[0].origin.address, confirmed=False)
        ]

    def _take(self, record: RecordT) -> list[RecordT]:
        data, (address, signature) = record.data, record.origin
        system, component = frame_system(data), frame_component(data)
        number = frame_message_id(data)
        start = 10 if data[0] == MAGIC_2 else 6
        payload = data[start : start + data[1]]
        is_heartbeat = number == HEARTBEAT_ID and is_vehicle(component, payload)
        # A radio cannot sign what it puts in.
        if signature in REJECTED_SIGNATURES and not (
            signature == "unsigned" and number in RADIO_MESSAGES
        ):
            self._reject(record, system, address, signature, is_vehicle=is_heartbeat)
            return []
        if not address or system >= FIRST_GROUND_SYSTEM:
            return [record]
        if number in RADIO_MESSAGES:
            return [record] if self._is_known_host(address) else []
        pin = self._pins.get(system)
        waiting: list[RecordT] = []
        if pin is None or (is_heartbeat and not pin.confirmed):
            held = self._held.setdefault(system, [])
            first = held[0] if held else record
            overdue = record.stamp_us - first.stamp_us > DECODING.autopilot_timeout
            if not is_heartbeat and not overdue:
                held.append(record)
                return []
            from_where = address if is_heartbeat else first.origin.address
            waiting = self._pin(system, from_where, confirmed=is_heartbeat)  # type: ignore[assignment]
        if self._is_accepted(system, component, record, is_heartbeat=is_heartbeat):
            waiting.append(record)
        return waiting

    def _pin(self, system: int, address: str, *, confirmed: bool) -> list[RawRecordLike]:
        """Pin a system to an address; return what waited of it and came from there."""
        self._pins[system] = _Pin(address, confirmed=confirmed)
        self._health.addresses[system] = address
        return [
            record
            for record in self._held.pop(system, ())
            if self._is_accepted(system, frame_component(record.data), record)
        ]

    def _is_accepted(
        self, system: int, component: int, record: RawRecordLike, *, is_heartbeat: bool = False
    ) -> bool:
        pin, address = self._pins[system], record.origin.address
        if pin.accepts(address, component, record.stamp_us):
            if pin.confirmed and not pin.is_exact:
                self._settled[bytes((system, component))] = pin.ports[component]
            return True
        host = host_of(address)
        named = host if host != host_of(pin.address) else address
        self._reject(record, system, named, "address", is_vehicle=is_heartbeat)
        return False

    def _is_known_host(self, address: str) -> bool:
        """Return whether a radio may speak from there: with an aircraft, or before any is known."""
        hosts = {host_of(pin.address) for pin in self._pins.values() if pin.confirmed}
        return not hosts or host_of(address) in hosts

    def _reject(
        self, record: RawRecordLike, system: int, address: str, reason: str, *, is_vehicle: bool
    ) -> None:
        rejected = self._health.rejected
        key = (system, address, reason)
        if key not in rejected and len(rejected) >= DECODING.max_rejected_senders:
            key = (0, "", reason)  # of many forged addresses each further one is as good
        found = rejected.get(key)
        if found is None:
            found = rejected[key] = RejectedSender(system=key[0], address=key[1], reason=reason)
            self._log.add_once(
                (f"rejected-{reason}", system, len(rejected)),
                record.stamp_us,
                found.describe(self._health.addresses.get(system, "")),
                system=system,
            )
        found.count += 1
        found.last_stamp = record.stamp_us
        found.is_vehicle = found.is_vehicle or is_vehicle

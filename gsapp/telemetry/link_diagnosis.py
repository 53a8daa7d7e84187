"""What is wrong with a link over which no aircraft is heard, and listening before recording."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Final, Literal

from gsapp.decoding.framing import Framer, LineFramer, MavlinkFrame, Residue
from gsapp.decoding.health import LinkHealth, LinkReport
from gsapp.decoding.notices import NoticeLog
from gsapp.decoding.sender_filter import FrameOrigin, SenderFilter
from gsapp.flight.raw_files.record_files import RawRecord, RecordKind
from gsapp.foundation import LinkError
from gsapp.telemetry.clock import HostClock
from gsapp.telemetry.link_kinds import list_serial_ports
from gsapp.telemetry.link_registry import kind_of, parse_link
from gsapp.telemetry.recorder_status import LinkContent, RecorderStatus
from gsapp.telemetry.send_queue import GroundPacker
from gsapp.telemetry.settings import TELEMETRY
from gsapp.telemetry.signing import read_signing_key
from gsapp.telemetry.sources import LinkUnavailableError, open_source

LinkProblem = Literal["closed", "no-data", "unreadable", "text", "mavlink", "no-aircraft"]

_PRINTABLE: Final = frozenset((*range(0x20, 0x7F), *b"\t\r\n"))
_CONTENT: Final = {"mavlink": "MAVLink", "text": "lines of text"}
_ITEM: Final = {"mavlink": "MAVLink frame", "text": "line of text"}


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkDiagnosis:
    """Why no aircraft is heard."""

    problem: LinkProblem
    """``closed``: the port is not open; ``no-data``: it is, and nothing comes; ``unreadable``,
    ``text``, ``mavlink``: something else comes than the link is for; ``no-aircraft``: MAVLink, but
    not of an aircraft."""
    found: str  # What has come, where and for how long, in a sentence.
    remedy: str = ""  # What to try, in sentences; empty where `found` says it.

    def __str__(self) -> str:
        return f"{self.found} {self.remedy}".strip()


class ContentSample:
    """The last bytes of a link, kept to tell what they are."""

    def __init__(self) -> None:
        self._data = b""

    def feed(self, data: bytes) -> None:
        # One thread feeds and another asks: bytes do not change while they are looked at.
        self._data = (self._data + data)[-TELEMETRY.diagnosed_bytes :]

    @property
    def kind(self) -> LinkContent:
        """Return what the bytes are; empty while they are too few to tell."""
        return _kind_of(self._data)


def _kind_of(data: bytes) -> LinkContent:
    framer = Framer()
    if any(
        isinstance(item, MavlinkFrame) and item.known
        for item in (*framer.feed(data), *framer.flush())
    ):
        return "mavlink"
    if len(data) < TELEMETRY.min_diagnosed_bytes:
        return ""
    printable = sum(byte in _PRINTABLE for byte in data)
    return "text" if printable >= TELEMETRY.min_printable_share * len(data) else "unreadable"


def diagnose_link(
    status: RecorderStatus,
    *,
    others: Iterable[str] = (),
    list_ports: Callable[[], Iterable[object]] = list_serial_ports,
) -> LinkDiagnosis | None:
    """Return why no aircraft is heard; None where the link carries what it is for.

    `others` are those heard in place of an aircraft, in words; for MAVLink. `list_ports` gives the
    serial ports of this computer.
    """
    address = parse_link(status.link)
    kind = kind_of(address)
    if not kind.is_physical:
        return None
    if not status.connected:
        return LinkDiagnosis(problem="closed", found=f"{status.source_state}.")
    port = kind.location(address)
    if not status.received_bytes:
        since = (status.updated_us - status.started_us) / 1e6
        return LinkDiagnosis(
            problem="no-data",
            found=f"No data on {port} for {_seconds(since)}.",
            remedy=kind.no_data_remedy(address, list_ports),
        )
    if status.content and status.content != kind.framing:
        amount = _bytes(status.received_bytes)
        if status.content == "unreadable":
            found = f"{port} has sent {amount}, but no {_ITEM[kind.framing]}."
        else:
            sent, wanted = _CONTENT[status.content], _CONTENT[kind.framing]
            found = f"{port} sends {sent}, not {wanted} ({amount})."
        return LinkDiagnosis(
            problem=status.content,
            found=found,
            remedy=kind.content_remedy(address, status.content),
        )
    if heard := ", ".join(others):
        return LinkDiagnosis(
            problem="no-aircraft",
            found=f"No aircraft on {port}: only {heard}.",
            remedy="Switch on the aircraft, and check that its radio is linked.",
        )
    return None


def _seconds(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 120.0 else f"{seconds / 60.0:.0f} min"


def _bytes(count: int) -> str:
    return f"{count:,} bytes" if count < 100_000 else f"{count / 1e6:.1f} MB"


_RECORD_KINDS: Final[Mapping[type, RecordKind]] = {MavlinkFrame: "frame", Residue: "residue"}


class LinkTest:
    """Opens a link in a thread of its own and keeps nothing but counts, until it is closed.

    `open_error` says why the link cannot be opened at all; empty where it can. `signing_key` is
    the file of the key of a flight that is copied. Raise LinkError if the link or the key is none.
    """

    def __init__(self, link: str, *, listen_only: bool = False, signing_key: str = "") -> None:
        self._clock = HostClock()
        self._listen_only = listen_only
        self._address = parse_link(link)
        self._source = open_source(self._address, clock=self._clock)
        self._source.prepare(0, read_signing_key(signing_key) if signing_key else b"")
        self._health = LinkHealth()
        self._filter = SenderFilter(self._health, NoticeLog(lambda _stamp: None))
        self._sample = ContentSample()
        self._framers: dict[str, Framer | LineFramer] = {}
        self._received = 0
        self._started_us = self._clock.now_us()
        self._lock = threading.Lock()
        self._ended = threading.Event()
        self.open_error = ""
        self._thread = threading.Thread(target=self._listen, name="testing a link", daemon=True)
        self._thread.start()

    def close(self) -> None:
        self._ended.set()
        self._thread.join()

    @property
    def seconds(self) -> float:
        return (self._clock.now_us() - self._started_us) / 1e6

    def report(self) -> LinkReport:
        with self._lock:
            return self._health.report(self._clock.now_us())

    def diagnosis(self) -> LinkDiagnosis | None:
        """Return why no aircraft is heard; None where one is, or lines of text."""
        if self.open_error:
            return LinkDiagnosis(problem="closed", found=self.open_error)
        report = self.report()
        if report.vehicles:
            return None
        return diagnose_link(
            RecorderStatus(
                pid=os.getpid(),
                link=str(self._address),
                folder="",
                state="recording",
                started_us=self._started_us,
                updated_us=self._clock.now_us(),
                source_state=self._source.state,
                connected=self._source.connected,
                received_bytes=self._received,
                content=self._sample.kind,
            ),
            others=[str(sender) for sender in report.senders],
        )

    def _listen(self) -> None:
        try:
            self._source.open()
        except LinkUnavailableError:
            pass
        except LinkError as error:
            self.open_error = str(error)
            return
        speaks = kind_of(self._address).needs_heartbeat and not self._listen_only
        packer = GroundPacker()
        next_heartbeat = 0.0
        while not self._ended.is_set() and not self._source.finished:
            if speaks and time.monotonic() >= next_heartbeat:
                next_heartbeat = time.monotonic() + TELEMETRY.heartbeat_interval
                self._source.write(packer.pack_heartbeat(self._clock.now_us()))
            for stamp, data, peer in self._source.read(TELEMETRY.test_read_timeout):
                self._take(stamp, data, peer)
        self._source.close()

    def _take(self, stamp: int, data: bytes, peer: str) -> None:
        framer = self._framers.get(peer)
        if framer is None:
            framer = self._framers[peer] = self._source.new_framer()
        self._received += len(data)
        self._sample.feed(data)
        origin = FrameOrigin(peer)
        records = [
            RawRecord(stamp, _RECORD_KINDS.get(type(item), "line"), item.data, origin)
            for item in framer.feed(data)
        ]
        with self._lock:
            self._health.feed(self._filter.feed(records))

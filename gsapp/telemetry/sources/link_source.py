"""What all sources have in common: the interface, and coming back after a loss.

A source stamps what it receives and otherwise leaves it as it came. It never gives up: while its
device or peer is away it tries again, at growing intervals, and says so in words.
"""

from __future__ import annotations

import contextlib
import errno
import socket
import sys
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from typing import Final, NamedTuple

from gsapp.decoding.framing import Framer, LineFramer, MavlinkFrame, Residue, TextLine
from gsapp.decoding.sender_filter import FrameOrigin
from gsapp.flight.events import Event
from gsapp.foundation import LinkError
from gsapp.telemetry.clock import Clock
from gsapp.telemetry.link_kinds import Framing, LinkAddress, NetworkLink
from gsapp.telemetry.link_registry import find_link_kind


class LinkUnavailableError(LinkError):
    """A link is not there yet, and may come by itself: unplugged, or nobody listens."""


class Chunk(NamedTuple):
    """Bytes that came at one time."""

    stamp_us: int  # Host time of arrival, microseconds since 1970 (UTC).
    data: bytes  # The bytes; empty where the stream of this peer ended.
    peer: str = ""
    """Who sent them, where a link has several senders: every peer is a stream of its own."""


class RecordedChunk(Chunk):
    """What another recorder wrote at one stamp, which is written as it is there."""

    items: Sequence[MavlinkFrame | Residue | TextLine]
    origin: FrameOrigin

    @classmethod
    def of_items(
        cls,
        stamp_us: int,
        items: Sequence[MavlinkFrame | Residue | TextLine],
        origin: FrameOrigin,
    ) -> RecordedChunk:
        parts = (one.data + b"\n" if isinstance(one, TextLine) else one.data for one in items)
        made = cls(stamp_us, b"".join(parts), origin.address)
        made.items, made.origin = items, origin
        return made


class LinkSource(ABC):
    """A source of bytes.

    Attributes
    ----------
    framing : {"mavlink", "text"}
        What the bytes hold; that of the `LinkKind`, set by `gsapp.telemetry.sources.open_source`.
    state : str
        How the link fares, in words for the user.
    unsent : str
        Why what was written last could not be sent, in words; empty where it could.
    connected : bool
        Whether data can arrive.
    finished : bool
        Whether nothing will ever come again (a recorded flight at its end).
    clock_offset_us : int
        By how much the stamps of another recorder are ahead of this computer's clock.
    events : deque of Event
        Marks and notes of another recorder that nobody has written yet.
    has_events : bool
        Whether all that this recorder had written so far has been among them.
    files : dict of str to str, optional
        Files with which another recorder's flight is read, see `gsapp.telemetry.flight_files`.
    sends_notes : bool or None
        Whether another recorder takes the notes made here; None where there is none.
    """

    framing: Framing = "mavlink"

    def __init__(self, address: LinkAddress, *, clock: Clock) -> None:
        self.address = address
        self.clock = clock
        self.state = f"{address}: not opened yet"
        self.unsent = ""
        self.connected = False
        self.finished = False
        self.clock_offset_us = 0
        self.events: deque[Event] = deque()
        self.has_events = False
        self.files: dict[str, str] | None = None
        self.sends_notes: bool | None = None

    def prepare(self, after_us: int, signing_key: bytes) -> None:  # noqa: B027 - few need it
        """Take the last stamp that the flight folder holds, 0 for none, and the key, if any."""

    def offer_notes(self, notes: Sequence[Event]) -> None:  # noqa: B027 - few take them
        """Take all marks and notes made here that another recorder is not known to have."""

    @abstractmethod
    def open(self) -> None:
        """Connect now.

        Raise LinkUnavailableError if the link is away but may come; `read` goes on trying. Raise
        LinkError if the user has to do something; `read` goes on trying all the same.
        """

    @abstractmethod
    def read(self, timeout: float) -> list[Chunk]:
        """Return what has arrived, waiting for it up to `timeout` seconds; never raises."""

    @abstractmethod
    def write(self, data: bytes) -> None:
        """Send bytes to all peers that are there; dropped where there is none. Never raises.

        What cannot be sent is dropped, and `unsent` says why.
        """

    @abstractmethod
    def close(self) -> None:
        """Give the device or port back. May be called twice."""

    def new_framer(self) -> Framer | LineFramer:
        """Return what finds the frames, or the lines, in the bytes of one peer."""
        return LineFramer() if self.framing == "text" else Framer()


class Backoff:
    """Intervals between attempts, doubling from `first` to `longest` seconds."""

    def __init__(self, first: float = 0.1, longest: float = 5.0) -> None:
        self._first = first
        self._longest = longest
        self._next = first

    def reset(self) -> None:
        self._next = self._first

    def next(self) -> float:
        wait = self._next
        self._next = min(2.0 * wait, self._longest)
        return wait


class ReconnectingSource(LinkSource):
    """A source that connects, and connects again when what it was connected to has gone."""

    longest_wait: float = 5.0

    def __init__(self, address: LinkAddress, *, clock: Clock) -> None:
        super().__init__(address, clock=clock)
        self._backoff = Backoff(longest=self.longest_wait)
        self._next_attempt = 0.0
        self._closed = False

    def open(self) -> None:
        if self.connected or self._closed:
            return
        try:
            self._connect()
        except LinkError as error:
            self.state = str(error)
            self._next_attempt = self.clock.monotonic() + self._backoff.next()
            raise
        except OSError as error:
            problem = self._problem(error)
            self.state = str(problem)
            self._next_attempt = self.clock.monotonic() + self._backoff.next()
            raise problem from error
        self.unsent = ""
        self.connected = True

    def read(self, timeout: float) -> list[Chunk]:
        if self._closed:
            self.clock.sleep(timeout)
            return []
        if not self.connected:
            wait = self._next_attempt - self.clock.monotonic()
            if wait > 0.0:
                self.clock.sleep(min(wait, timeout))
                return []
            with contextlib.suppress(LinkError):
                self.open()
            if not self.connected:
                return []
        try:
            chunks = self._receive(timeout)
        except OSError as error:
            self._lose(str(self._problem(error)))
            return [Chunk(self.clock.now_us(), b"")]
        if chunks:
            self._backoff.reset()
        return chunks

    def write(self, data: bytes) -> None:
        why = ""
        if self.connected:
            # A connection that has gone is noticed by reading, in the thread that reads.
            try:
                self._send(data)
            except LinkError as error:
                why = str(error)
            except OSError as error:
                why = f"cannot send ({error.strerror or error})"
        self.unsent = why

    def close(self) -> None:
        if not self._closed:
            self._closed = True
            self.connected = False
            with contextlib.suppress(OSError):
                self._disconnect()
            self.state = f"{self.address}: closed"

    def _lose(self, why: str) -> None:
        self.connected = False
        self.state = why
        self._next_attempt = self.clock.monotonic() + self._backoff.next()
        with contextlib.suppress(OSError):
            self._disconnect()

    def _problem(self, error: OSError) -> LinkError:
        """Put an error into one sentence with its remedy."""
        return network_error(self.address, error)

    @abstractmethod
    def _connect(self) -> None:
        """Connect, and set `state`; raise LinkError or OSError."""

    @abstractmethod
    def _receive(self, timeout: float) -> list[Chunk]:
        """Return what has arrived; raise LinkError or OSError when the connection has gone."""

    @abstractmethod
    def _send(self, data: bytes) -> None:
        """Send bytes; raise OSError where that is refused.

        It runs in another thread than all else: what it sends on may be closed at any time.
        """

    @abstractmethod
    def _disconnect(self) -> None: ...


def send_to_each(peers: Iterable[tuple[str, Callable[[], object]]]) -> None:
    """Send to several peers, each a name and what sends to it.

    One that cannot be reached does not keep it from the others; raise LinkError that names them.
    """
    refused = []
    for name, send in peers:
        try:
            send()
        except OSError as error:
            refused.append(f"{name} ({error.strerror or error})")
    if refused:
        raise LinkError(f"cannot send to {', '.join(refused)}")


def set_exclusive_port(listener: socket.socket) -> None:
    """Let no other program listen on a port that is about to be bound.

    Windows would hand it to any that asks to share it, as MAVProxy does, and with it the data.
    """
    if sys.platform == "win32":
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_EXCLUSIVEADDRUSE, 1)
    elif listener.type == socket.SOCK_STREAM:
        # Lets a new listener follow one that has just ended, not join one that runs.
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)


_PEER_UNREACHABLE_ERRORS: Final = {
    errno.ECONNREFUSED, errno.ETIMEDOUT, errno.EHOSTUNREACH, errno.ENETUNREACH,
    errno.ECONNRESET, errno.EPIPE, errno.EHOSTDOWN, errno.ENETDOWN,
}  # fmt: skip


def network_error(address: LinkAddress, error: OSError) -> LinkError:
    """Return the sentence for an error of a network link."""
    if isinstance(error, LinkError):
        return error
    where = f"{address.host} port {address.port}"
    kind = find_link_kind(address.kind)
    protocol = kind.protocol if isinstance(kind, NetworkLink) else "network"
    if isinstance(error, socket.gaierror):
        return LinkError(
            f"{address}: the host name '{address.host}' is not known; check its spelling or "
            "write its number"
        )
    if error.errno == errno.EADDRINUSE or getattr(error, "winerror", None) == 10048:
        return LinkError(
            f"{address}: {protocol} port {address.port} is in use by another program; close "
            "that (perhaps another ground station or recorder), or choose another port"
        )
    if getattr(error, "winerror", None) == 10013:
        return LinkError(
            f"{address}: Windows reserves {protocol} port {address.port} away: another program "
            "holds it for itself, or it is set aside; choose another port"
        )
    if error.errno in (errno.EACCES, errno.EPERM):
        return LinkError(
            f"{address}: no permission to open {protocol} port {address.port}; choose a port of "
            "1024 or above"
        )
    if error.errno == errno.EADDRNOTAVAIL:
        return LinkError(
            f"{address}: {address.host} is no address of this computer; write 127.0.0.1 for this "
            "computer only, or 0.0.0.0 for all its networks"
        )
    if error.errno == errno.ECONNREFUSED:
        return LinkUnavailableError(
            f"{address}: {where} refuses the connection (no program listening); check address "
            "and port; retrying"
        )
    if isinstance(error, TimeoutError) or error.errno in _PEER_UNREACHABLE_ERRORS:
        return LinkUnavailableError(f"{address}: nothing answers at {where}; retrying")
    return LinkUnavailableError(f"{address}: {error.strerror or error}; retrying")

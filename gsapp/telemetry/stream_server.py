"""What a recorder receives, passed on to other programs and computers; one way.

A thread of its own serves all of them fifty times a second. What a client sends is read and
dropped: it reaches nobody, but for notes of one that copies the flight, where that is asked for. A
client that does not take what it is sent is dropped, too; the
recorder never waits for one.
"""

from __future__ import annotations

import contextlib
import socket
import threading
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from ipaddress import ip_address
from pathlib import Path
from typing import Any, Final

from pydantic import BaseModel, ConfigDict, ValidationError

from gsapp.decoding.framing import MavlinkFrame, Residue, TextLine
from gsapp.flight.atomic_files import write_flight_file
from gsapp.flight.file_names import SHARE_FILE
from gsapp.foundation import FlightError, LinkError
from gsapp.telemetry.flight_notes import NoteReceiver
from gsapp.telemetry.flight_stream import HELLO, MAX_LINE, FlightSender
from gsapp.telemetry.link_kinds import LinkAddress
from gsapp.telemetry.link_registry import parse_link
from gsapp.telemetry.recorder_status import ShareStatus
from gsapp.telemetry.settings import TELEMETRY
from gsapp.telemetry.signing import read_signing_key
from gsapp.telemetry.sources.link_source import network_error
from gsapp.telemetry.sources.network import bind_sender, listen_on, prepare_connection, resolve

_READ_BYTES: Final = 65536


class ShareRequest(BaseModel):
    """Where a stream is to be passed on."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    links: tuple[str, ...] = ()  # LINKs of the kinds ``tcpin`` and ``udpout``.
    is_open: bool = False  # Whether anyone on a network may receive it, without a key.
    key_file: str = ""  # Of the key that other computers need; empty for the signing key.
    takes_notes: bool = False  # Whether notes of those who copy the flight are written into it.


NO_SHARES: Final = ShareRequest()


def share_address(link: str) -> LinkAddress:
    """Return the address of a LINK; raise LinkError if it cannot be shared with."""
    if link.strip().startswith("http:"):
        raise LinkError(
            f"'{link}': a recorder decodes nothing and has no page for browsers; the window has "
            "one, and gsapp replay FLIGHT --headless --share"
        )
    address = parse_link(link)
    if address.kind not in ("tcpin", "udpout"):
        raise LinkError(
            f"'{link}' cannot be shared with; write tcpin:HOST:PORT, to which others connect, "
            "or udpout:HOST:PORT, to which it is sent"
        )
    return address


def request_shares(folder: Path, request: ShareRequest) -> None:
    """Ask the recorder of a flight folder to share with these addresses, and no others.

    Raise FlightError if the folder cannot be written to.
    """
    write_flight_file(folder / SHARE_FILE, request.model_dump_json())


def pop_share_request(folder: Path) -> ShareRequest | None:
    """Return what the recorder of a folder was asked for since the last call; never raises."""
    path = folder / SHARE_FILE
    try:
        content = path.read_bytes()
        path.unlink()
        return ShareRequest.model_validate_json(content)
    except (OSError, ValidationError):
        return None


class _Share(ABC):
    """One address that the stream is passed on to."""

    def __init__(self, address: LinkAddress) -> None:
        self.address = address
        self.sent_bytes = 0
        self.dropped_bytes = 0
        self.note = ""

    @property
    def client_names(self) -> tuple[str, ...]:
        return ()

    @abstractmethod
    def serve(self, parts: Sequence[bytes]) -> None:
        """Pass on frames, or lines, that came since the last call; there may be none."""

    @abstractmethod
    def close(self) -> None: ...


class _UdpShare(_Share):
    """Datagrams to one address, a frame in each."""

    def __init__(self, address: LinkAddress) -> None:
        super().__init__(address)
        family, self._target = resolve(address, socket.SOCK_DGRAM)
        # Nothing reads from it: the system drops what is sent back.
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        try:
            bind_sender(self._socket, self._target)
        except OSError:
            self._socket.close()
            raise

    def serve(self, parts: Sequence[bytes]) -> None:
        for part in parts:
            try:
                self._socket.sendto(part, self._target)
            except OSError as error:
                self.dropped_bytes += len(part)
                self.note = f"cannot send ({error.strerror or error})"
            else:
                self.sent_bytes += len(part)
                self.note = ""

    def close(self) -> None:
        self._socket.close()


class _RefusedError(Exception):
    """A client may not have the flight."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _AccessRule:
    """What the clients of a TCP port may have of the flight."""

    folder: Callable[[], Path]  # It is recorded into.
    keys: tuple[bytes, ...]  # Of which a client that copies it must have one; empty for none.
    is_bare: bool  # Whether others receive frames without a proof.
    takes_notes: Callable[[], bool]  # Whether notes of a copy are written into the flight.


class _TcpClient:
    """A program that called.

    One that says ``gsapp flight`` copies the flight from its beginning, read from the files at the
    pace at which it takes it; any other receives what comes from when it called.
    """

    def __init__(
        self, connection: socket.socket, host: str, port: int, access: _AccessRule
    ) -> None:
        self.name = f"{host}:{port}"
        self._host = host
        self.is_copy = False
        self._access = access
        self._called = time.monotonic()
        self._socket = connection
        self._first = b""  # what it says, as long as that may be the request of a copy
        self._is_asked = True
        self._sender: FlightSender | None = None
        self._folder = access.folder()
        self._takes_notes = access.takes_notes()
        self._pending = b""
        connection.setblocking(False)
        # What waits in the system is old when it arrives.
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, TELEMETRY.client_send_buffer)
        prepare_connection(connection)

    def serve(self, data: bytes) -> int:
        """Send as much as the client takes, and return that; raise OSError where it is gone."""
        self._receive()
        if self._is_asked:
            self._listen()
        if self._sender is not None and self._takes_notes != self._access.takes_notes():
            raise ConnectionError("it has to learn whether its notes are taken")
        if self._sender is None:
            self._pending += data
        elif self._sender.is_accepted and len(self._pending) < TELEMETRY.client_send_buffer:
            if self._folder != self._access.folder():
                raise ConnectionError("the flight is in another folder by now")
            self._pending += self._sender.poll(time.time_ns() // 1000)
        sent = 0
        may_send = self._sender is not None or not self._is_asked
        if self._pending and may_send:
            with contextlib.suppress(BlockingIOError):
                sent = self._socket.send(self._pending)
                self._pending = self._pending[sent:]
        return sent

    def _receive(self) -> None:
        received = b""
        if self._sender is None or self._sender.reads_client:
            with contextlib.suppress(BlockingIOError):
                received = self._socket.recv(_READ_BYTES)
                if not received:
                    raise ConnectionError("closed")
        if self._is_asked:
            self._first += received
        elif self._sender is not None:
            self._sender.take_notes(received)

    def _listen(self) -> None:
        """Find out whether the client copies the flight, and answer it."""
        waited = time.monotonic() - self._called
        if self._sender is None and not self._first.startswith(HELLO):
            is_silent = len(self._first) < len(HELLO) and HELLO.startswith(self._first)
            limit = TELEMETRY.hello_time if self._access.is_bare else TELEMETRY.proof_time
            if is_silent and waited < limit:
                return
            if not self._access.is_bare:
                raise _RefusedError("it has not the key")
            self._is_asked = False
            return
        if waited > TELEMETRY.proof_time or len(self._first) > 2 * MAX_LINE:
            raise _RefusedError("it has not the key")
        if self._sender is None:
            notes = NoteReceiver(self._folder, self._host) if self._takes_notes else None
            self._sender = FlightSender(self._folder, self._access.keys, notes)
            self._pending = b""
        while b"\n" in self._first and self._is_asked:
            line, _, self._first = self._first.partition(b"\n")
            self._pending += self._sender.answer(line)
            self.is_copy = self._sender.is_accepted
            self._is_asked = not self.is_copy

    @property
    def pending_bytes(self) -> int:
        return len(self._pending)

    def close(self) -> None:
        self._socket.close()


class _TcpShare(_Share):
    """A TCP port; whoever calls receives the flight, or what comes from then on."""

    def __init__(self, address: LinkAddress, access: _AccessRule) -> None:
        super().__init__(address)
        self._access = access
        self._listener = listen_on(address)
        self._clients: list[_TcpClient] = []

    @property
    def client_names(self) -> tuple[str, ...]:
        return tuple(client.name for client in self._clients)

    def serve(self, parts: Sequence[bytes]) -> None:
        self._accept()
        data = b"".join(parts)
        for client in list(self._clients):
            try:
                self.sent_bytes += client.serve(data)
            except _RefusedError as error:
                self.note = f"{client.name} was refused: {error}"
                self._remove(client)
            except FlightError as error:
                self.note = f"a note of {client.name} was not written: {error}"
                self._remove(client)
            except (OSError, ValueError):  # it is gone, or what it says makes no sense
                self._remove(client)
            else:
                if client.pending_bytes > TELEMETRY.max_client_bytes and not client.is_copy:
                    self.note = f"{client.name} was disconnected: it does not read"
                    self._remove(client)

    def _accept(self) -> None:
        while True:
            try:
                connection, (host, port, *_) = self._listener.accept()
            except OSError:
                return  # nobody calls, or hung up already
            if len(self._clients) >= TELEMETRY.max_clients:
                connection.close()
                self.note = f"{host}:{port} was refused: {TELEMETRY.max_clients} are connected"
                continue
            try:
                self._clients.append(_TcpClient(connection, host, port, self._access))
            except OSError:
                connection.close()

    def _remove(self, client: _TcpClient) -> None:
        self.dropped_bytes += client.pending_bytes
        self._clients.remove(client)
        client.close()

    def close(self) -> None:
        for client in self._clients:
            client.close()
        self._clients.clear()
        self._listener.close()


class StreamServer:
    """Passes on what a recorder receives.

    Parameters
    ----------
    link : LinkAddress
        What is recorded.
    key : bytes, optional
        The signing key: what other computers need to copy the flight, unless a request names
        another.

    Attributes
    ----------
    folder : Path
        The flight folder, from which the flight so far is read.
    """

    def __init__(self, link: LinkAddress, key: bytes | None = None) -> None:
        self._link = link
        self._key = key
        self.folder = Path()
        self._shares: dict[str, _Share] = {}
        self._refused: dict[str, str] = {}  # why, by LINK
        self.request = NO_SHARES
        self._next_request: ShareRequest | None = None
        self._queue: deque[list[bytes]] = deque()
        self._dropped_bytes = 0
        self._over = threading.Event()
        self._thread: threading.Thread | None = None

    def open(self, request: ShareRequest) -> None:
        """Begin to share; raise LinkError where an address cannot be shared with."""
        self._apply(request)
        for problem in self._refused.values():
            self.close()
            raise LinkError(problem)
        self._start()

    def change(self, request: ShareRequest) -> None:
        """Share with other addresses from now on; where that fails the status says why."""
        self._next_request = request
        self._start()

    def send(self, items: Sequence[MavlinkFrame | Residue | TextLine]) -> None:
        """Pass on what came out of a framer; stray bytes are left out. Returns at once."""
        if not self._shares:
            return
        parts = [
            item.data + b"\n" if isinstance(item, TextLine) else item.data
            for item in items
            if not isinstance(item, Residue)
        ]
        if len(self._queue) < TELEMETRY.max_unshared:
            self._queue.append(parts)
        else:
            self._dropped_bytes += sum(map(len, parts))

    def status(self) -> list[ShareStatus]:
        """Return how each address fares."""
        found = []
        for link in self.request.links:
            share = self._shares.get(link)
            if link in self._refused:
                found.append(ShareStatus(link=link, error=self._refused[link]))
            elif share is not None:
                dropped = share.dropped_bytes + self._dropped_bytes
                found.append(
                    ShareStatus(
                        link=link, clients=share.client_names, sent_bytes=share.sent_bytes,
                        dropped_bytes=dropped, note=share.note,
                    )
                )  # fmt: skip
        return found

    def close(self) -> None:
        """Send what came, and hang up."""
        self._over.set()
        if self._thread is not None:
            self._thread.join(TELEMETRY.final_sending_time)
        for share in self._shares.values():
            share.close()

    def _start(self) -> None:
        if self._thread is None and (self._shares or self._next_request):
            self._thread = threading.Thread(target=self._run, name="sharing", daemon=True)
            self._thread.start()

    def _run(self) -> None:
        while True:
            pause = TELEMETRY.share_interval if self._shares else TELEMETRY.retry_interval
            is_over = self._over.wait(pause)
            request, self._next_request = self._next_request, None
            if request is not None:
                self._apply(request)
            parts = [part for _ in range(len(self._queue)) for part in self._queue.popleft()]
            for share in self._shares.values():
                try:
                    share.serve(parts)
                except Exception as error:  # a fault of one must not end the others
                    share.note = str(error)
            if is_over:
                return

    def _apply(self, request: ShareRequest) -> None:
        shares, refused = {}, {}
        former_access = (self.request.is_open, self.request.key_file)
        keeps = (request.is_open, request.key_file) == former_access
        for link in dict.fromkeys(request.links):
            former = self._shares.get(link) if keeps else None
            if former is None and link in self._shares:
                self._shares.pop(link).close()  # its port is needed
            try:
                shares[link] = former or self._make_share(link, request)
            except LinkError as error:
                refused[link] = str(error)
        former_shares, self._shares, self._refused = self._shares, shares, refused
        self.request = request
        for share in former_shares.values():
            if share not in shares.values():
                share.close()

    def _make_share(self, link: str, request: ShareRequest) -> _Share:
        address = share_address(link)
        key = read_signing_key(request.key_file) if request.key_file else self._key
        try:
            _, target = resolve(address, socket.SOCK_DGRAM)
            is_open = request.is_open or ip_address(target[0]).is_loopback
            if not is_open and (key is None or address.kind == "udpout"):
                raise LinkError(
                    f"{address}: anyone on that network could receive the flight; share over tcpin "
                    "with a key (--share-key), from which another recording of this program copies "
                    "it, or allow other programs without a key (--share-open)"
                )
            if self._returns_to_link(address, target):
                raise LinkError(
                    f"{address}: this is the port that is recorded: all that is sent would come "
                    "back; choose another port"
                )
            if address.kind == "udpout":
                return _UdpShare(address)
            keys = ((key,) if key else ()) + ((b"",) if is_open else ())
            access = _AccessRule(
                folder=lambda: self.folder, keys=keys, is_bare=is_open,
                takes_notes=lambda: self.request.takes_notes,
            )  # fmt: skip
            return _TcpShare(address, access)
        except OSError as error:
            raise network_error(address, error) from error

    def _returns_to_link(self, address: LinkAddress, target: tuple[Any, ...]) -> bool:
        if (address.kind, self._link.kind, address.port) != ("udpout", "udpin", self._link.port):
            return False
        family = socket.AF_INET6 if ":" in target[0] else socket.AF_INET
        with socket.socket(family, socket.SOCK_DGRAM) as probe:
            try:
                probe.bind((target[0], 0))  # only an address of this computer can be bound
            except OSError:
                return False
        return True

"""MAVLink over TCP and UDP: as the one who calls or speaks first, or the one who waits for it."""

from __future__ import annotations

import contextlib
import selectors
import socket
from collections.abc import Iterable
from functools import partial
from ipaddress import ip_address
from typing import Any

from gsapp.telemetry.clock import Clock
from gsapp.telemetry.link_kinds import LinkAddress
from gsapp.telemetry.settings import TELEMETRY
from gsapp.telemetry.sources.link_source import (
    Chunk,
    LinkUnavailableError,
    ReconnectingSource,
    send_to_each,
    set_exclusive_port,
)

_READ_BYTES = 65536


def resolve(
    address: LinkAddress, kind: socket.SocketKind
) -> tuple[socket.AddressFamily, tuple[Any, ...]]:
    """Return address family and address of a link; those of IP version 4 go first."""
    found = socket.getaddrinfo(address.host, address.port, type=kind)
    family, _, _, _, target = min(found, key=lambda entry: entry[0] != socket.AF_INET)
    return family, target


def listen_on(address: LinkAddress) -> socket.socket:
    """Return a TCP socket that listens and does not block; raise OSError where it cannot."""
    family, target = resolve(address, socket.SOCK_STREAM)
    made = socket.socket(family, socket.SOCK_STREAM)
    try:
        set_exclusive_port(made)
        made.bind(target)
        made.listen(TELEMETRY.max_clients)
        made.setblocking(False)
    except OSError:
        made.close()
        raise
    return made


def bind_sender(made: socket.socket, target: tuple[Any, ...]) -> None:
    """Bind a UDP socket that sends to a target; raise OSError where it cannot."""
    if ip_address(target[0]).is_loopback:
        made.bind(("127.0.0.1" if made.family == socket.AF_INET else "::1", 0))
    else:
        made.bind(("", 0))  # which interface leads to the host, the system decides


def prepare_connection(connection: socket.socket) -> None:
    """Send small frames at once, and notice a peer that has vanished without a word."""
    # macOS refuses where the peer has hung up already, which reading finds out.
    with contextlib.suppress(OSError):
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        # macOS calls the first of them TCP_KEEPALIVE, and waits two hours without it.
        idle = "TCP_KEEPIDLE" if hasattr(socket, "TCP_KEEPIDLE") else "TCP_KEEPALIVE"
        for name, value in ((idle, 5), ("TCP_KEEPINTVL", 2), ("TCP_KEEPCNT", 3)):
            if hasattr(socket, name):
                connection.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)


class TcpSource(ReconnectingSource):
    """Call a host, and call again whenever the connection ends."""

    def __init__(self, address: LinkAddress, *, clock: Clock) -> None:
        super().__init__(address, clock=clock)
        self._socket: socket.socket | None = None

    def _connect(self) -> None:
        made = socket.create_connection(
            (self.address.host, self.address.port), timeout=TELEMETRY.connect_timeout
        )
        prepare_connection(made)
        self._socket = made
        self.state = f"{self.address}: connected"

    def _receive(self, timeout: float) -> list[Chunk]:
        if self._socket is None:
            return []
        self._socket.settimeout(max(timeout, 0.0))
        try:
            data = self._socket.recv(_READ_BYTES)
        except (TimeoutError, BlockingIOError):
            return []
        if not data:
            raise LinkUnavailableError(
                f"{self.address}: connection closed by the other side; reconnecting"
            )
        return [Chunk(self.clock.now_us(), data)]

    def _send(self, data: bytes) -> None:
        connection = self._socket
        if connection is not None:
            connection.send(data)

    def _disconnect(self) -> None:
        if self._socket is not None:
            self._socket.close()
            self._socket = None


class TcpInSource(ReconnectingSource):
    """Listen on a port; several may call at once, each a stream of its own."""

    def __init__(self, address: LinkAddress, *, clock: Clock) -> None:
        super().__init__(address, clock=clock)
        self._listener: socket.socket | None = None
        self._clients: dict[socket.socket, str] = {}
        self._selector: selectors.BaseSelector | None = None

    def _connect(self) -> None:
        self._listener = made = listen_on(self.address)
        self._selector = selectors.DefaultSelector()
        self._selector.register(made, selectors.EVENT_READ)
        self._describe()

    def _describe(self) -> None:
        callers = ", ".join(sorted(self._clients.values()))
        self.state = f"{self.address}: " + (
            f"connected to {callers}" if callers else "waiting for a connection"
        )

    def _receive(self, timeout: float) -> list[Chunk]:
        chunks: list[Chunk] = []
        if self._selector is None:
            return chunks
        for key, _ in self._selector.select(timeout):
            if key.fileobj is self._listener:
                self._welcome()
            elif isinstance(key.fileobj, socket.socket):
                chunks.append(self._from_client(key.fileobj))
        return chunks

    def _welcome(self) -> None:
        if self._listener is None or self._selector is None:
            return
        try:
            client, caller = self._listener.accept()
        except OSError:
            return  # the caller has gone already
        if len(self._clients) >= TELEMETRY.max_clients:
            client.close()
            return
        client.setblocking(False)
        prepare_connection(client)
        self._clients[client] = f"{caller[0]}:{caller[1]}"
        self._selector.register(client, selectors.EVENT_READ)
        self._describe()

    def _from_client(self, client: socket.socket) -> Chunk:
        try:
            data = client.recv(_READ_BYTES)
        except OSError:
            data = b""  # an error ends a connection as well
        stamp = self.clock.now_us()
        peer = self._clients[client]
        if not data:
            self._dismiss(client)
        return Chunk(stamp, data, peer)

    def _dismiss(self, client: socket.socket) -> None:
        if self._selector is not None:
            self._selector.unregister(client)
        del self._clients[client]
        client.close()
        self._describe()

    def _send(self, data: bytes) -> None:
        send_to_each(
            (name, partial(client.send, data)) for client, name in list(self._clients.items())
        )

    def _disconnect(self) -> None:
        if self._selector is not None:
            self._selector.close()
            self._selector = None
        for client in self._clients:
            client.close()
        self._clients.clear()
        if self._listener is not None:
            self._listener.close()
            self._listener = None


_RECEIVE_BUFFER = 4 << 20
_MOST_AT_ONCE = 256


class _UdpSource(ReconnectingSource):
    """What both directions share."""

    def __init__(self, address: LinkAddress, *, clock: Clock) -> None:
        super().__init__(address, clock=clock)
        self._socket: socket.socket | None = None
        self._target: tuple[Any, ...] = ()

    def _make(self, family: socket.AddressFamily) -> socket.socket:
        made = socket.socket(family, socket.SOCK_DGRAM)
        # Room for what comes while the computer is busy.
        with contextlib.suppress(OSError):
            made.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _RECEIVE_BUFFER)
        return made

    def _receive(self, timeout: float) -> list[Chunk]:
        chunks: list[Chunk] = []
        source = self._socket
        if source is None:
            return chunks
        source.settimeout(max(timeout, 0.0))
        try:
            while len(chunks) < _MOST_AT_ONCE:
                try:
                    data, sender = source.recvfrom(65535)
                except ConnectionError:
                    continue  # an earlier reply found nobody; the next to speak is heard
                stamp = self.clock.now_us()
                if data and self._accepts(sender):
                    chunks.append(Chunk(stamp, data, f"{sender[0]}:{sender[1]}"))
                source.settimeout(0.0)
        except (TimeoutError, BlockingIOError):
            pass
        return chunks

    def _accepts(self, sender: tuple[Any, ...]) -> bool:
        raise NotImplementedError

    def _send_to(self, peers: Iterable[tuple[Any, ...]], data: bytes) -> None:
        source = self._socket
        if source is not None:
            send_to_each(
                (f"{peer[0]}:{peer[1]}", partial(source.sendto, data, peer)) for peer in peers
            )

    def _disconnect(self) -> None:
        if self._socket is not None:
            self._socket.close()
            self._socket = None


class UdpInSource(_UdpSource):
    """Wait on a port for whoever sends; replies go to all who were heard lately."""

    def __init__(self, address: LinkAddress, *, clock: Clock) -> None:
        super().__init__(address, clock=clock)
        self._peers: dict[tuple[Any, ...], float] = {}

    def _connect(self) -> None:
        family, target = resolve(self.address, socket.SOCK_DGRAM)
        made = self._make(family)
        try:
            set_exclusive_port(made)
            made.bind(target)
        except OSError:
            made.close()
            raise
        self._socket = made
        self.state = f"{self.address}: waiting for data"

    def _accepts(self, sender: tuple[Any, ...]) -> bool:
        if sender not in self._peers:
            if len(self._peers) >= TELEMETRY.max_peers:
                del self._peers[min(self._peers, key=self._peers.__getitem__)]
            self._peers[sender] = 0.0
            heard = ", ".join(sorted({peer[0] for peer in self._peers}))
            self.state = f"{self.address}: receiving from {heard}"
        self._peers[sender] = self.clock.monotonic()
        return True

    def _send(self, data: bytes) -> None:
        recent = self.clock.monotonic() - TELEMETRY.peer_timeout
        peers = [peer for peer, heard in list(self._peers.items()) if heard >= recent]
        self._send_to(peers, data)


class UdpOutSource(_UdpSource):
    """Speak to a host and port; whatever that host answers is received."""

    def _connect(self) -> None:
        family, self._target = resolve(self.address, socket.SOCK_DGRAM)
        made = self._make(family)
        try:
            bind_sender(made, self._target)
        except OSError:
            made.close()
            raise
        self._socket = made
        self.state = f"{self.address}: no answer yet"

    def _accepts(self, sender: tuple[Any, ...]) -> bool:
        if sender[0] != self._target[0]:
            return False
        self.state = f"{self.address}: receiving"
        return True

    def _send(self, data: bytes) -> None:
        self._send_to([self._target], data)

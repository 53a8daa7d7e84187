"""MAVLink over UDP: waiting for senders, or speaking first."""

from __future__ import annotations

import contextlib
import socket
from collections.abc import Iterable
from functools import partial
from typing import Any

from gsapp.telemetry.clock import Clock
from gsapp.telemetry.link_address import LinkAddress
from gsapp.telemetry.settings import TELEMETRY
from gsapp.telemetry.sources.link_source import (
    Chunk,
    ReconnectingSource,
    send_to_each,
    set_exclusive_port,
)

_RECEIVE_BUFFER = 4 << 20
_MOST_AT_ONCE = 256


class _UdpSource(ReconnectingSource):
    """What both directions share."""

    def __init__(self, address: LinkAddress, *, clock: Clock) -> None:
        super().__init__(address, clock=clock)
        self._socket: socket.socket | None = None
        self._target: tuple[Any, ...] = ()

    def _resolve(self) -> tuple[socket.AddressFamily, tuple[Any, ...]]:
        """Return address family and address; those of IP version 4 go first."""
        found = socket.getaddrinfo(self.address.host, self.address.port, type=socket.SOCK_DGRAM)
        family, _, _, _, target = min(found, key=lambda entry: entry[0] != socket.AF_INET)
        return family, target

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
        family, target = self._resolve()
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
        family, self._target = self._resolve()
        made = self._make(family)
        loopback = socket.getaddrinfo(self._target[0], None)[0][4][0] in ("127.0.0.1", "::1")
        try:
            if loopback:
                made.bind(("127.0.0.1" if family == socket.AF_INET else "::1", 0))
            else:
                made.bind(("", 0))  # which interface leads to the host, the system decides
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

"""A flight that another computer records and shares, copied from its beginning."""

from __future__ import annotations

import contextlib
import socket
import struct
from collections.abc import Sequence

from gsapp.flight.events import Event, mark_event_id
from gsapp.telemetry.clock import Clock
from gsapp.telemetry.flight_notes import encode_note
from gsapp.telemetry.flight_stream import (
    HELLO,
    MAX_LINE,
    NOTES_PURPOSE,
    TAKES_NOTES,
    FlightReceiver,
    StreamSeal,
    make_nonce,
)
from gsapp.telemetry.link_kinds import LinkAddress
from gsapp.telemetry.settings import TELEMETRY
from gsapp.telemetry.sources.link_source import (
    Chunk,
    LinkUnavailableError,
    ReconnectingSource,
    RecordedChunk,
)
from gsapp.telemetry.sources.network import prepare_connection

_READ_BYTES = 1 << 18
_MANY = 1 << 30
_REFUSALS = {
    b"key": "the key is not that of its recorder; give both the same (--share-key)",
    b"other": "it records another flight by now; stop, and connect again for a new flight",
}


class FlightCopySource(ReconnectingSource):
    """Calls a recorder that shares its flight; nothing is ever sent to the aircraft."""

    def __init__(self, address: LinkAddress, *, clock: Clock) -> None:
        super().__init__(address, clock=clock)
        self._socket: socket.socket | None = None
        self._receiver: FlightReceiver | None = None
        self._signing_key = b""
        self._after = (0, 0)  # stamp of the last record, and how many have that
        self._heard = 0.0
        self.sends_notes = False
        self._offered: Sequence[Event] = ()
        self._sent: set[str] = set()  # over this connection
        self._note_seal: StreamSeal | None = None
        self._outgoing = b""

    def prepare(self, after_us: int, signing_key: bytes) -> None:
        self._after = (after_us, _MANY if after_us else 0)
        self._signing_key = signing_key

    def _connect(self) -> None:
        made = socket.create_connection(
            (self.address.host, self.address.port), timeout=TELEMETRY.connect_timeout
        )
        try:
            prepare_connection(made)
            nonce = make_nonce()
            made.sendall(HELLO + b"%d %d %b\n" % (*self._after, nonce))
            answer = _read_line(made)
            if not answer.startswith(HELLO):
                raise LinkUnavailableError(
                    f"{self.address}: the program there shares no flight; for MAVLink use "
                    f"tcp:{self.address.host}:{self.address.port}; retrying"
                )
            identity = self._signing_key, nonce, answer.removeprefix(HELLO)
            seal = StreamSeal(*identity)
            made.sendall(seal.proof() + b"\n")
            if (verdict := _read_line(made)) not in (b"ok", TAKES_NOTES):
                why = _REFUSALS.get(verdict, "the connection was refused")
                raise LinkUnavailableError(f"{self.address}: {why}; retrying")
        except BaseException:
            made.close()
            raise
        self._socket, self._receiver = made, FlightReceiver(seal, self.events)
        self._heard = self.clock.monotonic()
        self.sends_notes = verdict == TAKES_NOTES
        self._note_seal = StreamSeal(*identity, NOTES_PURPOSE) if self.sends_notes else None
        self._sent, self._outgoing, self.has_events = set(), b"", False
        notes = "notes go back to it" if self.sends_notes else "notes stay on this computer"
        self.state = f"{self.address}: copying the flight; {notes}"

    def offer_notes(self, notes: Sequence[Event]) -> None:
        self._offered = notes

    def _receive(self, timeout: float) -> list[Chunk]:
        connection, receiver = self._socket, self._receiver
        if connection is None or receiver is None:
            return []
        connection.settimeout(max(timeout, 0.0))
        self._send_notes(connection)
        try:
            data = connection.recv(_READ_BYTES)
        except (TimeoutError, BlockingIOError):
            if self.clock.monotonic() - self._heard > TELEMETRY.copy_timeout:
                raise LinkUnavailableError(f"{self.address}: silent; reconnecting") from None
            return []
        if not data:
            raise LinkUnavailableError(
                f"{self.address}: connection closed by the other side; reconnecting"
            )
        self._heard = self.clock.monotonic()
        try:
            chunks = receiver.feed(data)
        except (ValueError, IndexError, struct.error) as error:
            raise LinkUnavailableError(f"{self.address}: {error}; reconnecting") from error
        if receiver.server_us:
            wall_us = self.clock.now_us() - self.clock.correction_us
            self.clock_offset_us = receiver.server_us - wall_us
            receiver.server_us = 0
        for chunk in chunks:
            self._note_position(chunk)
        self.has_events, self.files = receiver.has_events, receiver.files
        return list(chunks)

    def _send_notes(self, connection: socket.socket) -> None:
        """Send one note made here, where the other side takes it and does not have it yet."""
        if self._note_seal is None or not self.has_events:
            return
        if not self._outgoing:
            names = {mark_event_id(event): event for event in self._offered}
            name = next((one for one in names if one not in self._sent), None)
            if name is None:
                return
            self._sent.add(name)
            note = encode_note(names[name], socket.gethostname())
            self._outgoing = self._note_seal.encode_block(note)
        with contextlib.suppress(TimeoutError, BlockingIOError):
            self._outgoing = self._outgoing[connection.send(self._outgoing) :]

    def _note_position(self, chunk: RecordedChunk) -> None:
        stamp, count = self._after
        former = count if stamp == chunk.stamp_us else 0
        self._after = (chunk.stamp_us, former + len(chunk.items))

    def _send(self, data: bytes) -> None:
        """Send nothing: the flight is another recorder's."""

    def _disconnect(self) -> None:
        if self._socket is not None:
            self._socket.close()
            self._socket = None


def _read_line(connection: socket.socket) -> bytes:
    line = b""
    while not line.endswith(b"\n") and len(line) < MAX_LINE:
        # One by one: what follows the line are blocks.
        if not (one := connection.recv(1)):
            break
        line += one
    return line.removesuffix(b"\n")

"""The stream from which another recorder copies a flight: from its beginning, with its stamps.

The client speaks first, in lines: ``gsapp flight 1 STAMP COUNT NONCE``. STAMP is that of the last
record it has (0 for none), COUNT how many with that stamp. The server answers ``gsapp flight 1
NONCE``, the client ``PROOF``, and the server ``ok``, ``key`` (not the same signing key) or
``other`` (it records another flight by now); after ``ok notes`` the client may send notes. Both
nonces make a key of this connection out of the signing key, which is not sent. PROOF is its HMAC,
and so is the seal of every block that follows: nobody without the key is sent a flight, or can put
anything into it. Nothing is encrypted.

A block is its length (4 bytes, big-endian), its seal and its content: ``r`` for what was recorded
at one stamp from one sender, ``e`` for lines of ``events.jsonl``, ``f`` for the files with which
the flight is read (first, where the client has no record), ``t`` for the server's time.
What the client sends are blocks, too, sealed for this direction: a mark or note in each.
"""

from __future__ import annotations

import hashlib
import hmac
import json
import os
from collections import deque
from collections.abc import Iterator, Sequence
from itertools import groupby
from pathlib import Path
from struct import Struct
from typing import Final

from gsapp.decoding.framing import (
    MAGIC_2,
    MavlinkFrame,
    Residue,
    TextLine,
    frame_component,
    frame_message_id,
    frame_system,
)
from gsapp.decoding.sender_filter import FrameOrigin
from gsapp.flight.events import Event, EventLog, events_path
from gsapp.flight.raw_files import STAMP_STRUCT, RawTail
from gsapp.flight.raw_files.record_files import RawRecord
from gsapp.telemetry.flight_files import decode_files, encode_files
from gsapp.telemetry.flight_notes import NoteReceiver
from gsapp.telemetry.settings import TELEMETRY
from gsapp.telemetry.sources.link_source import RecordedChunk

HELLO: Final = b"gsapp flight 1 "
TAKES_NOTES: Final = b"ok notes"
NOTES_PURPOSE: Final = b"notes"
MAX_LINE: Final = 200
_LENGTH: Final = Struct(">I")
_ITEM: Final = Struct(">cI")
_SEAL_BYTES: Final = 16
_MAX_BLOCK: Final = 1 << 22
_MAX_RECORDS: Final = 2000  # In one turn of the server.
_TIME_INTERVAL_US: Final = 1_000_000
_KINDS: Final = {"frame": b"f", "line": b"l", "residue": b"s"}
_OWN_EVENTS: Final = ("alarm", "alarm-ended")
"""Of the equipment of the computer that wrote them."""


class StreamSeal:
    """The key of one connection."""

    def __init__(
        self,
        signing_key: bytes,
        client_nonce: bytes,
        server_nonce: bytes,
        purpose: bytes = b"flight",
    ) -> None:
        nonces = b"gsapp " + purpose + client_nonce + b" " + server_nonce
        # Hashed, since to an HMAC an empty key and one of zeros are the same.
        self._key = hmac.digest(hashlib.sha256(signing_key).digest(), nonces, "sha256")
        self._count = 0

    def proof(self) -> bytes:
        return hmac.digest(self._key, b"client", "sha256").hex().encode()

    def next_seal(self, content: bytes) -> bytes:
        """Return the seal of the next block."""
        self._count += 1
        return hmac.digest(self._key, b"%d %b" % (self._count, content), "sha256")[:_SEAL_BYTES]

    def encode_block(self, content: bytes) -> bytes:
        return _LENGTH.pack(len(content)) + self.next_seal(content) + content


class SealedBlockReader:
    """Takes blocks out of what the other side sends."""

    def __init__(self, seal: StreamSeal, max_block: int) -> None:
        self._seal = seal
        self._max_block = max_block
        self._data = b""

    def feed(self, data: bytes) -> list[bytes]:
        """Return the content of each block that is whole; raise ValueError where one is altered."""
        self._data += data
        contents = []
        start = 0
        head = _LENGTH.size + _SEAL_BYTES
        while len(self._data) >= start + head:
            (length,) = _LENGTH.unpack_from(self._data, start)
            if length > self._max_block:
                raise ValueError("a block is too long")
            end = start + head + length
            if len(self._data) < end:
                break
            seal = self._data[start + _LENGTH.size : start + head]
            content = self._data[start + head : end]
            if not hmac.compare_digest(seal, self._seal.next_seal(content)):
                raise ValueError("a block was altered on its way")
            contents.append(content)
            start = end
        self._data = self._data[start:]
        return contents


def make_nonce() -> bytes:
    """Return a random word that no connection had before."""
    return os.urandom(16).hex().encode()


class FlightSender:
    """The server's side of one connection.

    `keys` are the signing keys one of which the client must have; an empty one is for anyone.
    `notes` takes those of the client; None takes none.
    """

    def __init__(
        self, folder: Path, keys: Sequence[bytes], notes: NoteReceiver | None = None
    ) -> None:
        self._folder = folder
        self._keys = keys
        self._tail = RawTail(folder)
        self._events = EventLog(events_path(folder))
        self._after = (0, 0)
        self._same_stamp = 0  # records with that stamp so far
        self._next_time_us = 0
        self._has_files = False  # the client
        self._nonces = (b"", b"")
        self._seal: StreamSeal | None = None
        self._notes = notes
        self._note_blocks: SealedBlockReader | None = None
        self._waiting: deque[bytes] = deque()

    def answer(self, line: bytes) -> bytes:
        """Return the answer to a line of the client; raise ValueError where it is none."""
        if line.startswith(HELLO):
            stamp, count, nonce = line.removeprefix(HELLO).split()
            self._after = (int(stamp), int(count))
            self._nonces = (nonce, make_nonce())
            return HELLO + self._nonces[1] + b"\n"
        seals = {key: StreamSeal(key, *self._nonces) for key in self._keys if self._nonces[0]}
        found = [key for key, one in seals.items() if hmac.compare_digest(one.proof(), line)]
        if not found:
            return b"key\n"
        if self._after[0]:
            first = RawTail(self._folder).poll(1)
            if not first or first[0].stamp_us > self._after[0]:
                return b"other\n"
        self._seal = seals[found[0]]
        if self._notes is None:
            return b"ok\n"
        self._note_blocks = SealedBlockReader(
            StreamSeal(found[0], *self._nonces, NOTES_PURPOSE), TELEMETRY.max_note_block
        )
        return TAKES_NOTES + b"\n"

    def take_notes(self, data: bytes) -> None:
        """Take what the client sends, and write its notes at the rate that is allowed.

        Raise ValueError where it is no note, FlightError where the disk refuses.
        """
        if self._notes is None or self._note_blocks is None:
            return  # it reaches nobody
        self._waiting += self._note_blocks.feed(data)
        while self._waiting and self._notes.may_take():
            self._notes.take(self._waiting.popleft())

    @property
    def reads_client(self) -> bool:
        """Return whether what the client sends is to be read: not while notes wait."""
        return not self._waiting

    @property
    def is_accepted(self) -> bool:
        return self._seal is not None

    def poll(self, now_us: int) -> bytes:
        """Return blocks of what came since; once a second events and the time, too."""
        contents: list[bytes] = []
        if not (self._after[0] or self._has_files):
            self._has_files = True
            contents.append(b"f" + encode_files(self._folder))
        if self._tail.has_grown():
            contents += self._batches(self._tail.poll(_MAX_RECORDS))
        if now_us >= self._next_time_us:
            self._next_time_us = now_us + _TIME_INTERVAL_US
            contents += (b"e" + self._event_lines(), b"t" + STAMP_STRUCT.pack(now_us))
        seal = self._seal
        if seal is None:
            return b""
        return b"".join(map(seal.encode_block, contents))

    def _batches(self, records: Sequence[RawRecord]) -> Iterator[bytes]:
        stamp_after, count_after = self._after
        for (stamp, origin), group in groupby(records, lambda one: (one.stamp_us, one.origin)):
            if stamp < stamp_after:
                continue
            batch = list(group)
            if stamp == stamp_after:  # the client has some of them
                known = min(count_after - self._same_stamp, len(batch))
                self._same_stamp += known
                batch = batch[known:]
            if not batch:
                continue
            sender = origin.format()
            parts = [b"r", STAMP_STRUCT.pack(stamp), _LENGTH.pack(len(sender)), sender]
            for record in batch:
                parts += (_ITEM.pack(_KINDS[record.kind], len(record.data)), record.data)
            yield b"".join(parts)

    def _event_lines(self) -> bytes:
        events = [event for event in self._events.poll() if event.kind not in _OWN_EVENTS]
        return b"".join(json.dumps(event.to_json()).encode() + b"\n" for event in events)


class FlightReceiver:
    """The client's side of one connection: blocks to chunks, and to events.

    Attributes
    ----------
    server_us : int
        Time of the server when it sent the last block, host microseconds; 0 before the first.
    has_events : bool
        Whether all events of the flight so far have come.
    files : dict of str to str, optional
        Files with which the flight is read, text by name.
    """

    def __init__(self, seal: StreamSeal, events: deque[Event]) -> None:
        self._blocks = SealedBlockReader(seal, _MAX_BLOCK)
        self._events = events
        self.has_events = False
        self.files: dict[str, str] | None = None
        self._offset = 0  # of stray bytes
        self.server_us = 0

    def feed(self, data: bytes) -> list[RecordedChunk]:
        """Return what is whole; raise ValueError where it is not what the server sent."""
        chunks = []
        for content in self._blocks.feed(data):
            kind, body = content[:1], content[1:]
            if kind == b"r":
                chunks.append(self._chunk(body))
            elif kind == b"e":
                self._events.extend(Event.from_json(json.loads(one)) for one in body.splitlines())
                self.has_events = True
            elif kind == b"f":
                self.files = decode_files(body)
            elif kind == b"t":
                (self.server_us,) = STAMP_STRUCT.unpack(body)
        return chunks

    def _chunk(self, body: bytes) -> RecordedChunk:
        (stamp,) = STAMP_STRUCT.unpack_from(body)
        (length,) = _LENGTH.unpack_from(body, STAMP_STRUCT.size)
        position = STAMP_STRUCT.size + _LENGTH.size + length
        origin = FrameOrigin.parse(body[position - length : position])
        items: list[MavlinkFrame | Residue | TextLine] = []
        while position < len(body):
            kind, length = _ITEM.unpack_from(body, position)
            position += _ITEM.size
            data = body[position : position + length]
            position += length
            if kind == b"f":
                items.append(_frame(self._offset, data))
            elif kind == b"l":
                items.append(TextLine(self._offset, data, b"\n"))
            else:
                items.append(Residue(self._offset, data))
            self._offset += length
        return RecordedChunk.of_items(stamp, items, origin)


def _frame(offset: int, data: bytes) -> MavlinkFrame:
    version, sequence = (2, data[4]) if data[0] == MAGIC_2 else (1, data[2])
    ids = frame_system(data), frame_component(data), frame_message_id(data)
    return MavlinkFrame(offset, data, version, sequence, *ids, known=True)

"""Splitting a stream into MAVLink frames or text lines, losing no undamaged one.

A damaged frame costs only itself: after every candidate that fails, the search goes on at the
very next byte, not after the length that the damaged header claimed. Decisions depend on the
bytes alone, never on the pieces in which they arrived; where the bytes so far do not decide, the
framer waits for more, for a pause of the link (`flush_complete`) or for its end (`flush`).

A frame of known id is accepted when its checksum fits, unless a second frame whose checksum fits
starts within it and ends beyond it: then one of the two is chance (a torn frame completed by the
head of the next), and what follows tells which. A frame of unknown id has no checksum that could
be verified; it is accepted on the evidence around it, and never at the cost of a known one. If its
checksum fits a known id that differs in one bit, it is damaged.
"""

from __future__ import annotations

import codecs
import re
from collections.abc import Container, Mapping
from enum import Enum
from functools import cache
from struct import Struct
from typing import Final, NamedTuple

from fastcrc import crc16

from gsapp.decoding.dialect import WireFormat, wire_formats


class MavlinkFrame(NamedTuple):
    """One whole MAVLink frame, checked as far as its id is known."""

    offset: int  # Position of its first byte in the stream since the link was opened.
    data: bytes  # The frame from magic byte to checksum (and signature, if signed).
    version: int  # 1 or 2.
    sequence: int
    system: int
    component: int
    message_id: int
    """From the header."""
    known: bool  # Whether the id is in the dialect, so that the checksum could be verified.

    @property
    def payload(self) -> bytes:
        """Return the payload as sent; MAVLink 2 cuts trailing zero bytes."""
        start = 10 if self.version == 2 else 6
        return self.data[start : start + self.data[1]]


class Residue(NamedTuple):
    """Bytes that belong to no whole frame."""

    offset: int  # Position of the first byte in the stream.
    data: bytes


MAGIC_1: Final = 0xFE
MAGIC_2: Final = 0xFD
SIGNED_FLAG: Final = 0x01
MAX_FRAME_LENGTH: Final = 280
SIGNATURE_BYTES: Final = 13

_HEADER_1: Final = Struct("<BBBBBB").unpack_from
_HEADER_2: Final = Struct("<BBBBBBBHB").unpack_from
_NEXT_MAGIC: Final = re.compile(rb"[\xfd\xfe]").search


def frame_message_id(frame: bytes) -> int:
    """Return the id of a whole MAVLink frame."""
    if frame[0] == MAGIC_2:
        return frame[7] | frame[8] << 8 | frame[9] << 16
    return frame[5]


def frame_system(frame: bytes) -> int:
    """Return the system that a whole MAVLink frame names as its sender."""
    return frame[5] if frame[0] == MAGIC_2 else frame[3]


def frame_component(frame: bytes) -> int:
    """Return the component that a whole MAVLink frame names as its sender."""
    return frame[6] if frame[0] == MAGIC_2 else frame[4]


class _Decision(Enum):
    """What the bytes at hand say about a candidate."""

    ACCEPT = 1
    REJECT = 2
    WAIT = 3


class _FrameHeader(NamedTuple):
    """A header that could begin a frame; it may extend beyond the bytes at hand."""

    start: int
    end: int
    version: int
    sequence: int
    system: int
    component: int
    message_id: int
    known: bool


class _KnownHeader(NamedTuple):
    """What a header says of a message of known id: all but sequence and length."""

    version: int
    system: int
    component: int
    message_id: int
    crc_extra: bytes
    lengths: Container[int]


@cache
def _known_header_pattern() -> re.Pattern[bytes]:
    """Return a pattern of whole headers that belong to messages of known id.

    For MAVLink 1, where the length of each is known, it is exact; for MAVLink 2 it lets pass
    some more.
    """
    ids: dict[int, set[int]] = {}
    for number, wire in wire_formats().items():
        if number < 256:
            ids.setdefault(wire.size, set()).add(number)
            ids.setdefault(wire.full_size, set()).add(number)
    first = b"|".join(
        _byte_set({size}) + b"..." + _byte_set(numbers) for size, numbers in sorted(ids.items())
    )
    highest = _byte_set({number >> 16 for number in wire_formats()})
    pattern = rb"\xfe(?:" + first + rb")|\xfd.[\x00\x01]......" + highest
    return re.compile(pattern, re.DOTALL)


def _byte_set(values: set[int]) -> bytes:
    return b"[" + b"".join(b"\\x%02x" % value for value in sorted(values)) + b"]"


FramedItem = MavlinkFrame | Residue


def has_flipped_id(frame: bytes, formats: Mapping[int, WireFormat]) -> bool:
    """Return whether a frame of unknown id fits its checksum with one bit of the id flipped.

    It then is a damaged frame of a known message: of those of another dialect one in some
    thousands fits by chance.
    """
    start, body = (7, 10) if frame[0] == MAGIC_2 else (5, 6)
    end = body + frame[1]
    stated = frame[end] | frame[end + 1] << 8
    number = int.from_bytes(frame[start:body], "little")
    for bit in range(8 * (body - start)):
        meant = number ^ 1 << bit
        wire = formats.get(meant)
        if wire is None or frame[1] > wire.full_size:
            continue
        head = frame[1:start] + meant.to_bytes(body - start, "little")
        if crc16.mcrf4xx(head + frame[body:end] + wire.crc_extra) == stated:
            return True
    return False


class _BufferedFramer:
    """What framers have in common: bytes that wait, and their place in the stream."""

    _buffer = b""
    _offset = 0

    @property
    def pending(self) -> int:
        """Return how many bytes wait for a decision."""
        return len(self._buffer)

    @property
    def offset(self) -> int:
        """Return the stream offset of the first byte that has not come out yet."""
        return self._offset


class Framer(_BufferedFramer):
    """Split a byte stream into MAVLink 1 and 2 frames (signed ones too) and residue.

    Every byte fed comes out exactly once, in order, in a `MavlinkFrame` or a `Residue`. Frames do
    not depend on how the stream was cut into pieces. Neither do the bytes of the residue, but a
    long stretch of it may come out as several adjacent pieces, so that nothing is held back.
    """

    def __init__(self) -> None:
        self._known = wire_formats()
        self._suspect = _known_header_pattern().search
        self._buffer = b""
        self._offset = 0  # of the first byte of the buffer in the stream
        self._synchronous = True  # the buffer begins where a frame ended, or the stream began
        self._senders: set[int] = set()  # system and component of frames whose checksum fitted
        # By system, component and message as they stand in the header of such a frame.
        self._heard: dict[bytes, _KnownHeader] = {}

    def feed(self, data: bytes) -> list[FramedItem]:
        """Take the next bytes; return all that is decided so far, in the order of the stream."""
        self._buffer = self._buffer + data if self._buffer else bytes(data)
        return self._take(*self._scan(final=False))

    def flush_complete(self) -> list[FramedItem]:
        """Tell that the link pauses: bring out every frame that is whole by now.

        A frame at the end of which only the beginning has arrived stays pending, since a stalled
        connection may go on in the middle of it.
        """
        items, _ = self._scan(final=True)
        while items and isinstance(items[-1], Residue):
            items.pop()
        if not items:
            return []
        return self._take(items, items[-1].offset + len(items[-1].data) - self._offset)

    def flush(self) -> list[FramedItem]:
        """Tell that the stream ended here: bring out all that is pending."""
        items, _ = self._scan(final=True)
        taken = self._take(items, len(self._buffer))
        self._synchronous = True
        return taken

    def _take(self, items: list[FramedItem], position: int) -> list[FramedItem]:
        if items:
            self._synchronous = isinstance(items[-1], MavlinkFrame)
        self._buffer = self._buffer[position:]
        self._offset += position
        return items

    def _scan(  # noqa: C901 - the hot loop stays in one piece
        self, *, final: bool
    ) -> tuple[list[FramedItem], int]:
        """Return what is decided, and the position in the buffer up to which it is."""
        buffer, size, base = self._buffer, len(self._buffer), self._offset
        heard, accept = self._heard, _Decision.ACCEPT
        checksum, find, make = crc16.mcrf4xx, buffer.find, tuple.__new__
        suspect = self._suspect
        items: list[FramedItem] = []
        append = items.append
        position = done = 0  # of the candidate; of the first byte that has not come out
        while position < size:
            magic = buffer[position]
            named = None
            if magic == MAGIC_2 and position + 12 <= size:
                flags = buffer[position + 2]
                body = position + 10 + buffer[position + 1]
                end = body + 2 if flags == 0 else body + 15
                if flags <= SIGNED_FLAG and end <= size:
                    sequence, key = buffer[position + 4], buffer[position + 5 : position + 10]
                    named = heard.get(key) or self._named(key)
            elif magic == MAGIC_1 and position + 8 <= size:
                body = position + 6 + buffer[position + 1]
                end = body + 2
                if end <= size:
                    sequence, key = buffer[position + 2], buffer[position + 3 : position + 6]
                    named = heard.get(key) or self._named(key)
            if named is not None:
                # The common case, in line: a whole frame of known id.
                version, system, component, message_id, extra, lengths = named
                if (
                    buffer[position + 1] in lengths
                    and checksum(buffer[position + 1 : body] + extra)
                    == buffer[body] | buffer[body + 1] << 8
                ):
                    if (
                        find(b"\xfd", position + 1, end) < 0
                        and find(b"\xfe", position + 1, end) < 0
                    ) or (
                        buffer[end - 1] < MAGIC_2
                        and end == body + 2
                        and not suspect(buffer, position + 1, end)
                    ):
                        verdict = accept
                    else:
                        verdict = self._overlapped(position, end, final=final)
                else:
                    verdict = _Decision.REJECT
            else:
                verdict, head = self._judge(
                    position, position == done and (bool(items) or self._synchronous), final=final
                )
                if head is not None:
                    _, end, version, sequence, system, component, message_id, _ = head
            if verdict is accept:
                if position > done:
                    append(Residue(base + done, buffer[done:position]))
                if named is not None and key not in heard:
                    heard[key] = named
                    self._senders.add(system << 8 | component)
                append(
                    make(
                        MavlinkFrame,
                        (
                            base + position,
                            buffer[position:end],
                            version,
                            sequence,
                            system,
                            component,
                            message_id,
                            named is not None,
                        ),
                    )
                )
                position = done = end
            elif verdict is _Decision.REJECT:
                after = _NEXT_MAGIC(buffer, position + 1)
                position = after.start() if after else size
            else:
                break
        if position > done:
            append(Residue(base + done, buffer[done:position]))
        return items, position

    def _named(self, key: bytes) -> _KnownHeader | None:
        """Return what a header says by its bytes of system, component and message."""
        message_id = int.from_bytes(key[2:], "little")
        wire = self._known.get(message_id)
        if wire is None:
            return None
        version = 2 if len(key) == 5 else 1
        lengths = range(256) if version == 2 else (wire.size, wire.full_size)
        return _KnownHeader(version, key[0], key[1], message_id, wire.crc_extra, lengths)

    def _head(self, start: int) -> _FrameHeader | _Decision:
        """Read the header at a position: a head, REJECT, or WAIT where bytes are missing."""
        buffer, available = self._buffer, len(self._buffer) - start
        magic = buffer[start]
        if magic == MAGIC_2:
            if available >= 3 and buffer[start + 2] > SIGNED_FLAG:
                return _Decision.REJECT  # a form of frame that nobody here can read
            if available < 10:
                return _Decision.WAIT
            _, length, flags, _, sequence, system, component, low, high = _HEADER_2(buffer, start)
            end = start + 12 + length + (SIGNATURE_BYTES if flags else 0)
            number = low | high << 16
            return _FrameHeader(
                start, end, 2, sequence, system, component, number, number in self._known
            )
        if magic != MAGIC_1:
            return _Decision.REJECT
        if available < 6:
            return _Decision.WAIT
        _, length, sequence, system, component, number = _HEADER_1(buffer, start)
        wire = self._known.get(number)
        if wire is not None and length not in (wire.size, wire.full_size):
            return _Decision.REJECT
        return _FrameHeader(
            start, start + 8 + length, 1, sequence, system, component, number, wire is not None
        )

    def _fits(self, head: _FrameHeader) -> bool:
        buffer = self._buffer
        header = 10 if head.version == 2 else 6
        body = head.start + header + buffer[head.start + 1]
        extra = self._known[head.message_id].crc_extra
        return bool(
            crc16.mcrf4xx(buffer[head.start + 1 : body] + extra)
            == buffer[body] | buffer[body + 1] << 8
        )

    def _overlapped(self, start: int, end: int, *, final: bool) -> _Decision:
        """Judge a frame whose checksum fits, but in which others may start.

        Frames that lie wholly within are its payload (a file or a tunnel). One that ends beyond
        it contradicts it: unless a third frame follows the first, the second is the real one.
        """
        buffer = self._buffer
        signed = buffer[start] == MAGIC_2 and buffer[start + 2] == SIGNED_FLAG
        # Waiting for every header that begins near the end would delay too many frames. It is
        # needed where the checksum proves little: in the signature, which it does not cover, and
        # at the last byte, where a lost byte of the checksum may equal the next magic byte.
        unproven = end - SIGNATURE_BYTES if signed else end - 1
        match = _NEXT_MAGIC(buffer, start + 1, end)
        while match:
            inner = match.start()
            needed = 10 if buffer[inner] == MAGIC_2 else 6
            if inner + needed <= end or inner >= unproven:
                verdict = self._whole(inner, end, final=final)
                if verdict is _Decision.ACCEPT:
                    verdict = self._whole(end, end, final=final)
                    if verdict is not _Decision.ACCEPT:
                        return verdict
                elif verdict is _Decision.WAIT:
                    return verdict
            match = _NEXT_MAGIC(buffer, inner + 1, end)
        return _Decision.ACCEPT

    def _whole(self, start: int, beyond: int, *, final: bool) -> _Decision:
        """Judge whether a frame of known id starts here, ends beyond a place, and fits."""
        size = len(self._buffer)
        if start >= size:
            return _Decision.REJECT if final else _Decision.WAIT
        head = self._head(start)
        if isinstance(head, _FrameHeader):
            if not head.known or head.end <= beyond:
                return _Decision.REJECT
            if head.end <= size:
                return _Decision.ACCEPT if self._fits(head) else _Decision.REJECT
            head = _Decision.WAIT
        return _Decision.REJECT if final else head

    def _judge(
        self, position: int, synchronous: bool, *, final: bool
    ) -> tuple[_Decision, _FrameHeader | None]:
        """Judge a position that does not hold a whole frame of known id."""
        head = self._head(position)
        if head is _Decision.WAIT and final:
            head = _Decision.REJECT
        if isinstance(head, _Decision):
            return head, None
        if head.known:
            # Not whole yet: what lies inside may be its payload.
            return (_Decision.REJECT if final else _Decision.WAIT), None
        verdict = self._contains_known(head, final=final)
        if verdict is _Decision.ACCEPT:
            verdict = self._supported(head, synchronous, final=final)
        if verdict is _Decision.ACCEPT and has_flipped_id(
            self._buffer[head.start : head.end], self._known
        ):
            verdict = _Decision.REJECT
        return verdict, head

    def _contains_known(self, head: _FrameHeader, *, final: bool) -> _Decision:
        """Reject a candidate of unknown id in whose span a frame starts whose checksum fits."""
        size = len(self._buffer)
        match = _NEXT_MAGIC(self._buffer, head.start + 1, head.end)
        waiting = False
        while match:
            inner = self._head(match.start())
            if inner is _Decision.WAIT:
                waiting = True
            elif isinstance(inner, _FrameHeader) and inner.known:
                if inner.end > size:
                    waiting = True
                elif self._fits(inner):
                    return _Decision.REJECT
            match = _NEXT_MAGIC(self._buffer, match.start() + 1, head.end)
        if head.end > size:
            return _Decision.REJECT if final else _Decision.WAIT
        return _Decision.WAIT if waiting and not final else _Decision.ACCEPT

    def _supported(self, head: _FrameHeader, synchronous: bool, *, final: bool) -> _Decision:
        """Judge a whole candidate of unknown id by what surrounds it."""
        if head.end >= len(self._buffer):
            return _Decision.ACCEPT if final else _Decision.WAIT
        follower = self._head(head.end)
        if follower is _Decision.WAIT:
            return _Decision.ACCEPT if final else _Decision.WAIT
        if isinstance(follower, _FrameHeader):
            return _Decision.ACCEPT
        # Followed by garbage: believed where a frame was due, from a sender known by frames with
        # checksums, unless the sender's next frame seems to start within (a torn frame).
        if not synchronous or head.system << 8 | head.component not in self._senders:
            return _Decision.REJECT
        match = _NEXT_MAGIC(self._buffer, head.start + 1, head.end)
        while match:
            inner = self._head(match.start())
            if (
                isinstance(inner, _FrameHeader)
                and (inner.system, inner.component) == (head.system, head.component)
                and 0 < (inner.sequence - head.sequence) % 256 < 4
            ):
                return _Decision.REJECT
            match = _NEXT_MAGIC(self._buffer, match.start() + 1, head.end)
        return _Decision.ACCEPT


class TextLine(NamedTuple):
    """One whole text line."""

    offset: int  # Position of its first byte in the stream.
    data: bytes  # The line without its end; valid UTF-8.
    end: bytes  # What ended it: CR, LF, CR LF, or nothing at the end of the stream.


class LineFramer(_BufferedFramer):
    r"""Split a byte stream into text lines and residue.

    A line ends with LF, CR or CR LF. Lines that are not UTF-8, hold a NUL, or have more than
    `longest` bytes without their end are residue, whole. Every byte fed comes out exactly once,
    in order.
    """

    def __init__(self, longest: int = 4096) -> None:
        self._longest = longest
        self._buffer = b""
        self._offset = 0
        self._overlong = False  # the line at hand has been cut already

    def feed(self, data: bytes) -> list[TextLine | Residue]:
        self._buffer += data
        return self._split(final=False)

    def flush_complete(self) -> list[TextLine | Residue]:
        """Tell that the link pauses: a CR that might have been followed by LF ends its line."""
        return self._split(final=True)

    def flush(self) -> list[TextLine | Residue]:
        """Tell that the stream ended: an unfinished line comes out as it is."""
        items = self._split(final=True)
        if size := len(self._buffer):
            items.append(self._item(0, size, size))
            self._offset += size
            self._buffer = b""
        self._overlong = False
        return items

    def _split(self, *, final: bool) -> list[TextLine | Residue]:
        items: list[TextLine | Residue] = []
        buffer, start = self._buffer, 0
        held = len(buffer)
        for match in _LINE_END(buffer):
            if not final and match.end() == len(buffer) and match.group() == b"\r":
                held -= 1  # perhaps the first half of CR LF
                break
            start = self._cut(items, start, match.start())
            items.append(self._item(start, match.start(), match.end()))
            self._overlong = False
            start = match.end()
        start = self._cut(items, start, held)
        self._buffer = buffer[start:]
        self._offset += start
        return items

    def _cut(self, items: list[TextLine | Residue], start: int, stop: int) -> int:
        """Bring out the blocks of an over-long line, `longest` bytes each."""
        while stop - start > self._longest:
            block = self._buffer[start : start + self._longest]
            items.append(Residue(self._offset + start, block))
            start += self._longest
            self._overlong = True
        return start

    def _item(self, start: int, stop: int, end: int) -> TextLine | Residue:
        data, offset = self._buffer[start:stop], self._offset + start
        if self._overlong or b"\0" in data or not _is_utf8(data):
            return Residue(offset, self._buffer[start:end])
        return TextLine(offset, data, self._buffer[stop:end])


_LINE_END: Final = re.compile(rb"\r\n|\r|\n").finditer


def _is_utf8(data: bytes) -> bool:
    try:
        codecs.utf_8_decode(data, "strict", True)
    except UnicodeDecodeError:
        return False
    return True

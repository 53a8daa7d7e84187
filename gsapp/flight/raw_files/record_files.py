"""The records of each raw file: finding them, stepping over damage, finding the last whole one."""

from __future__ import annotations

import re
from collections import deque
from dataclasses import dataclass
from pathlib import Path
from stat import S_ISDIR
from struct import Struct
from typing import Final, Literal, NamedTuple

from fastcrc import crc16

from gsapp.decoding.dialect import WireFormat, wire_formats
from gsapp.decoding.framing import (
    MAGIC_1,
    MAGIC_2,
    MAX_FRAME_LENGTH,
    SIGNATURE_BYTES,
    has_flipped_id,
)
from gsapp.decoding.sender_filter import UNKNOWN_ORIGIN, FrameOrigin
from gsapp.flight.file_names import FRAMES_FILE, LINES_FILE, RESIDUE_FILE, SENDERS_FILE
from gsapp.foundation import FlightError


class RawRecord(NamedTuple):
    """One record of a raw file."""

    stamp_us: int
    """Host time of arrival, microseconds since 1970 (UTC)."""
    kind: Literal["frame", "line", "residue"]
    """From ``raw.tlog``, ``raw.txt`` or ``residue.bin``."""
    data: bytes
    """A whole MAVLink frame, a text line without its end, or stray bytes."""
    origin: FrameOrigin = UNKNOWN_ORIGIN  # Of a frame, as far as it is known.


STAMP_STRUCT: Final = Struct(">Q")
RESIDUE_HEADER: Final = Struct(">QQI")
MAX_RESIDUE_BYTES: Final = 65536
# Year 2100: a stamp beyond it is damage, not time.
MAX_STAMP: Final = 4_102_444_800_000_000

RecordKind = Literal["frame", "line", "residue"]

_LONGEST_LINE: Final = 65536
_TAIL_BYTES: Final = 65536
_READ_BYTES: Final = 1 << 20
_MAGIC: Final = re.compile(rb"[\xfd\xfe]")
_SHORTEST_RECORD: Final = 16  # a MAVLink 1 frame without payload


@dataclass(slots=True)
class RawDamage:
    """What could not be read of one raw file."""

    name: str
    bytes: int = 0
    """Bytes stepped over."""
    location_count: int = 0
    """Number of stretches they lie in."""
    stamps: int = 0
    """Records whose stamp was impossible and was replaced by the one before."""
    torn: int = 0
    """Bytes of an incomplete record at the end, so far."""

    def __bool__(self) -> bool:
        return bool(self.bytes or self.stamps or self.torn)

    def describe(self) -> str:
        """Return what was lost, in words; empty where nothing was."""
        parts = []
        if self.bytes:
            places = "1 place" if self.location_count == 1 else f"{self.location_count} places"
            parts.append(f"{self.bytes} damaged bytes in {places} were skipped")
        if self.stamps:
            stamps = (
                "1 impossible stamp was"
                if self.stamps == 1
                else (f"{self.stamps} impossible stamps were")
            )
            parts.append(f"{stamps} replaced by the previous")
        if self.torn:
            parts.append(f"the last record is incomplete ({self.torn} bytes)")
        return f"{self.name}: {', '.join(parts)}." if parts else ""


class RawFile:
    """One raw file, read from the front; `parse` of the subclass knows its records."""

    kind: RecordKind

    def __init__(self, path: Path) -> None:
        self.path = path
        self.position = 0
        self.damage = RawDamage(path.name)
        self.records: deque[RawRecord] = deque()
        self.last_read_stamp = -1  # stamp of the last record read
        self.exhausted = True  # all of what was there has been read
        self._in_damage = False

    def size(self) -> int:
        """Return the size; 0 where the file is not there yet."""
        try:
            status = self.path.stat()
        except FileNotFoundError:
            return 0
        except OSError as error:
            raise _unreadable_error(self.path, error) from error
        # A folder has size 0 on Windows, and would pass for a file that nothing was written to.
        if S_ISDIR(status.st_mode):
            raise _unreadable_error(self.path, IsADirectoryError("it is a folder"))
        return status.st_size

    def read(self, size: int, *, blocks: int | None = None) -> None:
        """Read new whole records up to a size of the file, or only so many blocks of it."""
        self.exhausted = True
        while self.position < size:
            if blocks is not None:
                if blocks == 0:
                    self.exhausted = False
                    break
                blocks -= 1
            wanted = size - self.position
            data = self._bytes(min(wanted, _READ_BYTES))
            whole = len(data) >= wanted or not data
            used = self.parse(data, whole=whole)
            if not whole and not used:
                self._skip(used := len(data))  # no record is that long
            self.position += used
            if whole:
                break
        # A file that has disappeared is smaller than what was read of it.
        self.damage.torn = max(size - self.position, 0) if self.exhausted else 0

    def remaining_bytes(self, size: int) -> bytes:
        return self._bytes(size - self.position)

    def _bytes(self, count: int) -> bytes:
        try:
            with self.path.open("rb") as stream:
                stream.seek(self.position)
                return stream.read(count)
        except FileNotFoundError:
            return b""
        except OSError as error:
            raise _unreadable_error(self.path, error) from error

    def seek_end(self, size: int) -> None:
        """Go to a record not far from the end, where the format lets one be found."""

    def torn_bytes(self, rest: bytes) -> int:
        """Return the length of `remaining_bytes` if it is the beginning of a record, else 0."""
        raise NotImplementedError

    def parse(self, data: bytes, *, whole: bool) -> int:
        """Take the records of a stretch; return how many bytes were used.

        `whole` tells that the stretch reaches to the end of what is there.
        """
        raise NotImplementedError

    def _add(self, stamp: int, data: bytes) -> None:
        if stamp > MAX_STAMP:
            self.damage.stamps += 1
            stamp = max(self.last_read_stamp, 0)
        self.last_read_stamp = stamp
        self._in_damage = False
        self.records.append(RawRecord(stamp, self.kind, data))

    def _skip(self, count: int) -> None:
        if count:
            self.damage.bytes += count
            self.damage.location_count += not self._in_damage
            self._in_damage = True


def _frame_span(data: bytes, start: int) -> tuple[int, int, int] | None:
    """Return message id, end of the payload and end of the frame whose header stands here.

    None where there is none. A header that is cut off ends beyond the data.
    """
    magic = data[start]
    if magic == MAGIC_2:
        if start + 10 > len(data):
            return -1, len(data) + 1, len(data) + 1
        if data[start + 2] > 1:
            return None
        body = start + 10 + data[start + 1]
        number = data[start + 7] | data[start + 8] << 8 | data[start + 9] << 16
        return number, body, body + 2 + (SIGNATURE_BYTES if data[start + 2] else 0)
    if magic == MAGIC_1:
        if start + 6 > len(data):
            return -1, len(data) + 1, len(data) + 1
        body = start + 6 + data[start + 1]
        return data[start + 5], body, body + 2
    return None


def _is_valid_frame(data: bytes, start: int, wire: WireFormat | None, body: int, end: int) -> bool:
    """Return whether the checksum fits, or where it cannot be checked, a frame or nothing follows.

    Of a follower that has just begun to come nobody knows yet what it is.
    """
    if wire is None:
        after = data[end : end + 9]
        followed = not after or (len(after) > 8 and after[8] in (MAGIC_1, MAGIC_2))
        return followed and not has_flipped_id(data[start:end], wire_formats())
    checksum: int = crc16.mcrf4xx(data[start + 1 : body] + wire.crc_extra)
    return checksum == data[body] | data[body + 1] << 8


class FrameFile(RawFile):
    """``raw.tlog``: stamped MAVLink frames, whose checksums tell where a good one stands."""

    kind: RecordKind = "frame"

    def seek_end(self, size: int) -> None:
        if size > _TAIL_BYTES:
            self.position = size - _TAIL_BYTES
            self.position += max(0, self._resume(self.remaining_bytes(size), 0))

    def torn_bytes(self, rest: bytes) -> int:
        if len(rest) <= 8:
            return len(rest)
        span = _frame_span(rest, 8)
        if span is None:
            return 0
        begun = len(rest) - span[2]  # of the next one, where a frame that cannot be checked waits
        return len(rest) if begun < 0 else begun if begun <= 8 else 0

    def parse(self, data: bytes, *, whole: bool) -> int:
        size, position = len(data), 0
        formats = wire_formats()
        while position + _SHORTEST_RECORD <= size:
            start = position + 8
            span = _frame_span(data, start)
            if span is not None:
                number, body, end = span
                if not whole and end + 8 >= size:
                    break
                if end <= size and _is_valid_frame(data, start, formats.get(number), body, end):
                    self._add(STAMP_STRUCT.unpack_from(data, position)[0], data[start:end])
                    position = end
                    continue
            found = self._resume(data, position + 1)
            if found < 0:
                if whole:
                    break  # it may become whole yet
                found = max(position + 1, size - MAX_FRAME_LENGTH - 8)
            self._skip(found - position)
            position = found
        return position

    def _resume(self, data: bytes, position: int) -> int:
        """Return where the next record of known id starts whose checksum fits, or -1."""
        match = _MAGIC.search(data, position + 8)
        while match:
            start = match.start()
            span = _frame_span(data, start)
            if span is not None:
                number, body, end = span
                wire = wire_formats().get(number)
                if (
                    wire is not None
                    and end <= len(data)
                    and _is_valid_frame(data, start, wire, body, end)
                ):
                    return start - 8
            match = _MAGIC.search(data, start + 1)
        return -1


class LineFile(RawFile):
    """``raw.txt``: stamped lines of text."""

    kind: RecordKind = "line"

    def seek_end(self, size: int) -> None:
        if size > _TAIL_BYTES:
            self.position = size - _TAIL_BYTES
            self.position += self.remaining_bytes(size).find(b"\n") + 1

    def torn_bytes(self, rest: bytes) -> int:
        return len(rest)

    def parse(self, data: bytes, *, whole: bool) -> int:  # noqa: ARG002 - same for all files
        position = 0
        while (end := data.find(b"\n", position)) >= 0:
            stamp, tab, line = data[position:end].partition(b"\t")
            if tab and stamp.isdigit() and len(stamp) <= 20:
                self._add(int(stamp), line)
            else:
                self._skip(end + 1 - position)
            position = end + 1
        if not position and len(data) > _LONGEST_LINE:
            self._skip(len(data))
            return len(data)
        return position


class SendersFile(LineFile):
    """``senders.txt``: from which stamp on frames come from whom."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self._origin = UNKNOWN_ORIGIN

    def label(self, records: list[RawRecord]) -> list[RawRecord]:
        """Return records, the next ones in the order of their stamps, frames with their origin."""
        if not records:
            return records
        last, size = records[-1].stamp_us, self.size()
        # No more than is needed: where senders take turns, there is an entry for every frame.
        while self.last_read_stamp <= last:
            self.read(size, blocks=1)
            if self.exhausted:
                break
        if not self.records and self._origin == UNKNOWN_ORIGIN:
            return records
        labeled = []
        for record in records:
            while self.records and self.records[0].stamp_us <= record.stamp_us:
                self._origin = FrameOrigin.parse(self.records.popleft().data)
            is_frame = record.kind == FrameFile.kind
            labeled.append(record._replace(origin=self._origin) if is_frame else record)
        return labeled


class ResidueFile(RawFile):
    """``residue.bin``: stamped pieces that belong to no frame; only their heads can be judged."""

    kind: RecordKind = "residue"

    def torn_bytes(self, rest: bytes) -> int:
        if len(rest) < RESIDUE_HEADER.size:
            return len(rest)
        stamp, _, length = RESIDUE_HEADER.unpack_from(rest)
        whole = RESIDUE_HEADER.size + length
        return len(rest) if self._plausible(stamp, length) and len(rest) < whole else 0

    def parse(self, data: bytes, *, whole: bool) -> int:
        position, size = 0, len(data)
        while position + RESIDUE_HEADER.size <= size:
            stamp, _, length = RESIDUE_HEADER.unpack_from(data, position)
            if not self._plausible(stamp, length):
                found = self._resume(data, position + 1)
                if found < 0:
                    if whole:
                        break
                    found = max(position + 1, size - RESIDUE_HEADER.size)
                self._skip(found - position)
                position = found
                continue
            start = position + RESIDUE_HEADER.size
            if start + length > size:
                break
            self._add(stamp, data[start : start + length])
            position = start + length
        return position

    def _plausible(self, stamp: int, length: int) -> bool:
        return 0 < length <= MAX_RESIDUE_BYTES and stamp <= MAX_STAMP

    def _resume(self, data: bytes, position: int) -> int:
        """Return where the next piece seems to start: two plausible heads in a row, or -1."""
        while position + RESIDUE_HEADER.size <= len(data):
            stamp, _, length = RESIDUE_HEADER.unpack_from(data, position)
            near = abs(stamp - self.last_read_stamp) < 86_400_000_000 or self.last_read_stamp < 0
            if near and self._plausible(stamp, length):
                after = position + RESIDUE_HEADER.size + length
                if after == len(data):
                    return position
                if after + RESIDUE_HEADER.size <= len(data):
                    follower, _, following = RESIDUE_HEADER.unpack_from(data, after)
                    if self._plausible(follower, following) and follower >= stamp:
                        return position
            position += 1
        return -1


def _unreadable_error(path: Path, error: OSError) -> FlightError:
    return FlightError(
        f"{path} cannot be read ({error.strerror or error}); check its permissions and the disk"
    )


class FileEnd(NamedTuple):
    """The end of a raw file."""

    size: int
    """Bytes without the incomplete record at the end."""
    torn: int
    """Bytes of that record. Damage that does not look like the beginning of a record is none."""
    last_stamp: int
    """Stamp of the last whole record; 0 where there is none."""


def find_file_end(path: Path) -> FileEnd:
    """Find where the last whole record of a raw file ends; a missing file is an empty one."""
    try:
        size = path.stat().st_size
    except FileNotFoundError:
        return FileEnd(0, 0, 0)
    file = _FILES[path.name](path)
    file.seek_end(size)
    while True:
        file.read(size, blocks=1)
        file.records.clear()
        if file.exhausted:
            break
    torn = file.torn_bytes(file.remaining_bytes(size))
    return FileEnd(size - torn, torn, max(file.last_read_stamp, 0))


_FILES: Final[dict[str, type[RawFile]]] = {
    FRAMES_FILE: FrameFile,
    LINES_FILE: LineFile,
    RESIDUE_FILE: ResidueFile,
    SENDERS_FILE: SendersFile,
}

"""The raw files of a flight: written by the recorder, tailed by windows, read by everyone.

========================  ==================================================================
``raw.tlog``              per frame: 8-byte big-endian host microseconds, the frame
``raw.txt``               per line: microseconds, tab, the line, line feed
``residue.bin``           per piece: 8-byte big-endian microseconds, 8-byte big-endian offset
                          in the stream, 4-byte big-endian length, the bytes
========================  ==================================================================

All three only ever grow. A reader meets a torn record at the end as "not there yet" and damage in
the middle as a gap that it reports and steps over.

What arrives at one time is written as one batch under one stamp, the residue first and the frames
last, and stamps rise from batch to batch. Readers take them in the opposite order. So a tail of a
growing folder yields the very sequence that a reader of the finished one gets.
"""

from __future__ import annotations

import errno
import os
import re
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from heapq import merge
from pathlib import Path
from struct import Struct
from typing import Final, Literal, NamedTuple

from fastcrc import crc16

from gsapp.decoding.dialect import WireFormat, wire_formats
from gsapp.decoding.frames import Frame, Residue
from gsapp.decoding.framing import LONGEST_FRAME, MAGIC_1, MAGIC_2, SIGNATURE_BYTES, Line
from gsapp.flight.records import RawRecord
from gsapp.foundation import FlightError

FRAMES_FILE: Final = "raw.tlog"
LINES_FILE: Final = "raw.txt"
RESIDUE_FILE: Final = "residue.bin"
RAW_FILES: Final = (RESIDUE_FILE, LINES_FILE, FRAMES_FILE)

_STAMP: Final = Struct(">Q")
_RESIDUE_HEAD: Final = Struct(">QQI")
_LONGEST_PIECE: Final = 65536
_LONGEST_LINE: Final = 65536
# Year 2100: a stamp beyond it is damage, not time.
_LAST_STAMP: Final = 4_102_444_800_000_000
_TAIL_BYTES: Final = 65536
_READ_BYTES: Final = 1 << 20
_MAGIC: Final = re.compile(rb"[\xfd\xfe]")
_SHORTEST_RECORD: Final = 16  # a MAVLink 1 frame without payload


@dataclass(slots=True)
class RawDamage:
    """What could not be read of one raw file.

    Attributes
    ----------
    name : str
        The file.
    bytes : int
        Bytes stepped over.
    places : int
        Number of stretches they lie in.
    stamps : int
        Records whose stamp was impossible and was replaced by the one before.
    torn : int
        Bytes of an incomplete record at the end, so far.
    """

    name: str
    bytes: int = 0
    places: int = 0
    stamps: int = 0
    torn: int = 0

    def __bool__(self) -> bool:
        """Tell whether anything was lost."""
        return bool(self.bytes or self.stamps or self.torn)

    def sentence(self) -> str:
        """Return what was lost, in words; empty where nothing was."""
        parts = []
        if self.bytes:
            places = "1 place" if self.places == 1 else f"{self.places} places"
            parts.append(f"{self.bytes} damaged bytes in {places} were stepped over")
        if self.stamps:
            parts.append(f"{self.stamps} impossible stamps were replaced by the one before")
        if self.torn:
            parts.append(f"the last record is incomplete ({self.torn} bytes)")
        return f"{self.name}: {', '.join(parts)}." if parts else ""


class RawPosition(NamedTuple):
    """Bytes read so far of ``raw.tlog``, ``raw.txt`` and ``residue.bin``."""

    frames: int
    lines: int
    residue: int


Kind = Literal["frame", "line", "residue"]


class _File:
    """One raw file, read from the front; `parse` of the subclass knows its records."""

    kind: Kind

    def __init__(self, path: Path) -> None:
        self.path = path
        self.position = 0
        self.damage = RawDamage(path.name)
        self.records: deque[RawRecord] = deque()
        self.horizon = -1  # stamp of the last record read
        self.exhausted = True  # all of what was there has been read
        self._in_damage = False

    def size(self) -> int:
        """Return the size; 0 where the file is not there yet."""
        try:
            return self.path.stat().st_size
        except FileNotFoundError:
            return 0
        except OSError as error:
            raise _unreadable(self.path, error) from error

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
        self.damage.torn = size - self.position if self.exhausted else 0

    def rest(self, size: int) -> bytes:
        """Return the bytes after the last whole record."""
        return self._bytes(size - self.position)

    def _bytes(self, count: int) -> bytes:
        try:
            with self.path.open("rb") as stream:
                stream.seek(self.position)
                return stream.read(count)
        except FileNotFoundError:
            return b""
        except OSError as error:
            raise _unreadable(self.path, error) from error

    def seek_end(self, size: int) -> None:
        """Go to a record not far from the end, where the format lets one be found."""

    def torn_bytes(self, rest: bytes) -> int:
        """Return the length of `rest` if it is the beginning of a record, else 0."""
        raise NotImplementedError

    def parse(self, data: bytes, *, whole: bool) -> int:
        """Take the records of a stretch; return how many bytes were used.

        `whole` tells that the stretch reaches to the end of what is there.
        """
        raise NotImplementedError

    def _add(self, stamp: int, data: bytes) -> None:
        if stamp > _LAST_STAMP:
            self.damage.stamps += 1
            stamp = max(self.horizon, 0)
        self.horizon = stamp
        self._in_damage = False
        self.records.append(RawRecord(stamp, self.kind, data))

    def _skip(self, count: int) -> None:
        if count:
            self.damage.bytes += count
            self.damage.places += not self._in_damage
            self._in_damage = True


def _wire_format(number: int) -> WireFormat | None:
    return wire_formats().get(number)


def _span(data: bytes, start: int) -> tuple[int, int, int] | None:
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


class _Frames(_File):
    kind: Kind = "frame"

    def seek_end(self, size: int) -> None:
        if size > _TAIL_BYTES:
            self.position = size - _TAIL_BYTES
            self.position += max(0, self._resume(self.rest(size), 0))

    def torn_bytes(self, rest: bytes) -> int:
        if len(rest) <= 8:
            return len(rest)
        span = _span(rest, 8)
        return len(rest) if span is not None and span[2] > len(rest) else 0

    def parse(self, data: bytes, *, whole: bool) -> int:
        size, position = len(data), 0
        while position + _SHORTEST_RECORD <= size:
            span = _span(data, position + 8)
            if span is not None:
                number, body, end = span
                if not whole and end + 8 >= size:
                    break
                if end <= size and self._good(data, position + 8, number, body, end):
                    self._add(_STAMP.unpack_from(data, position)[0], data[position + 8 : end])
                    position = end
                    continue
            found = self._resume(data, position + 1)
            if found < 0:
                if whole:
                    break  # it may become whole yet
                found = max(position + 1, size - LONGEST_FRAME - 8)
            self._skip(found - position)
            position = found
        return position

    @staticmethod
    def _good(data: bytes, start: int, number: int, body: int, end: int) -> bool:
        """Return whether the checksum fits, or where it cannot be checked, a frame follows."""
        wire = _wire_format(number)
        if wire is None:
            return end + 8 >= len(data) or data[end + 8] in (MAGIC_1, MAGIC_2)
        return bool(
            crc16.mcrf4xx(data[start + 1 : body] + wire.crc_extra)
            == data[body] | data[body + 1] << 8
        )

    def _resume(self, data: bytes, position: int) -> int:
        """Return where the next record of known id starts whose checksum fits, or -1."""
        match = _MAGIC.search(data, position + 8)
        while match:
            start = match.start()
            span = _span(data, start)
            if span is not None:
                number, body, end = span
                known = _wire_format(number) is not None
                if known and end <= len(data) and self._good(data, start, number, body, end):
                    return start - 8
            match = _MAGIC.search(data, start + 1)
        return -1


class _Lines(_File):
    kind: Kind = "line"

    def seek_end(self, size: int) -> None:
        if size > _TAIL_BYTES:
            self.position = size - _TAIL_BYTES
            self.position += self.rest(size).find(b"\n") + 1

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


class _Pieces(_File):
    kind: Kind = "residue"

    def torn_bytes(self, rest: bytes) -> int:
        if len(rest) < _RESIDUE_HEAD.size:
            return len(rest)
        stamp, _, length = _RESIDUE_HEAD.unpack_from(rest)
        whole = _RESIDUE_HEAD.size + length
        return len(rest) if self._plausible(stamp, length) and len(rest) < whole else 0

    def parse(self, data: bytes, *, whole: bool) -> int:
        position, size = 0, len(data)
        while position + _RESIDUE_HEAD.size <= size:
            stamp, _, length = _RESIDUE_HEAD.unpack_from(data, position)
            if not self._plausible(stamp, length):
                found = self._resume(data, position + 1)
                if found < 0:
                    if whole:
                        break
                    found = max(position + 1, size - _RESIDUE_HEAD.size)
                self._skip(found - position)
                position = found
                continue
            start = position + _RESIDUE_HEAD.size
            if start + length > size:
                break
            self._add(stamp, data[start : start + length])
            position = start + length
        return position

    def _plausible(self, stamp: int, length: int) -> bool:
        return 0 < length <= _LONGEST_PIECE and stamp <= _LAST_STAMP

    def _resume(self, data: bytes, position: int) -> int:
        """Return where the next piece seems to start: two plausible heads in a row, or -1."""
        while position + _RESIDUE_HEAD.size <= len(data):
            stamp, _, length = _RESIDUE_HEAD.unpack_from(data, position)
            near = abs(stamp - self.horizon) < 86_400_000_000 or self.horizon < 0
            if near and self._plausible(stamp, length):
                after = position + _RESIDUE_HEAD.size + length
                if after == len(data):
                    return position
                if after + _RESIDUE_HEAD.size <= len(data):
                    follower, _, following = _RESIDUE_HEAD.unpack_from(data, after)
                    if self._plausible(follower, following) and follower >= stamp:
                        return position
            position += 1
        return -1


class RawTail:
    """Read the raw files of a flight folder, finished or still growing.

    Parameters
    ----------
    folder : Path
        The flight folder. It and its files may appear later.

    Notes
    -----
    The sequence of records depends on the files alone, not on when they are polled.
    """

    def __init__(self, folder: Path | str) -> None:
        self.folder = Path(folder)
        self._frames = _Frames(self.folder / FRAMES_FILE)
        self._lines = _Lines(self.folder / LINES_FILE)
        self._pieces = _Pieces(self.folder / RESIDUE_FILE)

    @property
    def position(self) -> RawPosition:
        """Return how many bytes of each file have been read."""
        return RawPosition(self._frames.position, self._lines.position, self._pieces.position)

    @property
    def lost(self) -> tuple[RawDamage, ...]:
        """Return what could not be read, per file; empty when all was good."""
        return tuple(file.damage for file in self._files if file.damage)

    @property
    def _files(self) -> tuple[_File, _File, _File]:
        return (self._pieces, self._lines, self._frames)

    def poll(self, limit: int | None = None) -> list[RawRecord]:
        """Return the whole records that came since the last poll, merged by stamp.

        Parameters
        ----------
        limit : int, optional
            How many at most; the others come with the next poll.

        Raises
        ------
        FlightError
            If a file is there but cannot be read.
        """
        pieces, lines, frames = self._files
        while True:
            sizes = []
            for file in (frames, lines, pieces):
                sizes.append(file.size())
                if limit is None:
                    file.read(sizes[-1])
                elif len(file.records) < limit:
                    file.read(sizes[-1], blocks=1)
            bound = self._bound(
                frames_grew=frames.size() != sizes[0], lines_grew=lines.size() != sizes[1]
            )
            merged = self._merged(limit, bound)
            if merged or all(file.exhausted for file in self._files):
                return merged

    def _bound(self, *, frames_grew: bool, lines_grew: bool) -> dict[Kind, int]:
        """Return up to which stamp the records of each kind are complete.

        What was written to one file while a later one was read may precede records of the
        later one; these are left for the next time.
        """
        _, lines, frames = self._files
        unread = min(
            (file.horizon for file in self._files if not file.exhausted), default=_LAST_STAMP
        )
        before_frames = min(unread, frames.horizon) if frames_grew else unread
        before_lines = min(before_frames, lines.horizon) if lines_grew else before_frames
        return {"frame": unread, "line": before_frames, "residue": before_lines}

    def _merged(self, limit: int | None, bound: dict[Kind, int]) -> list[RawRecord]:
        ready = []
        for file in self._files:
            highest, records = bound[file.kind], file.records
            taken: list[RawRecord] = []
            while records and records[0].stamp_us <= highest and len(taken) != limit:
                taken.append(records.popleft())
            ready.append(taken)
        if not ready[0] and not ready[1]:
            return ready[2]
        merged = list(merge(*ready, key=lambda record: record.stamp_us))
        if limit is not None and len(merged) > limit:
            for record in reversed(merged[limit:]):
                self._file_of(record.kind).records.appendleft(record)
            merged = merged[:limit]
        return merged

    def _file_of(self, kind: Kind) -> _File:
        return next(file for file in self._files if file.kind == kind)


def _unreadable(path: Path, error: OSError) -> FlightError:
    return FlightError(
        f"{path} cannot be read ({error.strerror or error}); check its permissions and the disk"
    )


def read_tlog(path: Path | str, damage: RawDamage | None = None) -> Iterator[RawRecord]:
    """Read any ``.tlog``: MAVLink 1, 2 or both, from whichever ground station.

    Parameters
    ----------
    path : Path or str
        The file.
    damage : RawDamage, optional
        Filled with what had to be stepped over.

    Yields
    ------
    RawRecord
        The frames in the order of the file.

    Raises
    ------
    FlightError
        If the file cannot be read.
    """
    file = _Frames(Path(path))
    if damage is not None:
        damage.name = file.damage.name
        file.damage = damage
    if not file.path.is_file():
        raise FlightError(f"{path} cannot be read; there is no such file")
    size = file.size()
    while True:
        file.read(size, blocks=1)
        while file.records:
            yield file.records.popleft()
        if file.exhausted:
            return


@dataclass(slots=True)
class _Pending:
    """Bytes that the disk has not taken yet."""

    name: str
    data: bytes
    records: int
    begun: bool = False  # a part is on disk already: the rest must follow


@dataclass(slots=True)
class WriterState:
    """What a writer has done; attributes are totals since it was made.

    Attributes
    ----------
    frames, lines, residue_bytes, written_bytes : int
        What was handed over, and how many bytes the disk has taken.
    waiting_bytes : int
        Bytes in memory, since the disk takes no more.
    dropped_records, dropped_bytes : int
        What memory could not hold either.
    error : str
        Why the disk takes no more, in words; empty when it does.
    notes : list of str
        What was found and mended in files that were there already.
    """

    frames: int = 0
    lines: int = 0
    residue_bytes: int = 0
    written_bytes: int = 0
    waiting_bytes: int = 0
    dropped_records: int = 0
    dropped_bytes: int = 0
    error: str = ""
    notes: list[str] = field(default_factory=list)


class RawWriter:
    """Append to the raw files of a flight folder.

    Files that are there already are continued; an incomplete record at their end, which a power
    cut or a killed recorder left, is cut off first.

    Every batch is handed to the operating system at once. When the disk refuses, the newest
    batches are kept in memory, and written in order as soon as there is room again.

    Parameters
    ----------
    folder : Path
        The flight folder; made if missing.
    memory_bytes : int
        How much to keep in memory while the disk refuses.
    write : callable
        ``os.write`` or its stand-in.

    Attributes
    ----------
    state : WriterState
        What has been done.
    last_stamp : int
        Stamp of the last record that was there already; 0 for a new flight.

    Raises
    ------
    FlightError
        If the folder cannot be made or its files cannot be mended.
    """

    def __init__(
        self,
        folder: Path | str,
        *,
        memory_bytes: int = 16 << 20,
        write: Callable[[int, bytes], int] = os.write,
    ) -> None:
        self.folder = Path(folder)
        self.state = WriterState()
        self.last_stamp = 0
        self._memory_bytes = memory_bytes
        self._write = write
        self._descriptors: dict[str, int] = {}
        self._unsynced = dict.fromkeys(RAW_FILES, False)
        self._waiting: deque[_Pending] = deque()
        self._closing = threading.Lock()
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            for name in RAW_FILES:
                end = find_end(self.folder / name)
                self.last_stamp = max(self.last_stamp, end.last_stamp)
                if end.torn:
                    os.truncate(self.folder / name, end.size)
                    self.state.notes.append(
                        f"{name} ended in an incomplete record of {end.torn} bytes, "
                        "which was cut off."
                    )
        except OSError as error:
            raise FlightError(
                f"{self.folder} cannot be written to ({error.strerror or error}); "
                "choose another folder or correct its permissions"
            ) from error

    def append(self, stamp_us: int, items: Sequence[Frame | Residue | Line]) -> None:
        """Write what came at one time.

        Parameters
        ----------
        stamp_us : int
            Host microseconds, higher than that of the batch before.
        items : sequence of Frame, Residue or Line
            As they came out of a framer.
        """
        stamp = _STAMP.pack(stamp_us)
        frames: list[bytes] = []
        lines: list[bytes] = []
        pieces: list[bytes] = []
        for item in items:
            if isinstance(item, Frame):
                frames += (stamp, item.data)
            elif isinstance(item, Line):
                lines.append(b"%d\t%b\n" % (stamp_us, item.data))
            else:
                for start in range(0, len(item.data), _LONGEST_PIECE):
                    part = item.data[start : start + _LONGEST_PIECE]
                    pieces += (_RESIDUE_HEAD.pack(stamp_us, item.offset + start, len(part)), part)
                    self.state.residue_bytes += len(part)
        self.state.frames += len(frames) // 2
        self.state.lines += len(lines)
        if pieces:
            self._put(_Pending(RESIDUE_FILE, b"".join(pieces), len(pieces) // 2))
        if lines:
            self._put(_Pending(LINES_FILE, b"".join(lines), len(lines)))
        if frames:
            self._put(_Pending(FRAMES_FILE, b"".join(frames), len(frames) // 2))

    def retry(self) -> bool:
        """Try again to write what waits in memory; return whether nothing waits any more."""
        while self._waiting:
            if not self._deliver(self._waiting[0]):
                return False
            self._waiting.popleft()
        self.state.error = ""
        return True

    def sync(self) -> None:
        """Flush to the disk itself; may be called from another thread."""
        with self._closing:
            for name, descriptor in list(self._descriptors.items()):
                if not self._unsynced[name]:
                    continue
                self._unsynced[name] = False
                try:
                    os.fsync(descriptor)
                except OSError as error:
                    self._unsynced[name] = True
                    self.state.error = _refusal(self.folder / name, error)

    def close(self) -> None:
        """Write what waits, flush and close. What the disk does not take now is lost."""
        if not self.retry():
            for pending in self._waiting:
                self.state.dropped_bytes += len(pending.data)
                self.state.dropped_records += pending.records
            self._waiting.clear()
            self.state.waiting_bytes = 0
        self.sync()
        with self._closing:
            for descriptor in self._descriptors.values():
                os.close(descriptor)
            self._descriptors.clear()

    def _put(self, pending: _Pending) -> None:
        if self._waiting or not self._deliver(pending):
            self._waiting.append(pending)
            self.state.waiting_bytes += len(pending.data)
            self._make_room()

    def _make_room(self) -> None:
        """Drop the oldest that waits, but never the rest of what is half written."""
        while self.state.waiting_bytes > self._memory_bytes and len(self._waiting) > 1:
            first = self._waiting.popleft()
            if first.begun:
                second = self._waiting.popleft()
                self._waiting.appendleft(first)
                first = second
            self.state.waiting_bytes -= len(first.data)
            self.state.dropped_bytes += len(first.data)
            self.state.dropped_records += first.records

    def _deliver(self, pending: _Pending) -> bool:
        """Hand bytes to the operating system; return False where it does not take all."""
        waits = bool(self._waiting) and self._waiting[0] is pending
        path = self.folder / pending.name
        try:
            descriptor = self._descriptors.get(pending.name)
            if descriptor is None:
                flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND | getattr(os, "O_BINARY", 0)
                descriptor = os.open(path, flags, 0o644)
                self._descriptors[pending.name] = descriptor
            while pending.data:
                count = self._write(descriptor, pending.data)
                self._unsynced[pending.name] = True
                self.state.written_bytes += count
                if waits:
                    self.state.waiting_bytes -= count
                pending.data = pending.data[count:]
                pending.begun = True
        except OSError as error:
            self.state.error = _refusal(path, error)
            return False
        return True


def _refusal(path: Path, error: OSError) -> str:
    if error.errno in (errno.ENOSPC, errno.EDQUOT if hasattr(errno, "EDQUOT") else errno.ENOSPC):
        return (
            f"The disk of {path.parent} is full; the newest data are kept in memory: make room, "
            "and writing goes on."
        )
    return (
        f"{path} cannot be written to ({error.strerror or error}); the newest data are kept in "
        "memory until it can."
    )


class FileEnd(NamedTuple):
    """The end of a raw file.

    Attributes
    ----------
    size : int
        Bytes without the incomplete record at the end.
    torn : int
        Bytes of that record. Damage that does not look like the beginning of a record is none.
    last_stamp : int
        Stamp of the last whole record; 0 where there is none.
    """

    size: int
    torn: int
    last_stamp: int


def find_end(path: Path) -> FileEnd:
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
    torn = file.torn_bytes(file.rest(size))
    return FileEnd(size - torn, torn, max(file.horizon, 0))


_FILES: Final[dict[str, type[_File]]] = {
    FRAMES_FILE: _Frames,
    LINES_FILE: _Lines,
    RESIDUE_FILE: _Pieces,
}

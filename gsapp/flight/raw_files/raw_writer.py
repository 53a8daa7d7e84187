"""Writing the raw files, on through a full disk, and on where an earlier recorder was cut off."""

from __future__ import annotations

import errno
import os
import threading
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from gsapp.decoding.framing import MavlinkFrame, Residue, TextLine
from gsapp.decoding.sender_filter import UNKNOWN_ORIGIN, FrameOrigin
from gsapp.flight.file_names import (
    FRAMES_FILE,
    LINES_FILE,
    RAW_FILES,
    RESIDUE_FILE,
    SENDERS_FILE,
)
from gsapp.flight.raw_files.record_files import (
    MAX_RESIDUE_BYTES,
    RESIDUE_HEADER,
    STAMP_STRUCT,
    find_file_end,
)
from gsapp.foundation import FlightError
from gsapp.foundation.errors import DISK_FULL_ERRNOS, format_os_error
from gsapp.foundation.files import GROUP_FILE_MODE, flush_to_disk, make_group_folder

_FLAGS: Final = os.O_RDWR | os.O_APPEND | getattr(os, "O_BINARY", 0)
_READ_ONLY: Final = frozenset((errno.EACCES, errno.EPERM, errno.EROFS))
_PIECE: Final = 1 << 20
_WRITTEN_FILES: Final = (*RAW_FILES, SENDERS_FILE)


@dataclass(slots=True)
class _Pending:
    """Bytes that the disk has not taken yet."""

    name: str
    data: bytes
    records: int
    begun: bool = False  # a part is on disk already: the rest must follow


@dataclass(slots=True)
class WriterState:
    """What a writer has done; attributes are totals since it was made."""

    frames: int = 0
    lines: int = 0
    residue_bytes: int = 0
    """What was handed over."""
    waiting_bytes: int = 0
    """Bytes in memory, since the disk takes no more."""
    dropped_records: int = 0
    dropped_bytes: int = 0
    """The oldest that waited, which memory could not hold either."""
    lost_records: int = 0
    lost_bytes: int = 0
    """What still waited when the files were closed."""
    unwritten: dict[str, int] = field(default_factory=lambda: dict.fromkeys(_WRITTEN_FILES, 0))
    """Records of both kinds, by the file that they were for."""
    error: str = ""
    """Why the disk takes no more, in words; empty when it does."""
    sync_error: str = ""
    """Why nobody knows whether the disk keeps what it took, in words; empty when it says so."""
    notes: list[str] = field(default_factory=list)
    """What was found and mended in files that were there already."""

    @property
    def is_unconfirmed(self) -> bool:
        """Return whether the disk took all, but does not say that it keeps it."""
        return bool(self.sync_error) and not (self.error or self.dropped_bytes or self.lost_bytes)


class RawWriter:
    """Append to the raw files of a flight folder, which is made if missing.

    Files that are there already are continued; an incomplete record at their end, which a power cut
    or a killed recorder left, is cut off first. `last_stamp` is that of the last record there.

    Every batch is handed to the operating system at once. When the disk refuses, the newest
    batches, up to `memory_bytes`, are kept in memory, and written in order as soon as there is room
    again.
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
        self._unsynced = dict.fromkeys(_WRITTEN_FILES, False)
        self._unkept: set[str] = set()  # files of which a flush has failed
        self._delivered = dict.fromkeys(_WRITTEN_FILES, 0)  # records that the system took, by file
        self._made: set[str] = set()  # files that must be there
        self._may_not_write = False
        self._origin: FrameOrigin | None = UNKNOWN_ORIGIN  # of the last frame written
        self._waiting: deque[_Pending] = deque()
        self._closing = threading.Lock()
        try:
            make_group_folder(self.folder)
            for name in _WRITTEN_FILES:
                end = find_file_end(self.folder / name)
                self.last_stamp = max(self.last_stamp, end.last_stamp)
                if end.torn:
                    os.truncate(self.folder / name, end.size)
                    self.state.notes.append(
                        f"{name} ended in an incomplete record of {end.torn} bytes, which was "
                        "removed."
                    )
                if end.size:
                    self._descriptors[name] = os.open(self.folder / name, _FLAGS)
                    self._made.add(name)
            if SENDERS_FILE in self._made:
                self._origin = None  # what was written last is not that of what comes now
        except OSError as error:
            raise FlightError(
                format_os_error(
                    self.folder,
                    error,
                    "choose another folder or correct its permissions",
                    verb="written to",
                )
            ) from error

    def append(
        self,
        stamp_us: int,
        items: Sequence[MavlinkFrame | Residue | TextLine],
        origin: FrameOrigin = UNKNOWN_ORIGIN,
    ) -> None:
        """Write what came out of a framer at one time, host us, later than the batch before."""
        stamp = STAMP_STRUCT.pack(stamp_us)
        frames: list[bytes] = []
        lines: list[bytes] = []
        pieces: list[bytes] = []
        for item in items:
            if isinstance(item, MavlinkFrame):
                frames += (stamp, item.data)
            elif isinstance(item, TextLine):
                lines.append(b"%d\t%b\n" % (stamp_us, item.data))
            else:
                for start in range(0, len(item.data), MAX_RESIDUE_BYTES):
                    part = item.data[start : start + MAX_RESIDUE_BYTES]
                    pieces += (RESIDUE_HEADER.pack(stamp_us, item.offset + start, len(part)), part)
                    self.state.residue_bytes += len(part)
        self.state.frames += len(frames) // 2
        self.state.lines += len(lines)
        if pieces:
            self._put(_Pending(RESIDUE_FILE, b"".join(pieces), len(pieces) // 2))
        if lines:
            self._put(_Pending(LINES_FILE, b"".join(lines), len(lines)))
        if frames:
            if origin != self._origin:
                self._origin = origin
                self._put(_Pending(SENDERS_FILE, b"%d\t%b\n" % (stamp_us, origin.format()), 0))
            self._put(_Pending(FRAMES_FILE, b"".join(frames), len(frames) // 2))

    def is_folder_writable(self) -> bool:
        """Return whether the folder is the one that is written to, and may be written.

        False once the folder or one of its raw files was removed, renamed or replaced, or the
        folder was made read-only. What is written goes to nowhere then, though no write fails.
        """
        if self._may_not_write:
            return False
        try:
            for name in tuple(self._made):
                found = (self.folder / name).stat()
                descriptor = self._descriptors.get(name)
                if descriptor is not None and not _same_file(found, os.fstat(descriptor)):
                    return False
            return self.folder.is_dir() and os.access(self.folder, os.W_OK)
        except OSError:
            return False

    def move_to(self, folder: Path) -> bool:
        """Go on in another folder; return whether all that was written so far is there.

        A file that was removed can be read for as long as it is open. `OSError` if that folder does
        not take it; everything is as before then.
        """
        targets: dict[str, int] = {}
        whole = True
        try:
            for name in sorted(self._made):
                target = targets[name] = os.open(
                    folder / name, _FLAGS | os.O_CREAT, GROUP_FILE_MODE
                )
                source = self._descriptors.get(name)
                whole = source is not None and _copy(source, target) and whole
        except OSError:
            for target in targets.values():
                os.close(target)
            raise
        with self._closing:
            former, self._descriptors = self._descriptors, targets
            for descriptor in former.values():
                os.close(descriptor)
        self.folder = folder
        self._may_not_write = False
        self._unsynced.update(dict.fromkeys(targets, True))
        self.retry()
        return whole

    def retry(self) -> bool:
        """Try again to write what waits in memory; return whether nothing waits any more."""
        while self._waiting:
            if not self._deliver(self._waiting[0]):
                return False
            self._waiting.popleft()
        self.state.error = ""
        return True

    def sync(self, *, through: bool = False) -> None:
        """Flush to the disk; may be called from another thread.

        `through` empties the memory of the drive itself, too, which takes long on macOS and guards
        against nothing but a power cut.
        """
        flush = flush_to_disk if through else os.fsync
        with self._closing:
            for name, descriptor in list(self._descriptors.items()):
                fresh = self._unsynced[name]
                if not (fresh or through or name in self._unkept):
                    continue
                self._unsynced[name] = False
                try:
                    flush(descriptor)
                except OSError as error:
                    self._unkept.add(name)
                    self.state.sync_error = _sync_error_text(self.folder, error)
                else:
                    # A system may forget what it could not flush, and then call the rest, which
                    # is nothing, flushed: only what was written since proves that the disk works.
                    if fresh:
                        self._unkept.discard(name)
            if not self._unkept:
                self.state.sync_error = ""

    def close(self) -> None:
        """Write what waits, flush and close. What the disk does not take now is lost."""
        if not self.retry():
            for pending in self._waiting:
                self.state.lost_bytes += len(pending.data)
                self.state.lost_records += pending.records
                self.state.unwritten[pending.name] += pending.records
            self._waiting.clear()
            self.state.waiting_bytes = 0
        self._count_removed()
        self.sync(through=True)
        with self._closing:
            for descriptor in self._descriptors.values():
                os.close(descriptor)
            self._descriptors.clear()

    def _count_removed(self) -> None:
        for name, descriptor in self._descriptors.items():
            found = os.fstat(descriptor)
            if found.st_nlink == 0:
                self.state.lost_bytes += found.st_size
                self.state.lost_records += self._delivered[name]
                self.state.unwritten[name] += self._delivered[name]

    def _put(self, pending: _Pending) -> None:
        if self._waiting or not self._deliver(pending):
            self._waiting.append(pending)
            self.state.waiting_bytes += len(pending.data)
            self._make_room()

    def _make_room(self) -> None:
        """Drop the oldest that waits, but never the rest of what is half written.

        The sender of the frames that stay is kept, too.
        """
        kept: list[_Pending] = []
        while self.state.waiting_bytes > self._memory_bytes and len(self._waiting) > 1:
            first = self._waiting.popleft()
            if first.name == SENDERS_FILE and kept and kept[-1].name == SENDERS_FILE:
                former = kept[-1]  # of whom nothing is left
                if not former.begun:
                    self.state.waiting_bytes -= len(kept.pop().data)
            if first.begun or first.name == SENDERS_FILE:
                kept.append(first)
                continue
            self.state.waiting_bytes -= len(first.data)
            self.state.dropped_bytes += len(first.data)
            self.state.dropped_records += first.records
            self.state.unwritten[first.name] += first.records
        self._waiting.extendleft(reversed(kept))

    def _deliver(self, pending: _Pending) -> bool:
        """Hand bytes to the operating system; return False where it does not take all."""
        waits = bool(self._waiting) and self._waiting[0] is pending
        path = self.folder / pending.name
        try:
            descriptor = self._descriptors.get(pending.name)
            if descriptor is None:
                # One that is missing was removed: what it held must not be forgotten.
                create = 0 if pending.name in self._made else os.O_CREAT
                descriptor = os.open(path, _FLAGS | create, GROUP_FILE_MODE)
                self._descriptors[pending.name] = descriptor
                self._made.add(pending.name)
            while pending.data:
                count = self._write(descriptor, pending.data)
                self._unsynced[pending.name] = True
                if waits:
                    self.state.waiting_bytes -= count
                pending.data = pending.data[count:]
                pending.begun = True
        except OSError as error:
            self.state.error = _write_error_text(path, error)
            self._may_not_write = error.errno in _READ_ONLY
            if error.errno not in DISK_FULL_ERRNOS:
                self._let_go(pending.name)
            return False
        self._delivered[pending.name] += pending.records
        return True

    def _let_go(self, name: str) -> None:
        """Open a file anew next time: a disk that was pulled out and put back is another one."""
        # A flush that hangs on that disk must not hold up what still comes.
        if name in self._descriptors and self._closing.acquire(blocking=False):
            try:
                os.close(self._descriptors.pop(name))
            except OSError:
                pass  # it is let go all the same
            finally:
                self._closing.release()


def _same_file(one: os.stat_result, other: os.stat_result) -> bool:
    if os.path.samestat(one, other):
        return True
    return (one.st_size, one.st_mtime_ns) == (other.st_size, other.st_mtime_ns)


def _copy(source: int, target: int) -> bool:
    """Copy a file that is open; return whether all of it could be read."""
    position = 0
    while True:
        try:
            os.lseek(source, position, os.SEEK_SET)
            data = os.read(source, _PIECE)
        except OSError:
            return False  # a disk that is gone
        if not data:
            return True
        position += len(data)
        while data:
            data = data[os.write(target, data) :]


def _write_error_text(path: Path, error: OSError) -> str:
    if error.errno in DISK_FULL_ERRNOS:
        return (
            f"The disk of {path.parent} is full; new data are held in memory: free disk space "
            "and writing resumes."
        )
    return (
        f"{path} cannot be written to ({error.strerror or error}); new data are held in memory "
        "until it can."
    )


def _sync_error_text(folder: Path, error: OSError) -> str:
    return (
        f"The disk of {folder} accepts data but does not confirm it "
        f"({error.strerror or error}): it may be failing; record to another disk."
    )

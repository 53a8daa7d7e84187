"""Reading raw files: all of a flight folder, finished or still growing, or a single ``.tlog``."""

from __future__ import annotations

import os
from collections.abc import Iterator
from heapq import merge
from pathlib import Path
from typing import NamedTuple

from gsapp.flight.file_names import FRAMES_FILE, LINES_FILE, RESIDUE_FILE, SENDERS_FILE
from gsapp.flight.raw_files.record_files import (
    MAX_STAMP,
    FrameFile,
    LineFile,
    RawDamage,
    RawFile,
    RawRecord,
    RecordKind,
    ResidueFile,
    SendersFile,
)
from gsapp.foundation import FlightError


class RawPosition(NamedTuple):
    """Bytes read so far of ``raw.tlog``, ``raw.txt`` and ``residue.bin``."""

    frames: int
    lines: int
    residue: int


class RawTail:
    """Read the raw files of a flight folder, finished or still growing, or not yet there.

    The sequence of records depends on the files alone, not on when they are polled.
    """

    def __init__(self, folder: Path | str) -> None:
        self.folder = Path(folder)
        self._frames = FrameFile(self.folder / FRAMES_FILE)
        self._lines = LineFile(self.folder / LINES_FILE)
        self._pieces = ResidueFile(self.folder / RESIDUE_FILE)
        self._senders = SendersFile(self.folder / SENDERS_FILE)
        self._paths = [str(file.path) for file in (self._frames, self._lines, self._pieces)]
        self._polled: list[int] = []  # sizes of these at the last poll

    @property
    def position(self) -> RawPosition:
        return RawPosition(self._frames.position, self._lines.position, self._pieces.position)

    @property
    def damage(self) -> tuple[RawDamage, ...]:
        """Return what could not be read, per file; empty when all was good."""
        return tuple(file.damage for file in self._files if file.damage)

    @property
    def _files(self) -> tuple[RawFile, RawFile, RawFile]:
        return (self._pieces, self._lines, self._frames)

    def poll(self, limit: int | None = None) -> list[RawRecord]:
        """Return the whole records since the last poll, merged by stamp; at most `limit`."""
        pieces, lines, frames = self._files
        while True:
            sizes = []
            for file in (frames, lines, pieces):
                sizes.append(file.size())
                if limit is None:
                    file.read(sizes[-1])
                elif len(file.records) < limit:
                    file.read(sizes[-1], blocks=1)
            self._polled = sizes
            bound = self._bound(
                frames_grew=frames.size() != sizes[0], lines_grew=lines.size() != sizes[1]
            )
            merged = self._merged(limit, bound)
            if merged or all(file.exhausted for file in self._files):
                return merged

    def has_grown(self) -> bool:
        """Return whether a poll would find more than the last one did.

        Nothing is read: this may be asked every few milliseconds.
        """
        return (
            any(file.records or not file.exhausted for file in self._files)
            or [_size(path) for path in self._paths] != self._polled
        )

    def _bound(self, *, frames_grew: bool, lines_grew: bool) -> dict[RecordKind, int]:
        """Return up to which stamp the records of each kind are complete.

        What was written to one file while a later one was read may precede records of the
        later one; these are left for the next time.
        """
        _, lines, frames = self._files
        unread = min(
            (file.last_read_stamp for file in self._files if not file.exhausted), default=MAX_STAMP
        )
        before_frames = min(unread, frames.last_read_stamp) if frames_grew else unread
        before_lines = min(before_frames, lines.last_read_stamp) if lines_grew else before_frames
        return {"frame": unread, "line": before_frames, "residue": before_lines}

    def _merged(self, limit: int | None, bound: dict[RecordKind, int]) -> list[RawRecord]:
        ready = []
        for file in self._files:
            highest, records = bound[file.kind], file.records
            taken: list[RawRecord] = []
            while records and records[0].stamp_us <= highest and len(taken) != limit:
                taken.append(records.popleft())
            ready.append(taken)
        if not ready[0] and not ready[1]:
            return self._senders.label(ready[2])
        merged = list(merge(*ready, key=lambda record: record.stamp_us))
        if limit is not None and len(merged) > limit:
            for record in reversed(merged[limit:]):
                self._file_of(record.kind).records.appendleft(record)
            merged = merged[:limit]
        return self._senders.label(merged)

    def _file_of(self, kind: RecordKind) -> RawFile:
        return next(file for file in self._files if file.kind == kind)


def _size(path: str) -> int:
    try:
        return os.stat(path).st_size  # noqa: PTH116 - a Path takes six times as long
    except OSError:
        return 0


def read_tlog(path: Path | str, damage: RawDamage | None = None) -> Iterator[RawRecord]:
    """Yield the frames of any ``.tlog``: MAVLink 1, 2 or both, from whichever ground station.

    `damage` is filled with what had to be stepped over.
    """
    file = FrameFile(Path(path))
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


def read_nonempty_tlog(path: Path | str, damage: RawDamage | None = None) -> Iterator[RawRecord]:
    """Read a ``.tlog`` that is not growing, and holds a message; see `read_tlog`."""
    found = False
    for record in read_tlog(path, damage):
        found = True
        yield record
    if not found:
        raise FlightError(
            f"{path} holds no MAVLink message; check that it is a telemetry log and was copied "
            "whole"
        )

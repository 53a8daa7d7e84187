"""A log that is not whole yet, on the disk, so that a download goes on after a break."""

from __future__ import annotations

import contextlib
import json
from pathlib import Path
from typing import IO

from gsapp.foundation import FlightError, write_atomically
from gsapp.foundation.files import flush_to_disk, move_into_place
from gsapp.telemetry.log_download.log_protocol import LogEntry, MissingRanges

_MAGICS = ((b"\xa3\x95", ".bin"), (b"ULog\x01\x12\x35", ".ulg"))
_TLOG_MAGICS = (0xFD, 0xFE)


class PartialLog:
    """The bytes that have come, and a note of those that have not.

    The note is never ahead of the bytes: it is written after they are on the disk. Whatever kills
    the program, at most the last seconds are asked for again. What lies in the folder of the very
    same log is gone on with. Raise FlightError if the folder cannot be written to.
    """

    def __init__(self, folder: Path, entry: LogEntry) -> None:
        self.entry = entry
        self.path = folder / f"onboard-{entry.id}.part"
        self._note = folder / f"onboard-{entry.id}.json"
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self.missing = self._found()
            mode = "r+b" if self.path.exists() else "w+b"
            self._stream: IO[bytes] = self.path.open(mode, buffering=0)
            self._stream.truncate(entry.size)
        except OSError as error:
            raise self._refusal(error) from error

    def write(self, offset: int, data: bytes) -> None:
        """Write bytes at their place.

        Raise FlightError if the disk refuses.
        """
        try:
            self._stream.seek(offset)
            self._stream.write(data)
        except OSError as error:
            raise self._refusal(error) from error

    def save(self) -> None:
        """See what came onto the disk, then note it.

        Raise FlightError if the disk refuses.
        """
        try:
            flush_to_disk(self._stream.fileno())
            write_atomically(
                self._note,
                json.dumps({"log": self._identity(), "missing": self.missing.ranges}),
            )
        except OSError as error:
            raise self._refusal(error) from error

    def close(self) -> None:
        """Give the file back. May be called twice."""
        self._stream.close()

    def finish(self) -> Path:
        """Give the whole log its name, with the ending that its first bytes call for.

        Raise FlightError if it is of no kind that can be read, or the disk refuses.
        """
        self.save()
        self.close()
        ending = log_file_suffix(self.path)
        if not ending:
            raise FlightError(
                f"log {self.entry.id} of the autopilot is of no kind that can be read; its "
                f"bytes are in {self.path}"
            )
        whole = self.path.with_suffix(ending)
        try:
            move_into_place(self.path, whole)
        except OSError as error:
            raise self._refusal(error) from error
        with contextlib.suppress(OSError):
            self._note.unlink(missing_ok=True)
        return whole

    def _identity(self) -> list[int]:
        entry = self.entry
        return [entry.id, entry.size, entry.time_utc, entry.system]

    def _found(self) -> MissingRanges:
        """Return what is missing of what lies there; all where it is of another log."""
        with contextlib.suppress(OSError, ValueError, KeyError, TypeError):
            note = json.loads(self._note.read_bytes())
            if note["log"] == self._identity() and self.path.stat().st_size == self.entry.size:
                return MissingRanges(self.entry.size, note["missing"])
        self._note.unlink(missing_ok=True)
        return MissingRanges(self.entry.size)

    def _refusal(self, error: OSError) -> FlightError:
        return FlightError(
            f"{self.path} cannot be written ({error.strerror or error}); check the permissions "
            "and the space on the disk"
        )


def log_file_suffix(path: Path) -> str:
    """Return the ending that a log's first bytes call for; empty where their kind is not known."""
    with path.open("rb") as stream:
        head = stream.read(16)
    for magic, ending in _MAGICS:
        if head.startswith(magic):
            return ending
    return ".tlog" if len(head) > 8 and head[8] in _TLOG_MAGICS else ""

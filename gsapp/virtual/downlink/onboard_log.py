"""The log kept on board: whole frames with the box's own time of day, appended."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from struct import Struct
from typing import BinaryIO

_STAMP = Struct(">Q")


def pack_tlog_record(stamp_us: int, frame: bytes) -> bytes:
    """Return a frame as a .tlog holds it: 8-byte big-endian microseconds, then the frame."""
    return _STAMP.pack(stamp_us) + frame


class OnboardLog:
    """A growing .tlog.

    Only whole frames reach the file, so that it can be read at any moment, also after Ctrl-C.

    Parameters
    ----------
    path : Path
        Replaced if it exists.
    """

    FLUSH_BYTES = 4096

    def __init__(self, path: Path) -> None:
        self.path = path
        path.parent.mkdir(parents=True, exist_ok=True)
        self._stream: BinaryIO = path.open("wb", buffering=0)
        self._waiting = bytearray()

    def append(self, stamp_us: int, frames: Iterable[bytes]) -> None:
        for frame in frames:
            self._waiting += pack_tlog_record(stamp_us, frame)
        if len(self._waiting) >= self.FLUSH_BYTES:
            self.flush()

    def flush(self) -> None:
        if self._waiting:
            self._stream.write(self._waiting)
            self._waiting.clear()

    def close(self) -> None:
        """End the log. May be called twice."""
        if not self._stream.closed:
            self.flush()
            self._stream.close()

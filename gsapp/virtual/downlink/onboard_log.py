"""The log kept on board: frames with the box's own time, and how they are handed out after landing.

The ground asks with LOG_REQUEST_LIST and LOG_REQUEST_DATA; answers are LOG_ENTRY and LOG_DATA.
LOG_ERASE is not obeyed: the record of a flight is not erased over the air.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from struct import Struct
from typing import BinaryIO

from gsapp.virtual.downlink.onboard_messages import Message, dialect

_STAMP = Struct(">Q")


def pack_tlog_record(stamp_us: int, frame: bytes) -> bytes:
    """Return a frame as a .tlog holds it: 8-byte big-endian microseconds, then the frame."""
    return _STAMP.pack(stamp_us) + frame


class OnboardLog:
    """A growing .tlog; one that exists is replaced.

    Only whole frames reach the file, so that it can be read at any moment, also after Ctrl-C.
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
        if not self._stream.closed:
            self.flush()
            self._stream.close()


LOG_ID = 1
LOG_DATA_BYTES = 90
"""Bytes of the log in one LOG_DATA."""


class LogServer:
    """Answers requests for one log file, which may still grow; begun at a second since 1970."""

    def __init__(self, path: Path, *, started: int) -> None:
        self._path = path
        self._started = started
        self._pending: Iterator[Message] = iter(())

    def handle_request(self, message: Message) -> bool:
        """Take a message from the ground; return whether it was a request that is obeyed."""
        kind = message.get_msgId()
        if kind == dialect.MAVLINK_MSG_ID_LOG_REQUEST_LIST:
            self._pending = self._entries(message.start, message.end)
        elif kind == dialect.MAVLINK_MSG_ID_LOG_REQUEST_DATA and message.id == LOG_ID:
            self._pending = self._chunks(message.ofs, message.count)
        elif kind == dialect.MAVLINK_MSG_ID_LOG_REQUEST_END:
            self._pending = iter(())
        else:
            return False
        return True

    def pending_responses(self, budget: int) -> Iterator[Message]:
        """Yield answers that are due, until about `budget` bytes are spent."""
        spent = 0
        while spent < budget:
            message = next(self._pending, None)
            if message is None:
                return
            spent += 12 + LOG_DATA_BYTES + 7
            yield message

    def _size(self) -> int:
        return self._path.stat().st_size if self._path.exists() else 0

    def _entries(self, first: int, last: int) -> Iterator[Message]:
        if first <= LOG_ID <= last:
            yield dialect.MAVLink_log_entry_message(
                LOG_ID, 1, LOG_ID, self._started, min(self._size(), 0xFFFFFFFF)
            )

    def _chunks(self, offset: int, count: int) -> Iterator[Message]:
        if not self._path.exists():
            return
        with self._path.open("rb") as stream:
            stream.seek(offset)
            # What is asked for now is answered from what the log holds now.
            size = os.fstat(stream.fileno()).st_size
            end = min(offset + count, size)
            while True:
                data = stream.read(max(min(LOG_DATA_BYTES, end - offset), 0))
                # A chunk that is not full, were it empty, tells the ground that this was all.
                yield dialect.MAVLink_log_data_message(
                    LOG_ID, offset, len(data), data.ljust(LOG_DATA_BYTES, b"\0")
                )
                offset += len(data)
                if len(data) < LOG_DATA_BYTES or (offset == end and end < size):
                    return

"""What others ask the recorder to send: it alone owns the link.

A file ``recorder.send`` beside the record, of the same kind as ``raw.tlog``, to which whole frames
are appended and which the recorder follows. It passes on requests for the aircraft's log, and
nothing else: no file can make it command the aircraft or erase a log.
"""

from __future__ import annotations

import contextlib
import os
import time
from pathlib import Path
from typing import Any, Final

from gsapp.decoding.dialect import dialect
from gsapp.decoding.framing import frame_message_id
from gsapp.flight.file_names import SEND_FILE
from gsapp.flight.raw_files import STAMP_STRUCT, FrameFile
from gsapp.foundation.files import GROUP_FILE_MODE
from gsapp.telemetry.signing import SignatureVerifier, signature_time

LOG_REQUEST_LIST: Final = 117
LOG_REQUEST_DATA: Final = 119
LOG_REQUEST_END: Final = 122
ALLOWED_MESSAGE_IDS: Final = frozenset({LOG_REQUEST_LIST, LOG_REQUEST_DATA, LOG_REQUEST_END})
"""Ids of the messages that are passed on."""


def request_send(folder: Path, frame: bytes) -> None:
    """Ask the recorder of a flight folder to send a frame.

    Raise OSError if the folder cannot be written to.
    """
    # One write of a few bytes: windows may ask at once and do not come between each other.
    descriptor = os.open(
        folder / SEND_FILE,
        os.O_WRONLY | os.O_CREAT | os.O_APPEND | getattr(os, "O_BINARY", 0),
        GROUP_FILE_MODE,
    )
    try:
        os.write(descriptor, STAMP_STRUCT.pack(time.time_ns() // 1000) + frame)
    finally:
        os.close(descriptor)


class SendQueue:
    """The recorder's side, in its flight folder. What was asked for before is forgotten."""

    def __init__(self, folder: Path) -> None:
        self._path = folder / SEND_FILE
        self._file = FrameFile(self._path)
        self.close()

    def pop_frames(self) -> list[bytes]:
        """Return the frames that are to be sent now; never raises."""
        frames: list[bytes] = []
        with contextlib.suppress(OSError, ValueError):
            size = self._file.size()
            if size > self._file.position:
                self._file.read(size)
        while self._file.records:
            frame = self._file.records.popleft().data
            if frame_message_id(frame) in ALLOWED_MESSAGE_IDS:
                frames.append(frame)
        return frames

    def close(self) -> None:
        with contextlib.suppress(OSError):
            self._path.unlink(missing_ok=True)


GROUND_SYSTEM = 255
GROUND_COMPONENT = 190


class GroundPacker:
    """Packs what the ground station sends, in one sequence; signed where signatures are checked.

    pymavlink signs; a time stamp is never older than those of the aircraft, as the protocol asks.
    """

    def __init__(self, verifier: SignatureVerifier | None = None) -> None:
        self._verifier = verifier
        self._dialect = dialect()
        self._packer = self._dialect.MAVLink(
            None, srcSystem=GROUND_SYSTEM, srcComponent=GROUND_COMPONENT
        )
        if verifier is not None:
            self._packer.signing.secret_key = verifier.key
            self._packer.signing.sign_outgoing = True

    def pack_heartbeat(self, host_us: int) -> bytes:
        """Return the next HEARTBEAT of a ground station, sent at a host time (us)."""
        names = self._dialect
        return self._pack(
            names.MAVLink_heartbeat_message(
                names.MAV_TYPE_GCS, names.MAV_AUTOPILOT_INVALID, 0, 0, names.MAV_STATE_ACTIVE, 3
            ),
            host_us,
        )

    def repack(self, frame: bytes, host_us: int) -> bytes:
        """Return the message of a frame as the next one of this sender; empty if it holds none."""
        try:
            message = self._dialect.MAVLink(None).decode(bytearray(frame))
        except self._dialect.MAVError:
            return b""
        return self._pack(message, host_us)

    def _pack(self, message: Any, host_us: int) -> bytes:
        packer = self._packer
        if self._verifier is not None:
            packer.signing.timestamp = max(
                packer.signing.timestamp, signature_time(host_us), self._verifier.newest_time
            )
        data = bytes(message.pack(packer))
        packer.seq = (packer.seq + 1) % 256
        return data

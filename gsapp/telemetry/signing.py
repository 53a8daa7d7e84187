"""MAVLink 2 signatures: the key, and the check of what arrives."""

from __future__ import annotations

import hashlib
import hmac
import os
import stat
import sys
from pathlib import Path
from typing import Final

from gsapp.decoding.framing import MAGIC_2, SIGNATURE_BYTES, SIGNED_FLAG
from gsapp.decoding.sender_filter import SignatureState
from gsapp.flight.file_names import FLIGHT_FOLDER_FILES
from gsapp.foundation import LinkError
from gsapp.foundation.errors import format_os_error

KEY_BYTES: Final = 32
_EPOCH_S: Final = 1_420_070_400  # 1 January 2015 (UTC), where time stamps of signatures begin
_TICKS_PER_S: Final = 100_000  # of 10 us
_MAX_AGE: Final = 60 * _TICKS_PER_S
"""By how much the first frame of a stream may be older than the newest time known."""
_HASH_BYTES: Final = 6
_MAX_FILE_BYTES: Final = 4096


def derive_key(passphrase: str) -> bytes:
    """Return the key of a passphrase, as Mission Planner and MAVProxy derive it: its SHA-256."""
    return hashlib.sha256(passphrase.encode()).digest()


def read_signing_key(path: Path | str) -> bytes:
    """Read a key file: 32 bytes, 64 hexadecimal digits, or one line with a passphrase.

    Raise LinkError if it holds none of them, lies in a flight folder, which is handed on, or may be
    read by others.
    """
    path = Path(path).expanduser()
    try:
        with path.open("rb") as stream:
            mode = os.fstat(stream.fileno()).st_mode
            content = stream.read(_MAX_FILE_BYTES)
    except OSError as error:
        raise LinkError(
            format_os_error(path, error, "name the file of the signing key", verb="read")
        ) from error
    if any((path.parent / name).exists() for name in FLIGHT_FOLDER_FILES):
        raise LinkError(
            f"{path} lies in a flight folder, which is copied and handed on; move the signing key "
            "to your own folder"
        )
    if sys.platform != "win32" and mode & (stat.S_IRWXG | stat.S_IRWXO):
        raise LinkError(
            f"{path} may be read by other users; a signing key is for its owner alone: "
            f"chmod 600 {path}"
        )
    return _parse_key(path, content)


def _parse_key(path: Path, content: bytes) -> bytes:
    # Random bytes are never all printable; a passphrase always is.
    if len(content) == KEY_BYTES and not (content.isascii() and content.decode().isprintable()):
        return content
    try:
        text = content.decode().strip("\r\n")
    except UnicodeDecodeError:
        text = ""
    if not text.isprintable() or not text:
        raise LinkError(
            f"{path} holds no signing key; write 32 bytes, 64 hexadecimal digits, or a passphrase "
            "in one line"
        )
    if len(text) == 2 * KEY_BYTES:
        try:
            return bytes.fromhex(text)
        except ValueError:
            pass  # a passphrase of that length
    return derive_key(text)


def write_signing_key(path: Path, key: bytes) -> None:
    """Write a key into a file that its owner alone may read.

    Raise OSError if that fails.
    """
    path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    temporary.unlink(missing_ok=True)
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
    descriptor = os.open(temporary, flags, 0o600)
    try:
        os.write(descriptor, key)
    finally:
        os.close(descriptor)
    temporary.replace(path)


def signature_time(host_us: int) -> int:
    """Return the time stamp of a signature at a host time, us since 1970."""
    return max(host_us // 10 - _EPOCH_S * _TICKS_PER_S, 0)


class SignatureVerifier:
    """Checks the signatures of frames with a key, each stream of a sender by its own time stamps.

    pymavlink's `check_signature` does not tell a false frame from a replayed one, and takes the
    time stamp of a false one for that of the stream: one forged frame would silence the aircraft.

    Attributes
    ----------
    newest_time : int
        The newest time known, as in signatures: of the host at the start, or of a valid frame.
    """

    def __init__(self, key: bytes, host_us: int) -> None:
        self.key = key
        self.newest_time = signature_time(host_us)
        self._streams: dict[bytes, int] = {}

    def verify(self, frame: bytes) -> SignatureState:
        """Return what is found of a whole frame whose checksum fits."""
        if frame[0] != MAGIC_2 or not frame[2] & SIGNED_FLAG:
            return "unsigned"
        digest = hashlib.sha256(self.key + frame[:-_HASH_BYTES]).digest()
        if not hmac.compare_digest(digest[:_HASH_BYTES], frame[-_HASH_BYTES:]):
            return "false"
        trailer = frame[-SIGNATURE_BYTES:]
        stream = frame[5:7] + trailer[:1]  # system, component and link id
        time = int.from_bytes(trailer[1:-_HASH_BYTES], "little")
        former = self._streams.get(stream)
        if time <= former if former is not None else time < self.newest_time - _MAX_AGE:
            return "replayed"
        self._streams[stream] = time
        self.newest_time = max(self.newest_time, time)
        return "valid"

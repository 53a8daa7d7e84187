"""What a recorder tells of itself, in a file next to what it records."""

from __future__ import annotations

import contextlib
import errno
import os
import stat
import sys
import tempfile
import warnings
from functools import cache
from pathlib import Path
from typing import Final, Literal

import platformdirs
from pydantic import BaseModel, ConfigDict, ValidationError

from gsapp.foundation.errors import DISK_FULL_ERRNOS
from gsapp.foundation.files import GROUP_FILE_MODE, move_into_place
from gsapp.foundation.translation import QT_TR_NOOP
from gsapp.telemetry.settings import TELEMETRY

RUNTIME_VARIABLE: Final = "GSAPP_RUNTIME_FOLDER"


LinkContent = Literal["", "mavlink", "text", "unreadable"]
"""What the last bytes of a link are; empty while there are too few to tell."""


class ShareStatus(BaseModel):
    """An address that a recorder passes on to what it receives."""

    model_config = ConfigDict(frozen=True, extra="ignore")

    link: str  # As it was asked for.
    clients: tuple[str, ...] = ()  # Network addresses of who is connected, over TCP.
    sent_bytes: int = 0
    dropped_bytes: int = 0
    """Passed on since the start; not passed on, because a client or the network did not take it."""
    note: str = ""  # What happened last to a client, or why sending fails, in words.
    error: str = ""  # Why it is not shared with, in words; empty where it is.

    def describe(self) -> str:
        """Return how it fares, in a sentence."""
        if self.error:
            return f"Not shared: {self.error}"
        if self.link.startswith("tcpin"):
            count = len(self.clients)
            state = f"{count} client{'' if count == 1 else 's'} connected"
        else:
            state = "sending"
        return f"Shared over {self.link}: {'; '.join(filter(None, (state, self.note)))}"


class RecorderStatus(BaseModel):
    """The state of a recorder; written about twice a second."""

    model_config = ConfigDict(frozen=True, extra="ignore")

    pid: int  # Its process.
    link: str  # What it records.
    folder: str  # The flight folder.
    moved_from: str = ""
    """The folder in which the record began, if that was removed, renamed or made read-only and the
    record continues in `folder`; else empty."""
    state: Literal["starting", "recording", "stopped", "failed"]  # What it does.
    started_us: int
    updated_us: int
    """Host microseconds of its start and of this status."""
    source_state: str = ""  # How the link fares, in words.
    connected: bool = False  # Whether data can arrive.
    received_bytes: int = 0
    frames: int = 0
    lines: int = 0
    residue_bytes: int = 0
    """What has come since the start."""
    content: LinkContent = ""  # What the last bytes are; empty while there are too few to tell.
    byte_rate: float = 0.0  # Bytes per second of late.
    last_data_us: int | None = None  # Host time of the last data.
    disk_free_bytes: int | None = None  # Room on the disk.
    seconds_until_full: float | None = None
    """For how long it lasts at the present rate; None while nothing comes."""
    waiting_bytes: int = 0
    dropped_bytes: int = 0
    """Held in memory because the disk refuses; lost because memory was full too, or because the
    record ended meanwhile."""
    unwritten_frames: int = 0
    unwritten_lines: int = 0
    """How many of `frames` and `lines` were lost so."""
    error: str = ""  # What is wrong, in words; empty when all is well.
    unconfirmed: bool = False
    """Whether what is wrong is only that the disk does not say that it keeps what it took."""
    warnings: list[str] = []  # What will be wrong soon.
    notes: list[str] = []  # What was found in the folder at the start.
    listen_only: bool = False  # Whether nothing is sent.
    sends_heartbeats: bool = False  # Whether it sends the ground station's sign of life.
    heartbeats: int = 0  # Sent since the start.
    signing_key: str = ""
    """Path of the signing key file, for a restart; empty for none, and once recording stopped."""
    signatures: dict[str, int] = {}
    """Frames by what was found of their signature; empty where there is no key to check it."""
    shares: list[ShareStatus] = []  # Whom it passes on to what it receives.
    share_open: bool = False  # Whether anyone on a network may receive it, without a key.
    share_key: str = ""  # Path of the key that others need, if not the signing key; as that.
    share_notes: bool = False  # Whether the notes of others are written into the flight.
    sends_notes: bool | None = None
    """Of a flight that is copied now: whether its recorder takes the notes made here; else None."""
    parent: int = 0
    """The process that started it; on Windows the launcher of a virtual environment."""
    ahead_us: int = 0
    """By how much its stamps are ahead of the computer's clock, because that was set back, or
    because the flight that is continued ends in the future. Whoever compares a stamp with the
    computer's clock adds it to that."""
    clock_offset_us: int = 0
    """The part of `ahead_us` that is the clock of another recorder, whose flight is copied."""


HEARTBEAT_END: Final = QT_TR_NOOP(
    "The heartbeats of this ground station stop with the recording: an autopilot with its "
    "ground-station failsafe enabled (FS_GCS_ENABL, NAV_DLL_ACT) may return home or land."
)
"""What the end of a recording that sent heartbeats may do to an aircraft that flies."""


def runtime_folder() -> Path:
    """Return the folder in which running recorders leave a note for windows to find.

    The environment variable ``GSAPP_RUNTIME_FOLDER`` names another. Where others could write there,
    the user's own folder for the state of programs takes its place.
    """
    return _find_runtime_folder()[0]


def runtime_folder_note() -> str:
    """Return why the usual runtime folder is not used, in words; empty where it is."""
    return _find_runtime_folder()[1]


def _find_runtime_folder() -> tuple[Path, str]:
    usual = _usual_runtime_folder() / "recorders"
    try:
        return _make_private(usual), ""
    except OSError as error:
        # A note is no reason not to record.
        why = error.strerror or str(error)
    other = Path(platformdirs.user_state_dir("gsapp", appauthor=False)) / "recorders"
    try:
        folder = _make_private(other)
    except OSError:
        folder = _last_resort()
    return folder, (
        f"The runtime folder {usual} is not used: {why}. Windows find this recording by its note "
        f"in {folder}."
    )


def _usual_runtime_folder() -> Path:
    if given := os.environ.get(RUNTIME_VARIABLE):
        return Path(given).absolute()
    with warnings.catch_warnings():
        # Where the session names no folder, or one that others may enter, platformdirs takes
        # another, always the same; nobody has to do anything about it.
        warnings.filterwarnings("ignore", message="XDG_RUNTIME_DIR", category=UserWarning)
        return Path(platformdirs.user_runtime_dir("gsapp"))


@cache
def _last_resort() -> Path:
    """Return a folder of this process alone: it records, though no window finds it."""
    return Path(tempfile.mkdtemp(prefix="gsapp-"))


def _make_private(folder: Path) -> Path:
    """Make a folder that nobody but this user may write, nor exchange, if it is not there yet.

    Raise OSError if others could: a note planted there would pass for a recorder of this user.
    """
    for path in reversed((folder, *folder.parents)):
        with contextlib.suppress(FileExistsError):
            path.mkdir(mode=0o700)
        _check_private(path, is_last=path == folder)
    if not os.access(folder, os.W_OK | os.X_OK):
        raise PermissionError(errno.EACCES, "it may not be written", str(folder))
    return folder


def _check_private(path: Path, *, is_last: bool) -> None:
    if sys.platform == "win32":
        return  # every user has folders of their own there
    found = path.lstat()
    if stat.S_ISLNK(found.st_mode) and not is_last:
        found = path.stat()  # as /tmp of macOS; a link is exchanged only in a folder of others
    if not stat.S_ISDIR(found.st_mode):
        raise NotADirectoryError(errno.ENOTDIR, f"{path} is no folder", str(path))
    owners = (os.getuid(),) if is_last else (os.getuid(), 0)
    if found.st_uid not in owners:
        raise PermissionError(errno.EPERM, f"{path} belongs to another user", str(path))
    open_to_others = found.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
    # In a sticky folder, such as /tmp, nobody exchanges what belongs to another.
    if open_to_others and (is_last or not found.st_mode & stat.S_ISVTX):
        raise PermissionError(errno.EPERM, f"other users may write {path}", str(path))


def write_status(path: Path, status: RecorderStatus) -> bool:
    """Replace a status file; return False where the disk refuses.

    Unlike documents it is not flushed to the disk: it says what is, not what was. On Windows it
    is tried until nobody reads it: the last one tells that the recorder has stopped.
    """
    temporary = path.with_name(f".{path.name}.{status.pid}")
    content = status.model_dump_json(indent=1).encode("utf-8")
    try:
        os.close(os.open(temporary, os.O_WRONLY | os.O_CREAT, GROUP_FILE_MODE))
        temporary.write_bytes(content)
        move_into_place(temporary, path, patience=TELEMETRY.status_wait)
    except OSError as error:
        with contextlib.suppress(OSError):
            temporary.unlink()
        return error.errno in DISK_FULL_ERRNOS and _overwrite(path, content)
    return True


def _overwrite(path: Path, content: bytes) -> bool:
    """Write over what stands there, in the room that it has: a full disk takes no second file."""
    try:
        with path.open("r+b", buffering=0) as stream:
            stream.write(content)
            stream.truncate()
    except OSError:
        return False
    return True


def read_status(path: Path) -> RecorderStatus | None:
    """Read a status file; None where it is missing or not whole."""
    try:
        return RecorderStatus.model_validate_json(path.read_bytes())
    except (OSError, ValidationError):
        return None

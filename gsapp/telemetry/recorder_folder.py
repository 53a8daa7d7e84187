"""The folder that a recorder writes into: claimed, kept whole, and replaced when it is removed."""

from __future__ import annotations

import contextlib
import shutil
from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path
from typing import Final, Literal

from gsapp.flight.file_names import CALIBRATION_FOLDER, LOCK_FILE, STATUS_FILE
from gsapp.flight.folder import FlightFolder
from gsapp.foundation import FlightError, GroundStationError
from gsapp.foundation.errors import format_os_error
from gsapp.foundation.file_lock import FileLock, lock_holder
from gsapp.foundation.files import make_group_folder
from gsapp.telemetry.recorder_status import (
    RecorderStatus,
    read_status,
    runtime_folder,
    write_status,
)
from gsapp.telemetry.settings import TELEMETRY

RecordState = Literal["none", "recording", "interrupted", "finished"]

_SMALL_FILES: Final = ("*.toml", "*.jsonl", f"{CALIBRATION_FOLDER}/*.toml")


def runtime_status_path(folder: Path) -> Path:
    """Return the note in the runtime folder that leads from there to a recorder."""
    name = sha256(str(folder.absolute()).encode()).hexdigest()[:16]
    return runtime_folder() / f"{name}.json"


def runtime_lock_path(folder: Path) -> Path:
    """Return the lock beside the note, held for as long as the recorder of a folder lives."""
    return runtime_status_path(folder).with_suffix(".lock")


def record_state(folder: Path) -> RecordState:
    """Return what a folder holds: no record, one in progress, one cut off, or a finished one.

    A recorder that was stopped says so in its status file. One that died cannot. A record
    without any status, such as a copy or an import, counts as finished.
    """
    if (
        lock_holder(folder / LOCK_FILE) is not None
        or lock_holder(runtime_lock_path(folder)) is not None
    ):
        return "recording"
    if not folder.is_dir() or not _holds_flight(FlightFolder(path=folder)):
        return "none"
    status = read_status(folder / STATUS_FILE)
    return "interrupted" if status is not None and status.state != "stopped" else "finished"


def _holds_flight(folder: FlightFolder) -> bool:
    try:
        return bool(folder.nonempty_raw_files or folder.onboard_log())
    except GroundStationError:
        return True  # a flight card with mistakes, or one whose log is missing


def check_not_finished(folder: Path, remedy: str) -> None:
    """Refuse to append to a finished flight.

    Raise FlightError if the folder holds one; ends with `remedy`.
    """
    if record_state(folder) == "finished":
        raise FlightError(f"{folder} already holds a finished flight; {remedy}")


def next_free_folder(folder: Path) -> Path:
    """Return the first of ``NAME-2``, ``NAME-3`` ... beside a folder that does not exist."""
    number = 2
    while (found := folder.with_name(f"{folder.name}-{number}")).exists():
        number += 1
    return found


class RecordingClaim:
    """Shows others that a folder is being recorded into: a lock in it, and a note elsewhere.

    The note lies in the runtime folder, with a lock of its own. It still leads to the recorder
    where the flight folder, which is made if missing, cannot be seen any more. Raise FlightError if
    the folder cannot be written to, or is being recorded into.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._lock = _lock(folder)
        self._note = runtime_status_path(folder)
        self._beside = FileLock(runtime_lock_path(folder))
        with contextlib.suppress(OSError, FlightError):
            self._beside.acquire(patience=0.0)

    def write_status(self, status: RecorderStatus) -> None:
        """Write the note. The runtime folder usually lies in memory: a full disk does not matter.

        A folder that was given up and now belongs to another recorder is left to that one.
        """
        if lock_holder(self.folder / LOCK_FILE) in (None, status.pid):
            write_status(self._note, status)

    def release_folder(self) -> None:
        """Release the lock of a folder that is no longer written to; the note leads on."""
        self._lock.release()

    def remove_runtime_status(self) -> None:
        self._beside.release()
        for path in (self._note, self._beside.path):
            with contextlib.suppress(OSError):
                path.unlink()

    def release(self) -> None:
        self.remove_runtime_status()
        self._lock.release()


def _lock(place: Path) -> FileLock:
    try:
        make_group_folder(place)
        lock = FileLock(place / LOCK_FILE)
        held = lock.acquire()
    except OSError as error:
        raise FlightError(
            format_os_error(
                place,
                error,
                "choose another folder or correct its permissions",
                verb="written to",
            )
        ) from error
    if not held:
        status = read_status(place / STATUS_FILE)
        pid = lock_holder(place / LOCK_FILE)
        what = f" {status.link}" if status else ""
        raise FlightError(
            f"{place} is already being recorded:{what} by process {pid}; stop it, or record "
            "into another folder"
        )
    return lock


class FolderFileCache:
    """Keeps the small files of a flight folder in memory: flight card, map, certificates, marks.

    A record that goes on in another folder is read with them.
    """

    def __init__(self) -> None:
        self._kept: dict[str, tuple[tuple[int, int], bytes]] = {}

    def read(self, folder: Path) -> None:
        """Read what is new or changed. What has disappeared is kept."""
        with contextlib.suppress(OSError):
            for path in [found for pattern in _SMALL_FILES for found in folder.glob(pattern)]:
                name = str(path.relative_to(folder))
                with contextlib.suppress(OSError):
                    found = path.stat()
                    stamp = (found.st_mtime_ns, found.st_size)
                    new = name not in self._kept or self._kept[name][0] != stamp
                    if new and found.st_size <= TELEMETRY.max_kept_bytes:
                        self._kept[name] = stamp, path.read_bytes()

    def write(self, folder: Path) -> None:
        """Write them into another folder.

        Raise OSError if that does not take them.
        """
        for name, (_, data) in dict(self._kept).items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)


def claim_replacement_folder(former: Path, files: FolderFileCache) -> RecordingClaim:
    """Make the folder in which a record goes on whose own is gone, with the files of that.

    Raise OSError or FlightError if it cannot be made; nothing is left of it then.
    """
    folder = next_free_folder(former)
    try:
        claim = RecordingClaim(folder)
        try:
            files.write(folder)
        except OSError:
            claim.release()
            raise
    except (OSError, FlightError):
        shutil.rmtree(folder, ignore_errors=True)
        raise
    return claim


@contextlib.contextmanager
def rollback_on_failure(path: Path | str) -> Iterator[None]:
    """Take away what was made inside of a flight folder if the flight cannot begin.

    What stood there before stays, and so does a folder into which anything was recorded, or
    another recorder records.
    """
    folder = Path(path).absolute()
    made = [each for each in (folder, *folder.parents) if not each.exists()]
    try:
        yield
    except GroundStationError:
        if made and folder.is_dir() and not _in_use(folder):
            shutil.rmtree(folder, ignore_errors=True)
        for each in made:
            with contextlib.suppress(OSError):  # others may have put something there
                each.rmdir()
        raise


def _in_use(folder: Path) -> bool:
    return bool(FlightFolder(path=folder).raw_files) or lock_holder(folder / LOCK_FILE) is not None

"""Replacing the files of a flight whole, with one clear sentence where the disk refuses."""

from __future__ import annotations

import contextlib
import errno
import shutil
from collections.abc import Iterator
from pathlib import Path

from gsapp.foundation import FlightError, files
from gsapp.foundation.errors import DISK_FULL_ERRNOS, format_os_error


@contextlib.contextmanager
def atomic_flight_file(path: Path | str) -> Iterator[Path]:
    """Give a temporary file to write to, and put it in place of `path` if all went well."""
    target = Path(path)
    try:
        if target.is_dir():
            raise FlightError(f"{target} is a folder; name a file")
        with files.atomic_write(target) as temporary:
            yield temporary
    except OSError as error:
        raise FlightError(
            format_os_error(
                target, error, "check the path, the permissions and the space on the disk"
            )
        ) from error


@contextlib.contextmanager
def atomic_flight_folder(folder: Path | str) -> Iterator[Path]:
    """Give a folder to fill with a flight, and put it in place as a whole if all went well.

    An error tells of the folder by the name that it was to have.
    """
    target = Path(folder)
    made = target
    try:
        with files.atomic_folder(target) as made:
            made.chmod(made.stat().st_mode & files.GROUP_FOLDER_MODE)
            yield made
    except (OSError, FlightError) as error:
        refused = error if isinstance(error, OSError) else error.__cause__
        beside = made == target or str(made) in str(error) or _disk_is_full(error)
        if not isinstance(refused, OSError) or not beside:
            raise
        place = "choose a folder with write permission and disk space"
        raise FlightError(
            format_os_error(f"the flight folder {target}", refused, place, verb="made")
        ) from error


def _disk_is_full(error: Exception) -> bool:
    full = DISK_FULL_ERRNOS | {errno.EFBIG}
    return isinstance(error, OSError) and error.filename is None and error.errno in full


def write_flight_file(path: Path | str, content: bytes | str) -> Path:
    """Write a whole file; if the disk refuses, what stood at `path` still stands."""
    with atomic_flight_file(path) as temporary:
        temporary.write_bytes(content.encode("utf-8") if isinstance(content, str) else content)
    return Path(path)


def copy_atomically(source: Path | str, target: Path | str) -> Path:
    """Copy a file of any size, so that a reader never meets half of it."""
    with atomic_flight_file(target) as temporary, temporary.open("wb") as copy:
        try:
            with Path(source).open("rb") as stream:
                shutil.copyfileobj(stream, copy, 1 << 20)
        except OSError as error:
            raise FlightError(
                f"{source} cannot be copied to {target} ({error.strerror}); check the paths, the "
                "permissions and the space on the disk"
            ) from error
    return Path(target)

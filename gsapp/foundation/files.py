"""Writing files so that a reader never meets half of one, and which files of a folder are ours."""

from __future__ import annotations

import contextlib
import fnmatch
import json
import os
import secrets
import shutil
import stat
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from gsapp.foundation.errors import GroundStationError, UnknownNameError
from gsapp.foundation.name_suggestions import did_you_mean

_FULL_FSYNC: int | None = None
if sys.platform != "win32":
    import fcntl

    _FULL_FSYNC = getattr(fcntl, "F_FULLFSYNC", None)

GROUP_FILE_MODE = 0o660
GROUP_FOLDER_MODE = 0o770
"""Rights of what a crew shares, before the user's mask: flights are nothing for everyone."""

_PATIENCE = 1.0
"""Seconds for which what others have open is tried to be renamed on Windows."""
_PAUSE = 0.01
"""Seconds between two tries."""
_SYSTEM_FILES = frozenset({".ds_store", "thumbs.db", "desktop.ini"})
"""What file managers lay into folders that were looked at, in small letters."""


def format_json(result: object) -> str:
    """Return a result as JSON: SI units, absent = null."""
    return json.dumps(result, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def is_system_file(path: Path | str) -> bool:
    """Return whether a system laid a file there by itself.

    Beside those of file managers macOS lays ``._name`` beside every file ``name`` on a disk that
    is not its own: a USB stick, a share.
    """
    name = Path(path).name
    return name.startswith("._") or name.casefold() in _SYSTEM_FILES


def path_lexists(path: Path | str) -> bool:
    """Return whether anything stands there, be it a link to nothing.

    Raise OSError if that cannot be told.
    """
    try:
        os.lstat(path)
    except (FileNotFoundError, NotADirectoryError):
        return False
    return True


def make_group_folder(path: Path) -> None:
    """Make a folder that user and group may enter, as far as the user's mask lets them.

    One that is there keeps its rights; missing parents get the usual ones. Raise OSError if the
    disk refuses.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    path.mkdir(mode=GROUP_FOLDER_MODE, exist_ok=True)


FileStamp = tuple[int, int, int]
"""By which another state of a file is told: time of change (ns), size, and which file it is."""


def file_stamp(path: Path) -> FileStamp | None:
    """Return the stamp of a file; None where none can be seen."""
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size, found.st_ino


def list_names(folder: Path) -> list[str]:
    """Return the names of all that a folder holds.

    Raise GroundStationError if it is missing, no folder, or may not be read.
    """
    try:
        return [path.name for path in folder.iterdir()]
    except OSError as error:
        if isinstance(error, FileNotFoundError) and folder.is_symlink():
            raise GroundStationError(
                f"{folder} is a link to a folder that is not there; correct or remove the link"
            ) from error
        raise GroundStationError(
            f"the folder {folder} cannot be read ({error.strerror}); check its permissions"
        ) from error


def list_files(folder: Path, pattern: str = "*") -> tuple[Path, ...]:
    """Return what a folder holds of a pattern, by name, without litter; nothing if it is missing.

    Raise GroundStationError if something stands there whose content cannot be told: what is kept in
    it would silently be replaced by what counts without it. A pipe or a device is no file: its
    reader would wait.
    """
    with contextlib.suppress(OSError):  # which is told below
        if not path_lexists(folder):
            return ()
    names = fnmatch.filter(list_names(folder), pattern)
    found = tuple(sorted(folder / name for name in names if not is_system_file(name)))
    for path in found:
        if _is_stream(path):
            raise GroundStationError(f"{path} is a pipe or a device, not a file; remove it")
    return found


def flush_to_disk(descriptor: int) -> None:
    """See what was written to an open file onto the disk itself, so that no power cut takes it.

    On macOS `os.fsync` leaves it in the memory of the drive; what empties that may take a tenth of
    a second. File systems that do not know of it get the usual flush. Raise OSError if the disk
    refuses.
    """
    if sys.platform != "win32" and _FULL_FSYNC is not None:
        try:
            fcntl.fcntl(descriptor, _FULL_FSYNC)
        except OSError:
            pass  # the usual flush says what is wrong, if anything is
        else:
            return
    os.fsync(descriptor)


@contextlib.contextmanager
def atomic_write(path: Path | str) -> Iterator[Path]:
    """Give a temporary file in the same folder; if all goes well, flush it to disk and rename it.

    For what is too long for memory, or written by a library that wants a file; otherwise see
    `write_atomically`. Missing parent folders are made. A link stays, and what it leads to is
    replaced. A pipe or a device, such as ``/dev/stdout``, takes the content as it is: nothing else
    may take its place. Raise OSError if the disk refuses; the former file then still stands,
    unchanged.
    """
    named = Path(path)
    with _name_error_target(named):
        if _is_stream(named):
            with tempfile.TemporaryDirectory() as folder:
                content = Path(folder) / "content"
                content.touch()
                yield content
                with content.open("rb") as source, named.open("wb") as stream:
                    shutil.copyfileobj(source, stream)
            return
        target = Path(os.path.realpath(named)) if named.is_symlink() else named
        with _name_error_target(target):
            target.parent.mkdir(parents=True, exist_ok=True)
            with _commit_file(_create_sibling_file(target), target) as temporary:
                yield temporary


def _is_stream(path: Path) -> bool:
    """Return whether something stands there that is neither a file nor a folder."""
    try:
        kind = path.stat().st_mode
    except OSError:
        return False  # what is wrong is told by the attempt to write
    return not (stat.S_ISREG(kind) or stat.S_ISDIR(kind))


def _create_sibling_file(target: Path) -> Path:
    """Make an empty file beside a path, with the rights that any new file gets.

    Those of `tempfile` are its maker's alone, and to open them afterward would pass over what the
    user wants new files to be (``umask``).
    """
    while True:
        made = target.parent / f".{target.name}.{secrets.token_hex(4)}"
        with contextlib.suppress(FileExistsError):
            os.close(os.open(made, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
            return made


@contextlib.contextmanager
def _name_error_target(target: Path) -> Iterator[None]:
    """Let an error of the disk name what was to be written, not its temporary name."""
    try:
        yield
    except OSError as error:
        hidden = error.filename is None or Path(error.filename).name.startswith(f".{target.name}.")
        if hidden and error.errno is not None:
            error.filename, error.filename2 = str(target), None
        raise


@contextlib.contextmanager
def _commit_file(temporary: Path, target: Path) -> Iterator[Path]:
    try:
        yield temporary
        with temporary.open("rb+") as stream:
            flush_to_disk(stream.fileno())
        if sys.platform != "win32":
            # Windows knows but one right here, and could not take away what must not be written.
            with contextlib.suppress(FileNotFoundError):
                temporary.chmod(target.stat().st_mode & 0o777)
        move_into_place(temporary, target)
    except BaseException:
        with contextlib.suppress(OSError):
            temporary.unlink()
        raise


def create_sibling_folder(target: Path | str) -> Path:
    """Make an empty folder beside a path, to be filled and put in its place by `move_into_place`.

    Its name begins with a dot. Whoever may read what is made there may read it. A folder of
    `tempfile` is its maker's alone, and stays so under Windows, where no mode opens it. Raise
    OSError if the disk refuses.
    """
    path = Path(target)
    while True:
        made = path.parent / f".{path.name}.{secrets.token_hex(4)}"
        with contextlib.suppress(FileExistsError):
            made.mkdir()
            return made


@contextlib.contextmanager
def atomic_folder(target: Path | str) -> Iterator[Path]:
    """Give a folder to fill, and put it in place as a whole if all goes well.

    One that is empty but for litter may be there already; missing parents are made. Raise OSError
    if the disk refuses, or something else stands there. Nothing is left behind.
    """
    path = Path(target)
    path.parent.mkdir(parents=True, exist_ok=True)
    made = create_sibling_folder(path)
    try:
        yield made
        if path.is_dir():
            for litter in filter(is_system_file, tuple(path.iterdir())):
                litter.unlink()
            path.rmdir()
        move_into_place(made, path)
    finally:
        shutil.rmtree(made, ignore_errors=True)


def move_into_place(temporary: Path, target: Path, patience: float = _PATIENCE) -> None:
    """Rename, on Windows again and again for `patience` seconds; raise OSError if the disk refuses.

    There neither a file that anyone has open just now, be it the scanner for viruses, can be
    replaced, nor a folder renamed that holds one. A file is replaced, a folder must not be there.
    """
    deadline = time.monotonic() + patience
    while True:
        try:
            temporary.replace(target)
        except PermissionError:
            if sys.platform != "win32" or time.monotonic() >= deadline:
                raise
            time.sleep(_PAUSE)
        else:
            return


def write_atomically(path: Path | str, content: bytes | str) -> Path:
    """Write a whole file under a temporary name, flush it to disk, and rename it into place.

    Missing parent folders are made; text is written as UTF-8 with line feeds. Raise OSError if the
    disk refuses; the former file then still stands, unchanged.
    """
    with atomic_write(path) as temporary:
        temporary.write_bytes(content.encode("utf-8") if isinstance(content, str) else content)
    return Path(path)


@dataclass(frozen=True, slots=True, kw_only=True)
class ShippedFiles:
    """A folder of TOML files that can be named without path or ending."""

    folder: Path  # Where they lie.
    kind: str  # What they are, in words.

    def names(self) -> tuple[str, ...]:
        return tuple(path.stem for path in list_files(self.folder, "*.toml"))

    def find(self, name_or_path: str | Path) -> Path:
        """Return the path for a path or a name; a file on disk goes before a name.

        Raise UnknownNameError if there is neither; near names are proposed.
        """
        path = Path(name_or_path)
        if path.is_file():
            return path
        text = str(name_or_path)
        if text in self.names():
            return self.folder / f"{text}.toml"
        hint = did_you_mean(text, self.names(), most=1)
        raise UnknownNameError(
            f"there is no {self.kind} file '{text}', and no shipped one has that name; "
            f"{hint + ' ' if hint else ''}shipped are: {', '.join(self.names())}"
        )

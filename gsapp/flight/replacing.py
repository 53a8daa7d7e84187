"""Writing a file too long for memory, or by a library that writes for itself, atomically."""

from __future__ import annotations

import contextlib
import os
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

from gsapp.foundation import FlightError


@contextlib.contextmanager
def replacing(path: Path | str) -> Iterator[Path]:
    """Give a temporary path to write to, and put it in place of `path` if all went well.

    Yields
    ------
    Path
        An empty file in the same folder, with the same ending.

    Raises
    ------
    FlightError
        If the disk refuses. What stood at `path` then still stands.
    """
    target = Path(path)
    temporary: Path | None = None
    try:
        if target.is_dir():
            raise FlightError(f"{target} is a folder, where a file is meant; name a file")
        target.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(
            prefix=f".{target.stem}.", suffix=target.suffix, dir=target.parent
        )
        os.close(handle)
        temporary = Path(name)
        yield temporary
        with temporary.open("rb+") as stream:
            os.fsync(stream.fileno())
        temporary.chmod(target.stat().st_mode & 0o777 if target.exists() else 0o644)
        temporary.replace(target)
    except OSError as error:
        raise FlightError(
            f"{target} cannot be written ({error.strerror or error}); check the path, the "
            "permissions and the space on the disk"
        ) from error
    finally:
        if temporary is not None:
            with contextlib.suppress(OSError):
                temporary.unlink()


def copy_atomically(source: Path | str, target: Path | str) -> Path:
    """Copy a file of any size, so that a reader never meets half of it.

    Raises
    ------
    FlightError
        If the source cannot be read or the target cannot be written.
    """
    with replacing(target) as temporary, temporary.open("wb") as copy:
        try:
            with Path(source).open("rb") as stream:
                shutil.copyfileobj(stream, copy, 1 << 20)
        except OSError as error:
            raise FlightError(
                f"{source} cannot be copied to {target} ({error.strerror}); check the paths, the "
                "permissions and the space on the disk"
            ) from error
    return Path(target)

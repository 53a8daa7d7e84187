"""Arrays in temporary files: what a long flight adds belongs to the disk, not to memory."""

from __future__ import annotations

import contextlib
import errno
import mmap
import os
import pickle
import tempfile
from pathlib import Path
from typing import IO, Any, TypeVar

import numpy as np
import numpy.typing as npt
import platformdirs

MIN_FILE_SIZE = 2**20
"""Bytes below which an array stays in memory."""
_STORE_STEP = 16 * 2**20  # bytes of the first file of an `MemmapStore`; each is twice the last
_ALIGNMENT = 64  # bytes
Stored = TypeVar("Stored")
# Errors of file systems that cannot reserve space; writing reserves it on all.
_CANNOT_RESERVE = (errno.EINVAL, errno.EOPNOTSUPP, errno.ENOSYS)


def temporary_folder() -> Path | None:
    """Return a folder on disk for temporary data, or None for the system's own choice.

    The system's temporary folder often lies in memory.
    """
    folder = platformdirs.user_cache_path("gsapp") / "history"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return None
    return folder if os.access(folder, os.W_OK) else None


def open_temporary_file() -> IO[bytes]:
    """Open a file without a name where the system allows it; it vanishes with the process.

    Raises
    ------
    OSError
        If no file can be created.
    """
    # Unbuffered: a map of the file sees at once what is written.
    return tempfile.TemporaryFile(prefix="gsapp-", dir=temporary_folder(), buffering=0)


def extend_file(file: IO[bytes], size: int) -> None:
    """Extend a file to a size (bytes) and reserve its blocks on the disk.

    A write into a map of blocks that are not reserved kills the process when the disk is full.

    Raises
    ------
    OSError
        If the disk is full.
    """
    held = os.fstat(file.fileno()).st_size
    if hasattr(os, "posix_fallocate"):
        try:
            os.posix_fallocate(file.fileno(), held, size - held)
        except OSError as error:
            if error.errno not in _CANNOT_RESERVE:
                raise
        else:
            return
    file.seek(held)
    remaining = size - held
    while remaining > 0:
        remaining -= file.write(bytes(min(remaining, 2**20))) or 0


def create_temporary_array(count: int, dtype: npt.DTypeLike) -> npt.NDArray[Any]:
    """Return an array of `count` items, shape (count,), in a temporary file if it is large.

    Its content is undefined. It lies in memory if it is small or no file can be created.
    """
    size = count * np.dtype(dtype).itemsize
    if size >= MIN_FILE_SIZE:
        with contextlib.suppress(OSError, ValueError), open_temporary_file() as file:
            extend_file(file, size)
            return np.frombuffer(mmap.mmap(file.fileno(), size), dtype=dtype)
    return np.empty(count, dtype=dtype)


class MemmapStore:
    """Keeps objects whose arrays lie in temporary files.

    Objects share files, so that many of them take few handles. A file vanishes with the last
    object in it.
    """

    def __init__(self) -> None:
        self._chunk = create_temporary_array(0, np.uint8)
        self._used = 0
        self._step = _STORE_STEP

    def store(self, value: Stored) -> Stored:
        """Return a copy of an object whose arrays are read-only and lie in a file.

        `value`: anything that can be pickled.
        """
        arrays: list[pickle.PickleBuffer] = []
        data = pickle.dumps(value, protocol=5, buffer_callback=arrays.append)
        contents = [one.raw() for one in arrays]
        needed = sum(one.nbytes + _ALIGNMENT for one in contents)
        if self._used + needed > self._chunk.size:
            self._chunk = create_temporary_array(max(needed, self._step), np.uint8)
            self._used, self._step = 0, 2 * self._step
        places = []
        for content in contents:
            stop = self._used + content.nbytes
            place = self._chunk[self._used : stop]
            place[:] = content
            places.append(place.data.toreadonly())
            self._used = stop + -stop % _ALIGNMENT
        kept: Stored = pickle.loads(data, buffers=places)  # noqa: S301 (written above)
        return kept

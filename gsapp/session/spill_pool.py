"""A growing array of numbers kept in a temporary file, so that a long flight costs no memory."""

from __future__ import annotations

import contextlib
import errno
import mmap
import os
import sys
import tempfile
from pathlib import Path
from typing import IO

import numpy as np
import platformdirs

from gsapp.quantities import FloatArray

_STEP = 8 * 2**20  # bytes; small enough that growing never holds up a screen update
# What a file system answers that cannot set room aside; writing does it everywhere.
_NOT_OFFERED = (errno.EINVAL, errno.EOPNOTSUPP, errno.ENOSYS)
_ITEM = 8  # bytes of a float64


def spill_folder() -> Path | None:
    """Return a folder on disk for temporary data, or None for the system's own choice.

    The system's temporary folder often lies in memory, which is what spilling is to spare.
    """
    folder = platformdirs.user_cache_path("gsapp") / "history"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return None
    return folder if os.access(folder, os.W_OK) else None


class SpillPool:
    """Numbers by position in one flat array that is mapped from a temporary file.

    The file has no name where the system allows it and vanishes with the process, however that
    ends. Should the disk be full, the pool goes on in memory and `on_disk` turns False.

    Attributes
    ----------
    values : ndarray, shape (capacity,)
        Every number allocated so far. Never keep a view of it: growing replaces it.
    on_disk : bool
        Whether the numbers lie in a file.
    """

    def __init__(self) -> None:
        self._file: IO[bytes] | None = None
        self._map: mmap.mmap | None = None
        self._used = 0
        self.values: FloatArray = np.empty(0)
        with contextlib.suppress(OSError):
            # Unbuffered: what is written must be seen by the map at once.
            self._file = tempfile.TemporaryFile(  # noqa: SIM115 - lives as long as the pool
                prefix="gsapp-", dir=spill_folder(), buffering=0
            )
        self.on_disk = self._file is not None

    def allocate(self, count: int) -> int:
        """Set `count` numbers aside, all NaN, and return the position of the first."""
        base = self._used
        while base + count > self.values.size:
            self._grow(max(_STEP, count * _ITEM))
        self._used = base + count
        self.values[base : self._used] = np.nan
        return base

    def release_memory(self) -> None:
        """Let go of the memory that holds pages of the file; they come back when looked at."""
        # Elsewhere than on Linux the advice may mean that the content is no longer wanted.
        if self._map is not None and self.on_disk and sys.platform == "linux":
            self._map.madvise(mmap.MADV_DONTNEED)

    def close(self) -> None:
        """Give the file back. The pool is empty afterwards."""
        self.values = np.empty(0)
        self._used = 0
        self._release_map()
        if self._file is not None:
            self._file.close()
            self._file = None

    def _grow(self, step: int) -> None:
        size = self.values.size * _ITEM + step
        if self._file is not None:
            try:
                self._extend_file(self._file, size)
                grown = mmap.mmap(self._file.fileno(), size)
            except (OSError, ValueError):
                grown = self._leave_disk(size)
        else:
            grown = self._leave_disk(size)
        # The former map goes, and with it the resident pages of what is long past: they come
        # back from the file one by one, and only if somebody looks at them.
        self.values = np.frombuffer(grown, dtype=np.float64)
        self._release_map()
        self._map = grown

    @staticmethod
    def _extend_file(file: IO[bytes], size: int) -> None:
        """Take real disk blocks: a map over a hole kills the process when the disk is full."""
        held = os.fstat(file.fileno()).st_size
        if hasattr(os, "posix_fallocate"):
            try:
                os.posix_fallocate(file.fileno(), held, size - held)
            except OSError as error:
                if error.errno not in _NOT_OFFERED:
                    raise
            else:
                return
        file.seek(held)
        remaining = size - held
        while remaining > 0:
            remaining -= file.write(bytes(min(remaining, 2**20))) or 0

    def _leave_disk(self, size: int) -> mmap.mmap:
        """Copy everything into memory that belongs to no file."""
        self.on_disk = False
        grown = mmap.mmap(-1, size)
        np.frombuffer(grown, dtype=np.float64)[: self._used] = self.values[: self._used]
        if self._file is not None:
            # The map keeps its own hold on the file until it is released.
            self._file.close()
            self._file = None
        return grown

    def _release_map(self) -> None:
        if self._map is not None:
            # A view somewhere keeps the map alive; it is then freed with that view.
            with contextlib.suppress(BufferError):
                self._map.close()
            self._map = None

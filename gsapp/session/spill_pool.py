"""A growing array of numbers kept in a temporary file, so that a long flight costs no memory."""

from __future__ import annotations

import contextlib
import mmap
import sys
from typing import IO

import numpy as np

from gsapp.foundation.temporary_arrays import extend_file, open_temporary_file
from gsapp.quantities import FloatArray

_STEP = 8 * 2**20  # bytes; small enough that growing never holds up a screen update
_ITEM = 8  # bytes of a float64


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
            self._file = open_temporary_file()
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
                extend_file(self._file, size)
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

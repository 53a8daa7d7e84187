"""Blocks in a file: samples that take no memory while nobody uses them."""

from __future__ import annotations

import threading
from typing import IO, Any, Final

import numpy as np

from gsapp.foundation.temporary_arrays import open_temporary_file
from gsapp.quantities.block import Block, FloatArray

_LOCK: Final = threading.Lock()
"""Held while a file is at a place: blocks share files, and threads blocks."""


class StoredBlock(Block):
    """A block whose samples are in a file and are read at every use.

    Pickled, it is a `Block` in memory.

    `file`: open for reading and appending; it must not be closed before the block is dropped.

    Raises `OSError` if the file cannot be written.
    """

    __slots__ = ("_count", "_file", "_offset")

    _count: int
    _file: IO[bytes]
    _offset: int

    def __init__(self, block: Block, file: IO[bytes]) -> None:
        # Channel by channel: most uses need one.
        columns = np.column_stack((block.times, block.values)).T.tobytes()
        with _LOCK:
            for name, value in (
                ("channels", block.channels),
                ("_count", len(block)),
                ("_file", file),
                ("_offset", file.seek(0, 2)),
            ):
                object.__setattr__(self, name, value)
            file.write(columns)

    def _read(self, first: int, count: int) -> FloatArray:
        """Return columns, shape (count, n); the first is time."""
        found = np.empty((count, self._count))
        self._read_into(found, first * self._count)
        found.setflags(write=False)
        return found

    def _read_into(self, found: FloatArray, place: int) -> None:
        """Fill an array with what follows the number of that place in the file."""
        with _LOCK:
            self._file.seek(self._offset + 8 * place)
            self._file.readinto(found)  # type: ignore[attr-defined]

    def _column(self, number: int) -> FloatArray:
        column: FloatArray = self._read(number, 1)[0]
        return column

    @property
    def times(self) -> FloatArray:
        return self._column(0)

    @property
    def values(self) -> FloatArray:
        return np.ascontiguousarray(self._read(1, len(self.channels)).T)

    def __len__(self) -> int:
        return self._count

    def __getitem__(self, channel_id: str) -> FloatArray:
        if channel_id not in self.channels:
            return Block.__getitem__(self, channel_id)  # raises
        return self._column(1 + self.channels.index(channel_id))

    def between(self, start: float, stop: float) -> Block:
        times = self.times
        low, high = np.searchsorted(times, (start, stop), side="left")
        values = np.empty((len(self.channels), high - low))
        for number, column in enumerate(values, start=1):
            self._read_into(column, number * self._count + low)
        return Block(
            channels=self.channels, times=times[low:high], values=np.ascontiguousarray(values.T)
        )

    def in_memory(self) -> Block:
        return Block.unchecked(self.channels, self.times, self.values)

    def __reduce__(self) -> tuple[Any, ...]:
        return Block.unchecked, (self.channels, self.times, self.values)


def block_in_file(block: Block) -> Block:
    """Return a block with its samples in a temporary file; the block itself where none can be made.

    The file vanishes with the block.
    """
    try:
        return StoredBlock(block, open_temporary_file())
    except OSError:
        return block

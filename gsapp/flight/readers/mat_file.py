"""MATLAB's ``.mat`` files of version 5 to 7, read by SciPy once their sizes are known.

Headers tell the size of every array before it is unpacked. The format: MathWorks, "MAT-File
Format", level 5.
"""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import IO, Any, Protocol

import numpy as np

from gsapp.flight.read_limits import NUMBER_BYTES, check_read_size
from gsapp.flight.readers.reader_process import ProgressCallback
from gsapp.foundation import FlightError

_HEADER = 128
_MATRIX, _COMPRESSED = 14, 15
"""Types of elements."""
_OPAQUE = 17
"""Class of an array whose header has no sizes."""
_COMPLEX = 0x800
_DEEPEST = 32
"""Structures inside structures."""
_CHUNK = 1 << 16
_HDF5 = b"\x89HDF\r\n\x1a\n"
_HDF5_AT = 512


def read_mat_content(path: Path, limit: int, progress: ProgressCallback) -> dict[str, Any]:
    """Return what a ``.mat`` file of any version holds: numbers, texts, lists and dicts.

    Raise `FlightError` where that takes more than `limit` bytes.
    """
    with path.open("rb") as stream:
        head = stream.read(_HDF5_AT + len(_HDF5))
    if head.startswith((b"MATLAB 7.3", _HDF5)) or head[_HDF5_AT:] == _HDF5:
        from gsapp.flight.readers.mat_hdf5 import read_mat_hdf5

        return read_mat_hdf5(path, limit, progress)
    if not head.startswith(b"MATLAB 5.0"):
        raise FlightError(f"{path} is not a MATLAB .mat file of version 5 to 7; name another file")
    with path.open("rb") as stream:
        _check_sizes(path, stream, limit, progress)

    from scipy.io import loadmat

    content: dict[str, Any] = loadmat(path, simplify_cells=True)
    return {
        str(name): plain
        for name, value in content.items()
        if not name.startswith("__") and (plain := _plain(value)) is not None
    }


def _plain(value: Any) -> Any:
    """Return a value without the classes of SciPy; None for what is neither number nor text."""
    if isinstance(value, Mapping):
        return {str(name): one for name, each in value.items() if (one := _plain(each)) is not None}
    if isinstance(value, (list, tuple)):
        return [_plain(one) for one in value]
    if isinstance(value, np.ndarray) and type(value) is np.ndarray:
        if value.dtype.kind in "biufcU":
            return value
        if value.dtype.kind == "O":
            # Not as an array: NumPy would make one of numbers of equal sizes.
            return [_plain(one) for one in value.reshape(-1)]
    return value if isinstance(value, (bool, int, float, complex, str)) else None


class _Source(Protocol):
    """Bytes one after the other."""

    position: int

    def take(self, count: int) -> bytes:
        """Return the next bytes; raise EOFError if there are not so many."""
        ...

    def skip(self, count: int) -> None:
        """Pass over bytes; raise EOFError if there are not so many."""
        ...


class _FileSource:
    """The bytes of the file itself."""

    def __init__(self, stream: IO[bytes], start: int, end: int) -> None:
        self._stream = stream
        self._end = end
        self.position = start
        stream.seek(start)

    def take(self, count: int) -> bytes:
        self.skip(0)
        data = self._stream.read(count)
        if len(data) < count:
            raise EOFError
        self.position += count
        return data

    def skip(self, count: int) -> None:
        if self.position + count > self._end:
            raise EOFError
        self.position += count
        self._stream.seek(self.position)


class _InflatedSource:
    """The bytes of a compressed element, unpacked a little at a time and not kept."""

    def __init__(self, source: _FileSource, count: int, told: Callable[[int], None]) -> None:
        self._source = source
        self._left = count
        self._told = told
        self._unpacker = zlib.decompressobj()
        self._packed = self._ready = b""
        self.position = 0

    def take(self, count: int) -> bytes:
        parts: list[bytes] = []
        while count:
            part = self._next(count)
            parts.append(part)
            count -= len(part)
        return b"".join(parts)

    def skip(self, count: int) -> None:
        while count:
            count -= len(self._next(count))

    def _next(self, most: int) -> bytes:
        while not self._ready:
            if not self._packed:
                size = min(self._left, _CHUNK)
                self._packed = self._source.take(size)
                self._left -= size
            if self._unpacker.eof or (not self._packed and not self._left):
                raise EOFError
            self._ready = self._unpacker.decompress(self._packed, _CHUNK)
            self._packed = self._unpacker.unconsumed_tail
            self._told(len(self._ready))
        part, self._ready = self._ready[:most], self._ready[most:]
        self.position += len(part)
        return part


def _check_sizes(path: Path, stream: IO[bytes], limit: int, progress: ProgressCallback) -> None:
    """Raise `FlightError` where the arrays of a file take more than `limit` bytes."""
    size = path.stat().st_size
    source = _FileSource(stream, 0, size)
    head = source.take(_HEADER)
    walk = _SizeWalk(path, "<" if head[126:128] == b"IM" else ">", limit)
    while size - source.position >= _SizeWalk.TAG:
        progress(0.9 * source.position / size)
        kind, count, _ = walk.tag(source)
        start = source.position
        if kind == _COMPRESSED:
            inner = _InflatedSource(source, count, walk.unpacked)
            walk.element(inner)
        elif kind == _MATRIX:
            walk.matrix(source, count, 0)
        source.skip(start + count - source.position)
    progress(0.9)


class _SizeWalk:
    """Adds up what the arrays of a file take, by their headers."""

    TAG = 8

    def __init__(self, path: Path, order: str, limit: int) -> None:
        self._path = path
        self._words = struct.Struct(order + "2I")
        self._sizes = order + "i"
        self._limit = limit
        self._bytes = self._unpacked = 0

    def unpacked(self, count: int) -> None:
        self._unpacked += count
        check_read_size(self._path, self._unpacked, self._limit)

    def tag(self, source: _Source) -> tuple[int, int, bytes]:
        """Return type and bytes of the next element; where it is short, also its content."""
        data = source.take(self.TAG)
        kind, count = self._words.unpack(data)
        if kind >> 16:
            return kind & 0xFFFF, 0, data[4 : 4 + (kind >> 16)]
        return kind, count, b""

    def element(self, source: _Source, depth: int = 0) -> None:
        kind, count, _ = self.tag(source)
        if kind == _MATRIX:
            self.matrix(source, count, depth)
        else:
            source.skip(-(-count // 8) * 8)

    def matrix(self, source: _Source, length: int, depth: int) -> None:
        if depth > _DEEPEST:
            raise ValueError("structures are nested too deeply")
        end = source.position + length
        if not length:
            return
        self.tag(source)
        flags, _ = self._words.unpack(source.take(self.TAG))
        if flags & 0xFF != _OPAQUE:
            _, count, short = self.tag(source)
            data = short or source.take(-(-count // 8) * 8)[:count]
            sizes = [max(one, 0) for (one,) in struct.iter_unpack(self._sizes, data)]
            self._bytes += math.prod(sizes) * NUMBER_BYTES * (2 if flags & _COMPLEX else 1)
            check_read_size(self._path, self._bytes, self._limit)
        if flags & 0xFF > 5 and flags & 0xFF < 16:
            source.skip(end - source.position)  # numbers
        while end - source.position >= self.TAG:
            self.element(source, depth + 1)
        if source.position > end:
            raise ValueError("an array is longer than its element")

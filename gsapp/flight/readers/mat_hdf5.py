"""MATLAB's ``.mat`` files of version 7.3, which are HDF5, read by h5py where it is installed.

A structure is a group, an array a dataset with its axes in reverse order. A cell array, and each
member of an array of structures, is a dataset of references to what it holds. How MATLAB marks
them (``MATLAB_class``, ``MATLAB_empty``): "MAT-File Versions" in its documentation.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from gsapp.flight.read_limits import NUMBER_BYTES, check_read_size
from gsapp.flight.readers.reader_process import ProgressCallback
from gsapp.foundation import FlightError

_OWN = "#"
"""Begins the names of what MATLAB keeps for itself (``#refs#``)."""
_OBJECT = 1024
"""Bytes that any object takes, which many references may name."""


def read_mat_hdf5(file: Path, limit: int, progress: ProgressCallback) -> dict[str, Any]:
    """Read all variables, as `scipy.io.loadmat` with ``simplify_cells`` reads older versions.

    A structure is a dict, an array of structures a list of dicts, a text a str; axes of length 1
    are dropped. What is neither number nor text is left out. Raise `FlightError` where they take
    more than `limit` bytes.
    """
    try:
        import h5py
    except ImportError as error:
        raise FlightError(
            f"{file} is of version 7.3, which is HDF5; reading it needs h5py, which is not "
            "installed; install it with 'pip install gsapp-ground-station[mat73]', or save the "
            "file in MATLAB with save('file.mat', '-v7')"
        ) from error
    with file.open("rb") as stream, h5py.File(stream, "r") as root:
        return _Reader(file, root, limit, progress).members(root)


class _Reader:
    """Reads the objects of one file; those that others refer to are found from its root."""

    def __init__(self, file: Path, root: Any, limit: int, progress: ProgressCallback) -> None:
        self._file = file
        self._root = root
        self._limit = limit
        self._progress = progress
        self._bytes = 0

    def members(self, group: Any) -> dict[str, Any]:
        return {
            str(name): value
            for name, item in group.items()
            if not name.startswith(_OWN) and (value := self._value(item)) is not None
        }

    def _value(self, item: Any) -> Any:
        """Return a variable, a member or what a reference points to; None for what is no data."""
        self._add_size(_OBJECT)
        if hasattr(item, "items"):
            return self._structure(item)
        kind = _class_of(item)
        if item.attrs.get("MATLAB_empty", 0):
            return "" if kind == "char" else np.empty(0)
        self._add_size(NUMBER_BYTES * (item.size or 0))
        if kind == "cell":
            return [self._value(self._root[reference]) for reference in item[()].T.reshape(-1)]
        if item.dtype.kind not in "fiub":
            return None
        array = np.squeeze(np.asarray(item[()]).T)
        if kind == "char":
            return "".join(map(chr, array.reshape(-1).tolist()))
        return array.item() if array.ndim == 0 else array

    def _add_size(self, count: int) -> None:
        self._bytes += count
        check_read_size(self._file, self._bytes, self._limit)
        self._progress(None)

    def _structure(self, group: Any) -> Any:
        """Return one structure; a list of them where each member is a dataset of references."""
        arrays = [item for item in group.values() if _is_array_of_structures(item)]
        if not arrays or len(arrays) != len(group):
            return self.members(group)
        columns = {
            str(name): [self._value(self._root[reference]) for reference in item[()].T.reshape(-1)]
            for name, item in group.items()
        }
        return [
            {name: values[place] for name, values in columns.items() if values[place] is not None}
            for place in range(min(len(values) for values in columns.values()))
        ]


def _class_of(item: Any) -> str:
    kind = item.attrs.get("MATLAB_class", b"")
    return kind.decode("ascii", "replace") if isinstance(kind, bytes) else str(kind)


def _is_array_of_structures(item: Any) -> bool:
    return not hasattr(item, "items") and item.dtype.kind == "O" and not _class_of(item)

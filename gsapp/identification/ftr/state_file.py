"""Files that hold the state of an FTR: named arrays, and what they belong to."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import numpy.typing as npt

from gsapp.foundation import FlightError, write_atomically

STATE_FILE_VERSION = 3

ArrayTable = dict[str, npt.NDArray[np.generic]]
"""Arrays by name."""


def add_prefix(parts: Mapping[str, Mapping[str, npt.NDArray[np.generic]]]) -> ArrayTable:
    """Return the arrays of several parts in one table, each below the name of its part."""
    return {
        f"{part}.{name}": array for part, arrays in parts.items() for name, array in arrays.items()
    }


def strip_prefix(part: str, table: Mapping[str, npt.NDArray[np.generic]]) -> ArrayTable:
    """Return the entries of a table below a name, by the rest of their names."""
    start = part + "."
    return {name.removeprefix(start): x for name, x in table.items() if name.startswith(start)}


def write_state(path: Path, about: Mapping[str, object], table: ArrayTable) -> None:
    """Write a table, and what it belongs to, to an ``.npz`` file."""
    buffer = io.BytesIO()
    whole = {**table, "about": np.array(json.dumps(about))}
    np.savez_compressed(buffer, allow_pickle=False, **whole)
    write_atomically(path, buffer.getvalue())


def read_state(path: Path, about: Mapping[str, object]) -> ArrayTable:
    """Return the table that `write_state` wrote.

    Raises `FlightError` if the file cannot be read, or belongs to something else.
    """
    try:
        with np.load(path, allow_pickle=False) as stored:
            table: ArrayTable = {name: stored[name] for name in stored.files}
        theirs = json.loads(str(table.pop("about")))
    except Exception as error:
        # A damaged archive makes zipfile, NumPy and JSON raise whatever they meet.
        raise FlightError(
            f"{path} holds no state of FTR that can be read ({error}); start FTR again"
        ) from error
    mine = json.loads(json.dumps(about))
    different = sorted(key for key in mine if theirs.get(key) != mine[key])
    if different:
        raise FlightError(
            f"the state in {path} was saved with other {' and '.join(different)}; use the same, "
            "or restart FTR"
        )
    return table

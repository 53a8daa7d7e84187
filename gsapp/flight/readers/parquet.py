"""Parquet tables, read by pyarrow where it is installed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from gsapp.foundation import FlightError
from gsapp.quantities import FloatArray


def read_parquet_columns(path: Path | str) -> tuple[dict[str, FloatArray], dict[str, str]]:
    """Read the columns of numbers of a Parquet file.

    Returns
    -------
    columns : dict of str to ndarray, shape (n,)
        By name; null becomes NaN. Columns of text and times of day are passed over.
    units : dict of str to str
        What the metadata of the columns states under ``unit``.

    Raises
    ------
    FlightError
        If pyarrow is not installed, or the file cannot be read.
    """
    file = Path(path)
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError as error:
        raise FlightError(
            "reading Parquet needs pyarrow, which is not installed; install it with "
            "'pip install gsapp-ground-station[parquet]'"
        ) from error
    try:
        # Through a handle: given a path, Arrow would also read folders and other places.
        with file.open("rb") as stream:
            table = parquet.read_table(stream)
    except (OSError, pyarrow.ArrowException) as error:
        raise FlightError(
            f"{file} cannot be read as Parquet ({_first_line(error)}); write it again"
        ) from error
    columns: dict[str, FloatArray] = {}
    units: dict[str, str] = {}
    for field, column in zip(table.schema, table.columns, strict=True):
        if not (pyarrow.types.is_floating(field.type) or pyarrow.types.is_integer(field.type)):
            continue
        numbers = column.cast(pyarrow.float64()).to_numpy(zero_copy_only=False)
        columns[field.name] = np.array(numbers, dtype=np.float64)
        metadata: dict[bytes, bytes] = field.metadata or {}
        if b"unit" in metadata:
            units[field.name] = metadata[b"unit"].decode("utf-8", "replace")
    return columns, units


def _first_line(error: Any) -> str:
    return str(error).splitlines()[0] if str(error) else type(error).__name__

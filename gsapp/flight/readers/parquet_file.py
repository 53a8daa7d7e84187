"""Columns of Parquet files, read by pyarrow once their sizes are known."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import numpy as np

from gsapp.flight.read_limits import NUMBER_BYTES, check_read_size
from gsapp.flight.readers.reader_process import ProgressCallback
from gsapp.foundation import FlightError
from gsapp.quantities import FloatArray


def load_pyarrow() -> tuple[ModuleType, ModuleType]:
    """Return pyarrow and its module for Parquet files, which are installed on request only."""
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError as error:
        raise FlightError(
            "Parquet files need pyarrow, which is not installed. Install it with 'python3 "
            "packaging/bootstrap.py setup parquet' in the folder of the clone, or with 'pip "
            "install gsapp-ground-station[parquet]'. Files .csv and .mat need no installation"
        ) from error
    return pyarrow, parquet


def read_parquet_content(
    path: Path, limit: int, progress: ProgressCallback
) -> tuple[dict[str, FloatArray], dict[str, str]]:
    """Return the columns of numbers of a file, shape (n,), and the ``unit`` of each.

    Raise `FlightError` where they take more than `limit` bytes.
    """
    pyarrow, parquet = load_pyarrow()
    # Through a handle: given a path, Arrow would also read folders and other places.
    with path.open("rb") as stream:
        file = parquet.ParquetFile(stream)
        fields = [
            field
            for field in file.schema_arrow
            if pyarrow.types.is_floating(field.type) or pyarrow.types.is_integer(field.type)
        ]
        groups = [file.metadata.row_group(index) for index in range(file.num_row_groups)]
        rows = sum(max(group.num_rows, 0) for group in groups)
        check_read_size(path, rows * len(fields) * NUMBER_BYTES, limit)
        check_read_size(path, sum(max(group.total_byte_size, 0) for group in groups), limit)
        names = [field.name for field in fields]
        parts: dict[str, list[FloatArray]] = {name: [np.empty(0)] for name in names}
        for index in range(len(groups)):
            progress(index / len(groups))
            table = file.read_row_group(index, columns=names, use_threads=False)
            for name in parts:
                numbers = table.column(name).cast(pyarrow.float64())
                parts[name].append(numbers.to_numpy(zero_copy_only=False).astype(np.float64))
    units = {
        field.name: field.metadata[b"unit"].decode("utf-8", "replace")
        for field in fields
        if b"unit" in (field.metadata or {})
    }
    return {name: np.concatenate(each) for name, each in parts.items()}, units

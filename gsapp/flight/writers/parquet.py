"""Writing Parquet: a column for each channel, its unit in the column's metadata."""

from __future__ import annotations

from pathlib import Path

from gsapp.flight.atomic_files import atomic_flight_file
from gsapp.flight.certificates import uncalibrated_columns
from gsapp.flight.writers.column_units import ColumnUnits, ProgressCallback
from gsapp.foundation import FlightError
from gsapp.quantities import Block, channel

_ROWS_AT_ONCE = 2**17
"""A group of rows in the file: twenty minutes at 100 Hz."""


def write_parquet(
    path: Path | str, block: Block, system: str = "us", told: ProgressCallback | None = None
) -> Path:
    """Write a block as Parquet, atomically. Missing samples are null.

    Parameters
    ----------
    system : {"us", "si", "base"}
        Units of the columns; each column's metadata states its own under ``unit``. Where an
        instrument had no certificate, that of its volts names it under ``uncalibrated``.
    told : callable, optional
        See `gsapp.flight.writers.write_block`.

    Raises
    ------
    FlightError
        If pyarrow is not installed, or the file cannot be written.
    """
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError as error:
        raise FlightError(
            "writing Parquet needs pyarrow, which is not installed; install it with "
            "'pip install gsapp-ground-station[parquet]', or export to csv or mat"
        ) from error
    layout = ColumnUnits.from_channels(block.channels, system)
    fields = [pyarrow.field("time", pyarrow.float64(), metadata={"unit": "s"})]
    columns = [pyarrow.array(block.times)]
    lacking = uncalibrated_columns(layout.channels)
    for place, (name, unit) in enumerate(zip(layout.channels, layout.units, strict=True)):
        metadata = {"unit": unit, "description": channel(name).description}
        if name in lacking:
            metadata["uncalibrated"] = lacking[name]
        fields.append(pyarrow.field(name, pyarrow.float64(), metadata=metadata))
        values = layout.convert_column(place, block.values[:, place])
        columns.append(pyarrow.array(values, from_pandas=True))
    table = pyarrow.Table.from_arrays(columns, schema=pyarrow.schema(fields))
    with (
        atomic_flight_file(path) as temporary,
        # Through a stream: what Arrow says of a disk that refuses tells no program why.
        temporary.open("wb") as stream,
        parquet.ParquetWriter(stream, table.schema, compression="zstd") as writer,
    ):
        for start in range(0, max(len(block), 1), _ROWS_AT_ONCE):
            writer.write_table(table.slice(start, _ROWS_AT_ONCE))
            if told is not None:
                told(min((start + _ROWS_AT_ONCE) / max(len(block), 1), 1.0))
    return Path(path)

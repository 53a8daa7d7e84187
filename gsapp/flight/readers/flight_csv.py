"""Flight CSV: one header line of ``id [unit]``, one column of time, any subset of channels."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from gsapp.flight.readers.columns import (
    TIME,
    ColumnFlight,
    check_times,
    is_foreign_header,
    parse_header,
)
from gsapp.flight.readers.delimited_table import read_delimited_table
from gsapp.foundation import UnmappedError
from gsapp.foundation.name_suggestions import format_names
from gsapp.quantities import Block


def read_flight_csv(path: Path | str) -> ColumnFlight:
    """Read a Flight CSV.

    Parameters
    ----------
    path : Path or str
        The file. Cells that are empty or ``nan`` are missing samples.

    Raises
    ------
    FileProblemsError
        If it holds mistakes; the first twenty are named with line, column and remedy.
    UnmappedError
        If it is a table of another program.
    """
    table = read_delimited_table(path)
    if is_foreign_header(table.names):
        raise UnmappedError(
            f"{path} does not assign columns to channels and units; give a channel map of "
            "format 'table' with --map, or start with a header such as 'time [s],alpha [deg],q "
            f"[deg/s]'. Columns: {format_names(table.names, 12)}"
        )
    columns = parse_header(table.path, f"line {table.header_line}", table.names)
    values, lines = table.numbers()
    place = next(index for index, column in enumerate(columns) if column.id == TIME)
    times = columns[place].to_si(values[:, place])
    check_times(
        table.path,
        times,
        lambda row: f"line {lines[row]}, column {place + 1} ({table.names[place]})",
    )
    channels = [index for index in range(len(columns)) if index != place]
    # Column by column into the array that stays, so that a long flight is held only once more.
    si = np.empty((times.size, len(channels)))
    for target, index in enumerate(channels):
        si[:, target] = columns[index].to_si(values[:, index])
    block = Block(channels=tuple(columns[index].id for index in channels), times=times, values=si)
    return ColumnFlight(block=block, columns=columns, remarks=table.remarks)

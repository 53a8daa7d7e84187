"""Writing MATLAB's ``.mat``, version 5: a variable for each channel, units in a structure."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from gsapp.flight.atomic_files import atomic_flight_file
from gsapp.flight.certificates import uncalibrated_columns
from gsapp.flight.writers.column_units import ColumnUnits, ProgressCallback
from gsapp.foundation import FlightError
from gsapp.quantities import Block

_MOST_BYTES = 2**31 - 1


def variable_name(channel_id: str) -> str:
    """Return the MATLAB variable of a channel: ``q.2`` becomes ``q_2``."""
    return channel_id.replace(".", "_")


def write_mat(
    path: Path | str, block: Block, system: str = "us", told: ProgressCallback | None = None
) -> Path:
    """Write a block as a ``.mat`` file, atomically.

    Variables are columns, ``time`` in s among them; ``units.alpha`` holds ``'deg'``. Where an
    instrument had no certificate, so that there are only its volts, ``uncalibrated`` names it.

    Parameters
    ----------
    system : {"us", "si", "base"}
        Units of the variables.
    told : callable, optional
        See `gsapp.flight.writers.write_block`.

    Raises
    ------
    FlightError
        If the file cannot be written, or the flight is too long for the format.
    """
    from scipy.io import savemat  # a tenth of a second

    if len(block) * 8 > _MOST_BYTES:
        raise FlightError(
            f"{len(block)} samples do not fit a .mat file of version 5 (2 GB a variable); cut "
            "the flight, or export it as Parquet"
        )
    layout = ColumnUnits.from_channels(block.channels, system)
    content: dict[str, Any] = {"time": block.times[:, np.newaxis]}
    units: dict[str, str] = {"time": "s"}
    for place, (name, unit) in enumerate(zip(layout.channels, layout.units, strict=True)):
        content[variable_name(name)] = layout.convert_column(place, block.values[:, place])[
            :, np.newaxis
        ]
        units[variable_name(name)] = unit
    content["units"] = units
    lacking = uncalibrated_columns(layout.channels)
    if lacking:
        content["uncalibrated"] = ", ".join(lacking.values())
    with atomic_flight_file(path) as temporary, temporary.open("wb") as stream:
        for count, (name, value) in enumerate(content.items(), start=1):
            # To a stream that holds variables already it adds one.
            savemat(stream, {name: value}, long_field_names=True, do_compression=True)
            if told is not None:
                told(count / len(content))
    return Path(path)

"""Writing flights: Flight CSV, MATLAB, Parquet."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np

from gsapp.flight.atomic_files import atomic_flight_file
from gsapp.flight.certificates import uncalibrated_columns
from gsapp.flight.readers.parquet_file import load_pyarrow
from gsapp.foundation import FlightError, UnknownNameError
from gsapp.quantities import Block, FloatArray, channel, from_si, is_raw_channel

UnitSystem = Literal["us", "si", "base"]
"""``us``: deg, ft/s, g, lbf/ft^2, as flight-test reports use them; ``si``: deg, m/s, g, kPa, what
the window shows as SI; ``base``: rad, m/s, m/s^2, Pa, K, bit for bit as held inside."""

ProgressCallback = Callable[[float], object]
"""Receives the share of a file that is written; may raise to end the writing."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ColumnUnits:
    """Columns of a file: channel ids and the unit of each."""

    channels: tuple[str, ...]
    """Without time, which every file has first, in s."""
    units: tuple[str, ...]
    """As long as `channels`."""

    @staticmethod
    def from_channels(channels: Sequence[str], system: str) -> ColumnUnits:
        """Lay out channels in a system of units."""
        if system not in get_args(UnitSystem):
            raise UnknownNameError(
                f"no system of units is called '{system}'; use one of: us, si, base"
            )
        return ColumnUnits(
            channels=tuple(channels), units=tuple(_unit(name, system) for name in channels)
        )

    def convert_column(self, place: int, values: FloatArray) -> FloatArray:
        """Convert SI values of the column at `place` to its unit."""
        return from_si(values, self.units[place], channel(self.channels[place]).quantity)

    def is_unconverted(self, place: int) -> bool:
        return self.units[place] == channel(self.channels[place]).unit


def _unit(channel_id: str, system: str) -> str:
    spec = channel(channel_id)
    # A ratio is written as such, 0 to 1; percent is for the screen.
    if system == "base" or spec.quantity == "ratio":
        return spec.unit
    return spec.us_display if system == "us" else spec.si_display


_ROWS_AT_ONCE = 4096
# Two digits fewer than a double can hold: those that converting there and back may shake.
_CONVERTED_DIGITS = 15


def write_flight_csv(
    path: Path | str, block: Block, system: str = "us", told: ProgressCallback | None = None
) -> Path:
    """Write a block as Flight CSV, atomically.

    Values in SI, and times, are written with as many digits as bring back the very same number;
    converted ones with 15 digits, so that 1.2 deg does not become 1.2000000000000002. Missing
    samples are empty cells.
    """
    layout = ColumnUnits.from_channels(block.channels, system)
    header = ["time [s]"] + [
        f"{name} [{unit}]" for name, unit in zip(layout.channels, layout.units, strict=True)
    ]
    with (
        atomic_flight_file(path) as temporary,
        temporary.open("w", encoding="utf-8", newline="\n") as stream,
    ):
        stream.write(",".join(header) + "\n")
        for start in range(0, len(block), _ROWS_AT_ONCE):
            rows = slice(start, start + _ROWS_AT_ONCE)
            columns: list[Iterator[str]] = [map(repr, block.times[rows].tolist())]
            columns.extend(
                _cells(
                    layout.convert_column(place, block.values[rows, place]),
                    layout.is_unconverted(place),
                )
                for place in range(len(layout.channels))
            )
            stream.writelines(",".join(row) + "\n" for row in zip(*columns, strict=True))
            if told is not None:
                told(min(rows.stop / len(block), 1.0))
    return Path(path)


def _cells(values: FloatArray, exact: bool) -> Iterator[str]:
    missing = np.isnan(values).tolist()
    if exact:
        return ("" if gone else repr(v) for v, gone in zip(values.tolist(), missing, strict=True))
    form = f"%.{_CONVERTED_DIGITS}g"
    return ("" if gone else form % v for v, gone in zip(values.tolist(), missing, strict=True))


_MOST_BYTES = 2**31 - 1


def variable_name(channel_id: str) -> str:
    """Return the MATLAB variable of a channel: ``q.2`` becomes ``q_2``, ``M[0].f`` ``M_0_f``."""
    return re.sub(r"\W+", "_", channel_id).strip("_")


def write_mat(
    path: Path | str, block: Block, system: str = "us", told: ProgressCallback | None = None
) -> Path:
    """Write a block as a ``.mat`` file, atomically.

    Variables are columns, ``time`` in s among them; ``units.alpha`` holds ``'deg'``. Where an
    instrument had no certificate, so that there are only its volts, ``uncalibrated`` names it.
    ``names.M_0_f`` holds what a raw channel is called.
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
    for index, (name, unit) in enumerate(zip(layout.channels, layout.units, strict=True)):
        content[variable_name(name)] = layout.convert_column(index, block.values[:, index])[
            :, np.newaxis
        ]
        units[variable_name(name)] = unit
    content["units"] = units
    names = {variable_name(name): name for name in layout.channels if is_raw_channel(name)}
    if names:
        content["names"] = names
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


_GROUP_ROWS = 2**17
"""A group of rows in the file: twenty minutes at 100 Hz."""


def write_parquet(
    path: Path | str, block: Block, system: str = "us", told: ProgressCallback | None = None
) -> Path:
    """Write a block as Parquet, atomically. Missing samples are null.

    Each column's metadata states its ``unit``. Where an instrument had no certificate, that of its
    volts names it under ``uncalibrated``.
    """
    pyarrow, parquet = load_pyarrow()
    layout = ColumnUnits.from_channels(block.channels, system)
    fields = [pyarrow.field("time", pyarrow.float64(), metadata={"unit": "s"})]
    columns = [pyarrow.array(block.times)]
    lacking = uncalibrated_columns(layout.channels)
    for index, (name, unit) in enumerate(zip(layout.channels, layout.units, strict=True)):
        metadata = {"unit": unit, "description": channel(name).description}
        if name in lacking:
            metadata["uncalibrated"] = lacking[name]
        fields.append(pyarrow.field(name, pyarrow.float64(), metadata=metadata))
        values = layout.convert_column(index, block.values[:, index])
        columns.append(pyarrow.array(values, from_pandas=True))
    table = pyarrow.Table.from_arrays(columns, schema=pyarrow.schema(fields))
    with (
        atomic_flight_file(path) as temporary,
        # Through a stream: what Arrow says of a disk that refuses tells no program why.
        temporary.open("wb") as stream,
        parquet.ParquetWriter(stream, table.schema, compression="zstd") as writer,
    ):
        for start in range(0, max(len(block), 1), _GROUP_ROWS):
            writer.write_table(table.slice(start, _GROUP_ROWS))
            if told is not None:
                told(min((start + _GROUP_ROWS) / max(len(block), 1), 1.0))
    return Path(path)


WRITERS: Mapping[str, Callable[[Path | str, Block, str, ProgressCallback | None], Path]] = {
    "csv": write_flight_csv,
    "mat": write_mat,
    "parquet": write_parquet,
}
"""Every format by its name."""


def write_block(
    path: Path | str, block: Block, to: str, units: str = "us", told: ProgressCallback | None = None
) -> Path:
    """Write a block in the format ``csv``, ``mat`` or ``parquet``, atomically.

    `units` are ``us``, ``si`` or ``base``. `told` receives the share that is written, several
    times; what it raises ends the writing, and leaves no file behind.
    """
    check_format(to)
    return WRITERS[to](path, block, units, told)


def check_format(to: str) -> None:
    """Raise `UnknownNameError` unless there is a format of that name."""
    if to not in WRITERS:
        raise UnknownNameError(
            f"flights are not written as '{to}'; use one of: {', '.join(WRITERS)}"
        )

"""CSV, ``.mat`` and Parquet files of other programs, their columns named by a channel map."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from gsapp.decoding.channel_map import TABLE, ChannelMap
from gsapp.flight.readers.columns import check_spacing
from gsapp.flight.readers.delimited_table import DelimitedTable, read_delimited_table
from gsapp.flight.readers.log_table import ForeignLog, LogTable, find_valid_times
from gsapp.flight.readers.matlab import read_mat_columns
from gsapp.flight.readers.parquet import read_parquet_columns
from gsapp.foundation import FileProblem, FileProblemsError, UnitError
from gsapp.foundation.name_suggestions import did_you_mean, format_names
from gsapp.quantities import FloatArray, normalize_unit, to_si

_CLOCKS = ("time", "t", "timestamp", "time_s", "times", "seconds", "sec")
_WITH_UNIT = re.compile(r"(?P<name>[^\[\]()]+?)\s*[\[(](?P<unit>[^\[\]()]*)[\])]\s*")
_ELEMENT = re.compile(r"(?P<name>.+)\[(?P<index>\d+)\]")


def read_table(path: Path | str, channel_map: ChannelMap) -> ForeignLog:
    """Read the columns that a channel map of format ``table`` names.

    Parameters
    ----------
    path : Path or str
        A ``.csv``, ``.mat`` or ``.parquet`` file.
    channel_map : ChannelMap
        Which columns; the others may hold anything.

    Returns
    -------
    ForeignLog
        One table for each clock: ``("table", "")`` for that of the map, ``("table", name)`` for
        a channel whose entry names its own.

    Raises
    ------
    FileProblemsError
        If columns are missing or not numbers; near names are proposed.
    FlightError
        If the file cannot be read.
    """
    file = Path(path)
    names, fetch, remarks = _open_table(file)
    wanted = _requested_columns(channel_map)
    clocks: dict[str, tuple[str, str]] = {}
    mistakes: list[FileProblem] = []
    for key, fields in wanted.items():
        try:
            stated = key or channel_map.table_time
            clocks[key] = _clock(file, stated, channel_map, names, fields)
        except FileProblemsError as error:
            mistakes += error.problems
    mistakes += _missing(names, [name for fields in wanted.values() for name in fields])
    if mistakes:
        raise FileProblemsError(file, list(dict.fromkeys(mistakes)))
    used = {name for fields in wanted.values() for name in fields}
    used |= {name for name, _ in clocks.values()}
    arrays = fetch(sorted({_column(names, name) for name in used}))
    problems: list[FileProblem] = []
    tables: dict[tuple[str, str], LogTable] = {}
    for key, fields in wanted.items():
        clock, unit = clocks[key]
        stamps = _element(arrays, names, clock)
        if stamps is None:
            shape = arrays[_column(names, clock)].shape
            problems.append(_size_problem(clock, shape, "name the column of time", 0))
            continue
        times = to_si(stamps.reshape(-1), unit, "time")
        good = find_valid_times(times)
        check_spacing(file, times[good], clock)
        if not good.all():
            remarks.append(
                f"{int(good.size - good.sum())} rows of {file.name} have no time, or a repeated "
                f"or decreasing time, in '{clock}'; skipped"
            )
        columns: dict[str, FloatArray] = {}
        for name in fields:
            values = _element(arrays, names, name)
            if values is None or values.shape != times.shape:
                shape = arrays[_column(names, name)].shape
                expected = f"'{clock}' has {times.size} times"
                problems.append(_size_problem(name, shape, expected, times.size))
            else:
                columns[name] = values[good]
        tables[TABLE, key] = LogTable(times=times[good], fields=columns)
    if problems:
        raise FileProblemsError(file, problems)
    return ForeignLog(path=file, tables=tables, remarks=tuple(remarks))


def _size_problem(name: str, shape: tuple[int, ...], expected: str, size: int) -> FileProblem:
    """Return the problem of an array that does not have one number for each of `size` times."""
    remedy = "name one column of it, as in 'rates[0]', or its own clock"
    if len(shape) == 2 and shape[1] == size:
        remedy = "transpose it: rows are times"
    return FileProblem(where=name, what=f"has the shape {shape}, where {expected}", remedy=remedy)


Fetch = Callable[[Sequence[str]], Mapping[str, FloatArray]]


def _open_table(file: Path) -> tuple[tuple[str, ...], Fetch, list[str]]:
    """Return the names of the columns, and what reads some of them."""
    ending = file.suffix.casefold()
    if ending in (".mat", ".parquet"):
        columns, _ = read_mat_columns(file) if ending == ".mat" else read_parquet_columns(file)
        return tuple(columns), lambda names: {name: columns[name] for name in names}, []
    table = read_delimited_table(file)
    return table.names, lambda names: _numbers(table, names), list(table.remarks)


def _numbers(table: DelimitedTable, names: Sequence[str]) -> dict[str, FloatArray]:
    unique = list(dict.fromkeys(names))
    values, _ = table.numbers([table.names.index(name) for name in unique])
    return {name: values[:, place] for place, name in enumerate(unique)}


def _requested_columns(channel_map: ChannelMap) -> dict[str, list[str]]:
    """Return the columns wanted, by the clock that their entries name."""
    wanted: dict[str, list[str]] = {}
    for entry in channel_map.entries:
        wanted.setdefault(entry.time or "", []).extend(ref.field for ref in entry.inputs)
    return wanted


def _column(names: Sequence[str], name: str) -> str:
    match = _ELEMENT.fullmatch(name)
    return match["name"] if name not in names and match is not None else name


def _element(
    arrays: Mapping[str, FloatArray], names: Sequence[str], name: str
) -> FloatArray | None:
    column = _column(names, name)
    values = arrays[column]
    if column == name:
        return values
    index = int(name[len(column) + 1 : -1])
    if values.ndim != 2 or index >= values.shape[1]:
        return None
    return np.ascontiguousarray(values[:, index])


def _missing(names: Sequence[str], wanted: Sequence[str]) -> list[FileProblem]:
    """Return a problem for each column that is wanted and not there."""
    problems = []
    for name in dict.fromkeys(wanted):
        if _column(names, name) in names:
            continue
        problems.append(
            FileProblem(
                where=name,
                what="is no column of this file",
                remedy=did_you_mean(
                    name, names, f"it has: {format_names(names, 20) or 'no numbers at all'}", most=1
                ),
            )
        )
    return problems


def _clock(
    file: Path,
    stated: str | None,
    channel_map: ChannelMap,
    names: Sequence[str],
    fields: Sequence[str],
) -> tuple[str, str]:
    """Return the column of time, and its unit."""
    if stated is not None:
        if problems := _missing(names, [stated]):
            raise FileProblemsError(file, problems)
        return stated, channel_map.table_time_unit
    # Beside a member of a structure, its own clock goes before that of the file.
    structures = [field.rpartition(".")[0] + "." for field in fields[:1] if "." in field]
    for prefix in (*structures, ""):
        for name in names:
            match = _WITH_UNIT.fullmatch(name)
            plain, unit = (match["name"], match["unit"]) if match else (name, "")
            if plain.casefold() not in {prefix.casefold() + clock for clock in _CLOCKS}:
                continue
            try:
                return name, normalize_unit(unit, "time") if unit else channel_map.table_time_unit
            except UnitError:
                continue
    problem = FileProblem(
        where="time",
        what=f"no column is called time, among {', '.join(names[:20])}",
        remedy='name it in the channel map: time = "..."',
    )
    raise FileProblemsError(file, [problem])

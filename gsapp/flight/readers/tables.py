"""CSV, ``.mat`` and Parquet files of other programs, their columns named by a channel map."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gsapp.decoding.channel_map import TABLE, ChannelMap
from gsapp.flight.readers.boot_clock import find_valid_times
from gsapp.flight.readers.columns import check_spacing
from gsapp.flight.readers.delimited_table import (
    DelimitedTable,
    column_name,
    read_delimited_table,
    single_problem,
)
from gsapp.flight.readers.log_tables import ForeignLog, LogTable
from gsapp.flight.readers.reader_process import read_in_process
from gsapp.foundation import FileProblem, FileProblemsError, FlightError, UnitError
from gsapp.foundation.name_suggestions import did_you_mean, format_names
from gsapp.quantities import FloatArray, normalize_unit, to_si


def read_mat_columns(path: Path | str) -> tuple[dict[str, FloatArray], dict[str, str]]:
    """Read the arrays of numbers of a ``.mat`` file, and the texts of a structure ``units``.

    By variable, shape (n,) or (n, k), rows for time; a member of a structure is ``gyro.q``, one of
    the second in an array of structures ``gyro[1].q``.
    """
    return _flatten(_read_mat(Path(path)))


def _read_mat(file: Path) -> dict[str, Any]:
    """Return what a ``.mat`` file of any version holds, structures as dicts."""
    content: dict[str, Any] = _read_file(
        "mat", file, "save it again in MATLAB with save('file.mat', '-v7')"
    )
    return content


def _read_file(reader: str, file: Path, remedy: str) -> Any:
    try:
        return read_in_process(reader, file, remedy)
    except OSError as error:
        raise FlightError(
            f"{file} cannot be read ({error.strerror}); check the path and the permissions"
        ) from error


def _flatten(content: dict[str, Any]) -> tuple[dict[str, FloatArray], dict[str, str]]:
    """Return the arrays of numbers by their full names, and the texts of a structure ``units``."""
    columns: dict[str, FloatArray] = {}
    stated = content.pop("units", None)
    units = (
        {str(name): text for name, text in stated.items() if isinstance(text, str)}
        | {str(name): "" for name, text in stated.items() if _is_empty(text)}
        if isinstance(stated, Mapping)
        else {}
    )
    _collect("", content, columns)
    # What this program writes: raw channels have names that no variable can have.
    names = content.get("names")
    if units and isinstance(names, Mapping):
        columns = {str(names.get(name, name)): values for name, values in columns.items()}
        units = {str(names.get(name, name)): unit for name, unit in units.items()}
    return columns, units


def _is_empty(value: Any) -> bool:
    return isinstance(value, np.ndarray) and value.size == 0


def _collect(prefix: str, content: Mapping[str, Any], columns: dict[str, FloatArray]) -> None:
    for name, value in content.items():
        if isinstance(value, Mapping):
            _collect(f"{prefix}{name}.", value, columns)
        elif isinstance(value, list) and all(isinstance(one, Mapping) for one in value):
            for index, one in enumerate(value):
                _collect(f"{prefix}{name}[{index}].", one, columns)
        elif isinstance(value, (int, float)) and not isinstance(value, bool):
            columns[prefix + name] = np.array([value], dtype=np.float64)
        elif isinstance(value, np.ndarray) and value.dtype.kind in "fiub" and 1 <= value.ndim <= 2:
            columns[prefix + name] = value.astype(np.float64)


def read_parquet_columns(path: Path | str) -> tuple[dict[str, FloatArray], dict[str, str]]:
    """Read the columns of numbers of a Parquet file, shape (n,), and the ``unit`` of each.

    Null becomes NaN. Columns of text and times of day are passed over.
    """
    columns, units = _read_file("parquet", Path(path), "write it again")
    return columns, units


_CLOCKS = ("time", "t", "timestamp", "time_s", "times", "seconds", "sec")
_WITH_UNIT = re.compile(r"(?P<name>[^\[\]()]+?)\s*[\[(](?P<unit>[^\[\]()]*)[\])]\s*")
_ELEMENT = re.compile(r"(?P<name>.+)\[(?P<index>\d+)\]")
_COLUMN = re.compile(r"column\[(?P<index>\d+)\]")
"""What `column_name` gives."""
_STEP = re.compile(r"([^.\[\]]+)|\[(\d+)\]")


def read_table(path: Path | str, channel_map: ChannelMap) -> ForeignLog:
    """Read the columns of a file (CSV, ``.mat``, Parquet) that a map of format ``table`` names.

    The others may hold anything. One table for each clock: ``("table", "")`` for that of the map,
    ``("table", name)`` for a channel whose entry names its own.
    """
    file = Path(path)
    wanted = _requested_columns(channel_map)
    names, fetch, remarks = _open_table(file, channel_map)
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
                is_unfilled = bool((values == channel_map.unfilled).all())
                columns[name] = np.full(good.sum(), np.nan) if is_unfilled else values[good]
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


def _open_table(file: Path, channel_map: ChannelMap) -> tuple[tuple[str, ...], Fetch, list[str]]:
    ending = file.suffix.casefold()
    if ending in (".mat", ".parquet"):
        if ending == ".mat":
            columns, remarks = _only_part(file, channel_map)
        else:
            columns, remarks = read_parquet_columns(file)[0], []
        return tuple(columns), lambda names: {name: columns[name] for name in names}, remarks
    table = read_delimited_table(file)
    return table.names, lambda names: _numbers(table, names), list(table.remarks)


def _only_part(file: Path, channel_map: ChannelMap) -> tuple[dict[str, FloatArray], list[str]]:
    """Return the columns of a ``.mat`` file that holds one flight."""
    columns = _flatten(_read_mat(file))[0]
    parts, lacking = _find_parts(columns, channel_map)
    if len(parts) > 1:
        raise FlightError(
            f"{file} holds {len(parts)} flights: {format_names(list(parts), 12)}; make a flight "
            "folder of each with 'gsapp import'"
        )
    return (_strip(columns, parts[0]), lacking) if parts else (columns, [])


@dataclass(frozen=True, slots=True, kw_only=True)
class MatPart:
    """One of several flights in a ``.mat`` file: a structure, or a matrix of numbers."""

    name: str
    """As the file calls it: ``ail_1``, or ``runs[2]`` of an array of structures."""
    variables: dict[str, Any]
    """Its members; of a matrix, itself."""


def read_mat_parts(
    path: Path | str, channel_map: ChannelMap
) -> tuple[tuple[MatPart, ...], tuple[str, ...]]:
    """Return the flights in a ``.mat`` file that holds several, and remarks; else nothing.

    Each structure that has all members that the map names is a flight, and each matrix with as
    many columns where it names ``column[0]`` and so on.
    """
    content = _read_mat(Path(path))
    columns = _flatten(content)[0]
    names, remarks = _find_parts(columns, channel_map)
    if len(names) < 2:
        return (), ()
    parts = []
    for name in names:
        found: Any = content
        for key, index in _STEP.findall(name):
            found = found[int(index)] if index else found[key]
        variables = found if isinstance(found, dict) else {name.rpartition(".")[2]: found}
        parts.append(MatPart(name=name, variables=variables))
    return tuple(parts), tuple(remarks)


def _find_parts(
    columns: Mapping[str, FloatArray], channel_map: ChannelMap
) -> tuple[tuple[str, ...], list[str]]:
    """Return the full names of the parts that hold all that a map names, and who lacks what.

    Nothing where the file itself holds some of it.
    """
    fields = [name for each in _requested_columns(channel_map).values() for name in each]
    stated = (channel_map.table_time, *(entry.time for entry in channel_map.entries))
    wanted = dict.fromkeys([*fields, *(name for name in stated if name)])
    places = [_COLUMN.fullmatch(name) for name in wanted]
    if all(places):
        width = 1 + max(int(match["index"]) for match in places if match is not None)
        return tuple(
            name for name, array in columns.items() if array.ndim == 2 and array.shape[1] >= width
        ), []
    members = {_column(tuple(columns), name) for name in wanted}
    if members & columns.keys():
        return (), []
    held: dict[str, set[str]] = {}
    for name in columns:
        for member in members:
            if name.endswith(f".{member}"):
                held.setdefault(name[: -len(member) - 1], set()).add(member)
    most = max(map(len, held.values()), default=0)
    lacking = [
        f"'{part}' was skipped: it has no {format_names(sorted(members - found), 5)}"
        for part, found in held.items()
        if len(found) < most
    ]
    # Where no part has all, the best is read, to say of it what it lacks.
    return tuple(part for part, found in held.items() if len(found) == most), lacking


def _strip(columns: Mapping[str, FloatArray], part: str) -> dict[str, FloatArray]:
    """Return the columns of a part by the names that the map uses."""
    if part in columns:
        matrix = columns[part]
        return {column_name(index): matrix[:, index] for index in range(matrix.shape[1])}
    start = f"{part}."
    return {name[len(start) :]: one for name, one in columns.items() if name.startswith(start)}


def _numbers(table: DelimitedTable, names: Sequence[str]) -> dict[str, FloatArray]:
    unique = list(dict.fromkeys(names))
    values, _ = table.numbers([table.names.index(name) for name in unique])
    return {name: values[:, index] for index, name in enumerate(unique)}


def _requested_columns(channel_map: ChannelMap) -> dict[str, list[str]]:
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
        listed = f"it has: {format_names(names, 20) or 'no numbers at all'}"
        remedy = did_you_mean(name, names, listed, most=1)
        problems.append(FileProblem(where=name, what="is no column of this file", remedy=remedy))
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
    what = f"no column is called time, among {', '.join(names[:20])}"
    raise single_problem(file, "time", what, 'name it in the channel map: time = "..."')

"""Columns that name channels and units, as Flight CSV, ``.mat`` and Parquet hold them."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gsapp.flight.readers.boot_clock import find_isolated_times
from gsapp.flight.readers.delimited_table import read_delimited_table, single_problem
from gsapp.flight.settings import FLIGHT_DATA
from gsapp.flight.uniform_grid import median_step
from gsapp.foundation import (
    FileProblem,
    FileProblemsError,
    UnitError,
    UnknownNameError,
    UnmappedError,
)
from gsapp.foundation.name_suggestions import close_matches, format_names
from gsapp.quantities import (
    CHANNELS,
    Block,
    FloatArray,
    base_id,
    channel,
    is_raw_channel,
    normalize_unit,
    to_si,
)

TIME = "time"
_CELL = re.compile(
    r"(?P<id>\w+(?:\[\w+\])?\.\w+(?:\[\d+\])?|[^\[\]]*?)\s*(?:\[(?P<unit>[^\[\]]*)\])?"
)
_NUMBERED = re.compile(r"(?P<base>.+)_(?P<number>[2-9])")
_FIRST = 5
_MOST_PROBLEMS = 20


@dataclass(frozen=True, slots=True, kw_only=True)
class FileColumn:
    """One column as its header names it."""

    id: str
    """Channel id, or ``time``."""
    unit: str
    """As listed in the vocabulary."""

    @property
    def quantity(self) -> str:
        return TIME if self.id == TIME else channel(self.id).quantity

    def to_si(self, values: FloatArray) -> FloatArray:
        """Convert values of this column to SI."""
        return to_si(values, self.unit, self.quantity)


@dataclass(frozen=True, slots=True, kw_only=True)
class ColumnFlight:
    """A flight as columns, as Flight CSV, ``.mat`` and Parquet hold it."""

    block: Block
    """The samples at the times of the file, which may be uneven."""
    columns: tuple[FileColumn, ...]
    """As the file names them, in its order, time included."""
    remarks: tuple[str, ...] = ()
    """What was lost, in words."""


def parse_header(path: Path, where: str, names: Sequence[str]) -> tuple[FileColumn, ...]:
    """Return the columns that header cells name; all mistakes are named at once."""
    if all(_is_number(name) for name in names):
        remedy = "start with a header such as 'time [s],alpha [deg],q [deg/s]'"
        raise single_problem(path, where, "contains numbers instead of column names", remedy)
    problems: list[FileProblem] = []
    columns: list[FileColumn] = []
    seen: dict[str, int] = {}
    for number, name in enumerate(names, start=1):
        if len(problems) >= _MOST_PROBLEMS:
            what = "may have further problems like these"
            raise FileProblemsError(path, [*problems, FileProblem(where="file", what=what)])
        try:
            column = parse_name(name)
        except (UnitError, UnknownNameError) as error:
            problems.append(FileProblem.from_error(f"{where}, column {number} ({name})", error))
            continue
        if column.id in seen:
            problems.append(
                FileProblem(
                    where=f"{where}, column {number} ({name})",
                    what=f"'{column.id}' is already in column {seen[column.id]}",
                    remedy=f"remove one, or name it '{base_id(column.id)}.2' if it is a second "
                    "sensor",
                )
            )
        seen.setdefault(column.id, number)
        columns.append(column)
    if TIME not in seen and not any("'time'" in problem.what for problem in problems):
        problems.append(
            FileProblem(
                where=where,
                what="there is no column of time",
                remedy="add one headed 'time [s]'",
            )
        )
    if problems:
        raise FileProblemsError(path, problems)
    if len(columns) == 1:
        remedy = "add columns such as 'q [deg/s]'"
        raise single_problem(path, where, "time without any channel", remedy)
    return tuple(columns)


def is_foreign_header(names: Sequence[str]) -> bool:
    """Return whether header cells are those of another program: none has a unit, none is known."""
    for name in names:
        if is_raw_channel(name):
            continue
        if "[" in name or _is_number(name):
            return False
        try:
            parse_name(name)
        except UnknownNameError:
            continue
        except UnitError:
            return False
    return True


def parse_name(name: str) -> FileColumn:
    """Read ``alpha [deg]``; near names of an unknown one are told."""
    match = _CELL.fullmatch(name.strip())
    if match is None:
        raise UnknownNameError(
            f"'{name}' is not of the form 'id [unit]'; write for example 'alpha [deg]'"
        )
    channel_id, unit = match["id"].strip(), match["unit"]
    if not channel_id:
        raise UnknownNameError(
            "the column has no name; name it, or remove the column (or a trailing comma)"
        )
    if channel_id == TIME:
        return FileColumn(id=TIME, unit=_unit(TIME, unit, TIME))
    try:
        spec = channel(channel_id)
    except UnknownNameError as error:
        near = _nearest_channel(channel_id)
        if near:
            raise UnknownNameError(
                f"no channel is called '{channel_id}'; did you mean '{near}'?"
            ) from error
        raise
    return FileColumn(id=channel_id, unit=_unit(channel_id, unit, spec.quantity))


def _unit(channel_id: str, unit: str | None, quantity: str) -> str:
    try:
        return normalize_unit(unit or "", quantity)
    except UnitError as error:
        if unit is not None and unit.strip():
            raise
        listed = str(error).partition("; ")[2]
        raise UnitError(f"'{channel_id}' has no unit; {listed}, in brackets") from error


def _nearest_channel(name: str) -> str:
    """Return the id meant by a name in other capitals or in long form, or nothing."""
    plain = name.casefold().replace(" ", "_")
    for known in (TIME, *CHANNELS):
        if plain == known.casefold():
            return known
    for spec in CHANNELS.values():
        if plain in (
            spec.symbol.casefold().replace(" ", "_"),
            spec.title.casefold().replace(" ", "_"),
        ):
            return spec.id
    return next(iter(close_matches(plain, (TIME, *CHANNELS), most=1, cutoff=0.7)), "")


def _is_number(text: str) -> bool:
    try:
        float(text or "nan")
    except ValueError:
        return False
    return True


def check_times(path: Path, times: FloatArray, where: Callable[[int], str]) -> None:
    """Check that every row has a time (s), later than the one before; name the first that have not.

    `where` gives the place of a row in the file, in words.
    """
    problems = [
        FileProblem(
            where=where(row),
            what="has no time",
            remedy="give every row a time, or remove the row",
        )
        for row in np.flatnonzero(np.isnan(times))[:_FIRST].tolist()
    ]
    steps = np.diff(times)
    for row in np.flatnonzero(steps <= 0.0)[:_FIRST].tolist():
        what = f"goes back from {times[row]:.9g} s to {times[row + 1]:.9g} s"
        remedy = "sort the rows by time, or cut the file where the clock restarted"
        if steps[row] == 0.0:
            what, remedy = "repeats the time of the row before", "keep one of the two rows"
        problems.append(FileProblem(where=where(row + 1), what=what, remedy=remedy))
    if problems:
        raise FileProblemsError(path, problems)
    check_spacing(path, times, where(0))


def check_spacing(path: Path, times: FloatArray, where: str) -> None:
    """Check that samples do not follow quicker than any instrument takes them, times in s.

    They do where a program counts time in days, and times are too large where it counts in
    microseconds. On average: samples of several instruments, each at
    its own time, may follow each other closely.
    """
    if times.size < 2:
        return
    if max(abs(float(times[0])), abs(float(times[-1]))) > FLIGHT_DATA.max_time:
        remedy = "is the time in us or ns? write it in the stated unit"
        raise single_problem(path, where, f"time {times[-1]:.3g} s is out of range", remedy)
    step = float(times[-1] - times[0]) / (times.size - 1)
    if step * FLIGHT_DATA.max_sample_rate < 1.0:
        remedy = "is the time in days or hours? write it in the stated unit"
        what = f"the samples would follow every {step:.2g} s"
        raise single_problem(path, where, what, remedy)


def fastest_rate(block: Block) -> float:
    """Return the rate of the channel that is sampled most often, Hz; the others have gaps."""
    steps = [median_step(block.times[~np.isnan(block[name])]) for name in block.channels]
    return 1.0 / min((step for step in steps if step > 0.0), default=np.nan)


def build_flight_from_columns(
    path: Path, arrays: Mapping[str, FloatArray], units: Mapping[str, str]
) -> ColumnFlight:
    """Make a flight of arrays that are named by channel and state their units.

    Arrays are called ``alpha``, ``q_2`` for ``q.2``, or ``alpha [deg]``; `units` has those that the
    name itself does not state.
    """
    names = list(arrays)
    headers = [
        name if "[" in name or name not in units else f"{_channel_of(name)} [{units[name]}]"
        for name in names
    ]
    columns = parse_header(path, "names", headers)
    place = _time_index(columns)
    size = arrays[names[place]].size
    wrong = [
        FileProblem(
            where=name,
            what=f"has the shape {array.shape}, where time has {size} samples",
            remedy="store one number per time",
        )
        for name, array in arrays.items()
        if array.ndim != 1 or array.size != size
    ]
    if wrong:
        raise FileProblemsError(path, wrong)
    if not size:
        raise single_problem(path, names[place], "is empty", "export again")
    return _build_flight(
        path,
        columns,
        lambda index: arrays[names[index]],
        lambda row: f"{names[place]}, sample {row + 1}",
    )


def _build_flight(
    path: Path,
    columns: Sequence[FileColumn],
    samples: Callable[[int], FloatArray],
    where: Callable[[int], str],
    remarks: Sequence[str] = (),
) -> ColumnFlight:
    place = _time_index(columns)
    times = columns[place].to_si(samples(place))
    isolated = find_isolated_times(times)
    lost = int(np.count_nonzero(isolated))
    rows = np.flatnonzero(~isolated)
    chosen = rows if lost else slice(None)
    times = times[chosen]
    check_times(path, times, lambda row: where(int(rows[row])))
    channels = [index for index in range(len(columns)) if index != place]
    # Column by column into the array that stays, so that a long flight is held only once more.
    values = np.empty((times.size, len(channels)))
    for target, index in enumerate(channels):
        values[:, target] = columns[index].to_si(samples(index))[chosen]
    counted = "1 row" if lost == 1 else f"{lost} rows"
    return ColumnFlight(
        block=Block(
            channels=tuple(columns[index].id for index in channels), times=times, values=values
        ),
        columns=tuple(columns),
        remarks=(
            *remarks,
            *([f"skipped for impossible times: {counted} of {path.name}"] if lost else []),
        ),
    )


def _time_index(columns: Sequence[FileColumn]) -> int:
    return next(index for index, column in enumerate(columns) if column.id == TIME)


def _channel_of(name: str) -> str:
    """Return the channel id of a variable: ``q_2``, which MATLAB can write, is ``q.2``."""
    match = _NUMBERED.fullmatch(name)
    if match is None or name in CHANNELS or match["base"] not in CHANNELS:
        return name
    return f"{match['base']}.{match['number']}"


def read_flight_csv(path: Path | str) -> ColumnFlight:
    """Read a Flight CSV; cells that are empty or ``nan`` are missing samples."""
    table = read_delimited_table(path)
    if not table.has_header:
        raise UnmappedError(
            f"{path} has {len(table.names)} columns of numbers without names; give a channel map "
            f"of format 'table' with --map, with sources {table.names[0]} to {table.names[-1]}, or "
            "start with a header such as 'time [s],alpha [deg],q [deg/s]'"
        )
    if is_foreign_header(table.names):
        raise UnmappedError(
            f"{path} does not assign columns to channels and units; give a channel map of "
            "format 'table' with --map, or start with a header such as 'time [s],alpha [deg],q "
            f"[deg/s]'. Columns: {format_names(table.names, 12)}"
        )
    columns = parse_header(table.path, f"line {table.header_line}", table.names)
    values, lines = table.numbers()
    place = _time_index(columns)
    return _build_flight(
        table.path,
        columns,
        lambda index: values[:, index],
        lambda row: f"line {lines[row]}, column {place + 1} ({table.names[place]})",
        table.remarks,
    )

"""Flight CSV: one header line of ``id [unit]``, one column of time, any subset of channels."""

from __future__ import annotations

import difflib
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gsapp.flight.readers.delimited import TextTable, read_text_table
from gsapp.foundation import FileProblem, FileProblemsError, UnitError, UnknownNameError
from gsapp.quantities import (
    CHANNELS,
    Block,
    FloatArray,
    base_id,
    channel,
    normalize_unit,
    to_si,
)

TIME = "time"
_CELL = re.compile(r"(?P<id>[^\[\]]*?)\s*(?:\[(?P<unit>[^\[\]]*)\])?")


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """One column as its header names it.

    Attributes
    ----------
    id : str
        Channel id, or ``time``.
    unit : str
        As listed in the vocabulary.
    """

    id: str
    unit: str

    @property
    def quantity(self) -> str:
        """Return the key of the quantity."""
        return TIME if self.id == TIME else channel(self.id).quantity

    def to_si(self, values: FloatArray) -> FloatArray:
        """Convert values of this column to SI."""
        return to_si(values, self.unit, self.quantity)


@dataclass(frozen=True, slots=True, kw_only=True)
class ColumnFlight:
    """A flight as columns, as Flight CSV, ``.mat`` and Parquet hold it.

    Attributes
    ----------
    block : Block
        The samples at the times of the file, which may be uneven.
    columns : tuple of Column
        As the file names them, in its order, time included.
    remarks : tuple of str
        What was lost, in words.
    """

    block: Block
    columns: tuple[Column, ...]
    remarks: tuple[str, ...] = ()


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
    """
    table = read_text_table(path)
    columns = parse_header(table.path, f"line {table.header_line}", table.names)
    values, lines = table.numbers()
    place = next(index for index, column in enumerate(columns) if column.id == TIME)
    times = columns[place].to_si(values[:, place])
    _check_times(table, times, lines, place)
    channels = [index for index in range(len(columns)) if index != place]
    # Column by column into the array that stays, so that a long flight is held only once more.
    si = np.empty((times.size, len(channels)))
    for target, index in enumerate(channels):
        si[:, target] = columns[index].to_si(values[:, index])
    block = Block(channels=tuple(columns[index].id for index in channels), times=times, values=si)
    return ColumnFlight(block=block, columns=columns, remarks=table.remarks)


def parse_header(path: Path, where: str, names: Sequence[str]) -> tuple[Column, ...]:
    """Return the columns that header cells name.

    Raises
    ------
    FileProblemsError
        If a name is unknown, a unit does not fit, one is named twice, or there is no time.
    """
    if all(_is_number(name) for name in names):
        problem = FileProblem(
            where=where,
            what="holds numbers where the names of the columns are meant",
            remedy="begin with a header such as 'time [s],alpha [deg],q [deg/s]'",
        )
        raise FileProblemsError(path, [problem])
    problems: list[FileProblem] = []
    columns: list[Column] = []
    seen: dict[str, int] = {}
    for number, name in enumerate(names, start=1):
        try:
            column = parse_name(name)
        except (UnitError, UnknownNameError) as error:
            what, _, remedy = str(error).partition("; ")
            problems.append(
                FileProblem(where=f"{where}, column {number} ({name})", what=what, remedy=remedy)
            )
            continue
        if column.id in seen:
            problems.append(
                FileProblem(
                    where=f"{where}, column {number} ({name})",
                    what=f"'{column.id}' already stands in column {seen[column.id]}",
                    remedy=f"take one out, or call it '{base_id(column.id)}.2' if it is a second "
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
    if not problems and len(columns) == 1:
        problems.append(
            FileProblem(
                where=where,
                what="there is time but no channel",
                remedy="add columns such as 'q [deg/s]'",
            )
        )
    if problems:
        raise FileProblemsError(path, problems)
    return tuple(columns)


def parse_name(name: str) -> Column:
    """Read ``alpha [deg]``.

    Raises
    ------
    UnknownNameError
        If no channel has that id; near ones are named.
    UnitError
        If the unit does not express the channel.
    """
    match = _CELL.fullmatch(name.strip())
    if match is None:
        raise UnknownNameError(
            f"'{name}' is not of the form 'id [unit]'; write for example 'alpha [deg]'"
        )
    channel_id, unit = match["id"].strip(), match["unit"]
    if not channel_id:
        raise UnknownNameError(
            "the column has no name; name it, or take the column (or a last comma) out"
        )
    if channel_id == TIME:
        return Column(id=TIME, unit=_unit(TIME, unit, TIME))
    try:
        spec = channel(channel_id)
    except UnknownNameError as error:
        near = _near(channel_id)
        if near:
            raise UnknownNameError(
                f"no channel is called '{channel_id}'; did you mean '{near}'?"
            ) from error
        raise
    return Column(id=channel_id, unit=_unit(channel_id, unit, spec.quantity))


def _unit(channel_id: str, unit: str | None, quantity: str) -> str:
    try:
        return normalize_unit(unit or "", quantity)
    except UnitError as error:
        if unit is not None and unit.strip():
            raise
        listed = str(error).partition("; ")[2]
        raise UnitError(f"'{channel_id}' has no unit; {listed}, in brackets") from error


def _near(name: str) -> str:
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
    close = difflib.get_close_matches(plain, (TIME, *CHANNELS), n=1, cutoff=0.7)
    return close[0] if close else ""


def _is_number(text: str) -> bool:
    try:
        float(text or "nan")
    except ValueError:
        return False
    return True


def _check_times(table: TextTable, times: FloatArray, lines: Sequence[int], place: int) -> None:
    column = f"column {place + 1} ({table.names[place]})"
    missing = np.flatnonzero(np.isnan(times))
    problems = [
        FileProblem(
            where=f"line {lines[row]}, {column}",
            what="has no time",
            remedy="give every row its time, or take the row out",
        )
        for row in missing[:5]
    ]
    steps = np.diff(times)
    for row in np.flatnonzero(steps <= 0.0)[:5]:
        same = steps[row] == 0.0
        problems.append(
            FileProblem(
                where=f"line {lines[row + 1]}, {column}",
                what="repeats the time of the row before"
                if same
                else f"goes back from {times[row]:.9g} s to {times[row + 1]:.9g} s",
                remedy="keep one of the two rows"
                if same
                else "sort the rows by time, or cut the file where the clock began again",
            )
        )
    if problems:
        raise FileProblemsError(table.path, problems)

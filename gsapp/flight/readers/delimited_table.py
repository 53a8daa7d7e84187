"""Text tables: numbers in columns, usually under one line of names.

Cells are separated by commas, semicolons, tabs or blanks. Every mistake is named with line, column
and remedy. Numbers are parsed a few thousand rows at a time by Python's own `float`, which measured
faster than `numpy.loadtxt` and tells where it failed.
"""

from __future__ import annotations

import csv
import itertools
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gsapp.foundation import FileProblem, FileProblemsError
from gsapp.quantities import FloatArray
from gsapp.quantities.units import QUANTITIES, parse_finite_number

_ROWS_AT_ONCE = 4096
_BYTES_AT_ONCE = 1 << 20
_LINES_LOOKED_AT = 20
_MOST_PROBLEMS = 20
_SEPARATORS = (";", "\t")
"""In place of commas; where a line has none of the three, blanks separate its cells."""
_COMMENT = "#%"
"""Begins a line that is no data; the last one before the data may name the columns."""
_BLANKS = re.compile(r"\s+(?![\[(])")
"""Between words, and not before the unit of one."""
_MOMENT = re.compile(r"\d+[-/.]\d+[-/.]\d+|\d+:\d\d")
"""How a date or a time of day begins."""
_SEPARATOR_LINE = re.compile(r"\"?sep=.\"?,*", re.IGNORECASE)
"""A line by which a spreadsheet is told what separates the cells."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DelimitedTable:
    """A text table, its names read, its numbers not yet."""

    path: Path
    names: tuple[str, ...]
    """The cells of the line of names; without one ``column[0]``, ``column[1]`` and so on."""
    header_line: int
    """Number of the line before the first that may be data, from 1."""
    lines: tuple[str, ...]
    """The lines below it, their cells separated by commas, blank ones included."""
    quoted: bool
    """Whether cells may stand in quotation marks."""
    remarks: tuple[str, ...]
    """What was lost, in words."""

    @property
    def has_header(self) -> bool:
        return self.names[0] != column_name(0)

    def numbers(self, columns: Sequence[int] | None = None) -> tuple[FloatArray, list[int]]:
        """Parse columns, by default all, as numbers; empty cells are NaN.

        The other columns may hold anything. Returns the numbers, shape (n, n_columns), and the line
        of each row in the file.
        """
        chosen = list(range(len(self.names))) if columns is None else list(columns)
        every = chosen == list(range(len(self.names)))
        problems: list[FileProblem] = []
        count = 0
        parts: list[FloatArray] = []
        line_numbers: list[int] = []
        for first, rows in self._batches():
            line_numbers.extend(first + offset for offset, row in rows)
            cells = [row for _, row in rows]
            ragged = [(first + offset, row) for offset, row in rows if len(row) != len(self.names)]
            if ragged:
                count += len(ragged)
                room = _MOST_PROBLEMS - len(problems)
                problems.extend(self._ragged(line, row) for line, row in ragged[: max(room, 0)])
                cells = [row for row in cells if len(row) == len(self.names)]
            picked = cells if every else [[row[column] for column in chosen] for row in cells]
            values = _fast_numbers(picked, len(chosen))
            if values is None:
                values, found = self._slow_numbers(first, rows, chosen)
                count += len(found)
                problems.extend(found[: max(_MOST_PROBLEMS - len(problems), 0)])
            parts.append(values)
        if problems:
            if count > len(problems):
                problems.append(
                    FileProblem(
                        where="file",
                        what=f"has {count - len(problems)} further problems like these",
                    )
                )
            raise FileProblemsError(self.path, problems)
        if not line_numbers:
            raise single_problem(
                self.path,
                "file",
                "has a header but no rows",
                "record or export again; at least one row is needed",
            )
        return np.concatenate(parts), line_numbers

    def _batches(self) -> Iterator[tuple[int, list[tuple[int, list[str]]]]]:
        """Yield the line number of a batch, and its rows with their offsets from it."""
        for start in range(0, len(self.lines), _ROWS_AT_ONCE):
            batch = self.lines[start : start + _ROWS_AT_ONCE]
            split = (
                _split_quoted(self.path, batch)
                if self.quoted
                else (line.split(",") for line in batch)
            )
            rows = [
                (offset, row)
                for offset, (line, row) in enumerate(zip(batch, split, strict=False))
                if line and not line.isspace()
            ]
            if rows:
                yield self.header_line + 1 + start, rows

    def _ragged(self, line: int, row: Sequence[str]) -> FileProblem:
        expected, found = len(self.names), len(row)
        remedy = "give every row one cell per column, empty where missing"
        if found > expected and all(cell.strip().lstrip("-").isdigit() for cell in row if cell):
            remedy = "decimal commas? write decimal points"
        return FileProblem(
            where=f"line {line}",
            what=f"has {found} cells where the header has {expected}",
            remedy=remedy,
        )

    def _slow_numbers(
        self, first: int, rows: Sequence[tuple[int, list[str]]], chosen: Sequence[int]
    ) -> tuple[FloatArray, list[FileProblem]]:
        """Parse cell by cell, and say of each bad one where it is."""
        whole = [(first + offset, row) for offset, row in rows if len(row) == len(self.names)]
        values = np.full((len(whole), len(chosen)), np.nan)
        problems: list[FileProblem] = []
        for index, (line, row) in enumerate(whole):
            for place, column in enumerate(chosen):
                text = row[column].strip()
                number = parse_finite_number(text)
                if number is not None:
                    values[index, place] = number
                    continue
                problems.append(
                    FileProblem(
                        where=f"line {line}, column {column + 1} ({self.names[column]})",
                        what=f"'{_shortened(text)}' is not a number",
                        remedy=_number_remedy(text),
                    )
                )
        return values, problems


def _split_quoted(path: Path, lines: Sequence[str]) -> Iterator[list[str]]:
    try:
        yield from csv.reader(lines)
    except csv.Error as error:
        raise _quoting_problem(path, error) from error


def _quoting_problem(path: Path, error: csv.Error) -> FileProblemsError:
    remedy = "remove quotation marks that are not closed"
    return single_problem(path, "file", f"is not CSV ({error})", remedy)


def column_name(index: int) -> str:
    """Return what the column at `index`, from 0, is called in a table without names."""
    return f"column[{index}]"


def read_delimited_table(path: Path | str) -> DelimitedTable:
    """Read a text file as a table, its numbers not yet parsed.

    UTF-8 with or without byte-order mark and Latin-1 are understood, as are all line ends, and
    decimal commas where cells are not separated by them. Lines before the header that are blank or
    begin with ``#`` or ``%``, and one that tells a spreadsheet the separator (``sep=,``), are
    passed over. Names may be missing, or stand in such a comment. A last line that was torn off is
    left out and remarked on.
    """
    file = Path(path)
    try:
        return _read_table(file)
    except csv.Error as error:
        raise _quoting_problem(file, error) from error


def _read_table(file: Path) -> DelimitedTable:
    data = _content(file)
    lines = _lines(data)
    header = next(
        (
            index
            for index, line in enumerate(lines)
            if line.strip()
            and line[0] not in _COMMENT
            and not _SEPARATOR_LINE.fullmatch(line.strip())
        ),
        None,
    )
    if header is None:
        raise single_problem(
            file,
            "file",
            "is empty",
            "a flight needs a header such as 'time [s],q [deg/s]' and rows",
        )
    separator = _separator(lines[header])
    quoted = b'"' in data
    if separator == "," and not _are_numbers(lines[header].split(",")):
        names = tuple(name.strip() for name in next(csv.reader([lines[header]])))
        first = header + 1
    else:
        decimal_comma = separator != "," and not any(
            "." in line for line in lines[header + 1 : header + 1 + _LINES_LOOKED_AT]
        )
        rows = _Rows(separator=separator, quoted=quoted, decimal_comma=decimal_comma)
        first, names = rows.find_data(lines, header)
        lines[first:] = [rows.with_commas(line) for line in lines[first:]]
        quoted = False
    remarks: tuple[str, ...] = ()
    if lines[-1] and not quoted and len(lines) > first:
        cells = lines[-1].count(",") + 1
        if cells < len(names):
            remarks = (
                f"line {len(lines)} of {file.name} was torn off after {cells} of {len(names)} "
                "cells; it is left out",
            )
            lines.pop()
    return DelimitedTable(
        path=file,
        names=names,
        header_line=first,
        lines=tuple(lines[first:]),
        quoted=quoted,
        remarks=remarks,
    )


def _separator(line: str) -> str:
    """Return what separates the cells of a line; empty for blanks."""
    best = max((",", *_SEPARATORS), key=line.count)
    if not line.count(best):
        return "" if len(_BLANKS.split(line.strip())) > 1 else ","
    return best


def _are_numbers(cells: Sequence[str]) -> bool:
    return all(parse_finite_number(cell.strip()) is not None for cell in cells) and any(cells)


def _are_units(cells: Sequence[str]) -> bool:
    known = {unit for one in QUANTITIES.values() for unit in one.units} | {"-", ""}
    return all(cell.strip("[]() ") in known for cell in cells)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Rows:
    """How the lines of a table are to be split that is no plain CSV."""

    separator: str
    quoted: bool
    decimal_comma: bool

    def cells(self, line: str) -> list[str]:
        """Split a line of names."""
        if not self.separator:
            return _BLANKS.split(line.strip())
        parts = next(csv.reader([line], delimiter=self.separator)) if self.quoted else None
        return [cell.strip() for cell in parts or line.split(self.separator)]

    def with_commas(self, line: str) -> str:
        """Return a line of data with commas between its cells."""
        if self.separator == ",":
            return line
        cells = line.split() if not self.separator else self.cells(line)
        return ",".join(cell.replace(",", "." if self.decimal_comma else " ") for cell in cells)

    def find_data(self, lines: Sequence[str], header: int) -> tuple[int, tuple[str, ...]]:
        """Return the place of the first line of numbers, and the names of its columns.

        Names stand in the last line before it that has as many words, a comment perhaps; a line of
        units below them is passed over.
        """
        stop = min(len(lines), header + _LINES_LOOKED_AT)
        first = next(
            (
                place
                for place in range(header, stop)
                if _are_numbers(self.with_commas(lines[place]).split(","))
            ),
            None,
        )
        if first is None:
            return header + 1, tuple(self.cells(lines[header]))
        width = self.with_commas(lines[first]).count(",") + 1
        for line in reversed(lines[:first]):
            names = self.cells(line.strip().lstrip(_COMMENT))
            if len(names) == width and not _are_numbers(names) and not _are_units(names):
                return first, tuple(names)
        if first == header:
            return first, tuple(column_name(index) for index in range(width))
        return header + 1, tuple(self.cells(lines[header]))


def single_problem(path: Path, where: str, what: str, remedy: str) -> FileProblemsError:
    """Return the error of one problem."""
    return FileProblemsError(path, [FileProblem(where=where, what=what, remedy=remedy)])


def _content(path: Path) -> bytes:
    try:
        data = path.read_bytes()
    except OSError as error:
        raise single_problem(
            path,
            "file",
            f"cannot be read ({error.strerror})",
            "check the path and the permissions",
        ) from error
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise single_problem(path, "file", "is UTF-16 text", "save it as CSV UTF-8")
    data = data.removeprefix(b"\xef\xbb\xbf")
    zero = data.find(b"\0")
    if zero >= 0:
        raise single_problem(
            path,
            f"byte {zero + 1}",
            "is a zero byte, so the file is not text",
            "name a CSV file, or use the right ending for another format",
        )
    return data


def _lines(data: bytes) -> list[str]:
    try:
        return _decoded_lines(data, "utf-8")
    except UnicodeDecodeError:
        # Every byte is a character of Latin-1; in practice it is a degree sign in the header.
        return _decoded_lines(data, "latin-1")


def _decoded_lines(data: bytes, encoding: str) -> list[str]:
    """Return the lines of a file, split in pieces: one call would hold up all other threads."""
    lines: list[str] = []
    start = 0
    while start < len(data):
        end = data.find(b"\n", start + _BYTES_AT_ONCE) + 1 or len(data)
        piece = data[start:end].replace(b"\r\n", b"\n").replace(b"\r", b"\n")
        lines[-1:] = piece.decode(encoding).split("\n")  # the last one is empty until here
        start = end
    return lines or [""]


def _fast_numbers(rows: Sequence[Sequence[str]], width: int) -> FloatArray | None:
    """Return the rows as numbers, or None where one of the cells needs a closer look."""
    cells = itertools.chain.from_iterable(rows)
    try:
        values = np.array([float(cell) if cell else np.nan for cell in cells], dtype=np.float64)
    except ValueError:
        return None
    if np.isinf(values).any() or any(
        "_" in cell or not cell.isascii() for row in rows for cell in row
    ):
        return None
    return values.reshape(len(rows), width)


def _number_remedy(text: str) -> str:
    if "," in text:
        return "write a decimal point"
    if _MOMENT.match(text):
        return "write seconds, counted from any moment"
    if text.casefold() in {"na", "n/a", "null", "none", "-", "--", "missing", "?"}:
        return "leave the cell empty where a sample is missing"
    if "inf" in text.casefold():
        return "implausible value; leave the cell empty"
    if text[:1].isdigit():
        return "write only the number; the unit is in the header"
    return "write a number, or leave the cell empty"


def _shortened(text: str) -> str:
    return text if len(text) <= 30 else f"{text[:27]}..."

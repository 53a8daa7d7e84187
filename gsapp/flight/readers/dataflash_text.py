"""ArduPilot's on-board log as text, ``.log``: one record to a line, as ground stations convert it.

A line is the name of its message and its values, separated by commas: ``ATT, 607, 1.25, -0.4``.
FMT lines say how the columns are called, as in a ``.bin``. Values are multiplied by the factor of
their format letter already.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

TEXT_LETTERS = "nNZ"
"""Format letters of texts."""
_MODE = "M"
"""Format letter of a flight mode, which is a number or its name."""
_ARRAY = "a"
"""Format letter of 32 numbers, which a line has no room for."""
_TYPE_DIGITS = 3
_LONGEST_TEXT = 256
"""Bytes; those of a binary log have 64."""
_LOOKED_AT = 8192
"""Bytes in which the first definition stands, after what the autopilot or converter says first."""


@dataclass(slots=True, kw_only=True)
class TextRecords:
    """All lines of one message."""

    type: int
    name: str
    letters: str
    columns: tuple[str, ...]
    lines: list[str] = field(default_factory=list)
    """What follows the name."""
    places: list[int] = field(default_factory=list)
    """Numbers of these lines in the file."""

    def rows(self) -> tuple[npt.NDArray[np.void], npt.NDArray[np.int64]]:
        """Return the values of good lines, numbers as float64 and texts as bytes, and their places.

        A mode that is named becomes text, and its letter that of a text.
        """
        width = len(self.columns)
        split = [line.split(",", width - 1) for line in self.lines]
        # A text at the end keeps its commas; else there is one value for each column.
        whole = np.array([len(row) == width for row in split], dtype=bool)
        cells = [row for row in split if len(row) == width]
        read = [
            self._column(place, [row[place].strip() for row in cells]) for place in range(width)
        ]
        good = np.ones(len(cells), dtype=bool)
        for values in read:
            if values.dtype.kind == "f":
                good &= ~np.isinf(values)
        kinds: list[Any] = list(zip(self.columns, (one.dtype for one in read), strict=True))
        rows = np.empty(len(cells), dtype=kinds)
        for name, values in zip(self.columns, read, strict=True):
            rows[name] = values
        return rows[good], np.array(self.places, dtype=np.int64)[whole][good]

    def _column(self, place: int, cells: list[str]) -> npt.NDArray[Any]:
        letter = self.letters[place]
        if letter not in TEXT_LETTERS:
            try:
                return np.array(cells, dtype=np.float64)
            except ValueError:
                if letter != _MODE:
                    return np.array([_number(cell) for cell in cells])
            self.letters = self.letters[:place] + TEXT_LETTERS[1] + self.letters[place + 1 :]
        # As many bytes as the longest of them, for each.
        return np.array([cell.encode()[:_LONGEST_TEXT] for cell in cells], dtype=np.bytes_)


def is_text_log(data: bytes) -> bool:
    """Return whether the bytes of a file are a log as text."""
    start = data[:_LOOKED_AT]
    return b"FMT," in start and b"\0" not in start


def _number(cell: str) -> float:
    """Return a number, infinity for what is none."""
    try:
        return float(cell)
    except ValueError:
        return np.inf


def scan_text(data: bytes) -> tuple[dict[str, TextRecords], int]:
    """Gather the lines of each message by its name; also return how many belong to none."""
    messages: dict[str, TextRecords] = {}
    lost = 0
    for index, line in enumerate(data.decode("utf-8", "replace").splitlines()):
        name, _, rest = line.partition(",")
        name = name.strip()
        if name == "FMT":
            lost += not _define(messages, rest)
        elif name in messages:
            messages[name].lines.append(rest)
            messages[name].places.append(index)
        elif messages:
            lost += bool(name)
    return messages, lost


def _define(messages: dict[str, TextRecords], line: str) -> bool:
    """Take the definition of a message; return False for one that is damaged."""
    parts = [part.strip() for part in line.split(",")]
    if len(parts) < 5 or not (parts[0].isdecimal() and len(parts[0]) <= _TYPE_DIGITS):
        return False
    kind, name, letters, columns = parts[0], parts[2], parts[3], tuple(parts[4:])
    if name == "FMT" or _ARRAY in letters:
        return True
    if not all((name, *columns)) or not len(set(columns)) == len(columns) == len(letters):
        return False
    known = messages.get(name)
    if known is None or (known.letters, known.columns) != (letters, columns):
        made = TextRecords(type=int(kind), name=name, letters=letters, columns=columns)
        if known is not None and len(known.columns) == len(columns):
            made.lines, made.places = known.lines, known.places
        messages[name] = made
    return True

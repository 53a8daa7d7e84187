"""Rows as text that a spreadsheet opens without running what stands in a name as a formula."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable, Sequence

_FORMULA = re.compile(r"\s*[=+@\t\r\uff0b\uff1d\uff20-]")
"""How a cell begins that a spreadsheet takes for a formula."""
_NUMBER = re.compile(
    r"[+-]?(?:\d[\d,]*\.?\d*(?:e[+-]?\d+)?|inf|nan)(?: (?:± ?)?[\w.%°·²³/^]*)*|-+", re.IGNORECASE
)
"""What begins with a sign and is none: a number, with a bound or a unit, and a dash for nothing."""


def delimited_text(rows: Iterable[Sequence[object]], separator: str = ",") -> str:
    """Return rows as lines of text: separated by commas for a file, by tabs for a clipboard.

    Texts that a spreadsheet would compute, such as a note ``=1+1``, begin with an apostrophe.
    """
    lines = io.StringIO()
    writer = csv.writer(lines, delimiter=separator, lineterminator="\n")
    writer.writerows([_cell(cell) for cell in row] for row in rows)
    return lines.getvalue()


def _cell(cell: object) -> object:
    if not isinstance(cell, str):
        return cell
    # A return would begin another line, as the writer does not quote it.
    text = cell.replace("\r\n", "\n").replace("\r", "\n")
    is_formula = _FORMULA.match(cell) and not _NUMBER.fullmatch(text)
    return f"'{text}" if is_formula else text

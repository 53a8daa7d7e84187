"""Lines of a TOML text: where each key is, and where a reader stops."""

from __future__ import annotations

import re
import tomllib
from bisect import bisect_left
from collections import Counter
from collections.abc import Iterator
from typing import Any

_TOKEN = re.compile(
    r'"""(?:\\.|[^\\])*?"{3,5}'  # A string of several lines may end in two quotes of its own.
    r"|'''.*?'{3,5}"
    r'|"(?:\\.|[^"\\\n])*"'
    r"|'[^'\n]*'"
    r"|#[^\n]*"
    r"|[\[\]{}\n]",
    re.DOTALL,
)
"""What decides whether an end of line ends a statement."""


def join_key(path: str, part: str | int) -> str:
    """Return the key path of a part of a table or list: ``mass.ixx``, ``cards[2]``."""
    if isinstance(part, int):
        return f"{path}[{part}]"
    return f"{path}.{part}" if path else part


def walk_values(value: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the key path and value of everything in parsed content, tables before their keys."""
    if path:
        yield path, value
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from walk_values(inner, join_key(path, key))
    elif isinstance(value, list):
        for index, inner in enumerate(value):
            yield from walk_values(inner, join_key(path, index))


def key_lines(text: str) -> dict[str, int]:
    """Return the line where the statement of each key path begins, from 1.

    The text must be valid TOML.
    """
    lines: dict[str, int] = {}
    counts: Counter[str] = Counter()  # Of the tables in each array of tables so far.
    table = ""
    begin = 0
    for line, end in _statements(text):
        statement = text[begin:end]
        begin = end
        content: Any = tomllib.loads(statement)
        if statement.lstrip().startswith("["):
            table = ""
            while isinstance(content, dict) and content:
                ((key, content),) = content.items()
                table = join_key(table, key)
                lines.setdefault(table, line)
                if isinstance(content, list):
                    counts[table] += 1
                if table in counts:
                    table = join_key(table, counts[table] - 1)
                    lines.setdefault(table, line)
        else:
            for path, _ in walk_values(content):
                lines.setdefault(join_key(table, path), line)
    return lines


def _statements(text: str) -> Iterator[tuple[int, int]]:
    """Yield the line where each statement begins and the index where it ends."""
    depth = 0
    line = next_line = 1
    for token in _TOKEN.finditer(text):
        mark = token.group()
        next_line += mark.count("\n")
        depth += (mark in "[{") - (mark in "]}")
        if mark == "\n" and depth == 0:
            yield line, token.end()
            line = next_line
    yield line, len(text)


def line_of_key(path: str, lines: dict[str, int]) -> int | None:
    """Return the line of a key path, else that of the innermost table around it."""
    while path and path not in lines:
        path = path[: max(path.rfind("."), path.rfind("["), 0)]
    return lines.get(path)


def line_of_error(text: str, error: Exception) -> int:
    """Return the line of what raises an error of the reader of TOML that names none.

    Of a string or bracket that is never closed, it is the line where its statement begins.
    """
    if isinstance(error, tomllib.TOMLDecodeError):
        ends = list(_statements(text))
    else:
        ends = [(number, found.end()) for number, found in enumerate(re.finditer(r"\n|$", text), 1)]

    def raises(end: tuple[int, int]) -> bool:
        try:
            tomllib.loads(text[: end[1]])
        except (ValueError, RecursionError) as found:
            return type(found) is type(error)
        return False

    return ends[bisect_left(ends[:-1], True, key=raises)][0]

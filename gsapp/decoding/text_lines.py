"""Lines of text with numbers between delimiters, as the channel map describes them."""

from __future__ import annotations

import math

from gsapp.decoding.channel_map import LINE, ChannelMap
from gsapp.foundation.number_parsing import parse_finite_number


class TextLineParser:
    """Parses lines of text; an empty cell is missing, and what no channel takes may be words."""

    def __init__(self, channel_map: ChannelMap) -> None:
        self._map = channel_map
        columns = [
            ref.index or 0
            for entry in channel_map.entries
            if entry.message == LINE
            for ref in entry.inputs
        ]
        self._mapped = bool(columns)
        if channel_map.text_time is not None:
            columns.append(channel_map.text_time)
        self._count = max(columns) + 1 if columns else 0
        self._used = frozenset(columns)

    def parse(self, data: bytes) -> tuple[list[float], int | None] | str:
        """Return the numbers of a line and its stamp (us), or why it is left out."""
        if not self._mapped:
            return f"the channel map '{self._map.name}' says nothing of its columns"
        cells = data.decode("utf-8", "replace").strip().split(self._map.delimiter)
        numbers = (
            parse_finite_number(cell) if place in self._used else math.nan
            for place, cell in enumerate(cells[: self._count])
        )
        item = [number for number in numbers if number is not None]
        if len(item) < self._count:
            return f"it does not hold {self._count} numbers"
        column = self._map.text_time
        if column is None:
            return item, None
        if not 0.0 <= item[column] * self._map.text_scale < 2.0**62:
            return "its time is missing, negative or too great"
        return item, round(item[column] * self._map.text_scale)

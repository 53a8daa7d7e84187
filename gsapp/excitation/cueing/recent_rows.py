"""The rows of the last minute: what a verdict looks back on."""

from __future__ import annotations

from collections import deque
from itertools import takewhile

import numpy as np

from gsapp.excitation.flight_rows import FlightRows, concatenate_rows
from gsapp.excitation.settings import CUES


class RecentRows:
    """Keeps the newest rows of one stretch of flight."""

    def __init__(self) -> None:
        self._parts: deque[FlightRows] = deque()

    def clear(self) -> None:
        """Forget all rows."""
        self._parts.clear()

    def add(self, rows: FlightRows) -> None:
        """Take in the next rows; a fresh stretch leaves nothing of what came before."""
        if rows.starts_segment:
            self._parts.clear()
        self._parts.append(rows)
        oldest = rows.times[-1] - CUES.rows_retention
        while self._parts[0].times[-1] < oldest:
            self._parts.popleft()

    def segment(self, start: float, stop: float) -> FlightRows | None:
        """Return the rows from one flight time to another (s), as far as they are kept."""
        parts = [one for one in self._parts if one.times[-1] >= start and one.times[0] <= stop]
        if not parts:
            return None
        found = concatenate_rows(parts)
        inside = np.flatnonzero((found.times >= start) & (found.times <= stop))
        if not inside.size:
            return None
        return found.slice_rows(int(inside[0]), int(inside[-1]) + 1)

    def mean(self, channel: str, seconds: float) -> float | None:
        """Return the mean of a channel over the newest seconds, SI; None where it is missing."""
        if not self._parts:
            return None
        since = self._parts[-1].times[-1] - seconds
        newest = takewhile(lambda one: one.times[-1] > since, reversed(self._parts))
        values = np.concatenate([one[channel] for one in newest])
        values = values[np.isfinite(values)]
        return float(values.mean()) if values.size else None

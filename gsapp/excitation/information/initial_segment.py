"""The first seconds in the air, from which the noise of the day is heard."""

from __future__ import annotations

from collections import deque
from typing import Final

import numpy as np

from gsapp.excitation.flight_rows import FlightRows, concatenate_rows

CLIMB_EXCLUSION_TIME: Final = 8.0
"""Seconds after take-off that are left out: flaps, full throttle, a steep climb."""
_KEPT: Final = 60.0
"""Seconds of rows kept on the ground: a take-off is recognized some time after it was."""


class InitialSegmentCollector:
    """Waits for so many seconds of flight, and gives their rows once."""

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._parts: deque[FlightRows] = deque()
        self._given = False

    def process_rows(self, rows: FlightRows, took_off: float | None) -> FlightRows | None:
        """Take in the next rows; give the stretch as soon as all of it is there.

        Parameters
        ----------
        took_off : float or None
            Flight time, s; None on the ground.
        """
        if self._given or not len(rows):
            return None
        if rows.starts_segment:
            self._parts.clear()
        self._parts.append(rows)
        newest = float(rows.times[-1])
        if took_off is None:
            while self._parts[0].times[-1] < newest - _KEPT:
                self._parts.popleft()
            return None
        start = took_off + CLIMB_EXCLUSION_TIME
        if newest < start + self._seconds:
            return None
        heard = concatenate_rows(self._parts)
        inside = np.flatnonzero((heard.times >= start) & (heard.times <= start + self._seconds))
        self._given = True
        self._parts.clear()
        return heard.slice_rows(int(inside[0]), int(inside[-1]) + 1) if inside.size > 1 else None

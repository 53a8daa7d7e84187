"""Rows in frames of a fixed length.

Frames begin at whole multiples of their length, counted from time zero, so that what is judged of
them does not depend on how the stream was cut.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from gsapp.excitation.flight_rows import FlightRows
from gsapp.excitation.settings import ALERTS
from gsapp.quantities import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightFrame:
    """Some successive rows, and the state of the flight."""

    rows: FlightRows
    """One frame's worth; ``rows.fresh`` says whether nothing leads up to it."""
    time_since_takeoff: float = -1.0
    """Seconds since the take-off; negative on the ground, infinite where the record begins in the
    air."""
    time_airborne: float = 0.0
    """Seconds in the air so far."""
    height: float = math.nan
    """Above the field, m; NaN where unknown."""
    near_ground: bool = False
    """Whether it is so low that it may be landing; False where no height tells."""

    @property
    def time(self) -> float:
        """Return the time of the last row, s."""
        return float(self.rows.times[-1])

    @property
    def airborne(self) -> bool:
        return self.time_since_takeoff >= 0.0

    def mean(self, name: str) -> float:
        """Return the mean of a channel, NaN where it has no sample."""
        known = self._known(name)
        return float(known.mean()) if known.size else math.nan

    def last(self, name: str) -> float:
        """Return the last sample of a channel, NaN where it has none."""
        known = self._known(name)
        return float(known[-1]) if known.size else math.nan

    def _known(self, name: str) -> FloatArray:
        values = self.rows[name]
        return values[np.isfinite(values)]


class FrameSplitter:
    """Cuts rows into frames."""

    def __init__(self, rate: float) -> None:
        self._length = max(1, round(ALERTS.frame_duration * rate))
        self.restart()

    def restart(self) -> None:
        self._parts: list[FlightRows] = []
        self._held = 0
        self._fresh = True

    def split(self, rows: FlightRows) -> Iterator[FlightRows]:
        """Take in rows; give the frames that are complete."""
        if rows.starts_segment:
            self.restart()
        start = 0
        while start < len(rows):
            begun = (rows.first_index + start - self._held) % self._length
            stop = min(start + self._length - self._held - begun, len(rows))
            if begun == 0:  # else a stretch begins within a frame, the rest of which is let go
                self._parts.append(rows.slice_rows(start, stop))
                self._held += stop - start
            start = stop
            if self._held == self._length:
                yield self._whole()

    def _whole(self) -> FlightRows:
        parts, fresh = self._parts, self._fresh
        self._parts, self._held, self._fresh = [], 0, False
        values = np.concatenate([part.values for part in parts])
        with np.errstate(invalid="ignore"):
            values[~(np.abs(values) < ALERTS.max_value)] = np.nan
        return FlightRows(
            first_index=parts[0].first_index,
            times=np.concatenate([part.times for part in parts]),
            values=values,
            starts_segment=fresh,
        )

"""The channels of a flight as lines to be drawn, no finer than the screen shows."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np

from gsapp.flight.flight import Flight
from gsapp.flight.maneuvers.signals import SIGNALS, extract_signals
from gsapp.quantities import FloatArray

_SAMPLES_PER_COLUMN: Final = 3
"""Samples to a column up to which each is drawn by itself."""


class Traces:
    """The signals of a whole flight, with stand-ins where the channels themselves are missing."""

    def __init__(self, flight: Flight) -> None:
        self.times = flight.block.times
        rows = extract_signals(flight.block)
        self._series: Mapping[str, FloatArray] = {
            name: np.ascontiguousarray(rows[:, place])
            for place, name in enumerate(SIGNALS)
            if np.isfinite(rows[:, place]).any()
        }

    @property
    def channels(self) -> tuple[str, ...]:
        """Return what was measured, in the order of the signals."""
        return tuple(self._series)

    def value(self, name: str, time: float) -> float:
        """Return the sample (SI) nearest to a time, s; NaN where it is missing."""
        place = int(np.clip(np.searchsorted(self.times, time), 1, self.times.size - 1))
        if time - self.times[place - 1] <= self.times[place] - time:
            place -= 1
        return float(self._series[name][place])

    def line(
        self, name: str, start: float, stop: float, columns: int
    ) -> tuple[FloatArray, FloatArray]:
        """Return a line from start to stop, s, and one sample further on either side.

        Parameters
        ----------
        name : str
            One of `channels`.
        columns : int
            Of the picture. Where many samples share a column, it has its lowest and its highest
            value only; bins are counted from the first sample, so that a line that is moved does
            not flicker.

        Returns
        -------
        times, values : ndarray, shape (m,)
            s and SI; NaN where missing.
        """
        values = self._series[name]
        low, high = np.searchsorted(self.times, (start, stop))
        low, high = max(int(low) - 1, 0), min(int(high) + 1, values.size)
        if high - low <= _SAMPLES_PER_COLUMN * max(columns, 1):
            return self.times[low:high], values[low:high]
        size = -(-(high - low) // max(columns, 1))
        first = low // size * size
        edges = np.arange(first, high, size)
        part = values[first:high]
        both = np.empty(2 * edges.size)
        both[0::2] = np.fmin.reduceat(part, edges - first)
        both[1::2] = np.fmax.reduceat(part, edges - first)
        return np.repeat(self.times[edges], 2), both

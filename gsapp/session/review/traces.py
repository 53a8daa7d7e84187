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
        self._raw: dict[str, tuple[FloatArray, FloatArray]] = {}
        self.times = flight.block.times
        rows = extract_signals(flight.block)
        self._series: Mapping[str, FloatArray] = {
            name: np.ascontiguousarray(rows[:, index])
            for index, name in enumerate(SIGNALS)
            if np.isfinite(rows[:, index]).any()
        }

    @property
    def channels(self) -> tuple[str, ...]:
        """Return what was measured, in the order of the signals, then raw channels."""
        return (*self._series, *self._raw)

    def add(self, name: str, times: FloatArray, values: FloatArray) -> None:
        """Add a raw channel at its own times, s; shapes (n,)."""
        self._raw[name] = times, values

    def _samples(self, name: str) -> tuple[FloatArray, FloatArray]:
        return self._raw[name] if name in self._raw else (self.times, self._series[name])

    def value(self, name: str, time: float) -> float:
        """Return the sample (SI) nearest to a time, s; NaN where it is missing."""
        times, values = self._samples(name)
        place = int(np.clip(np.searchsorted(times, time), 1, max(times.size - 1, 1)))
        if place == times.size or time - times[place - 1] <= times[place] - time:
            place -= 1
        return float(values[place])

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
        all_times, values = self._samples(name)
        low, high = np.searchsorted(all_times, (start, stop))
        low, high = max(int(low) - 1, 0), min(int(high) + 1, values.size)
        if high - low <= _SAMPLES_PER_COLUMN * max(columns, 1):
            return all_times[low:high], values[low:high]
        size = -(-(high - low) // max(columns, 1))
        first = low // size * size
        edges = np.arange(first, high, size)
        part = values[first:high]
        both = np.empty(2 * edges.size)
        both[0::2] = np.fmin.reduceat(part, edges - first)
        both[1::2] = np.fmax.reduceat(part, edges - first)
        return np.repeat(all_times[edges], 2), both

"""The newest rows of a stretch: what a verdict looks back on."""

from __future__ import annotations

from typing import Final

import numpy as np

from gsapp.excitation.doublets.settings import DOUBLETS
from gsapp.excitation.flight_rows import FlightRows
from gsapp.flight.maneuvers.signals import SIGNALS
from gsapp.quantities import FloatArray

EXTRA_CHANNELS: Final = ("phi", "rate_switch", "density", "static_pressure", "temperature")
"""Channels kept beside the signals of the detection."""

_EXTRA_INDEX: Final = {name: len(SIGNALS) + k for k, name in enumerate(EXTRA_CHANNELS)}


class SignalHistory:
    """Keeps signals and a few more channels of the newest rows.

    Parameters
    ----------
    rate : float
        Of the rows, Hz.
    """

    def __init__(self, rate: float) -> None:
        self._kept = round(DOUBLETS.history_retention * rate)
        self._width = len(SIGNALS) + len(EXTRA_CHANNELS)
        self.clear()

    def clear(self) -> None:
        """Forget all rows."""
        self._times = np.empty(4 * self._kept)
        self._values = np.empty((4 * self._kept, self._width))
        self._count = 0

    def add(self, rows: FlightRows, signals: FloatArray) -> None:
        """Take in the next rows; what they lead to may be asked for row by row.

        Parameters
        ----------
        rows : FlightRows
        signals : ndarray, shape (n, len(SIGNALS))
            Of these rows, as far as they are believed.
        """
        count = len(rows)
        if self._count + count > self._times.size:
            kept = min(self._count, self._kept)
            start = self._count - kept
            room = max(4 * self._kept, kept + 2 * count)
            times, values = np.empty(room), np.empty((room, self._width))
            times[:kept] = self._times[start : self._count]
            values[:kept] = self._values[start : self._count]
            self._times, self._values, self._count = times, values, kept
        low, high = self._count, self._count + count
        self._times[low:high] = rows.times
        self._values[low:high, : len(SIGNALS)] = signals
        for name, place in _EXTRA_INDEX.items():
            self._values[low:high, place] = rows[name]
        self._count = high

    def segment(self, start: float, stop: float) -> tuple[FloatArray, FloatArray]:
        """Return times and signals from one time to another, both inclusive, s.

        Returns
        -------
        times : ndarray, shape (n,)
        signals : ndarray, shape (n, len(SIGNALS))
        """
        low, high = self._between(start, stop)
        return self._times[low:high], self._values[low:high, : len(SIGNALS)]

    def extra_channel(self, name: str, start: float, stop: float) -> FloatArray:
        """Return one of `EXTRA_CHANNELS` from one time to another, both inclusive, s."""
        low, high = self._between(start, stop)
        return self._values[low:high, _EXTRA_INDEX[name]]

    def _between(self, start: float, stop: float) -> tuple[int, int]:
        times = self._times[: self._count]
        low = np.searchsorted(times, start - 1e-9)
        return int(low), int(np.searchsorted(times, stop + 1e-9, side="right"))

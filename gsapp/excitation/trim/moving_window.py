"""Means, slopes and unrest over moving windows, tick by tick.

Each window is summed by itself, whatever number of ticks come at once: so the results are the same
to the last bit however a stream was cut.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gsapp.quantities import FloatArray

_LEAST_SHARE = 0.6
"""Share of the ticks of a window that must be there."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class WindowFit:
    """The straight line through each window."""

    mean: FloatArray
    """Shape (n, m). NaN, as all, where too much is missing."""
    slope: FloatArray
    """Shape (n, m). Per tick."""
    power: FloatArray
    """Shape (n, m). Mean square about the line."""


class MovingWindow:
    """The latest ticks, as many as a window is long.

    Parameters
    ----------
    length : int
        Ticks.
    columns : int
        Values of a tick.
    """

    def __init__(self, length: int, columns: int) -> None:
        self._length = length
        self._past = np.full((length - 1, columns), np.nan)
        self._lags = np.arange(length)
        self._places = self._lags - 0.5 * (length - 1)
        self._lever = float((self._places**2).sum())

    def fit_windows(self, ticks: FloatArray) -> WindowFit:
        """Return the lines through the windows that end at these ticks.

        Parameters
        ----------
        ticks : ndarray, shape (n, m)
            NaN where missing.
        """
        length = self._length
        joined = np.concatenate((self._past, ticks))
        self._past = joined[len(ticks) :]
        # Contiguous along each window: that fixes the order of every sum.
        places = np.arange(len(ticks))[:, np.newaxis] + self._lags
        windows = np.ascontiguousarray(joined.T[:, places])
        there = np.isfinite(windows)
        present = there.sum(axis=2)
        enough = present >= _LEAST_SHARE * length
        total = np.where(there, windows, 0.0).sum(axis=2)
        mean = np.where(enough, total / np.maximum(present, 1), np.nan)
        # What is missing counts as the mean.
        rest = np.where(there, windows - mean[:, :, np.newaxis], 0.0)
        slope = (rest * self._places).sum(axis=2) / self._lever
        power = np.maximum((rest * rest).sum(axis=2) - slope * slope * self._lever, 0.0) / length
        return WindowFit(
            mean=mean.T,
            slope=np.where(enough, slope, np.nan).T,
            power=np.where(enough, power, np.nan).T,
        )

"""Columns of a chart: bins of samples, aligned to the absolute sample index.

A column is either a whole number of samples wide, or one sample is a whole number of columns
wide. Either way a column means the same stretch of flight time however the picture was scrolled
there, so a column once painted stays right, and all charts share it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from gsapp.quantities import FloatArray

# The history answers quickest for bins that its own cells fill without a remainder.
_CELLS = ((16385, 4096), (1025, 256), (65, 16))
_WIDEST_SAMPLE = 64


class Samples(Protocol):
    """What is drawn from: `gsapp.session.history.History`, or the same methods elsewhere."""

    @property
    def channels(self) -> Sequence[str]:
        """Return the channels held."""

    @property
    def rate(self) -> float:
        """Return samples per second of the grid, Hz."""

    @property
    def revision(self) -> int:
        """Return a number that changes whenever what was drawn may have become wrong."""

    @property
    def start(self) -> float | None:
        """Return the time of the earliest sample of any channel, s."""

    @property
    def end(self) -> float | None:
        """Return the time of the latest sample of any channel, s."""

    def last(self, channel_id: str) -> tuple[float, float] | None:
        """Return time (s) and value (SI) of the latest sample of a channel."""

    def samples(self, channel_id: str, first: int, last: int) -> FloatArray:
        """Return the samples ``first <= k < last``, NaN where there is none."""

    def extremes(
        self, channel_id: str, first_bin: int, last_bin: int, bin_size: int
    ) -> tuple[FloatArray, FloatArray]:
        """Return lowest and highest value of the bins ``first_bin <= j < last_bin``."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ColumnScale:
    """How columns lie on the grid of samples.

    Attributes
    ----------
    rate : float
        Samples per second, Hz.
    samples : int
        Samples in a column.
    stretch : int
        Columns to a sample; either this or `samples` is 1.
    """

    rate: float
    samples: int = 1
    stretch: int = 1

    @property
    def seconds(self) -> float:
        """Return the duration of a column, s."""
        return self.samples / (self.rate * self.stretch)

    def column(self, time: float) -> int:
        """Return the column in which a time (s) lies."""
        # A thousandth of a sample makes up for what floating point took from a time on the grid.
        return math.floor((time * self.rate + 1e-3) * self.stretch / self.samples)

    def time(self, column: float) -> float:
        """Return the time at which a column begins, s."""
        return column * self.samples / (self.rate * self.stretch)


def choose_scale(window: float, width: int, rate: float) -> ColumnScale:
    """Return the finest scale at which `width` columns hold at least `window` seconds.

    Parameters
    ----------
    window : float
        Seconds to be seen.
    width : int
        Columns at hand.
    rate : float
        Samples per second, Hz.
    """
    wanted = max(window, 1e-3) * rate
    width = max(width, 1)
    if wanted <= width:
        return ColumnScale(rate=rate, stretch=min(int(width / wanted), _WIDEST_SAMPLE))
    samples = math.ceil(wanted / width - 1e-9)
    for least, cell in _CELLS:
        if samples >= least:
            samples = -(-samples // cell) * cell
            break
    return ColumnScale(rate=rate, samples=samples)


def column_extremes(
    history: Samples, channel_id: str, scale: ColumnScale, first: int, last: int
) -> tuple[FloatArray, FloatArray]:
    """Return lowest and highest value that a channel's line takes in a row of columns.

    Parameters
    ----------
    history : Samples
        Where the samples are.
    channel_id : str
        The channel, which the history must hold.
    scale : ColumnScale
        How columns lie on the samples.
    first, last : int
        ``first <= c < last``.

    Returns
    -------
    low, high : ndarray, shape (last - first,)
        SI units; NaN where nothing was measured. Where a sample is several columns wide, the
        columns between two samples hold the straight line between them, and nothing follows a
        sample whose successor is missing.
    """
    stretch = scale.stretch
    if stretch == 1:
        return history.extremes(channel_id, first, last, scale.samples)
    first_sample = first // stretch
    values = history.samples(channel_id, first_sample, -(-last // stretch) + 1)
    columns = np.arange(first, last)
    place = columns // stretch - first_sample
    part = columns % stretch
    begin, slope = values[place], np.diff(values)[place] / stretch
    one = begin + slope * part
    other = one + slope
    alone = (part == 0) & np.isnan(slope)
    one[alone] = other[alone] = begin[alone]
    return np.fmin(one, other), np.fmax(one, other)

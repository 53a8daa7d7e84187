"""Columns of a chart: bins of samples, aligned to the absolute sample index.

The columns of a chart hold exactly the time that was asked for, so that a column is as a rule no
whole number of samples wide: one holds 9 samples, the next one 10. A column means the same stretch
of flight time however the picture was scrolled there, so a column once painted stays right, and
all charts share it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Protocol

import numpy as np
import numpy.typing as npt

from gsapp.quantities import FloatArray

_CELLS = (4096, 256, 16)  # Samples of which the history keeps lowest and highest value.
_CELLS_IN_COLUMN = 4  # So many cells in a column are fine enough for its edges.


class SampleSource(Protocol):
    """What is drawn: a `SampleHistory`, or another object with its methods."""

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
    """How columns lie on the grid of samples: ``stretch`` columns on ``samples`` cells."""

    rate: float  # Samples per second, Hz.
    # A column is ``samples / stretch`` cells wide.
    samples: int = 1
    stretch: int = 1
    # Samples that always lie in one column together; 1 where a column is narrower than a sample.
    cell: int = 1

    @property
    def seconds(self) -> float:
        return self.samples * self.cell / (self.rate * self.stretch)

    @property
    def holds_samples(self) -> bool:
        """Return whether a sample is no wider than a column."""
        return self.samples >= self.stretch

    def column(self, time: float) -> int:
        """Return the column in which a time (s) lies."""
        # A thousandth of a sample makes up for what floating point took from a time on the grid.
        place = time * self.rate + 1e-3
        if self.holds_samples:
            return self.column_of(math.floor(place))
        return math.floor(place * self.stretch / self.samples)

    def column_of(self, index: int) -> int:
        """Return the column in which a sample lies."""
        return index // self.cell * self.stretch // self.samples

    def first_samples(self, first: int, last: int) -> npt.NDArray[np.int64]:
        columns = np.arange(first, last, dtype=np.int64)
        return -(-columns * self.samples // self.stretch) * self.cell

    def time(self, column: float) -> float:
        """Return the time at which a column begins, s."""
        cells = column * self.samples / self.stretch
        if self.holds_samples:
            cells = math.ceil(cells - 1e-9)
        return cells * self.cell / self.rate


def select_column_scale(window: float, width: int, rate: float) -> ColumnScale:
    """Return the scale at which `width` columns hold `window` seconds.

    Parameters
    ----------
    window : float
        Seconds to be seen.
    width : int
        Columns at hand.
    rate : float
        Samples per second, Hz.
    """
    samples = Fraction(max(window, 1e-3) * rate).limit_denominator(1000)
    each = max(samples, Fraction(1, 1000)) / max(width, 1)
    cell = next((cell for cell in _CELLS if each >= _CELLS_IN_COLUMN * cell), 1)
    each /= cell
    return ColumnScale(rate=rate, samples=each.numerator, stretch=each.denominator, cell=cell)


def column_extremes(
    history: SampleSource, channel_id: str, scale: ColumnScale, first: int, last: int
) -> tuple[FloatArray, FloatArray]:
    """Return lowest and highest value that a channel's line takes in a row of columns.

    Parameters
    ----------
    first, last : int
        ``first <= c < last``.

    Returns
    -------
    low, high : ndarray, shape (last - first,)
        SI units; NaN where nothing was measured. Where a sample is several columns wide, the
        columns between two samples hold the straight line between them, and nothing follows a
        sample whose successor is missing.
    """
    if not scale.holds_samples:
        return _interpolated_extremes(history, channel_id, scale, first, last)
    if scale.stretch == 1:
        return history.extremes(channel_id, first, last, scale.samples * scale.cell)
    begins = scale.first_samples(first, last + 1)
    if scale.cell == 1:
        low = high = history.samples(channel_id, int(begins[0]), int(begins[-1]))
    else:
        begins //= scale.cell
        low, high = history.extremes(channel_id, int(begins[0]), int(begins[-1]), scale.cell)
    cuts = begins[:-1] - begins[0]
    return np.fmin.reduceat(low, cuts), np.fmax.reduceat(high, cuts)


def _interpolated_extremes(
    history: SampleSource, channel_id: str, scale: ColumnScale, first: int, last: int
) -> tuple[FloatArray, FloatArray]:
    """Return the extremes of columns narrower than a sample; see `column_extremes`."""
    # Edges of the columns, in parts of which `stretch` make the distance of two samples.
    edges = np.arange(first, last + 1, dtype=np.int64) * scale.samples
    place = edges // scale.stretch
    part = (edges - place * scale.stretch) / scale.stretch
    values = history.samples(channel_id, int(place[0]), int(place[-1]) + 2)
    place -= place[0]
    here, slope = values[place], np.diff(values)[place]
    edge = np.where(part == 0.0, here, here + slope * part)
    # A column ends on the line on which it begins, or holds the next sample and ends on its line.
    holds = (place[1:] > place[:-1]) & (part[1:] > 0.0)
    width = scale.samples / scale.stretch
    end = np.where(holds, edge[1:], here[:-1] + slope[:-1] * (part[:-1] + width))
    sample = np.where(holds, here[1:], np.nan)
    return np.fmin(np.fmin(edge[:-1], end), sample), np.fmax(np.fmax(edge[:-1], end), sample)

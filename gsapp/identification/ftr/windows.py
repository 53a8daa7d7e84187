"""Stretches of flight that are listened to, in blocks of the grid."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gsapp.identification.ftr.regression_rows import RegressionRows


@dataclass(slots=True, kw_only=True)
class EstimationWindow:
    """A stretch of flight that is listened to.

    Attributes
    ----------
    start, stop : float
        From the origin of the grid, s; `stop` is None while the end is not known.
    overrun : bool
        Whether samples beyond the end were taken in before it was known.
    """

    start: float
    stop: float | None = None
    overrun: bool = False

    def blocks(self, rate: float, block: int) -> tuple[int, int]:
        """Return the number of the first block of the window, and of the one after the last.

        Parameters
        ----------
        rate : float
            Samples a second.
        block : int
            Samples of a block.
        """
        first = (math.ceil(self.start * rate - 1e-6) - 1) // block
        if self.stop is None:
            return first, 2**62
        return first, -(-math.floor(self.stop * rate + 1e-6) // block)

    def masked(self, first: int, rows: RegressionRows, rate: float, block: int) -> RegressionRows:
        """Return rows of whole blocks, from a number on, with what lies outside not valid."""
        count, length = rows.valid.shape
        places = (first + np.arange(count))[:, np.newaxis] * block + np.arange(length)
        times = places / rate
        inside = times >= self.start - 1e-9
        if self.stop is not None:
            inside &= times <= self.stop + 1e-9
        return RegressionRows(valid=rows.valid & inside, columns=rows.columns, running=rows.running)

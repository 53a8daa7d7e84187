"""Curves of a channel map: from the raw number of a field to a channel, by table or polynomial."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gsapp.quantities import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Curve:
    """What a raw number means, in the unit of the map's entry."""

    points: tuple[tuple[float, float], ...] = ()
    """Raw numbers, increasing, and their values: between them straight lines, which go on beyond
    the ends."""
    coefficients: tuple[float, ...] = ()
    """In place of points: ascending powers of the raw number."""

    def evaluate(self, raw: FloatArray) -> FloatArray:
        """Return the values of raw numbers, shape (n,); NaN stays NaN."""
        if self.coefficients:
            values = np.full_like(raw, self.coefficients[-1])
            for coefficient in self.coefficients[-2::-1]:
                values = values * raw + coefficient
            return values
        x, y = np.array(self.points).T
        # The straight line between two points, and beyond them that of the last two.
        place = np.clip(np.searchsorted(x, raw, side="right") - 1, 0, x.size - 2)
        share = (raw - x[place]) / (x[place + 1] - x[place])
        result: FloatArray = y[place] * (1.0 - share) + y[place + 1] * share
        return result

    def count_beyond(self, raw: FloatArray) -> int:
        """Return how many raw numbers lie beyond the ends of the table."""
        if not self.points:
            return 0
        low, high = self.points[0][0], self.points[-1][0]
        return int(np.count_nonzero((raw < low) | (raw > high)))

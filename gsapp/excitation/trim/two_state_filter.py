"""A filter for two states, one of which is seen."""

from __future__ import annotations

import math


class TwoStateKalmanFilter:
    """A Kalman filter of two states in plain floats: a step takes less than one of arrays would.

    Parameters
    ----------
    states : tuple of float
        At the start.
    stds : tuple of float
        Their standard deviations at the start.

    Attributes
    ----------
    first, second : float
        The states.
    """

    __slots__ = ("_p00", "_p01", "_p11", "first", "second")

    def __init__(self, states: tuple[float, float], spreads: tuple[float, float]) -> None:
        self.first, self.second = states
        self._p00, self._p01, self._p11 = spreads[0] ** 2, 0.0, spreads[1] ** 2

    @property
    def stds(self) -> tuple[float, float]:
        """Return the standard deviations of both states."""
        return math.sqrt(self._p00), math.sqrt(self._p11)

    def predict(
        self,
        states: tuple[float, float],
        cross: tuple[float, float],
        noise: tuple[float, float],
    ) -> None:
        """Go on by one step.

        Parameters
        ----------
        states : tuple of float
            After the step, as the caller's equations have it.
        cross : tuple of float
            How much the first state then depends on the second before, and the second on the
            first.
        noise : tuple of float
            Variances that the step adds.
        """
        self.first, self.second = states
        b, c = cross
        p00, p01, p11 = self._p00, self._p01, self._p11
        self._p00 = p00 + 2.0 * b * p01 + b * b * p11 + noise[0]
        self._p01 = c * p00 + (1.0 + b * c) * p01 + b * p11
        self._p11 = c * c * p00 + 2.0 * c * p01 + p11 + noise[1]

    def update_first(self, value: float, variance: float) -> None:
        """Take in a measurement of the first state."""
        total = self._p00 + variance
        k0, k1 = self._p00 / total, self._p01 / total
        miss = value - self.first
        self.first += k0 * miss
        self.second += k1 * miss
        self._p11 -= k1 * self._p01
        self._p01 -= k0 * self._p01
        self._p00 -= k0 * self._p00

    def update_second(self, value: float, variance: float) -> None:
        """Take in a measurement of the second state."""
        total = self._p11 + variance
        k0, k1 = self._p01 / total, self._p11 / total
        miss = value - self.second
        self.first += k0 * miss
        self.second += k1 * miss
        self._p00 -= k0 * self._p01
        self._p01 -= k1 * self._p01
        self._p11 -= k1 * self._p11

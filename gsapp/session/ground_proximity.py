"""Whether the aircraft is about to touch down, as far as its speed and its altitude tell.

Every landing ends below the stall speed. An alarm for it, one second before the wheels touch,
teaches the crew to ignore it; so limits that mean nothing near the ground wait there.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from gsapp.quantities import Block, FloatArray

SPEED_CHANNEL, ALTITUDE_CHANNEL = "Vc", "altitude"

_NEAR = 6.0
"""Height above the place of take-off that counts as near the ground, m."""
_GROUND_TIME = 5.0
"""Seconds of standing and rolling whose median altitude is that of the ground ..."""
_LEAST_TIME = 1.0
"""... or what there is of them, but no less than this."""
_WINDOW = 0.5
"""Seconds of which more than half must be near the ground: barometers are noisy."""


class GroundProximityMonitor:
    """Tells which samples were taken near the ground from which the aircraft took off.

    What comes out depends on the samples only, not on how they were cut into blocks.

    Parameters
    ----------
    flown_at : float
        Calibrated airspeed at which it certainly flies, m/s; the altitude of the ground is
        settled then, and once for the flight: a pitot that is blocked in flight lands nowhere.
    slow_at : float
        Calibrated airspeed below which it certainly does not fly, m/s.
    rate : float
        Of the grid, Hz.
    """

    def __init__(self, flown_at: float, slow_at: float, rate: float) -> None:
        self._flown_at = flown_at
        self._slow_at = slow_at
        self._longest = round(_GROUND_TIME * rate)
        self._least = round(_LEAST_TIME * rate)
        self._window = max(round(_WINDOW * rate), 1)
        self._altitudes: FloatArray = np.empty(0)
        self._ground: float | None = None
        self._flown = False
        self._last = np.zeros(self._window - 1, dtype=bool)
        self._next: int | None = None

    def feed(self, first: int, block: Block) -> npt.NDArray[np.bool_]:
        """Return for each sample, shape (n,), whether it is near the ground.

        Parameters
        ----------
        first : int
            Index of the first sample on the grid.
        """
        speed, altitude = block[SPEED_CHANNEL], block[ALTITUDE_CHANNEL]
        if not self._flown:
            self._learn(speed, altitude)
        if self._ground is None:
            return np.zeros(len(block), dtype=bool)
        if first != self._next:
            self._last[:] = False
        self._next = first + len(block)
        line = np.concatenate((self._last, np.abs(altitude - self._ground) < _NEAR))
        self._last = line[line.size - self._last.size :]
        counts = np.concatenate(((0,), np.cumsum(line)))
        return (counts[self._window :] - counts[: -self._window]) * 2 > self._window

    def _learn(self, speed: FloatArray, altitude: FloatArray) -> None:
        flown = np.flatnonzero(speed > self._flown_at)
        end = int(flown[0]) if flown.size else speed.size
        standing = altitude[:end][(speed[:end] < self._slow_at) & ~np.isnan(altitude[:end])]
        self._altitudes = np.concatenate((self._altitudes, standing))[-self._longest :]
        if flown.size:
            self._flown = True
            if self._altitudes.size >= self._least:
                self._ground = float(np.median(self._altitudes))

"""Engine vibration, as the gyros see it.

The fans turn at 117 to 417 Hz; the gyros have no filter before the converter, so the 100 Hz
samples show the difference to the nearest multiple of 100 Hz. Nothing here folds anything: the
phase of each fan is followed exactly, and the samples do the rest.
"""

from __future__ import annotations

import numpy as np

from gsapp.quantities import FloatArray


class EngineVibration:
    """Rates shaken by two or more engines out of balance.

    Imbalance pushes with the square of the speed; the rate that it shakes up grows with the
    speed itself.

    Parameters
    ----------
    amplitude : float
        Of all engines together at `full_speed`, on each axis, rad/s.
    full_speed : float
        Of the engines, rad/s.
    engines : int
        How many.
    random : numpy.random.Generator
        For the phases at the start and the directions in which each engine shakes.
    """

    def __init__(
        self, amplitude: float, full_speed: float, engines: int, random: np.random.Generator
    ) -> None:
        self._full_speed = max(full_speed, 1e-9)
        share = random.uniform(0.8, 1.2, (engines, 3)) / np.sqrt(engines)
        self._amplitude = amplitude * share
        self._offset = random.uniform(0.0, 2.0 * np.pi, (engines, 3))
        self._phase = random.uniform(0.0, 2.0 * np.pi, engines)
        self._speed: FloatArray | None = None

    def vibration_rates(self, speeds: FloatArray, dt: float) -> FloatArray:
        """Return the rates at the next samples.

        Parameters
        ----------
        speeds : ndarray, shape (n, engines)
            Of the engines at these samples, rad/s.
        dt : float
            Between samples, s.

        Returns
        -------
        ndarray, shape (n, 3)
            p, q, r; rad/s.
        """
        if not len(speeds):
            return np.empty((0, 3))
        before = np.vstack([speeds[:1] if self._speed is None else self._speed, speeds])
        turned = 0.5 * dt * (before[1:] + before[:-1])
        # Added one after the other, so that pieces give what the whole gives.
        phases = np.cumsum(np.vstack([self._phase, turned]), axis=0)[1:]
        self._phase = phases[-1]
        self._speed = speeds[-1:]
        waves = np.sin(phases[:, :, None] + self._offset)
        size = self._amplitude * (speeds / self._full_speed)[:, :, None]
        return np.asarray((size * waves).sum(axis=1))

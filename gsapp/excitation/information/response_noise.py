"""The noise that maximum likelihood will find in its residuals: how strong, and of what color."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.excitation.information.settings import INFORMATION
from gsapp.identification.statistics.correlation import STATISTICS
from gsapp.quantities import FloatArray

_USUAL_NOISE: Final = {
    **dict.fromkeys(("alpha", "beta"), INFORMATION.vane_noise),
    **dict.fromkeys(("p", "q", "r"), INFORMATION.gyro_noise),
    **dict.fromkeys(("ax", "ay", "an"), INFORMATION.accelerometer_noise),
}
"""Noise of instruments of which the aircraft file says nothing."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ResponseNoise:
    """Noise of some responses, as residuals show it."""

    responses: tuple[str, ...]
    rate: float
    """Samples per second."""
    autocovariance: FloatArray
    """Shape (2 Lg + 1, n_responses, n_responses). Autocovariance, SI; the middle one is that of lag
    0."""
    duration: float
    """Length of the stretches that it was heard in, s; 0 where it is assumed."""

    @property
    def variances(self) -> FloatArray:
        """Return the variance of each response, shape (n_responses,)."""
        return np.asarray(self.autocovariance[len(self.autocovariance) // 2].diagonal())

    def select(self, responses: Sequence[str]) -> ResponseNoise:
        """Return the noise of some of the responses, in this order."""
        places = [self.responses.index(name) for name in responses]
        return ResponseNoise(
            responses=tuple(responses),
            rate=self.rate,
            autocovariance=np.ascontiguousarray(self.autocovariance[:, places][:, :, places]),
            duration=self.duration,
        )

    def autocovariance_to(self, count: int) -> FloatArray:
        """Return the autocovariance to at most so many lags."""
        middle = len(self.autocovariance) // 2
        reach = min(count, middle)
        return self.autocovariance[middle - reach : middle + reach + 1]


def assumed_noise(aircraft: Aircraft, responses: Sequence[str], rate: float) -> ResponseNoise:
    """Return white noise as strong as the aircraft file says of its instruments.

    That is what there is before anything was heard in flight: gusts are not in it.

    Parameters
    ----------
    rate : float
        Samples per second.
    """
    stated = aircraft.sensors.noise_in_flight
    stds = [stated[name] or _USUAL_NOISE[name] for name in responses]
    lagged = np.zeros((2 * STATISTICS.max_lags + 1, len(stds), len(stds)))
    lagged[STATISTICS.max_lags] = np.diag(np.square(stds))
    return ResponseNoise(responses=tuple(responses), rate=rate, autocovariance=lagged, duration=0.0)


def pool_noise(heard: Sequence[ResponseNoise]) -> ResponseNoise:
    """Return the mean over stretches of the same responses, each by its length.

    Far lags come from those stretches that were long enough to show them.
    """
    reach = max(len(one.autocovariance) // 2 for one in heard)
    total = np.zeros_like(max(heard, key=lambda one: len(one.autocovariance)).autocovariance)
    weights = np.zeros(2 * reach + 1)
    for one in heard:
        own = len(one.autocovariance) // 2
        part = slice(reach - own, reach + own + 1)
        total[part] += one.duration * one.autocovariance
        weights[part] += one.duration
    return ResponseNoise(
        responses=heard[0].responses,
        rate=heard[0].rate,
        autocovariance=total / weights[:, None, None],
        duration=float(weights[reach]),
    )

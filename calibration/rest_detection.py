"""Instruments at rest: whether all of them stood still, and their volts while they did.

Samples are gathered into stretches of equal length, counted from time zero, and only whole ones
are judged: the result does not depend on how the samples were cut when they came in. A rest goes
on for as long as the samples of each half second are quiet and the means of all lie together; the
last of those that do not begins the next one.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

import numpy as np
import numpy.typing as npt
from scipy.special import stdtrit

from calibration.adc import ADC_RESOLUTION
from calibration.settings import CALIBRATION
from gsapp.quantities import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class SampleSegment:
    """All samples of one stretch."""

    number: int
    """It begins at ``number * length``."""
    times: FloatArray
    """Shape (n,). s."""
    volts: FloatArray
    """Shape (n, n_channels). V; NaN where missing."""
    count: FloatArray
    mean: FloatArray
    std: FloatArray
    """Shape (n_channels,). Of each channel's samples; the mean is NaN where there are none."""

    @classmethod
    def from_samples(cls, number: int, times: FloatArray, volts: FloatArray) -> SampleSegment:
        """Return a stretch with its statistics."""
        present = np.isfinite(volts)
        count = present.sum(axis=0).astype(np.float64)
        divisor = np.maximum(count, 1.0)
        mean = np.where(present, volts, 0.0).sum(axis=0) / divisor
        off = np.where(present, volts - mean, 0.0)
        std = np.sqrt((off * off).sum(axis=0) / np.maximum(count - 1.0, 1.0))
        return cls(number, times, volts, count, np.where(count > 0.0, mean, np.nan), std)


class SampleSegmenter:
    """Cuts samples into stretches.

    Parameters
    ----------
    channels : sequence of str
        Which of the samples are kept, in this order.
    length : float
        Of a stretch, s.
    """

    def __init__(self, channels: Sequence[str], length: float) -> None:
        self._channels = tuple(channels)
        self._length = length
        self.restart()

    def restart(self) -> None:
        """Forget the samples of the stretch that is not whole yet."""
        self._times = np.empty(0)
        self._volts = np.empty((0, len(self._channels)))

    def feed(
        self, times: npt.ArrayLike, volts: Mapping[str, npt.ArrayLike]
    ) -> Iterator[SampleSegment]:
        """Take samples and yield the stretches that are whole.

        Parameters
        ----------
        times : array_like, shape (n,)
            Flight time, s, increasing.
        volts : mapping of str to array_like, shape (n,)
            By channel, V; NaN where missing. Other channels are left out.
        """
        t = np.asarray(times, dtype=np.float64)
        if not t.size:
            return
        columns = [np.asarray(volts[name], dtype=np.float64) for name in self._channels]
        self._times = np.concatenate([self._times, t])
        self._volts = np.concatenate([self._volts, np.column_stack(columns)])
        # A sample that rounding left just short of the border belongs to what it begins.
        numbers = np.floor(self._times / self._length + 1e-6).astype(np.int64)
        # The last stretch may go on; it waits for the first sample after it.
        whole = int(np.searchsorted(numbers, numbers[-1]))
        first_times, first_volts = self._times, self._volts
        self._times, self._volts = self._times[whole:], self._volts[whole:]
        for number in np.unique(numbers[:whole]):
            low, high = np.searchsorted(numbers, (number, number + 1))
            yield SampleSegment.from_samples(
                int(number), first_times[low:high], first_volts[low:high]
            )


RestState = Literal["absent", "moving", "resting", "rested"]


@dataclass(frozen=True, slots=True, kw_only=True)
class RestCriteria:
    """What still counts as rest, V."""

    std: float
    """Largest standard deviation of the samples within half a second."""
    mean_spread: float
    """Largest distance between the means of any two half seconds."""
    noise_factor: float = math.inf
    """The same in standard deviations that noise of the samples alone gives such a mean, where that
    is less; a step of the converter is always granted. Infinite where slow movements are no
    matter."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RestPeriod:
    """A period of rest."""

    start: float
    end: float
    """Flight time, s."""
    volts: Mapping[str, float]
    std: Mapping[str, float]
    """Mean and standard deviation of single samples by instrument, V."""
    uncertainty: Mapping[str, float]
    """Of the mean, half width at 95 %, V. From the scatter of half-second means, so that slow noise
    counts in full; no finer than what the converter's steps allow."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RestStatus:
    """How a rest goes on."""

    state: RestState
    """No samples yet; not still; still, but not for long enough; still for long enough."""
    progress: float = 0.0
    """Share of the time of rest that has passed, 0 to 1."""
    rest: RestPeriod | None = None
    """The rest so far; None before there are two blocks of it."""
    why: str = ""
    """What moved last, in words; empty where nothing has."""


class RestMonitor:
    """Watches several instruments until all have been at rest for long enough."""

    def __init__(self, limits: Mapping[str, RestCriteria], *, seconds: float = 5.0) -> None:
        self._channels = tuple(limits)
        self._std = np.array([limits[name].std for name in self._channels])
        self._wander = np.array([limits[name].mean_spread for name in self._channels])
        self._noises = np.array([limits[name].noise_factor for name in self._channels])
        self._needed = max(math.ceil(seconds / CALIBRATION.rest_block - 1e-9), 2)
        self._cutter = SampleSegmenter(self._channels, CALIBRATION.rest_block)
        self._run: deque[SampleSegment] = deque(maxlen=CALIBRATION.max_blocks)
        self._found: RestPeriod | None = None
        self._why = ""
        self._moving = False

    @property
    def channels(self) -> tuple[str, ...]:
        return self._channels

    def restart(self) -> None:
        """Forget what was: a new rest must be seen from its beginning."""
        self._run.clear()
        self._cutter.restart()
        self._found = None
        self._why = ""
        self._moving = False

    def feed(self, times: npt.ArrayLike, volts: Mapping[str, npt.ArrayLike]) -> None:
        """Take samples.

        Parameters
        ----------
        times : array_like, shape (n,)
            Flight time, s, increasing.
        volts : mapping of str to array_like, shape (n,)
            By instrument, V; NaN where missing. Instruments that are not watched are left out.
        """
        for stretch in self._cutter.feed(times, volts):
            self._judge(stretch)

    @property
    def status(self) -> RestStatus:
        if not self._run:
            state: RestState = "moving" if self._moving else "absent"
            return RestStatus(state=state, why=self._why)
        progress = min(len(self._run) / self._needed, 1.0)
        if self._found is None and len(self._run) > 1:
            self._found = self._rest()
        state = "rested" if progress >= 1.0 else "resting"
        return RestStatus(state=state, progress=progress, rest=self._found, why=self._why)

    def _judge(self, block: SampleSegment) -> None:
        self._found = None
        if self._run and block.number != self._run[-1].number + 1:
            self._run.clear()
            self._why = "there was a gap in the samples"
        if np.any(block.count < CALIBRATION.min_block_samples):
            missing = self._channels[int(np.argmin(block.count))]
            self._run.clear()
            self._moving = True
            self._why = (
                f"{missing} gave no samples at {block.number * CALIBRATION.rest_block:.1f} s"
            )
            return
        if np.any(block.std > self._std):
            self._run.clear()
            self._moving = True
            self._why = self._told(block, "shook", block.std, self._std)
            return
        means = np.array([*(known.mean for known in self._run), block.mean])
        spread = np.ptp(means, axis=0)
        allowed = self._allowed(block)
        if np.any(spread > allowed):
            self._run.clear()
            self._why = self._told(block, "moved", spread, allowed)
        self._run.append(block)

    def _allowed(self, block: SampleSegment) -> FloatArray:
        """Return how far means may lie apart, V: noise is that within the blocks."""
        blocks = (*self._run, block)
        noise = np.sqrt(np.mean([known.std**2 / known.count for known in blocks], axis=0))
        judged = np.isfinite(self._noises)
        allowed = self._wander.copy()
        by_noise = np.maximum(self._noises[judged] * noise[judged], ADC_RESOLUTION)
        allowed[judged] = np.minimum(allowed[judged], by_noise)
        return allowed

    def _told(self, block: SampleSegment, did: str, found: FloatArray, allowed: FloatArray) -> str:
        worst = int(np.argmax(found / allowed))
        return (
            f"{self._channels[worst]} {did} by {1e3 * found[worst]:.1f} mV "
            f"at {block.number * CALIBRATION.rest_block:.1f} s"
        )

    def _rest(self) -> RestPeriod:
        count = np.array([block.count for block in self._run])
        means = np.array([block.mean for block in self._run])
        stds = np.array([block.std for block in self._run])
        mean = np.sum(count * means, axis=0) / np.sum(count, axis=0)
        std = np.sqrt(np.mean(stds**2 + (means - mean) ** 2, axis=0))
        blocks = len(means)
        scatter = np.std(means, axis=0, ddof=1) / math.sqrt(blocks)
        # Without noise to blur the steps, the mean is known to half a step only.
        steps = np.where(std < 0.5 * ADC_RESOLUTION, 0.5 * ADC_RESOLUTION, 0.0)
        uncertainty = np.hypot(float(stdtrit(blocks - 1, 0.975)) * scatter, steps)
        return RestPeriod(
            start=self._run[0].number * CALIBRATION.rest_block,
            end=(self._run[-1].number + 1) * CALIBRATION.rest_block,
            volts=self._named(mean),
            std=self._named(std),
            uncertainty=self._named(uncertainty),
        )

    def _named(self, values: FloatArray) -> Mapping[str, float]:
        return MappingProxyType(dict(zip(self._channels, values.tolist(), strict=True)))

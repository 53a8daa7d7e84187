"""Samples gathered into stretches of equal length, counted from time zero.

What is judged by whole stretches does not depend on how the samples were cut when they came in.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

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

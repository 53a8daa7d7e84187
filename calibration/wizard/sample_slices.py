"""Samples cut into tenths of a second of flight time, whatever pieces they came in."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from calibration.wizard.settings import WIZARD
from gsapp.quantities import Block, FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SampleSlice:
    """The samples of a tenth of a second."""

    start: float
    end: float
    """Flight time, s."""
    times: FloatArray
    """Shape (n,). s."""
    volts: Mapping[str, FloatArray]
    """Shape (n,). By instrument, V; NaN where missing."""
    excitation: FloatArray
    """Shape (n,). V; NaN where missing."""

    @property
    def present(self) -> bool:
        """Return whether any instrument gave any volts."""
        return any(bool(np.isfinite(samples).any()) for samples in self.volts.values())


class SampleSlicer:
    """Gathers blocks and gives whole slices.

    Parameters
    ----------
    channels : sequence of str
        The instruments.
    """

    def __init__(self, channels: Sequence[str]) -> None:
        self._channels = tuple(channels)
        self._times = np.empty(0)
        self._values = np.empty((0, len(self._channels) + 1))
        self._last = -np.inf

    def feed(self, block: Block) -> Iterator[SampleSlice]:
        if not len(block):
            return
        if block.times[0] < self._last - WIZARD.clock_restart:
            self._times, self._values = self._times[:0], self._values[:0]
            self._last = -np.inf
        new = block.times > self._last
        names = [*(f"{name}_volts" for name in self._channels), "excitation"]
        values = np.full((len(block), len(names)), np.nan)
        for at, name in enumerate(names):
            if name in block:
                values[:, at] = block[name]
        self._times = np.concatenate([self._times, block.times[new]])
        self._values = np.concatenate([self._values, values[new]])
        if not self._times.size:
            return
        self._last = float(self._times[-1])
        numbers = np.floor(self._times / WIZARD.slice_duration + 1e-9).astype(np.int64)
        whole = int(np.searchsorted(numbers, numbers[-1]))
        pieces = [
            (int(number), *np.searchsorted(numbers, (number, number + 1)))
            for number in np.unique(numbers[:whole])
        ]
        times, values = self._times, self._values
        self._times, self._values = times[whole:], values[whole:]
        for number, first, last in pieces:
            part = values[first:last]
            yield SampleSlice(
                start=number * WIZARD.slice_duration,
                end=(number + 1) * WIZARD.slice_duration,
                times=times[first:last],
                volts={name: part[:, at] for at, name in enumerate(self._channels)},
                excitation=part[:, -1],
            )

"""Faults at work on the volts of the bench.

What is mounted the other way round (``reversed``) is so from the beginning: see `virtual`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from calibration.adc import ADC_FULL_SCALE
from gsapp.quantities import FloatArray
from gsapp.virtual.ad_converter import DAQ_CHANNELS
from gsapp.virtual.bench.bench_faults import BenchFault

_SCRATCH, _LOST = 0.04, 0.6
"""A bad contact: standard deviation, V, and how far it falls when lost, V."""
_ROOM = (0.25, 0.45)
"""V between where the wiper stands at first and the end of the converter, where it is clipped."""


class BenchFaultInjector:
    """What faults make of volts, stretch after stretch."""

    def __init__(self, faults: Sequence[BenchFault], random: np.random.Generator) -> None:
        self._faults = tuple(faults)
        self._random = random.spawn(len(self._faults))
        self._open = [bool(own.integers(2)) for own in self._random]
        self._upward = [bool(own.integers(2)) for own in self._random]
        self._room = [float(own.uniform(*_ROOM)) for own in self._random]
        self._at_first: FloatArray | None = None

    def apply(self, volts: FloatArray) -> FloatArray:
        """Return volts (n, 20) with the faults in them."""
        if not self._faults or not len(volts):
            return volts
        harmed = volts.copy()
        if self._at_first is None:
            self._at_first = harmed[0].copy()
        for index, fault in enumerate(self._faults):
            column = DAQ_CHANNELS.index(fault.channel)
            first = float(self._at_first[column])
            if fault.kind == "dead":
                harmed[:, column] = 0.0 if self._open[index] else first
            elif fault.kind == "swapped":
                other = DAQ_CHANNELS.index(fault.other)
                harmed[:, [column, other]] = harmed[:, [other, column]]
            elif fault.kind == "noisy":
                harmed[:, column] += self._scratching(self._random[index], len(volts))
            elif fault.kind == "clipped":
                end = (
                    ADC_FULL_SCALE - self._room[index] if self._upward[index] else self._room[index]
                )
                harmed[:, column] += end - first
        return harmed

    def _scratching(self, random: np.random.Generator, count: int) -> FloatArray:
        drawn = random.standard_normal((count, 2))
        lost = np.abs(drawn[:, 1]) > 2.17  # three samples in a hundred
        return np.asarray(_SCRATCH * drawn[:, 0] - np.where(lost, _LOST, 0.0))

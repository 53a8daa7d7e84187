"""What the filter believes of noise: instruments, turbulence, and unmeasured moments."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gsapp.discrepancy.filtering.record import Record
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import DEGREE

GUSTS = ("u", "v", "w")
GUST_ROWS = (0, 2, 1)
"""States that gusts along x, y, z enter: V, beta, alpha."""
_FIRST_GUST = 0.1
_FIRST_MOMENT = 0.01
_SMALLEST: Mapping[str, float] = {
    "V": 0.02,
    "ax": 0.01,
    "ay": 0.01,
    "an": 0.01,
    **dict.fromkeys(("alpha", "beta", "phi", "theta"), 0.005 * DEGREE),
    **dict.fromkeys(("p", "q", "r"), 0.02 * DEGREE),
}
"""No instrument is believed better than this (SI), standard deviation."""


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseModel:
    """Covariances of the filter.

    Turbulence is first order: in gust g with time constant L/V, ``g' = -V/L g + w``, and the same
    white noise w drives the airspeed or flow angle. L is an effective length: Dryden's shape for
    side and up gusts has 0.7 of its scale length.

    Attributes
    ----------
    variances : mapping of str to float
        White noise of each channel per sample, SI squared.
    gusts : tuple of float
        Intensity of the white noise behind the gusts along x, y, z, m^2/s^3.
    lengths : tuple of float
        Effective scale lengths, m.
    moments : float
        Intensity of white noise in p', q', r', rad^2/s^3: noise of measured surfaces, and all
        else that no channel shows.
    """

    variances: Mapping[str, float]
    gusts: tuple[float, float, float] = (_FIRST_GUST,) * 3
    lengths: tuple[float, float, float] = (150.0, 60.0, 40.0)
    moments: float = _FIRST_MOMENT

    def with_value(self, name: str, value: float) -> NoiseModel:
        """Return the model with one of its numbers changed: ``gust.w``, ``length.w``, ``moments``."""
        if name == "moments":
            return replace(self, moments=value)
        kind, _, axis = name.partition(".")
        place = GUSTS.index(axis)
        old = self.gusts if kind == "gust" else self.lengths
        new = tuple(value if index == place else one for index, one in enumerate(old))
        if kind == "gust":
            return replace(self, gusts=(new[0], new[1], new[2]))
        return replace(self, lengths=(new[0], new[1], new[2]))

    def value(self, name: str) -> float:
        """Return one of its numbers; see `with_value`."""
        if name == "moments":
            return self.moments
        kind, _, axis = name.partition(".")
        return (self.gusts if kind == "gust" else self.lengths)[GUSTS.index(axis)]

    def with_variances(self, variances: Mapping[str, float]) -> NoiseModel:
        """Return the model with other instrument noise."""
        bounded = {name: max(one, _SMALLEST[name] ** 2) for name, one in variances.items()}
        return replace(self, variances=bounded)

    def process(self, V: float, n_states: int) -> FloatArray:
        """Return the intensity of process noise, shape (n_states + 3, n_states + 3)."""
        scales = (1.0, 1.0 / V**2, 1.0 / V**2)
        found = np.zeros((n_states + 3, n_states + 3))
        for place, (row, intensity, scale) in enumerate(
            zip(GUST_ROWS, self.gusts, scales, strict=True)
        ):
            entry = np.zeros(n_states + 3)
            entry[row] = entry[n_states + place] = 1.0
            found += intensity * scale * np.outer(entry, entry)
        for row in (3, 4, 5):
            found[row, row] += self.moments
        return found

    def gust_rms(self, V: float) -> dict[str, float]:
        """Return the standard deviation (m/s) of the gusts along u, v, w at airspeed V."""
        return {
            name: float(np.sqrt(0.5 * intensity * length / V))
            for name, intensity, length in zip(GUSTS, self.gusts, self.lengths, strict=True)
        }


def first_noise(records: Sequence[Record]) -> NoiseModel:
    """Return where tuning starts: third differences of the channels, which motion leaves alone."""
    found: dict[str, list[float]] = {}
    for record in records:
        for column, name in enumerate(record.channels):
            samples = np.where(record.counted[:, column], record.measured[:, column], np.nan)
            differences = np.diff(samples, 3)
            differences = differences[np.isfinite(differences)]
            if differences.size > 10:
                # Robust, so that the corners of an input do not count; 20 = 1 + 9 + 9 + 1.
                size = float(np.median(np.abs(differences))) / 0.6745
                found.setdefault(name, []).append(size * size / 20.0)
    variances = {name: float(np.median(values)) for name, values in found.items()}
    return NoiseModel(variances=variances).with_variances(variances)

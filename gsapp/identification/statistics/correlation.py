"""Autocovariance of residuals by FFT: samples that do not count, lags that do not cross gaps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt
from scipy.fft import irfft, next_fast_len, rfft

from gsapp.quantities import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class ResidualStatisticsSettings:
    """Engineering choices unless a source is named."""

    singular_tolerance: float = 1e-11  # Of the largest eigenvalue: smaller is rounding.
    min_own_variance_share: float = 1e-8  # Of a variance less that of a common offset.
    max_lags: int = 100  # Notes, section 7: 50 to 100 give bounds within 10 %.
    strong_correlation: float = 0.95  # Two parameters cannot be told apart beyond.
    contradiction_sigmas: float = 4.0
    """Of a response against the others: 0 of 600 in calm air beyond 4, 4 beyond 3."""
    max_named: int = 3  # Derivatives that a sentence on a response names.

    # Whiteness.
    portmanteau_lags: int = 20  # Lags of the portmanteau test.
    low_frequency: float = 2.0  # Frequency, Hz, below which power is low-frequency.
    significance_level: float = 0.001  # Probability below which residuals are not white.
    min_samples: int = 20  # Samples that the test takes.

    # Turbulence.
    gust_band: tuple[float, float] = (0.5, 4.0)  # Frequencies of gusts, Hz.
    max_rate_share: float = 0.2  # Of the samples a second: where the band ends in a slow record.
    noise_frequency: float = 8.0  # Frequency, Hz, from which residuals are noise.
    min_force_coherence: tuple[float, float] = (0.6, 0.5)
    """Coherence of forces from which gusts are found; the second where kinematics are certain."""
    kinematic_sigmas: float = 5.0
    """Deviations from which they are: 180 calm virtual records at 10 Hz stay below 3.4, those of
    ATTAS below 4.1."""
    min_kinematic_coherence: float = 0.25  # Coherence of kinematics from which gusts are found.
    min_noise_ratio: float = 3.0  # Density in the band over that of the noise.
    min_gust: float = 0.05  # m/s in the band: smaller ones would be reported as 0.0 m/s.
    taper_share: float = 0.3  # Share of a segment over which its ends fade in and out.
    min_segment_length: float = 3.0  # s: fewer have too few frequencies.
    min_frequencies: int = 10  # Frequencies in the band that the coherence takes.


STATISTICS: Final = ResidualStatisticsSettings()


BoolArray = npt.NDArray[np.bool_]
ComplexArray = npt.NDArray[np.complex128]


def default_lags(samples: int) -> int:
    """Return how many lags to take for so many samples: 100, or a quarter of a short record."""
    return max(1, min(STATISTICS.max_lags, samples // 4))


class LagLayout:
    """Where samples stand in one long row in which lags cannot cross from segment to segment.

    Parameters
    ----------
    count : int
        Samples in all.
    segments : sequence of slice or None
        Stretches of contiguous samples; None is one.
    lags : int
        Zeros after each segment.

    Attributes
    ----------
    pieces : list of (slice, slice)
        Of each segment: where its samples are, and where they stand in the row.
    length : int
        Of the row.
    whole : bool
        Whether there is but one segment.
    """

    def __init__(self, count: int, segments: Sequence[slice] | None, lags: int) -> None:
        parts = [slice(0, count)] if segments is None else list(segments)
        self.lags = lags
        self.pieces: list[tuple[slice, slice]] = []
        start = 0
        for part in parts:
            first, last, _ = part.indices(count)
            if last > first:
                self.pieces.append((slice(first, last), slice(start, start + last - first)))
                start += last - first + lags
        self.whole = len(self.pieces) == 1
        self.length = next_fast_len(max(start, 2 * lags + 1), real=True)

    def scatter(self, columns: FloatArray, row: FloatArray) -> None:
        """Write columns (n, ...) into a row (length, ...) that is zero elsewhere."""
        for source, target in self.pieces:
            row[target] = columns[source]

    def lagged_sums(self, columns: FloatArray) -> FloatArray:
        """Return sum_k x_k[a] x_(k+j)[b] for j = -lags ... lags.

        `columns`, shape (n, m).

        Shape (2 lags + 1, m, m). The middle one is that of lag 0.
        """
        spectra = self._spectra(columns)
        return self.lags_of(spectra.conj()[:, :, None] * spectra[:, None, :])

    def autocovariance_sums(self, columns: FloatArray) -> FloatArray:
        """Return the lagged sums of each column with itself alone, shape (2 lags + 1, m)."""
        spectra = self._spectra(columns)
        return self.lags_of(spectra.conj() * spectra)

    def _spectra(self, columns: FloatArray) -> ComplexArray:
        row = np.zeros((self.length, columns.shape[1]))
        self.scatter(columns, row)
        spectra: ComplexArray = rfft(row, axis=0)
        return spectra

    def lags_of(self, cross: ComplexArray) -> FloatArray:
        """Return the lagged sums that belong to a cross spectrum (n_frequencies, ...)."""
        sums = irfft(cross, n=self.length, axis=0)
        found: FloatArray = np.concatenate((sums[-self.lags :], sums[: self.lags + 1]))
        return found

    @property
    def frequency_weights(self) -> FloatArray:
        """Return what to multiply products of spectra by, so that they add up to sums over time."""
        shares = np.full(self.length // 2 + 1, 1.0 / self.length)
        # The spectrum of a real row: all frequencies but the ends count twice.
        shares[1 : (self.length + 1) // 2] *= 2.0
        return shares

    def pair_counts(self, counted: BoolArray) -> FloatArray:
        """Return how many pairs of samples that count lie j apart, as `lagged_sums`."""
        found: FloatArray
        if self.whole and counted.all():
            apart = np.abs(np.arange(-self.lags, self.lags + 1))
            found = np.maximum(len(counted) - apart, 0.0)[:, None, None]
        else:
            found = np.rint(self.lagged_sums(counted.astype(np.float64)))
        return found

    def pair_normalization(self, counted: BoolArray) -> FloatArray:
        """Return the factors that turn sums over pairs into autocovariances, as `lagged_sums`."""
        count = len(counted)
        pairs = self.pair_counts(counted)
        shrink = 1.0 - np.abs(np.arange(-self.lags, self.lags + 1)) / count
        factors: FloatArray = shrink[:, None, None] / np.maximum(pairs, 1.0)
        return factors

    def spectrum_of_lags(self, lagged: FloatArray) -> ComplexArray:
        """Return sum_j D_j exp(i w j) for D of shape (2 lags + 1, m, m)."""
        row = np.zeros((self.length, *lagged.shape[1:]))
        row[: self.lags + 1] = lagged[self.lags :]
        row[-self.lags :] = lagged[: self.lags]
        found: ComplexArray = rfft(row, axis=0).conj()
        return found


def residual_autocovariance(v: FloatArray, layout: LagLayout) -> FloatArray:
    """Return C_j of residuals for j = -lags ... lags, shape (2 lags + 1, m, m).

    C_j = (1/nt) sum_k v_k v_(k+j)' where all samples count. Where some do not, the mean over the
    pairs that count takes its place, times 1 - |j|/nt, which is the same for a full record.
    """
    counted = np.isfinite(v)
    sums = layout.lagged_sums(np.where(counted, v, 0.0))
    return sums * layout.pair_normalization(counted)


def bartlett(lags: int) -> FloatArray:
    """Return the taper 1 - |j|/(lags + 1) for j = -lags ... lags."""
    taper: FloatArray = 1.0 - np.abs(np.arange(-lags, lags + 1)) / (lags + 1.0)
    return taper

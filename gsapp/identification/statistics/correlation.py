"""Autocovariance of residuals by FFT: samples that do not count, lags that do not cross gaps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from gsapp.quantities import FloatArray

FEWEST_LAGS, MOST_LAGS = 50, 100
"""Notes, section 7: with 50 to 100 lags the corrected bound is right within 10 %."""


def usual_lags(samples: int) -> int:
    """Return how many lags to take for so many samples: a tenth, from 50 to 100 if they allow.

    A short record cannot tell 50 lags of its correlation; it gets a quarter of its samples.
    """
    return max(1, min(max(FEWEST_LAGS, samples // 10), MOST_LAGS, samples // 4))


class Layout:
    """Where samples stand in one long row in which lags cannot cross from segment to segment.

    Parameters
    ----------
    count : int
        Samples in all.
    segments : sequence of slice or None
        Stretches of contiguous samples; None is one.
    lags : int
        Zeros after each segment.
    """

    def __init__(self, count: int, segments: Sequence[slice] | None, lags: int) -> None:
        parts = [slice(0, count)] if segments is None else list(segments)
        self.lags = lags
        self._pieces: list[tuple[slice, slice]] = []
        start = 0
        for part in parts:
            first, last, _ = part.indices(count)
            if last > first:
                self._pieces.append((slice(first, last), slice(start, start + last - first)))
                start += last - first + lags
        self.length = next_fast_len(max(start, 2 * lags + 1), real=True)

    def spectrum(self, columns: FloatArray) -> FloatArray:
        """Return the transform of columns (n, ...) in the layout, shape (n_frequencies, ...)."""
        laid = np.zeros((self.length, *columns.shape[1:]))
        for source, target in self._pieces:
            laid[target] = columns[source]
        found: FloatArray = rfft(laid, axis=0)
        return found

    def lagged_sums(self, columns: FloatArray) -> FloatArray:
        """Return sum_k x_k[a] x_(k+j)[b] for j = -lags ... lags.

        Parameters
        ----------
        columns : ndarray, shape (n, m)

        Returns
        -------
        ndarray, shape (2 lags + 1, m, m)
            The middle one is that of lag 0.
        """
        spectra = self.spectrum(columns)
        cross = spectra.conj()[:, :, None] * spectra[:, None, :]
        sums = irfft(cross, n=self.length, axis=0)
        found: FloatArray = np.concatenate((sums[-self.lags :], sums[: self.lags + 1]))
        return found

    def spectrum_of_lags(self, lagged: FloatArray) -> FloatArray:
        """Return sum_j D_j exp(i w j) for D of shape (2 lags + 1, m, m)."""
        row = np.zeros((self.length, *lagged.shape[1:]))
        row[: self.lags + 1] = lagged[self.lags :]
        row[-self.lags :] = lagged[: self.lags]
        found: FloatArray = rfft(row, axis=0).conj()
        return found


def autocovariance(
    v: FloatArray, lags: int, segments: Sequence[slice] | None = None
) -> tuple[FloatArray, Layout]:
    """Return C_j of residuals for j = -lags ... lags, shape (2 lags + 1, m, m), and the layout.

    C_j = (1/nt) sum_k v_k v_(k+j)' where all samples count. Where some do not, the mean over the
    pairs that count takes its place, times 1 - |j|/nt, which is the same for a full record.
    """
    count = len(v)
    layout = Layout(count, segments, lags)
    counted = np.isfinite(v)
    clean = np.where(counted, v, 0.0)
    sums = layout.lagged_sums(clean)
    if counted.all() and segments is None:
        return sums / count, layout
    pairs = np.rint(layout.lagged_sums(counted.astype(np.float64)))
    shrink = 1.0 - np.abs(np.arange(-lags, lags + 1)) / count
    return sums / np.maximum(pairs, 1.0) * shrink[:, None, None], layout


def bartlett(lags: int) -> FloatArray:
    """Return the taper 1 - |j|/(lags + 1) for j = -lags ... lags."""
    taper: FloatArray = 1.0 - np.abs(np.arange(-lags, lags + 1)) / (lags + 1.0)
    return taper

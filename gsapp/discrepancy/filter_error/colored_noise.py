"""Colored noise of instruments: first-order recursions from sample to sample, taken in blocks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gsapp.discrepancy.filter_error.noise_model import NoiseModel
from gsapp.quantities import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ColoredNoise:
    """The channels with colored noise, and what a block makes of it.

    With e of variance `driving_variance` from sample to sample, noise goes ``n' = rho n + e``.

    Attributes
    ----------
    channel_indices : ndarray of int, shape (n_colored,)
        Of the channels.
    driving_variance : ndarray, shape (n_colored,)
        Variance of what each sample adds, SI squared.
    stds : ndarray, shape (n_colored,)
        Standard deviation of the noise.
    variance_of_means : ndarray, shape (n_colored,)
        Of its mean over a block.
    decay : ndarray, shape (n_colored,)
        Share of the noise at a block's start that is left at its end.
    mean_share : ndarray, shape (n_colored,)
        Share of it in the mean over the block.
    by_end, by_mean : ndarray, shape (n_colored, block)
        Share of what the second sample of a block, the third ... and the one after it add, in the
        noise at the block's end and in the mean over it.
    """

    channel_indices: NDArray[np.intp]
    driving_variance: FloatArray
    stds: FloatArray
    variance_of_means: FloatArray
    decay: FloatArray
    mean_share: FloatArray
    by_end: FloatArray
    by_mean: FloatArray

    @classmethod
    def from_noise_model(
        cls, noise: NoiseModel | None, channels: Sequence[str], block: int
    ) -> ColoredNoise:
        """Return what a noise model makes of these channels in blocks of so many samples."""
        known = {} if noise is None else noise.correlations
        names = [name for name in channels if name in known]
        rho = np.array([known[name] for name in names])
        added = np.array([noise.variances[name] for name in names if noise is not None])
        powers: FloatArray = rho[:, None] ** np.arange(block + 1.0)
        # Of what comes in at sample k of a block, samples k to block - 1 show something.
        sums = np.cumsum(powers[:, :block], axis=1) / block
        by_mean = np.hstack((sums[:, :-1][:, ::-1], np.zeros((len(rho), 1))))
        shown = sums[:, -1]
        variance = added / (1.0 - rho**2)
        return cls(
            channel_indices=np.array([channels.index(name) for name in names], dtype=np.intp),
            driving_variance=added,
            stds=np.sqrt(variance),
            variance_of_means=shown**2 * variance + (by_mean**2).sum(axis=1) * added,
            decay=powers[:, block],
            mean_share=shown,
            by_end=powers[:, :block][:, ::-1],
            by_mean=by_mean,
        )

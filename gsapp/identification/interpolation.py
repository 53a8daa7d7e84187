"""Curves put in place of the chords that a slow channel was drawn with.

An attitude that comes at half the rate of the grid stands on it with straight lines between its
samples. In a short period of 11 rad/s these chords cut off 0.2 percent of the motion: many times
what the smooth answer of an autopilot has of noise, and just what a wrong scale would do.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from scipy.interpolate import CubicSpline

from gsapp.identification.preparation_settings import PREPARATION
from gsapp.quantities import Block, FloatArray

INTERPOLATED_CHANNELS: Final = ("phi", "theta")
"""Channels that are smooth between samples: integrals of what the gyros show."""


def interpolate_held_samples(block: Block) -> Block:
    """Return a block whose slow attitude channels are curved between their own samples."""
    columns = [
        k
        for k, name in enumerate(block.channels)
        if name.partition(".")[0] in INTERPOLATED_CHANNELS
    ]
    if not columns:
        return block
    values = block.values.copy()
    for column in columns:
        values[:, column] = interpolate_cubic(values[:, column])
    return Block(channels=block.channels, times=block.times, values=values)


def interpolate_cubic(samples: FloatArray) -> FloatArray:
    """Return a signal with cubics in place of its chords, shape (n,); itself where it has none.

    Where a chord ends is seen by the signal itself: in between, and nowhere else, three samples
    always lie on a line.
    """
    ends = _knot_indices(samples)
    if ends is None:
        return samples
    out = samples.copy()
    known = np.isfinite(samples[ends])
    breaks = np.flatnonzero(np.diff(known.astype(int))) + 1
    for run in np.split(np.arange(ends.size), breaks):
        if known[run[0]] and run.size >= PREPARATION.min_knots:
            own = ends[run]
            inside = np.arange(own[0], own[-1] + 1)
            out[inside] = CubicSpline(own, samples[own])(inside)
            out[own] = samples[own]
    return out


def _knot_indices(samples: FloatArray) -> np.ndarray[tuple[int], np.dtype[np.intp]] | None:
    """Return where the chords of a signal end; None where it is not made of chords."""
    bends = np.full(samples.size, np.nan)
    bends[1:-1] = np.abs(np.diff(samples, 2))
    judged = np.isfinite(bends)
    usual = float(np.sqrt(np.mean(bends[judged] ** 2))) if judged.any() else 0.0
    if usual == 0.0:
        return None
    straight = bends < PREPARATION.collinearity_tolerance * usual
    for length in range(2, PREPARATION.max_interval + 1):
        for first in range(length):
            end = np.zeros(samples.size, dtype=bool)
            end[first::length] = True
            between, at = judged & ~end, judged & end
            if not (between.any() and at.any()):
                continue
            if (
                straight[between].mean() > PREPARATION.min_linear_share
                and straight[at].mean() < PREPARATION.max_linear_knot_share
            ):
                return np.flatnonzero(end)
    return None

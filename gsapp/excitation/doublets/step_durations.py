"""How long each step of an input lasted: from half way there to half way on to the next.

A surface takes a tenth of a second from one side to the other. Half way up and half way down are
as far apart as the stick stood there, however quick the servo is, and wherever it stops at last.
"""

from __future__ import annotations

from itertools import accumulate, pairwise

import numpy as np

from gsapp.flight.maneuvers.input_shape import SurfaceInput, smooth_samples
from gsapp.flight.maneuvers.maneuver_grade import ManeuverSamples
from gsapp.flight.maneuvers.signals import SIGNAL_COLUMNS
from gsapp.quantities import FloatArray

_AROUND = 0.3
"""Seconds before and after an input in which its edges are looked for."""


def measure_step_durations(passage: ManeuverSamples, one: SurfaceInput) -> tuple[float, ...]:
    """Return the length of each step of an input, s.

    Parameters
    ----------
    passage : ManeuverSamples
    one : SurfaceInput
        One of its surfaces.
    """
    low, high = np.searchsorted(passage.times, (one.t_start - _AROUND, one.t_end + _AROUND))
    times, samples = passage.times[low:high], passage.rows[low:high, SIGNAL_COLUMNS[one.surface]]
    there = np.isfinite(samples)
    times, samples = times[there], samples[there]
    lengths = tuple(length for _, length in one.excursions)
    if times.size < 3:
        return lengths
    level = smooth_samples(samples, float(np.median(np.diff(times))))
    peaks = _peaks(times, level, one)
    heights = [one.trim_before, *(float(level[place]) for place in peaks), one.trim_after]
    middles = [0.5 * (former + next_) for former, next_ in pairwise(heights)]
    edges = [_crossed(times, level, middles[0], peaks[0], -1)]
    edges += [
        _crossed(times, level, *one_edge, 1) for one_edge in zip(middles[1:], peaks, strict=True)
    ]
    found = tuple(later - former for former, later in pairwise(edges))
    return found if min(found) > 0.0 else lengths


def _peaks(times: FloatArray, level: FloatArray, one: SurfaceInput) -> list[int]:
    """Return where each step is furthest to its side."""
    ends = accumulate((length for _, length in one.excursions), initial=one.t_start)
    found = []
    for (side, _), (start, stop) in zip(one.excursions, pairwise(ends), strict=True):
        low, high = np.searchsorted(times, (start, stop))
        low = min(int(low), times.size - 1)
        found.append(low + int(np.argmax(side * level[low : max(int(high), low + 1)])))
    return found


def _crossed(
    times: FloatArray, level: FloatArray, middle: float, peak: int, direction: int
) -> float:
    """Return when the level passed a value next to a peak, after it (1) or before it (-1), s."""
    beyond = (level - middle) * np.sign(level[peak] - middle)
    outside = np.flatnonzero(beyond <= 0.0)
    outside = outside[outside > peak] if direction > 0 else outside[outside < peak]
    if not outside.size:
        return float(times[-1 if direction > 0 else 0])
    place = int(outside[0] if direction > 0 else outside[-1])
    inner = place - direction
    share = beyond[inner] / (beyond[inner] - beyond[place])
    return float(times[inner] + share * (times[place] - times[inner]))

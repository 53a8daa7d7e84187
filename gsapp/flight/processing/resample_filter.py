"""Resampling and zero-phase filtering of uneven, gappy records.

Filtering after the fact shifts phase unless it runs both ways (notes, section 6). Missing samples
stay missing: each stretch without a gap is treated by itself.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np
from scipy import signal
from scipy.interpolate import CubicSpline

from gsapp.flight.settings import FLIGHT_DATA
from gsapp.flight.uniform_grid import median_step
from gsapp.foundation import FlightError
from gsapp.quantities import CIRCULAR_CHANNELS, STEPWISE_CHANNELS, Block, FloatArray, base_id

_MOST_NUMBERS = 500_000_000
"""Samples of all channels that still fit into the memory of a field laptop, 4 GB."""

Interpolation = Literal["linear", "cubic"]


def low_pass(block: Block, corner: float) -> Block:
    """Filter every channel both ways with a fourth-order Butterworth low-pass.

    Both ways makes eight orders and no shift of phase; the corner is where 3 dB are lost after
    both. A stretch too short for the filter to settle in is left out (missing). Switches and
    counts stay as they are.

    Parameters
    ----------
    corner : float
        Hz.

    Raises
    ------
    FlightError
        If the corner does not lie below half the sample rate.
    """
    rate = 1.0 / median_step(block.times)
    if not 0.0 < corner < 0.5 * rate:
        raise FlightError(
            f"a filter at {corner:g} Hz does not suit {rate:g} samples per second; choose a corner "
            f"between 0 and {0.5 * rate:g} Hz"
        )
    values = np.full(block.values.shape, np.nan)
    for column, name in enumerate(block.channels):
        own = block.values[:, column]
        for rows in _gap_free_segments(block.times, own):
            # A slow channel has its own rate on the common grid.
            period = median_step(block.times[rows]) if rows.size > 1 else np.nan
            if base_id(name) in STEPWISE_CHANNELS or not rows.size > 1 or corner * period >= 0.5:
                values[rows, column] = own[rows]
                continue
            sections = _filter(corner * period)
            if rows.size > _min_segment_samples(corner * period):
                smooth = signal.sosfiltfilt(sections, _unwrap_angles(name, own[rows]))
                values[rows, column] = _wrap_angles(name, smooth, own[rows])
    return Block(channels=block.channels, times=block.times, values=values)


def check_sample_rate(rate: float) -> None:
    """Raise `FlightError` where there can be no such rate, samples per second."""
    if not 0.0 < rate < 1e6:
        raise FlightError(
            f"{rate:g} samples per second are not possible; give more than 0 and less than a "
            "million"
        )


def resample(
    block: Block, rate: float, *, corner: float | None = None, kind: Interpolation = "linear"
) -> Block:
    """Lay a block on an even grid of another rate.

    Before decimation a zero-phase low-pass takes out what the new rate cannot hold.

    Parameters
    ----------
    rate : float
        Samples per second; the new grid is ``k / rate``.
    corner : float, optional
        Of the low-pass, Hz; by default 0.4 of the new rate where that is lower than the old one,
        else none. 0 turns it off.
    kind : {"linear", "cubic"}
        Interpolation between samples; never over a gap. Switches and counts keep the former one.

    Raises
    ------
    FlightError
        If the rate is not positive, the block too short, the result too long for a computer, or
        if the filter lets through what the new rate cannot hold.
    """
    check_sample_rate(rate)
    if len(block) < 2:
        raise FlightError("fewer than two samples cannot be resampled")
    before = 1.0 / median_step(block.times)
    if corner is None and rate < before * (1.0 - 1e-6):
        corner = FLIGHT_DATA.decimation_cutoff * rate
    first = int(np.ceil(block.times[0] * rate - 1e-6))
    last = int(np.floor(block.times[-1] * rate + 1e-6))
    count = (last - first + 1) * len(block.channels)
    if count > _MOST_NUMBERS:
        raise FlightError(
            f"{rate:g} samples per second would make {count / 1e6:.0f} million numbers of this "
            "flight; choose a lower rate, or fewer channels"
        )
    if corner:
        if 0.5 * rate < min(corner, 0.5 * before):
            raise FlightError(
                f"a filter at {corner:g} Hz passes more than {rate:g} samples per second can "
                f"represent; choose {FLIGHT_DATA.decimation_cutoff * rate:g} Hz or less, "
                "or 0 for none"
            )
        block = low_pass(block, corner)
    times = np.arange(first, last + 1) / rate
    values = np.full((times.size, len(block.channels)), np.nan)
    for column, name in enumerate(block.channels):
        own = block.values[:, column]
        for rows in _gap_free_segments(block.times, own):
            at = block.times[rows]
            inside = slice(*np.searchsorted(times, (at[0] - 1e-9, at[-1] + 1e-9)))
            new, straight = times[inside], _unwrap_angles(name, own[rows])
            if base_id(name) in STEPWISE_CHANNELS:
                found = own[rows][np.searchsorted(at, new + 1e-9, side="right") - 1]
            elif kind == "cubic" and rows.size > 3:
                found = CubicSpline(at, straight)(new)
            else:
                found = np.interp(new, at, straight)
            values[inside, column] = _wrap_angles(name, found, own[rows])
    return Block(channels=block.channels, times=times, values=values)


def _gap_free_segments(times: FloatArray, samples: FloatArray) -> Iterator[np.ndarray]:
    """Yield the rows of each stretch of samples without a gap."""
    there = np.flatnonzero(np.isfinite(samples))
    if not there.size:
        return
    steps = np.diff(times[there])
    longest = FLIGHT_DATA.max_gap_periods * float(np.median(steps)) if steps.size else np.inf
    yield from np.split(there, np.flatnonzero(steps > longest) + 1)


def _filter(corner: float) -> FloatArray:
    """Return sections of the one-way filter for a corner in cycles per sample, both ways."""
    # Two passes lose 3 dB where one loses 1.5: the corner of one pass lies higher, on the warped
    # axis of the bilinear transform.
    wider = (np.sqrt(2.0) - 1.0) ** (-0.5 / FLIGHT_DATA.filter_order)
    one_way = 2.0 / np.pi * np.arctan(wider * np.tan(np.pi * corner))
    sections: FloatArray = signal.butter(
        FLIGHT_DATA.filter_order, min(one_way, 0.999), output="sos"
    )
    return sections


def _min_segment_samples(corner: float) -> int:
    return 3 * (2 * (FLIGHT_DATA.filter_order // 2) + 1) + int(0.5 / corner)


def _unwrap_angles(name: str, samples: FloatArray) -> FloatArray:
    return np.unwrap(samples) if base_id(name) in CIRCULAR_CHANNELS else samples


def _wrap_angles(name: str, samples: FloatArray, given: FloatArray) -> FloatArray:
    """Return angles in the turn that the channel was given in."""
    if base_id(name) not in CIRCULAR_CHANNELS:
        return samples
    start = 0.0 if given.min() >= 0.0 and given.max() > np.pi else -np.pi
    wound: FloatArray = (samples - start) % (2.0 * np.pi) + start
    return wound

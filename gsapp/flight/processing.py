"""Cut, merge, resample, filter, rename: what a record goes through between tools.

Filtering after the fact shifts phase unless it runs both ways (notes, section 6). Missing samples
stay missing: each stretch without a gap is treated by itself.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Literal, NamedTuple

import numpy as np
from scipy import signal
from scipy.interpolate import CubicSpline

from gsapp.flight.settings import FLIGHT_DATA
from gsapp.flight.uniform_grid import median_step, overlay_on_grid
from gsapp.foundation import FlightError
from gsapp.quantities import (
    CIRCULAR_CHANNELS,
    STEPWISE_CHANNELS,
    Block,
    FloatArray,
    base_id,
    channel,
)


class TimeWindow(NamedTuple):
    """From the first to the last time kept, s of flight time; both are kept."""

    start: float
    stop: float


def parse_time_window(text: str) -> TimeWindow:
    """Read ``START:STOP``, seconds; either may be empty for the end of the flight."""
    first, separator, last = text.partition(":")
    try:
        start = float(first) if first.strip() else -math.inf
        stop = float(last) if last.strip() else math.inf
    except ValueError:
        separator = ""
    if not separator or not start < stop:
        raise FlightError(
            f"'{text}' is not a window of time; write START:STOP in seconds, the earlier first, "
            "such as 120.5:131"
        )
    return TimeWindow(start, stop)


def cut_windows(block: Block, windows: Sequence[TimeWindow]) -> Block:
    """Keep what lies in any of the windows, each of which must hold a sample.

    One missing row is left between two windows that do not touch, so that nothing later takes them
    for one stretch. Times stay as they are.
    """
    times = block.times
    kept = np.zeros(times.size, dtype=bool)
    for window in windows:
        inside = (times >= window.start - 1e-9) & (times <= window.stop + 1e-9)
        if not inside.any():
            whole = f"{times[0]:g} to {times[-1]:g} s" if times.size else "no duration"
            raise FlightError(
                f"no sample lies from {window.start:g} to {window.stop:g} s; the flight covers "
                f"{whole}"
            )
        kept |= inside
    rows = np.flatnonzero(kept)
    after = rows[:-1][np.diff(rows) > 1] + 1
    with_gaps = np.union1d(rows, after)
    values = block.values[with_gaps].copy()
    values[np.isin(with_gaps, after)] = np.nan
    return Block(channels=block.channels, times=times[with_gaps], values=values)


def rename_channels(block: Block, names: Mapping[str, str]) -> Block:
    """Give channels, by their old ids, other ids of the vocabulary; two may be swapped.

    `FlightError` if two would have one id, or the new one measures another quantity.
    """
    for old, new in names.items():
        block[old]
        if channel(old).quantity != channel(new).quantity:
            raise FlightError(
                f"{old} measures {channel(old).quantity} and {new} {channel(new).quantity}; "
                "rename it to a channel of the same quantity"
            )
    renamed = tuple(names.get(name, name) for name in block.channels)
    if len(set(renamed)) != len(renamed):
        double = next(name for name in renamed if renamed.count(name) > 1)
        raise FlightError(
            f"after renaming two channels would be called {double}; rename the other one too, "
            f"to {double}.2 for a second sensor"
        )
    return Block(channels=renamed, times=block.times, values=block.values)


def drop_channels(block: Block, names: Sequence[str]) -> Block:
    """Leave channels out."""
    for name in names:
        block[name]
    return block.select([name for name in block.channels if name not in names])


_MOST_NUMBERS = 500_000_000
"""Samples of all channels that still fit into the memory of a field laptop, 4 GB."""

Interpolation = Literal["linear", "cubic"]


def low_pass(block: Block, corner: float) -> Block:
    """Filter every channel both ways with a fourth-order Butterworth low-pass, corner in Hz.

    Both ways makes eight orders and no shift of phase; the corner is where 3 dB are lost after
    both. It lies below half the sample rate. A stretch too short for the filter to settle in is
    left out (missing). Switches and counts stay as they are.
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
    if base_id(name) not in CIRCULAR_CHANNELS:
        return samples
    start = 0.0 if given.min() >= 0.0 and given.max() > np.pi else -np.pi
    wound: FloatArray = (samples - start) % (2.0 * np.pi) + start
    return wound


Conflict = Literal["first", "last", "both"]
"""Which record wins where two have the same channel; ``both`` keeps the second as ``.2``."""


def shift_time(block: Block, seconds: float) -> Block:
    """Return a block with a time added to its own."""
    return Block(channels=block.channels, times=block.times + seconds, values=block.values)


def merge_records(
    blocks: Sequence[Block], *, conflict: Conflict = "first", rate: float | None = None
) -> Block:
    """Merge records of one flight by time, by default at the rate of the quickest one.

    Where two have a channel, the samples of the winner, ``first`` or ``last``, count and the other
    fills its holes; or ``both`` are kept, the later ones as a second sensor.
    """
    if not any(len(block) for block in blocks):
        raise FlightError("the flights contain no samples; nothing to merge")
    if rate is None:
        rate = max(1.0 / median_step(block.times) for block in blocks if len(block) > 1)
    on_grid = [resample(block, rate, corner=0.0) for block in blocks]
    if conflict == "both":
        on_grid = _number_repeated_channels(on_grid)
    merged = overlay_on_grid(on_grid if conflict == "last" else on_grid[::-1], rate)
    return merged.select(list(dict.fromkeys(n for block in on_grid for n in block.channels)))


def append_records(blocks: Sequence[Block], *, pause: float = 10.0) -> Block:
    """Put records one after the other, a pause (s) without samples between them.

    Of the same channels or not; what one lacks is missing there.
    """
    filled = [block for block in blocks if len(block)]
    if not filled:
        raise FlightError("the flights contain no samples; nothing to append")
    rate = 1.0 / median_step(filled[0].times)
    parts: list[Block] = []
    end = None
    for block in filled:
        moved = block if end is None else shift_time(block, end + pause - float(block.times[0]))
        parts.append(resample(moved, rate, corner=0.0))
        end = float(moved.times[-1])
    return overlay_on_grid(parts, rate)


def _number_repeated_channels(blocks: Sequence[Block]) -> list[Block]:
    """Give each repetition of a channel the next free number."""
    taken: set[str] = set()
    renamed: list[Block] = []
    for block in blocks:
        names = []
        for name in block.channels:
            base, number, new = name.partition(".")[0], 1, name
            while new in taken:
                number += 1
                new = f"{base}.{number}"
            taken.add(new)
            names.append(new)
        renamed.append(Block(channels=tuple(names), times=block.times, values=block.values))
    return renamed

"""How far one record lies behind another of the same motion, to a row."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import fft

from gsapp.flight.onboard_log.settings import ALIGNMENT
from gsapp.quantities import Block, FloatArray

_PREFERRED_CHANNELS = (
    "q",
    "p",
    "r",
    "alpha",
    "an",
    "ay",
    "phi",
    "theta",
    "de",
    "da",
    "dr",
    "qbar",
    "V",
)
_MOST_ROWS = 1 << 22


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordLag:
    """How far one record lies behind another."""

    rows: int
    """Rows to add to the log's, so that it lies on the live record."""
    correlation: float
    """Of the two there, 0 to 1."""

    @property
    def is_reliable(self) -> bool:
        """Return whether the two are alike there."""
        return self.correlation >= ALIGNMENT.min_correlation


def estimate_record_lag(live: Block, log: Block, rate: float) -> RecordLag | None:
    """Find how far a log lies behind a live record of the same motion.

    Parameters
    ----------
    live, log : Block
        On the grid ``k / rate``.
    rate : float
        Rows per second.

    Returns
    -------
    Lag or None
        None if no channel of both moves alike anywhere. One row, or less, counts as none: it is
        the delay of interpolation, and both carry the vehicle's own clock.
    """
    names = common_channels(live, log)
    if not names:
        return None
    found = find_lag(live, log, rate, names)
    if not found.is_reliable:
        return None
    return found if abs(found.rows) > 1 else RecordLag(rows=0, correlation=found.correlation)


def find_lag(live: Block, log: Block, rate: float, names: Sequence[str]) -> RecordLag:
    """Find the lag at which channels of two records are most alike, to a row.

    The masked, normalized cross-correlation of the channels, averaged, has its peak there.

    Parameters
    ----------
    live, log : Block
        On the grid ``k / rate``.
    rate : float
        Rows per second.
    names : sequence of str
        Channels of both.

    Returns
    -------
    RecordLag
        With a correlation of 0 where one record is too long to be compared.
    """
    live_first, live_values = fill_omitted_rows(live, names, rate)
    log_first, log_values = fill_omitted_rows(log, names, rate)
    if max(len(live_values), len(log_values)) > _MOST_ROWS:
        return RecordLag(rows=0, correlation=0.0)
    correlation = _correlation(live_values, log_values, rate)
    best = int(np.argmax(correlation))
    lag = best - (len(log_values) - 1) + live_first - log_first
    return RecordLag(rows=lag, correlation=float(correlation[best]))


def common_channels(
    live: Block,
    log: Block,
    leave_out: Collection[str] = (),
    most: int = ALIGNMENT.compared_channels,
) -> list[str]:
    """Return up to `most` channels of both that move, the telling ones first."""
    shared = [name for name in live.channels if name in log.channels and name not in leave_out]
    ordered = [name for name in _PREFERRED_CHANNELS if name in shared]
    ordered += [name for name in shared if name not in ordered]
    moving = [
        name for name in ordered if all(_sample_range(block[name]) > 0.0 for block in (live, log))
    ]
    return moving[:most]


def _sample_range(values: FloatArray) -> float:
    there = values[~np.isnan(values)]
    return float(np.ptp(there)) if there.size else 0.0


def fill_omitted_rows(block: Block, names: Sequence[str], rate: float) -> tuple[int, FloatArray]:
    """Return the first row and all rows without omissions; a pause is filled with NaN.

    Returns
    -------
    first : int
        On the grid ``k / rate``.
    values : ndarray, shape (n, len(names))
    """
    index = np.rint(block.times * rate).astype(np.int64)
    size = int(index[-1] - index[0]) + 1
    values = np.full((min(size, _MOST_ROWS + 1), len(names)), np.nan)
    inside = index - index[0] < len(values)
    for place, name in enumerate(names):
        values[index[inside] - index[0], place] = block[name][inside]
    return int(index[0]), values


def _correlation(live: FloatArray, log: FloatArray, rate: float) -> FloatArray:
    """Return the mean correlation at every lag, from the log's end on the live's beginning on."""
    size = len(live) + len(log) - 1
    padded = fft.next_fast_len(size, real=True)

    def sums(one: FloatArray, other: FloatArray) -> FloatArray:
        product = fft.rfft(one, padded) * fft.rfft(other[::-1], padded)
        result: FloatArray = fft.irfft(product, padded)[:size]
        return result

    total = np.zeros(size)
    for place in range(live.shape[1]):
        a, b = live[:, place], log[:, place]
        a_there, b_there = (~np.isnan(a)).astype(float), (~np.isnan(b)).astype(float)
        a, b = np.nan_to_num(a - np.nanmean(a)), np.nan_to_num(b - np.nanmean(b))
        energy = sums(a * a, b_there) * sums(a_there, b * b)
        both = sums(a_there, b_there)
        least = max(
            ALIGNMENT.min_overlap * rate,
            ALIGNMENT.min_overlap_share * min(a_there.sum(), b_there.sum()),
        )
        # Rounding of the transform leaves a little where nothing is.
        usable = (both >= least) & (energy > 1e-12 * energy.max())
        total[usable] += sums(a, b)[usable] / np.sqrt(energy[usable])
    result: FloatArray = total / live.shape[1]
    return result

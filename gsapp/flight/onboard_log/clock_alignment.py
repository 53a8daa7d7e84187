"""How two clocks stand to each other over a flight: offset, drift, and how sure both are.

First one record is laid on the other to a row. Then stretches of the flight are compared one by
one, each with its own lag; a straight line through the lags is the offset and the drift. Where the
lags lie on no line, the records are not of one motion, however alike they look in one place.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import fft

from gsapp.flight.onboard_log.log_state import LogClock
from gsapp.flight.settings import ALIGNMENT
from gsapp.quantities import Block, FloatArray
from gsapp.quantities.constants import MAD_TO_STD

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
        return self.correlation >= ALIGNMENT.min_correlation


def estimate_record_lag(live: Block, log: Block, rate: float) -> RecordLag | None:
    """Find how far a log lies behind a live record of the same motion, on the same grid.

    None if no channel of both moves alike anywhere. One row, or less, counts as none: it is the
    delay of interpolation, and both carry the vehicle's own clock.
    """
    names = common_channels(live, log)
    if not names:
        return None
    found = find_lag(live, log, rate, names)
    if not found.is_reliable:
        return None
    return found if abs(found.rows) > 1 else RecordLag(rows=0, correlation=found.correlation)


def find_lag(live: Block, log: Block, rate: float, names: Sequence[str]) -> RecordLag:
    """Find the lag at which channels of two records on one grid are most alike, to a row.

    The masked, normalized cross-correlation of the channels, averaged, has its peak there; 0 where
    one record is too long to be compared.
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
    """Return the number of the first row on the grid, and all rows, shape (n, len(names)).

    A pause is filled with NaN.
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


class ClockAlignmentError(Exception):
    """Two records that cannot be aligned; says why, to stand after a colon."""


class _SegmentLag(NamedTuple):
    """What one channel says of one stretch."""

    at: float
    """Middle of the stretch, s of flight time."""
    channel: str
    lag: float
    """To be added to the log's time there, s."""
    std: float
    """s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _LagLine:
    """Lags as ``offset + slope * (time - at)``."""

    at: float
    offset: float
    offset_std: float
    slope: float
    slope_std: float | None
    agreeing: int


def align_clocks(
    live: Block, log: Block, rate: float, *, leave_out: Collection[str] = ()
) -> LogClock:
    """Find how the clock of a log stands to that of a live record of the same motion, on one grid.

    Channels that are timed by their arrival are to be left out. `ClockAlignmentError` if nothing
    moves alike, or not everywhere alike.
    """
    names = common_channels(live, log, leave_out)
    if not names:
        raise ClockAlignmentError("no moving channel in both records")
    coarse = find_lag(live, log, rate, names)
    if not coarse.is_reliable:
        raise ClockAlignmentError(
            f"no common channel correlates (correlation {max(coarse.correlation, 0.0):.2f}, of "
            f"{', '.join(names)})"
        )
    every = common_channels(live, log, leave_out, ALIGNMENT.max_channels)
    lags = _segment_lags(live, log, rate, every, coarse)
    windows = len({one.at for one in lags})
    if not windows:
        raise ClockAlignmentError(
            f"coarse correlation {coarse.correlation:.2f}, but no window of "
            f"{ALIGNMENT.window_duration:g} s correlates in detail"
        )
    line = _fit_lag_line(lags)
    if line.agreeing < ALIGNMENT.min_agreeing_share * windows:
        raise ClockAlignmentError(
            f"only {line.agreeing} of {windows} motion windows agree on one clock"
        )
    if abs(line.slope) > ALIGNMENT.max_drift and abs(line.slope) > ALIGNMENT.drift_sigmas * (
        line.slope_std or 0.0
    ):
        raise ClockAlignmentError(
            f"one clock would gain {abs(line.slope) * 1e6:.0f} ppm on the other, which is "
            "implausible"
        )
    drifts = (
        line.slope_std is not None and abs(line.slope) > ALIGNMENT.drift_sigmas * line.slope_std
    )
    # Lags are over flight time; offset and drift over the log's own, parts in a million apart.
    return LogClock(
        offset=line.offset,
        offset_std=line.offset_std,
        drift=-line.slope,
        drift_std=line.slope_std,
        drifts=drifts,
        at=line.at - line.offset,
        correlation=coarse.correlation,
        windows=windows,
        agreeing=line.agreeing,
    )


def _segment_lags(
    live: Block, log: Block, rate: float, names: Sequence[str], coarse: RecordLag
) -> list[_SegmentLag]:
    """Return the lags of stretches of the live record that move, one per window."""
    live_first, live_values = fill_omitted_rows(live, names, rate)
    log_first, log_values = fill_omitted_rows(log, names, rate)
    periods = [_period(column) for column in live_values.T]
    widths = [
        2 * round(0.5 * max(ALIGNMENT.smoothing * rate, ALIGNMENT.smoothing_periods * period)) + 1
        for period in periods
    ]
    live_values, log_values = (
        _smooth_columns(live_values, widths),
        _smooth_columns(log_values, widths),
    )
    start = max(live_first, log_first + coarse.rows)
    stop = min(live_first + len(live_values), log_first + coarse.rows + len(log_values))
    search = max(ALIGNMENT.min_search, ALIGNMENT.max_drift * (stop - start) / rate)
    reach = max(min(round(search * rate), (stop - start) // 8), 2)
    # The log is looked at a little before and behind each stretch, and smoothing takes its ends.
    edge = reach + min(max(widths) // 2, (stop - start) // 8)
    start, stop = start + edge, stop - edge
    if stop - start < min(widths):
        return []
    rows = min(round(ALIGNMENT.window_duration * rate), stop - start)
    count = (stop - start) // rows
    begins = start + (stop - start - rows) * np.arange(count) // max(count - 1, 1)
    if count > ALIGNMENT.max_windows:
        motion = [
            np.nansum(_relative_range(live_values, each - live_first, rows))
            for each in begins.tolist()
        ]
        begins = np.sort(begins[np.argsort(motion, kind="stable")[-ALIGNMENT.max_windows :]])
    found = []
    for begin in begins.tolist():
        part = live_values[begin - live_first : begin - live_first + rows]
        other = _slice(log_values, begin - coarse.rows - reach - log_first, rows + 2 * reach)
        for column, name in enumerate(names):
            alone = widths[column] + periods[column]
            lag = _lag_of_channel(part[:, column], other[:, column], reach, alone)
            if lag is not None:
                found.append(
                    _SegmentLag(
                        at=(begin + 0.5 * rows) / rate,
                        channel=name,
                        lag=(coarse.rows + lag[0]) / rate,
                        std=max(lag[1] / rate, ALIGNMENT.min_lag_std),
                    )
                )
    return found


def _period(values: FloatArray) -> float:
    """Return how many rows lie between two samples of a channel that was laid on a grid.

    Between samples it is a straight line.
    """
    bends = np.abs(np.diff(values, 2))
    there = np.isfinite(bends)
    if not there.any():
        return 1.0
    rounding = 1e-9 * max(float(np.nanmax(np.abs(values))), 1e-300)
    return float(there.sum() / max(np.count_nonzero(bends[there] > rounding), 1))


def _relative_range(values: FloatArray, start: int, rows: int) -> FloatArray:
    part = values[start : start + rows]
    there = ~np.isnan(part)
    low = np.where(there, part, np.inf).min(axis=0)
    high = np.where(there, part, -np.inf).max(axis=0)
    whole = np.nanmax(values, axis=0) - np.nanmin(values, axis=0)
    moved: FloatArray = np.where(high > low, high - low, 0.0) / np.where(whole > 0.0, whole, 1.0)
    return moved


def _slice(values: FloatArray, start: int, rows: int) -> FloatArray:
    """Return rows of an array, NaN beyond its ends."""
    part = np.full((rows, values.shape[1]), np.nan)
    first, last = max(start, 0), min(start + rows, len(values))
    if last > first:
        part[first - start : last - start] = values[first:last]
    return part


def _smooth_columns(values: FloatArray, widths: Sequence[int]) -> FloatArray:
    """Return columns smoothed by symmetric bells; NaN where any row of a bell is missing."""
    result = np.full_like(values, np.nan)
    for column, width in enumerate(widths):
        if len(values) < width:
            continue
        bell = np.hanning(width + 2)[1:-1]
        there = ~np.isnan(values[:, column])
        filled = np.where(there, values[:, column], 0.0)
        whole = np.convolve(there, np.ones(width), mode="same") >= width - 0.5
        smooth = np.convolve(filled, bell / bell.sum(), mode="same")
        result[whole, column] = smooth[whole]
    return result


def _lag_of_channel(
    live: FloatArray, log: FloatArray, reach: int, alone: float
) -> tuple[float, float] | None:
    """Return the lag of a stretch, in rows from the coarse one, and its standard deviation.

    None where the two are not alike. `log` is longer by `reach` rows either way; rows that lie
    `alone` rows apart are independent.
    """
    there = np.flatnonzero(~np.isnan(live))
    if there.size < ALIGNMENT.min_valid_share * live.size:
        return None
    # Row k of the views is the log as seen `reach - k` rows later than the coarse lag has it.
    views = np.lib.stride_tricks.sliding_window_view(log, live.size)
    views = views[:, there]
    measured = live[there]
    whole: npt.NDArray[np.bool_] = np.isfinite(views.sum(axis=1))
    if not whole[reach]:
        return None
    measured = measured - measured.mean()
    with np.errstate(invalid="ignore"):
        views = views - views.mean(axis=1, keepdims=True)
        apart = np.where(whole, np.square(views - measured).sum(axis=1), np.inf)
    best = int(np.argmin(apart))
    energy = float(measured @ measured)
    if not 0 < best < 2 * reach or not np.isfinite(apart[best - 1 : best + 2]).all():
        return None
    if not apart[best] < (1.0 - ALIGNMENT.min_window_correlation**2) * energy:
        return None
    before, here, after = apart[best - 1 : best + 2].tolist()
    curve = before - 2.0 * here + after
    if not curve > 0.0:
        return None
    vertex = best + 0.5 * (before - after) / curve
    # Smoothed rows are not independent: as many as are left count.
    rest = alone * max(here, 0.0) / max(measured.size - 2, 1)
    std = float(np.sqrt(2.0 * rest / curve))
    return reach - vertex, max(std, 1e-3)


def _fit_lag_line(lags: Sequence[_SegmentLag]) -> _LagLine:
    """Return the line through the lags, leaving out stretches that lie far beside it.

    A channel whose lags scatter by more than they say counts less, and the other way round.
    """
    channels = sorted({one.channel for one in lags})
    column = np.array([channels.index(one.channel) for one in lags])
    stretches, row = np.unique([one.at for one in lags], return_inverse=True)
    each = np.array([one.lag for one in lags])
    stds = np.array([one.std for one in lags])
    for _ in range(ALIGNMENT.iterations):
        weights = np.bincount(row, stds**-2, minlength=stretches.size)
        means = np.bincount(row, each * stds**-2, minlength=stretches.size) / weights
        # By medians first, which no stray lag moves.
        slope = _median_slope(stretches, means)
        middle = float(np.median(means - slope * stretches))
        rest = each - middle - slope * stretches[row]
        excess = np.array(
            [_robust_std(rest[column == k] / stds[column == k]) for k in range(len(channels))]
        )
        stds = np.maximum(
            stds * np.maximum(excess, ALIGNMENT.min_scatter_ratio)[column], ALIGNMENT.min_lag_std
        )
    weights = np.bincount(row, stds**-2, minlength=stretches.size)
    means = np.bincount(row, each * stds**-2, minlength=stretches.size) / weights
    beside = np.abs(means - middle - slope * stretches)
    usual = max(_robust_std(beside), 2.0 * ALIGNMENT.min_lag_std)
    kept = beside <= ALIGNMENT.outlier_sigmas * np.maximum(usual, weights**-0.5)
    return _fit_weighted_line(stretches[kept], means[kept], weights[kept])


def _robust_std(values: FloatArray) -> float:
    if values.size < ALIGNMENT.min_scatter_values:
        return 1.0
    return MAD_TO_STD * float(np.median(np.abs(values)))


def _fit_weighted_line(times: FloatArray, lags: FloatArray, weights: FloatArray) -> _LagLine:
    """Return the weighted line through lags of stretches that agree."""
    at = float(weights @ times / weights.sum())
    offset = float(weights @ lags / weights.sum())
    arm = float(weights @ (times - at) ** 2)
    if times.size < 3 or not arm > 0.0:
        spread = float(np.std(lags)) if times.size > 1 else 0.0
        return _LagLine(
            at=at,
            offset=offset,
            offset_std=max(float(weights.sum() ** -0.5), spread),
            slope=0.0,
            slope_std=None,
            agreeing=int(times.size),
        )
    slope = float(weights @ ((times - at) * (lags - offset)) / arm)
    left = lags - offset - slope * (times - at)
    # How far they scatter counts, not what they say, where there are enough to tell.
    told = 1.0 if times.size - 2 < ALIGNMENT.min_scatter_values else 0.0
    excess = max(float(weights @ left**2) / (times.size - 2), told)
    # What straight lines between samples leave is alike everywhere: more stretches do not help.
    offset_std = max(float(np.sqrt(excess / weights.sum())), 0.5 * ALIGNMENT.min_lag_std)
    slope_std = max(
        float(np.sqrt(excess / arm)), 2.0 * ALIGNMENT.min_lag_std / float(np.ptp(times))
    )
    return _LagLine(
        at=at,
        offset=offset,
        offset_std=offset_std,
        slope=slope,
        slope_std=slope_std,
        agreeing=int(times.size),
    )


def _median_slope(times: FloatArray, lags: FloatArray) -> float:
    first, second = np.triu_indices(times.size, 1)
    if not first.size:
        return 0.0
    return float(np.median((lags[second] - lags[first]) / (times[second] - times[first])))

"""How two clocks stand to each other over a flight: offset, drift, and how sure both are.

Stretches of the flight are compared one by one, each with its own lag; a straight line through the
lags is the offset and the drift. Where the lags lie on no line, the records are not of one motion,
however alike they look in one place.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from gsapp.flight.onboard.lags import Lag, common_channels, dense, find_lag
from gsapp.flight.onboard.record import LogClock
from gsapp.quantities import Block, FloatArray

_WINDOW = 10.0
"""Seconds of a stretch: several periods of what an aircraft of this size does."""
_MOST_WINDOWS = 80
_MOST_CHANNELS = 12
_SMOOTH = 0.3
"""Seconds over which both are smoothed alike before they are compared.

The radio carries a few samples a second, and what lies between them is a straight line; smoothed,
both hold the same. It is symmetric, so that it moves nothing.
"""
_LEAST_THERE = 0.6
_LEAST_ALIKE = 0.9
_LEAST_AGREEING = 0.5
_MOST_DRIFT = 1e-3
"""Of any clock: bad crystals do 200 ppm."""
_LEAST_SEARCH = 0.5
_BEYOND_DOUBT = 3.0
"""Standard deviations from which on a drift is corrected."""
_FLOOR = 2e-4
"""Seconds; no lag of a stretch is believed to be better than this."""
_OUTSIDE = 4.0
_NORMAL = 1.4826
"""From the median of absolute deviations to a standard deviation."""


class NoClockError(Exception):
    """Two records that cannot be aligned; says why, to stand after a colon."""


class _Window(NamedTuple):
    """The lag of one stretch: at a time of the live record, s; the log's lag there, s; its std."""

    at: float
    lag: float
    std: float


@dataclass(frozen=True, slots=True, kw_only=True)
class _Line:
    """Lags as ``offset + slope * (time - at)``."""

    at: float
    offset: float
    offset_std: float
    slope: float
    slope_std: float | None
    agreeing: int


def compare_clocks(
    live: Block, log: Block, rate: float, *, leave_out: Collection[str] = ()
) -> LogClock:
    """Find how the clock of a log stands to that of a live record of the same motion.

    Parameters
    ----------
    live, log : Block
        On the grid ``k / rate``.
    rate : float
        Rows per second.
    leave_out : collection of str
        Channels that are not to be compared, such as those timed by their arrival.

    Returns
    -------
    LogClock
        Offset and drift with their standard deviations.

    Raises
    ------
    NoClockError
        If nothing moves alike, or not everywhere alike.
    """
    names = common_channels(live, log, leave_out)
    if not names:
        raise NoClockError("no channel that moves is in both")
    coarse = find_lag(live, log, rate, names)
    if not coarse.good:
        raise NoClockError(
            f"no channel of both moves alike (correlation {max(coarse.correlation, 0.0):.2f}, of "
            f"{', '.join(names)})"
        )
    every = common_channels(live, log, leave_out, _MOST_CHANNELS)
    windows = _windows(live, log, rate, every, coarse)
    if not windows:
        raise NoClockError(
            f"they look alike somewhere (correlation {coarse.correlation:.2f}), but no stretch of "
            f"{_WINDOW:g} s does in detail"
        )
    line = _line(windows)
    if line.agreeing < _LEAST_AGREEING * len(windows) or abs(line.slope) > _MOST_DRIFT:
        raise NoClockError(
            f"only {line.agreeing} of {len(windows)} stretches of motion lie where one clock "
            "would put them"
        )
    drifts = line.slope_std is not None and abs(line.slope) > _BEYOND_DOUBT * line.slope_std
    # Lags are over flight time; offset and drift over the log's own, parts in a million apart.
    return LogClock(
        offset=line.offset,
        offset_std=line.offset_std,
        drift=-line.slope,
        drift_std=line.slope_std,
        drifts=drifts,
        at=line.at - line.offset,
        correlation=coarse.correlation,
        windows=len(windows),
        agreeing=line.agreeing,
    )


def _windows(live: Block, log: Block, rate: float, names: list[str], coarse: Lag) -> list[_Window]:
    """Return the lags of stretches of the live record that move, one each `_WINDOW` seconds."""
    live_first, live_values = dense(live, names, rate)
    log_first, log_values = dense(log, names, rate)
    width = 2 * round(0.5 * _SMOOTH * rate) + 1
    live_values, log_values = _smoothed(live_values, width), _smoothed(log_values, width)
    start = max(live_first, log_first + coarse.rows)
    stop = min(live_first + len(live_values), log_first + coarse.rows + len(log_values))
    search = max(_LEAST_SEARCH, _MOST_DRIFT * (stop - start) / rate)
    reach = max(min(round(search * rate), (stop - start) // 8), 2)
    # The log is looked at a little before and behind each stretch, and smoothing takes its ends.
    start, stop = start + reach + width // 2, stop - reach - width // 2
    if stop - start < width:
        return []
    rows = min(round(_WINDOW * rate), stop - start)
    count = (stop - start) // rows
    begins = start + (stop - start - rows) * np.arange(count) // max(count - 1, 1)
    if count > _MOST_WINDOWS:
        motion = [
            np.nansum(_spread(live_values, each - live_first, rows)) for each in begins.tolist()
        ]
        begins = np.sort(begins[np.argsort(motion, kind="stable")[-_MOST_WINDOWS:]])
    found = []
    for begin in begins.tolist():
        part = live_values[begin - live_first : begin - live_first + rows]
        other = _slice(log_values, begin - coarse.rows - reach - log_first, rows + 2 * reach)
        lag = _lag_of_window(part, other, reach, width)
        if lag is not None:
            rows_off, std = lag
            found.append(
                _Window(
                    at=(begin + 0.5 * rows) / rate,
                    lag=(coarse.rows + rows_off) / rate,
                    std=max(std / rate, _FLOOR),
                )
            )
    return found


def _spread(values: FloatArray, start: int, rows: int) -> FloatArray:
    """Return how far each channel moves in a stretch, as a share of how far it ever does."""
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


def _smoothed(values: FloatArray, width: int) -> FloatArray:
    """Return the columns smoothed by a symmetric bell; NaN where any of its rows is missing."""
    bell = np.hanning(width + 2)[1:-1]
    bell /= bell.sum()
    result = np.full_like(values, np.nan)
    if len(values) < width:
        return result
    for column in range(values.shape[1]):
        there = ~np.isnan(values[:, column])
        filled = np.where(there, values[:, column], 0.0)
        whole = np.convolve(there, np.ones(width), mode="same") >= width - 0.5
        result[whole, column] = np.convolve(filled, bell, mode="same")[whole]
    return result


def _lag_of_window(
    live: FloatArray, log: FloatArray, reach: int, width: int
) -> tuple[float, float] | None:
    """Return the lag of a stretch, in rows from the coarse one, and its standard deviation.

    Each channel that moves has its own; they are weighted by what they know.

    Parameters
    ----------
    live : ndarray, shape (n, m)
    log : ndarray, shape (n + 2 reach, m)
    reach : int
        Rows to try either way.
    width : int
        Rows over which both were smoothed.
    """
    lags, weights = [], []
    for column in range(live.shape[1]):
        found = _lag_of_channel(live[:, column], log[:, column], reach, width)
        if found is not None:
            lags.append(found[0])
            weights.append(found[1] ** -2)
    if not lags:
        return None
    total = sum(weights)
    return float(np.dot(lags, weights) / total), float(total**-0.5)


def _lag_of_channel(
    live: FloatArray, log: FloatArray, reach: int, width: int
) -> tuple[float, float] | None:
    there = np.flatnonzero(~np.isnan(live))
    if there.size < _LEAST_THERE * live.size:
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
    if not apart[best] < (1.0 - _LEAST_ALIKE**2) * energy:
        return None
    before, here, after = apart[best - 1 : best + 2].tolist()
    curve = before - 2.0 * here + after
    if not curve > 0.0:
        return None
    vertex = best + 0.5 * (before - after) / curve
    # Smoothed rows are not independent: as many as are left count.
    rest = width * max(here, 0.0) / max(measured.size - 2, 1)
    std = float(np.sqrt(2.0 * rest / curve))
    return reach - vertex, max(std, 1e-3)


def _line(windows: list[_Window]) -> _Line:
    """Return the line through the lags, leaving out those that lie far beside it."""
    times = np.array([window.at for window in windows])
    lags = np.array([window.lag for window in windows])
    stds = np.array([window.std for window in windows])
    # First by medians, which no stray lag moves.
    slope = _median_slope(times, lags)
    rest = lags - slope * times
    rest -= np.median(rest)
    scale = max(_NORMAL * float(np.median(np.abs(rest))), 2.0 * _FLOOR)
    kept = np.abs(rest) <= _OUTSIDE * np.maximum(scale, stds)
    times, lags, stds = times[kept], lags[kept], stds[kept]
    weights = stds**-2
    at = float(weights @ times / weights.sum())
    offset = float(weights @ lags / weights.sum())
    arm = float(weights @ (times - at) ** 2)
    if times.size < 3 or not arm > 0.0:
        spread = float(np.std(lags)) if times.size > 1 else 0.0
        std = max(float(weights.sum() ** -0.5), spread)
        return _Line(
            at=at,
            offset=offset,
            offset_std=std,
            slope=0.0,
            slope_std=None,
            agreeing=int(times.size),
        )
    slope = float(weights @ ((times - at) * (lags - offset)) / arm)
    left = lags - offset - slope * (times - at)
    # Where they scatter by more than they say, what they show counts.
    excess = max(float(weights @ left**2) / (times.size - 2), 1.0)
    return _Line(
        at=at,
        offset=offset,
        offset_std=float(np.sqrt(excess / weights.sum())),
        slope=slope,
        slope_std=float(np.sqrt(excess / arm)),
        agreeing=int(times.size),
    )


def _median_slope(times: FloatArray, lags: FloatArray) -> float:
    """Return the median of the slopes between all pairs of lags."""
    first, second = np.triu_indices(times.size, 1)
    if not first.size:
        return 0.0
    return float(np.median((lags[second] - lags[first]) / (times[second] - times[first])))

"""The clock of the board, as the records of an on-board log agree on it in the order of the file.

A log is written as time goes on, so its stamps grow from its first byte to its last. A message
whose stamps lie elsewhere than those of its neighbors counts by another clock (ArduPilot up to 3.2
stamps GPS with the time of week), or by none: its place in the file then tells when it was written.
A single stamp that lies elsewhere is damage, or of something that was never measured.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from gsapp.flight.settings import FLIGHT_DATA
from gsapp.flight.uniform_grid import median_step
from gsapp.quantities import BoolArray, FloatArray

IndexArray = npt.NDArray[np.int64]
MessageKey = tuple[str, str]
"""Name, and number of the instance as text."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RecordTimes:
    """When the records of one message were taken."""

    places: IndexArray
    """Shape (n,). Where each begins in the file, increasing."""
    times: FloatArray
    """Shape (n,). Seconds; NaN where a record has no time that can be true."""
    stamped: bool = True
    """Whether the log states times of this message at all."""
    by_order: bool = False
    """Whether the times follow from the places."""

    @property
    def valid(self) -> BoolArray:
        """Return which have a time, shape (n,)."""
        return np.isfinite(self.times)

    def remark(self, label: str) -> str:
        """Return what was done about the stamps of the message, in words; empty for nothing."""
        if self.by_order:
            return f"{label} has no stamp of the vehicle's clock: timed by its order in the log"
        count = int(self.times.size - np.count_nonzero(self.valid))
        if not count:
            return ""
        samples = "1 sample" if count == 1 else f"{count} samples"
        return f"skipped for impossible or repeated times: {samples} of {label}"


@dataclass(frozen=True, slots=True, eq=False)
class BootClock:
    """The clock that most records of a log share, and the records on it."""

    times: Mapping[MessageKey, RecordTimes]
    """By message. Stamps that agree are as stated, and strictly increasing; others are NaN. A
    message that does not agree, or has no stamps, is timed by its order; all NaN where there is no
    clock at all."""
    _places: IndexArray
    _order: FloatArray
    """Times of all records that agree, by place, never decreasing."""

    @staticmethod
    def of(stated: Mapping[MessageKey, RecordTimes]) -> BootClock:
        """Find the clock of records with stamps as the log states them, NaN for none."""
        # All messages in one array: most logs have dozens, of a few samples each.
        sizes = [one.places.size for one in stated.values()]
        owner = np.repeat(np.arange(len(sizes)), sizes)
        places = np.concatenate([np.empty(0, np.int64), *(one.places for one in stated.values())])
        times = np.concatenate([np.empty(0), *(one.times for one in stated.values())])
        order = np.argsort(places, kind="stable")
        good = np.abs(times) < FLIGHT_DATA.max_time
        near = _is_near_neighbors(times, order[good[order]])
        strays = np.bincount(owner[good & ~near], minlength=len(sizes))
        # A few stamps that lie elsewhere are but wrong.
        odd = (2 * strays >= np.bincount(owner[good], minlength=len(sizes))) & (
            strays >= FLIGHT_DATA.clock_neighbors
        )
        if odd.any():
            good &= ~odd[owner]
            near = _is_near_neighbors(times, order[good[order]])
        good &= near
        restless = _is_restless(owner, times, good, len(sizes))
        ends = np.cumsum(sizes).tolist()
        for size, end, check in zip(sizes, ends, restless.tolist(), strict=True):
            if check:
                own = good[end - size : end]
                own[own] = find_valid_times(times[end - size : end][own])
        ordered = order[good[order]]
        board = BootClock({}, places[ordered], np.maximum.accumulate(times[ordered]))
        times = np.where(good, times, np.nan)
        placed: dict[MessageKey, RecordTimes] = {}
        for (key, one), end, other in zip(stated.items(), ends, odd.tolist(), strict=True):
            by_order = other or not one.stamped
            own_times = times[end - one.places.size : end]
            if by_order:
                own_times = _with_own_intervals(board._times_at(one.places), one.times)
            placed[key] = RecordTimes(places=one.places, times=own_times, by_order=by_order)
        return BootClock(placed, board._places, board._order)

    def event_times(self, stated: RecordTimes) -> list[float | None]:
        """Return when things happened that the log states among its samples; None if unknown.

        As stated, or by their order where that cannot be.
        """
        order = self._times_at(stated.places)
        with np.errstate(invalid="ignore"):
            near = np.abs(stated.times - order) <= FLIGHT_DATA.max_stamp_offset
        times = np.where(near, stated.times, order)
        return [time if math.isfinite(time) else None for time in times.tolist()]

    def _times_at(self, places: IndexArray) -> FloatArray:
        if not self._places.size:
            return np.full(places.size, np.nan)
        return np.interp(places, self._places, self._order)


def _with_own_intervals(order: FloatArray, stated: FloatArray) -> FloatArray:
    """Return times by order, shape (n,), the intervals as another clock states them where it runs.

    The order alone places a sample between those of other messages. NaN where the times would
    repeat or go back.
    """
    offset = order - stated
    known = np.isfinite(offset)
    if known.any():
        near = np.abs(offset - np.median(offset[known])) <= FLIGHT_DATA.max_clock_jump
        order = np.where(near, stated + np.median(offset[known]), order)
    return np.where(find_valid_times(order), order, np.nan)


def _is_near_neighbors(times: FloatArray, order: IndexArray) -> BoolArray:
    """Return which stamps lie near the median of those beside them in the file, shape (n,).

    `order` has the places of those that count, as they follow each other; the others lie nowhere.
    """
    near = np.zeros(times.size, dtype=bool)
    width, stride = FLIGHT_DATA.clock_window, FLIGHT_DATA.clock_window // 2 + 1
    if order.size < width + stride:
        near[order] = True  # too few to say which of them are wrong
        return near
    ordered = times[order]
    windows = np.lib.stride_tricks.sliding_window_view(ordered, width)[::stride]
    medians = np.sort(windows, axis=1)[:, width // 2]
    # How far the medians before and after lie apart: the pace of the log, or a pause.
    steps = np.abs(np.diff(medians, prepend=medians[:1], append=medians[-1:]))
    reach = FLIGHT_DATA.max_stamp_offset + steps[:-1] + steps[1:]
    nearest = (np.arange(order.size) - width // 2 + stride // 2) // stride
    nearest = np.minimum(np.maximum(nearest, 0), medians.size - 1)
    near[order] = np.abs(ordered - medians[nearest]) <= reach[nearest]
    return near


def _is_restless(owner: IndexArray, times: FloatArray, good: BoolArray, count: int) -> BoolArray:
    """Return which messages have stamps that may be wrong or repeat, shape (count,)."""
    with np.errstate(invalid="ignore"):
        steps = np.diff(times)
        even = (steps > 0.0) & (steps <= FLIGHT_DATA.max_clock_jump / FLIGHT_DATA.clock_neighbors)
    restless = np.zeros(count, dtype=bool)
    restless[owner[1:][~even & (owner[1:] == owner[:-1])]] = True
    restless[owner[~good]] = True
    return restless


def find_valid_times(times: FloatArray) -> BoolArray:
    """Return which samples have a time (s, in the order of the file) that can be true.

    A damaged stamp stands far from those of its neighbors; what then still repeats or goes back is
    dropped too, so that the rest is strictly increasing.
    """
    limit = max(FLIGHT_DATA.max_clock_jump, 10.0 * abs(median_step(times)))
    steps = np.diff(times)
    # The median of its neighbors is no more than two of them away.
    if ((steps > 0.0) & (2.0 * steps <= limit)).all():
        return np.isfinite(times)
    good = np.isfinite(times) & ~(_distance_to_neighbors(times) > limit)
    kept = np.where(good, times, -np.inf)
    before = np.concatenate(([-np.inf], np.maximum.accumulate(kept)[:-1]))
    result: BoolArray = good & (times > before)
    return result


def find_isolated_times(times: FloatArray) -> BoolArray:
    """Return which times (s) cannot be true, as those about them follow one another without them.

    They stand farther away than any pause, or time would go back at them; where it goes back for
    longer, or often, none is isolated.
    """
    distance = _distance_to_neighbors(times)
    limit = max(FLIGHT_DATA.max_clock_jump, 10.0 * abs(median_step(times)))
    steps = np.diff(times)
    back = np.concatenate((steps < 0.0, [False])) | np.concatenate(([False], steps < 0.0))
    found: BoolArray = (distance > FLIGHT_DATA.max_pause + limit) | (back & (distance > limit))
    return found | _late_stamps(np.where(found, -np.inf, times))


def _late_stamps(times: FloatArray) -> BoolArray:
    """Return the few times that are not later than all before them, such as a stamp of 0.

    `times`: minus infinity where the stamp is known to be wrong.
    """
    latest = np.maximum.accumulate(times)
    late = np.concatenate(([False], times[1:] <= latest[:-1])) & np.isfinite(times)
    in_row = FLIGHT_DATA.clock_neighbors // 2 + 1
    runs = np.convolve(late, np.ones(in_row), mode="valid") if times.size >= in_row else late
    few = np.count_nonzero(late) <= FLIGHT_DATA.max_late_stamps * times.size
    return late if few and runs.max(initial=0) < in_row else np.zeros_like(late)


def _distance_to_neighbors(times: FloatArray) -> FloatArray:
    """Return how far each time lies from the median of those about it, s; 0 for a few of them."""
    if times.size <= FLIGHT_DATA.clock_neighbors:
        return np.zeros(times.size)
    reach = FLIGHT_DATA.clock_neighbors // 2
    padded = np.concatenate((times[:1].repeat(reach), times, times[-1:].repeat(reach)))
    # Repeating the ends would let a damaged first or last stamp vouch for itself.
    padded[:reach] = times[1 : reach + 1]
    padded[-reach:] = times[-reach - 1 : -1]
    windows = np.lib.stride_tricks.sliding_window_view(padded, FLIGHT_DATA.clock_neighbors)
    distance: FloatArray = np.abs(times - np.median(windows, axis=1))
    return distance

"""Which rows of the grid many samples complete: `gsapp.decoding.gridder` for a whole file at once.

The numbers are those that the gridder finds sample by sample.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from gsapp.decoding.grid import BoolArray, Grid
from gsapp.decoding.settings import DECODING
from gsapp.quantities import FloatArray

IntArray = npt.NDArray[np.int64]
_LARGEST = 2**62


class RowPlan(NamedTuple):
    """Successive rows to be laid: each between two samples, or on one, given by their places."""

    first: int  # The first row.
    before: Sequence[int] | IntArray
    after: Sequence[int] | IntArray
    """Samples before and after each row; the same twice where the row stands on it."""
    weights: Sequence[float] | FloatArray  # Share of the sample after.
    gaps: Sequence[int]
    silent: Sequence[int]
    """Rows, counted from the first, that lie in a gap; that lie in a silence."""

    def silence(self) -> BoolArray | None:
        if not self.silent:
            return None
        flags = np.zeros(len(self.after), dtype=bool)
        flags[list(self.silent)] = True
        return flags


@dataclass(frozen=True, slots=True, kw_only=True)
class PlannedSamples:
    """What a gridder has to know of many samples."""

    plans: list[RowPlan]
    kept: IntArray
    """Shape (m,). Places among those given, from 0, of the samples that are later than all before
    them."""
    repeated: int  # How many have the time of the latest before them.
    intervals: IntArray  # Between those kept, the last one of an earlier call included, us.
    gaps: int
    gap_time: int  # How long the gaps last together, us.
    next_row: int
    silent_until: int  # By which flight time a silence has been noticed, us.


def plan_rows(
    grid: Grid,
    times: Sequence[int],
    nows: Sequence[int],
    *,
    last: int | None,
    intervals: Sequence[int],
    fallback: int,
    silent_until: int,
) -> PlannedSamples | None:
    """Plan the rows that samples complete; see `Gridder.feed`. None if the numbers are too great.

    `last` is the time of the sample before them, None for none, `intervals` are those before it,
    and `silent_until` is the flight time by which a silence had been noticed.
    """
    origin = times[0] if last is None else last
    stamps = np.array(times, dtype=np.int64)
    offsets, heard = stamps - origin, np.array(nows, dtype=np.int64) - origin
    largest = max(int(np.abs(offsets).max()), int(np.abs(heard).max()), abs(silent_until - origin))
    if largest * grid.numerator + grid.step >= _LARGEST:
        return None
    latest = np.maximum.accumulate(np.concatenate(([-1 if last is None else 0], offsets)))[:-1]
    kept = np.flatnonzero(offsets > latest)
    repeated = int(np.count_nonzero(offsets == latest))
    own = offsets[kept]
    heard = heard[kept]
    came = np.maximum(heard, own)
    before = np.concatenate((np.zeros(1, np.int64), own[:-1]))[: own.size]
    begins = int(last is None)
    steps = (own - before)[begins:]
    usual, usual_before = _periods(steps, intervals)
    gap = np.zeros(own.size, dtype=bool)
    silent = np.zeros(own.size, dtype=bool)
    gap[begins:] = 2 * steps > 5 * usual
    passed = (came - before)[begins:]
    silent[begins:] = passed > np.maximum(fallback, usual_before * 5 // 2)
    # Until then another source counts, whatever came late.
    noticed = np.concatenate(([silent_until - origin], np.where(silent, heard, -_LARGEST)))
    until = np.maximum.accumulate(noticed)[1:]

    step, at, at_before = grid.step, own * grid.numerator, before * grid.numerator
    first_row = -(-origin * grid.numerator // step)
    phase = first_row * step - origin * grid.numerator
    stop = (at - phase) // step + 1
    start = (at_before - phase) // step + 1
    # After a pause too long to be filled, rows go on at the sample or after it.
    pause = at - at_before > grid.max_filled_rows * step
    pause[:begins] = True
    start[pause] = stop[pause] - (phase + (stop[pause] - 1) * step == at[pause])
    counts = stop - start
    offset = np.concatenate(([0], np.cumsum(counts)))
    sample = np.repeat(np.arange(own.size), counts)
    position = phase + (start[sample] + np.arange(sample.size) - offset[sample]) * step
    on_sample = position == at[sample]
    with np.errstate(invalid="ignore", divide="ignore"):
        weights = (position - at_before[sample]) / (at - at_before)[sample]
    weights[on_sample] = 1.0
    after = kept[sample] + 1
    places = np.concatenate((np.zeros(1, np.int64), kept[:-1] + 1))[: own.size]
    former = np.where(on_sample, after, places[sample])
    in_gap = gap[sample] & ~on_sample
    in_silence = silent[sample] & ~on_sample | (position < (until * grid.numerator)[sample])
    cuts = np.unique(np.concatenate(([0], np.flatnonzero(pause), [own.size])))
    plans = []
    for one, following in zip(cuts[:-1].tolist(), cuts[1:].tolist(), strict=True):
        rows = slice(int(offset[one]), int(offset[following]))
        plans.append(
            RowPlan(
                first_row + int(start[one]),
                former[rows],
                after[rows],
                weights[rows],
                np.flatnonzero(in_gap[rows]).tolist(),
                np.flatnonzero(in_silence[rows]).tolist(),
            )
        )
    return PlannedSamples(
        plans=plans,
        kept=kept,
        repeated=repeated,
        intervals=steps,
        gaps=int(np.count_nonzero(gap)),
        gap_time=int((own - before)[gap].sum()),
        next_row=first_row + int(stop[-1]) if own.size else 0,
        silent_until=int(until[-1]) + origin if own.size else silent_until,
    )


def _periods(steps: IntArray, intervals: Sequence[int]) -> tuple[IntArray, IntArray]:
    """Return the lower median of the last intervals, each included; and of those before each.

    Until two are known, and until one is.
    """
    every = np.concatenate((np.array(intervals, dtype=np.int64), steps))
    width = DECODING.period_window
    periods = np.empty(every.size, dtype=np.int64)
    for count in range(1, min(width, every.size + 1)):
        periods[count - 1] = np.sort(every[:count])[(count - 1) // 2]
    if every.size >= width:
        windows = np.lib.stride_tricks.sliding_window_view(every, width)
        periods[width - 1 :] = np.partition(windows, (width - 1) // 2, axis=1)[:, (width - 1) // 2]
    before = np.concatenate(([DECODING.unknown_period], periods))[len(intervals) : -1]
    usual = periods[len(intervals) :].copy()
    if not intervals and usual.size:
        usual[0] = DECODING.unknown_period
    return usual, before

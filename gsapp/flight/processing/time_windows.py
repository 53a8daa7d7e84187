"""Windows of time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from gsapp.foundation import FlightError
from gsapp.quantities import Block


class TimeWindow(NamedTuple):
    """From the first to the last time kept, s of flight time; both are kept."""

    start: float
    stop: float


def parse_time_window(text: str) -> TimeWindow:
    """Read ``START:STOP``, seconds; either may be empty for the end of the flight.

    Raises
    ------
    FlightError
        If it is something else.
    """
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
    """Keep what lies in any of the windows.

    One missing row is left between two windows that do not touch, so that nothing later takes
    them for one stretch. Times stay as they are.

    Raises
    ------
    FlightError
        If a window holds no sample.
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

"""Sensors at the end of their range: what is cut off cannot be estimated from.

The marks of `gsapp.session.limits` belong to a chart whose value stands at the end of a range; here
the pilot is told, once for each event, which sensor it was and what to do about it. What was
limited before it came to its end, in the converter or by a stop, shows as flat tops: the same
highest value again and again, which noise does not allow.
"""

from __future__ import annotations

from collections import deque
from typing import Final

import numpy as np
import numpy.typing as npt

from gsapp.aircraft import Aircraft
from gsapp.excitation.dangers.danger import Urgency
from gsapp.excitation.dangers.frames import Frame
from gsapp.excitation.dangers.standing import Finding
from gsapp.excitation.dangers.wording import TITLES
from gsapp.flight.maneuvers.clipping import at_range_end, instrument_ranges
from gsapp.quantities import FloatArray

_SENSORS: Final = ("alpha", "beta", "p", "q", "r", "ax", "ay", "an")
_LEAST: Final = 3
"""Successive samples at the end: one alone is a spike."""
_FLAT_TIME: Final = 0.12
"""Seconds at one value."""
_FLAT: Final = 0.12
"""Of the usual change from row to row; less is none."""
_MEMORY: Final = 40
"""Frames of which the usual change and the swing are remembered."""
_STANDS_OUT: Final = 6.0
"""A flat top lies so many usual changes away from the middle of the last seconds, or more."""


class ClipRoom:
    """Watches alpha, beta, rates and accelerations.

    Parameters
    ----------
    aircraft : Aircraft or None
        Knows the ranges; without it only flat tops tell.
    rate : float
        Hz.
    """

    def __init__(self, aircraft: Aircraft | None, rate: float) -> None:
        self._ranges = {} if aircraft is None else instrument_ranges(aircraft)
        self._flat_rows = max(4, round(_FLAT_TIME * rate))
        self.restart()

    def restart(self) -> None:
        """Forget everything."""
        self._changes = {name: deque[float](maxlen=_MEMORY) for name in _SENSORS}
        self._ends = {name: deque[tuple[float, float]](maxlen=_MEMORY) for name in _SENSORS}
        self._runs = {name: deque[int](maxlen=_MEMORY) for name in _SENSORS}
        self._tails: dict[str, FloatArray] = {}

    def judge(self, frame: Frame, doubted: frozenset[str]) -> list[Finding]:
        """Return which sensors stand at an end of their range in this frame.

        Parameters
        ----------
        frame : Frame
        doubted : frozenset of str
            Sensors of which something worse is known.
        """
        found = []
        for name in _SENSORS:
            values = frame.rows[name]
            flat = self._flat_top(name, values)
            clipped = (
                name in self._ranges
                and _longest(at_range_end(values, self._ranges[name])) >= _LEAST
            )
            if (clipped or flat) and name not in doubted and _flies(frame):
                found.append(_finding(name))
        return found

    def _flat_top(self, name: str, values: FloatArray) -> bool:
        """Return whether the highest or lowest value of late is held."""
        if not np.isfinite(values).all():
            self._tails.pop(name, None)
            return False
        tail = self._tails.get(name)
        line = values if tail is None else np.concatenate((tail, values))
        self._tails[name] = values[-self._flat_rows :]
        steps = np.abs(np.diff(line))
        changes, ends = self._changes[name], self._ends[name]
        usual = float(np.median(changes)) if len(changes) == _MEMORY else 0.0
        changes.append(float(np.sqrt(np.mean(steps * steps))))
        low, high = float(line.min()), float(line.max())
        still = np.concatenate((steps < _FLAT * usual, [False]))
        self._runs[name].append(_longest(still))
        former = list(ends)
        ends.append((low, high))
        if usual <= 0.0:
            return False
        low = min(low, *(one for one, _ in former))
        high = max(high, *(one for _, one in former))
        slack = _FLAT * usual
        middle = 0.5 * (low + high)
        if high - middle < _STANDS_OUT * usual:
            return False
        at_end = (line >= high - slack) | (line <= low + slack)
        # A slow link repeats itself everywhere, not at the ends only.
        runs = self._runs[name]
        usual_run = sorted(runs)[-1 - len(runs) // 10]
        return _longest(still & at_end) >= max(self._flat_rows - 1, 2 * usual_run + 1)


def _flies(frame: Frame) -> bool:
    """Return whether it flies and does not touch down just now."""
    return frame.airborne and not frame.near_ground


def _longest(true: npt.NDArray[np.bool_]) -> int:
    """Return the length of the longest run of true values, shape (n,)."""
    if not true.any():
        return 0
    edges = np.flatnonzero(np.diff(np.concatenate(([0], true.astype(np.int8), [0]))))
    return int((edges[1::2] - edges[::2]).max())


def _finding(name: str) -> Finding:
    title = TITLES[name]
    return Finding(
        key=f"clip.{name}",
        urgency=Urgency.CAUTION,
        words=f"The {title} is at the end of its range and cuts off: fly the next input smaller",
        spoken=f"{title} clips",
    )

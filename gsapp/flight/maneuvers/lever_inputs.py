"""Steps, pulses and doublets of throttle and flap.

Levers move slower than sticks, and so do the engines and drives behind them. What tells an input
from flying is that the lever rests before and after, and that no surface moves quickly meanwhile.
A lever that stays where it was moved to made a step: no trim is to be found again.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gsapp.flight.maneuvers.input_shape import SurfaceInput, measure_surface_input
from gsapp.flight.maneuvers.settings import DETECTION
from gsapp.quantities import FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class LeverMotion:
    """When a lever moved, and until when it then rested and no surface moved quickly, s."""

    first: float
    last: float
    rested_until: float


class LeverMonitor:
    """Follows one lever, frame by frame; `least` is the move that counts, `still` that of rest."""

    def __init__(self, least: float, still: float) -> None:
        self._least, self._still = least, still
        self.restart()

    def restart(self) -> None:
        """Begin a stretch of samples without a gap."""
        self._level = math.nan  # Where it rests, or rested before it moved.
        self._mean = math.nan
        self._rest = 0  # Frames.
        self._reach = 0.0
        self._moving: tuple[float, float] | None = None

    def add(self, times: FloatArray, samples: FloatArray, *, quick: bool) -> LeverMotion | None:
        """Take in a frame; return a motion whose rest is over.

        `quick` is whether a surface moved quickly in it.
        """
        samples = samples[np.isfinite(samples)]
        if not samples.size:
            found = self.finish(float(times[0]))
            self.restart()
            return found
        mean, spread = float(samples.mean()), float(np.ptp(samples))
        rests = spread <= self._still and not abs(mean - self._mean) > self._still
        self._mean = mean
        found = None
        if quick or not rests:
            found = self.finish(float(times[0]))
        if quick:
            # What moves from now on moves with a stick.
            self._moving, self._rest, self._level = None, 0, math.nan
            return found
        self._rest = self._rest + 1 if rests else 0
        if self._moving is not None:
            self._reach = max(self._reach, float(np.max(np.abs(samples - self._level))))
            if not rests:
                self._moving = (self._moving[0], float(times[-1]))
            if self._rest >= DETECTION.max_free_response / DETECTION.frame_duration:
                found = self.finish(float(times[-1]))
        elif not rests and math.isfinite(self._level):
            self._moving = (float(times[0]), float(times[-1]))
            self._reach = float(np.max(np.abs(samples - self._level)))
        elif self._rest >= DETECTION.lever_rest_frames:
            self._level = mean
        return found

    def finish(self, time: float) -> LeverMotion | None:
        """End the rest after a motion at a time, s; return the motion if it counts."""
        if self._moving is None or self._rest < DETECTION.lever_rest_frames:
            return None
        first, last = self._moving
        reach, self._moving, self._level = self._reach, None, self._mean
        if reach < self._least or last - first > DETECTION.max_input_duration:
            return None
        return LeverMotion(first=first, last=last, rested_until=time)


def measure_lever_input(
    name: str, times: FloatArray, samples: FloatArray, motion: LeverMotion, noise: float
) -> SurfaceInput | None:
    """Measure an input of a lever; None where samples are missing.

    `times`, `samples`, shape (n,): from a good second before to a good second after it. `noise` is
    the standard deviation of its signal.
    """
    there = np.isfinite(samples)
    times, samples = times[there], samples[there]
    calm = (times >= motion.first - DETECTION.trim_time) & (times < motion.first)
    rest = (times > motion.last) & (times <= motion.last + DETECTION.trim_time)
    inside = (times >= motion.first) & (times <= motion.last)
    if calm.sum() < 3 or rest.sum() < 3 or not inside.any():
        return None
    before, after = float(np.median(samples[calm])), float(np.median(samples[rest]))
    change = abs(after - before)
    if change < 0.5 * float(np.ptp(samples[inside])):
        first = motion.first + DETECTION.look_back
        return measure_surface_input(name, times, samples, first, motion.last, noise)
    near = DETECTION.begin_share * change
    left = times[(times <= motion.last) & (np.abs(samples - before) < near)]
    there_again = times[(times >= motion.first) & (np.abs(samples - after) < near)]
    t_start = float(left[-1]) if left.size else motion.first
    t_end = float(there_again[there_again > t_start][0]) if there_again.size else motion.last
    return SurfaceInput(
        surface=name,
        t_start=t_start,
        t_end=t_end,
        amplitude=change,
        trim_before=before,
        trim_after=after,
        excursions=((1 if after > before else -1, motion.rested_until - t_end),),
        motion_before=float(np.ptp(samples[calm])),
        max_excursion=change,
        max_step=change,
        side_ratio=0.0,
        kind="step",
    )

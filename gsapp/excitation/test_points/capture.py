"""Which test point the aircraft is holding now, without a key being pressed."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from gsapp.excitation.flight_rows import FlightRows
from gsapp.excitation.settings import INPUTS
from gsapp.excitation.test_points.point import TestPoint
from gsapp.excitation.trim.trim_cue import TrimDeviation
from gsapp.quantities import BoolArray, FloatArray


def guidance_text(
    point: TestPoint | None,
    *,
    speed: float | None,
    alpha: float | None,
    system: str = "US",
) -> str:
    """Return short advice towards a test point; empty where there is nothing to say.

    Speed counts; at 1 g it fixes alpha, so alpha speaks where no speed is measured or asked for,
    and once the speed is right.
    """
    if point is None:
        return ""
    fast = _deviation(speed, point.speed)
    steep = _deviation(alpha, point.alpha)
    if fast is not None and abs(fast) > INPUTS.deadband * point.speed_tolerance:
        share = abs(fast) / point.speed_tolerance
        text = TrimDeviation(
            quantity="speed", amount=fast, tolerance_ratio=share, channel="V"
        ).format_text(system)
        far = share > INPUTS.far_tolerances
        return f"{text}: {_throttle_advice(fast < 0.0, far, point.throttle)}"
    if steep is not None:
        share = abs(steep) / point.alpha_tolerance
        text = TrimDeviation(
            quantity="alpha", amount=steep, tolerance_ratio=share, channel="alpha"
        ).format_text(system)
        if fast is not None and share > 1.0:
            # The speed is right, so the load is not 1 g: in a turn that is as it should be.
            return text
        if fast is None and share > INPUTS.deadband:
            far = share > INPUTS.far_tolerances
            return f"{text}: {_throttle_advice(steep > 0.0, far, point.throttle)}"
    return ""


def _deviation(value: float | None, wanted: float | None) -> float | None:
    if value is None or wanted is None or not math.isfinite(value):
        return None
    return value - wanted


def _throttle_advice(more: bool, far: bool, throttle: float | None) -> str:
    if not far or throttle is None:
        return "a little power" if more else "ease the throttle"
    return f"{'power' if more else 'throttle back'}, then {100.0 * throttle:.0f} %"


class TestPointCapture:
    """Captures the point that is held; the nearest of several that are still open.

    What comes out depends on the rows only, not on how they were cut. A point with a speed is held
    by speed, one with an angle of attack alone by that.
    """

    def __init__(self, points: Sequence[TestPoint] = ()) -> None:
        self._points = tuple(points)
        self.restart()

    def restart(self) -> None:
        self._times = np.empty(0)
        self._kept = np.empty((0, 2))
        self._captured: int | None = None

    def set_points(self, points: Sequence[TestPoint]) -> None:
        """Watch other points; one that was captured and is still among them stays so."""
        known = {point: index for index, point in enumerate(points)}
        self._captured = known.get(self.captured) if self.captured is not None else None
        self._points = tuple(points)

    @property
    def captured(self) -> TestPoint | None:
        """Return the point captured last, until the aircraft has left it; None for none."""
        return None if self._captured is None else self._points[self._captured]

    def process_rows(self, rows: FlightRows) -> None:
        if rows.starts_segment:
            self.restart()
        if not len(rows):
            return
        times = np.concatenate((self._times, rows.times))
        flow = np.concatenate((self._kept, np.column_stack((rows["V"], rows["alpha"]))))
        old = len(self._kept)
        if times.size < 2:
            self._times, self._kept = times, flow
            return
        window = round(INPUTS.capture_time * (times.size - 1) / float(times[-1] - times[0]))
        misses = [self._misses(point, flow) for point in self._points]
        held = [
            _held(miss, _tolerance(point), window)[old:]
            for point, miss in zip(self._points, misses, strict=True)
        ]
        self._judge(np.array(held).reshape(len(held), -1), [miss[old:] for miss in misses])
        self._times, self._kept = times[-(window + 1) :], flow[-(window + 1) :]

    def _misses(self, point: TestPoint, flow: FloatArray) -> FloatArray:
        """Return how far each row is from a point, m/s or rad; NaN where not measured."""
        if point.speed is not None:
            return flow[:, 0] - point.speed
        if point.alpha is not None:
            return flow[:, 1] - point.alpha
        return np.full(len(flow), np.nan)

    def _judge(self, held: BoolArray, misses: Sequence[FloatArray]) -> None:
        """Find what is captured after the newest rows."""
        anywhere = np.flatnonzero(held.any(axis=0)) if held.size else np.empty(0, dtype=int)
        since = 0
        if anywhere.size:
            since = int(anywhere[-1])
            self._captured = min(
                np.flatnonzero(held[:, since]).tolist(),
                key=lambda place: abs(misses[place][since]) / _tolerance(self._points[place]),
            )
        if self._captured is not None:
            point = self._points[self._captured]
            after = np.abs(misses[self._captured][since:])
            if bool((after > INPUTS.release_tolerances * _tolerance(point)).any()):
                self._captured = None


def _tolerance(point: TestPoint) -> float:
    return point.speed_tolerance if point.speed is not None else point.alpha_tolerance


def _held(misses: FloatArray, tolerance: float, window: int) -> BoolArray:
    """Return at which rows a point has been held for a whole window, shape (n,)."""
    inside = np.abs(misses) <= tolerance
    places = np.arange(misses.size)
    outside = np.maximum.accumulate(np.where(inside, -1, places))
    long_enough = places - outside > window
    before = np.concatenate((np.full(min(window, misses.size), np.nan), misses[: -window or None]))
    steady = np.abs(misses - before[: misses.size]) <= INPUTS.max_speed_change * tolerance
    return np.asarray(long_enough & steady, dtype=np.bool_)

"""Quick moves of the surfaces: what tells an input made on purpose from steering.

A surface that is moved on purpose goes further within `DETECTION.look_back` than steering ever
does; how far steering goes is learned from the flight itself. Used by the detection, frame by
frame, and by whoever watches inputs while they happen.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Final

import numpy as np

from gsapp.flight.maneuvers.input_measures import GradingContext
from gsapp.flight.maneuvers.input_shape import SurfaceInput, measure_surface_input, smooth_samples
from gsapp.flight.maneuvers.settings import DETECTION
from gsapp.flight.maneuvers.signals import SIGNAL_COLUMNS, SURFACES
from gsapp.quantities import FloatArray

UNAMBIGUOUS_SHAPES: Final = ("doublet", "3-2-1-1")
"""Shapes that steering hardly makes."""


class RapidMoveDetector:
    """How far each surface goes within `DETECTION.look_back`, and how far steering goes.

    By surface, rad: a quick move goes further than its `thresholds`.
    """

    def __init__(self, setting: GradingContext, rate: float) -> None:
        self.lag = max(round(DETECTION.look_back * rate), 1)
        self.half_travel = [setting.half_travel(name) for name in SURFACES]
        self.thresholds = [setting.least_move(name) for name in SURFACES]
        self._steering = [deque[float](maxlen=DETECTION.steering_frames) for _ in SURFACES]
        self.restart()

    def restart(self) -> None:
        """Begin a stretch of samples without a gap; what was learned stays."""
        self._tail = np.full((self.lag + 2, len(SURFACES)), np.nan)

    def measure(self, rows: FloatArray) -> FloatArray:
        """Return how far each surface went within `DETECTION.look_back`, rad, shape (n, 3).

        Of the rows that follow those of the last call; the surfaces come first. Single wild samples
        are voted out by their two predecessors. 0 where samples are missing.
        """
        surfaces = np.concatenate((self._tail, rows[:, : len(SURFACES)]))
        self._tail = surfaces[-(self.lag + 2) :]
        one, two, three = surfaces[:-2], surfaces[1:-1], surfaces[2:]
        voted = np.maximum(np.minimum(one, two), np.minimum(np.maximum(one, two), three))
        moves = np.abs(voted[self.lag :] - voted[: -self.lag])
        return np.where(np.isnan(moves), 0.0, moves)

    def learn_pilot_activity(self, frames: Iterable[FloatArray]) -> None:
        """Take the furthest moves of frames of half a second, shape (3,), for steering."""
        for peaks in frames:
            for index, seen in enumerate(self._steering):
                seen.append(float(peaks[index]))

    def update_thresholds(self, setting: GradingContext) -> None:
        """Draw the thresholds anew from the noise floor and from the steering seen so far."""
        for index, name in enumerate(SURFACES):
            seen = sorted(self._steering[index])
            steering = 0.0
            if len(seen) >= DETECTION.min_steering_frames:
                steering = seen[int(DETECTION.steering_quantile * len(seen))]
            self.thresholds[index] = max(
                setting.least_move(name),
                setting.noise.least_move(name, DETECTION.rapid_move_over_noise),
                DETECTION.rapid_move_over_steering * steering,
            )


def find_strong_moves(
    times: FloatArray, rows: FloatArray, moved: Iterable[str], first: float, last: float, lag: int
) -> dict[str, tuple[float, float]]:
    """Return first and last quick move of each surface, without steering around them, s.

    `first` and `last` are those of all surfaces, `lag` the samples in `DETECTION.look_back`.
    """
    # The first and the last step are half as large as those between, and may be less than
    # quick by themselves.
    inside = (times >= first - DETECTION.first_step_search) & (times <= last + 0.5)
    found = {}
    for place, surface in enumerate(SURFACES):
        if surface not in moved:
            continue
        samples = rows[:, place]
        moves = np.zeros(times.size)
        moves[lag:] = np.abs(samples[lag:] - samples[:-lag])
        moves = np.where(inside & np.isfinite(moves), moves, 0.0)
        strongest = int(np.argmax(moves))
        least = DETECTION.step_share * float(moves[strongest])
        strong = np.flatnonzero(moves > least)
        if strong.size:
            index = int(np.searchsorted(strong, strongest))
            found[surface] = _cluster(times[strong], min(index, strong.size - 1))
    return found


def _cluster(times: FloatArray, strongest: int) -> tuple[float, float]:
    """Return first and last of the times that hang together with the strongest one, s."""
    parted = np.flatnonzero(np.diff(times) > DETECTION.input_end_pause_displaced)
    low = int(np.searchsorted(parted, strongest))
    first = int(parted[low - 1]) + 1 if low > 0 else 0
    last = int(parted[low]) if low < parted.size else times.size - 1
    return float(times[first]), float(times[last])


def find_pilot_takeover(
    times: FloatArray,
    rows: FloatArray,
    last: float,
    setting: GradingContext,
    rate: float,
    *,
    stood: Mapping[str, float] = MappingProxyType({}),
    least: float = 0.0,
) -> float | None:
    """Return when the pilot took over after the last quick move, s; None if not yet.

    The samples begin at that move or before. A surface that goes back to where it `stood` before it
    all, rad, is let go, not taken; what moves less than `least` (rad) is no hand.
    """
    rest = last + 0.3
    calm = (times >= rest) & (times < rest + 0.4)
    earliest: float | None = None
    for surface in SURFACES:
        samples = rows[:, SIGNAL_COLUMNS[surface]]
        level = samples[calm]
        if not np.isfinite(level).any():
            continue
        margin = max(
            0.3 * DETECTION.min_rapid_move * setting.half_travel(surface),
            setting.noise.least_move(surface, 5.0),
            least,
        )
        held = float(np.nanmedian(level))
        away = distance_outside_range(
            smooth_samples(samples, 1.0 / rate), held, stood.get(surface, held)
        )
        off = away > margin
        gone = np.flatnonzero(off & (times > rest + 0.2))
        if gone.size:
            at = float(times[gone[0]])
            earliest = at if earliest is None else min(earliest, at)
    return earliest


def distance_outside_range(samples: FloatArray, one: float, other: float) -> FloatArray:
    """Return how far samples lie outside of what is between two levels, 0 for those inside."""
    low, high = min(one, other), max(one, other)
    return np.asarray(np.maximum(np.maximum(low - samples, samples - high), 0.0))


def is_deliberate_input(main: SurfaceInput, free: float, threshold: float) -> bool:
    """Return whether an input looks like one made on purpose.

    The less its shape tells, the calmer it must be before and after, where no stick moves for
    `free` s. Large steps to both sides leave no doubt even if the pilot takes over at once. One to
    a single side is no maneuver then: steering in a fright looks the same. A quick move of its
    surface goes beyond `threshold`, rad.
    """
    # What steering does may have been learned since the move was taken for quick.
    if main.max_step < threshold:
        return False
    clear = main.kind in UNAMBIGUOUS_SHAPES
    strict = not clear or main.abruptness <= DETECTION.sudden_share
    certain = DETECTION.certain_step_ratio_other if strict else DETECTION.certain_step_ratio
    if main.is_unmistakable and main.max_step > certain * threshold:
        return True
    abrupt = DETECTION.abrupt_share if clear else DETECTION.abrupt_share_other
    if main.is_from_calm:
        abrupt *= DETECTION.calm_abrupt_ratio
    if main.kind == "retrim" or main.abruptness < abrupt:
        return False
    if main.motion_before > (0.6 if clear else 0.35) * main.amplitude:
        return False
    return main.has_returned_to_trim and free > (
        DETECTION.hands_off if clear else DETECTION.hands_off_other
    )


def measure_moved_inputs(
    times: FloatArray,
    rows: FloatArray,
    moves: dict[str, tuple[float, float]],
    setting: GradingContext,
) -> list[SurfaceInput]:
    """Measure inputs from their first and last quick moves (s), that of the quickest step first.

    Quickest as share of travel.
    """
    found = []
    for surface, (first, last) in moves.items():
        noise = setting.noise.std_of(surface)
        one = measure_surface_input(
            surface, times, rows[:, SIGNAL_COLUMNS[surface]], first, last, noise
        )
        if one is not None:
            found.append(one)
    # Steering may go further than an input, but not as quickly.
    sizes = {one.surface: one.max_step / setting.half_travel(one.surface) for one in found}
    found.sort(key=lambda one: -sizes[one.surface])
    return [one for one in found if one is found[0] or _belongs_to_main_input(one, found[0], sizes)]


def _belongs_to_main_input(one: SurfaceInput, main: SurfaceInput, sizes: dict[str, float]) -> bool:
    return (
        sizes[one.surface] >= DETECTION.secondary_input_ratio * sizes[main.surface]
        and one.abruptness > DETECTION.abrupt_share
        and one.t_start < main.t_end + DETECTION.input_end_pause
        and one.t_end > main.t_start - DETECTION.input_end_pause
    )

"""Quick moves that may be an input: sticks let go or not, what was moved, hands on again."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from gsapp.excitation.doublets.flight_context import FlightContext, SignalHistory
from gsapp.excitation.doublets.verdict_criteria import InputRequest
from gsapp.excitation.settings import CUES, DOUBLETS
from gsapp.flight.maneuvers.input_shape import SurfaceInput, measure_surface_input, smooth_samples
from gsapp.flight.maneuvers.rapid_moves import (
    UNAMBIGUOUS_SHAPES,
    distance_outside_range,
    find_pilot_takeover,
    find_strong_moves,
    is_deliberate_input,
    measure_moved_inputs,
)
from gsapp.flight.maneuvers.settings import DETECTION
from gsapp.flight.maneuvers.signals import SURFACES
from gsapp.quantities import FloatArray


@dataclass(slots=True)
class InputCandidate:
    """Quick moves that may be an input."""

    first_move_time: float
    last_move_time: float
    """Time of the first and of the last quick move, s."""
    began_in_recovery: bool
    """Whether the pilot was recovering when it began."""
    surfaces: list[str] = field(default_factory=list)
    """Surfaces in the order of their first quick move."""
    inputs: list[SurfaceInput] = field(default_factory=list)
    """Measured when the sticks were let go; empty before."""
    t_end: float = math.nan
    """When the last surface was back, s."""
    request: InputRequest = field(default_factory=InputRequest)
    """What the input is held against, once it is known."""
    hands_off: float = DETECTION.min_free_response_time
    """Seconds for which the hands should be off."""
    previous_inputs: list[SurfaceInput] = field(default_factory=list)
    """What was found before the sticks moved again so soon that it seemed to go on; empty for
    nothing."""
    resume_time: float = math.nan
    """When they did, s."""
    is_confirmed: bool = False
    """Whether it was what had been expected, so that nothing that follows makes it steering."""

    @property
    def expected_surfaces(self) -> set[str]:
        return (
            set() if self.request.target_input is None else set(self.request.target_input.surfaces)
        )

    @property
    def pending_surfaces(self) -> set[str]:
        return self.expected_surfaces - set(self.surfaces)

    @property
    def expected_kind(self) -> str:
        """Return the shape expected; empty for none."""
        return "" if self.request.target_input is None else self.request.target_input.kind


def remove_steering(
    one: SurfaceInput,
    kind: str,
    times: FloatArray,
    samples: FloatArray,
    span: tuple[float, float],
    threshold: float,
    noise: float,
) -> SurfaceInput:
    """Return the input that was expected, where steering ran into it; else what was measured.

    `one` was measured from the first quick move on, and is of another shape than the `kind`
    expected; `span` has the first and last quick move of the surface, s.
    """
    for begin in _steps(times, samples, span, threshold):
        later = measure_surface_input(one.surface, times, samples, begin, span[1], noise)
        if later is None or later.kind != kind or later.max_step < threshold:
            continue
        if later.amplitude > max(DOUBLETS.min_relative_size * one.amplitude, later.motion_before):
            return later
    return one


def _steps(
    times: FloatArray, samples: FloatArray, span: tuple[float, float], threshold: float
) -> list[float]:
    """Return when each quick move after the first one began, s."""
    dt = float(np.median(np.diff(times)))
    lag = max(round(DETECTION.look_back / dt), 1)
    moves = np.zeros(times.size)
    moves[lag:] = np.abs(samples[lag:] - samples[:-lag])
    inside = (times >= span[0]) & (times <= span[1])
    quick = times[inside & (np.nan_to_num(moves) > threshold)]
    return [float(at) for at in quick[1:][np.diff(quick) > DOUBLETS.step_gap]]


class StickReleaseDetector:
    """Reads the sticks from the surfaces."""

    def __init__(self, history: SignalHistory, around: FlightContext) -> None:
        self._history = history
        self._around = around

    def amplitudes(self, moving: InputCandidate, now: float) -> dict[str, float]:
        """Return how far each surface went so far, rad: half of peak to peak."""
        _, rows = self._history.segment(moving.first_move_time - DETECTION.look_back, now)
        found = {}
        for surface in moving.surfaces:
            samples = rows[:, SURFACES.index(surface)]
            if np.isfinite(samples).any():
                found[surface] = 0.5 * float(np.nanmax(samples) - np.nanmin(samples))
        shares = {
            name: size / self._around.setting.half_travel(name) for name, size in found.items()
        }
        most = max(shares.values(), default=0.0)
        return {
            name: size
            for name, size in found.items()
            if shares[name] >= DETECTION.secondary_input_ratio * most
        }

    def detect_release(self, moving: InputCandidate, now: float) -> list[SurfaceInput] | None:
        """Return what was moved once the sticks are let go, the main surface first.

        Empty if it was steering; None while that is open.
        """
        if moving.last_move_time - moving.first_move_time > DOUBLETS.max_duration:
            return []
        idle = now - moving.last_move_time
        if idle < (
            DOUBLETS.release_time_expected
            if moving.pending_surfaces and moving.pending_surfaces < moving.expected_surfaces
            else DOUBLETS.release_time
        ):
            return None
        ends = idle >= DETECTION.input_end_pause_displaced or self._back(moving, now)
        if not ends and idle <= DOUBLETS.last_step_time:
            return None
        found = self._measured(moving, now)
        if not ends and not (
            found and _is_complete(found[0], idle) and self._both_sides(moving, found[0], now)
        ):
            return None
        if not found:
            return []
        if self._is_input(moving, found[0], now):
            return found
        return [] if idle >= DETECTION.input_end_pause else None

    def detect_hands_on(self, moving: InputCandidate, now: float, rate: float) -> float | None:
        """Return when a hand was put on after the sticks were let go, s; None while none is."""
        # The last step of a small input may be no quick move.
        last = max(moving.last_move_time, moving.t_end - 0.1)
        times, rows = self._history.segment(last - 0.1, now)
        # A second stick that goes back to where it stood is let go late. One of the input's own
        # sticks that moves at all is in a hand.
        own = {one.surface for one in moving.inputs}
        stood = {name: at for name, at in self._stood(moving).items() if name not in own}
        taken = find_pilot_takeover(
            times, rows, last, self._around.setting, rate, stood=stood, least=DOUBLETS.rest_movement
        )
        at_once = self._resting_moved(moving, now, stood)
        if at_once is None:
            return taken
        at_once = max(at_once, moving.t_end)
        return at_once if taken is None else min(at_once, taken)

    def _stood(self, moving: InputCandidate) -> dict[str, float]:
        """Return where each surface stood before the input, rad."""
        begin = moving.first_move_time - DETECTION.look_back
        _, rows = self._history.segment(begin - 0.5, begin)
        return {
            surface: float(np.nanmedian(samples))
            for index, surface in enumerate(SURFACES)
            if np.isfinite(samples := rows[:, index]).any()
        }

    def _resting_moved(
        self, moving: InputCandidate, now: float, stood: Mapping[str, float]
    ) -> float | None:
        """Return when a surface that had been at rest moved after the sticks were let go, s.

        A hand that is put on at once moves other surfaces before the last one of the input rests.
        A second stick that goes back to where it stood is let go late.
        """
        start, stop = (moving.t_end - wait for wait in DOUBLETS.rest_interval)
        times, rows = self._history.segment(start, now)
        before, after = times <= stop, times > stop
        dt = float(np.median(np.diff(times))) if times.size > 2 else 1.0
        moved: list[float] = []
        # The last step of the input is no hand, however long its plateau was.
        ending = {one.surface for one in moving.inputs if one.t_end > start}
        for index, surface in enumerate(SURFACES):
            if surface in ending:
                continue
            samples = smooth_samples(rows[:, index], dt)
            rest = samples[before]
            noise = self._around.setting.noise.std_of(surface)
            if not np.isfinite(rest).all() or np.ptp(rest) > max(
                DOUBLETS.rest_movement, 4.0 * noise
            ):
                continue
            held = float(np.median(rest))
            away = distance_outside_range(samples, held, stood.get(surface, held))
            off = away > max(DOUBLETS.stick_movement, 6.0 * noise)
            gone = np.flatnonzero(off & after)
            if gone.size:
                moved.append(float(times[gone[0]]))
        return min(moved, default=None)

    def _is_input(self, moving: InputCandidate, main: SurfaceInput, now: float) -> bool:
        """Return whether the main surface was moved on purpose."""
        if moving.began_in_recovery and not main.is_unmistakable:
            return False
        clear = main.kind in UNAMBIGUOUS_SHAPES or main.kind == moving.expected_kind
        if not clear and now - moving.last_move_time < DOUBLETS.hands_off_other:
            return False
        threshold = self._around.move_detector.thresholds[SURFACES.index(main.surface)]
        both = self._both_sides(moving, main, now)
        meant = _is_flawed_attempt(
            moving,
            main,
            (DOUBLETS.certain_step_ratio if both else DOUBLETS.certain_step_ratio_one_side)
            * threshold,
        )
        if not clear and moving.expected_kind and not meant:
            return False
        if _matches_expected(moving, main, threshold):
            moving.is_confirmed = True
            return True
        if is_deliberate_input(main, math.inf, threshold):
            return True
        return (
            not main.has_returned_to_trim
            and both
            and (meant or _is_unreturned_doublet(main, threshold))
        )

    def _measured(self, moving: InputCandidate, now: float) -> list[SurfaceInput]:
        """Return what each surface did, that of the input first."""
        times, rows = self._history.segment(
            moving.first_move_time - DETECTION.look_back - DOUBLETS.pre_input_time, now
        )
        lag = self._around.move_detector.lag
        if times.size <= lag:
            return []
        moves = find_strong_moves(
            times, rows, moving.surfaces, moving.first_move_time, moving.last_move_time, lag
        )
        found = measure_moved_inputs(times, rows, moves, self._around.setting)
        inputs = [self._left(one, moves, moving.last_move_time, times, rows) for one in found]
        inputs = [self._alone(one, moving, moves, times, rows) for one in inputs]
        # A second stick may go further than the input that was expected.
        return sorted(
            inputs,
            key=lambda one: (
                not (one.surface in moving.expected_surfaces and one.kind in UNAMBIGUOUS_SHAPES)
            ),
        )

    def _left(
        self,
        one: SurfaceInput,
        moves: Mapping[str, tuple[float, float]],
        last: float,
        times: FloatArray,
        rows: FloatArray,
    ) -> SurfaceInput:
        if abs(one.trim_after - one.trim_before) < DOUBLETS.displaced_share * one.amplitude:
            return one
        noise = self._around.setting.noise.std_of(one.surface)
        samples = rows[:, SURFACES.index(one.surface)]
        first = moves[one.surface][0]
        other = measure_surface_input(one.surface, times, samples, first, last, noise, left=True)
        return one if other is None or other.kind not in UNAMBIGUOUS_SHAPES else other

    def _alone(
        self,
        one: SurfaceInput,
        moving: InputCandidate,
        moves: Mapping[str, tuple[float, float]],
        times: FloatArray,
        rows: FloatArray,
    ) -> SurfaceInput:
        """Return an input of another shape than expected without the steering before it."""
        if one.surface not in moving.expected_surfaces or one.kind == moving.expected_kind:
            return one
        index = SURFACES.index(one.surface)
        return remove_steering(
            one,
            moving.expected_kind,
            times,
            rows[:, index],
            moves[one.surface],
            self._around.move_detector.thresholds[index],
            self._around.setting.noise.std_of(one.surface),
        )

    def _both_sides(self, moving: InputCandidate, main: SurfaceInput, now: float) -> bool:
        _, rows = self._history.segment(main.t_start, min(moving.last_move_time + 0.2, now))
        away = rows[:, SURFACES.index(main.surface)] - main.trim_before
        if not np.isfinite(away).any():
            return False
        sides = sorted((float(np.nanmax(away)), float(-np.nanmin(away))))
        return sides[0] > DOUBLETS.second_side_share * sides[1]

    def _back(self, moving: InputCandidate, now: float) -> bool:
        """Return whether every moved surface is near where it was before."""
        begin = moving.first_move_time - DETECTION.look_back
        times, rows = self._history.segment(begin - 0.5, now)
        for surface in moving.surfaces:
            samples = rows[:, SURFACES.index(surface)]
            early, late = samples[times < begin], samples[times > now - 2.0 * CUES.tick]
            if not (np.isfinite(early).any() and np.isfinite(late).any()):
                continue
            level = float(np.nanmedian(early))
            largest = float(np.nanmax(np.abs(samples - level)))
            if abs(float(np.nanmedian(late)) - level) > DOUBLETS.returned_share * largest:
                return False
        return True


def _is_complete(main: SurfaceInput, idle: float) -> bool:
    longest = max(length for _, length in main.excursions)
    return main.kind in UNAMBIGUOUS_SHAPES and idle > max(
        DOUBLETS.last_step_time, 1.5 * longest + 0.2
    )


def _matches_expected(moving: InputCandidate, main: SurfaceInput, threshold: float) -> bool:
    """Return whether an input of the very shape that was expected came out of calm."""
    calm = main.motion_before < DOUBLETS.max_unrest_expected * main.amplitude
    shaped = main.surface in moving.expected_surfaces and main.kind == moving.expected_kind
    return shaped and calm and main.max_step > threshold


def _is_flawed_attempt(moving: InputCandidate, main: SurfaceInput, least: float) -> bool:
    """Return whether another shape than the one expected was meant to be it, and went wrong.

    Steering makes such moves as well, but hardly out of complete calm.
    """
    calm = main.motion_before < DOUBLETS.max_unrest_other * main.amplitude
    return main.surface in moving.expected_surfaces and calm and main.max_step > least


def _is_unreturned_doublet(main: SurfaceInput, threshold: float) -> bool:
    clear = main.kind in UNAMBIGUOUS_SHAPES and main.max_step > threshold
    return clear and main.abruptness > 0.5 and main.motion_before < main.amplitude

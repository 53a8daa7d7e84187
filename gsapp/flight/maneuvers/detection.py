"""Finding the maneuvers of a whole flight, block by block.

A surface that is moved on purpose goes further within 0.15 s than steering ever does; how far
steering goes is learned from the flight itself. Quick moves that follow each other, on one surface
or several, are one input; it counts as a maneuver if it returns to trim, if the sticks are then
left alone, if the aircraft flies, and if it answers. Everything is decided at the ends of frames of
half a second that are counted from the first sample, so that results do not depend on how the
samples came in pieces.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.flight.flight import Flight
from gsapp.flight.maneuvers.airborne_detection import AirborneDetector
from gsapp.flight.maneuvers.dead_instruments import dead_instruments_text, find_dead_instruments
from gsapp.flight.maneuvers.detected_maneuver import DetectedManeuver
from gsapp.flight.maneuvers.input_measures import (
    GradingContext,
    ManeuverSamples,
    cross_deflections,
    measure_response,
    time_scale_of,
)
from gsapp.flight.maneuvers.input_shape import SurfaceInput
from gsapp.flight.maneuvers.lever_inputs import LeverMonitor, LeverMotion, measure_lever_input
from gsapp.flight.maneuvers.maneuver_grade import grade_maneuver
from gsapp.flight.maneuvers.noise_floor import NoiseFloor, NoiseFloorEstimator
from gsapp.flight.maneuvers.rapid_moves import (
    RapidMoveDetector,
    find_pilot_takeover,
    find_strong_moves,
    is_deliberate_input,
    measure_moved_inputs,
)
from gsapp.flight.maneuvers.settings import DETECTION
from gsapp.flight.maneuvers.signals import (
    CONTROLS,
    LEVERS,
    SIGNAL_COLUMNS,
    SIGNALS,
    SURFACES,
    extract_signals,
)
from gsapp.foundation import FlightError
from gsapp.quantities import Block, FloatArray


@dataclass(slots=True)
class _Candidate:
    """Quick moves that may become a maneuver."""

    first: float
    last: float
    """Time of the first and of the last quick move, s."""
    moved: set[str] = field(default_factory=set)
    """The surfaces."""
    strongest: float = 0.0
    strongest_at: float = 0.0
    """The quickest move as a share of travel, and the end of its frame, s."""
    closed: bool = False
    """Whether the input is over and its answer awaited."""


class ManeuverDetector:
    """Finds maneuvers while samples come in, at least `DETECTION.min_sample_rate` a second."""

    def __init__(self, aircraft: Aircraft, rate: float) -> None:
        if not (math.isfinite(rate) and rate >= DETECTION.min_sample_rate):
            raise FlightError(
                f"maneuvers cannot be found at {rate:g} samples per second; it takes "
                f"{DETECTION.min_sample_rate:g} minimum, 50 or more recommended"
            )
        self._aircraft = aircraft
        # All times inside are flight time over this.
        self._scale = time_scale_of(aircraft)
        self._rate = rate * self._scale
        self._count = max(round(DETECTION.frame_duration * self._rate), 1)
        self._windowed = round(DETECTION.noise_window / DETECTION.frame_duration)
        self.reset()

    def reset(self) -> None:
        """Forget everything; the flight begins anew."""
        self._watch = AirborneDetector(self._aircraft)
        self._flown: list[tuple[float, float]] = []  # when it was in the air, s
        self._meter = NoiseFloorEstimator(self._aircraft, self._rate, self._scale)
        self._setting = GradingContext(
            aircraft=self._aircraft, noise=NoiseFloor(), time_scale=self._scale
        )
        self._found: list[DetectedManeuver] = []
        self._quick = RapidMoveDetector(self._setting, self._rate)
        self._levers = {
            name: LeverMonitor(
                DETECTION.min_lever_move * self._setting.half_travel(name),
                DETECTION.lever_rest * self._setting.half_travel(name),
            )
            for name in LEVERS
        }
        self._last_time = -math.inf
        self._restart()

    def _restart(self) -> None:
        """Begin a stretch of samples without a gap."""
        self._waiting_times: list[FloatArray] = []
        self._waiting_rows: list[FloatArray] = []
        self._waiting = 0
        self._quick.restart()
        self._forget_frames()

    def _forget_frames(self) -> None:
        self._frames: deque[tuple[FloatArray, FloatArray]] = deque(
            maxlen=math.ceil(DETECTION.history_duration / DETECTION.frame_duration)
        )
        self._window: list[FloatArray] = []
        self._candidate: _Candidate | None = None
        self._held: list[FloatArray] = []

    # What it knows --------------------------------------------------------------------

    @property
    def maneuvers(self) -> tuple[DetectedManeuver, ...]:
        return tuple(self._found)

    @property
    def noise(self) -> NoiseFloor:
        return self._meter.floor

    @property
    def airborne(self) -> bool:
        return self._watch.airborne

    def was_airborne(self, start: float, stop: float) -> bool:
        """Return whether the aircraft was in the air at any time from start to stop, s."""
        start, stop = start / self._scale, stop / self._scale
        return any(begin <= stop and end >= start for begin, end in self._flown)

    @property
    def airborne_criterion(self) -> str:
        return self._watch.criterion

    # Samples --------------------------------------------------------------------------

    def feed(self, block: Block) -> None:
        """Take in the next samples; a gap in their times ends what was under way."""
        if not len(block):
            return
        rows, times = extract_signals(block), block.times / self._scale
        longest = 1.5 / self._rate
        steps = np.diff(times, prepend=self._last_time if self._waiting_or_seen else times[0])
        cuts = np.flatnonzero(np.abs(steps) > longest).tolist()
        start = 0
        for stop in (*cuts, times.size):
            if start in cuts:
                self._end_stretch()
            if stop > start:
                self._append(times[start:stop], rows[start:stop])
            start = stop
        self._last_time = float(times[-1])

    def process_step(self) -> None:
        """Nothing is left to do after the blocks of a step: all is drawn from whole frames."""

    def finish(self) -> tuple[DetectedManeuver, ...]:
        """Draw conclusions from what came last; return all maneuvers of the flight by time."""
        self._end_stretch()
        landing = self._watch.possible_landing_time
        if landing is not None:
            self._landed(landing)
        return self.maneuvers

    @property
    def _waiting_or_seen(self) -> bool:
        return math.isfinite(self._last_time)

    def _end_stretch(self) -> None:
        if self._waiting:
            times = np.concatenate(self._waiting_times)
            rows = np.concatenate(self._waiting_rows)
            self._take(times, rows, len(times))
        self._finish_levers()
        if self._candidate is not None:
            self._conclude()
        self._restart()

    def _append(self, times: FloatArray, rows: FloatArray) -> None:
        self._waiting_times.append(times)
        self._waiting_rows.append(rows)
        self._waiting += len(times)
        whole = self._waiting // self._count * self._count
        if not whole:
            return
        all_times = np.concatenate(self._waiting_times)
        all_rows = np.concatenate(self._waiting_rows)
        self._take(all_times[:whole], all_rows[:whole], self._count)
        self._waiting_times, self._waiting_rows = [all_times[whole:]], [all_rows[whole:]]
        self._waiting -= whole

    def _take(self, times: FloatArray, rows: FloatArray, count: int) -> None:
        """Go through frames of `count` samples each."""
        moves = self._quick.measure(rows)
        shaped = rows.reshape(-1, count, len(SIGNALS))
        there = np.isfinite(shaped)
        present = there.sum(axis=1)
        means = np.where(there, shaped, 0.0).sum(axis=1) / np.where(present > 0, present, np.nan)
        peaks = moves.reshape(-1, count, len(SURFACES)).max(axis=1)
        for place in range(len(shaped)):
            low = place * count
            self._frame(
                times[low : low + count],
                shaped[place],
                means[place],
                peaks[place],
                moves[low : low + count],
            )

    # Frames ---------------------------------------------------------------------------

    def _frame(
        self,
        times: FloatArray,
        rows: FloatArray,
        means: FloatArray,
        peaks: FloatArray,
        moves: FloatArray,
    ) -> None:
        if not np.isfinite(rows).any():
            # A gap that was filled: it says nothing of flight or ground, and nothing goes across.
            self._finish_levers()
            if self._candidate is not None:
                self._conclude()
            self._forget_frames()
            return
        was_airborne = self._watch.airborne
        self._watch.add(float(times[0]), means)
        if was_airborne and not self._watch.airborne:
            self._landed(self._watch.since)
        if self._watch.airborne:
            begin = self._flown.pop()[0] if was_airborne and self._flown else float(times[0])
            self._flown.append((begin, float(times[-1])))
        self._frames.append((times, rows))
        self._measure_noise(rows)
        self._note_moves(times, peaks, moves)
        self._follow_levers(times, rows, quick=bool((peaks > self._quick.thresholds).any()))
        if self._candidate is None:
            self._learn([peaks])
        else:
            self._held.append(peaks)
            self._follow(float(times[-1]))

    def _measure_noise(self, rows: FloatArray) -> None:
        self._window.append(rows)
        if len(self._window) < self._windowed:
            return
        self._meter.add(
            np.concatenate(self._window),
            airborne=self._watch.airborne,
            standing=self._watch.is_stationary,
        )
        self._window = []
        noise = self._meter.floor
        self._setting = replace(self._setting, noise=noise)
        self._quick.update_thresholds(self._setting)

    def _learn(self, frames: list[FloatArray]) -> None:
        if self._watch.airborne:
            self._quick.learn_pilot_activity(frames)

    def _note_moves(self, times: FloatArray, peaks: FloatArray, moves: FloatArray) -> None:
        """Note the quick moves of a frame."""
        thresholds = self._quick.thresholds
        quick = [place for place in range(len(SURFACES)) if peaks[place] > thresholds[place]]
        if not quick:
            return
        if self._candidate is not None and self._separate(
            self._candidate, float(times[0]), {SURFACES[place] for place in quick}
        ):
            self._conclude()
        over = (moves > thresholds).any(axis=1)
        where = np.flatnonzero(over)
        first, last = float(times[where[0]]), float(times[where[-1]])
        if self._candidate is None:
            self._candidate = _Candidate(first=first, last=last)
        candidate = self._candidate
        candidate.last = last
        for place in quick:
            candidate.moved.add(SURFACES[place])
            size = float(peaks[place]) / self._quick.half_travel[place]
            if size > candidate.strongest:
                candidate.strongest, candidate.strongest_at = size, float(times[-1])

    @staticmethod
    def _separate(candidate: _Candidate, now: float, surfaces: set[str]) -> bool:
        idle = now - candidate.last
        return candidate.closed or (
            idle >= DETECTION.input_end_pause and surfaces.isdisjoint(candidate.moved)
        )

    def _follow(self, now: float) -> None:
        """See whether the input under way is over, and whether its answer is."""
        candidate = self._candidate
        if candidate is None:
            return
        if candidate.last - candidate.first > DETECTION.max_input_duration:
            # Steering that goes on may have an input in it, and is waited for to its end.
            long_ago = now - candidate.strongest_at > DETECTION.input_end_pause_displaced
            if long_ago or candidate.last - candidate.first > 2.0 * DETECTION.max_input_duration:
                self._conclude()
            return
        idle = now - candidate.last
        if not candidate.closed:
            away = idle < DETECTION.input_end_pause_displaced and not self._back(candidate)
            candidate.closed = idle >= DETECTION.input_end_pause and not away
        if candidate.closed and (
            idle >= DETECTION.max_free_response or self._taken_over(candidate.last, now) < now
        ):
            self._conclude()

    def _stretch(self, start: float) -> tuple[FloatArray, FloatArray]:
        kept = [frame for frame in self._frames if frame[0][-1] >= start]
        times = np.concatenate([frame[0] for frame in kept])
        rows = np.concatenate([frame[1] for frame in kept])
        low = int(np.searchsorted(times, start))
        return times[low:], rows[low:]

    def _back(self, candidate: _Candidate) -> bool:
        """Return whether every moved surface is near where it was before."""
        begin = candidate.first - DETECTION.look_back
        times, rows = self._stretch(begin - 0.5)
        before = times < begin
        for surface in candidate.moved:
            samples = rows[:, SIGNAL_COLUMNS[surface]]
            early, late = samples[before], samples[-self._count :]
            if not (np.isfinite(early).any() and np.isfinite(late).any()):
                continue
            level = float(np.nanmedian(early))
            largest = float(np.nanmax(np.abs(samples - level)))
            if abs(float(np.nanmedian(late)) - level) > 0.4 * largest:
                return False
        return True

    def _taken_over(self, last: float, now: float, least: float = 0.0) -> float:
        """Return when the pilot took over after the last quick move, s; `now` if not yet."""
        times, rows = self._stretch(last - 0.1)
        taken = find_pilot_takeover(times, rows, last, self._setting, self._rate, least=least)
        return now if taken is None else min(taken, now)

    # Levers ---------------------------------------------------------------------------

    def _follow_levers(self, times: FloatArray, rows: FloatArray, *, quick: bool) -> None:
        for name, lever in self._levers.items():
            motion = lever.add(times, rows[:, SIGNAL_COLUMNS[name]], quick=quick)
            if motion is not None:
                self._judge_lever(name, motion)

    def _finish_levers(self) -> None:
        for name, lever in self._levers.items():
            motion = lever.finish(float(self._frames[-1][0][-1])) if self._frames else None
            if motion is not None:
                self._judge_lever(name, motion)
            lever.restart()

    def _judge_lever(self, name: str, motion: LeverMotion) -> None:
        """Keep a motion of a lever as a maneuver if it flies and answers."""
        settled = motion.first - self._watch.since > DETECTION.takeoff_settling_time
        if not (self._watch.airborne and settled):
            return
        times, rows = self._stretch(motion.first - 2.5 * DETECTION.trim_time)
        samples = rows[:, SIGNAL_COLUMNS[name]]
        one = measure_lever_input(name, times, samples, motion, self._setting.noise.std_of(name))
        if one is None:
            return
        passage = ManeuverSamples(
            times=times, rows=rows, t_input=one.t_start, t_input_end=one.t_end,
            t_end=max(motion.rested_until, one.t_end),
        )  # fmt: skip
        sticks = cross_deflections(passage, [one])
        held = all(
            size < DETECTION.lever_stick_share * self._setting.half_travel(surface)
            for surface, size in sticks.items()
        )
        answered = measure_response(passage, self._setting, [name])
        if held and max(answered.values(), default=0.0) >= DETECTION.min_response:
            number = str(len(self._found) + 1)
            self._found.append(build_maneuver(number, passage, self._setting, [one]))

    # Conclusions ----------------------------------------------------------------------

    def _landed(self, time: float) -> None:
        last = (time - DETECTION.landing_margin) * self._scale
        while self._found and self._found[-1].t_input_end > last:
            self._found.pop()
        self._dismiss()

    def _dismiss(self) -> None:
        self._learn(self._held)
        self._held = []
        self._candidate = None

    def _conclude(self) -> None:
        """Decide whether the input that is over was a maneuver."""
        candidate = self._candidate
        if candidate is None:
            return
        found = self._judge(candidate) if self._flies(candidate) else None
        if found is None:
            self._dismiss()
            return
        self._found.append(found)
        self._held = []
        self._candidate = None

    def _flies(self, candidate: _Candidate) -> bool:
        return (
            self._watch.airborne
            and candidate.first - self._watch.since > DETECTION.takeoff_settling_time
        )

    def _judge(self, candidate: _Candidate) -> DetectedManeuver | None:
        times, rows = self._stretch(
            candidate.first - DETECTION.look_back - 2.5 * DETECTION.trim_time
        )
        moves = find_strong_moves(
            times, rows, candidate.moved, candidate.first, candidate.last, self._quick.lag
        )
        inputs = measure_moved_inputs(times, rows, moves, self._setting)
        if not inputs:
            return None
        main = inputs[0]
        last = max(moves[one.surface][1] for one in inputs)
        taken = self._taken_over(last, float(times[-1]))
        alone = taken
        if main.is_from_calm:
            least = DETECTION.calm_hand * main.amplitude
            alone = self._taken_over(last, float(times[-1]), least)
        begin = min(one.t_start for one in inputs)
        end = max(one.t_end for one in inputs)
        passage = ManeuverSamples(
            times=times,
            rows=rows,
            t_input=begin,
            t_input_end=end,
            t_end=min(max(taken, end), end + DETECTION.max_free_response),
        )
        threshold = self._quick.thresholds[SURFACES.index(main.surface)]
        if not is_deliberate_input(main, alone - end, threshold):
            return None
        answered = measure_response(passage, self._setting, [one.surface for one in inputs])
        if answered and max(answered.values()) < DETECTION.min_response:
            return None
        return build_maneuver(str(len(self._found) + 1), passage, self._setting, inputs)


def build_maneuver(
    name: str, passage: ManeuverSamples, setting: GradingContext, inputs: list[SurfaceInput]
) -> DetectedManeuver:
    """Return the maneuver of a passage, graded, in flight time; by what was alive."""
    dead = find_dead_instruments(
        lambda name: (
            passage.rows[:, SIGNAL_COLUMNS[name]] if name in SIGNAL_COLUMNS else np.empty(0)
        ),
        setting.aircraft,
    )
    passage = _drop_signals(passage, [name for names in dead.values() for name in names])
    grade, reasons = grade_maneuver(passage, setting, inputs)
    reasons = (*reasons, dead_instruments_text(dead)) if dead else reasons
    start = max(passage.t_input - DETECTION.trim_time, float(passage.times[0]))
    V, alpha = passage.mean_at_trim("V"), passage.mean_at_trim("alpha")
    return DetectedManeuver(
        id=name,
        t_start=start * setting.time_scale,
        t_end=passage.t_end * setting.time_scale,
        inputs=tuple(name for name in CONTROLS if name in {one.surface for one in inputs}),
        kind=inputs[0].kind if inputs else "none",
        amplitude=inputs[0].amplitude if inputs else None,
        grade=grade,
        reasons=reasons,
        V=V if math.isfinite(V) else None,
        alpha=alpha if math.isfinite(alpha) else None,
        t_input=passage.t_input * setting.time_scale,
        t_input_end=passage.t_input_end * setting.time_scale,
        amplitudes={one.surface: one.amplitude for one in inputs},
    )


def _drop_signals(passage: ManeuverSamples, names: Sequence[str]) -> ManeuverSamples:
    gone = [SIGNAL_COLUMNS[name] for name in names if name in SIGNAL_COLUMNS]
    if not gone:
        return passage
    rows = passage.rows.copy()
    rows[:, gone] = np.nan
    return replace(passage, rows=rows)


def detect_maneuvers(flight: Flight, aircraft: Aircraft) -> tuple[DetectedManeuver, ...]:
    """Find the maneuvers of a whole flight, with the aircraft as that flight flew it."""
    return run_detector(flight, aircraft).finish()


def run_detector(flight: Flight, aircraft: Aircraft) -> ManeuverDetector:
    """Return a detector that has seen a whole flight; `detect_maneuvers` tells the rest."""
    check_detectable(flight)
    detector = ManeuverDetector(aircraft, flight.rate)
    detector.feed(flight.block)
    return detector


def check_detectable(flight: Flight) -> None:
    """Raise `FlightError` for a flight in which no maneuver can be told, with what is missing."""
    if len(flight.block) < 2:
        raise FlightError(f"the flight '{flight.name}' contains no samples")
    rows = extract_signals(flight.block)
    if not np.isfinite(rows[:, : len(SURFACES)]).any():
        had = ", ".join(flight.block.channels) or "no channel"
        raise FlightError(
            f"the flight '{flight.name}' has no samples of a surface (de, da or dr); it has {had}"
        )

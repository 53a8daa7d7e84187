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
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.flight.flight import Flight
from gsapp.flight.maneuvers.airborne import FRAME, AirborneWatch
from gsapp.flight.maneuvers.found import FoundManeuver
from gsapp.flight.maneuvers.grading import (
    TRIM_TIME,
    Passage,
    Setting,
    answer,
    grade_maneuver,
)
from gsapp.flight.maneuvers.noise import WINDOW, NoiseFloor, NoiseMeter
from gsapp.flight.maneuvers.shape import LOOK_BACK, SurfaceInput, measure, smoothed
from gsapp.flight.maneuvers.signals import COLUMN, SIGNALS, SURFACES, signals_of
from gsapp.foundation import FlightError
from gsapp.quantities import Block, FloatArray

SLOWEST_RATE: Final = 8.0
"""Fewer samples a second do not show the steps of an input."""

_SETTLED = 6.0
"""Seconds after take-off in which the pilot is busy with flying."""
_BEFORE_LANDING = 4.0
"""Seconds before a landing that belong to flare and touch-down."""
_CLOSED = 1.3
"""Seconds without a quick move after which an input is over, if the surfaces are back."""
_CLOSED_AWAY = 2.6
"""The same if they are not: the longest step of an input."""
_LONGEST = 10.0
"""An input that goes on for longer, s, is steering, from which to learn."""
_FREE_ANSWER = 5.0
"""Length of the answer after the input that belongs to the maneuver at most, s."""
_KEPT = 40.0
_LEAST_MOVE = 0.02
"""Share of half the travel that a quick move takes at least."""
_OVER_NOISE, _OVER_STEERING = 7.0, 3.0
_STEERING_SHARE = 0.8
_STEERING_FRAMES = 240
_FEWEST_STEERING_FRAMES = 12
ALSO_MOVED: Final = 0.25
"""An input this quick beside the quickest, both as shares of travel, belongs to the maneuver."""
_ANSWERED = 8.0
"""Peak-to-peak answer over the noise floor that a standing aircraft does not give."""
_ABRUPT, _ABRUPT_IF_ODD = 0.35, 0.5
"""Share of its excursion that an input covers within `LOOK_BACK`, doublet or 3-2-1-1, and
any other shape."""
_STRONG = 0.35
"""Share of the quickest move of a surface that the steps of one input reach."""
_AROUND = 1.5
"""Seconds before the first quick move in which the first step is looked for."""
_SURELY = 1.3
"""A step from side to side is no accident this far over the threshold of a quick move."""
_FREE_IF_CLEAR, _FREE_IF_ODD = 0.4, 1.0
"""Seconds without a stick after a doublet or 3-2-1-1, and after any other shape."""


@dataclass(slots=True)
class _Candidate:
    """Quick moves that may become a maneuver.

    Attributes
    ----------
    moved : set of str
        The surfaces.
    first, last : float
        Time of the first and of the last quick move, s.
    strongest, strongest_at : float
        The quickest move as a share of travel, and the end of its frame, s.
    closed : bool
        Whether the input is over and its answer awaited.
    """

    first: float
    last: float
    moved: set[str] = field(default_factory=set)
    strongest: float = 0.0
    strongest_at: float = 0.0
    closed: bool = False


class ManeuverDetector:
    """Finds maneuvers while samples come in.

    Parameters
    ----------
    aircraft : Aircraft
        Travel of the surfaces, stall speed, ranges of the instruments.
    rate : float
        Samples per second.

    Raises
    ------
    FlightError
        If there are too few samples per second to see an input.
    """

    def __init__(self, aircraft: Aircraft, rate: float) -> None:
        if not (math.isfinite(rate) and rate >= SLOWEST_RATE):
            raise FlightError(
                f"maneuvers cannot be found at {rate:g} samples per second; "
                f"it takes {SLOWEST_RATE:g} at least, and 50 or more to be of use"
            )
        self._aircraft = aircraft
        self._rate = rate
        self._count = max(round(FRAME * rate), 1)
        self._lag = max(round(LOOK_BACK * rate), 1)
        self._windowed = round(WINDOW / FRAME)
        self.reset()

    def reset(self) -> None:
        """Forget everything; the flight begins anew."""
        self._watch = AirborneWatch(self._aircraft)
        self._meter = NoiseMeter()
        self._setting = Setting(aircraft=self._aircraft, noise=NoiseFloor())
        self._found: list[FoundManeuver] = []
        self._steering = [deque[float](maxlen=_STEERING_FRAMES) for _ in SURFACES]
        self._half_travel = [self._setting.half_travel(name) for name in SURFACES]
        self._thresholds = [_LEAST_MOVE * travel for travel in self._half_travel]
        self._last_time = -math.inf
        self._restart()

    def _restart(self) -> None:
        """Begin a stretch of samples without a gap."""
        self._waiting_times: list[FloatArray] = []
        self._waiting_rows: list[FloatArray] = []
        self._waiting = 0
        self._tail = np.full((self._lag + 2, len(SURFACES)), np.nan)
        self._frames: deque[tuple[FloatArray, FloatArray]] = deque(maxlen=math.ceil(_KEPT / FRAME))
        self._window: list[FloatArray] = []
        self._candidate: _Candidate | None = None
        self._held: list[FloatArray] = []

    # What it knows --------------------------------------------------------------------

    @property
    def maneuvers(self) -> tuple[FoundManeuver, ...]:
        """Return the maneuvers so far. The latest may yet turn out to be part of a landing."""
        return tuple(self._found)

    @property
    def noise(self) -> NoiseFloor:
        """Return the noise floor of each channel as far as it is known."""
        return self._meter.floor

    @property
    def airborne(self) -> bool:
        """Return whether the aircraft flies."""
        return self._watch.airborne

    @property
    def judged_by(self) -> str:
        """Return what tells whether it flies, in words."""
        return self._watch.judged_by

    @property
    def under_way(self) -> bool:
        """Return whether an input is being made, or its answer awaited."""
        return self._candidate is not None

    # Samples --------------------------------------------------------------------------

    def feed(self, block: Block) -> None:
        """Take in the next samples; a gap in their times ends what was under way."""
        if not len(block):
            return
        rows, times = signals_of(block), block.times
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

    def settle(self) -> None:
        """Nothing is left to do after the blocks of a step: all is drawn from whole frames."""

    def finish(self) -> tuple[FoundManeuver, ...]:
        """Draw conclusions from what came last; the flight is over.

        Returns
        -------
        tuple of FoundManeuver
            All maneuvers, in order of time.
        """
        self._end_stretch()
        landing = self._watch.landing
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
        moves = self._moves(rows)
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

    def _moves(self, rows: FloatArray) -> FloatArray:
        """Return how far each surface went within `LOOK_BACK`, rad, shape (n, 3).

        Single wild samples are voted out by their two predecessors. 0 where samples are missing.
        """
        surfaces = np.concatenate((self._tail, rows[:, : len(SURFACES)]))
        self._tail = surfaces[-(self._lag + 2) :]
        one, two, three = surfaces[:-2], surfaces[1:-1], surfaces[2:]
        voted = np.maximum(np.minimum(one, two), np.minimum(np.maximum(one, two), three))
        moves = np.abs(voted[self._lag :] - voted[: -self._lag])
        return np.where(np.isnan(moves), 0.0, moves)

    # Frames ---------------------------------------------------------------------------

    def _frame(
        self,
        times: FloatArray,
        rows: FloatArray,
        means: FloatArray,
        peaks: FloatArray,
        moves: FloatArray,
    ) -> None:
        was_airborne = self._watch.airborne
        self._watch.add(float(times[0]), means)
        if was_airborne and not self._watch.airborne:
            self._landed(self._watch.since)
        self._frames.append((times, rows))
        self._measure_noise(rows)
        self._look(times, peaks, moves)
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
            standing=self._watch.standing,
        )
        self._window = []
        noise = self._meter.floor
        self._setting = replace(self._setting, noise=noise)
        for place, name in enumerate(SURFACES):
            seen = sorted(self._steering[place])
            steering = 0.0
            if len(seen) >= _FEWEST_STEERING_FRAMES:
                steering = seen[int(_STEERING_SHARE * len(seen))]
            self._thresholds[place] = max(
                _LEAST_MOVE * self._half_travel[place],
                _OVER_NOISE * noise.of(name),
                _OVER_STEERING * steering,
            )

    def _learn(self, frames: list[FloatArray]) -> None:
        if self._watch.airborne:
            for peaks in frames:
                for place, seen in enumerate(self._steering):
                    seen.append(float(peaks[place]))

    def _look(self, times: FloatArray, peaks: FloatArray, moves: FloatArray) -> None:
        """Note the quick moves of a frame."""
        quick = [place for place in range(len(SURFACES)) if peaks[place] > self._thresholds[place]]
        if not quick:
            return
        if self._candidate is not None and self._separate(
            self._candidate, float(times[0]), {SURFACES[place] for place in quick}
        ):
            self._conclude()
        over = (moves > self._thresholds).any(axis=1)
        where = np.flatnonzero(over)
        first, last = float(times[where[0]]), float(times[where[-1]])
        if self._candidate is None:
            self._candidate = _Candidate(first=first, last=last)
        candidate = self._candidate
        candidate.last = last
        for place in quick:
            candidate.moved.add(SURFACES[place])
            size = float(peaks[place]) / self._half_travel[place]
            if size > candidate.strongest:
                candidate.strongest, candidate.strongest_at = size, float(times[-1])

    @staticmethod
    def _separate(candidate: _Candidate, now: float, surfaces: set[str]) -> bool:
        """Return whether new quick moves do not belong to the input under way."""
        idle = now - candidate.last
        return candidate.closed or (idle >= _CLOSED and surfaces.isdisjoint(candidate.moved))

    def _follow(self, now: float) -> None:
        """See whether the input under way is over, and whether its answer is."""
        candidate = self._candidate
        if candidate is None:
            return
        if candidate.last - candidate.first > _LONGEST:
            # Steering that goes on may have an input in it, and is waited for to its end.
            long_ago = now - candidate.strongest_at > _CLOSED_AWAY
            if long_ago or candidate.last - candidate.first > 2.0 * _LONGEST:
                self._conclude()
            return
        idle = now - candidate.last
        if not candidate.closed:
            away = idle < _CLOSED_AWAY and not self._back(candidate)
            candidate.closed = idle >= _CLOSED and not away
        if candidate.closed and (
            idle >= _FREE_ANSWER or self._taken_over(candidate.last, now) < now
        ):
            self._conclude()

    def _stretch(self, start: float) -> tuple[FloatArray, FloatArray]:
        """Return times and rows from a time on."""
        kept = [frame for frame in self._frames if frame[0][-1] >= start]
        times = np.concatenate([frame[0] for frame in kept])
        rows = np.concatenate([frame[1] for frame in kept])
        low = int(np.searchsorted(times, start))
        return times[low:], rows[low:]

    def _back(self, candidate: _Candidate) -> bool:
        """Return whether every moved surface is near where it was before."""
        begin = candidate.first - LOOK_BACK
        times, rows = self._stretch(begin - 0.5)
        before = times < begin
        for surface in candidate.moved:
            samples = rows[:, COLUMN[surface]]
            early, late = samples[before], samples[-self._count :]
            if not (np.isfinite(early).any() and np.isfinite(late).any()):
                continue
            level = float(np.nanmedian(early))
            largest = float(np.nanmax(np.abs(samples - level)))
            if abs(float(np.nanmedian(late)) - level) > 0.4 * largest:
                return False
        return True

    def _taken_over(self, last: float, now: float) -> float:
        """Return when the pilot took over after the last quick move, s; `now` if not yet."""
        rest = last + 0.3
        times, rows = self._stretch(last - 0.1)
        calm = (times >= rest) & (times < rest + 0.4)
        earliest = now
        for place, surface in enumerate(SURFACES):
            samples = rows[:, COLUMN[surface]]
            level = samples[calm]
            if not np.isfinite(level).any():
                continue
            margin = max(
                0.3 * _LEAST_MOVE * self._half_travel[place],
                5.0 * self._setting.noise.of(surface),
            )
            off = np.abs(smoothed(samples, 1.0 / self._rate) - float(np.nanmedian(level))) > margin
            gone = np.flatnonzero(off & (times > rest + 0.2))
            if gone.size:
                earliest = min(earliest, float(times[gone[0]]))
        return earliest

    # Conclusions ----------------------------------------------------------------------

    def _landed(self, time: float) -> None:
        while self._found and self._found[-1].t_input_end > time - _BEFORE_LANDING:
            self._found.pop()
        self._dismiss()

    def _dismiss(self) -> None:
        """Take what was under way for steering."""
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
        return self._watch.airborne and candidate.first - self._watch.since > _SETTLED

    def _strong_moves(
        self, times: FloatArray, rows: FloatArray, candidate: _Candidate
    ) -> dict[str, tuple[float, float]]:
        """Return first and last quick move of each surface, without steering around them, s."""
        # The first and the last step are half as large as those between, and may be less than
        # quick by themselves.
        inside = (times >= candidate.first - _AROUND) & (times <= candidate.last + 0.5)
        found = {}
        for place, surface in enumerate(SURFACES):
            if surface not in candidate.moved:
                continue
            samples = rows[:, place]
            moves = np.zeros(times.size)
            moves[self._lag :] = np.abs(samples[self._lag :] - samples[: -self._lag])
            moves = np.where(inside & np.isfinite(moves), moves, 0.0)
            strongest = int(np.argmax(moves))
            least = _STRONG * float(moves[strongest])
            strong = np.flatnonzero(moves > least)
            if strong.size:
                at = int(np.searchsorted(strong, strongest))
                found[surface] = _cluster(times[strong], min(at, strong.size - 1))
        return found

    def _judge(self, candidate: _Candidate) -> FoundManeuver | None:
        times, rows = self._stretch(candidate.first - LOOK_BACK - 2.5 * TRIM_TIME)
        moves = self._strong_moves(times, rows, candidate)
        inputs = moved_inputs(times, rows, moves, self._setting)
        if not inputs:
            return None
        last = max(moves[one.surface][1] for one in inputs)
        taken_over = self._taken_over(last, float(times[-1]))
        begin = min(one.t_start for one in inputs)
        end = max(one.t_end for one in inputs)
        passage = Passage(
            times=times,
            rows=rows,
            t_input=begin,
            t_input_end=end,
            t_end=min(max(taken_over, end), end + _FREE_ANSWER),
        )
        threshold = self._thresholds[SURFACES.index(inputs[0].surface)]
        if not _deliberate(inputs[0], passage.t_end - end, threshold):
            return None
        answered = answer(passage, self._setting, [one.surface for one in inputs])
        if answered and max(answered.values()) < _ANSWERED:
            return None
        return described(str(len(self._found) + 1), passage, self._setting, inputs)


def _cluster(times: FloatArray, strongest: int) -> tuple[float, float]:
    """Return first and last of the times that hang together with the strongest one, s."""
    parted = np.flatnonzero(np.diff(times) > _CLOSED_AWAY)
    low = int(np.searchsorted(parted, strongest))
    first = int(parted[low - 1]) + 1 if low > 0 else 0
    last = int(parted[low]) if low < parted.size else times.size - 1
    return float(times[first]), float(times[last])


def _deliberate(main: SurfaceInput, free: float, threshold: float) -> bool:
    """Return whether an input looks like one made on purpose.

    The less its shape tells, the calmer it must be before and after. Large steps to both sides
    leave no doubt even if the pilot takes over at once. One to a single side is no maneuver then:
    steering in a fright looks the same.
    """
    # What steering does may have been learned since the move was taken for quick.
    if main.quickest < threshold:
        return False
    if main.unmistakable and main.quickest > _SURELY * threshold:
        return True
    clear = main.kind in ("doublet", "3-2-1-1")
    if main.kind == "retrim" or main.abruptness < (_ABRUPT if clear else _ABRUPT_IF_ODD):
        return False
    if main.unrest > (0.6 if clear else 0.35) * main.amplitude:
        return False
    return main.returned and free > (_FREE_IF_CLEAR if clear else _FREE_IF_ODD)


def moved_inputs(
    times: FloatArray,
    rows: FloatArray,
    moves: dict[str, tuple[float, float]],
    setting: Setting,
) -> list[SurfaceInput]:
    """Measure the inputs of a maneuver, the one of the quickest step first, as share of travel.

    Parameters
    ----------
    times, rows : ndarray, shape (n,) and (n, len(SIGNALS))
    moves : dict
        First and last quick move (s) of each surface that made any.
    setting : Setting
    """
    found = []
    for surface, (first, last) in moves.items():
        noise = setting.noise.of(surface)
        one = measure(surface, times, rows[:, COLUMN[surface]], first, last, noise)
        if one is not None:
            found.append(one)
    # Steering may go further than an input, but not as quickly.
    sizes = {one.surface: one.quickest / setting.half_travel(one.surface) for one in found}
    found.sort(key=lambda one: -sizes[one.surface])
    return [one for one in found if one is found[0] or _goes_with(one, found[0], sizes)]


def _goes_with(one: SurfaceInput, main: SurfaceInput, sizes: dict[str, float]) -> bool:
    """Return whether an input is part of the maneuver that the main one makes."""
    return (
        sizes[one.surface] >= ALSO_MOVED * sizes[main.surface]
        and one.abruptness > _ABRUPT
        and one.t_start < main.t_end + _CLOSED
        and one.t_end > main.t_start - _CLOSED
    )


def described(
    name: str, passage: Passage, setting: Setting, inputs: list[SurfaceInput]
) -> FoundManeuver:
    """Return the maneuver of a passage, graded."""
    grade, reasons = grade_maneuver(passage, setting, inputs)
    start = max(passage.t_input - TRIM_TIME, float(passage.times[0]))
    V, alpha = passage.mean_before("V"), passage.mean_before("alpha")
    return FoundManeuver(
        id=name,
        t_start=start,
        t_end=passage.t_end,
        inputs=tuple(name for name in SURFACES if name in {one.surface for one in inputs}),
        kind=inputs[0].kind if inputs else "none",
        amplitude=inputs[0].amplitude if inputs else None,
        grade=grade,
        reasons=reasons,
        V=V if math.isfinite(V) else None,
        alpha=alpha if math.isfinite(alpha) else None,
        t_input=passage.t_input,
        t_input_end=passage.t_input_end,
        amplitudes={one.surface: one.amplitude for one in inputs},
    )


def find_maneuvers(flight: Flight, aircraft: Aircraft) -> tuple[FoundManeuver, ...]:
    """Find the maneuvers of a whole flight.

    Parameters
    ----------
    flight : Flight
    aircraft : Aircraft
        As that flight flew it.

    Raises
    ------
    FlightError
        If the flight has no samples, too few a second, or no surface was measured.
    """
    return detect(flight, aircraft).finish()


def detect(flight: Flight, aircraft: Aircraft) -> ManeuverDetector:
    """Return a detector that has seen a whole flight; `find_maneuvers` tells the rest."""
    check_flight(flight)
    detector = ManeuverDetector(aircraft, flight.rate)
    detector.feed(flight.block)
    return detector


def check_flight(flight: Flight) -> None:
    """Refuse a flight in which no maneuver can be told.

    Raises
    ------
    FlightError
        With what is missing.
    """
    if len(flight.block) < 2:
        raise FlightError(f"the flight '{flight.name}' holds no samples to find maneuvers in")
    rows = signals_of(flight.block)
    if not np.isfinite(rows[:, : len(SURFACES)]).any():
        had = ", ".join(flight.block.channels) or "no channel"
        raise FlightError(
            f"the flight '{flight.name}' has no sample of a surface (de, da or dr), so that no "
            f"input can be seen; it has {had}"
        )

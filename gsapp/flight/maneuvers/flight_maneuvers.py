"""The maneuvers of a flight: found and corrected by hand, or named, or the whole of a record."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.decoding.derived_channels import source_instruments
from gsapp.flight.events import EventLog, convert_to_flown_clock, events_path, read_events
from gsapp.flight.flight import Flight
from gsapp.flight.maneuvers.airborne_detection import flying_speed
from gsapp.flight.maneuvers.detected_maneuver import GRADES, DetectedManeuver, Grade
from gsapp.flight.maneuvers.detection import (
    ManeuverDetector,
    build_maneuver,
    check_detectable,
    run_detector,
)
from gsapp.flight.maneuvers.input_measures import (
    RESPONSE_CHANNELS,
    GradingContext,
    ManeuverSamples,
    time_scale_of,
)
from gsapp.flight.maneuvers.input_shape import SurfaceInput, measure_plain_input
from gsapp.flight.maneuvers.maneuver_list import ManeuverEditLog, apply_edits
from gsapp.flight.maneuvers.noise_floor import NoiseFloor
from gsapp.flight.maneuvers.rapid_moves import find_strong_moves, measure_moved_inputs
from gsapp.flight.maneuvers.settings import DETECTION
from gsapp.flight.maneuvers.signals import SIGNAL_COLUMNS, SURFACE_PARTS, SURFACES, extract_signals
from gsapp.foundation import FlightError
from gsapp.quantities import Block, FloatArray
from gsapp.quantities.constants import DEGREE

_GRADE: Final[Mapping[str, Grade]] = {grade: grade for grade in GRADES}


@dataclass(frozen=True, slots=True, kw_only=True)
class ManeuverWindow:
    """A stretch of one flight, s of flight time; the first flight is number 1."""

    flight: int
    start: float
    stop: float


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightManeuvers:
    """The maneuvers of a flight and what they were judged by."""

    maneuvers: tuple[DetectedManeuver, ...]
    noise: NoiseFloor
    airborne_criterion: str
    """What told whether it flew, in words."""
    remarks: tuple[str, ...] = ()
    """Sentences for the crew: stuck surfaces, a record taken whole, changes by hand."""
    on_ground: tuple[str, ...] = ()
    """Ids of windows that were named while the aircraft stood or rolled slowly."""


def parse_maneuver_windows(texts: Sequence[str], flights: int = 1) -> tuple[ManeuverWindow, ...]:
    """Read ``START:STOP`` or ``K:START:STOP``.

    With more than one flight, each text must say which it means.
    """
    return tuple(_window(text, flights) for text in texts)


def _window(text: str, flights: int) -> ManeuverWindow:
    parts = text.strip().split(":")
    usage = "write START:STOP in seconds, as 139.5:146, or K:START:STOP for the K-th flight"
    try:
        numbers = [float(part) for part in parts]
    except ValueError:
        numbers = []
    if len(numbers) not in (2, 3) or not all(math.isfinite(number) for number in numbers):
        raise FlightError(f"the maneuver '{text}' cannot be read; {usage}")
    start, stop = numbers[-2:]
    if not start < stop:
        what = "is empty" if start == stop else "ends before it begins"
        raise FlightError(f"the maneuver '{text}' {what}; {usage}")
    if len(numbers) == 2:
        if flights > 1:
            raise FlightError(
                f"the maneuver '{text}' does not name one of the {flights} flights; write "
                f"1:{text} for the first one"
            )
        return ManeuverWindow(flight=1, start=start, stop=stop)
    if numbers[0] != int(numbers[0]) or not 1 <= numbers[0] <= flights:
        counted = "there is 1 flight" if flights == 1 else f"there are {flights} flights"
        raise FlightError(f"the maneuver '{text}' names flight {parts[0]}, but {counted}")
    return ManeuverWindow(flight=int(numbers[0]), start=start, stop=stop)


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordedVerdict:
    """A verdict as the crew was told it, or as a debrief gives it."""

    t_input: float
    """When the input began, s."""
    result: str
    """``good``, ``too-large`` ..."""
    advice: str
    """In words."""
    grade: Grade | None = None
    """None in records from before there was one."""


def read_recorded_verdicts(flight: Flight) -> tuple[RecordedVerdict, ...]:
    """Return the verdicts among the events of a flight; none of a flight that nobody watched."""
    return tuple(
        RecordedVerdict(
            t_input=float(event.data["t_input"]),
            result=str(event.data.get("result", "good")),
            advice=event.text,
            grade=_GRADE.get(str(event.data.get("grade"))),
        )
        for event in convert_to_flown_clock(read_events(events_path(flight.path)).events)
        if event.kind == "verdict" and isinstance(event.data.get("t_input"), (int, float))
    )


def apply_verdicts(
    found: DetectedManeuver, verdicts: Sequence[RecordedVerdict]
) -> DetectedManeuver:
    """Return a maneuver graded as the verdict on its input allows; see `after_verdict`."""
    for one in verdicts:
        if found.t_start <= one.t_input < found.t_end:
            found = found.with_verdict(one.result, one.advice, one.grade)
    return found


class ManeuverAssessor:
    """Looks at any stretch of one flight as at a maneuver: which inputs moved, how good it is."""

    def __init__(self, flight: Flight, aircraft: Aircraft, noise: NoiseFloor) -> None:
        self._flight = flight
        self._scale = time_scale_of(aircraft)
        self._setting = GradingContext(aircraft=aircraft, noise=noise, time_scale=self._scale)
        self._verdicts = read_recorded_verdicts(flight)

    @cached_property
    def _times(self) -> FloatArray:
        return self._flight.block.times / self._scale

    @cached_property
    def _rows(self) -> FloatArray:
        """Return the signals of the flight; most flights are never assessed again."""
        return extract_signals(self._flight.block)

    def apply_verdicts(self, found: DetectedManeuver) -> DetectedManeuver:
        return apply_verdicts(found, self._verdicts)

    def assess(self, name: str, start: float, stop: float) -> DetectedManeuver:
        """Return the stretch from start to stop (s) as a maneuver, graded."""
        known = self._flight.block.times
        low, high = np.searchsorted(known, (start - 1e-9, stop + 1e-9))
        if high - low < 2:
            raise FlightError(
                f"the flight '{self._flight.name}' has no samples from {start:g} to {stop:g} s; "
                f"it runs from {known[0]:.2f} to {known[-1]:.2f} s"
            )
        times, rows = self._times[low:high], self._rows[low:high]
        inputs = self._inputs(low, high)
        begin, end = float(times[0]), float(times[-1])
        passage = ManeuverSamples(
            times=times,
            rows=rows,
            t_input=min((one.t_start for one in inputs), default=begin),
            t_input_end=max((one.t_end for one in inputs), default=end),
            t_end=end,
        )
        found = build_maneuver(name, passage, self._setting, inputs)
        edges = float(known[low]), float(known[high - 1])
        return self.apply_verdicts(replace(found, t_start=edges[0], t_end=edges[1]))

    def _inputs(self, low: int, high: int) -> list[SurfaceInput]:
        times, rows = self._times[low:high], self._rows[low:high]
        plain = []
        for surface in SURFACES:
            samples = rows[:, SIGNAL_COLUMNS[surface]]
            one = measure_plain_input(surface, times, samples)
            least = max(
                DETECTION.moved_over_noise * self._setting.noise.std_of(surface),
                DETECTION.moved_share * self._setting.half_travel(surface),
            )
            if one is not None and one.amplitude > least:
                plain.append(one)
        # The record may go on into steering, which goes far as well, but not quickly.
        moves = {
            one.surface: one.max_step / self._setting.half_travel(one.surface) for one in plain
        }
        plain.sort(key=lambda one: -moves[one.surface])
        plain = [
            one
            for one in plain
            if moves[one.surface] >= DETECTION.secondary_input_ratio * moves[plain[0].surface]
            or self._moved_in_turn(one, plain[0], times, rows)
        ]
        return [self._better(one, low, high) for one in plain]

    def _moved_in_turn(
        self, one: SurfaceInput, main: SurfaceInput, times: FloatArray, rows: FloatArray
    ) -> bool:
        """Return whether a surface made its steps before or after the main one made its own."""
        size = one.amplitude / self._setting.half_travel(one.surface)
        largest = main.amplitude / self._setting.half_travel(main.surface)
        if size < DETECTION.secondary_input_ratio * largest or not one.has_returned_to_trim:
            return False
        lag = max(round(DETECTION.look_back / float(np.median(np.diff(times)))), 1)
        whole = (float(times[0]), float(times[-1]))
        moves = find_strong_moves(times, rows, (one.surface, main.surface), *whole, lag)
        if len(moves) < 2:
            return False
        (first, last), (begin, end) = moves[one.surface], moves[main.surface]
        return one.abruptness > DETECTION.abrupt_share and (
            first > end + DETECTION.input_end_pause or last < begin - DETECTION.input_end_pause
        )

    def _better(self, one: SurfaceInput, low: int, high: int) -> SurfaceInput:
        moves = {one.surface: (one.t_start + DETECTION.look_back, one.t_end)}
        measured = measure_moved_inputs(
            self._times[low:high], self._rows[low:high], moves, self._setting
        )
        return measured[0] if measured and measured[0].kind != "retrim" else one


def collect_maneuvers(
    flight: Flight,
    aircraft: Aircraft,
    *,
    given: Sequence[str] = (),
    number: int = 1,
    flights: int = 1,
    as_found: bool = False,
) -> FlightManeuvers:
    """Return the maneuvers of a flight with all that is worth saying.

    Changes made by hand, which stand among the events of the flight, count.

    Parameters
    ----------
    aircraft : Aircraft
        As that flight flew it.
    given : sequence of str
        ``START:STOP`` or ``K:START:STOP``, s. Those for this flight take the place of what would
        be found; which inputs moved is seen from the samples.
    number, flights : int
        Which flight of how many this is, for ``K``. A flight that no text names is searched.
    as_found : bool
        Whether to leave out what was changed by hand.

    Raises
    ------
    FlightError
        If no surface was measured, or a text cannot be read or lies outside the flight.
    """
    windows = [one for one in parse_maneuver_windows(given, flights) if one.flight == number]
    try:
        check_detectable(flight)
    except FlightError as error:
        raise FlightError("; ".join((str(error), *uncalibrated_text(flight)))) from None
    detector = run_detector(flight, aircraft)
    found = detector.finish()
    remarks = list(surface_remarks(flight))
    assessor = ManeuverAssessor(flight, aircraft, detector.noise)
    found = tuple(assessor.apply_verdicts(one) for one in found)
    on_ground: tuple[str, ...] = ()
    segments = record_segments(flight)
    if windows:
        parts = [part for window in windows for part in _split_window(window, segments)]
        found = tuple(
            assessor.assess(str(place), *part) for place, part in enumerate(parts, start=1)
        )
        if len(parts) > len(windows):
            remarks.append(
                f"the record has gaps: the time windows give {len(parts)} maneuvers, parted there"
            )
        # Without airspeed a steady flight may look like standing.
        if detector.airborne_criterion == "airspeed":
            slow = [one for one in found if not detector.was_airborne(one.t_start, one.t_end)]
            on_ground = tuple(one.id for one in slow if _stands(one, flight, aircraft))
            remarks += [ground_window_text(one, stands=one.id in on_ground) for one in slow]
    elif _is_cut_around_inputs(segments, found, detector):
        found = tuple(
            _take_whole(assessor, str(place), segment, found)
            for place, segment in enumerate(segments, start=1)
        )
        remarks += [
            f"the record of {stop - start:.1f} s is used as one maneuver"
            for start, stop in segments
        ]
    if not windows and not as_found:
        log = ManeuverEditLog(EventLog(events_path(flight.path)), found)
        found, said = apply_edits(log, assessor.assess)
        remarks += said
    return FlightManeuvers(
        maneuvers=found,
        noise=detector.noise,
        airborne_criterion=detector.airborne_criterion,
        remarks=tuple(remarks),
        on_ground=on_ground,
    )


def record_segments(flight: Flight) -> tuple[tuple[float, float], ...]:
    """Return begin and end (s) of the parts of a record between gaps without any sample."""
    times = flight.block.times
    times = times[np.isfinite(flight.block.values).any(axis=1)]
    if not times.size:
        return ()
    cuts = np.flatnonzero(np.diff(times) > DETECTION.max_gap)
    starts, stops = [0, *(cuts + 1)], [*cuts, times.size - 1]
    return tuple(
        (float(times[start]), float(times[stop])) for start, stop in zip(starts, stops, strict=True)
    )


def _split_window(
    window: ManeuverWindow, segments: Sequence[tuple[float, float]]
) -> list[tuple[float, float]]:
    """Return the parts of a window that hold samples; the window where it lies in one segment."""
    parts = [(max(window.start, low), min(window.stop, high)) for low, high in segments]
    parts = [(start, stop) for start, stop in parts if stop > start]
    return parts if len(parts) > 1 else [(window.start, window.stop)]


def _is_cut_around_inputs(
    segments: Sequence[tuple[float, float]],
    found: Sequence[DetectedManeuver],
    detector: ManeuverDetector,
) -> bool:
    """Return whether somebody cut a record, or joined several, each around one input."""
    if len(segments) == 1 and len(found) <= 1:
        start, stop = segments[0]
        if stop - start < DETECTION.short_flight_duration:
            return True
    return bool(segments) and all(
        stop - start <= DETECTION.max_cut_duration
        and all(detector.was_airborne(end, end) for end in (start, stop))
        and sum(start <= one.t_start <= stop for one in found) == 1
        for start, stop in segments
    )


def _take_whole(
    assessor: ManeuverAssessor,
    name: str,
    segment: tuple[float, float],
    found: Sequence[DetectedManeuver],
) -> DetectedManeuver:
    """Return a segment as one maneuver.

    Where the detection saw the same inputs, and a trim before, it knows their shape better.
    """
    whole = assessor.assess(name, *segment)
    for one in found:
        trimmed = segment[0] + DETECTION.trim_time <= one.t_input <= segment[1]
        if trimmed and set(whole.inputs) <= set(one.inputs):
            return replace(one, id=name, t_start=whole.t_start, t_end=whole.t_end)
    return whole


def _stands(maneuver: DetectedManeuver, flight: Flight, aircraft: Aircraft) -> bool:
    """Return whether an aircraft is slower than any wind lets it fly."""
    block = flight.block
    low, high = np.searchsorted(block.times, (maneuver.t_start, maneuver.t_end))
    part = Block(
        channels=block.channels, times=block.times[low:high], values=block.values[low:high]
    )
    speed = extract_signals(part)[:, SIGNAL_COLUMNS["V"]]
    least = DETECTION.standing_speed_ratio * flying_speed(aircraft)
    return bool(np.isfinite(speed).any() and np.nanmedian(speed) < least)


def ground_window_text(maneuver: DetectedManeuver, *, stands: bool) -> str:
    """Return what a window is worth in which the airspeed is that of an aircraft on the ground."""
    times = f"from {maneuver.t_start:.2f} to {maneuver.t_end:.2f} s"
    if stands:
        return (
            f"maneuver {maneuver.id} is excluded: not flown; {times} the aircraft was on the "
            "ground, by its airspeed"
        )
    return (
        f"maneuver {maneuver.id} is used as named, but {times} its airspeed is below that of "
        "flight: check the airspeed, and mass, wing and stall speed of the aircraft file"
    )


def surface_remarks(flight: Flight) -> tuple[str, ...]:
    """Return sentences about surfaces that were not measured or never moved."""
    rows = extract_signals(flight.block)
    behind, bare = _instruments_by_channel(flight), set(flight.uncalibrated_channels)
    found = []
    for surface in SURFACES:
        samples = rows[:, SIGNAL_COLUMNS[surface]]
        samples = samples[np.isfinite(samples)]
        if not samples.size and bare & set(behind.get(surface, ())):
            found.append(f"{surface} is uncalibrated: its inputs cannot be detected")
        elif not samples.size:
            found.append(f"{surface} was not measured: its inputs cannot be detected")
        elif samples.size > 100 and not float(np.ptp(samples)) > 0.0:
            still = f"is constant at {samples[0] / DEGREE:.2f} deg in every sample"
            measured = {surface, *SURFACE_PARTS[surface]} & set(flight.block.channels)
            found.append(
                f"{surface} {still}: its sensor appears stuck or unplugged"
                if measured
                else f"{surface} was not measured, and {surface}_command {still}: check the "
                "servo in the channel map"
            )
    return tuple(found)


def explain_no_maneuvers(flight: Flight, found: Sequence[DetectedManeuver] = ()) -> str:
    """Return why a flight gives no maneuver to use, although some may have been found."""
    causes = [*uncalibrated_text(flight)]
    if causes:
        return "; ".join(causes)
    causes += surface_remarks(flight)
    for one in found:
        why = "excluded manually" if one.use is False else "; ".join(one.reasons)
        causes.append(f"maneuver {one.id} is not used: {why or 'unfit'}")
    if not found:
        other = "other " if causes else ""
        causes.append(f"no {other}fast input returned to trim with a response in the air")
    return "; ".join(causes)


def _instruments_by_channel(flight: Flight) -> dict[str, tuple[str, ...]]:
    measured = [name for name, each in flight.sources.items() if each.kind != "derived"]
    return source_instruments([*measured, *flight.uncalibrated_channels])


def uncalibrated_text(flight: Flight) -> tuple[str, ...]:
    """Return which inputs and answers of a flight are volts only, for want of a certificate."""
    bare = set(flight.uncalibrated_channels)
    if not bare:
        return ()
    behind = _instruments_by_channel(flight)
    answers = dict.fromkeys(name for names in RESPONSE_CHANNELS.values() for name in names)
    parts = []
    for what, names in (("inputs", SURFACES), ("answers", answers)):
        lacking = [one for name in names for one in behind.get(name, ()) if one in bare]
        if lacking:
            parts.append(f"{what} {', '.join(dict.fromkeys(lacking))}")
    if not parts:
        return ()
    return (
        f"uncalibrated, volts only: {'; '.join(parts)}: add their certificates (--calibration)",
    )

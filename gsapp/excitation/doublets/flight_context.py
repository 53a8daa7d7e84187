"""What must be known before an input can be told: the newest rows, flight, noise, steering."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace
from typing import Final

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.excitation.flight_rows import FlightRows
from gsapp.excitation.settings import DOUBLETS
from gsapp.flight.maneuvers.airborne_detection import AirborneDetector
from gsapp.flight.maneuvers.input_measures import GradingContext
from gsapp.flight.maneuvers.noise_floor import NoiseFloor, NoiseFloorEstimator
from gsapp.flight.maneuvers.rapid_moves import RapidMoveDetector
from gsapp.flight.maneuvers.settings import DETECTION
from gsapp.flight.maneuvers.signals import SIGNAL_COLUMNS, SIGNALS, SURFACES
from gsapp.quantities import FloatArray

EXTRA_CHANNELS: Final = ("phi", "rate_switch", "density", "static_pressure", "temperature")
"""Channels kept beside the signals of the detection."""

_EXTRA_INDEX: Final = {name: len(SIGNALS) + k for k, name in enumerate(EXTRA_CHANNELS)}


class SignalHistory:
    """Keeps signals and a few more channels of the newest rows."""

    def __init__(self, rate: float) -> None:
        self._kept = round(DOUBLETS.history_retention * rate)
        self._width = len(SIGNALS) + len(EXTRA_CHANNELS)
        self.clear()

    def clear(self) -> None:
        self._times = np.empty(4 * self._kept)
        self._values = np.empty((4 * self._kept, self._width))
        self._count = 0

    def add(self, rows: FlightRows, signals: FloatArray) -> None:
        """Take in the next rows, and their signals as far as they are believed."""
        count = len(rows)
        if self._count + count > self._times.size:
            kept = min(self._count, self._kept)
            start = self._count - kept
            size = max(4 * self._kept, kept + 2 * count)
            times, values = np.empty(size), np.empty((size, self._width))
            times[:kept] = self._times[start : self._count]
            values[:kept] = self._values[start : self._count]
            self._times, self._values, self._count = times, values, kept
        low, high = self._count, self._count + count
        self._times[low:high] = rows.times
        self._values[low:high, : len(SIGNALS)] = signals
        for name, place in _EXTRA_INDEX.items():
            self._values[low:high, place] = rows[name]
        self._count = high

    def segment(self, start: float, stop: float) -> tuple[FloatArray, FloatArray]:
        """Return times, shape (n,), and signals, shape (n, len(SIGNALS)), both ends included."""
        low, high = self._between(start, stop)
        return self._times[low:high], self._values[low:high, : len(SIGNALS)]

    def extra_channel(self, name: str, start: float, stop: float) -> FloatArray:
        """Return one of `EXTRA_CHANNELS` from one time to another, both inclusive, s."""
        low, high = self._between(start, stop)
        return self._values[low:high, _EXTRA_INDEX[name]]

    def _between(self, start: float, stop: float) -> tuple[int, int]:
        times = self._times[: self._count]
        low = np.searchsorted(times, start - 1e-9)
        return int(low), int(np.searchsorted(times, stop + 1e-9, side="right"))


class FlightContext:
    """Follows a flight in frames of about half a second (whole ticks), counted from time zero.

    `setting` has the noise floor of each channel, as far as it is known, `move_detector` the
    thresholds that tell an input from steering, and `unmeasured_surfaces` those of which the last
    frame held no sample.
    """

    def __init__(self, aircraft: Aircraft, rate: float, tick: int) -> None:
        self._aircraft = aircraft
        self._rate = rate
        self._ticks = max(round(DETECTION.frame_duration * rate / tick), 1)
        self._window = round(DETECTION.noise_window / DETECTION.frame_duration)
        self.restart()

    def restart(self) -> None:
        self._watch = AirborneDetector(self._aircraft)
        self._meter = NoiseFloorEstimator(self._aircraft, self._rate)
        self.setting = GradingContext(aircraft=self._aircraft, noise=NoiseFloor())
        self.move_detector = RapidMoveDetector(self.setting, self._rate)
        self._field: deque[float] = deque(maxlen=DOUBLETS.ground_altitude_frames)
        self._low = False
        self.unmeasured_surfaces: tuple[str, ...] = ()
        self._began = -math.inf
        self.start_segment(0.0)

    def start_segment(self, time: float) -> None:
        """Begin a stretch at a time (s) to which nothing leads up; what was learned stays."""
        self.move_detector.restart()
        self._began = time
        self._rows: list[FloatArray] = []
        self._peaks: list[FloatArray] = []
        self._frames: list[FloatArray] = []
        self._held: list[FloatArray] = []
        self._steering = True

    def is_flying(self, time: float) -> bool:
        """Return whether the aircraft flies at a time (s), neither taking off nor landing."""
        since = self._watch.since
        took_off = since > self._began + DOUBLETS.airborne_at_start
        settled = not took_off or time - since > DETECTION.takeoff_settling_time
        return self._watch.airborne and settled and not self._low

    def process_tick(
        self, number: int, time: float, rows: FloatArray, peaks: FloatArray, *, steering: bool
    ) -> None:
        """Take in a tick, by its number from time zero, and the time of its last row.

        `peaks` are the furthest moves of each surface, as `RapidMoveDetector.measure` gives them,
        shape (3,); `steering` is whether the rows surely hold no input.
        """
        self._rows.append(rows)
        self._peaks.append(peaks)
        self._steering = self._steering and steering
        if (number + 1) % self._ticks == 0:
            self._end_frame(time)

    def reject_input(self) -> None:
        self.move_detector.learn_pilot_activity(self._held)
        self._held = []

    def accept_input(self) -> None:
        """Forget the moves of an input: they say nothing about steering."""
        self._held = []

    def _look_down(self, altitude: float) -> None:
        """Learn the altitude of the field, m, and tell whether the aircraft is close to it."""
        if not math.isfinite(altitude):
            return
        if self._watch.airborne:
            # A record that begins in the air does not know its field.
            self._low = (
                bool(self._field)
                and altitude - float(np.median(self._field)) < DOUBLETS.landing_height
            )
        else:
            self._field.append(altitude)

    def _end_frame(self, time: float) -> None:
        rows = np.concatenate(self._rows)
        there = np.isfinite(rows)
        present = there.sum(axis=0)
        self.unmeasured_surfaces = tuple(
            name for name in SURFACES if not present[SIGNAL_COLUMNS[name]]
        )
        means = np.where(there, rows, 0.0).sum(axis=0) / np.where(present > 0, present, np.nan)
        self._watch.add(time - (len(rows) - 1) / self._rate, means)
        self._look_down(float(means[SIGNAL_COLUMNS["altitude"]]))
        if self._watch.airborne:
            furthest = np.array(self._peaks).max(axis=0)
            if self._steering:
                self.move_detector.learn_pilot_activity([furthest])
            else:
                self._held.append(furthest)
        self._rows, self._peaks, self._steering = [], [], True
        self._frames.append(rows)
        if len(self._frames) < self._window:
            return
        self._meter.add(
            np.concatenate(self._frames),
            airborne=self._watch.airborne,
            standing=self._watch.is_stationary,
        )
        self._frames = []
        self.setting = replace(self.setting, noise=self._meter.floor)
        self.move_detector.update_thresholds(self.setting)


def default_aircraft() -> Aircraft:
    """Return what is taken for an aircraft of which nothing is known."""
    return Aircraft.model_validate(
        {
            "name": "unknown",
            "geometry": {"wing_area": "1 m^2", "span": "2.7 m", "chord": "0.43 m"},
            "mass": {
                "mass": "20 kg",
                "ixx": "7 kg*m^2",
                "iyy": "8.5 kg*m^2",
                "izz": "9.5 kg*m^2",
            },
        }
    )

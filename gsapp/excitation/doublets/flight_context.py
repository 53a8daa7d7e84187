"""What must be known before an input can be told: does it fly, how noisy, how hands steer it."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.excitation.doublets.settings import DOUBLETS
from gsapp.flight.maneuvers.airborne_detection import AirborneDetector
from gsapp.flight.maneuvers.input_measures import GradingContext
from gsapp.flight.maneuvers.noise_floor import NoiseFloor, NoiseFloorEstimator
from gsapp.flight.maneuvers.rapid_moves import RapidMoveDetector
from gsapp.flight.maneuvers.settings import DETECTION
from gsapp.flight.maneuvers.signals import SIGNAL_COLUMNS, SURFACES
from gsapp.quantities import FloatArray


class FlightContext:
    """Follows a flight in frames of about half a second, counted from time zero.

    Parameters
    ----------
    aircraft : Aircraft
    rate : float
        Of the rows, Hz.
    tick : int
        Rows in a tick; frames are whole ticks.

    Attributes
    ----------
    setting : GradingContext
        The aircraft with the noise floor of each channel, as far as it is known.
    move_detector : RapidMoveDetector
        Thresholds that tell an input from steering.
    unmeasured_surfaces : tuple of str
        Surfaces of which the last frame held no sample.
    """

    def __init__(self, aircraft: Aircraft, rate: float, tick: int) -> None:
        self._aircraft = aircraft
        self._rate = rate
        self._ticks = max(round(DETECTION.frame_duration * rate / tick), 1)
        self._window = round(DETECTION.noise_window / DETECTION.frame_duration)
        self.restart()

    def restart(self) -> None:
        """Forget the flight."""
        self._watch = AirborneDetector(self._aircraft)
        self._meter = NoiseFloorEstimator()
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
        """Take in a tick.

        Parameters
        ----------
        number : int
            Of the tick, counted from time zero.
        time : float
            Of its last row, s.
        rows : ndarray, shape (n, len(SIGNALS))
        peaks : ndarray, shape (3,)
            The furthest that each surface went, as `RapidMoveDetector.measure` gives it.
        steering : bool
            Whether the rows surely hold no input.
        """
        self._rows.append(rows)
        self._peaks.append(peaks)
        self._steering = self._steering and steering
        if (number + 1) % self._ticks == 0:
            self._end_frame(time)

    def reject_input(self) -> None:
        """Learn from what was taken for an input and was steering."""
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

"""Recognizing that a flight has landed, from speed, height, motion and the autopilot's report."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from typing import Final

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.excitation.flight_rows import FlightRows, FlightRowStream
from gsapp.flight.maneuvers.airborne_detection import AirborneDetector, flying_speed
from gsapp.flight.maneuvers.settings import DETECTION
from gsapp.flight.maneuvers.signals import SIGNAL_COLUMNS, SIGNALS
from gsapp.quantities import Block, FloatArray, join_blocks
from gsapp.session.monitor_settings import MONITORS

_READ: Final = (*SIGNALS, "ground_speed")


class LandingMonitor:
    """Follows one flight, and tells since when the aircraft stands on the ground after it.

    Slow, still and level for three seconds, after five seconds of flight. A low pass and a touch
    and go are too fast, a stall is too short, and a blocked pitot is contradicted by height or
    ground speed. Where the autopilot reports ground, or disarms after the flight, a second of being
    slow is enough. A take-off begins another flight.

    Parameters
    ----------
    aircraft : Aircraft or None
        Tells how fast it must be to fly.
    on_ground : callable
        Whether the autopilot reports ground at a flight time (s); None where it reports nothing.

    Attributes
    ----------
    landed_at : float or None
        Flight time since which it stands, s; None before, and while it flies again.
    """

    def __init__(
        self,
        aircraft: Aircraft | None,
        rate: float,
        on_ground: Callable[[float], bool | None] = lambda _: None,
    ) -> None:
        self._aircraft = aircraft
        self._on_ground = on_ground
        self._speed = MONITORS.default_flying_speed if aircraft is None else flying_speed(aircraft)
        self._count = max(round(DETECTION.frame_duration * rate), 1)
        self._stream = FlightRowStream(rate)
        self.reset()

    def reset(self) -> None:
        self._airborne_detector = (
            None if self._aircraft is None else AirborneDetector(self._aircraft)
        )
        self._stream.restart()
        self._blocks: list[Block] = []
        self._newest = self._processed_to = -math.inf
        self._rows: list[FlightRows] = []
        self._left = np.empty((0, len(_READ) + 1))  # of a frame that is not complete
        self._flown = 0
        self._ground = math.nan
        self._altitudes: deque[float] = deque(maxlen=MONITORS.standing_frames)
        self._standing = 0
        self._since = 0.0
        self.landed_at: float | None = None

    def feed(self, block: Block) -> None:
        self._blocks.append(block)
        if len(block):
            self._newest = max(self._newest, float(block.times[-1]))

    def process_step(self) -> None:
        """Look at the whole frames; nothing changes between two of them."""
        if self._newest < self._processed_to + DETECTION.frame_duration:
            return
        self._processed_to = self._newest
        for block in join_blocks(self._blocks):
            self._rows += self._stream.feed(block)
        self._blocks.clear()
        self._rows += self._stream.take_complete_rows()
        rows = np.concatenate(
            [self._left] + [np.column_stack([one.columns(_READ), one.times]) for one in self._rows]
        )
        self._rows.clear()
        whole = len(rows) // self._count * self._count
        self._left = rows[whole:]
        frames = rows[:whole].reshape(-1, self._count, rows.shape[1])
        present = np.isfinite(frames).sum(axis=1)
        sums = np.where(np.isfinite(frames), frames, 0.0).sum(axis=1)
        means = sums / np.where(present > 0, present, np.nan)
        for frame, mean in zip(frames, means[:, :-1], strict=True):
            if np.isfinite(mean).any():  # else the link was silent
                self._frame(float(frame[0, -1]), mean)

    def _frame(self, time: float, means: FloatArray) -> None:
        speed, altitude = (
            float(means[SIGNAL_COLUMNS["V"]]),
            float(means[SIGNAL_COLUMNS["altitude"]]),
        )
        over_ground = float(means[-1])
        if self._airborne_detector is None:
            flies = speed > self._speed or (math.isnan(speed) and over_ground > self._speed)
        else:
            self._airborne_detector.add(time, means[:-1])
            flies = self._airborne_detector.airborne
        # A vehicle without air data may seem to fly for ever; one that is fast has not landed.
        reported = bool(self._on_ground(time)) and self._is_slow(speed, over_ground)
        if flies and not reported:
            self._flown += 1
            self._standing = 0
            self._altitudes.clear()
            if self.landed_at is None or self._flown < MONITORS.min_flown_frames:
                return
            self.landed_at = None  # another take-off
            return
        if math.isfinite(altitude):
            self._altitudes.append(altitude)
            if (
                self._flown < MONITORS.min_flown_frames
                and not speed > MONITORS.slow_ratio * self._speed
            ):
                self._ground = altitude
        if not reported and not self._is_at_rest(speed, over_ground, means):
            self._standing = 0
            return
        if not self._standing:
            self._since = time
        self._standing += 1
        patience = (
            MONITORS.reported_ground_frames
            if reported
            else self._required_frames(altitude, over_ground)
        )
        if self._flown >= MONITORS.min_flown_frames and self._standing >= patience:
            self.landed_at = self._since
            self._flown = 0

    def _is_at_rest(self, speed: float, over_ground: float, means: FloatArray) -> bool:
        """Return whether nothing of a frame contradicts an aircraft that stands."""
        rates = np.abs(means[[SIGNAL_COLUMNS["p"], SIGNAL_COLUMNS["q"]]])
        level = (
            not self._altitudes
            or max(self._altitudes) - min(self._altitudes) < MONITORS.max_altitude_change
        )
        altitude = float(means[SIGNAL_COLUMNS["altitude"]])
        high = math.isnan(over_ground) and altitude - self._ground > MONITORS.max_ground_height
        return (
            self._is_slow(speed, over_ground)
            and level
            and not high
            and not bool((rates > MONITORS.max_ground_rate).any())
        )

    def _is_slow(self, speed: float, over_ground: float) -> bool:
        return not max(_or_zero(speed), _or_zero(over_ground)) > MONITORS.slow_ratio * self._speed

    def _required_frames(self, altitude: float, over_ground: float) -> int:
        confirmed = math.isfinite(over_ground) or math.isfinite(altitude - self._ground)
        return MONITORS.standing_frames if confirmed else MONITORS.standing_frames_alone


def _or_zero(value: float) -> float:
    return value if math.isfinite(value) else 0.0

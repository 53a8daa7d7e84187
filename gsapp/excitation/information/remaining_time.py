"""What time is left: by the clock, by the fuel, and how many maneuvers fit into it."""

from __future__ import annotations

import math

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.excitation.flight_rows import FlightRows
from gsapp.excitation.settings import INFORMATION
from gsapp.flight.maneuvers.airborne_detection import AirborneDetector
from gsapp.flight.maneuvers.settings import DETECTION
from gsapp.flight.maneuvers.signals import SIGNALS
from gsapp.quantities import FloatArray


class RemainingTimeEstimator:
    """Counts down one flight by fuel and clock; without an aircraft by the clock alone."""

    def __init__(
        self,
        aircraft: Aircraft | None,
        rate: float,
        *,
        longest: float = INFORMATION.default_flight_duration,
    ) -> None:
        self._aircraft = aircraft
        self._rate = rate
        self.max_duration = longest
        self._frame = max(1, round(DETECTION.frame_duration * rate))
        self.restart()

    def restart(self) -> None:
        self._watch = None if self._aircraft is None else AirborneDetector(self._aircraft)
        self._rest: FloatArray = np.empty((0, len(SIGNALS)))
        self._next = 0
        self.takeoff_time: float | None = None
        self._landed = False
        self._burned = 0.0
        self._burned_at_takeoff = 0.0
        self._measured: float | None = None
        self._measured_at_takeoff: float | None = None
        self._inputs: list[float] = []

    # --- what comes in --------------------------------------------------------------------------

    def process_rows(self, rows: FlightRows) -> None:
        if self._watch is None or self._aircraft is None or not len(rows):
            return
        first = rows.first_index
        if rows.starts_segment or first != self._next:
            self._rest = self._rest[:0]
        self._next = first + len(rows)
        self._burn(rows)
        pending = np.concatenate((self._rest, rows.values[:, : len(SIGNALS)]))
        start = first - len(self._rest)
        # Frames lie on the grid of all rows, however these came.
        skipped = -start % self._frame if not len(self._rest) else 0
        pending, start = pending[skipped:], start + skipped
        whole = len(pending) // self._frame * self._frame
        frames = pending[:whole].reshape(-1, self._frame, len(SIGNALS))
        there = np.isfinite(frames)
        counts = there.sum(axis=1)
        means = np.where(there, frames, 0.0).sum(axis=1) / np.maximum(counts, 1)
        means[counts == 0] = np.nan
        for index, mean in enumerate(means):
            self._judge((start + index * self._frame) / self._rate, mean)
        self._rest = pending[whole:]

    def add_maneuver(self, t_input: float) -> None:
        """Take note of a maneuver, good or bad, whose input began then (s)."""
        self._inputs.append(t_input)

    def _judge(self, time: float, means: FloatArray) -> None:
        watch = self._watch
        assert watch is not None  # noqa: S101 - for the type checker
        before = watch.airborne
        watch.add(time, means)
        if watch.airborne and not before and self.takeoff_time is None:
            self.takeoff_time = time if math.isinf(watch.since) else watch.since
            self._burned_at_takeoff = self._burned
            self._measured_at_takeoff = self._measured
        self._landed = self.takeoff_time is not None and not watch.airborne

    def _burn(self, rows: FlightRows) -> None:
        """Add up the fuel that the throttle asked for, and look at the gauge.

        Engines run while they turn; where nobody measures that, while the throttle is open.
        """
        assert self._aircraft is not None  # noqa: S101 - for the type checker
        mass = self._aircraft.mass
        throttle = rows["throttle"]
        flow = mass.fuel_flow_idle + (mass.fuel_flow_full - mass.fuel_flow_idle) * np.clip(
            throttle, 0.0, 1.0
        )
        flow = np.where(np.isfinite(throttle), flow, self._usual_flow)
        rpm = rows["rpm"]
        running = np.where(
            np.isfinite(rpm),
            rpm > INFORMATION.engine_running_speed,
            ~(throttle < INFORMATION.closed_throttle),
        )
        flow = np.where(running, flow, 0.0)
        # One after the other, so that pieces give what the whole gives.
        self._burned = float(np.cumsum(np.concatenate(([self._burned], flow / self._rate)))[-1])
        gauge = rows["fuel"]
        seen = gauge[np.isfinite(gauge)]
        if seen.size:
            self._measured = float(seen[-1])

    @property
    def _usual_flow(self) -> float:
        assert self._aircraft is not None  # noqa: S101 - for the type checker
        mass = self._aircraft.mass
        return 0.5 * (mass.fuel_flow_idle + mass.fuel_flow_full)

    # --- what follows ---------------------------------------------------------------------------

    @property
    def maneuver_interval(self) -> float:
        """Return the time from one maneuver to the next as learned so far, s."""
        gaps = np.diff(np.array(self._inputs))
        laps = gaps[(gaps >= INFORMATION.min_lap) & (gaps <= INFORMATION.max_lap)]
        return float((INFORMATION.default_maneuver_interval + laps.sum()) / (1 + laps.size))

    @property
    def mass(self) -> float | None:
        """Return the mass of the aircraft by the fuel burned so far, kg; None without aircraft."""
        if self._aircraft is None:
            return None
        whole = self._aircraft.mass
        return whole.mass - whole.fuel + (self._fuel if whole.fuel > 0.0 else 0.0)

    @property
    def _fuel(self) -> float:
        """Return the fuel on board, kg."""
        assert self._aircraft is not None  # noqa: S101 - for the type checker
        if self._measured is not None:
            return self._measured
        return max(self._aircraft.mass.fuel - self._burned, 0.0)

    def time_left(self, time: float) -> float | None:
        """Return the seconds left for maneuvers at a flight time, by clock and fuel.

        Before take-off those of the whole flight; zero once landed; None where nothing tells.
        """
        if self._aircraft is None:
            return None
        if self._landed:
            return 0.0
        flown = 0.0 if self.takeoff_time is None else time - self.takeoff_time
        left = self.max_duration - flown
        by_fuel = self._by_fuel(flown)
        if by_fuel is not None:
            left = min(left, by_fuel)
        return max(left - INFORMATION.landing_reserve, 0.0)

    def _by_fuel(self, flown: float) -> float | None:
        """Return how long the fuel lasts, s; None where the file says nothing of fuel."""
        assert self._aircraft is not None  # noqa: S101 - for the type checker
        mass = self._aircraft.mass
        gauge = self._measured is not None
        if not gauge and not (mass.fuel > 0.0 and mass.fuel_flow_full > 0.0):
            return None
        flow = self._usual_flow
        if flown > INFORMATION.fuel_flow_time:
            if gauge and self._measured_at_takeoff is not None:
                burned = self._measured_at_takeoff - self._fuel
            else:
                burned = self._burned - self._burned_at_takeoff
            flow = burned / flown
        return self._fuel / flow if flow > 0.0 else None

    def maneuvers_left(self, time: float) -> int | None:
        left = self.time_left(time)
        return None if left is None else int(left // self.maneuver_interval)

    @property
    def remarks(self) -> tuple[str, ...]:
        """Return by what the time is counted where it is not measured."""
        if self._aircraft is None:
            return ("no aircraft file: fuel and flight time not monitored",)
        if self._measured is not None:
            return ()
        if self._aircraft.mass.fuel > 0.0 and self._aircraft.mass.fuel_flow_full > 0.0:
            return ("fuel is counted by the throttle; no channel measures it",)
        return ("no fuel in the aircraft file: only flight time is monitored",)

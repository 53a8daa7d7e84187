"""Level flight over speed: which angle of attack, throttle and elevator belong together at 1 g."""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator

from gsapp.aircraft import Aircraft
from gsapp.dynamics.atmosphere import SEA_LEVEL_DENSITY
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.model import Model
from gsapp.dynamics.trim import Trim, find_unflyable_reasons, trim
from gsapp.excitation.test_points.settings import INPUTS
from gsapp.foundation import FlightError
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import GRAVITY


@dataclass(frozen=True, slots=True, kw_only=True)
class LevelFlight:
    """Steady level flight at one speed."""

    speed: float
    """True airspeed, m/s."""
    alpha: float
    """At the CG, rad."""
    throttle: float
    """0 to 1."""
    elevator: float
    """rad."""


class TrimCurve:
    """The trim curve of an aircraft on the day; found once, on a grid of speeds.

    Parameters
    ----------
    model : Model or None
        None: nothing can be told, and every answer is None.
    mass, rho, flap : float
        kg (the aircraft file's by default), kg/m^3, rad.

    Attributes
    ----------
    alpha_shift : float
        By which alpha as measured lies above that of the model, rad; see `with_measured_alpha`.
    problem : str
        Why nothing can be told, in words; empty if something can.
    """

    def __init__(
        self,
        aircraft: Aircraft,
        model: Model | None,
        *,
        mass: float | None = None,
        rho: float = SEA_LEVEL_DENSITY,
        flap: float = 0.0,
    ) -> None:
        self.mass = aircraft.mass.mass if mass is None else mass
        self.rho = rho
        self.flap = flap
        self.alpha_shift = 0.0
        self.problem = ""
        self._table = self._flown(aircraft, model)
        if self._table.size:
            speeds, alphas = self._table[:, 0], self._table[:, 1]
            self._curve = PchipInterpolator(speeds, self._table[:, 1:])
            self._speed = PchipInterpolator(alphas[::-1], speeds[::-1])

    @property
    def speed_range(self) -> tuple[float, float] | None:
        """Return the slowest and the fastest level flight, m/s; None where nothing is known."""
        if not self._table.size:
            return None
        return float(self._table[0, 0]), float(self._table[-1, 0])

    def level_flight_at(self, speed: float) -> LevelFlight | None:
        """Return level flight at a speed (m/s); None where it cannot be flown or is not known."""
        ends = self.speed_range
        if ends is None or not ends[0] <= speed <= ends[1]:
            return None
        alpha, throttle, elevator = (float(value) for value in self._curve(speed))
        return LevelFlight(
            speed=speed, alpha=alpha + self.alpha_shift, throttle=throttle, elevator=elevator
        )

    def alpha_at(self, speed: float) -> float | None:
        """Return the angle of attack (rad) at a speed (m/s), or None."""
        found = self.level_flight_at(speed)
        return None if found is None else found.alpha

    def speed_at(self, alpha: float) -> float | None:
        """Return the speed (m/s) at an angle of attack (rad), or None."""
        if not self._table.size:
            return None
        by_model = alpha - self.alpha_shift
        least, most = float(self._table[-1, 1]), float(self._table[0, 1])
        if not least - INPUTS.alpha_tolerance <= by_model <= most + INPUTS.alpha_tolerance:
            return None
        return float(self._speed(min(max(by_model, least), most)))

    def with_measured_alpha(self, flown: Sequence[tuple[float, float]]) -> TrimCurve:
        """Return the curve with its alpha as it was measured in steady flight.

        Parameters
        ----------
        flown : sequence of (float, float)
            Mean speed (m/s) and alpha (rad) of steady level stretches; three at least. Their
            median counts, and no more of it than `INPUTS.max_alpha_shift`.
        """
        misses = [
            alpha - expected.alpha + self.alpha_shift
            for speed, alpha in flown
            if (expected := self.level_flight_at(speed)) is not None and math.isfinite(alpha)
        ]
        if len(misses) < INPUTS.min_segments:
            return self
        moved = copy.copy(self)
        moved.alpha_shift = min(
            max(float(np.median(misses)), -INPUTS.max_alpha_shift), INPUTS.max_alpha_shift
        )
        return moved

    def _flown(self, aircraft: Aircraft, model: Model | None) -> FloatArray:
        """Return speed, alpha, throttle and elevator over the range; without rows if none."""
        nothing = np.empty((0, 4))
        if model is None:
            self.problem = "no model relates angle of attack and speed"
            return nothing
        problems = find_unflyable_reasons(aircraft, model)
        if problems:
            self.problem = f"the model '{model.name}' cannot be flown: {problems[0]}"
            return nothing
        flying = FlightModel(aircraft, model)
        slowest, fastest = self._ends(aircraft, model)
        grid = np.linspace(slowest, fastest, INPUTS.grid_points)
        found = [self._level(flying, speed) for speed in grid.tolist()]
        run = _longest_true_run([one is not None for one in found])
        if run.stop - run.start < 2:
            self.problem = f"the model '{model.name}' has no level-flight speed"
            return nothing
        rows = [_level_flight_row(one) for one in found[run] if one is not None]
        for place, beyond in ((0, run.start - 1), (-1, run.stop)):
            if 0 <= beyond < grid.size:
                end = self._end(flying, rows[place][0], float(grid[beyond]))
                rows.insert(0 if place == 0 else len(rows), end)
        table = np.array(sorted(set(rows)))
        # Where alpha does not fall with speed there is no telling one from the other.
        return table if bool((np.diff(table[:, 1]) < 0.0).all()) else self._told_apart(table)

    def _told_apart(self, table: FloatArray) -> FloatArray:
        falling = np.concatenate(([True], np.diff(table[:, 1]) < 0.0))
        return table[_longest_true_run(falling.tolist())]

    def _ends(self, aircraft: Aircraft, model: Model) -> tuple[float, float]:
        """Return where to look, m/s."""
        limits, weight = aircraft.limits, self.mass * GRAVITY
        lift = model.derivative("CN_0") + model.derivative("CN_alpha") * limits.alpha_stall
        pressure = weight / (max(lift, 0.1) * aircraft.geometry.wing_area)
        stall = math.sqrt(2.0 * pressure / self.rho)
        true = math.sqrt(SEA_LEVEL_DENSITY / self.rho)
        slowest = max(INPUTS.min_speed_ratio * stall, limits.stall_speed * true)
        return slowest, max(
            min(INPUTS.max_speed_ratio * stall, limits.maximum_speed * true), 1.1 * slowest
        )

    def _level(self, flying: FlightModel, speed: float) -> Trim | None:
        try:
            return trim(flying, V=speed, rho=self.rho, mass=self.mass, flap=self.flap)
        except FlightError:
            return None

    def _end(self, flying: FlightModel, inside: float, outside: float) -> _Row:
        """Return level flight at the end of the range, between a speed that flies and one not."""
        for _ in range(INPUTS.bisections):
            middle = 0.5 * (inside + outside)
            if self._level(flying, middle) is None:
                outside = middle
            else:
                inside = middle
        found = self._level(flying, inside)
        assert found is not None  # noqa: S101  it flew a moment ago
        return _level_flight_row(found)


_Row = tuple[float, float, float, float]


def _level_flight_row(level: Trim) -> _Row:
    controls, state = level.controls, level.state
    return (
        float(state[0]),
        float(state[1]),
        float(controls["throttle"]),
        float(controls["de"]),
    )


def _longest_true_run(flags: Sequence[bool]) -> slice:
    """Return where most successive flags are set."""
    best, start = slice(0, 0), 0
    for place, flag in enumerate([*flags, False]):
        if not flag:
            if place - start > best.stop - best.start:
                best = slice(start, place)
            start = place + 1
    return best

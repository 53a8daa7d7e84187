"""Test points: where to be, trimmed, before an input, and what is wanted of it."""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.dynamics.atmosphere import SEA_LEVEL_DENSITY
from gsapp.dynamics.flight_model import FlightModel
from gsapp.dynamics.model import Model
from gsapp.dynamics.trim import Trim, find_unflyable_reasons, trim
from gsapp.excitation.settings import INPUTS
from gsapp.flight.cards import TestCard, Tolerance
from gsapp.foundation import FlightError
from gsapp.quantities import FloatArray, channel, from_si
from gsapp.quantities.constants import GRAVITY


@dataclass(frozen=True, slots=True, kw_only=True)
class TestPoint:
    """Where the aircraft should be when the input begins."""

    __test__ = False  # the name is the field's; it is no test of ours

    card: str = ""
    """Id of the card that it belongs to; empty for none."""
    speed: float | None = None
    alpha: float | None = None
    """True airspeed, m/s, and angle of attack at the CG at 1 g, rad: a pair on the trim curve, or
    one of them where no model tells the other."""
    speed_tolerance: float
    alpha_tolerance: float
    """To either side, m/s and rad."""
    height: float | None = None
    """Above the field, m."""
    flap: float = 0.0
    """rad."""
    throttle: float | None = None
    elevator: float | None = None
    """That hold it in level flight, by the model; 0 to 1 and rad."""
    density: float | None = None
    mass: float | None = None
    """Of the air (kg/m^3) and of the aircraft (kg) that this holds for; None: sea level, and the
    aircraft file's."""
    remarks: tuple[str, ...] = ()
    """What cannot be told of it, in words."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ToleranceBand:
    """A wanted value with the room around it."""

    low: float
    best: float
    high: float
    why_low: str = ""
    why_high: str = ""
    """What sets each end, in words: "the pitch rate must stand out of its noise ten times", "alpha
    leaves its linear range"."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TargetInput:
    """The input wanted at a test point."""

    surfaces: tuple[str, ...]
    """``de``, ``da``, ``dr`` in the order in which they are moved."""
    kind: str
    """Shape of each input."""
    amplitudes: Mapping[str, ToleranceBand]
    """Half of peak to peak by surface, rad; a surface of which nothing is known is absent."""
    width: ToleranceBand
    """Of one step, s."""
    hands_off: float
    """Two periods of the slowest oscillation that the input excites (phugoid and spiral, which no
    straight leg is long enough for, are not meant), s."""
    mode: str
    """Which oscillation sets `hands_off` and `width`: ``short period``, ``dutch roll``,
    ``roll``."""
    source: Literal["card", "model", "flight", "usual"]
    """Where it comes from; ``flight`` once derivatives estimated in this flight replaced those of
    the model, ``usual`` where no model flies there."""


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
    """The trim curve of an aircraft on the day (mass, rho, flap); found once, on a grid of speeds.

    Where nothing can be told every answer is None, and `problem` says why. Alpha as measured lies
    above that of the model by `alpha_shift`, rad; see `with_measured_alpha`.
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
            from scipy.interpolate import PchipInterpolator  # a quarter of a second

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

        From speed (m/s) and alpha (rad) of three or more level stretches. Their median counts, and
        no more of it than `INPUTS.max_alpha_shift`.
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
    best, start = slice(0, 0), 0
    for index, flag in enumerate([*flags, False]):
        if not flag:
            if index - start > best.stop - best.start:
                best = slice(start, index)
            start = index + 1
    return best


class TestPointError(FlightError):
    """Nobody can fly there; the sentence says what can be flown."""

    __test__ = False  # the name is the field's; it is no test of ours


def create_test_point(
    card: TestCard,
    curve: TrimCurve | None,
    *,
    system: str = "US",
) -> TestPoint:
    """Return the test point of a card, by the curve for its flap, if a model is known.

    `TestPointError` as for `create_point_at`.
    """
    return create_point_at(
        speed=card.speed,
        alpha=card.alpha,
        curve=curve,
        tolerance=card.tolerance,
        card=card.id,
        height=card.height,
        flap=card.flap,
        system=system,
    )


def create_point_at(
    *,
    speed: float | None = None,
    alpha: float | None = None,
    curve: TrimCurve | None,
    tolerance: Tolerance | None = None,
    card: str = "",
    height: float | None = None,
    flap: float = 0.0,
    system: str = "US",
) -> TestPoint:
    """Return a test point for a speed, an angle of attack, or a pair of them.

    At 1 g one fixes the other. `TestPointError` if neither is given, it cannot be flown, or the
    pair lies off the trim curve by more than the tolerance (a card's usual one by default).
    """
    if speed is None and alpha is None:
        raise TestPointError("a test point needs a speed or an angle of attack; write one of them")
    tolerance = tolerance or Tolerance()
    remarks: tuple[str, ...] = ()
    level = None
    if curve is None or curve.speed_range is None:
        why = curve.problem if curve is not None and curve.problem else "no model is known"
        unknown = "whether speed and angle of attack fit each other"
        if speed is None or alpha is None:
            unknown = f"the {'speed' if speed is None else 'angle of attack'} that belongs to it"
        remarks = (f"{unknown} cannot be determined: {why}",)
    else:
        aimed = speed
        if aimed is None and alpha is not None:
            aimed = curve.speed_at(alpha)
            if aimed is None:
                raise TestPointError(_no_such_alpha(alpha, curve, system))
        assert aimed is not None  # noqa: S101  one of the two was given
        level = curve.level_flight_at(aimed)
        if level is None:
            raise TestPointError(_no_such_speed(aimed, curve, system))
        if alpha is not None and abs(alpha - level.alpha) > tolerance.alpha:
            told = _format_value(level.alpha, "alpha", system)
            raise TestPointError(
                f"at {_format_value(aimed, 'V', system)} it flies level at alpha {told}, not "
                f"{_format_value(alpha, 'alpha', system)}; write {told} or leave alpha out"
            )
        speed = aimed
        # A pair within tolerance is aimed at as written.
        alpha = level.alpha if alpha is None else alpha
    return TestPoint(
        card=card,
        speed=speed,
        alpha=alpha,
        speed_tolerance=tolerance.speed,
        alpha_tolerance=tolerance.alpha,
        height=height,
        flap=flap,
        throttle=None if level is None else level.throttle,
        elevator=None if level is None else level.elevator,
        density=None if curve is None else curve.rho,
        mass=None if curve is None else curve.mass,
        remarks=remarks,
    )


def _no_such_speed(speed: float, curve: TrimCurve, system: str) -> str:
    assert curve.speed_range is not None  # noqa: S101  asked before
    low, high = curve.speed_range
    slow = speed < low
    end = low if slow else high
    return (
        f"level flight at {_format_value(speed, 'V', system)} is not possible: the "
        f"{'slowest' if slow else 'fastest'} is {_format_value(end, 'V', system)}; write "
        f"{'more' if slow else 'less'}"
    )


def _no_such_alpha(alpha: float, curve: TrimCurve, system: str) -> str:
    assert curve.speed_range is not None  # noqa: S101  asked before
    most, least = (curve.alpha_at(speed) or 0.0 for speed in curve.speed_range)
    return (
        f"level flight at alpha {_format_value(alpha, 'alpha', system)} is not possible: it goes "
        "from "
        f"{_format_value(least, 'alpha', system)} at "
        f"{_format_value(curve.speed_range[1], 'V', system)} to "
        f"{_format_value(most, 'alpha', system)} at "
        f"{_format_value(curve.speed_range[0], 'V', system)}; write one in between"
    )


def _format_value(value: float, name: str, system: str) -> str:
    """Return a value in the user's units, with the digits that are of use in a sentence."""
    spec = channel(name)
    unit = spec.display_unit(system)
    text = f"{from_si(value, unit, spec.quantity):.1f}"
    return f"{text.removesuffix('.0')} {unit}"

"""From ticks to the motion of the last second, from whatever is measured."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from typing import Final

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.excitation.trim.bank import BankObserver
from gsapp.excitation.trim.climb import ClimbObserver
from gsapp.excitation.trim.judging import Motion
from gsapp.excitation.trim.leg import LegWatch
from gsapp.excitation.trim.standing import StandWatch
from gsapp.excitation.trim.ticks import PLACE
from gsapp.excitation.trim.tolerances import TrimTolerances
from gsapp.excitation.trim.unrest import RESTLESS, UnrestWatch
from gsapp.excitation.trim.windows import MovingWindow, WindowFit
from gsapp.flight.maneuvers.airborne import flying_speed
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import GRAVITY

_FITTED: Final = (*RESTLESS, "V")
_FITTED_PLACES: Final = [PLACE[name] for name in _FITTED]
_USUAL_SPEED: Final = 28.0
_CRUISE: Final = 1.5
"""Usual airspeed over that below which it does not fly."""
_EARTH_RADIUS: Final = 6_371_000.0
_TURN_TIME: Final = 0.5
_QUICK_TIME: Final = 0.3
_LEAST_SHARE: Final = 0.6


class Senses:
    """Knows the motion tick by tick.

    Parameters
    ----------
    aircraft : Aircraft or None
    dt : float
        Between ticks, s.
    tolerances : TrimTolerances
        Their windows.

    Attributes
    ----------
    motion : Motion
        Over the last second.
    quick : tuple of float
        p, q, r over the last 0.3 s, rad/s.
    airborne : bool
    attitude, beta : bool
        Whether bank is measured, and sideslip.
    unrest : UnrestWatch
    leg : LegWatch
    """

    def __init__(self, aircraft: Aircraft | None, dt: float, tolerances: TrimTolerances) -> None:
        self._aircraft = aircraft
        self._dt = dt
        self._second = round(tolerances.steady / dt)
        usual = _USUAL_SPEED if aircraft is None else _CRUISE * flying_speed(aircraft)
        self.unrest = UnrestWatch(aircraft, tolerances, self._second)
        self._stand = StandWatch(aircraft, dt)
        self.leg = LegWatch(dt)
        self._bank = BankObserver(dt, usual)
        self._climb = ClimbObserver(dt)
        self.restart()

    def restart(self) -> None:
        """Forget the motion and the legs; what standing still told stays."""
        self.unrest.restart()
        self.leg.restart()
        self._bank.restart()
        self._climb.restart()
        self._window = MovingWindow(self._second, len(_FITTED))
        self._derived: deque[tuple[float, float, float]] = deque(maxlen=self._second)
        self._turns: deque[float] = deque(maxlen=round(_TURN_TIME / self._dt))
        self._rates: deque[Sequence[float]] = deque(maxlen=round(_QUICK_TIME / self._dt))
        self.motion = Motion(*(math.nan for _ in Motion._fields))
        self.quick: tuple[float, ...] = (0.0, 0.0, 0.0)
        self.airborne = self.attitude = self.beta = False

    def take(self, ticks: FloatArray) -> Iterator[None]:
        """Go through ticks of `gsapp.excitation.trim.ticks.SEEN`; give way after each."""
        flies = self._flown(ticks)
        fit = self._window.take(ticks[:, _FITTED_PLACES])
        places = _positions(ticks)
        for place, values in enumerate(ticks.tolist()):
            self._step(values, places[place], flies[place], fit, place)
            yield

    def _flown(self, ticks: FloatArray) -> list[tuple[bool, bool]]:
        """Return whether it flies and stands at each tick; take zeros off, put alpha to the CG."""
        states = []
        watched = [PLACE[name] for name in ("p", "q", "r", "V", "altitude")]
        for row, values in enumerate(ticks[:, watched].tolist()):
            self._stand.step(tuple(values))
            states.append((self._stand.airborne, self._stand.standing))
            ticks[row, :3] -= self._stand.zeros
        if self._aircraft is not None:
            vane = self._aircraft.sensors.alpha_vane
            x, y, _ = vane.position
            p, q, speed = ticks[:, PLACE["p"]], ticks[:, PLACE["q"]], ticks[:, PLACE["V"]]
            arm = np.where(speed > 1.0, q * x - p * y, 0.0) / np.maximum(speed, 1.0)
            ticks[:, PLACE["alpha"]] /= vane.upwash
            ticks[:, PLACE["alpha"]] += np.where(np.isfinite(arm), arm, 0.0)
        return states

    def _step(
        self,
        values: list[float],
        position: list[float],
        flies: tuple[bool, bool],
        fit: WindowFit,
        place: int,
    ) -> None:
        airborne, standing = flies
        self.airborne = airborne
        powers = fit.power[place, : len(RESTLESS)].tolist()
        means = fit.mean[place].tolist()
        p, q, r, ax, ay, an, _, beta, speed, phi, theta, altitude, climb_rate, height = values[:14]
        self.attitude, self.beta = phi == phi, beta == beta
        if standing:
            self.unrest.learn(powers)
        if not airborne:
            self._bank.restart()
        self.unrest.step(powers, means[-1])
        bank = self._bank
        bank.step((p, q, r), ax, ay, speed, beta, self.unrest.gusts or 0.0)
        seen = phi if self.attitude else bank.bank
        leaning = seen if seen == seen else 0.0
        nose = theta if theta == theta else bank.nose
        sine, cosine = math.sin(leaning), math.cos(leaning)
        lift = math.cos(nose) * (cosine * an - (sine * ay if ay == ay else 0.0)) - GRAVITY
        lift += math.sin(nose) * ax if ax == ax else 0.0
        self._climb.step(altitude, climb_rate, lift)
        self._derived.append((seen, self._climb.climb, height))
        self._rates.append((p, q, r))
        self._turns.append((q * sine if q == q else 0.0) + r * cosine)
        if airborne:
            self.leg.step(self._turns[-1], _mean(self._turns), *position)
        self.quick = tuple(_mean(column) for column in zip(*self._rates, strict=True))
        leaned, climb, high = (_mean(column) for column in zip(*self._derived, strict=True))
        self.motion = Motion(
            roll_rate=means[0],
            pitch_rate=means[1],
            yaw_rate=means[2],
            speed=means[-1],
            acceleration=float(fit.slope[place, -1]) / self._dt,
            alpha=means[4],
            bank=leaned,
            climb=climb,
            height=high,
            spread=0.0 if self.attitude else bank.spread,
        )


def _positions(ticks: FloatArray) -> list[list[float]]:
    """Return north and east from anywhere, m, of each tick; NaN where unknown."""
    north, east = ticks[:, PLACE["north"]], ticks[:, PLACE["east"]]
    latitude, longitude = ticks[:, PLACE["latitude"]], ticks[:, PLACE["longitude"]]
    east = np.where(np.isfinite(east), east, _EARTH_RADIUS * longitude * np.cos(latitude))
    north = np.where(np.isfinite(north), north, _EARTH_RADIUS * latitude)
    found: list[list[float]] = np.column_stack((north, east)).tolist()
    return found


def _mean(values: Iterable[float]) -> float:
    """Return the mean of what is there; NaN where much is missing."""
    given = list(values)
    known = [value for value in given if value == value]
    enough = len(known) >= _LEAST_SHARE * len(given) and known
    return sum(known) / len(known) if enough else math.nan

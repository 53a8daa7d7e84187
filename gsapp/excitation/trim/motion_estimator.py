"""From ticks to the motion of the last second, from whatever is measured."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from typing import Final

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.excitation.trim.bank_observer import BankObserver
from gsapp.excitation.trim.climb_observer import ClimbObserver
from gsapp.excitation.trim.ground_monitor import GroundMonitor
from gsapp.excitation.trim.leg_monitor import LegMonitor
from gsapp.excitation.trim.moving_window import MovingWindow, WindowFit
from gsapp.excitation.trim.tick_means import TICK_INDEX
from gsapp.excitation.trim.tolerances import TrimTolerances
from gsapp.excitation.trim.trim_evaluation import ATTITUDE_SOURCE, MeanMotion
from gsapp.excitation.trim.turbulence_monitor import TURBULENCE_CHANNELS, TurbulenceMonitor
from gsapp.flight.maneuvers.airborne_detection import flying_speed
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import EARTH_RADIUS, GRAVITY

_FITTED: Final = (*TURBULENCE_CHANNELS, "V")
_FITTED_PLACES: Final = [TICK_INDEX[name] for name in _FITTED]
_P, _Q, _R, _ALPHA = (TICK_INDEX[name] for name in ("p", "q", "r", "alpha"))
_SPEED, _ALTITUDE = TICK_INDEX["V"], TICK_INDEX["altitude"]
_SLOWEST: Final = 5.0
"""Airspeed below which flow angles mean nothing, m/s."""
_USUAL_SPEED: Final = 28.0
"""Airspeed, m/s, where neither a pitot nor an aircraft file tells one."""
_CRUISE: Final = 1.5
"""Usual airspeed over that below which it does not fly."""
_BANK_SIGNS: Final = ("turn rate", "rate of roll", "lateral acceleration", "beta")
"""What tells of the bank where no attitude is measured."""
_TURN_TIME: Final = 0.7
"""Seconds of which the mean turn rate tells a turn."""
_QUICK_TIME: Final = 0.3
"""Seconds of which the mean rates tell that trim is lost."""
_LEAST_SHARE: Final = 0.6
"""Share of what a mean is taken of that must be there."""


class MotionEstimator:
    """Knows the motion tick by tick.

    Parameters
    ----------
    dt : float
        Between ticks, s.

    Attributes
    ----------
    fast_rates : tuple of float
        p, q, r over the last 0.3 s, rad/s.
    bank_sources : tuple of str
        What tells the bank, in words.
    """

    def __init__(self, aircraft: Aircraft | None, dt: float, tolerances: TrimTolerances) -> None:
        self._aircraft = aircraft
        self._dt = dt
        self._second = round(tolerances.averaging_time / dt)
        usual = _USUAL_SPEED if aircraft is None else _CRUISE * flying_speed(aircraft)
        self.unrest = TurbulenceMonitor(aircraft, tolerances, self._second)
        self._stand = GroundMonitor(aircraft, dt)
        self.leg = LegMonitor(dt)
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
        self.motion = MeanMotion(*(math.nan for _ in MeanMotion._fields))
        self._local = False
        self.fast_rates: tuple[float, ...] = (0.0, 0.0, 0.0)
        self.airborne = self.on_ground = False
        self.bank_sources: tuple[str, ...] = ()

    def process_ticks(self, ticks: FloatArray) -> Iterator[None]:
        """Go through ticks of `TICK_CHANNELS`; yield after each."""
        prepared = [self._prepared(values) for values in ticks.tolist()]
        fitted = [[values[place] for place in _FITTED_PLACES] for values, *_ in prepared]
        fit = self._window.fit_windows(np.array(fitted, dtype=np.float64).reshape(-1, len(_FITTED)))
        for place, (values, airborne, on_ground, standing) in enumerate(prepared):
            self.airborne, self.on_ground = airborne, on_ground
            self._step(values, standing, fit, place)
            yield

    def _prepared(self, values: list[float]) -> tuple[list[float], bool, bool, bool]:
        """Take zeros off, put alpha to the CG; return whether it flies, is grounded, stands."""
        stand = self._stand
        p, q, r, speed = values[_P], values[_Q], values[_R], values[_SPEED]
        stand.step((p, q, r, speed, values[_ALTITUDE]))
        p, q, r = (rate - zero for rate, zero in zip((p, q, r), stand.zero_offsets, strict=True))
        values[_P], values[_Q], values[_R] = p, q, r
        if self._aircraft is not None:
            vane = self._aircraft.sensors.alpha_vane
            turned = q * vane.position[0] - p * vane.position[1]
            known = speed > _SLOWEST and turned == turned
            values[_ALPHA] = values[_ALPHA] / vane.upwash + (turned / speed if known else 0.0)
        return values, stand.airborne, stand.on_ground, stand.standing

    def _step(self, values: list[float], standing: bool, fit: WindowFit, place: int) -> None:
        airborne = self.airborne
        powers = fit.power[place, : len(TURBULENCE_CHANNELS)].tolist()
        means = fit.mean[place].tolist()
        p, q, r, ax, ay, an, _, beta, speed, phi, theta, altitude, climb_rate, height = values[:14]
        attitude = phi == phi
        self.bank_sources = ATTITUDE_SOURCE if attitude else _bank_sources(r, p, ay, beta)
        if standing:
            self.unrest.learn_ground_noise(powers)
        if not airborne:
            self._bank.restart()
        self.unrest.step(powers, means[-1])
        bank = self._bank
        bank.step((p, q, r), ax, ay, speed, beta, self.unrest.gust_strength or 0.0)
        seen = phi if attitude else bank.bank
        leaning = seen if seen == seen else 0.0
        nose = theta if theta == theta else bank.pitch
        sine, cosine = math.sin(leaning), math.cos(leaning)
        lift = math.cos(nose) * (cosine * an - (sine * ay if ay == ay else 0.0)) - GRAVITY
        lift += math.sin(nose) * ax if ax == ax else 0.0
        self._climb.step(altitude, climb_rate, lift)
        self._derived.append((seen, self._climb.climb, height))
        self._rates.append((p, q, r))
        self._turns.append((q * sine if q == q else 0.0) + r * cosine)
        if airborne:
            self.leg.step(self._turns[-1], _mean(self._turns), seen, *self._place(values[14:]))
        self.fast_rates = tuple(_mean(column) for column in zip(*self._rates, strict=True))
        leaned, climb, high = (_mean(column) for column in zip(*self._derived, strict=True))
        self.motion = MeanMotion(
            roll_rate=means[0],
            pitch_rate=means[1],
            yaw_rate=means[2],
            speed=means[-1],
            acceleration=float(fit.slope[place, -1]) / self._dt,
            alpha=means[4],
            bank=leaned,
            climb=climb,
            height=high,
            bank_std=0.0 if attitude else bank.bank_std,
        )

    def _place(self, values: list[float]) -> tuple[float, float]:
        """Return north and east, m, from whichever position this flight has; NaN for none."""
        north, east, latitude, longitude = values
        # The two have different origins: one of them serves throughout.
        self._local = self._local or north == north
        if self._local:
            return north, east
        return EARTH_RADIUS * latitude, EARTH_RADIUS * longitude * math.cos(latitude)


def _bank_sources(*values: float) -> tuple[str, ...]:
    return tuple(words for words, value in zip(_BANK_SIGNS, values, strict=True) if value == value)


def _mean(values: Iterable[float]) -> float:
    """Return the mean of what is there; NaN where much is missing."""
    given = list(values)
    known = [value for value in given if value == value]
    enough = len(known) >= _LEAST_SHARE * len(given) and known
    return sum(known) / len(known) if enough else math.nan

"""Motion and air of a trim cue: windows of ticks, bank and climb, and how rough the air is.

Of each channel the power about the straight line of a second is known at every tick. Three such
seconds end to end say how restless the aircraft is now, five whether that lasts.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.dynamics.atmosphere import SEA_LEVEL_DENSITY
from gsapp.excitation.settings import CUES, TRIM
from gsapp.excitation.trim.bank_observer import BankObserver, TwoStateKalmanFilter
from gsapp.excitation.trim.leg_monitor import LegMonitor
from gsapp.excitation.trim.tick_means import TICK_INDEX
from gsapp.excitation.trim.trim_cue import ATTITUDE_SOURCE, MeanMotion, TrimTolerances
from gsapp.flight.maneuvers.airborne_detection import AirborneDetector, flying_speed
from gsapp.flight.maneuvers.settings import DETECTION
from gsapp.flight.maneuvers.signals import SIGNAL_COLUMNS, SIGNALS
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import EARTH_RADIUS, GRAVITY

TURBULENCE_CHANNELS: Final = ("p", "q", "r", "an", "alpha", "beta")
"""Channels by which unrest is judged."""


_LIFT: Final = TURBULENCE_CHANNELS.index("an")
_ALPHA_COLUMN: Final = TURBULENCE_CHANNELS.index("alpha")


class TurbulenceMonitor:
    """Follows unrest tick by tick; mass and wing area turn accelerations into gusts, m/s.

    `tolerance_ratio` is that of the most restless channel, root mean square over its tolerance, NaN
    where no channel tells; `is_lasting` whether it has been restless for some seconds. `second` is
    the window, in ticks, in which the powers were taken.
    """

    def __init__(self, aircraft: Aircraft | None, tolerances: TrimTolerances, second: int) -> None:
        self._loading = (
            None
            if aircraft is None
            else 2.0 * aircraft.mass.mass / (aircraft.geometry.wing_area * TRIM.lift_slope)
        )
        self._second = second
        self._now = max(1, round(tolerances.turbulence_time / tolerances.averaging_time))
        self._limits = (
            tolerances.roll_rate_rms,
            tolerances.pitch_rate_rms,
            tolerances.yaw_rate_rms,
            tolerances.an_rms,
            tolerances.alpha_rms,
            tolerances.beta_rms,
        )
        self._floor = [0.0] * len(TURBULENCE_CHANNELS)
        self._ground = 0
        self.restart()

    def restart(self) -> None:
        """Forget the motion; what was learned on the ground stays."""
        self._past: deque[Sequence[float]] = deque(
            maxlen=(TRIM.window_count - 1) * self._second + 1
        )
        self.tolerance_ratio, self.worst_channel, self.is_lasting = math.nan, "", False
        self.gust_strength: float | None = None

    def learn_ground_noise(self, powers: Sequence[float]) -> None:
        """Take in what is to be seen of a standing aircraft: noise and vibration."""
        self._ground += 1
        self._floor = [
            floor + (power - floor) / self._ground if power == power else floor
            for floor, power in zip(self._floor, powers, strict=True)
        ]

    def step(self, powers: Sequence[float], speed: float) -> None:
        """Go on by one tick with powers of `TURBULENCE_CHANNELS`, SI squared; NaN where missing."""
        self._past.append(self._with_alpha(powers, speed))
        seconds = [self._past[place] for place in range(len(self._past) - 1, -1, -self._second)]
        self.tolerance_ratio, self.worst_channel, self.is_lasting = math.nan, "", False
        for place, limit in enumerate(self._limits):
            floor = self._floor[place]
            clean = [max(one[place] - floor, 0.0) for one in seconds if one[place] == one[place]]
            recent = clean[: self._now]
            if not recent:
                continue
            share = math.sqrt(sum(recent) / len(recent)) / limit
            if not share <= self.tolerance_ratio:
                self.tolerance_ratio, self.worst_channel = share, TURBULENCE_CHANNELS[place]
                self.is_lasting = (
                    len(clean) >= TRIM.window_count
                    and min(clean) > (TRIM.lasting_share * limit) ** 2
                )
        self.gust_strength = self._gusts(seconds, speed)

    def _with_alpha(self, powers: Sequence[float], speed: float) -> Sequence[float]:
        """Put what the lift tells of alpha in place of a vane that is not there."""
        if (
            powers[_ALPHA_COLUMN] == powers[_ALPHA_COLUMN]
            or self._loading is None
            or not speed > TRIM.min_gust_speed
        ):
            return powers
        lift = max(powers[_LIFT] - self._floor[_LIFT], 0.0)
        told = lift * (self._loading / (SEA_LEVEL_DENSITY * speed * speed)) ** 2
        return (*powers[:_ALPHA_COLUMN], told, *powers[_ALPHA_COLUMN + 1 :])

    def _gusts(self, seconds: list[Sequence[float]], speed: float) -> float | None:
        alpha = [one[_ALPHA_COLUMN] for one in seconds if one[_ALPHA_COLUMN] == one[_ALPHA_COLUMN]]
        if not alpha or not speed > TRIM.min_gust_speed:
            return None
        bump = max(sum(alpha) / len(alpha) - self._floor[_ALPHA_COLUMN], 0.0)
        return TRIM.gust_ratio * speed * math.sqrt(bump)


# Means, slopes and unrest over moving windows, tick by tick.
# Each window is summed by itself, whatever number of ticks come at once: so the results are the
# same to the last bit however a stream was cut.


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class WindowFit:
    """The straight line through each window."""

    mean: FloatArray
    """Shape (n, m). NaN, as all, where too much is missing."""
    slope: FloatArray
    """Shape (n, m). Per tick."""
    power: FloatArray
    """Shape (n, m). Mean square about the line."""


class MovingWindow:
    """The latest ticks, as many as a window is long."""

    def __init__(self, length: int, columns: int) -> None:
        self._length = length
        self._past = np.full((length - 1, columns), np.nan)
        self._lags = np.arange(length)
        self._places = self._lags - 0.5 * (length - 1)
        self._lever = float((self._places**2).sum())

    def fit_windows(self, ticks: FloatArray) -> WindowFit:
        """Return the lines through the windows that end at these ticks, shape (n, m)."""
        length = self._length
        joined = np.concatenate((self._past, ticks))
        self._past = joined[len(ticks) :]
        # Contiguous along each window: that fixes the order of every sum.
        places = np.arange(len(ticks))[:, np.newaxis] + self._lags
        windows = np.ascontiguousarray(joined.T[:, places])
        there = np.isfinite(windows)
        present = there.sum(axis=2)
        enough = present >= TRIM.min_window_share * length
        total = np.where(there, windows, 0.0).sum(axis=2)
        mean = np.where(enough, total / np.maximum(present, 1), np.nan)
        # What is missing counts as the mean.
        rest = np.where(there, windows - mean[:, :, np.newaxis], 0.0)
        slope = (rest * self._places).sum(axis=2) / self._lever
        power = np.maximum((rest * rest).sum(axis=2) - slope * slope * self._lever, 0.0) / length
        return WindowFit(
            mean=mean.T,
            slope=np.where(enough, slope, np.nan).T,
            power=np.where(enough, power, np.nan).T,
        )


_FLOWN: Final = ("p", "q", "r", "V", "altitude")


class GroundMonitor:
    """Follows one flight tick by tick: airborne, standing still, or surely on the ground.

    Without an aircraft an airspeed decides, and without that all counts as flown. `zero_offsets` of
    p, q, r are to be taken off what they show.
    """

    def __init__(self, aircraft: Aircraft | None, dt: float) -> None:
        self._watch = None if aircraft is None else AirborneDetector(aircraft)
        self._length = round(DETECTION.frame_duration / dt)
        self._frame: list[tuple[float, ...]] = []
        self._frames = 0
        self._still = np.zeros(3)
        self._still_frames = np.zeros(3, dtype=np.int64)
        self.airborne = False
        self.on_ground = False
        self.standing = False
        self.zero_offsets = (0.0, 0.0, 0.0)

    def step(self, values: tuple[float, ...]) -> None:
        """Go on by one tick: p, q, r (rad/s), V (m/s), altitude (m); NaN where missing."""
        self._frame.append(values)
        if len(self._frame) < self._length:
            return
        means = [_window_mean(column) for column in zip(*self._frame, strict=True)]
        self._frame.clear()
        self._frames += 1
        self._decide(means)
        self.on_ground = not self.airborne and self._frames >= TRIM.ground_frames

    def _decide(self, means: list[float]) -> None:
        if self._watch is None:
            self.airborne = not means[3] < TRIM.default_min_airspeed
            self.standing = False
            return
        row = np.full(len(SIGNALS), np.nan)
        row[[SIGNAL_COLUMNS[name] for name in _FLOWN]] = means
        self._watch.add(self._frames * DETECTION.frame_duration, row)
        self.airborne = self._watch.airborne
        self.standing = not self.airborne and bool(self._watch.is_stationary)
        if self.standing:
            self._learn(means[:3])

    def _learn(self, rates: list[float]) -> None:
        there = np.abs(rates) < TRIM.max_zero
        self._still += np.where(there, rates, 0.0)
        self._still_frames += there
        known = self._still_frames >= TRIM.min_zero_frames
        p, q, r = np.where(known, self._still / np.maximum(self._still_frames, 1), 0.0).tolist()
        self.zero_offsets = (p, q, r)


def _window_mean(values: tuple[float, ...]) -> float:
    known = [value for value in values if math.isfinite(value)]
    return sum(known) / len(known) if known else math.nan


# The rate of climb now, from a height that comes late and from accelerations that do not.
# Height is read half a second late and with the noise of a static pressure. So it is followed where
# it is, and accelerations carry the rate of climb on to the present.


class ClimbObserver:
    """Follows the rate of climb tick by tick; NaN where nothing tells it."""

    def __init__(self, dt: float) -> None:
        self._dt = dt
        self._lag = round(CUES.slow_channel_delay / dt)
        self.restart()

    def restart(self) -> None:
        self._filter: TwoStateKalmanFilter | None = None
        self._lifts: deque[float] = deque([0.0] * self._lag, maxlen=self._lag)
        self._unseen = self._astray = 0.0
        self.climb = math.nan

    def step(self, height: float, climb_rate: float, lift: float) -> None:
        """Go on by one tick; NaN where missing.

        Height and rate of climb as they were `CUES.slow_channel_delay` ago; acceleration upwards
        now.
        """
        dt = self._dt
        before = self._lifts[0]
        self._lifts.append(lift if lift == lift else 0.0)
        missing = height != height and climb_rate != climb_rate
        self._unseen = self._unseen + dt if missing else 0.0
        if self._filter is None:
            if not missing:
                self._filter = TwoStateKalmanFilter(
                    (height if height == height else 0.0, 0.0), TRIM.initial_std
                )
            return
        state = self._filter
        if self._unseen > TRIM.climb_timeout:
            self.restart()
            return
        state.predict(
            (state.first + dt * state.second, state.second + dt * before),
            (dt, 0.0),
            (0.0, dt * TRIM.climb_process_noise),
        )
        self._astray = (
            self._astray + dt if abs(height - state.first) > TRIM.max_height_error else 0.0
        )
        if self._astray > TRIM.height_error_time:
            state = self._filter = TwoStateKalmanFilter((height, state.second), TRIM.initial_std)
        elif height == height and not self._astray:
            state.update_first(height, TRIM.height_std**2)
        elif climb_rate == climb_rate:
            state.update_second(climb_rate, TRIM.climb_rate_std**2)
        self.climb = state.second + dt * sum(self._lifts)


_FITTED: Final = (*TURBULENCE_CHANNELS, "V")
_FITTED_PLACES: Final = [TICK_INDEX[name] for name in _FITTED]
_P, _Q, _R, _ALPHA = (TICK_INDEX[name] for name in ("p", "q", "r", "alpha"))
_SPEED, _ALTITUDE = TICK_INDEX["V"], TICK_INDEX["altitude"]


_BANK_SIGNS: Final = ("turn rate", "rate of roll", "lateral acceleration", "beta")
"""What tells of the bank where no attitude is measured."""


class MotionEstimator:
    """Knows the motion tick by tick.

    `fast_rates` are p, q, r over the last 0.3 s; `bank_sources` what tells the bank, in words.
    """

    def __init__(self, aircraft: Aircraft | None, dt: float, tolerances: TrimTolerances) -> None:
        self._aircraft = aircraft
        self._dt = dt
        self._second = round(tolerances.averaging_time / dt)
        usual = (
            TRIM.default_speed if aircraft is None else TRIM.cruise_ratio * flying_speed(aircraft)
        )
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
        self._turns: deque[float] = deque(maxlen=round(TRIM.turn_averaging / self._dt))
        self._rates: deque[Sequence[float]] = deque(maxlen=round(TRIM.rate_averaging / self._dt))
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
            known = speed > TRIM.min_flow_angle_speed and turned == turned
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
    return tuple(text for text, value in zip(_BANK_SIGNS, values, strict=True) if value == value)


def _mean(values: Iterable[float]) -> float:
    """Return the mean of what is there; NaN where much is missing."""
    given = list(values)
    known = [value for value in given if value == value]
    enough = len(known) >= TRIM.min_mean_share * len(given) and known
    return sum(known) / len(known) if enough else math.nan

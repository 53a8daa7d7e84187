"""The noise floor of each channel, from stretches in which nothing but noise is to be seen.

Before take-off the engines run for about 80 s: what the channels then show is vibration, noise
of the instruments and steps of the converter. It is measured in windows of two seconds, each
freed of its straight line (a high-pass at about half a hertz), and the median over the windows
stands against range-check pulses and run-ups.

A record that begins in the air may be one maneuver from end to end. Its noise is what changes
faster than an aircraft moves: fourth differences, whose median neither inputs nor responses reach.
The noise that the aircraft file states counts there as well.

Of a coarse converter most differences are zero: its steps are no noise. One of them is no motion
either.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.flight.maneuvers.dead_instruments import sensor_noise
from gsapp.flight.maneuvers.settings import DETECTION
from gsapp.flight.maneuvers.signals import RATES, SIGNAL_COLUMNS, SIGNALS, SURFACES
from gsapp.quantities import FloatArray

_RATE_COLUMNS = [SIGNAL_COLUMNS[name] for name in RATES]


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseFloor:
    """Standard deviation of what each channel shows when nothing happens."""

    std: Mapping[str, float] = field(default_factory=dict)
    """By channel, SI. A channel without samples is absent."""
    step: Mapping[str, float] = field(default_factory=dict)
    """The step of each channel's converter, SI; 0 where none is seen."""
    source: str = "not measured"
    """Where it was measured, in words."""
    duration: float = 0.0
    """Length of the stretches it was measured in, s."""
    is_final: bool = False
    """Whether it was measured before take-off: no flying changes it any more."""

    def std_of(self, name: str) -> float:
        """Return the standard deviation of a channel; 0 where it is not known."""
        return self.std.get(name, 0.0)

    def least_move(self, name: str, sigmas: float) -> float:
        """Return what neither noise, so many standard deviations, nor one step of rounding is."""
        step = DETECTION.move_over_converter_step * self.step.get(name, 0.0)
        return max(sigmas * self.std_of(name), step)


def window_noise(rows: FloatArray) -> FloatArray:
    """Return the standard deviation about the straight line of each column of even rows.

    NaN counts as missing, and is what comes where less than half of the samples are there.
    """
    count = len(rows)
    place = np.arange(count, dtype=np.float64) - 0.5 * (count - 1)
    there = np.isfinite(rows)
    present = there.sum(axis=0)
    safe = np.maximum(present, 1)
    filled = np.where(there, rows, 0.0)
    mean = filled.sum(axis=0) / safe
    offset = np.where(there, rows - mean, 0.0)
    lever = np.where(there, place[:, None], 0.0)
    lever = np.where(there, lever - lever.sum(axis=0) / safe, 0.0)
    power = (lever * lever).sum(axis=0)
    slope = (lever * offset).sum(axis=0) / np.where(power > 0.0, power, 1.0)
    rest = offset - slope * lever
    variance = (rest * rest).sum(axis=0) / np.maximum(present - 2, 1)
    return np.where(present >= max(0.5 * count, 4), np.sqrt(variance), np.nan)


def fast_noise(rows: FloatArray, rate: float) -> FloatArray:
    """Return the standard deviation of what each column of even rows does faster than a motion.

    From the median of the fourth differences, over samples about `DETECTION.noise_lag` apart;
    surfaces, which step, over neighboring samples. A channel slower than the grid repeats its
    values: its differences are those of the values, if they are smaller. `rate` in 1/s. NaN where
    a column has less than eight differences.
    """
    found = np.full(rows.shape[1], np.nan)
    lag = max(round(DETECTION.noise_lag * rate), 1)
    for place in np.flatnonzero(np.isfinite(rows).any(axis=0)):
        samples = rows[:, place]
        found[place] = _fourth_difference_noise(samples, 1 if place < len(SURFACES) else lag)
        repeated = np.diff(samples, prepend=np.nan) == 0.0
        if repeated.mean() > DETECTION.repeated_share:
            # A comparison with NaN is false: a floor of too few values changes nothing.
            fresh = _fourth_difference_noise(samples[~repeated], 1)
            found[place] = fresh if fresh < found[place] else found[place]
    return found


def _fourth_difference_noise(samples: FloatArray, lag: int) -> float:
    if samples.size <= 4 * lag:
        return math.nan
    steps = samples
    for _ in range(4):
        steps = steps[lag:] - steps[:-lag]
    sizes = np.abs(steps[np.isfinite(steps)])
    # White noise: sqrt(1 + 16 + 36 + 16 + 1) in each, half of them below 0.6745 deviations.
    return float(np.median(sizes)) / (0.6745 * math.sqrt(70.0)) if sizes.size >= 8 else math.nan


class _Resolution:
    """The smallest change of each column so far, and how far it went."""

    def __init__(self) -> None:
        self._step = np.full(len(SIGNALS), np.inf)
        self._low, self._high = self._step.copy(), -self._step

    def add(self, rows: FloatArray) -> None:
        steps = np.abs(np.diff(rows, axis=0))
        # Comparisons with NaN are false: columns without samples stay as they are.
        self._step = np.fmin(self._step, np.where(steps > 0.0, steps, np.inf).min(axis=0))
        self._low = np.fmin(self._low, np.fmin.reduce(rows, axis=0))
        self._high = np.fmax(self._high, np.fmax.reduce(rows, axis=0))

    @property
    def step(self) -> dict[str, float]:
        """Return the step of each column's converter; 0 where it rests between few values."""
        many = self._high - self._low > DETECTION.min_converter_steps * self._step
        return _by_channel(np.where(many, self._step, 0.0))


class NoiseFloorEstimator:
    """Collects windows and says what the noise floor is so far."""

    def __init__(self, aircraft: Aircraft, rate: float, time_scale: float = 1.0) -> None:
        self._stated = sensor_noise(aircraft)
        self._rate = rate
        self._window = DETECTION.noise_window * time_scale  # s of flight time.
        self._ground: list[FloatArray] = []
        self._turning: list[FloatArray] = []
        self._recent: list[tuple[FloatArray, bool]] = []
        self._fast: list[FloatArray] = []
        self._resolution = _Resolution()
        self._flown = False
        self._stood = False
        self._floor: NoiseFloor | None = None

    def add(self, rows: FloatArray, *, airborne: bool, standing: bool | None = None) -> None:
        """Take in one window; `standing` is None where no airspeed tells whether it rolls."""
        self._resolution.add(rows)
        if airborne:
            if not self._flown:
                # The run and the rotation were on the ground still, and were not quiet.
                self._flown = True
                self._recent, self._fast = [], []
            # What was measured on the ground stands.
            if not self._on_ground:
                self._floor = None
                self._keep(self._fast, fast_noise(rows, self._rate))
        elif not self._flown and standing is not False:
            self._floor = None
            self._stood = self._stood or bool(standing)
            noise = window_noise(rows)
            self._keep(self._fast, fast_noise(rows, self._rate))
            # A comparison with a missing engine speed is false.
            self._recent.append(
                (
                    noise,
                    bool((rows[:, SIGNAL_COLUMNS["rpm"]] > DETECTION.engine_running_speed).any()),
                )
            )
            if standing or len(self._recent) > DETECTION.takeoff_windows:
                noise, turning = self._recent.pop(0)
                self._keep(self._turning if turning else self._ground, noise)

    @property
    def floor(self) -> NoiseFloor:
        if self._floor is None:
            self._floor = self._measure()
        return self._floor

    @staticmethod
    def _keep(kept: list[FloatArray], noise: FloatArray) -> None:
        kept.append(noise)
        if len(kept) > DETECTION.max_windows:
            del kept[::2]

    @property
    def _on_ground(self) -> bool:
        return len(self._turning or self._ground) >= DETECTION.min_ground_windows

    def _measure(self) -> NoiseFloor:
        if self._turning:
            running, told = self._turning, " with the engines running"
        else:
            running = _vibrating_windows(self._ground)
            told = " while the gyros shook" if len(running) < len(self._ground) else ""
        # What nothing shows to stand, and never took off, may have flown all the time.
        known = self._flown or self._stood
        if known and len(running) >= DETECTION.min_ground_windows:
            length = self._window * len(running)
            return NoiseFloor(
                std=_by_channel(_ground_noise(np.array(running))),
                step=self._resolution.step,
                source=f"{length:.0f} s before take-off{told}",
                duration=length,
                is_final=self._flown,
            )
        if not self._fast:
            return NoiseFloor()
        length = self._window * len(self._fast)
        found = _by_channel(_column_quantiles(np.array(self._fast), DETECTION.quiet_share))
        return NoiseFloor(
            std={name: max(std, self._stated.get(name, 0.0)) for name, std in found.items()},
            step=self._resolution.step,
            source=f"the fast changes over {length:.0f} s of the record",
            duration=length,
        )


def _vibrating_windows(windows: list[FloatArray]) -> list[FloatArray]:
    """Return the windows in which the gyros shake as they do with engines; all if they never do."""
    if not windows:
        return []
    rates = np.array(windows)[:, _RATE_COLUMNS]
    known = np.isfinite(rates)
    shaking = np.where(known, rates, 0.0).sum(axis=1) / np.maximum(known.sum(axis=1), 1)
    level = float(np.quantile(shaking, 0.75))
    return [window for window, size in zip(windows, shaking, strict=True) if size >= 0.4 * level]


def _ground_noise(windows: FloatArray) -> FloatArray:
    """Return the noise on the ground: engines always shake, surfaces move in the range check."""
    found = _column_quantiles(windows, 0.5)
    calm = [SIGNAL_COLUMNS[name] for name in SURFACES]
    found[calm] = _column_quantiles(windows[:, calm], 0.2)
    return found


def _column_quantiles(windows: FloatArray, share: float) -> FloatArray:
    """Return the value of each column below which a share of its windows lies; NaN for none."""
    # Missing ones are sorted behind all others.
    ordered = np.sort(windows, axis=0)
    present = np.isfinite(windows).sum(axis=0)
    place = (share * np.maximum(present - 1, 0)).astype(np.int64)
    return np.asarray(ordered[place, np.arange(windows.shape[1])])


def _by_channel(values: FloatArray) -> dict[str, float]:
    return {
        name: float(value)
        for name, value in zip(SIGNALS, values, strict=True)
        if math.isfinite(value)
    }

"""Measures of a maneuver that the verdict on its input and its grade are drawn from; limits.

The verdict tells the crew whether to repeat an input; the grade tells how much an estimate can
take from it. Both hold the same measures against the same criteria. What is beyond `invalid` makes
a verdict other than good and is at least a small defect, so that no such input is graded A; a large
defect is always beyond `invalid`, so that an input with one is never good.

The verdict knows more: the amplitude, width and airspeed that were asked for, and what a model
says of gusts. These criteria are its own (`gsapp.excitation.doublets.verdict_criteria`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.dynamics.sensors import flow_at_cg
from gsapp.flight.maneuvers.dead_instruments import clipping_ranges, is_at_range_limit
from gsapp.flight.maneuvers.input_shape import SurfaceInput, smooth_samples
from gsapp.flight.maneuvers.noise_floor import NoiseFloor, window_noise
from gsapp.flight.maneuvers.settings import DETECTION
from gsapp.flight.maneuvers.signals import SIGNAL_COLUMNS, SURFACES
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import DEGREE, GRAVITY

DefectSeverity = Literal["small", "large", "fatal"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Criterion:
    """Bounds of one measure, which is worse the larger it is."""

    small: float
    large: float = math.inf
    """Beyond them it is a small or a large defect of the maneuver; infinite for never."""
    invalid: float | None = None
    """Beyond it the verdict is not good; None where the verdict goes by another measure."""

    def __post_init__(self) -> None:
        if not self.small <= (self.small if self.invalid is None else self.invalid) <= self.large:
            raise ValueError(f"a criterion needs small <= invalid <= large: {self}")

    def severity(self, value: float) -> DefectSeverity | None:
        """Return how severe a defect is; None for none."""
        if value > self.large:
            return "large"
        return "small" if value > self.small else None

    def is_invalid(self, value: float) -> bool:
        return self.invalid is not None and value > self.invalid


@dataclass(frozen=True, slots=True, kw_only=True)
class InputCriteria:
    """The criteria, with their measures."""

    trim_rate: Criterion = Criterion(small=6.0 * DEGREE, large=15.0 * DEGREE)
    """Mean rate about an axis over the second before, rad/s. The verdict goes by
    `trim_tolerance_factor`: 8 deg/s of roll, 6 of pitch and yaw."""
    trim_tolerance_factor: float = 2.0
    """Times the tolerances of the trim cue within which a start still counts: GO asks for more
    than an estimate needs."""
    trim_load_factor: float = 0.25
    """Mean deviation from 1 g over the second before, g: a small defect."""
    throttle_change: float = 0.15
    """Throttle moved: a small defect."""
    min_amplitude: float = 0.03
    """Share of half of the travel, as the aircraft file states it, below which an input is a large
    defect."""
    faint_response: float = 12.0
    weak_response: float = 25.0
    """Peak-to-peak response over the noise floor below which it is a large or a small defect. The
    amplitudes that the verdict calls too small follow from them."""
    cross_input: Criterion = Criterion(small=0.35, invalid=0.35, large=0.7)
    """Largest excursion of another surface over the amplitude of the main one, both as shares of
    their travel."""
    least_cross_input: float = 0.5 * DEGREE
    """rad; another surface that moves less counts for nothing, however small the input was."""
    residual_deflection: Criterion = Criterion(small=0.4, invalid=0.4)
    """How far a surface stayed from where it began, share of its amplitude."""
    hands_off_lack: Criterion = Criterion(small=0.0, invalid=0.5, large=0.5)
    """Missing share of the hands-off interval that is wanted: of the target input, or
    `DETECTION.min_free_response_time`. Half of it is one period of the oscillation."""
    time_out_of_range: float = 0.1
    """Time out of the linear range of alpha, beta or a_n, s: a small defect, and invalid."""
    clipped_share: Criterion = Criterion(small=0.0, large=0.05)
    """Share of the samples at an end of the instrument's range."""
    clipped_time: float = 0.03
    """Time at an end of the range, from the input on, from which the verdict is not good, s."""
    missing_samples: Criterion = Criterion(small=0.1, invalid=0.2)
    """Missing share of the samples of a channel."""
    pre_input_motion: Criterion = Criterion(small=0.25, invalid=0.6, large=0.6)
    """Motion before the input over the response, both as standard deviations."""
    gust_fraction: float = 0.5
    """Share of the response that gusts may make, by the model; then up to `gust_factor` times
    the motion before the input."""
    gust_factor: float = 3.0
    """A model that is wrong finds gusts in calm air. Gusts are slow, and within two seconds most
    of them are hidden in a straight line."""


INPUT_CRITERIA: Final = InputCriteria()
"""Tuned by `bench verdicts` on seeds below 17,000."""


RESPONSE_CHANNELS = {
    "de": ("q", "an", "alpha"),
    "da": ("p", "r"),
    "dr": ("r", "ay", "p", "beta"),
    "flap": ("an", "q", "alpha", "ax"),
    "throttle": ("ax", "q", "an"),
}
"""What answers to each control."""
COUPLED_SURFACE = {"da": "dr", "dr": "da"}
"""The surface that answers in the same channels: nobody sees there which of the two it was."""


def time_scale_of(aircraft: Aircraft) -> float:
    """Return how many times slower an aircraft moves than the one `DETECTION` was tuned on.

    By Froude's law times go with the root of the length; a smaller aircraft counts as that one,
    since its pilot is no faster. Detection and grades of a large aircraft work in flight time over
    this factor.
    """
    return max(math.sqrt(aircraft.geometry.chord / DETECTION.reference_chord), 1.0)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GradingContext:
    """What a maneuver is judged against: the aircraft and what its channels show at rest."""

    aircraft: Aircraft
    noise: NoiseFloor
    time_scale: float = 1.0
    """Flight time over the time that samples are given in; see `time_scale_of`."""

    def half_travel(self, surface: str) -> float:
        """Return half of the travel of a surface, rad; of the throttle's, 0 to 1."""
        if surface == "throttle":
            return 0.5
        low, high = getattr(self.aircraft.controls, surface).travel
        return 0.5 * float(high - low)

    def least_move(self, surface: str) -> float:
        """Return what a surface goes at least in a rapid move, rad, whatever its noise.

        A share of its travel; of an assumed travel, which may be ten times the true one, less.
        """
        stated = "travel" in getattr(self.aircraft.controls, surface).model_fields_set
        share = DETECTION.min_rapid_move if stated else DETECTION.min_rapid_move_assumed_travel
        return share * self.half_travel(surface)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ManeuverSamples:
    """The samples of one maneuver with a bit of what came before."""

    times: FloatArray
    rows: FloatArray
    t_input: float
    t_input_end: float
    t_end: float
    """s."""

    def samples(self, name: str, start: float, stop: float) -> FloatArray:
        """Return the samples of a signal that are there from start to stop, s."""
        low, high = np.searchsorted(self.times, (start, stop))
        found = self.rows[low:high, SIGNAL_COLUMNS[name]]
        return found[np.isfinite(found)]

    def count(self, start: float, stop: float) -> int:
        """Return the number of samples from start to stop, s, missing ones included."""
        low, high = np.searchsorted(self.times, (start, stop))
        return int(high - low)

    def mean_at_trim(self, name: str) -> float:
        """Return the mean in the stretch of trim; NaN without a sample."""
        found = self.samples(name, self.t_input - DETECTION.trim_time, self.t_input)
        if not found.size:
            # A record that begins with its input: what it began in is as near as it gets.
            begin = float(self.times[0])
            found = self.samples(name, begin, begin + DETECTION.look_back)
        return float(found.mean()) if found.size else math.nan


def linear_ranges(aircraft: Aircraft) -> dict[str, tuple[float, float]]:
    """Return the ranges of alpha, beta (rad) and a_n (m/s^2) in which the model is linear."""
    limits = aircraft.limits
    return {
        "alpha": limits.alpha_linear,
        "beta": (-limits.beta_linear, limits.beta_linear),
        "an": limits.load_factor,
    }


def measure_response(
    passage: ManeuverSamples, setting: GradingContext, surfaces: Sequence[str]
) -> dict[str, float]:
    """Return how far each channel went in answer to these surfaces, over its noise floor.

    Peak-to-peak change, slower than 0.05 s, in standard deviations of the noise floor; channels
    without samples are absent.
    """
    found: dict[str, float] = {}
    dt = float(np.median(np.diff(passage.times))) if passage.times.size > 1 else 0.01
    stop = min(passage.t_input_end + DETECTION.response_time, float(passage.times[-1]))
    for name in dict.fromkeys(name for surface in surfaces for name in RESPONSE_CHANNELS[surface]):
        samples = passage.samples(name, passage.t_input, stop)
        if samples.size < 5:
            continue
        noise = max(setting.noise.std_of(name), MIN_NOISE[name])
        found[name] = float(np.ptp(smooth_samples(samples, dt))) / noise
    return found


MIN_NOISE: Mapping[str, float] = {
    **dict.fromkeys(("p", "q", "r"), 0.2 * DEGREE),
    **dict.fromkeys(("alpha", "beta"), 0.1 * DEGREE),
    **dict.fromkeys(("ax", "ay", "an"), 0.005 * GRAVITY),
}
"""Better than this no instrument of such an aircraft is; keeps an ideal one from infinity."""


def clipped_samples(
    passage: ManeuverSamples, aircraft: Aircraft, start: float, stop: float
) -> dict[str, tuple[int, int]]:
    """Return how many samples of each instrument that clips are at its limit, and of how many."""
    found = {}
    for name, limits in clipping_ranges(aircraft).items():
        samples = passage.samples(name, start, stop)
        count = int(is_at_range_limit(samples, limits).sum())
        if count:
            found[name] = (count, samples.size)
    return found


def pre_input_motion_ratio(
    passage: ManeuverSamples, setting: GradingContext, surfaces: Sequence[str]
) -> tuple[float, str]:
    """Compare what the aircraft did before the input with what it did in answer.

    Returns the largest ratio of the answering channels (standard deviation before the input, beyond
    the noise floor, over that of the answer) and which one; empty for none.
    """
    worst, channel = 0.0, ""
    for name in dict.fromkeys(name for surface in surfaces for name in RESPONSE_CHANNELS[surface]):
        before = passage.samples(name, passage.t_input - 2.0 * DETECTION.trim_time, passage.t_input)
        after = passage.samples(
            name, passage.t_input, passage.t_input_end + DETECTION.response_time
        )
        if before.size < 20 or after.size < 5:
            continue
        # What the noise floor explains is no turbulence.
        std = float(window_noise(before[:, None])[0])
        size = math.sqrt(max(std**2 - setting.noise.std_of(name) ** 2, 0.0))
        ratio = size / max(float(after.std()), 1e-12)
        if ratio > worst:
            worst, channel = ratio, name
    return worst, channel


def level_of(passage: ManeuverSamples, surface: str, start: float, stop: float) -> float:
    """Return the median of a surface from start to stop, s; NaN without a sample."""
    samples = passage.samples(surface, start, stop)
    return float(np.median(samples)) if samples.size else math.nan


def residual_deflection(passage: ManeuverSamples, one: SurfaceInput) -> float:
    """Return how far a surface stayed from where it began, share of its amplitude."""
    start, stop = (one.t_end + wait for wait in DETECTION.rest_after_input)
    after = level_of(passage, one.surface, start, min(stop, passage.t_end))
    if not math.isfinite(after):
        after = one.trim_after
    return abs(after - one.trim_before) / max(one.amplitude, 1e-9)


def cross_deflections(passage: ManeuverSamples, inputs: Sequence[SurfaceInput]) -> dict[str, float]:
    """Return how far each surface that should rest went from where it was, rad."""
    found = {}
    dt = float(np.median(np.diff(passage.times)))
    moved = {one.surface for one in inputs}
    for surface in SURFACES:
        if surface in moved:
            continue
        level = level_of(passage, surface, passage.t_input - DETECTION.trim_time, passage.t_input)
        samples = passage.samples(surface, passage.t_input, passage.t_end)
        if samples.size >= 5 and math.isfinite(level):
            found[surface] = float(np.max(np.abs(smooth_samples(samples, dt) - level)))
    return found


def cross_input_ratios(
    moved: Mapping[str, float], setting: GradingContext, inputs: Sequence[SurfaceInput]
) -> dict[str, float]:
    """Return `cross_deflections` over the main input, as shares of travel, the largest first.

    What moved too little to count is left out.
    """
    travel = setting.half_travel
    whole = max(one.amplitude / travel(one.surface) for one in inputs)
    return {
        surface: size / travel(surface) / whole
        for surface, size in sorted(moved.items(), key=lambda item: -item[1])
        if size > INPUT_CRITERIA.least_cross_input
    }


def flow_history(passage: ManeuverSamples, aircraft: Aircraft) -> dict[str, FloatArray]:
    """Return alpha and beta at the CG, and a_n, of the whole passage, slower than 0.05 s."""
    column = {
        name: passage.rows[:, SIGNAL_COLUMNS[name]] for name in ("V", "alpha", "beta", *"pqr", "an")
    }
    speed = column["V"]
    alpha, beta = column["alpha"], column["beta"]
    if np.isfinite(speed).any():
        # What is missing beside the vane itself makes a small correction smaller.
        steady = np.where(np.isfinite(speed), speed, np.nanmedian(speed))
        rates = [np.nan_to_num(column[name]) for name in "pqr"]
        vanes = [np.nan_to_num(column[name]) for name in ("alpha", "beta")]
        _, attack, slip = flow_at_cg(
            aircraft, np.maximum(steady, 1.0), vanes[0], vanes[1], (rates[0], rates[1], rates[2])
        )
        alpha = np.where(np.isfinite(alpha), attack, np.nan)
        beta = np.where(np.isfinite(beta), slip, np.nan)
    dt = float(np.median(np.diff(passage.times)))
    found = {"alpha": alpha, "beta": beta, "an": column["an"]}
    return {name: smooth_samples(np.asarray(values), dt) for name, values in found.items()}


def is_out_of_range(values: FloatArray, limits: tuple[float, float], dt: float) -> bool:
    """Return whether samples of the flow lie out of the linear range for long enough to count."""
    with np.errstate(invalid="ignore"):
        count = int(((values < limits[0]) | (values > limits[1])).sum())
    return count * dt >= INPUT_CRITERIA.time_out_of_range

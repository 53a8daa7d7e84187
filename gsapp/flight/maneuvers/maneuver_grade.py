"""How good a maneuver is for estimating derivatives, judged from its own samples.

Each defect is small, large or fatal. None gives an A, one small one a B; several small ones or a
large one a C; a fatal one, or two large ones, a D.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.flight.maneuvers.clipping import clipping_ranges, is_at_range_limit
from gsapp.flight.maneuvers.detected_maneuver import Grade
from gsapp.flight.maneuvers.input_shape import SurfaceInput, smooth_samples
from gsapp.flight.maneuvers.noise_floor import NoiseFloor
from gsapp.flight.maneuvers.settings import DETECTION
from gsapp.flight.maneuvers.signals import SIGNAL_COLUMNS, SURFACES
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import DEGREE, GRAVITY

DefectSeverity = Literal["small", "large", "fatal"]

RESPONSE_CHANNELS = {"de": ("q", "an", "alpha"), "da": ("p", "r"), "dr": ("r", "ay", "p", "beta")}
"""What answers to each surface."""
COUPLED_SURFACE = {"da": "dr", "dr": "da"}
"""The surface that answers in the same channels: nobody sees there which of the two it was."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Defect:
    """One thing that speaks against a maneuver."""

    severity: DefectSeverity
    text: str


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GradingContext:
    """What a maneuver is judged against: the aircraft and what its channels show at rest."""

    aircraft: Aircraft
    noise: NoiseFloor

    def half_travel(self, surface: str) -> float:
        """Return half of the travel of a surface, rad."""
        low, high = getattr(self.aircraft.controls, surface).travel
        return 0.5 * float(high - low)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ManeuverSamples:
    """The samples of one maneuver with a bit of what came before.

    Attributes
    ----------
    times : ndarray, shape (n,)
    rows : ndarray, shape (n, len(SIGNALS))
    t_input, t_input_end, t_end : float
        s.
    """

    times: FloatArray
    rows: FloatArray
    t_input: float
    t_input_end: float
    t_end: float

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

    Returns
    -------
    dict
        Channel to peak-to-peak change, slower than 0.05 s, in standard deviations of its noise
        floor; channels without samples are absent.
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


def grade_maneuver(
    passage: ManeuverSamples, setting: GradingContext, inputs: Sequence[SurfaceInput]
) -> tuple[Grade, tuple[str, ...]]:
    """Grade a maneuver.

    Parameters
    ----------
    passage : ManeuverSamples
    setting : GradingContext
    inputs : sequence of SurfaceInput
        What was moved on purpose; the main one first.

    Returns
    -------
    grade : {"A", "B", "C", "D"}
    reasons : tuple of str
        The worst first.
    """
    if not inputs:
        text = "no surface moved beyond its noise: no excitation"
        return "D", (text,)
    surfaces = [one.surface for one in inputs]
    defects = [
        *_trim(passage),
        *_amplitude(passage, setting, inputs[0]),
        *_excitation(passage, setting, surfaces),
        *_clipping(passage, setting),
        *_missing_samples(passage, surfaces),
        *_lost_coupled_surfaces(passage, setting, surfaces),
        *_other_inputs(passage, setting, inputs),
        *_turbulence(passage, setting, surfaces),
        *_free_response(passage),
    ]
    order: dict[DefectSeverity, int] = {"fatal": 0, "large": 1, "small": 2}
    defects.sort(key=lambda defect: order[defect.severity])
    return _grade(defects), tuple(defect.text for defect in defects)


def _grade(defects: Sequence[Defect]) -> Grade:
    count = {name: sum(d.severity == name for d in defects) for name in ("small", "large", "fatal")}
    if count["fatal"] or count["large"] >= 2:
        return "D"
    if count["large"] or count["small"] >= 2:
        return "C"
    return "B" if count["small"] else "A"


def _trim(passage: ManeuverSamples) -> list[Defect]:
    found = []
    for name, words in (("p", "rolling"), ("q", "pitching"), ("r", "yawing")):
        rate = passage.mean_at_trim(name)
        if abs(rate) > DETECTION.max_trim_rate:
            found.append(
                Defect(
                    severity="large" if abs(rate) > DETECTION.max_rate_before_input else "small",
                    text=f"not trimmed at the start: {words} at {rate / DEGREE:.0f} deg/s",
                )
            )
    load = passage.samples("an", passage.t_input - DETECTION.trim_time, passage.t_input)
    if load.size and abs(float(load.mean()) / GRAVITY - 1.0) > 0.25:
        found.append(
            Defect(
                severity="small",
                text=f"not trimmed at the start: a_n is {load.mean() / GRAVITY:.2f} g",
            )
        )
    throttle = passage.samples("throttle", passage.t_input - DETECTION.trim_time, passage.t_end)
    if throttle.size and float(np.ptp(throttle)) > 0.15:
        found.append(
            Defect(
                severity="small",
                text=f"throttle moved by {100.0 * float(np.ptp(throttle)):.0f} %",
            )
        )
    return found


def _amplitude(
    passage: ManeuverSamples, setting: GradingContext, main: SurfaceInput
) -> list[Defect]:
    found = []
    travel = setting.half_travel(main.surface)
    if main.amplitude < 0.03 * travel:
        found.append(
            Defect(
                severity="large",
                text=f"{main.surface} moved {main.amplitude / DEGREE:.1f} deg only",
            )
        )
    for name, (low, high) in linear_ranges(setting.aircraft).items():
        unit, words = (GRAVITY, "g") if name == "an" else (DEGREE, "deg")
        samples = passage.samples(name, passage.t_input, passage.t_end)
        if samples.size < 5:
            continue
        # A twentieth of the samples at either end is left to noise and gusts.
        least, most = np.quantile(samples, (0.05, 0.95))
        if least < low or most > high:
            worst = float(least if low - least > most - high else most)
            found.append(
                Defect(
                    severity="small",
                    text=f"too large: {name} reached {worst / unit:.1f} {words}, beyond the linear "
                    f"range of {low / unit:.0f} to {high / unit:.0f}",
                )
            )
    return found


def _excitation(
    passage: ManeuverSamples, setting: GradingContext, surfaces: Sequence[str]
) -> list[Defect]:
    found = []
    for surface in surfaces:
        answered = measure_response(passage, setting, [surface])
        if not answered:
            names = ", ".join(RESPONSE_CHANNELS[surface])
            found.append(
                Defect(severity="fatal", text=f"no response to {surface} was measured: no {names}")
            )
            continue
        best = max(answered, key=lambda name: answered[name])
        size = answered[best]
        if size < DETECTION.weak_response:
            found.append(
                Defect(
                    severity="large" if size < DETECTION.faint_response else "small",
                    text=f"too small: {best} answered {surface} with {size:.0f} times its noise "
                    f"({DETECTION.faint_response:.0f} is little, "
                    f"{DETECTION.weak_response:.0f} enough)",
                )
            )
    return found


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


def _clipping(passage: ManeuverSamples, setting: GradingContext) -> list[Defect]:
    start = passage.t_input - DETECTION.trim_time
    clipped = clipped_samples(passage, setting.aircraft, start, passage.t_end)
    return [
        Defect(
            severity="small" if count < 0.05 * total else "large",
            text=f"{name} clipped in {count} samples ({100.0 * count / total:.0f} %)",
        )
        for name, (count, total) in clipped.items()
    ]


def _missing_samples(passage: ManeuverSamples, surfaces: Sequence[str]) -> list[Defect]:
    start, stop = passage.t_input - DETECTION.trim_time, passage.t_end
    total = passage.count(start, stop)
    names = dict.fromkeys(
        name for surface in surfaces for name in (surface, *RESPONSE_CHANNELS[surface])
    )
    found = []
    if total < DETECTION.min_graded_samples:
        found.append(Defect(severity="fatal", text=f"{total} samples are too few for an estimate"))
    absent = []
    for name in names:
        samples = passage.samples(name, start, stop)
        if not samples.size:
            absent.append(name)
        elif samples.size < 0.9 * total:
            share = 100.0 * (1.0 - samples.size / total)
            found.append(Defect(severity="small", text=f"{share:.0f} % of {name} is missing"))
        elif samples.size > 20 and not float(np.ptp(samples)) > 0.0:
            found.append(
                Defect(severity="large", text=f"{name} is constant: its sensor appears stuck")
            )
    if absent:
        found.append(Defect(severity="small", text=f"not measured: {', '.join(absent)}"))
    return found


def _lost_coupled_surfaces(
    passage: ManeuverSamples, setting: GradingContext, surfaces: Sequence[str]
) -> list[Defect]:
    """Return the partners of the inputs that were measured before, and no more in the maneuver."""
    partners = dict.fromkeys(COUPLED_SURFACE[one] for one in surfaces if one in COUPLED_SURFACE)
    return [
        Defect(
            severity="fatal",
            text=f"{name} was lost: its share of the response is unknown",
        )
        for name in partners
        if name in setting.noise.std
        and not passage.samples(name, passage.t_input - DETECTION.trim_time, passage.t_end).size
    ]


def _other_inputs(
    passage: ManeuverSamples, setting: GradingContext, inputs: Sequence[SurfaceInput]
) -> list[Defect]:
    main = inputs[0]
    whole = main.amplitude / setting.half_travel(main.surface)
    found = []
    for surface in SURFACES:
        if surface in {one.surface for one in inputs}:
            continue
        samples = passage.samples(surface, passage.t_input - 0.2, passage.t_end)
        if samples.size < 5:
            continue
        moved = 0.5 * float(np.ptp(np.quantile(samples, (0.02, 0.98))))
        share = moved / setting.half_travel(surface) / whole
        if share > 0.2 and moved > max(6.0 * setting.noise.std_of(surface), 0.5 * DEGREE):
            found.append(
                Defect(
                    severity="small" if share < 0.5 else "large",
                    text=f"{surface} moved as well, by {moved / DEGREE:.1f} deg",
                )
            )
    return found


def pre_input_motion_ratio(
    passage: ManeuverSamples, setting: GradingContext, surfaces: Sequence[str]
) -> tuple[float, str]:
    """Compare what the aircraft did before the input with what it did in answer.

    Returns
    -------
    ratio : float
        Largest of the answering channels: standard deviation before the input, beyond the noise
        floor, over that of the answer.
    channel : str
        Which one; empty for none.
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
        size = math.sqrt(max(_detrended_std(before) ** 2 - setting.noise.std_of(name) ** 2, 0.0))
        ratio = size / max(float(after.std()), 1e-12)
        if ratio > worst:
            worst, channel = ratio, name
    return worst, channel


def _turbulence(
    passage: ManeuverSamples, setting: GradingContext, surfaces: Sequence[str]
) -> list[Defect]:
    worst, channel = pre_input_motion_ratio(passage, setting, surfaces)
    if worst < 0.25:
        return []
    return [
        Defect(
            severity="small" if worst < 0.6 else "large",
            text=f"turbulence before the input: {channel} wandered by {100.0 * worst:.0f} % of "
            "its response",
        )
    ]


def _detrended_std(samples: FloatArray) -> float:
    """Return the standard deviation about the straight line."""
    place = np.linspace(-1.0, 1.0, samples.size)
    offset = samples - samples.mean()
    slope = float((place * offset).sum() / (place * place).sum())
    return float((offset - slope * place).std())


def _free_response(passage: ManeuverSamples) -> list[Defect]:
    free = passage.t_end - passage.t_input_end
    if free >= DETECTION.min_free_response_time:
        return []
    return [
        Defect(
            severity="small" if free >= 0.5 * DETECTION.min_free_response_time else "large",
            text=f"hands off for {max(free, 0.0):.1f} s only after the input",
        )
    ]

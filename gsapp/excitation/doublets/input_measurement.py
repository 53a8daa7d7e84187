"""What an input was like: sizes, times, the trim it began in, what it did, what else moved."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.decoding import air_data
from gsapp.dynamics.atmosphere import SEA_LEVEL_DENSITY
from gsapp.excitation.doublets.flight_context import SignalHistory
from gsapp.excitation.doublets.gust_analysis import GUST_ANALYSIS_CHANNELS, GustAnalyzer
from gsapp.excitation.settings import CUES, DOUBLETS
from gsapp.excitation.trim.bank_observer import BankObserver
from gsapp.flight.maneuvers.airborne_detection import flying_speed
from gsapp.flight.maneuvers.input_measures import (
    INPUT_CRITERIA,
    GradingContext,
    ManeuverSamples,
    clipped_samples,
    cross_deflections,
    flow_history,
    residual_deflection,
)
from gsapp.flight.maneuvers.input_shape import SurfaceInput, smooth_samples
from gsapp.flight.maneuvers.settings import DETECTION
from gsapp.flight.maneuvers.signals import SIGNAL_COLUMNS, SURFACES
from gsapp.quantities import FloatArray


def measure_step_durations(passage: ManeuverSamples, one: SurfaceInput) -> tuple[float, ...]:
    """Return the length of each step of an input, s."""
    low, high = np.searchsorted(
        passage.times, (one.t_start - DOUBLETS.edge_search, one.t_end + DOUBLETS.edge_search)
    )
    times, samples = passage.times[low:high], passage.rows[low:high, SIGNAL_COLUMNS[one.surface]]
    there = np.isfinite(samples)
    times, samples = times[there], samples[there]
    lengths = tuple(length for _, length in one.excursions)
    if times.size < 3:
        return lengths
    level = smooth_samples(samples, float(np.median(np.diff(times))))
    peaks = _peaks(times, level, one)
    heights = [one.trim_before, *(float(level[place]) for place in peaks), one.trim_after]
    middles = [0.5 * (former + next_) for former, next_ in pairwise(heights)]
    edges = [_crossed(times, level, middles[0], peaks[0], -1)]
    edges += [
        _crossed(times, level, *one_edge, 1) for one_edge in zip(middles[1:], peaks, strict=True)
    ]
    found = tuple(later - former for former, later in pairwise(edges))
    return found if min(found) > 0.0 else lengths


def _peaks(times: FloatArray, level: FloatArray, one: SurfaceInput) -> list[int]:
    ends = accumulate((length for _, length in one.excursions), initial=one.t_start)
    found = []
    for (side, _), (start, stop) in zip(one.excursions, pairwise(ends), strict=True):
        low, high = np.searchsorted(times, (start, stop))
        low = min(int(low), times.size - 1)
        found.append(low + int(np.argmax(side * level[low : max(int(high), low + 1)])))
    return found


def _crossed(
    times: FloatArray, level: FloatArray, middle: float, peak: int, direction: int
) -> float:
    """Return when the level passed a value next to a peak, after it (1) or before it (-1), s."""
    beyond = (level - middle) * np.sign(level[peak] - middle)
    outside = np.flatnonzero(beyond <= 0.0)
    outside = outside[outside > peak] if direction > 0 else outside[outside < peak]
    if not outside.size:
        return float(times[-1 if direction > 0 else 0])
    place = int(outside[0] if direction > 0 else outside[-1])
    inner = place - direction
    share = beyond[inner] / (beyond[inner] - beyond[place])
    return float(times[inner] + share * (times[place] - times[inner]))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MeasuredInput:
    """An input with its hands-off interval, measured."""

    passage: ManeuverSamples
    """The samples."""
    inputs: tuple[SurfaceInput, ...]
    """In the order in which they began."""
    steps: Mapping[str, tuple[float, ...]]
    """How long each step of each input lasted, s."""
    symmetry: Mapping[str, float]
    """Smaller over larger side of each input by area."""
    residual_deflection: Mapping[str, float]
    """How far each surface stayed from where it began, share of its amplitude."""
    cross_deflections: Mapping[str, float]
    """Largest excursion of each other surface, rad."""
    trim_values: Mapping[str, float]
    """Means over the second before: ``p``, ``q``, ``r``, ``bank``, ``V``, ``alpha``; SI, at the CG;
    what was not measured is absent."""
    bank_is_measured: bool
    """Whether the bank comes from measured attitude."""
    flow: Mapping[str, FloatArray]
    """``alpha``, ``beta`` at the CG (rad) and ``an`` (m/s^2) from input to end, slower than 0.05 s;
    without samples absent."""
    clipped: Mapping[str, int]
    """Samples at the end of the range of each instrument that clipped."""
    saturated_before: tuple[str, ...]
    """Instruments that stood at the end of their range before the input too."""
    gust_fraction: float | None
    """What gusts did, as a share of the answer without them; None where no model tells."""
    rate_switch: float | None
    """As measured."""

    @property
    def surfaces(self) -> tuple[str, ...]:
        return tuple(one.surface for one in self.inputs)

    @property
    def hands_off_time(self) -> float:
        """Return how long the hands were off, s."""
        return self.passage.t_end - self.passage.t_input_end


def measure_input(
    history: SignalHistory,
    inputs: Sequence[SurfaceInput],
    t_end: float,
    setting: GradingContext,
    explainer: GustAnalyzer | None,
) -> MeasuredInput:
    """Measure an input whose hands-off interval is over; the history reaches to its end."""
    ordered = tuple(sorted(inputs, key=lambda one: one.t_start))
    t_input = ordered[0].t_start
    t_input_end = max(one.t_end for one in ordered)
    times, rows = history.segment(t_input - DOUBLETS.pre_input_time, t_end)
    passage = ManeuverSamples(
        times=times,
        rows=rows,
        t_input=t_input,
        t_input_end=t_input_end,
        t_end=max(t_end, t_input_end),
    )
    clipped, stuck = _clipped(passage, setting)
    flow = flow_history(passage, setting.aircraft)
    trim = {
        name: value
        for name in ("p", "q", "r", "V")
        if math.isfinite(value := passage.mean_at_trim(name))
    }
    before = passage.times < t_input
    calm = flow["alpha"][before & (passage.times >= t_input - DETECTION.trim_time)]
    if np.isfinite(calm).any():
        trim["alpha"] = float(np.nanmean(calm))
    bank, bank_seen = _bank(history, t_input, setting.aircraft)
    if bank is not None:
        trim["bank"] = bank
    cross = cross_deflections(passage, ordered)
    switch = history.extra_channel("rate_switch", t_input - 1.0, t_end)
    return MeasuredInput(
        passage=passage,
        inputs=ordered,
        steps={one.surface: measure_step_durations(passage, one) for one in ordered},
        symmetry={one.surface: _symmetry(passage, one) for one in ordered},
        residual_deflection={one.surface: residual_deflection(passage, one) for one in ordered},
        cross_deflections=cross,
        trim_values=trim,
        bank_is_measured=bank_seen,
        flow={
            name: values[~before]
            for name, values in flow.items()
            if np.isfinite(values[~before]).sum() >= 5
        },
        clipped=clipped,
        saturated_before=stuck,
        gust_fraction=_gusts(passage, ordered, history, setting, explainer, stuck, cross),
        rate_switch=float(np.nanmedian(switch)) if np.isfinite(switch).any() else None,
    )


def _symmetry(passage: ManeuverSamples, one: SurfaceInput) -> float:
    samples = passage.samples(one.surface, one.t_start, one.t_end) - one.trim_before
    sides = sorted((float(samples[samples > 0.0].sum()), float(-samples[samples < 0.0].sum())))
    return sides[0] / sides[1] if sides[1] > 0.0 else 0.0


def _bank(history: SignalHistory, t_input: float, aircraft: Aircraft) -> tuple[float | None, bool]:
    """Return the mean bank over the second before, rad, and whether attitude tells it."""
    attitude = history.extra_channel("phi", t_input - DETECTION.trim_time, t_input)
    if np.isfinite(attitude).sum() > 0.5 * attitude.size > 0:
        return float(np.nanmean(attitude)), True
    times, rows = history.segment(t_input - DOUBLETS.bank_history, t_input)
    step = max(round(CUES.tick / float(np.median(np.diff(times)))), 1) if times.size > 2 else 1
    observer = BankObserver(CUES.tick, flying_speed(aircraft))
    seen = []
    for low in range(0, times.size - step + 1, step):
        part = rows[low : low + step]
        there = np.isfinite(part)
        sums = np.where(there, part, 0.0).sum(axis=0)
        counts = there.sum(axis=0)
        mean = np.where(counts > 0, sums / np.maximum(counts, 1), np.nan)
        p, q, r, ax, ay, V, beta = (
            float(mean[SIGNAL_COLUMNS[name]]) for name in ("p", "q", "r", "ax", "ay", "V", "beta")
        )
        observer.step((p, q, r), ax, ay, V, beta, DOUBLETS.default_gusts)
        if times[low] >= t_input - DETECTION.trim_time and math.isfinite(observer.bank):
            seen.append(observer.bank)
    return (sum(seen) / len(seen) if seen else None), False


def _clipped(
    passage: ManeuverSamples, setting: GradingContext
) -> tuple[dict[str, int], tuple[str, ...]]:
    start, begun = passage.t_input - DETECTION.trim_time, passage.t_input
    before = clipped_samples(passage, setting.aircraft, start, begun)
    stuck = tuple(name for name, (count, total) in before.items() if count > 0.5 * total)
    after = clipped_samples(passage, setting.aircraft, begun, passage.t_end)
    return {name: count for name, (count, _) in after.items() if name not in stuck}, stuck


def _gusts(
    passage: ManeuverSamples,
    inputs: Sequence[SurfaceInput],
    history: SignalHistory,
    setting: GradingContext,
    explainer: GustAnalyzer | None,
    stuck: Sequence[str],
    cross: Mapping[str, float],
) -> float | None:
    """Return what gusts did, as a share of the answer without them."""
    speed = passage.mean_at_trim("V")
    if explainer is None or not math.isfinite(speed):
        return None
    low = int(np.searchsorted(passage.times, passage.t_input))
    names = [
        name
        for name in (*GUST_ANALYSIS_CHANNELS["longitudinal"], *GUST_ANALYSIS_CHANNELS["lateral"])
        if name not in stuck
    ]
    moved = {one.surface for one in inputs}
    moved |= {name for name, size in cross.items() if size > INPUT_CRITERIA.least_cross_input}
    return explainer.gust_fraction(
        {
            name: _fill_gaps(passage.rows[low:, SIGNAL_COLUMNS[name]])
            for name in SURFACES
            if name in moved
        },
        {name: passage.rows[low:, SIGNAL_COLUMNS[name]] for name in names},
        [one.surface for one in inputs],
        trim={name: start for name in names if (start := _mean_before(passage, name)) is not None},
        speed=speed,
        density=_density(history, passage),
        noise=setting.noise,
    )


def _mean_before(passage: ManeuverSamples, name: str) -> tuple[float, float] | None:
    mean = passage.mean_at_trim(name)
    at = passage.samples(name, passage.t_input - DOUBLETS.initial_state_time, passage.t_input)
    return (mean, float(at.mean())) if math.isfinite(mean) and at.size else None


def _fill_gaps(samples: FloatArray) -> FloatArray:
    there = np.isfinite(samples)
    if there.all() or not there.any():
        return samples
    place = np.arange(samples.size)
    return np.interp(place, place[there], samples[there])


def _density(history: SignalHistory, passage: ManeuverSamples) -> float:
    """Return the density of the air, kg/m^3, as far as it was measured."""
    start, stop = passage.t_input - DETECTION.trim_time, passage.t_end
    given = history.extra_channel("density", start, stop)
    if not np.isfinite(given).any():
        given = air_data.density(
            history.extra_channel("static_pressure", start, stop),
            history.extra_channel("temperature", start, stop),
        )
    return float(np.nanmedian(given)) if np.isfinite(given).any() else SEA_LEVEL_DENSITY

"""How good a maneuver is for estimating derivatives, judged from its own samples.

Each defect is small, large or fatal, by the criteria that the verdict in flight goes by too
(`gsapp.flight.maneuvers.input_measures`). None gives an A, one small one a B; several small ones
or a large one a C; a fatal one, or two large ones, a D.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gsapp.flight.maneuvers.detected_maneuver import Grade
from gsapp.flight.maneuvers.input_measures import (
    COUPLED_SURFACE,
    INPUT_CRITERIA,
    RESPONSE_CHANNELS,
    DefectSeverity,
    GradingContext,
    ManeuverSamples,
    clipped_samples,
    cross_deflections,
    cross_input_ratios,
    flow_history,
    is_out_of_range,
    linear_ranges,
    measure_response,
    pre_input_motion_ratio,
    residual_deflection,
)
from gsapp.flight.maneuvers.input_shape import SurfaceInput
from gsapp.flight.maneuvers.settings import DETECTION
from gsapp.flight.maneuvers.signals import SURFACES
from gsapp.quantities.constants import DEGREE, GRAVITY


@dataclass(frozen=True, slots=True, kw_only=True)
class Defect:
    """One thing that speaks against a maneuver."""

    severity: DefectSeverity
    text: str


def grade_maneuver(
    passage: ManeuverSamples, setting: GradingContext, inputs: Sequence[SurfaceInput]
) -> tuple[Grade, tuple[str, ...]]:
    """Return the grade of a maneuver, its main input first, and the reasons, the worst first."""
    if not inputs:
        text = "no surface moved beyond its noise: no excitation"
        return "D", (text,)
    surfaces = [one.surface for one in inputs]
    defects = [
        *_trim(passage, inputs),
        *_amplitude(passage, setting, inputs[0]),
        *_excitation(passage, setting, surfaces),
        *_clipping(passage, setting),
        *_missing_samples(passage, surfaces),
        *_lost_coupled_surfaces(passage, setting, surfaces),
        *_other_inputs(passage, setting, inputs),
        *_turbulence(passage, setting, surfaces),
        *_free_response(passage, setting),
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


def _defects(severity: DefectSeverity | None, text: str) -> list[Defect]:
    return [] if severity is None else [Defect(severity=severity, text=text)]


def _trim(passage: ManeuverSamples, inputs: Sequence[SurfaceInput]) -> list[Defect]:
    found = []
    for name, text in (("p", "rolling"), ("q", "pitching"), ("r", "yawing")):
        rate = passage.mean_at_trim(name)
        found += _defects(
            INPUT_CRITERIA.trim_rate.severity(abs(rate)),
            f"not trimmed at the start: {text} at {rate / DEGREE:.0f} deg/s",
        )
    load = passage.mean_at_trim("an") / GRAVITY
    if abs(load - 1.0) > INPUT_CRITERIA.trim_load_factor:
        found += _defects("small", f"not trimmed at the start: a_n is {load:.2f} g")
    if any(one.surface == "throttle" for one in inputs):
        return found
    throttle = passage.samples("throttle", passage.t_input - DETECTION.trim_time, passage.t_end)
    moved = float(np.ptp(throttle)) if throttle.size else 0.0
    if moved > INPUT_CRITERIA.throttle_change:
        found += _defects("small", f"throttle moved by {100.0 * moved:.0f} %")
    return found


def _amplitude(
    passage: ManeuverSamples, setting: GradingContext, main: SurfaceInput
) -> list[Defect]:
    found = []
    least = INPUT_CRITERIA.min_amplitude / DETECTION.min_rapid_move
    if main.surface in SURFACES and main.amplitude < least * setting.least_move(main.surface):
        found += _defects("large", f"{main.surface} moved {main.amplitude / DEGREE:.1f} deg only")
    flow = flow_history(passage, setting.aircraft)
    during = (passage.times >= passage.t_input) & (passage.times <= passage.t_end)
    dt = float(np.median(np.diff(passage.times)))
    for name, (low, high) in linear_ranges(setting.aircraft).items():
        samples = flow[name][during]
        if not is_out_of_range(samples, (low, high), dt):
            continue
        unit, text = (GRAVITY, "g") if name == "an" else (DEGREE, "deg")
        least, most = np.nanmin(samples), np.nanmax(samples)
        worst = float(least if low - least > most - high else most)
        found += _defects(
            "small",
            f"too large: {name} reached {worst / unit:.1f} {text}, beyond the linear range of "
            f"{low / unit:.0f} to {high / unit:.0f}",
        )
    return found


def _excitation(
    passage: ManeuverSamples, setting: GradingContext, surfaces: Sequence[str]
) -> list[Defect]:
    found = []
    faint, weak = INPUT_CRITERIA.faint_response, INPUT_CRITERIA.weak_response
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
        if size < weak:
            found += _defects(
                "large" if size < faint else "small",
                f"too small: {best} answered {surface} with {size:.0f} times its noise "
                f"({faint:.0f} is little, {weak:.0f} enough)",
            )
    return found


def _clipping(passage: ManeuverSamples, setting: GradingContext) -> list[Defect]:
    start = passage.t_input - DETECTION.trim_time
    clipped = clipped_samples(passage, setting.aircraft, start, passage.t_end)
    return [
        defect
        for name, (count, total) in clipped.items()
        for defect in _defects(
            INPUT_CRITERIA.clipped_share.severity(count / total),
            f"{name} clipped in {count} samples ({100.0 * count / total:.0f} %)",
        )
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
        elif severity := INPUT_CRITERIA.missing_samples.severity(1.0 - samples.size / total):
            share = 100.0 * (1.0 - samples.size / total)
            found += _defects(severity, f"{share:.0f} % of {name} is missing")
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
    moved = cross_deflections(passage, inputs)
    found = []
    for surface, ratio in cross_input_ratios(moved, setting, inputs).items():
        found += _defects(
            INPUT_CRITERIA.cross_input.severity(ratio),
            f"{surface} moved as well, by {moved[surface] / DEGREE:.1f} deg",
        )
    for one in inputs:
        if one.kind == "step":
            continue
        share = residual_deflection(passage, one)
        found += _defects(
            INPUT_CRITERIA.residual_deflection.severity(share),
            f"{one.surface} not returned to neutral: {100.0 * share:.0f} % of its deflection left",
        )
    return found


def _turbulence(
    passage: ManeuverSamples, setting: GradingContext, surfaces: Sequence[str]
) -> list[Defect]:
    # A lever moves one of the channels that may answer; the others show their noise.
    surfaces = [name for name in surfaces if name in SURFACES]
    worst, channel = pre_input_motion_ratio(passage, setting, surfaces)
    return _defects(
        INPUT_CRITERIA.pre_input_motion.severity(worst),
        f"turbulence before the input: {channel} wandered by {100.0 * worst:.0f} % of its response",
    )


def _free_response(passage: ManeuverSamples, setting: GradingContext) -> list[Defect]:
    free = passage.t_end - passage.t_input_end
    return _defects(
        INPUT_CRITERIA.hands_off_lack.severity(1.0 - free / DETECTION.min_free_response_time),
        f"hands off for {max(free, 0.0) * setting.time_scale:.1f} s only after the input",
    )

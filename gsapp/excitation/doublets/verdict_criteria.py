"""The verdict on a measured input: what speaks against it, the worst first, and what to do.

The criteria that a grade shares are in `gsapp.flight.maneuvers.input_measures`. Bands of amplitude
and width come from the wanted input, the airspeed from the test point. The order is that of what
makes an input useless: nothing to judge by, a sensor at its end, a start out of trim, a second
stick, an answer lost in the noise, an answer out of the linear range, gusts; last a width that
misses the mode.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.excitation.doublets.input_measurement import MeasuredInput
from gsapp.excitation.doublets.verdict import InputFinding, InputVerdict, VerdictResult
from gsapp.excitation.settings import DOUBLETS
from gsapp.excitation.test_points.point import TargetInput, TestPoint, ToleranceBand
from gsapp.excitation.test_points.stick_text import (
    format_amplitude_change,
    format_sticks,
    format_width_change,
)
from gsapp.excitation.trim.trim_cue import TrimDeviation, TrimTolerances
from gsapp.flight.cards import TestCard
from gsapp.flight.cards.card import compare_with_card
from gsapp.flight.maneuvers.detection import build_maneuver
from gsapp.flight.maneuvers.input_measures import (
    INPUT_CRITERIA,
    RESPONSE_CHANNELS,
    GradingContext,
    cross_input_ratios,
    is_out_of_range,
    linear_ranges,
    pre_input_motion_ratio,
)
from gsapp.flight.maneuvers.input_shape import SurfaceInput
from gsapp.flight.maneuvers.settings import DETECTION
from gsapp.quantities import SURFACE_NAMES as SURFACE_WORDS
from gsapp.quantities import channel, name_in_text


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class InputCase:
    """All that a verdict is drawn from."""

    measured: MeasuredInput
    kind: str
    """Shape of the main input."""
    target_input: TargetInput | None
    """None where nothing is known of what is wanted: shape and answer alone are judged."""
    point: TestPoint | None
    setting: GradingContext
    tolerances: TrimTolerances
    known_aircraft: bool = True
    """Whether there is an aircraft file."""
    system: str = "US"
    """Units of the words."""

    @property
    def aircraft(self) -> Aircraft:
        return self.setting.aircraft

    @property
    def dt(self) -> float:
        """Return the time between samples, s."""
        return float(np.median(np.diff(self.measured.passage.times)))

    def stick_text(self, surface: str) -> str:
        """Return the deflection wanted of a surface in the pilot's words.

        One position of the rate switch serves all surfaces of the input.
        """
        asked = {one.surface: self.amplitude_band(one.surface) for one in self.measured.inputs}
        best = {name: band.best for name, band in asked.items() if band is not None}
        aircraft = self.aircraft if self.known_aircraft else None
        return format_sticks(aircraft, best, rate_switch=self.measured.rate_switch)[surface]

    def describe_input(self, one: SurfaceInput) -> str:
        """Return what an input is called: "rudder doublet"."""
        return f"{SURFACE_WORDS[one.surface]} {one.kind}"

    @property
    def pre_input_motion_ratio(self) -> float:
        return pre_input_motion_ratio(self.measured.passage, self.setting, self.measured.surfaces)[
            0
        ]

    def amplitude_band(self, surface: str) -> ToleranceBand | None:
        """Return the amplitudes wanted of a surface; None where none are known."""
        return None if self.target_input is None else self.target_input.amplitudes.get(surface)


_CLIPPED: Final = {
    **{name: name_in_text(name) for name in ("p", "q", "r", "alpha", "beta")},
    **dict.fromkeys(("ax", "ay", "an"), "acceleration"),
}
_OUT: Final = {**{name: name_in_text(name) for name in ("alpha", "beta")}, "an": "load factor"}


def find_deficiencies(case: InputCase) -> tuple[InputFinding, ...]:
    """Return what speaks against an input, the worst first; nothing for a good one."""
    return tuple(finding for judge in _CHECKS for finding in judge(case))


def list_unevaluated(case: InputCase) -> tuple[str, ...]:
    """Return what could not be judged, in words."""
    measured, found = case.measured, []
    if case.target_input is None:
        found.append("amplitude and width: no card and no model give a target")
    if "de" in measured.surfaces and "alpha" not in measured.flow:
        found.append("linear range: angle of attack is not measured")
    if {"da", "dr"} & set(measured.surfaces) and "beta" not in measured.flow:
        found.append("linear range: sideslip is not measured")
    found += [f"{channel(name).title} saturated" for name in measured.saturated_before]
    if measured.gust_fraction is None:
        found.append("gusts during the input: no model to compare with")
    elif (
        measured.gust_fraction
        > INPUT_CRITERIA.gust_fraction
        >= INPUT_CRITERIA.gust_factor * case.pre_input_motion_ratio
    ):
        share = 100.0 * measured.gust_fraction
        found.append(
            f"the model finds gusts of {share:.0f} % of the response in calm air: doubtful"
        )
    if "bank" not in measured.trim_values:
        found.append("bank at the start: not measured")
    elif not measured.bank_is_measured:
        found.append("bank at the start by rates and accelerations (no attitude)")
    return tuple(found)


# --- the judges, in the order in which they are heard ------------------------------------------


def _check_samples(case: InputCase) -> list[InputFinding]:
    passage, found = case.measured.passage, []
    start = passage.t_input - DETECTION.trim_time
    total = passage.count(start, passage.t_end)
    for surface in case.measured.surfaces:
        count = passage.samples(surface, start, passage.t_end).size
        lost = 1.0 - count / max(total, 1)
        if INPUT_CRITERIA.missing_samples.is_invalid(lost):
            text = f"{SURFACE_WORDS[surface]} signal missing for {100.0 * lost:.0f} percent"
            found.append(InputFinding(result="unclear", words=text, surface=surface))
        heard = [
            name
            for name in RESPONSE_CHANNELS[surface]
            if name not in case.measured.saturated_before
            and not INPUT_CRITERIA.missing_samples.is_invalid(
                1.0 - passage.samples(name, start, passage.t_end).size / max(total, 1)
            )
        ]
        if not heard:
            text = f"no response measured for the {SURFACE_WORDS[surface]}"
            found.append(InputFinding(result="unclear", words=text, surface=surface))
    return found


def _check_clipping(case: InputCase) -> list[InputFinding]:
    found = []
    worst = sorted(case.measured.clipped.items(), key=lambda item: -item[1])
    for name, count in worst:
        if count * case.dt >= INPUT_CRITERIA.clipped_time:
            found.append(_too_large(case, name, f"{_CLIPPED[name]} clipped"))
    return found


def _check_trim(case: InputCase) -> list[InputFinding]:
    allowed, trim = case.tolerances, case.measured.trim_values
    factor = INPUT_CRITERIA.trim_tolerance_factor
    seen = case.measured.bank_is_measured
    bank = allowed.bank if seen else allowed.bank_unmeasured
    checks = [
        ("p", "roll rate", "p", allowed.roll_rate, 0.0),
        ("q", "pitch rate", "q", allowed.pitch_rate, 0.0),
        ("r", "yaw rate", "r", allowed.yaw_rate, 0.0),
        # A bank that rates tell is not told in degrees.
        ("bank", "bank", "phi" if seen else "r", bank, 0.0),
    ]
    point = case.point
    if point is not None and point.speed is not None:
        checks.append(("V", "speed", "V", point.speed_tolerance, point.speed))
    elif point is not None and point.alpha is not None:
        checks.append(("alpha", "alpha", "alpha", point.alpha_tolerance, point.alpha))
    off = [
        TrimDeviation(
            quantity=quantity,
            amount=trim[name] - wanted,
            tolerance_ratio=abs(trim[name] - wanted) / (factor * tolerance),
            channel=told,
        )
        for name, quantity, told, tolerance, wanted in checks
        if name in trim
    ]
    return [
        InputFinding(
            result="not-trimmed",
            words=f"not trimmed: {one.format_text(case.system)}",
            channel=one.channel,
        )
        for one in sorted(off, key=lambda one: -one.tolerance_ratio)
        if one.tolerance_ratio > 1.0
    ]


def _check_cross_input(case: InputCase) -> list[InputFinding]:
    measured, found = case.measured, []
    shares = cross_input_ratios(measured.cross_deflections, case.setting, measured.inputs)
    for surface, share in shares.items():
        if INPUT_CRITERIA.cross_input.is_invalid(share):
            text = f"invalid: {SURFACE_WORDS[surface]} moved too"
            found.append(InputFinding(result="invalid", words=text, surface=surface))
    for surface, share in measured.residual_deflection.items():
        if INPUT_CRITERIA.residual_deflection.is_invalid(share):
            text = f"invalid: {SURFACE_WORDS[surface]} not returned to neutral"
            found.append(InputFinding(result="invalid", words=text, surface=surface))
    wanted = case.target_input
    if wanted is not None and INPUT_CRITERIA.hands_off_lack.is_invalid(
        1.0 - measured.hands_off_time / wanted.hands_off
    ):
        text = f"invalid: hands off for {max(measured.hands_off_time, 0.0):.1f} seconds only"
        found.append(InputFinding(result="invalid", words=text))
    return found


def _check_shape(case: InputCase) -> list[InputFinding]:
    wanted = case.target_input
    if wanted is None or case.kind == wanted.kind:
        return []
    text = f"that was a {case.kind}, not a {wanted.kind}"
    return [InputFinding(result="unclear", words=text)]


def _check_min_amplitude(case: InputCase) -> list[InputFinding]:
    found = []
    for one in case.measured.inputs:
        band = case.amplitude_band(one.surface)
        if band is None or one.amplitude >= band.low:
            continue
        factor = max(band.best / max(one.amplitude, 1e-9), DOUBLETS.min_change)
        change = f"{format_amplitude_change(factor)}, {case.stick_text(one.surface)}"
        text = f"{case.describe_input(one)} too small: {change}"
        found.append(
            InputFinding(result="too-small", words=text, surface=one.surface, factor=factor)
        )
    return found


def _check_linear_range(case: InputCase) -> list[InputFinding]:
    found = []
    for name, limits in linear_ranges(case.aircraft).items():
        values = case.measured.flow.get(name)
        if values is not None and is_out_of_range(values, limits, case.dt):
            found.append(_too_large(case, name, f"{_OUT[name]} left its linear range"))
    if found:
        return found
    for one in case.measured.inputs:
        band = case.amplitude_band(one.surface)
        if band is not None and one.amplitude > band.high:
            found.append(_larger_than(case, one, band))
    return found


def _check_gusts(case: InputCase) -> list[InputFinding]:
    gusts = case.measured.gust_fraction
    if gusts is not None:
        most = INPUT_CRITERIA.gust_factor * case.pre_input_motion_ratio
        too_gusty = min(gusts, most) > INPUT_CRITERIA.gust_fraction
    else:
        too_gusty = INPUT_CRITERIA.pre_input_motion.is_invalid(case.pre_input_motion_ratio)
    text = "invalid, gusts: wait for calmer air"
    return [InputFinding(result="invalid", words=text)] if too_gusty else []


def _check_step_width(case: InputCase) -> list[InputFinding]:
    wanted = case.target_input
    if wanted is None:
        return []
    found = []
    for one in case.measured.inputs:
        if one.kind != wanted.kind:
            continue
        width, band = step_width(case, one), wanted.width
        if band.low <= width <= band.high:
            continue
        result: VerdictResult = "too-fast" if width < band.low else "too-slow"
        text = f"{case.describe_input(one)} {result.replace('-', ' ')}"
        words = f"{text}: {format_width_change(width, band.best)}"
        found.append(
            InputFinding(
                result=result, words=words, surface=one.surface, factor=band.best / max(width, 1e-3)
            )
        )
    return found


_CHECKS: Final[tuple[Callable[[InputCase], list[InputFinding]], ...]] = (
    _check_samples,
    _check_clipping,
    _check_trim,
    _check_cross_input,
    _check_shape,
    _check_min_amplitude,
    _check_linear_range,
    _check_gusts,
    _check_step_width,
)


# --- small things ------------------------------------------------------------------------------

_UNITS: Final[Mapping[str, float]] = {"doublet": 2.0, "3-2-1-1": 7.0, "pulse": 1.0}


def step_width(case: InputCase, one: SurfaceInput) -> float:
    """Return the length of one step of an input, s: its steps over their units."""
    lengths = case.measured.steps[one.surface]
    return sum(lengths) / _UNITS.get(one.kind, float(len(lengths)))


def _too_large(case: InputCase, name: str, why: str) -> InputFinding:
    """Return the finding for a signal that went too far."""
    main = max(
        case.measured.inputs,
        key=lambda one: (name in RESPONSE_CHANNELS[one.surface], one.amplitude),
    )
    band = case.amplitude_band(main.surface)
    factor = DOUBLETS.reduction if band is None else band.best / max(main.amplitude, 1e-9)
    factor = min(factor, 1.0 / DOUBLETS.min_change)
    text = f"{case.describe_input(main)} too large: {why}, {format_amplitude_change(factor)}"
    return InputFinding(
        result="too-large", words=text, surface=main.surface, factor=factor, channel=name
    )


def _larger_than(case: InputCase, one: SurfaceInput, band: ToleranceBand) -> InputFinding:
    factor = min(band.best / one.amplitude, 1.0 / DOUBLETS.min_change)
    change = f"{format_amplitude_change(factor)}, {case.stick_text(one.surface)}"
    text = f"{case.describe_input(one)} too large: {change}"
    return InputFinding(result="too-large", words=text, surface=one.surface, factor=factor)


@dataclass(frozen=True, slots=True, kw_only=True)
class InputRequest:
    """What an input is held against."""

    target_input: TargetInput | None = None
    point: TestPoint | None = None
    card: TestCard | None = None


def evaluate_input(
    name: str,
    now: float,
    measured: MeasuredInput,
    asked: InputRequest,
    setting: GradingContext,
    tolerances: TrimTolerances,
    *,
    known_aircraft: bool = True,
    system: str = "US",
) -> InputVerdict:
    """Return the verdict on an input.

    Grade and verdict never contradict each other. Good is what is graded A or B; where the judges
    of the verdict have nothing against an input that is graded lower, it is ``unclear``, with the
    grader's reason. An input that is not good is graded B at best.
    """
    travel = setting.half_travel
    by_size = sorted(measured.inputs, key=lambda one: -one.max_step / travel(one.surface))
    case = InputCase(
        measured=measured,
        kind=by_size[0].kind,
        target_input=asked.target_input,
        point=asked.point,
        setting=setting,
        tolerances=tolerances,
        known_aircraft=known_aircraft,
        system=system,
    )
    found = find_deficiencies(case)
    graded = build_maneuver(name, measured.passage, setting, by_size)
    if not found and graded.grade in ("C", "D"):
        found = (InputFinding(result="unclear", words=graded.reasons[0]),)
    result = found[0].result if found else "good"
    advice = found[0].words if found else "good"
    graded = graded.with_verdict(result, advice)
    if (
        not found
        and min(measured.symmetry.values()) < DOUBLETS.min_symmetry
        and case.kind == "doublet"
    ):
        advice = "good, but uneven: make both halves equal"
    card, counts = "", False
    if asked.card is not None and asked.card.kind == case.kind:
        attempt = compare_with_card(asked.card, graded)
        card, counts = asked.card.id, result == "good" and attempt.is_counted
        if result == "good" and not counts:
            advice = f"good, but not for the card: {attempt.reasons[0].partition(',')[0]}"
    passage = measured.passage
    return InputVerdict(
        id=name,
        given_at=now,
        t_start=passage.t_input - DETECTION.trim_time,
        t_input=passage.t_input,
        t_input_end=passage.t_input_end,
        t_end=passage.t_end,
        surfaces=measured.surfaces,
        kind=case.kind,
        amplitudes={one.surface: one.amplitude for one in measured.inputs},
        halves=measured.steps,
        symmetry=measured.symmetry,
        left_over=measured.residual_deflection,
        cross=measured.cross_deflections,
        V=measured.trim_values.get("V"),
        alpha=graded.alpha,
        result=result,
        grade=graded.grade,
        findings=found,
        advice=advice,
        card=card,
        counts=counts,
        judged_by=list_unevaluated(case),
    )

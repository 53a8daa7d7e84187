"""From a measured input to its verdict."""

from __future__ import annotations

from dataclasses import dataclass

from gsapp.excitation.doublets.input_measurement import MeasuredInput
from gsapp.excitation.doublets.settings import DOUBLETS
from gsapp.excitation.doublets.verdict import InputFinding, InputVerdict
from gsapp.excitation.doublets.verdict_criteria import (
    InputCase,
    find_deficiencies,
    list_unevaluated,
)
from gsapp.excitation.test_points.point import TestPoint
from gsapp.excitation.test_points.target_input import TargetInput
from gsapp.excitation.trim.tolerances import TrimTolerances
from gsapp.flight.cards import TestCard
from gsapp.flight.cards.card_matching import compare_with_card
from gsapp.flight.maneuvers.detection import build_maneuver
from gsapp.flight.maneuvers.input_measures import GradingContext
from gsapp.flight.maneuvers.settings import DETECTION


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

    Parameters
    ----------
    name : str
        Its id.
    now : float
        Flight time, s.
    measured : MeasuredInput
    asked : InputRequest
    setting : GradingContext
    tolerances : TrimTolerances
    known_aircraft : bool
        Whether there is an aircraft file.
    system : {"US", "SI"}
        Units of the words.
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

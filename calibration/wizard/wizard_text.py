"""The wizard's sentences: what to do, what happened; and the few words that are spoken."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from calibration.drift import CheckResult
from calibration.plan import CalibrationPlan, InstrumentPlan
from calibration.points import DIRECTION_TEXT
from calibration.wizard.angle_monitor import PointHint, StepProposal
from calibration.wizard.procedure import CalibrationOutcome
from calibration.wizard.state import ScheduledSetting


def sign_prompt(instrument: InstrumentPlan, hint: PointHint, *, ask: bool) -> str:
    """Return how to prove the sign; `ask` where it takes the crew's word."""
    if hint == "against":
        return (
            f"The voltage changed in the opposite direction: is it {instrument.positive} now? "
            "Confirm, or move it the right way."
        )
    if hint == "little":
        return f"{instrument.positive_motion_text}, further, and hold it there."
    if ask:
        return f"{instrument.positive_motion_text}, hold it there and confirm."
    return f"{instrument.positive_motion_text} and hold it there."


def sign_speech(instrument: InstrumentPlan, hint: PointHint) -> str:
    """Return the same in few words."""
    if hint == "against":
        return f"Opposite direction. Is it {instrument.positive}?"
    return f"{instrument.title}, {instrument.positive}"


def point_prompt(instrument: InstrumentPlan, slot: ScheduledSetting, look: StepProposal) -> str:
    """Return how to come to a setting, and what was wrong with where it rests."""
    goal = instrument.format_setting(slot.value)
    there, back = _direction_text(instrument, slot)
    if look.hint == "past":
        return f"Past it: come {back} to {goal} and hold."
    if look.hint == "wrong_side" and not slot.is_turning_point:
        return f"Overshot: go back {there} past it, then {back} to {goal} and hold."
    if look.hint == "elsewhere" and look.value is not None:
        about = instrument.format_setting(round(look.value))
        return f"Steady at about {about}: continue to {goal} and hold."
    if slot.direction == "single":
        return f"Set it to {goal} and hold."
    if slot.is_turning_point:
        return f"Go {there} past {goal}, come {back} to it and hold."
    return f"Go {back} to {goal} and hold."


def point_speech(instrument: InstrumentPlan, slot: ScheduledSetting, look: StepProposal) -> str:
    """Return the setting as it is called out."""
    side = ""
    if slot.value:
        side = f" {_last(instrument.positive if slot.value > 0.0 else instrument.negative)}"
    goal = f"{abs(slot.value):g}{side}" if slot.value else "zero"
    if look.hint == "past":
        return f"Back to {goal}"
    if look.hint == "wrong_side" and not slot.is_turning_point:
        there, _ = _direction_text(instrument, slot)
        return f"Overshot. {there.capitalize()} past it, then back to {goal}"
    if look.hint == "elsewhere":
        return f"Not yet {goal}"
    if slot.is_turning_point and slot.direction != "single":
        return f"Past {goal}, then back"
    return goal.capitalize()


def recorded_point_text(
    instrument: InstrumentPlan, data: Mapping[str, Any], slot: ScheduledSetting, hint: PointHint
) -> str:
    """Return what was taken (the data of the step), and what is odd about it."""
    text = f"taken: {data['volts']:.3f} V at {instrument.format_setting(data['value'])}"
    if hint == "noisy":
        return f"{text}, noisy ({1e3 * data['std']:.0f} mV)"
    if hint == "unmoved":
        return f"{text}, although it has not moved since the last step"
    if slot.direction not in ("single", data["direction"]):
        return f"{text}, while {DIRECTION_TEXT[data['direction']]}"
    return text


def hint_text(hint: PointHint) -> str:
    """Return why a rest is not taken."""
    return {
        "against": "the voltage changed in the wrong direction",
        "wrong_side": "reached from the wrong side",
    }[hint]


def fit_text(instrument: InstrumentPlan, outcome: CalibrationOutcome) -> tuple[str, str]:
    """Return what to do with a curve, and the same in few words."""
    title = instrument.title
    if not outcome.ready:
        return f"{title}: too few points; add some or repeat them.", "Too few points"
    if outcome.issues:
        if outcome.check_result is not None:
            return f"{title}: calibrate it again before the flight.", f"{title} has moved"
        return f"{title}: repeat these points, or accept it.", "Check the curve"
    if outcome.check_result is not None:
        return f"{title} has not moved: accept it.", f"{title} holds"
    return f"{title} OK: accept it.", f"{title} good"


def calibration_summary_text(plan: CalibrationPlan, accepted: Sequence[str]) -> dict[str, str]:
    """Return how many of the instruments of a run are calibrated, as prompt and as it is spoken."""
    count, total = len(accepted), len(plan.instruments)
    if count == total == 1:
        prompt = f"{plan.instruments[0].title} calibrated."
    elif count == total:
        prompt = f"{count} instruments calibrated."
    else:
        prompt = f"{count} of {total} instruments calibrated."
    return {"prompt": prompt, "spoken": f"Done. {prompt}".rstrip(".")}


def check_summary_text(plan: CalibrationPlan, checks: Mapping[str, CheckResult]) -> dict[str, str]:
    """Return what the checks of an aircraft come to, as prompt and as it is spoken."""
    if not checks:
        return {"prompt": "No certificate checked.", "spoken": "Done. No certificate checked"}
    moved = [plan[name].title for name, one in checks.items() if not one.passed]
    if not moved:
        every = "All" if len(checks) == len(plan.instruments) else f"The {len(checks)} checked"
        prompt = f"{every} certificates valid."
        return {"prompt": prompt, "spoken": prompt.rstrip(".")}
    names = ", ".join([moved[0], *(title.lower() for title in moved[1:])])
    have = "has" if len(moved) == 1 else "have"
    return {
        "prompt": f"{names} {have} moved: calibrate again before the flight.",
        "spoken": f"Done. {names} {have} moved",
    }


def _direction_text(instrument: InstrumentPlan, slot: ScheduledSetting) -> tuple[str, str]:
    up, down = _last(instrument.negative), _last(instrument.positive)
    return (up, down) if slot.direction == "up" else (down, up)


def _last(text: str) -> str:
    return text.rpartition(" ")[2]

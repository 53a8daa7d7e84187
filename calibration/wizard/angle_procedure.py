"""Surfaces and vanes: the sign, the points up and down, the curve."""

from __future__ import annotations

import math
from datetime import datetime

from calibration.plan import InstrumentPlan
from calibration.pressures import GroundAir
from calibration.wizard import wizard_text
from calibration.wizard.angle_monitor import (
    AngleFaultMonitor,
    AngleMonitor,
    PointHint,
    StepProposal,
)
from calibration.wizard.point_evaluation import evaluate_check, evaluate_points
from calibration.wizard.procedure import (
    ActionFeedback,
    CalibrationOutcome,
    CalibrationProcedure,
    JournalHeader,
    ProcedureView,
    ReferenceCertificates,
    SampleSlice,
    StepDraft,
    WizardAction,
    WizardPhase,
)
from calibration.wizard.state import AngleProgress

_UNUSABLE: dict[PointHint, str] = {
    "absent": "no voltage",
    "clipped": "the voltage is at the end of the ADC range",
}
_PERSISTENT_HINTS: tuple[PointHint, ...] = ("past", "wrong_side", "elsewhere")
"""What was said of the last rest goes on to hold until the next one."""
_BLOCKING_FAULTS = ("dead", "swapped", "clipped")
"""Faults with which no sign can be proven."""


class AngleProcedure(CalibrationProcedure[AngleProgress]):
    """Looks after one instrument that is set by hand."""

    def __init__(
        self, instrument: InstrumentPlan, header: JournalHeader, reference: ReferenceCertificates
    ) -> None:
        self._instrument = instrument
        self._header = header
        self._reference = reference
        best = reference.former_or_nominal(instrument.channel)
        self._watch = AngleMonitor(instrument, best, trusted=header.mode == "check")
        others = [
            other.channel
            for other in header.plan.instruments
            if other.is_angle_sensor and other.channel != instrument.channel
        ]
        self._faults = AngleFaultMonitor(instrument, others, best)
        self._look = StepProposal()
        self._armed = False
        self._ask = False
        self._said: tuple[object, ...] = ()

    def restart(self) -> None:
        self._watch.restart()
        self._faults.restart()
        self._look = StepProposal()
        self._armed = False
        self._said = ()

    def feed(self, one: SampleSlice) -> None:
        self._watch.feed(one.times, one.volts[self._instrument.channel], one.excitation)
        self._faults.feed(one)

    def phase(self, work: AngleProgress) -> WizardPhase:
        if work.rising is None:
            return "sign"
        return "points" if work.open_slot_indices else "fit"

    def automatic_step(self, work: AngleProgress) -> StepDraft | ActionFeedback | None:
        phase = self.phase(work)
        if phase == "fit":
            return None
        sign = phase == "sign"
        before = self._look
        if sign:
            self._look = self._watch.detect_sign(confirmed=False)
        else:
            self._look = self._watch.detect_point(
                work, work.open_slot_indices[0], by_key=self._armed
            )
        asked = sign or (self._header.mode == "check" and not work.points)
        self._faults.update(moved=self._look.hint != "unmoved", sign_asked=asked)
        if self._look.hint == "moving" and before.hint in _PERSISTENT_HINTS:
            self._look = before
        if self._look.hint == "against":
            # The way back looks like the way there: from here on only the crew can tell.
            self._ask = True
            self._faults.diagnose_after_movement()
        if self._look.data is None:
            return self._remark()
        if sign:
            if self._ask or self._faults.diagnose_after_movement():
                return self._remark()
            return self._sign_draft()
        if self._header.auto or self._armed:
            return self._point_draft(work)
        return self._remark()

    def available_actions(self, work: AngleProgress) -> frozenset[str]:
        phase = self.phase(work)
        kinds = {"confirm_sign", "take"} if phase == "sign" else {"add"}
        if phase == "points":
            kinds |= {"take", "next"}
        if phase == "fit" and self._header.mode == "full":
            kinds.add("choose_degree")
        if work.points:
            kinds |= {"repeat", "delete"}
        return frozenset(kinds)

    def act(self, work: AngleProgress, action: WizardAction) -> StepDraft | ActionFeedback:
        if action.kind in ("take", "confirm_sign"):
            if self.phase(work) == "points":
                return self._take(work)
            return self._confirm_sign() if action.yes else self._deny_sign()
        if action.kind in ("repeat", "delete"):
            return self._remove(work, action)
        if action.kind == "add":
            return self._add(action)
        if action.kind == "next":
            at = work.open_slot_indices[0]
            gone = self._instrument.format_setting(work.slots[at].value)
            return StepDraft(
                kind="leave_out", data={"slot": at}, message=f"left out: {gone}", tone=""
            )
        degree = action.degree
        text = "fit order automatic" if degree is None else f"curve of degree {degree}"
        return StepDraft(kind="degree", data={"degree": degree}, message=text, tone="")

    def build_view(self, work: AngleProgress, outcome: CalibrationOutcome) -> ProcedureView:
        phase = self.phase(work)
        slot = work.remaining[0] if phase == "points" else None
        if slot is not None:
            prompt = wizard_text.point_prompt(self._instrument, slot, self._look)
            spoken = wizard_text.point_speech(self._instrument, slot, self._look)
            if self._header.mode == "check" and not work.points:
                # No page before it has said which one is meant.
                spoken = f"{self._instrument.title}: {spoken[0].lower()}{spoken[1:]}"
        elif phase == "sign":
            prompt = wizard_text.sign_prompt(self._instrument, self._look.hint, ask=self._ask)
            spoken = wizard_text.sign_speech(self._instrument, self._look.hint)
        else:
            prompt, spoken = wizard_text.fit_text(self._instrument, outcome)
        # Once all points are taken the surface is seen by its own curve.
        drawn = outcome.certificates[0] if phase == "fit" and outcome.certificates else None
        return ProcedureView(
            instrument=self._instrument,
            prompt=prompt,
            spoken=spoken,
            target=None if slot is None else slot.value,
            direction="single" if slot is None else slot.direction,
            reading=self._watch.reading,
            current_value=self._watch.current_value(drawn),
            points=tuple(taken.point for taken in work.points),
            remaining=work.remaining,
            degree=work.degree,
            faults=self._faults.faults,
            warnings=self._warnings(phase),
        )

    def outcome(
        self, work: AngleProgress, stamp: datetime, air: GroundAir | None
    ) -> CalibrationOutcome:
        channel = self._instrument.channel
        former = self._reference.former.get(channel)
        if self._header.mode == "check":
            return evaluate_check(work, former)
        return evaluate_points(
            self._instrument,
            work,
            self._header,
            former=former,
            partner=self._reference.current.get(self._instrument.partner),
            stamp=stamp,
            temperature=air.temperature if air is not None else self._header.temperature,
        )

    def _warnings(self, phase: WizardPhase) -> tuple[str, ...]:
        reading = self._watch.reading
        if phase == "fit" or reading.state != "absent" or math.isnan(reading.time):
            return ()
        return (
            f"{self._instrument.title}: no voltage received; check its plug and the channel map",
        )

    def _remark(self) -> ActionFeedback | None:
        """Return what is to be said of the volts, once for each change of them."""
        faults = self._faults.faults
        now = (self._look.hint, tuple((fault.kind, fault.swapped_with) for fault in faults))
        if now == self._said:
            return None
        before, self._said = self._said, now
        if faults and (not before or before[1] != now[1]):
            return ActionFeedback(message=faults[0].sentence, tone="error")
        if self._look.hint in ("against", "wrong_side"):
            return ActionFeedback(message=wizard_text.hint_text(self._look.hint), tone="error")
        if self._look.data is not None and "volts" in self._look.data:
            return ActionFeedback(message="steady: record it", tone="steady")
        return None

    def _sign_draft(self) -> StepDraft:
        assert self._look.data is not None  # noqa: S101 - asked by the callers
        way = "rise" if self._look.data["rising"] else "fall"
        message = f"sign proven: volts {way} with {self._instrument.positive}"
        return StepDraft(kind="sign", data=self._look.data, message=message)

    def _confirm_sign(self) -> StepDraft | ActionFeedback:
        """Take the crew's word that it was moved as asked."""
        faults = self._faults.diagnose_after_movement()
        hindering = next((one for one in faults if one.kind in _BLOCKING_FAULTS), None)
        if hindering is not None:
            return ActionFeedback(message=hindering.sentence, tone="error")
        self._look = self._watch.detect_sign(confirmed=True)
        if self._look.data is None:
            return ActionFeedback(
                message="no movement detected: move it, then record", tone="error"
            )
        return self._sign_draft()

    def _deny_sign(self) -> ActionFeedback:
        self.restart()
        self._watch.reset()
        return ActionFeedback(message="move it again")

    def _take(self, work: AngleProgress) -> StepDraft | ActionFeedback:
        self._look = self._watch.detect_point(work, work.open_slot_indices[0], by_key=True)
        if self._look.data is not None:
            return self._point_draft(work)
        unusable = _UNUSABLE.get(self._look.hint)
        if unusable is not None:
            return ActionFeedback(message=unusable, tone="error")
        self._armed = True
        return ActionFeedback(message="hold still: recorded as soon as it is steady")

    def _point_draft(self, work: AngleProgress) -> StepDraft:
        data = self._look.data
        assert data is not None  # noqa: S101 - asked by the callers
        slot = work.slots[data["slot"]]
        message = wizard_text.recorded_point_text(self._instrument, data, slot, self._look.hint)
        return StepDraft(kind="point", data=data, message=message)

    def _remove(self, work: AngleProgress, action: WizardAction) -> StepDraft | ActionFeedback:
        at = len(work.points) - 1 if action.index is None else action.index
        if not 0 <= at < len(work.points):
            return ActionFeedback(message=f"there is no point {at + 1}", tone="error")
        gone = self._instrument.format_setting(work.points[at].value)
        message = f"{gone}: again" if action.kind == "repeat" else f"{gone}: deleted"
        return StepDraft(kind=action.kind, data={"index": at}, message=message, tone="")

    def _add(self, action: WizardAction) -> StepDraft | ActionFeedback:
        value = action.value
        if value is None:
            return ActionFeedback(message="enter the setting of the new point", tone="error")
        travel = self._instrument.travel
        if travel is not None and not travel[0] <= value <= travel[1]:
            limits = f"{travel[0]:g} to {travel[1]:g} {self._instrument.unit}"
            return ActionFeedback(
                message=f"{value:g} is beyond the travel of {limits}", tone="error"
            )
        added = self._instrument.format_setting(value)
        return StepDraft(kind="add", data={"value": value}, message=f"added: {added}", tone="")

"""Surfaces and vanes: the sign, the points up and down, the curve."""

from __future__ import annotations

import math
from datetime import datetime

from calibration.faults import InstrumentFault
from calibration.plan import InstrumentPlan
from calibration.pressures import GroundAir
from calibration.wizard import words
from calibration.wizard.hand_faults import HandFaults
from calibration.wizard.hand_watch import HandWatch, Hint, Look
from calibration.wizard.hand_work import HandWork
from calibration.wizard.judging import judge, judge_check
from calibration.wizard.slices import Slice
from calibration.wizard.state import Work
from calibration.wizard.station import Answer, Draft, Header, Outcome, Reference, Showing, Station
from calibration.wizard.view import Action, Phase

_UNUSABLE: dict[Hint, str] = {
    "absent": "there are no volts of it",
    "clipped": "the volts are at the end of the converter's range and cannot be used",
}
_STANDING: tuple[Hint, ...] = ("past", "wrong_side", "elsewhere")
"""What was said of the last rest goes on to hold until the next one."""
_HINDERING = ("dead", "swapped", "clipped")
"""Faults with which no sign can be proven."""


class HandStation(Station):
    """Looks after one instrument that is set by hand.

    Parameters
    ----------
    instrument : InstrumentPlan
        Which.
    header : Header
        Of the calibration.
    reference : Reference
        What readings are held against.
    """

    def __init__(self, instrument: InstrumentPlan, header: Header, reference: Reference) -> None:
        self._instrument = instrument
        self._header = header
        self._reference = reference
        best = reference.best(instrument.channel)
        self._watch = HandWatch(instrument, best, trusted=header.mode == "check")
        others = [
            other.channel
            for other in header.plan.instruments
            if other.by_hand and other.channel != instrument.channel
        ]
        self._faults = HandFaults(instrument, others, best)
        self._look = Look()
        self._armed = False
        self._ask = False
        self._said: tuple[object, ...] = ()

    def restart(self) -> None:
        """Demand a movement, since a step was made."""
        self._watch.restart()
        self._faults.restart()
        self._look = Look()
        self._armed = False
        self._said = ()

    def feed(self, one: Slice) -> None:
        """Take the samples of a tenth of a second."""
        self._watch.feed(one.times, one.volts[self._instrument.channel], one.excitation)
        self._faults.feed(one)

    def phase(self, work: Work) -> Phase:
        """Return which page it is."""
        hand = _hand(work)
        if hand.rising is None:
            return "sign"
        return "points" if hand.open_slots else "fit"

    def by_itself(self, work: Work) -> Draft | Answer | None:
        """Return the sign or the point that the volts prove, or what is to be said of them."""
        hand = _hand(work)
        phase = self.phase(hand)
        if phase == "fit":
            return None
        sign = phase == "sign"
        before = self._look
        if sign:
            self._look = self._watch.look_for_sign(confirmed=False)
        else:
            self._look = self._watch.look_for_point(hand, hand.open_slots[0], by_key=self._armed)
        asked = sign or (self._header.mode == "check" and not hand.points)
        self._faults.look(moved=self._look.hint != "unmoved", sign_asked=asked)
        if self._look.hint == "moving" and before.hint in _STANDING:
            self._look = before
        if self._look.hint == "against":
            # The way back looks like the way there: from here on only the crew can tell.
            self._ask = True
            self._faults.after_movement()
        if self._look.data is None:
            return self._remark()
        if sign:
            if self._ask or self._faults.after_movement():
                return self._remark()
            return self._sign_draft()
        if self._header.auto or self._armed:
            return self._point_draft(hand)
        return self._remark()

    def can(self, work: Work) -> frozenset[str]:
        """Return the kinds of actions that it answers to now."""
        hand = _hand(work)
        phase = self.phase(hand)
        kinds = {"confirm_sign", "take"} if phase == "sign" else {"add"}
        if phase == "points":
            kinds |= {"take", "next"}
        if phase == "fit" and self._header.mode == "full":
            kinds.add("choose_degree")
        if hand.points:
            kinds |= {"repeat", "delete"}
        return frozenset(kinds)

    def act(self, work: Work, action: Action) -> Draft | Answer:
        """Return what an action leads to."""
        hand = _hand(work)
        if action.kind in ("take", "confirm_sign"):
            if self.phase(hand) == "points":
                return self._take(hand)
            return self._confirm_sign() if action.yes else self._deny_sign()
        if action.kind in ("repeat", "delete"):
            return self._remove(hand, action)
        if action.kind == "add":
            return self._add(action)
        if action.kind == "next":
            at = hand.open_slots[0]
            gone = self._instrument.setting_words(hand.slots[at].value)
            return Draft(kind="leave_out", data={"slot": at}, message=f"left out: {gone}", tone="")
        degree = action.degree
        text = "the evidence chooses the curve" if degree is None else f"curve of degree {degree}"
        return Draft(kind="degree", data={"degree": degree}, message=text, tone="")

    def show(self, work: Work, outcome: Outcome) -> Showing:
        """Return what is to be shown."""
        hand = _hand(work)
        phase = self.phase(hand)
        slot = hand.remaining[0] if phase == "points" else None
        if slot is not None:
            prompt = words.point_prompt(self._instrument, slot, self._look)
            spoken = words.point_spoken(self._instrument, slot, self._look)
            if self._header.mode == "check" and not hand.points:
                # No page before it has said which one is meant.
                spoken = f"{self._instrument.title}: {spoken[0].lower()}{spoken[1:]}"
        elif phase == "sign":
            prompt = words.sign_prompt(self._instrument, self._look.hint, ask=self._ask)
            spoken = words.sign_spoken(self._instrument, self._look.hint)
        else:
            prompt, spoken = words.fit_words(self._instrument, outcome)
        # Once all points are taken the surface is seen by its own curve.
        drawn = outcome.certificates[0] if phase == "fit" and outcome.certificates else None
        return Showing(
            instrument=self._instrument,
            prompt=prompt,
            spoken=spoken,
            target=None if slot is None else slot.value,
            direction="single" if slot is None else slot.direction,
            reading=self._watch.reading,
            value_now=self._watch.value_now(drawn),
            points=tuple(taken.point for taken in hand.points),
            remaining=hand.remaining,
            degree=hand.degree,
            faults=self._faults.seen,
            warnings=self._warnings(phase),
        )

    def outcome(self, work: Work, stamp: datetime, air: GroundAir | None) -> Outcome:
        """Return what the points come to."""
        channel = self._instrument.channel
        former = self._reference.former.get(channel)
        if self._header.mode == "check":
            return judge_check(_hand(work), former)
        return judge(
            self._instrument,
            _hand(work),
            self._header,
            former=former,
            partner=self._reference.today.get(self._instrument.partner),
            stamp=stamp,
            temperature=air.temperature if air is not None else self._header.temperature,
        )

    def _warnings(self, phase: Phase) -> tuple[str, ...]:
        reading = self._watch.reading
        if phase == "fit" or reading.state != "absent" or math.isnan(reading.time):
            return ()
        return (
            f"{self._instrument.title}: no volts come; look at its plug and at the channel map",
        )

    def _remark(self) -> Answer | None:
        """Return what is to be said of the volts, once for each change of them."""
        faults = self._faults.seen
        now = (self._look.hint, tuple((fault.kind, fault.other) for fault in faults))
        if now == self._said:
            return None
        before, self._said = self._said, now
        if faults and (not before or before[1] != now[1]):
            return Answer(message=faults[0].sentence, tone="error")
        if self._look.hint in ("against", "wrong_side"):
            return Answer(message=words.hint_words(self._look.hint), tone="error")
        if self._look.data is not None and "volts" in self._look.data:
            return Answer(message="steady: take it", tone="steady")
        return None

    def _sign_draft(self) -> Draft:
        assert self._look.data is not None  # noqa: S101 - asked by the callers
        way = "rise" if self._look.data["rising"] else "fall"
        message = f"sign proven: volts {way} with {self._instrument.positive}"
        return Draft(kind="sign", data=self._look.data, message=message)

    def _confirm_sign(self) -> Draft | Answer:
        """Take the crew's word that it was moved as asked."""
        faults = self._faults.after_movement()
        hindering = _first(faults)
        if hindering is not None:
            return Answer(message=hindering.sentence, tone="error")
        self._look = self._watch.look_for_sign(confirmed=True)
        if self._look.data is None:
            return Answer(message="no movement was seen: move it, then take", tone="error")
        return self._sign_draft()

    def _deny_sign(self) -> Answer:
        self.restart()
        self._watch.forget()
        return Answer(message="move it once more")

    def _take(self, hand: HandWork) -> Draft | Answer:
        self._look = self._watch.look_for_point(hand, hand.open_slots[0], by_key=True)
        if self._look.data is not None:
            return self._point_draft(hand)
        unusable = _UNUSABLE.get(self._look.hint)
        if unusable is not None:
            return Answer(message=unusable, tone="error")
        self._armed = True
        return Answer(message="hold still: it is taken as soon as it rests")

    def _point_draft(self, hand: HandWork) -> Draft:
        data = self._look.data
        assert data is not None  # noqa: S101 - asked by the callers
        slot = hand.slots[data["slot"]]
        message = words.taken_words(self._instrument, data, slot, self._look.hint)
        return Draft(kind="point", data=data, message=message)

    def _remove(self, hand: HandWork, action: Action) -> Draft | Answer:
        at = len(hand.points) - 1 if action.index is None else action.index
        if not 0 <= at < len(hand.points):
            return Answer(message=f"there is no point {at + 1}", tone="error")
        gone = self._instrument.setting_words(hand.points[at].value)
        message = f"{gone}: once more" if action.kind == "repeat" else f"{gone}: deleted"
        return Draft(kind=action.kind, data={"index": at}, message=message, tone="")

    def _add(self, action: Action) -> Draft | Answer:
        value = action.value
        if value is None:
            return Answer(message="say at which setting a point is to be added", tone="error")
        travel = self._instrument.travel
        if travel is not None and not travel[0] <= value <= travel[1]:
            limits = f"{travel[0]:g} to {travel[1]:g} {self._instrument.unit}"
            return Answer(message=f"{value:g} is beyond the travel of {limits}", tone="error")
        added = self._instrument.setting_words(value)
        return Draft(kind="add", data={"value": value}, message=f"added: {added}", tone="")


def _hand(work: Work) -> HandWork:
    assert isinstance(work, HandWork)  # noqa: S101 - the state pairs stations with their work
    return work


def _first(faults: tuple[InstrumentFault, ...]) -> InstrumentFault | None:
    return next((fault for fault in faults if fault.kind in _HINDERING), None)

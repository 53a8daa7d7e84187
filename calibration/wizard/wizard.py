"""The wizard: samples and actions in, a frozen view out. No window, no clock of its own.

Samples are cut into tenths of a second of flight time before anything looks at them, so that what
the wizard does by itself follows from what was sampled, not from how it came in.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

from calibration.certificate import Certificate
from calibration.fit import CalibrationError
from calibration.plan import CalibrationPlan, InstrumentPlan
from calibration.store import CertificateStore
from calibration.wizard import words
from calibration.wizard.hand import HandWatch, Look
from calibration.wizard.journal import Journal, Step
from calibration.wizard.judging import Judgment, judge
from calibration.wizard.plan_json import plan_content, plan_of
from calibration.wizard.schedule import Mode
from calibration.wizard.slices import Slice, Slicer
from calibration.wizard.state import HandWork, State
from calibration.wizard.view import Action, ActionKind, Phase, Tone, WizardView
from gsapp.quantities import Block

_BEGIN = 2.0
"""Seconds of samples that are looked at before the first instrument is asked for."""
_SHOWN = 3.0
"""Seconds for which a good fit is shown before it is accepted by itself."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Header:
    """What a calibration is, as its journal begins."""

    plan: CalibrationPlan
    mode: Mode
    who: str
    temperature: float | None
    auto: bool


class Wizard:
    """Leads through the calibration of an aircraft.

    Parameters
    ----------
    plan : CalibrationPlan
        What is calibrated.
    store : CertificateStore
        Where certificates go.
    journal : Path
        Every step is kept there as it is taken. A former journal is set aside, not lost.
    who : str
        Takes the readings.
    temperature : float, optional
        Of the surroundings, K.
    now : callable
        Local time.
    mode : {"full", "check"}
        All settings, or the three-point check.
    auto : bool
        Whether points are taken by themselves once the instrument rests where it was asked to.

    Raises
    ------
    CalibrationError
        If the journal cannot be written.
    """

    def __init__(
        self,
        plan: CalibrationPlan,
        store: CertificateStore,
        journal: Path,
        *,
        who: str = "",
        temperature: float | None = None,
        now: Callable[[], datetime],
        mode: Mode = "full",
        auto: bool = True,
    ) -> None:
        header = Header(plan=plan, mode=mode, who=who, temperature=temperature, auto=auto)
        book = Journal(journal)
        book.set_aside()
        book.append(Step(kind="calibration", stamp=now(), data=_header_content(header)))
        self._set_up(header, store, book, now)

    @classmethod
    def resume(
        cls, journal: Path, store: CertificateStore, *, now: Callable[[], datetime]
    ) -> Wizard:
        """Go on with a calibration at the point where it stopped, however it stopped.

        Raises
        ------
        CalibrationError
            If there is none that could go on.
        """
        book = Journal(journal)
        steps = book.recover()
        if not steps or steps[0].kind != "calibration":
            raise CalibrationError(
                f"{journal} holds no calibration that could go on; begin a new one"
            )
        wizard = object.__new__(cls)
        wizard._set_up(_header_of(steps[0]), store, book, now)
        for step in steps[1:]:
            wizard._follow(step)
        if len(steps) > 1:
            # All effects but the last were complete before the step after them was written.
            wizard._put_into_effect(steps[-1])
        wizard._turn_to_instrument()
        return wizard

    def _set_up(
        self, header: Header, store: CertificateStore, book: Journal, now: Callable[[], datetime]
    ) -> None:
        self._header = header
        self._store = store
        self._journal = book
        self._now = now
        self._states = [State.beginning(header.plan, header.mode)]
        self._steps: list[Step] = []
        self._undone: Step | None = None
        self._slicer = Slicer(header.plan.channels)
        self._in_force = store.in_force()
        self._watch: HandWatch | None = None
        self._look = Look()
        self._armed = False
        self._held = False
        self._since: float | None = None
        self._message = ""
        self._tone: Tone = ""
        self._event = 0
        self._judged: tuple[object, Judgment] | None = None
        self._made: dict[str, Certificate] = {}

    # What comes in.

    def feed(self, block: Block) -> None:
        """Take samples: ``<channel>_volts`` of the instruments, and ``excitation``."""
        for one in self._slicer.feed(block):
            self._live(one)

    def act(self, action: Action) -> None:
        """Do what the crew asks; what is not possible now is said in the view's message."""
        if action.kind not in self.view.can:
            self._say(f"{action.kind.replace('_', ' ')} is not possible now", "error")
            return
        _HANDLERS[action.kind](self, action)

    @property
    def state(self) -> State:
        """Return how far the calibration has come."""
        return self._states[-1]

    @property
    def who(self) -> str:
        """Return who takes the readings."""
        return self._header.who

    # Steps.

    def _step(self, kind: str, channel: str = "", **data: Any) -> None:
        """Make a step: on the disk first, then in the state, then in the store."""
        step = Step(kind=kind, channel=channel, stamp=self._now(), data=data)
        self._journal.append(step)
        before = self.state.channel
        self._follow(step)
        self._put_into_effect(step)
        self._armed = False
        if self.state.channel != before:
            self._turn_to_instrument()
        elif self._watch is not None:
            self._watch.restart()
        self._look = Look()
        self._since = None

    def _follow(self, step: Step) -> None:
        if step.kind == "undo":
            self._states.pop()
            self._undone = self._steps.pop()
            return
        self._states.append(self.state.after(step))
        self._steps.append(step)

    def _put_into_effect(self, step: Step) -> None:
        """Do in the store what a step stands for; doing so twice changes nothing."""
        if self._header.mode == "check":
            return
        if step.kind == "accept":
            certificate = self._judge(step.channel, step.stamp).certificate
            if certificate is not None:
                self._store.put(certificate)
                self._made[step.channel] = certificate
        elif step.kind == "skip":
            reason = str(step.data["reason"])
            self._store.skip(step.channel, reason, self.who, step.stamp)
            self._made.pop(step.channel, None)
        elif step.kind == "undo" and self._undone is not None:
            undone = self._undone
            if undone.kind in ("accept", "skip"):
                self._store.revert(undone.channel, undone.stamp)
                self._made.pop(undone.channel, None)
        else:
            return
        self._in_force = self._store.in_force()

    def _turn_to_instrument(self) -> None:
        instrument = self.state.instrument
        self._since = None
        self._watch = None
        if instrument is not None and instrument.by_hand:
            self._watch = HandWatch(instrument, self._in_force.get(instrument.channel))

    def _say(self, message: str, tone: Tone) -> None:
        self._message, self._tone = message, tone
        self._event += 1

    # What happens by itself.

    def _live(self, one: Slice) -> None:
        if self._since is None:
            self._since = one.start
        phase = self.phase
        if phase == "begin":
            if one.present and one.end - self._since >= _BEGIN:
                self._step("begin")
            return
        instrument = self.state.instrument
        if self._watch is None or instrument is None:
            return
        self._watch.feed(one.times, one.volts[instrument.channel], one.excitation)
        if phase == "sign":
            self._look_for_sign(confirmed=False)
        elif phase == "points":
            self._look_for_point()
        elif phase == "fit" and not self._held and one.end - self._since >= _SHOWN:
            judgment = self._judge(instrument.channel)
            if judgment.certificate is not None and not judgment.doubts:
                self._accept(instrument)

    def _look_for_sign(self, *, confirmed: bool) -> None:
        instrument, watch = self._at_hand()
        self._look = watch.look_for_sign(confirmed=confirmed)
        data = self._look.data
        if data is not None:
            self._step("sign", instrument.channel, **data)
            way = "rise" if data["rising"] else "fall"
            self._say(f"sign proven: volts {way} with {instrument.positive}", "taken")

    def _look_for_point(self) -> None:
        instrument, watch = self._at_hand()
        work = self._work()
        at = work.open_slots[0]
        self._look = watch.look_for_point(work, at, by_key=self._armed)
        if self._look.data is not None and (self._header.auto or self._armed):
            self._take_point(instrument, work, at, self._look)

    def _take_point(self, instrument: InstrumentPlan, work: HandWork, at: int, look: Look) -> None:
        assert look.data is not None  # noqa: S101 - asked by the callers
        self._step("point", instrument.channel, **look.data)
        taken = self._work().points[-1]
        self._say(words.taken_words(instrument, taken, work.slots[at], look.hint), "taken")

    def _accept(self, instrument: InstrumentPlan) -> None:
        self._step("accept", instrument.channel)
        self._held = False
        self._say(f"{instrument.title}: certificate in force", "taken")

    # What the crew does.

    def _take(self) -> None:
        phase = self.phase
        if phase == "sign":
            self._look_for_sign(confirmed=True)
            if self._look.hint:
                self._say("no movement was seen: move it, then take", "error")
            return
        self._armed = True
        self._look_for_point()
        if self._armed:
            text = {
                "absent": "there are no volts",
                "clipped": "the volts are at the end of the converter's range; this cannot be used",
            }.get(self._look.hint)
            self._armed = text is None
            self._say(text or "hold still: taken as soon as it rests", "error" if text else "")

    def _remove(self, kind: str, index: int | None) -> None:
        instrument, _ = self._at_hand()
        points = self._work().points
        at = len(points) - 1 if index is None else index
        if not 0 <= at < len(points):
            self._say(f"there is no point {at + 1}", "error")
            return
        self._step(kind, instrument.channel, index=at)
        gone = instrument.setting_words(points[at].value)
        what = "again" if kind == "repeat" else "deleted"
        self._say(f"point at {gone} {what}", "")

    def _add(self, action: Action) -> None:
        instrument, _ = self._at_hand()
        if action.value is None:
            self._say("say at which setting a point is to be added", "error")
            return
        self._step("add", instrument.channel, value=float(action.value))
        self._say(f"added: {instrument.setting_words(action.value)}", "")

    def _undo(self) -> None:
        undone = self._steps[-1]
        self._step("undo", undone.channel)
        self._held = True
        title = f" of {self._header.plan[undone.channel].title}" if undone.channel else ""
        self._say(f"taken back: {undone.kind.replace('_', ' ')}{title}", "")

    def _back(self) -> None:
        channels = self._header.plan.channels
        at = channels.index(self.state.channel) if self.state.channel else len(channels)
        self._open(channels[at - 1])

    def _open_asked(self, action: Action) -> None:
        if action.channel not in self._header.plan.channels:
            self._say(f"the plan has no instrument '{action.channel}'", "error")
            return
        self._open(action.channel)

    def _open(self, channel: str) -> None:
        self._step("open", channel)
        self._held = True
        self._say(self._header.plan[channel].title, "")

    def _next(self) -> None:
        if self.phase == "begin":
            self._step("begin")
            return
        if self.phase == "points":
            instrument, _ = self._at_hand()
            at = self._work().open_slots[0]
            self._step("leave_out", instrument.channel, slot=at)
            words_ = instrument.setting_words(self._work().slots[at].value)
            self._say(f"left out: {words_}", "")
            return
        channels = self._header.plan.channels
        at = channels.index(self.state.channel)
        self._open(channels[(at + 1) % len(channels)])

    def _skip(self, action: Action) -> None:
        instrument = self.state.instrument
        assert instrument is not None  # noqa: S101 - only possible with one at hand
        self._step("skip", instrument.channel, reason=action.reason or "not calibrated today")
        self._held = False
        self._say(f"{instrument.title} is uncalibrated", "error")

    def _confirm_sign(self, action: Action) -> None:
        if action.yes:
            self._take()
            return
        _, watch = self._at_hand()
        watch.restart()
        self._look = Look()
        self._say("move it once more", "")

    def _choose_degree(self, action: Action) -> None:
        instrument, _ = self._at_hand()
        self._step("degree", instrument.channel, degree=action.degree)
        self._held = True
        self._say(
            "degree by the evidence" if action.degree is None else f"degree {action.degree}", ""
        )

    def _accept_now(self) -> None:
        instrument, _ = self._at_hand()
        self._accept(instrument)

    def _abort(self) -> None:
        self._step("abort")
        self._say("broken off: the certificates in force stay in force", "")

    # What is to be shown.

    @property
    def phase(self) -> Phase:
        """Return which page it is."""
        state = self.state
        if state.aborted:
            return "aborted"
        if not state.begun:
            return "begin"
        if state.done:
            return "done"
        work = state.work.get(state.channel)
        if work is None:
            return "fit"
        if work.rising is None:
            return "sign"
        return "points" if work.open_slots else "fit"

    @property
    def view(self) -> WizardView:
        """Return the wizard as it is to be shown."""
        phase, state, plan = self.phase, self.state, self._header.plan
        instrument = state.instrument
        work = state.work.get(state.channel)
        slot = work.remaining[0] if work is not None and phase == "points" else None
        judgment = self._judge(state.channel) if work is not None else Judgment()
        prompt, spoken = self._prompt(phase, instrument, work)
        closed = len(state.closed)
        share = 0.0
        if work is not None and state.channel not in state.closed and work.slots:
            share = 1.0 - len(work.open_slots) / len(work.slots)
        return WizardView(
            instrument=instrument,
            index=plan.channels.index(state.channel) if state.channel else closed,
            count=len(plan.channels),
            phase=phase,
            prompt=prompt,
            spoken=spoken,
            target=None if slot is None else slot.value,
            direction="single" if slot is None else slot.direction,
            reading=None if self._watch is None else self._watch.reading,
            value_now=None if self._watch is None else self._watch.value_now(),
            points=() if work is None else tuple(taken.point for taken in work.points),
            remaining=() if work is None else work.remaining,
            calibration=judgment.calibration,
            drift=judgment.drift,
            degree=None if work is None else work.degree,
            sentences=judgment.doubts,
            can=self._can(phase, work),
            progress=1.0 if phase == "done" else (closed + share) / len(plan.channels),
            accepted=tuple(state.accepted),
            skipped=dict(state.skipped),
            certificates=dict(self._made),
            message=self._message,
            tone=self._tone,
            event=self._event,
        )

    def _can(self, phase: Phase, work: HandWork | None) -> frozenset[str]:
        can = {"undo"} if self._steps and phase != "aborted" else set()
        if phase in ("begin", "sign", "points", "fit"):
            can |= {"abort", "open", "next"}
        if phase in ("sign", "points", "fit"):
            can |= {"skip", "back"}
        if phase in ("sign", "points"):
            can.add("take")
        if phase == "sign":
            can.add("confirm_sign")
        if phase in ("points", "fit"):
            can.add("add")
            if work is not None and work.points:
                can |= {"repeat", "delete"}
        if phase == "fit":
            can |= {"choose_degree"}
            if self._judge(self.state.channel).certificate is not None:
                can.add("accept")
        if phase == "done":
            can |= {"open", "back"}
        return frozenset(can)

    def _prompt(
        self, phase: Phase, instrument: InstrumentPlan | None, work: HandWork | None
    ) -> tuple[str, str]:
        if phase == "begin":
            return "Waiting for the volts of the aircraft.", "Waiting"
        if phase == "aborted":
            return "Broken off: the certificates in force stay in force.", "Broken off"
        if instrument is None or work is None:
            return "All instruments are done.", "Done"
        if phase == "sign":
            return (
                words.sign_prompt(instrument, self._look.hint),
                words.sign_spoken(instrument, self._look.hint),
            )
        if phase == "points":
            slot = work.remaining[0]
            return (
                words.point_prompt(instrument, slot, self._look),
                words.point_spoken(instrument, slot, self._look),
            )
        judgment = self._judge(instrument.channel)
        if judgment.doubts or self._held:
            return f"{instrument.title}: accept the curve, or mend its points.", "Look at the curve"
        return f"{instrument.title} is good; go on to the next.", f"{instrument.title} good"

    def _judge(self, channel: str, stamp: datetime | None = None) -> Judgment:
        """Return what the points come to; worked out once for each set of points."""
        work = self.state.work[channel]
        if stamp is None and self._judged is not None and self._judged[0] is work:
            return self._judged[1]
        judgment = judge(
            self._header.plan[channel],
            work,
            self._in_force.get(channel),
            who=self._header.who,
            stamp=stamp or self._now(),
            temperature=self._header.temperature,
        )
        if stamp is None:
            self._judged = (work, judgment)
        return judgment

    def _at_hand(self) -> tuple[InstrumentPlan, HandWatch]:
        instrument = self.state.instrument
        assert instrument is not None  # noqa: S101 - asked by `can`
        assert self._watch is not None  # noqa: S101
        return instrument, self._watch

    def _work(self) -> HandWork:
        return self.state.work[self.state.channel]


_HANDLERS: Mapping[ActionKind, Callable[[Wizard, Action], None]] = {
    "take": lambda wizard, _: wizard._take(),
    "repeat": lambda wizard, action: wizard._remove("repeat", action.index),
    "delete": lambda wizard, action: wizard._remove("delete", action.index),
    "add": Wizard._add,
    "undo": lambda wizard, _: wizard._undo(),
    "back": lambda wizard, _: wizard._back(),
    "next": lambda wizard, _: wizard._next(),
    "skip": Wizard._skip,
    "confirm_sign": Wizard._confirm_sign,
    "choose_degree": Wizard._choose_degree,
    "accept": lambda wizard, _: wizard._accept_now(),
    "abort": lambda wizard, _: wizard._abort(),
    "open": Wizard._open_asked,
}


def unfinished(journal: Path) -> bool:
    """Return whether a journal holds a calibration that was begun and neither ended nor aborted."""
    steps = Journal(journal).read()
    if not steps or steps[0].kind != "calibration":
        return False
    header = _header_of(steps[0])
    states = [State.beginning(header.plan, header.mode)]
    for step in steps[1:]:
        if step.kind == "undo":
            states.pop()
        else:
            states.append(states[-1].after(step))
    return not (states[-1].done or states[-1].aborted)


def _header_content(header: Header) -> Mapping[str, Any]:
    return {
        "plan": plan_content(header.plan),
        "mode": header.mode,
        "who": header.who,
        "temperature": header.temperature,
        "auto": header.auto,
    }


def _header_of(step: Step) -> Header:
    data = step.data
    return Header(
        plan=plan_of(data["plan"]),
        mode=data["mode"],
        who=data["who"],
        temperature=data["temperature"],
        auto=data["auto"],
    )

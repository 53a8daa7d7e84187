"""The wizard: samples and actions in, a frozen view out. No window, no clock of its own.

Samples are cut into tenths of a second of flight time before anything looks at them, so that what
the wizard does by itself follows from what was sampled, not from how it came in.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields
from datetime import datetime
from pathlib import Path
from typing import Any

from calibration.certificate_store import CertificateStore
from calibration.plan import CalibrationPlan
from calibration.points import CalibrationError
from calibration.settings import WIZARD
from calibration.wizard import wizard_text
from calibration.wizard.journal import JournalStep
from calibration.wizard.procedure import (
    ActionFeedback,
    CalibrationOutcome,
    CalibrationProcedure,
    FeedbackTone,
    SampleSlice,
    SampleSlicer,
    StepDraft,
    WizardAction,
    WizardActionKind,
    WizardPhase,
    WizardView,
)
from calibration.wizard.state import CalibrationMode, GroupProgress, InstrumentGroup, WizardState
from calibration.wizard.step_executor import StepExecutor, create_procedure
from gsapp.quantities import Block

_SHOWN: Mapping[CalibrationMode, float] = {"full": 3.0, "check": 0.5}
"""Seconds for which a good result is shown before it is accepted by itself."""
_POINT_EDIT_ACTIONS = ("repeat", "delete", "add", "choose_degree")
"""Actions of a crew that looks into a result: it is not accepted under its hands."""


class CalibrationWizard:
    """Leads through the calibration of an aircraft.

    Parameters
    ----------
    store : CertificateStore
        Where certificates go.
    journal : Path
        Every step is kept there as it is taken. A former journal is set aside, not lost.
    mode : {"full", "check"}
        All settings, or the three-point check of surfaces and vanes.
    auto : bool
        Whether points are taken by themselves once the instrument rests where it was asked to.

    Raises
    ------
    CalibrationError
        If the journal cannot be written, or there is nothing to calibrate or to check.
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
        mode: CalibrationMode = "full",
        auto: bool = True,
    ) -> None:
        ledger = StepExecutor.create(
            plan,
            store,
            journal,
            who=who,
            temperature=temperature,
            mode=mode,
            auto=auto,
            stamp=now(),
        )
        self._set_up(ledger, now)

    @classmethod
    def resume(
        cls, journal: Path, store: CertificateStore, *, now: Callable[[], datetime]
    ) -> CalibrationWizard:
        """Go on with a calibration at the point where it stopped, however it stopped.

        Raises
        ------
        CalibrationError
            If there is none that could go on.
        """
        wizard = object.__new__(cls)
        wizard._set_up(StepExecutor.resume(journal, store), now)
        wizard._held = wizard.phase == "fit"
        return wizard

    def _set_up(self, ledger: StepExecutor, now: Callable[[], datetime]) -> None:
        self._ledger = ledger
        self._now = now
        self._slicer = SampleSlicer(ledger.header.plan.channels)
        self._station: CalibrationProcedure[Any] | None = None
        self._held = False
        self._since: float | None = None
        self._end: float | None = None
        self._message = ""
        self._tone: FeedbackTone = ""
        self._event = 0
        self._judged: tuple[tuple[object, ...], CalibrationOutcome] | None = None
        self._turn_to_group()

    # What comes in.

    def feed(self, block: Block) -> None:
        """Take samples: ``<channel>_volts`` of the instruments, and ``excitation``.

        Raises
        ------
        CalibrationError
            If what was taken cannot be written to the disk.
        """
        self._ledger.apply_pending()
        for one in self._slicer.feed(block):
            self._live(one)

    def act(self, action: WizardAction) -> None:
        """Do what the crew asks; what is not possible now is said in the view's message.

        Raises
        ------
        CalibrationError
            If it cannot be written to the disk.
        """
        self._ledger.apply_pending()
        if action.kind not in self._can():
            self._say(f"{action.kind.replace('_', ' ')} is not possible now", "error")
            return
        station, state = self._station, self.state
        if station is not None and action.kind in station.available_actions(
            state.progress[state.current_key]
        ):
            answer = station.act(state.progress[state.current_key], action)
            self._answer(answer)
            self._held = self._held or (
                isinstance(answer, StepDraft) and action.kind in _POINT_EDIT_ACTIONS
            )
            return
        _HANDLERS[action.kind](self, action)

    @property
    def state(self) -> WizardState:
        return self._ledger.state

    # Steps.

    def _step(self, kind: str, key: str = "", data: Mapping[str, Any] | None = None) -> None:
        before = self.state
        step = JournalStep(kind=kind, channel=key, stamp=self._now(), data=data or {})
        try:
            self._ledger.execute(step)
        finally:
            if self.state is not before:
                self._since = None
                self._go_on(before.current_key)

    def _go_on(self, before: str) -> None:
        """Watch the same group anew, or the next."""
        if self._station is None or self.state.current_key != before:
            self._turn_to_group()
        else:
            self._station.restart()

    def _turn_to_group(self) -> None:
        group = self.state.group
        self._station = None
        if group is not None:
            self._station = create_procedure(group, self._ledger.header, self._ledger.reference)

    def _answer(self, answer: StepDraft | ActionFeedback | None) -> None:
        if isinstance(answer, StepDraft):
            self._step(answer.kind, self.state.current_key, answer.data)
        if answer is not None:
            self._say(answer.message, answer.tone)

    def _say(self, message: str, tone: FeedbackTone) -> None:
        self._message, self._tone = message, tone
        self._event += 1

    # What happens by itself.

    def _live(self, one: SampleSlice) -> None:
        gap = self._end is not None and abs(one.start - self._end) > WIZARD.max_gap
        self._end = one.end
        if self._since is None or gap:
            self._since = one.start
        if self.phase == "begin":
            if one.present and one.end - self._since >= WIZARD.start_time:
                self._step("begin")
            return
        if gap:
            self._turn_to_group()
        station, state = self._station, self.state
        if station is None:
            return
        station.feed(one)
        work = state.progress[state.current_key]
        answer = station.automatic_step(work)
        if isinstance(answer, StepDraft):
            self._held = False
        self._answer(answer)
        if self.phase == "fit" and not self._held and self._since is not None:
            shown = one.end - self._since >= _SHOWN[self._ledger.header.mode]
            outcome = self._outcome()
            if shown and outcome.ready and not outcome.issues:
                self._accept()

    # What the crew does, whatever the instrument.

    def _next(self) -> None:
        if self.phase == "begin":
            self._step("begin")
            return
        self._open(self._following())

    def _back(self) -> None:
        groups = self.state.groups
        self._open(groups[self._index() - 1])

    def _open_asked(self, action: WizardAction) -> None:
        try:
            self._open(self.state.find_group(action.channel))
        except CalibrationError as error:
            self._say(str(error), "error")

    def _open(self, group: InstrumentGroup) -> None:
        self._step("open", group.key)
        self._held = True
        self._say(group.title, "")

    def _skip(self, action: WizardAction) -> None:
        group = self._group()
        full = self._ledger.header.mode == "full"
        reason = action.reason or ("not calibrated" if full else "not checked")
        uncalibrated = dict.fromkeys(group.channels, reason)
        self._step("skip", group.key, {"certified": [], "uncalibrated": uncalibrated})
        self._held = False
        self._say(f"{group.title}: {'uncalibrated' if full else 'not checked'}", "error")

    def _accept(self) -> None:
        group, outcome = self._group(), self._outcome()
        certified = [one.channel for one in outcome.certificates]
        if outcome.check_result is not None:
            certified = [group.key]
        data = {"certified": certified, "uncalibrated": dict(outcome.uncalibrated)}
        self._step("accept", group.key, data)
        self._held = False
        done = "certificate in force" if outcome.check_result is None else "checked"
        self._say(f"{group.title}: {done}", "taken")

    def _undo(self) -> None:
        undone = self._ledger.last_step
        if undone is None:
            return
        self._step("undo", undone.channel)
        self._held = True
        title = f" of {self.state.find_group(undone.channel).title}" if undone.channel else ""
        self._say(f"undone: {undone.kind.replace('_', ' ')}{title}", "")

    def _abort(self) -> None:
        self._step("abort")
        self._say("stopped: the certificates in force stay in force", "")

    # What is to be shown.

    @property
    def phase(self) -> WizardPhase:
        state = self.state
        if state.aborted:
            return "aborted"
        if not state.begun:
            return "begin"
        if self._station is None:
            return "done"
        return self._station.phase(state.progress[state.current_key])

    @property
    def view(self) -> WizardView:
        state, phase = self.state, self.phase
        outcome = self._outcome()
        parts: dict[str, Any] = {}
        if self._station is not None:
            shown = self._station.build_view(state.progress[state.current_key], outcome)
            parts = {one.name: getattr(shown, one.name) for one in fields(shown)}
        faults = [one.sentence for one in parts.get("faults", ())]
        today, checks = self._ledger.reference.current, self._ledger.accepted_checks()
        place = _PHASE_TEXT.get(phase, {})
        if phase == "done":
            plan = self._ledger.header.plan
            place = (
                wizard_text.check_summary_text(plan, checks)
                if self._ledger.header.mode == "check"
                else wizard_text.calibration_summary_text(plan, state.accepted)
            )
        return WizardView(
            **{"instrument": None, **place, **parts},
            index=self._index(),
            count=len(state.groups),
            phase=phase,
            mode=self._ledger.header.mode,
            calibration=outcome.calibration,
            drift=outcome.drift,
            check_result=outcome.check_result,
            problems=(*faults, *parts.get("warnings", ()), *outcome.issues),
            remarks=outcome.remarks,
            accepted_checks=checks,
            available_actions=self._can(),
            progress=self._progress(),
            accepted=state.accepted,
            skipped=state.skipped,
            certificates={name: today[name] for name in state.accepted if name in today},
            message=self._message,
            tone=self._tone,
            event_count=self._event,
        )

    def _can(self) -> frozenset[str]:
        state, phase = self.state, self.phase
        if phase == "aborted":
            return frozenset()
        can = {"undo"} if self._ledger.last_step is not None else set()
        if phase == "begin":
            return frozenset(can | {"abort", "open", "next"})
        can.add("open")
        if self._index() > 0:
            can.add("back")
        if self._station is None:
            return frozenset(can)
        can |= {
            "abort",
            "skip",
            *self._station.available_actions(state.progress[state.current_key]),
        }
        if self._following().key != state.current_key:
            can.add("next")
        if phase == "fit" and self._outcome().ready:
            can.add("accept")
        return frozenset(can)

    def _outcome(self) -> CalibrationOutcome:
        """Return what the work at hand comes to; worked out once for each state of it."""
        state = self.state
        if self._station is None:
            return CalibrationOutcome()
        work: GroupProgress = state.progress[state.current_key]
        basis = (work, state.ground_air, self._ledger.reference)
        if self._judged is None or any(
            one is not other for one, other in zip(self._judged[0], basis, strict=True)
        ):
            self._judged = basis, self._station.outcome(work, self._now(), state.ground_air)
        return self._judged[1]

    def _progress(self) -> float:
        state = self.state
        if state.done:
            return 1.0
        shares = [
            1.0 if group.key in state.closing_steps else state.progress[group.key].fraction_done
            for group in state.groups
        ]
        return sum(shares) / len(shares)

    def _index(self) -> int:
        keys = [group.key for group in self.state.groups]
        return (
            keys.index(self.state.current_key)
            if self.state.current_key
            else len(keys) * self.state.begun
        )

    def _following(self) -> InstrumentGroup:
        key = self.state.advance_from(self.state.current_key).current_key or self.state.current_key
        return self.state.find_group(key)

    def _group(self) -> InstrumentGroup:
        group = self.state.group
        assert group is not None  # noqa: S101 - asked by `can`
        return group


_PHASE_TEXT: Mapping[str, Mapping[str, str]] = {
    "begin": {"prompt": "Waiting for sensor voltages.", "spoken": "Waiting"},
    "aborted": {
        "prompt": "Stopped: the certificates in force stay in force.",
        "spoken": "Stopped",
    },
}

_HANDLERS: Mapping[WizardActionKind, Callable[[CalibrationWizard, WizardAction], None]] = {
    "undo": lambda wizard, _: wizard._undo(),
    "back": lambda wizard, _: wizard._back(),
    "next": lambda wizard, _: wizard._next(),
    "skip": CalibrationWizard._skip,
    "accept": lambda wizard, _: wizard._accept(),
    "abort": lambda wizard, _: wizard._abort(),
    "open": CalibrationWizard._open_asked,
}

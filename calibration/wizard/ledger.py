"""What was done in a calibration: journal, states, and what they mean for the certificates.

A step is on the disk before it counts; then the state follows; then the store. A program that is
killed in between finds the step in the journal, and puts it into effect once more, which changes
nothing where it was done already.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import Any

from calibration.certificate import Certificate
from calibration.checked import Checked
from calibration.comparing import CheckResult, tells_branches
from calibration.plan import CalibrationPlan
from calibration.points import CalibrationError
from calibration.reading import load_certificates
from calibration.store import CertificateStore
from calibration.wizard.journal import Journal, Step
from calibration.wizard.json_forms import content_of, plan_of
from calibration.wizard.schedule import Mode
from calibration.wizard.state import State
from calibration.wizard.station import Header, Outcome, Reference
from calibration.wizard.stations import station_of

_BEGINNING = "calibration"
"""Kind of the first line of a journal."""


class Track:
    """The states that steps lead to, and the way back through them.

    Parameters
    ----------
    beginning : State
        Before the first step.
    """

    def __init__(self, beginning: State) -> None:
        self._states = [beginning]
        self.steps: list[Step] = []
        self.undone: Step | None = None

    @property
    def state(self) -> State:
        """Return how far it has come."""
        return self._states[-1]

    def follow(self, step: Step) -> None:
        """Take a step.

        Raises
        ------
        CalibrationError
            If it cannot be taken from here.
        """
        try:
            if step.kind == "undo":
                self.undone = self.steps.pop()
                self._states.pop()
            else:
                self._states.append(self.state.after(step))
                self.steps.append(step)
        except (KeyError, IndexError, TypeError, ValueError) as error:
            raise CalibrationError(
                f"the step '{step.kind}' of {step.stamp:%Y-%m-%d %H:%M:%S} does not follow from "
                "those before it; the journal was written by another version, begin a new one"
            ) from error


class Ledger:
    """Keeps the steps of one calibration.

    Use `begin` or `resume`.

    Attributes
    ----------
    header : Header
        What it is.
    reference : Reference
        What readings are held against.
    """

    def __init__(
        self,
        header: Header,
        former: Mapping[str, Certificate],
        store: CertificateStore,
        journal: Journal,
    ) -> None:
        self.header = header
        self._store = store
        self._journal = journal
        self._track = Track(_beginning(header))
        self._pending: Step | None = None
        self._checked: tuple[object, dict[str, CheckResult]] | None = None
        nominal = load_certificates(header.plan.nominal) if header.plan.nominal else {}
        self.reference = Reference(former=former, today=store.in_force(), nominal=nominal)
        for group in self.state.groups:
            station_of(group, header, self.reference)

    @classmethod
    def begin(
        cls,
        plan: CalibrationPlan,
        store: CertificateStore,
        path: Path,
        *,
        who: str,
        temperature: float | None,
        mode: Mode,
        auto: bool,
        stamp: datetime,
    ) -> Ledger:
        """Begin a calibration; a former journal is set aside.

        Raises
        ------
        CalibrationError
            If there is nothing to do, or the journal cannot be written.
        """
        former = store.in_force()
        rising: dict[str, bool] = {}
        any_side: list[str] = []
        if mode == "check":
            plan = _checkable(plan, former, store.aircraft)
            rising = {name: sum(former[name].end_slopes) > 0.0 for name in plan.channels}
            any_side = [name for name in plan.channels if tells_branches(former[name])]
        header = Header(
            plan=plan,
            mode=mode,
            who=who,
            temperature=temperature,
            auto=auto,
            rising=rising,
            any_side=any_side,
        )
        known = {name: one for name, one in former.items() if name in plan.channels}
        ledger = cls(header, known, store, Journal(path))
        stamps = {name: one.stamp.isoformat() for name, one in known.items()}
        journal = Journal(path)
        journal.set_aside()
        data = {**content_of(header), "former": stamps}
        journal.append(Step(kind=_BEGINNING, stamp=stamp, data=data))
        return ledger

    @classmethod
    def resume(cls, path: Path, store: CertificateStore) -> Ledger:
        """Go on with the calibration of a journal.

        Raises
        ------
        CalibrationError
            If it holds none that could go on.
        """
        journal = Journal(path)
        steps = journal.recover()
        header = _header_of(steps, path)
        former: dict[str, Certificate] = {}
        for name, text in steps[0].data["former"].items():
            certificate = store.dated(name, datetime.fromisoformat(text))
            if certificate is not None:
                former[name] = certificate
        ledger = cls(header, former, store, journal)
        for step in steps[1:]:
            ledger._track.follow(step)
        if len(steps) > 1:
            # All effects but the last were complete before the step after them was written.
            ledger._pending = steps[-1]
            ledger.settle()
        return ledger

    @property
    def state(self) -> State:
        """Return how far the calibration has come."""
        return self._track.state

    @property
    def last(self) -> Step | None:
        """Return the step that undo would take back."""
        return self._track.steps[-1] if self._track.steps else None

    def make(self, step: Step) -> None:
        """Make a step: on the disk, then in the state, then in the store.

        Raises
        ------
        CalibrationError
            If the journal cannot be written: then it was not made. If the certificates cannot be
            written: then it was, and `settle` tries again.
        """
        self.settle()
        self._journal.append(step)
        self._track.follow(step)
        self._pending = step
        self.settle()

    def settle(self) -> None:
        """Do in the store what the last step stands for, unless it was done already."""
        step = self._pending
        if step is None:
            return
        try:
            if step.kind == "accept":
                self._accept(step)
            elif step.kind == "skip" and self.header.mode == "full":
                self._mark(step)
            elif step.kind == "undo":
                self._take_back(self._track.undone)
        except OSError as error:
            raise CalibrationError(
                f"the certificates of {self._store.aircraft} cannot be written "
                f"({error.strerror}); make room on the disk, the wizard tries again by itself"
            ) from error
        self._pending = None

    def outcome(self, key: str, stamp: datetime) -> Outcome:
        """Return what the work of a group comes to."""
        state = self.state
        station = station_of(state.find(key), self.header, self.reference)
        return station.outcome(state.work[key], stamp, state.air)

    def checks(self) -> dict[str, CheckResult]:
        """Return what the three-point checks found that were accepted."""
        closings = self.state.closings
        if self.header.mode == "full":
            return {}
        if self._checked is None or self._checked[0] is not closings:
            outcomes = {
                key: self.outcome(key, step.stamp)
                for key, step in closings.items()
                if step.kind == "accept"
            }
            results = {key: one.check for key, one in outcomes.items() if one.check is not None}
            self._checked = closings, results
        return self._checked[1]

    def _accept(self, step: Step) -> None:
        outcome = self.outcome(step.channel, step.stamp)
        if outcome.check is not None:
            certificate = self.reference.former[step.channel]
            checked = Checked(
                channel=step.channel,
                who=self.header.who,
                stamp=step.stamp,
                certificate=certificate.stamp,
                unit=certificate.unit,
                result=outcome.check,
            )
            self._store.record_check(checked)
            return
        for certificate in outcome.certificates:
            self._store.put(certificate)
        self._mark(step)

    def _mark(self, step: Step) -> None:
        """Mark as uncalibrated what a step leaves so."""
        for name, reason in step.data["uncalibrated"].items():
            self._store.skip(name, reason, self.header.who, step.stamp)
        self._renew()

    def _take_back(self, undone: Step | None) -> None:
        if undone is None or undone.kind not in ("accept", "skip"):
            return
        if self.header.mode == "check":
            self._store.withdraw_check(undone.channel, undone.stamp)
            return
        for name in (*undone.data["certified"], *undone.data["uncalibrated"]):
            self._store.revert(name, undone.stamp)
        self._renew()

    def _renew(self) -> None:
        self.reference = Reference(
            former=self.reference.former,
            today=self._store.in_force(),
            nominal=self.reference.nominal,
        )


def unfinished(journal: Path) -> bool:
    """Return whether a journal holds a calibration that was begun, and has not come to its end."""
    steps = Journal(journal).read()
    try:
        header = _header_of(steps, journal)
        track = Track(_beginning(header))
        for step in steps[1:]:
            track.follow(step)
    except CalibrationError:
        return False
    return not track.state.ended


def _beginning(header: Header) -> State:
    return State.beginning(header.plan, header.mode, rising=header.rising, any_side=header.any_side)


def _checkable(
    plan: CalibrationPlan, former: Mapping[str, Certificate], aircraft: str
) -> CalibrationPlan:
    """Return the plan of those instruments that have a certificate to be checked."""
    known = [one.channel for one in plan.instruments if one.by_hand and one.channel in former]
    if not known:
        raise CalibrationError(
            f"no surface or vane of {aircraft} has a certificate in force that could be checked; "
            "calibrate first"
        )
    return plan.of(known)


def _header_of(steps: Sequence[Step], path: Path) -> Header:
    if not steps or steps[0].kind != _BEGINNING:
        raise CalibrationError(f"{path} holds no calibration that could go on; begin a new one")
    content: dict[str, Any] = dict(steps[0].data)
    try:
        content.pop("former")
        return Header(**{**content, "plan": plan_of(content["plan"])})
    except (KeyError, TypeError) as error:
        raise CalibrationError(
            f"{path} was written by another version of the program; begin a new calibration"
        ) from error

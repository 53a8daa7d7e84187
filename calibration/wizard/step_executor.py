"""What was done in a calibration: journal, states, and what they mean for the certificates.

A step is on the disk before it counts; then the state follows; then the store. A program that is
killed in between finds the step in the journal, and puts it into effect once more, which changes
nothing where it was done already.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Any

from calibration.certificate import Certificate
from calibration.certificate_store import CertificateStore, CheckRecord
from calibration.certificate_toml import load_certificates
from calibration.drift import CheckResult, has_hysteresis
from calibration.plan import CalibrationPlan
from calibration.points import CalibrationError
from calibration.wizard.accelerometer_procedure import AccelerometerProcedure
from calibration.wizard.angle_procedure import AngleProcedure
from calibration.wizard.gyro_procedure import GyroProcedure
from calibration.wizard.journal import Journal, JournalStep, plan_from_json, to_json_content
from calibration.wizard.pressure_procedure import PressureProcedure
from calibration.wizard.procedure import (
    CalibrationOutcome,
    CalibrationProcedure,
    JournalHeader,
    ReferenceCertificates,
)
from calibration.wizard.state import CalibrationMode, InstrumentGroup, WizardState


def create_procedure(
    group: InstrumentGroup, header: JournalHeader, reference: ReferenceCertificates
) -> CalibrationProcedure[Any]:
    """Return what looks after a group."""
    kind = group.instruments[0].kind
    if kind == "gyro":
        return GyroProcedure(group, header, reference)
    if kind == "accelerometer":
        return AccelerometerProcedure(group, header, reference)
    if kind == "pressure":
        return PressureProcedure(group, header, reference)
    return AngleProcedure(group.instruments[0], header, reference)


_HEADER_KIND = "calibration"
"""Kind of the first line of a journal."""


class StepHistory:
    """The states that steps lead to, and the way back through them."""

    def __init__(self, beginning: WizardState) -> None:
        self._states = [beginning]
        self.steps: list[JournalStep] = []
        self.undone: JournalStep | None = None

    @property
    def state(self) -> WizardState:
        return self._states[-1]

    def apply(self, step: JournalStep) -> None:
        """Take a step."""
        try:
            if step.kind == "undo":
                self.undone = self.steps.pop()
                self._states.pop()
            else:
                self._states.append(self.state.apply(step))
                self.steps.append(step)
        except (KeyError, IndexError, TypeError, ValueError) as error:
            raise CalibrationError(
                f"the step '{step.kind}' of {step.stamp:%Y-%m-%d %H:%M:%S} does not follow from "
                "the steps before; the journal is from another version; start a new calibration"
            ) from error


class StepExecutor:
    """Keeps the steps of one calibration.

    Use `begin` or `resume`.
    """

    def __init__(
        self,
        header: JournalHeader,
        former: Mapping[str, Certificate],
        store: CertificateStore,
        journal: Journal,
    ) -> None:
        self.header = header
        self._store = store
        self._journal = journal
        self._track = StepHistory(_initial_state(header))
        self._pending: JournalStep | None = None
        self._checked: tuple[object, dict[str, CheckResult]] | None = None
        nominal = load_certificates(header.plan.nominal) if header.plan.nominal else {}
        self.reference = ReferenceCertificates(
            former=former, current=store.in_force(), nominal=nominal
        )
        for group in self.state.groups:
            create_procedure(group, header, self.reference)

    @classmethod
    def create(
        cls,
        plan: CalibrationPlan,
        store: CertificateStore,
        path: Path,
        *,
        who: str,
        temperature: float | None,
        mode: CalibrationMode,
        auto: bool,
        stamp: datetime,
    ) -> StepExecutor:
        """Begin a calibration; a former journal is set aside."""
        former = store.in_force()
        rising: dict[str, bool] = {}
        any_side: list[str] = []
        if mode == "check":
            plan = _checkable_plan(plan, former, store.aircraft)
            rising = {name: sum(former[name].end_slopes) > 0.0 for name in plan.channels}
            any_side = [name for name in plan.channels if has_hysteresis(former[name])]
        header = JournalHeader(
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
        data = {**to_json_content(header), "former": stamps}
        journal.append(JournalStep(kind=_HEADER_KIND, stamp=stamp, data=data))
        return ledger

    @classmethod
    def resume(cls, path: Path, store: CertificateStore) -> StepExecutor:
        """Go on with the calibration of a journal."""
        journal = Journal(path)
        steps = journal.recover()
        header = _parse_header(steps, path)
        former: dict[str, Certificate] = {}
        for name, text in steps[0].data["former"].items():
            certificate = store.find_by_stamp(name, datetime.fromisoformat(text))
            if certificate is not None:
                former[name] = certificate
        ledger = cls(header, former, store, journal)
        for step in steps[1:]:
            ledger._track.apply(step)
        if len(steps) > 1:
            # All effects but the last were complete before the step after them was written.
            ledger._pending = steps[-1]
            ledger.apply_pending()
        return ledger

    @property
    def state(self) -> WizardState:
        return self._track.state

    @property
    def last_step(self) -> JournalStep | None:
        return self._track.steps[-1] if self._track.steps else None

    def execute(self, step: JournalStep) -> None:
        """Make a step: on the disk, then in the state, then in the store.

        Raises
        ------
        CalibrationError
            If the journal cannot be written: then it was not made. If the certificates cannot be
            written: then it was, and `apply_pending` tries again.
        """
        self.apply_pending()
        self._journal.append(step)
        self._track.apply(step)
        self._pending = step
        self.apply_pending()

    def apply_pending(self) -> None:
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
                f"({error.strerror}); free disk space; the wizard retries automatically"
            ) from error
        self._pending = None

    def outcome(self, key: str, stamp: datetime) -> CalibrationOutcome:
        """Return what the work of a group comes to."""
        state = self.state
        station = create_procedure(state.find_group(key), self.header, self.reference)
        return station.outcome(state.progress[key], stamp, state.ground_air)

    def accepted_checks(self) -> dict[str, CheckResult]:
        """Return what the three-point checks found that were accepted."""
        closings = self.state.closing_steps
        if self.header.mode == "full":
            return {}
        if self._checked is None or self._checked[0] is not closings:
            outcomes = {
                key: self.outcome(key, step.stamp)
                for key, step in closings.items()
                if step.kind == "accept"
            }
            results = {
                key: one.check_result
                for key, one in outcomes.items()
                if one.check_result is not None
            }
            self._checked = closings, results
        return self._checked[1]

    def _accept(self, step: JournalStep) -> None:
        outcome = self.outcome(step.channel, step.stamp)
        if outcome.check_result is not None:
            certificate = self.reference.former[step.channel]
            checked = CheckRecord(
                channel=step.channel,
                who=self.header.who,
                stamp=step.stamp,
                certificate=certificate.stamp,
                unit=certificate.unit,
                result=outcome.check_result,
            )
            self._store.record_check(checked)
            return
        for certificate in outcome.certificates:
            self._store.put_in_force(certificate)
        self._mark(step)

    def _mark(self, step: JournalStep) -> None:
        for name, reason in step.data["uncalibrated"].items():
            self._store.mark_uncalibrated(name, reason, self.header.who, step.stamp)
        self._renew()

    def _take_back(self, undone: JournalStep | None) -> None:
        if undone is None or undone.kind not in ("accept", "skip"):
            return
        if self.header.mode == "check":
            self._store.withdraw_check(undone.channel, undone.stamp)
            return
        for name in (*undone.data["certified"], *undone.data["uncalibrated"]):
            self._store.withdraw(name, undone.stamp)
        self._renew()

    def _renew(self) -> None:
        self.reference = replace(self.reference, current=self._store.in_force())


def has_unfinished_calibration(journal: Path) -> bool:
    """Return whether a journal holds a calibration that was begun, and has not come to its end."""
    steps = Journal(journal).read()
    try:
        header = _parse_header(steps, journal)
        track = StepHistory(_initial_state(header))
        for step in steps[1:]:
            track.apply(step)
    except CalibrationError:
        return False
    return not track.state.ended


def _initial_state(header: JournalHeader) -> WizardState:
    return WizardState.initial(
        header.plan, header.mode, rising=header.rising, any_side=header.any_side
    )


def _checkable_plan(
    plan: CalibrationPlan, former: Mapping[str, Certificate], aircraft: str
) -> CalibrationPlan:
    known = [
        one.channel for one in plan.instruments if one.is_angle_sensor and one.channel in former
    ]
    if not known:
        raise CalibrationError(
            f"no surface or vane of {aircraft} has a certificate in force to check; calibrate first"
        )
    return plan.select_channels(known)


def _parse_header(steps: Sequence[JournalStep], path: Path) -> JournalHeader:
    if not steps or steps[0].kind != _HEADER_KIND:
        raise CalibrationError(f"{path} contains no unfinished calibration; start a new one")
    content: dict[str, Any] = dict(steps[0].data)
    try:
        content.pop("former")
        return JournalHeader(**{**content, "plan": plan_from_json(content["plan"])})
    except (KeyError, TypeError) as error:
        raise CalibrationError(
            f"{path} was written by another version of the program; start a new calibration"
        ) from error

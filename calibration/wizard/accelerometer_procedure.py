"""Accelerometers: the aircraft laid in six positions, each taken once it lies still."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime

from calibration.inertial import (
    ACCELEROMETERS,
    POSITION_TEXT,
    Position,
    calibrate_accelerometers,
    create_inertial_rest_monitor,
    recognize_position,
    specific_force,
)
from calibration.plan import InstrumentPlan
from calibration.points import CalibrationError
from calibration.pressures import GroundAir
from calibration.rest_detection import RestPeriod
from calibration.settings import CALIBRATION
from calibration.wizard.journal_json import to_json_content
from calibration.wizard.procedure import (
    ActionFeedback,
    CalibrationOutcome,
    CalibrationProcedure,
    JournalHeader,
    ProcedureView,
    ReferenceCertificates,
    StepDraft,
)
from calibration.wizard.rest_timeout import RestTimeoutMonitor
from calibration.wizard.sample_slices import SampleSlice
from calibration.wizard.sensor_progress import AccelerometerProgress
from calibration.wizard.settings import WIZARD
from calibration.wizard.state import GroupProgress, InstrumentGroup
from calibration.wizard.view import WizardAction, WizardPhase


class AccelerometerProcedure(CalibrationProcedure):
    """Looks after the accelerometers.

    A position is known by the volts, so that the six may be taken in any order.

    Parameters
    ----------
    reference : ReferenceCertificates
        Holds the factory's figures.
    """

    def __init__(
        self, group: InstrumentGroup, header: JournalHeader, reference: ReferenceCertificates
    ) -> None:
        self._group = group
        self._header = header
        self._factory = reference.factory_calibrations
        self._still = create_inertial_rest_monitor(
            group.channels, seconds=WIZARD.position_rest, factory=self._factory
        )
        self._unrest = RestTimeoutMonitor()

    def restart(self) -> None:
        self._still.restart()
        self._unrest.restart()

    def feed(self, one: SampleSlice) -> None:
        self._still.feed(one.times, one.volts)
        self._unrest.feed(self._still.status)

    def phase(self, work: GroupProgress) -> WizardPhase:
        return "accel_position" if _accelerometer_progress(work).open_positions else "fit"

    def automatic_step(self, work: GroupProgress) -> StepDraft | ActionFeedback | None:
        lain = _accelerometer_progress(work)
        rest = self._rested
        if rest is None or not self._header.auto:
            return None
        position = recognize_position(rest.volts, factory=self._factory)
        if position is None or position not in lain.open_positions:
            return None
        return _draft(position, rest)

    def available_actions(self, work: GroupProgress) -> frozenset[str]:
        lain = _accelerometer_progress(work)
        kinds = {"take"} if lain.open_positions else set()
        return frozenset(kinds | {"repeat"} if lain.readings else kinds)

    def act(self, work: GroupProgress, action: WizardAction) -> StepDraft | ActionFeedback:
        lain = _accelerometer_progress(work)
        if action.kind == "take":
            if self._rested is None:
                return ActionFeedback(message="not yet still", tone="error")
            return _draft(lain.open_positions[0], self._rested)
        at = len(lain.readings) - 1 if action.index is None else action.index
        if not 0 <= at < len(lain.readings):
            return ActionFeedback(message=f"there is no position {at + 1}", tone="error")
        again = POSITION_TEXT[lain.readings[at].position]
        return StepDraft(kind="repeat", data={"index": at}, message=f"{again}: again", tone="")

    def build_view(self, work: GroupProgress, outcome: CalibrationOutcome) -> ProcedureView:
        lain = _accelerometer_progress(work)
        reading = self._still.status
        if not lain.open_positions:
            good = not outcome.issues
            return ProcedureView(
                instrument=self._group.instruments[0],
                prompt=(
                    "Accelerometers OK: accept."
                    if good
                    else "Check the accelerometers, then repeat a position or accept."
                ),
                spoken="Accelerometers OK" if good else "Check the accelerometers",
            )
        position = lain.open_positions[0]
        return ProcedureView(
            instrument=self._concerned(position),
            prompt=f"Lay the aircraft {POSITION_TEXT[position]}, and leave it still.",
            spoken=POSITION_TEXT[position].capitalize(),
            amount=round(reading.progress * WIZARD.position_rest / CALIBRATION.rest_block)
            * CALIBRATION.rest_block,
            amount_goal=WIZARD.position_rest,
            amount_unit="s",
            position=position,
            warnings=self._warnings(lain),
        )

    def outcome(
        self, work: GroupProgress, stamp: datetime, air: GroundAir | None
    ) -> CalibrationOutcome:
        lain = _accelerometer_progress(work)
        if lain.open_positions:
            return CalibrationOutcome()
        try:
            found = calibrate_accelerometers(lain.readings, factory=self._factory)
        except CalibrationError as error:
            return CalibrationOutcome(issues=(str(error),))
        temperature = air.temperature if air is not None else self._header.temperature
        certificates = []
        doubts = [found.issue] if found.issue else []
        uncalibrated: dict[str, str] = {}
        remarks: list[str] = []
        for channel in self._group.channels:
            verdict = found.fits[channel].verdict
            (remarks if verdict.passed else doubts).append(verdict.sentence)
            if not verdict.usable:
                uncalibrated[channel] = verdict.sentence
                continue
            certificates.append(
                found.certificate(
                    channel, who=self._header.who, stamp=stamp, temperature=temperature
                )
            )
        return CalibrationOutcome(
            certificates=tuple(certificates),
            uncalibrated=uncalibrated,
            issues=tuple(doubts),
            remarks=tuple(remarks),
            ready=True,
        )

    @property
    def _rested(self) -> RestPeriod | None:
        reading = self._still.status
        return reading.rest if reading.state == "rested" else None

    def _concerned(self, position: Position) -> InstrumentPlan:
        force: Mapping[str, float] = specific_force(position)
        axis = max(ACCELEROMETERS, key=lambda name: abs(force[name]))
        return next(one for one in self._group.instruments if one.channel == axis)

    def _warnings(self, lain: AccelerometerProgress) -> tuple[str, ...]:
        if self._rested is not None:
            found = recognize_position(self._rested.volts, factory=self._factory)
            if found is None:
                return (
                    "the voltages match no position; if the position is right, record it: an "
                    "accelerometer is faulty",
                )
            if found not in lain.open_positions:
                return (f"{POSITION_TEXT[found]} was already recorded",)
        return self._unrest.warnings


def _draft(position: Position, rest: RestPeriod) -> StepDraft:
    return StepDraft(
        kind="position",
        data={"position": position, "rest": to_json_content(rest)},
        message=f"taken: {POSITION_TEXT[position]}",
    )


def _accelerometer_progress(work: GroupProgress) -> AccelerometerProgress:
    assert isinstance(work, AccelerometerProgress)  # noqa: S101 - paired with its work by the state
    return work

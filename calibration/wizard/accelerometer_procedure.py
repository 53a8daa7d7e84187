"""Accelerometers: the aircraft laid in six positions, each taken once it lies still."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime

from calibration.inertial.accelerometers import (
    ACCELEROMETERS,
    POSITION_TEXT,
    Position,
    calibrate_accelerometers,
    recognize_position,
    specific_force,
)
from calibration.inertial.gyros import create_inertial_rest_monitor
from calibration.plan import InstrumentPlan
from calibration.points import CalibrationError
from calibration.pressures import GroundAir
from calibration.rest_detection import RestPeriod
from calibration.settings import CALIBRATION, WIZARD
from calibration.wizard.journal import to_json_content
from calibration.wizard.procedure import (
    ActionFeedback,
    CalibrationOutcome,
    CalibrationProcedure,
    JournalHeader,
    ProcedureView,
    ReferenceCertificates,
    RestTimeoutMonitor,
    SampleSlice,
    StepDraft,
    WizardAction,
    WizardPhase,
)
from calibration.wizard.state import AccelerometerProgress, InstrumentGroup


class AccelerometerProcedure(CalibrationProcedure[AccelerometerProgress]):
    """Looks after the accelerometers.

    A position is known by the volts, so that the six may be taken in any order.
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

    def phase(self, work: AccelerometerProgress) -> WizardPhase:
        return "accel_position" if work.open_positions else "fit"

    def automatic_step(self, work: AccelerometerProgress) -> StepDraft | ActionFeedback | None:
        rest = self._rested
        if rest is None or not self._header.auto:
            return None
        position = recognize_position(rest.volts, factory=self._factory)
        if position is None or position not in work.open_positions:
            return None
        return _draft(position, rest)

    def available_actions(self, work: AccelerometerProgress) -> frozenset[str]:
        kinds = {"take"} if work.open_positions else set()
        return frozenset(kinds | {"repeat"} if work.readings else kinds)

    def act(self, work: AccelerometerProgress, action: WizardAction) -> StepDraft | ActionFeedback:
        if action.kind == "take":
            if self._rested is None:
                return ActionFeedback(message="not yet still", tone="error")
            return _draft(work.open_positions[0], self._rested)
        at = len(work.readings) - 1 if action.index is None else action.index
        if not 0 <= at < len(work.readings):
            return ActionFeedback(message=f"there is no position {at + 1}", tone="error")
        again = POSITION_TEXT[work.readings[at].position]
        return StepDraft(kind="repeat", data={"index": at}, message=f"{again}: again", tone="")

    def build_view(self, work: AccelerometerProgress, outcome: CalibrationOutcome) -> ProcedureView:
        reading = self._still.status
        if not work.open_positions:
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
        position = work.open_positions[0]
        return ProcedureView(
            instrument=self._concerned(position),
            prompt=f"Lay the aircraft {POSITION_TEXT[position]}, and leave it still.",
            spoken=POSITION_TEXT[position].capitalize(),
            amount=round(reading.progress * WIZARD.position_rest / CALIBRATION.rest_block)
            * CALIBRATION.rest_block,
            amount_goal=WIZARD.position_rest,
            amount_unit="s",
            position=position,
            warnings=self._warnings(work),
        )

    def outcome(
        self, work: AccelerometerProgress, stamp: datetime, air: GroundAir | None
    ) -> CalibrationOutcome:
        if work.open_positions:
            return CalibrationOutcome()
        try:
            found = calibrate_accelerometers(work.readings, factory=self._factory)
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

    def _warnings(self, work: AccelerometerProgress) -> tuple[str, ...]:
        if self._rested is not None:
            found = recognize_position(self._rested.volts, factory=self._factory)
            if found is None:
                return (
                    "the voltages match no position; if the position is right, record it: an "
                    "accelerometer is faulty",
                )
            if found not in work.open_positions:
                return (f"{POSITION_TEXT[found]} was already recorded",)
        return self._unrest.warnings


def _draft(position: Position, rest: RestPeriod) -> StepDraft:
    return StepDraft(
        kind="position",
        data={"position": position, "rest": to_json_content(rest)},
        message=f"taken: {POSITION_TEXT[position]}",
    )

"""Rate gyros: a still period for all of them, then a turn there and back about each axis."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime

from calibration.inertial.accelerometers import ACCELEROMETERS
from calibration.inertial.gyros import (
    create_inertial_rest_monitor,
    gyro_certificate,
    gyro_zero,
)
from calibration.inertial.turn_detection import TurnMonitor
from calibration.plan import InstrumentPlan
from calibration.points import CalibrationError
from calibration.pressures import GroundAir
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
from calibration.wizard.state import GyroProgress, InstrumentGroup, RequestedTurn

_SILENT = "The {} gyro did not respond to a turn; check its wires."


class GyroProcedure(CalibrationProcedure[GyroProgress]):
    """Looks after the gyros."""

    def __init__(
        self, group: InstrumentGroup, header: JournalHeader, reference: ReferenceCertificates
    ) -> None:
        self._group = group
        self._header = header
        self._factory = reference.factory_calibrations
        # Accelerometers tell a slow steady turn from rest, where they are recorded.
        beside = [name for name in ACCELEROMETERS if name in header.plan.channels]
        self._beside = tuple(beside) if len(beside) == len(ACCELEROMETERS) else ()
        self._still = create_inertial_rest_monitor(
            (*group.channels, *self._beside), seconds=WIZARD.zero_rest, factory=self._factory
        )
        self._unrest = RestTimeoutMonitor()
        least = [
            WIZARD.min_turn_share * one.turn for one in group.instruments if one.turn is not None
        ]
        self._turn = TurnMonitor(
            group.channels, least=min(least, default=180.0), factory=self._factory
        )

    def restart(self) -> None:
        self._still.restart()
        self._unrest.restart()
        self._turn.restart()

    def feed(self, one: SampleSlice) -> None:
        self._still.feed(one.times, one.volts)
        self._unrest.feed(self._still.status)
        self._turn.feed(one.times, one.volts)

    def phase(self, work: GyroProgress) -> WizardPhase:
        if work.rest is None:
            return "gyro_still"
        return "gyro_turn" if work.open_turn_indices else "fit"

    def automatic_step(self, work: GyroProgress) -> StepDraft | ActionFeedback | None:
        phase = self.phase(work)
        if phase == "gyro_still":
            reading = self._still.status
            if reading.state != "rested" or reading.rest is None:
                return None
            rest = to_json_content(reading.rest)
            return StepDraft(kind="still", data={"rest": rest}, message="gyro zeros recorded")
        if phase == "gyro_turn" and self._turn.status.state == "turned":
            return self._turned(work)
        return None

    def available_actions(self, work: GyroProgress) -> frozenset[str]:
        kinds = {"next", "take"} if self.phase(work) == "gyro_turn" else set()
        return frozenset(kinds | {"repeat", "delete"} if work.turns else kinds)

    def act(self, work: GyroProgress, action: WizardAction) -> StepDraft | ActionFeedback:
        if action.kind == "next":
            return StepDraft(
                kind="leave_out",
                data={"slot": work.open_turn_indices[0]},
                message="turn skipped; the data-sheet scale applies where none was made",
                tone="",
            )
        if action.kind == "take":
            return self._without_answer(work)
        at = len(work.turns) - 1 if action.index is None else action.index
        if not 0 <= at < len(work.turns):
            return ActionFeedback(message=f"there is no turn {at + 1}", tone="error")
        message = "repeat the turn" if action.kind == "repeat" else "turn deleted"
        return StepDraft(kind=action.kind, data={"index": at}, message=message, tone="")

    def build_view(self, work: GyroProgress, outcome: CalibrationOutcome) -> ProcedureView:
        phase = self.phase(work)
        if phase == "gyro_still":
            reading = self._still.status
            return ProcedureView(
                instrument=self._group.instruments[0],
                prompt="Do not touch the aircraft until the gyro zeros are recorded.",
                spoken="Gyros. Hands off",
                amount=round(reading.progress * WIZARD.zero_rest / CALIBRATION.rest_block)
                * CALIBRATION.rest_block,
                amount_goal=WIZARD.zero_rest,
                amount_unit="s",
                warnings=self._unrest.warnings,
            )
        points = tuple(turn.point for _, turn in work.turns)
        if phase == "gyro_turn":
            asked = work.requested_turns[work.open_turn_indices[0]]
            turning = self._turn.status
            return ProcedureView(
                instrument=self._instrument(asked.channel),
                prompt=self._turn_prompt(asked),
                spoken=self._turn_spoken(asked),
                target=asked.angle,
                amount=turning.angle,
                amount_goal=abs(asked.angle),
                amount_unit="deg",
                points=points,
            )
        good = not outcome.issues
        return ProcedureView(
            instrument=self._group.instruments[0],
            prompt=(
                "Gyros OK: accept." if good else "Check the gyros, then accept the usable ones."
            ),
            spoken="Gyros OK" if good else "Check the gyros",
            points=points,
        )

    def outcome(
        self, work: GyroProgress, stamp: datetime, air: GroundAir | None
    ) -> CalibrationOutcome:
        if work.rest is None:
            return CalibrationOutcome()
        certificates, doubts, remarks = [], [], []
        uncalibrated: dict[str, str] = {}
        for channel in self._group.channels:
            if channel in work.unresponsive:
                uncalibrated[channel] = _SILENT.format(channel)
                doubts.append(uncalibrated[channel])
                continue
            zero = gyro_zero(channel, work.rest, factory=self._factory)
            turns = [turn for _, turn in work.turns if turn.channel == channel]
            try:
                certificate = gyro_certificate(
                    zero,
                    turns,
                    who=self._header.who,
                    stamp=stamp,
                    temperature=air.temperature if air is not None else self._header.temperature,
                    factory=self._factory,
                )
            except CalibrationError as error:
                uncalibrated[channel] = str(error)
                doubts.append(str(error))
                continue
            certificates.append(certificate)
            verdicts = [zero.verdict, *(turn.verdict for turn in turns)]
            doubts += [one.sentence for one in verdicts if not one.passed]
            remarks += [zero.verdict.sentence]
            remarks += [one.sentence for one in verdicts[1:] if one.passed]
        return CalibrationOutcome(
            certificates=tuple(certificates),
            uncalibrated=uncalibrated,
            issues=tuple(doubts),
            remarks=tuple(remarks),
            ready=True,
        )

    def _turned(self, work: GyroProgress) -> StepDraft | ActionFeedback:
        slot = work.open_turn_indices[0]
        asked = work.requested_turns[slot]
        try:
            turn = self._turn.detected_turn(asked.channel, asked.angle)
        except CalibrationError as error:
            self._turn.restart()
            return ActionFeedback(message=str(error), tone="error")
        kind = turn.verdict.kind
        if kind == "clipped":
            self._turn.restart()
            return ActionFeedback(message=turn.verdict.sentence, tone="error")
        return StepDraft(
            kind="turn",
            data={"slot": slot, "turn": to_json_content(turn)},
            message=turn.verdict.sentence,
            tone="taken" if turn.verdict.usable else "error",
        )

    def _without_answer(self, work: GyroProgress) -> StepDraft | ActionFeedback:
        """Take the crew's word that the table was turned, though no gyro saw it."""
        if self._turn.status.state in ("turning", "stopping"):
            return ActionFeedback(
                message="turn detected: hold the table still; it is recorded automatically"
            )
        channel = work.requested_turns[work.open_turn_indices[0]].channel
        return StepDraft(
            kind="silent", data={"gyro": channel}, message=_SILENT.format(channel), tone="error"
        )

    def _instrument(self, channel: str) -> InstrumentPlan:
        return next(one for one in self._group.instruments if one.channel == channel)

    def _turn_prompt(self, asked: RequestedTurn) -> str:
        instrument = self._instrument(asked.channel)
        way = instrument.positive if asked.angle > 0.0 else instrument.negative
        state = self._turn.status.state
        angle = f"{abs(asked.angle):g} deg"
        if state == "unsettled":
            return f"{_UPRIGHT[asked.channel]} Hold the table still."
        if state == "ready":
            return f"Turn the table {angle}, {way}, within its marks, then hold it still."
        return f"Turn on to {angle}, {way}, then hold it still."

    def _turn_spoken(self, asked: RequestedTurn) -> str:
        instrument = self._instrument(asked.channel)
        way = instrument.positive if asked.angle > 0.0 else instrument.negative
        if self._turn.status.state == "unsettled":
            return f"{instrument.title} on the table"
        return f"Turn {abs(asked.angle):g}, {way}"


_UPRIGHT: Mapping[str, str] = {
    "p": "Put the aircraft on the turntable, nose straight down or up.",
    "q": "Put the aircraft on the turntable, one wing straight up.",
    "r": "Put the aircraft on the turntable, upright.",
}

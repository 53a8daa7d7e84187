"""Pressures: zero with the pitot covered, a breath into it, the field's barometer."""

from __future__ import annotations

from datetime import datetime

from calibration.certificate import Certificate
from calibration.points import CalibrationError
from calibration.pressures import (
    GroundAir,
    PitotBlowDetector,
    PressureZero,
    create_covered_pitot_monitor,
    dynamic_pressure_zero,
    static_pressure_check,
)
from calibration.rest_detection import RestPeriod
from calibration.settings import CALIBRATION, PRESSURES, WIZARD
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
from calibration.wizard.state import InstrumentGroup, PressureProgress

_DYNAMIC, _STATIC = "dynamic_pressure", "static_pressure"
_WITHOUT_BAROMETER = (
    "the static pressure was not compared with a barometer: enter the field pressure, or "
    "accept and keep the previous certificate",
)


class PressureProcedure(CalibrationProcedure[PressureProgress]):
    """Looks after the pressures.

    A key says that the pitot is covered. Where the pressure then moves as it does in wind, the
    cover is asked for once more; the same key takes it in a lull, with a bound for the wind.
    """

    def __init__(
        self, group: InstrumentGroup, header: JournalHeader, reference: ReferenceCertificates
    ) -> None:
        self._group = group
        self._header = header
        known = {name: reference.former_or_nominal(name) for name in group.channels}
        missing = [name for name, certificate in known.items() if certificate is None]
        if missing:
            raise CalibrationError(
                f"{missing[0]} has no certificate whose slope could be kept; name a set in the "
                'plan, as nominal = "b777", or put a certificate in force'
            )
        self._known = {name: one for name, one in known.items() if one is not None}
        curves = self._known[_DYNAMIC], self._known.get(_STATIC)
        self._still = create_covered_pitot_monitor(*curves, seconds=WIZARD.pressure_rest)
        self._lull = create_covered_pitot_monitor(*curves, seconds=WIZARD.pressure_rest, lull=True)
        self._unrest = RestTimeoutMonitor()
        self._blow: PitotBlowDetector | None = None
        self._covered = self._content = False
        self._waited = 0.0
        self._said = ""

    def restart(self) -> None:
        self._still.restart()
        self._lull.restart()
        self._unrest.restart()
        self._blow = None
        self._covered = self._content = False
        self._waited = 0.0
        self._said = ""

    def feed(self, one: SampleSlice) -> None:
        self._still.feed(one.times, one.volts)
        self._lull.feed(one.times, one.volts)
        self._unrest.feed(self._still.status)
        if self._covered:
            self._waited += WIZARD.slice_duration
        if self._blow is not None:
            self._blow.feed(one.times, one.volts)

    def phase(self, work: PressureProgress) -> WizardPhase:
        if work.zero is None:
            return "pressure_zero"
        return "fit" if work.blow_detected or work.left_out else "pressure_blow"

    def automatic_step(self, work: PressureProgress) -> StepDraft | ActionFeedback | None:
        phase = self.phase(work)
        if phase == "pressure_zero":
            return self._zero_draft()
        if phase == "pressure_blow":
            return self._follow_breath(work)
        return None

    def available_actions(self, work: PressureProgress) -> frozenset[str]:
        phase = self.phase(work)
        kinds = {"enter"}
        if phase == "pressure_zero":
            kinds.add("take")
        else:
            kinds.add("repeat")
        if phase == "pressure_blow":
            kinds.add("next")
        return frozenset(kinds)

    def act(self, work: PressureProgress, action: WizardAction) -> StepDraft | ActionFeedback:
        if action.kind == "take":
            return self._take()
        if action.kind == "repeat":
            again = "repeated from zero" if work.blow_detected else "zero repeated"
            return StepDraft(kind="repeat", message=again, tone="")
        if action.kind == "next":
            return StepDraft(kind="leave_out", message="pitot blow skipped", tone="")
        return self._entered(action)

    def build_view(self, work: PressureProgress, outcome: CalibrationOutcome) -> ProcedureView:
        phase = self.phase(work)
        instrument = self._group.instruments[0]
        if phase == "pressure_zero":
            reading = self._still.status
            prompt, spoken = self._cover_words()
            return ProcedureView(
                instrument=instrument,
                prompt=prompt,
                spoken=spoken,
                amount=round(reading.progress * WIZARD.pressure_rest / CALIBRATION.rest_block)
                * CALIBRATION.rest_block,
                amount_goal=WIZARD.pressure_rest,
                amount_unit="s",
                warnings=self._unrest.warnings,
            )
        if phase == "pressure_blow":
            blow = None if self._blow is None else self._blow.status
            failed = blow is not None and blow.state in ("reversed", "blocked", "leaking")
            return ProcedureView(
                instrument=instrument,
                prompt="Take the cover off and blow gently into the pitot.",
                spoken="Blow into the pitot",
                amount=None if blow is None else blow.pressure,
                amount_unit="Pa",
                warnings=(blow.sentence,) if blow is not None and failed else (),
            )
        good = not outcome.issues
        return ProcedureView(
            instrument=instrument,
            prompt=(
                "Pressures OK: accept."
                if good
                else "Check the pressures: enter the field pressure, repeat, or accept."
            ),
            spoken="Pressures OK" if good else "Check the pressures",
        )

    def outcome(
        self, work: PressureProgress, stamp: datetime, air: GroundAir | None
    ) -> CalibrationOutcome:
        if work.zero is None:
            return CalibrationOutcome()
        uncalibrated: dict[str, str] = {}
        found: list[PressureZero] = []
        doubts: list[str] = []
        zero, lull = work.zero, work.in_wind
        for name in self._group.channels:
            if name == _STATIC and air is None:
                doubts += _WITHOUT_BAROMETER if work.fraction_done == 1.0 else ()
                continue
            try:
                found.append(self._at_known_pressure(name, zero, lull, stamp, air))
            except CalibrationError as error:
                uncalibrated[name] = str(error)
                doubts.append(str(error))
        doubts += [one.sentence for one in found if not one.passed]
        if work.in_wind:
            doubts.append(
                "the dynamic pressure moved as in wind during zeroing: the zero may be off by "
                f"{PRESSURES.wind_uncertainty:.0f} Pa"
            )
        if work.left_out:
            doubts.append("the pitot was not blown into: hoses not checked")
        return CalibrationOutcome(
            certificates=tuple(one.certificate for one in found),
            uncalibrated=uncalibrated,
            issues=tuple(doubts),
            remarks=tuple(one.sentence for one in found if one.passed),
            ready=True,
        )

    def _at_known_pressure(
        self, name: str, rest: RestPeriod, lull: bool, stamp: datetime, air: GroundAir | None
    ) -> PressureZero:
        former = self._known[name]
        temperature = self._header.temperature if air is None else air.temperature
        who = self._header.who
        if name == _STATIC and air is not None:
            return static_pressure_check(
                rest, former, air.pressure, who=who, stamp=stamp, temperature=temperature
            )
        return dynamic_pressure_zero(
            rest, former, who=who, stamp=stamp, temperature=temperature, lull=lull
        )

    @property
    def _windy(self) -> bool:
        return self._waited >= WIZARD.cover_timeout

    def _cover_words(self) -> tuple[str, str]:
        """Return what to do about the cover, and the same in few words."""
        if self._content:
            return "Keep still: the zero is recorded in a lull.", "Waiting for a lull"
        if self._windy:
            return (
                "The pressure moves as in wind: check the cover, or record it in a lull.",
                "Check the cover",
            )
        if self._covered:
            return "Keep the pitot covered until the pressure is steady.", "Hold the cover"
        return "Cover the pitot, then record.", "Cover the pitot"

    def _take(self) -> StepDraft | ActionFeedback:
        self._content = self._windy
        self._covered = True
        waiting = "in a lull" if self._content else "as soon as it is steady"
        return self._zero_draft() or ActionFeedback(message=f"covered: taken {waiting}")

    def _zero_draft(self) -> StepDraft | None:
        watches = {False: self._still} if self._covered else {}
        if self._content:
            watches[True] = self._lull
        for lull, watch in watches.items():
            reading = watch.status
            if reading.state == "rested" and reading.rest is not None:
                return StepDraft(
                    kind="zero",
                    data={"rest": to_json_content(reading.rest), "lull": lull},
                    message="pressure zeros recorded",
                )
        return None

    def _follow_breath(self, work: PressureProgress) -> StepDraft | ActionFeedback | None:
        if self._blow is None:
            self._blow = PitotBlowDetector(self._today(work), self._known.get(_STATIC))
        reading = self._blow.status
        if reading.state == "green":
            return StepDraft(kind="blow", message=reading.sentence)
        if reading.state in ("reversed", "blocked", "leaking") and reading.state != self._said:
            self._said = reading.state
            return ActionFeedback(message=reading.sentence, tone="error")
        return None

    def _today(self, work: PressureProgress) -> Certificate:
        """Return the curve of the dynamic pressure through today's zero."""
        former = self._known[_DYNAMIC]
        if work.zero is None:
            return former
        try:
            zero = dynamic_pressure_zero(work.zero, former, who="", stamp=former.stamp)
        except CalibrationError:
            return former
        return zero.certificate

    def _entered(self, action: WizardAction) -> StepDraft | ActionFeedback:
        if action.pressure is None or action.temperature is None:
            return ActionFeedback(message="enter both pressure and temperature", tone="error")
        try:
            air = GroundAir.from_input(action.pressure, "Pa", action.temperature, "K")
        except CalibrationError as error:
            return ActionFeedback(message=str(error), tone="error")
        return StepDraft(
            kind="air",
            data=to_json_content(air),
            message=f"air at the field: {air.pressure / 100.0:.1f} hPa",
            tone="",
        )

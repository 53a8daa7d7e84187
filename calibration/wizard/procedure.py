"""What the wizard asks of those that know one kind of instrument.

A station looks after one group while it is at hand: it follows the volts, says what is to be done,
and drafts the steps. It keeps nothing that must survive: what was done stands in the work, which
follows from the journal.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from datetime import datetime
from typing import Any

from calibration.certificate import Certificate
from calibration.drift import CheckResult, Drift
from calibration.inertial import FactoryCalibration, Position, factory_calibrations
from calibration.instrument_faults import InstrumentFault
from calibration.plan import CalibrationPlan, InstrumentPlan
from calibration.points import CalibrationPoint, Direction
from calibration.pressures import GroundAir
from calibration.quality import Calibration
from calibration.voltage_monitor import VoltageReading
from calibration.wizard.sample_slices import SampleSlice
from calibration.wizard.setting_schedule import CalibrationMode, ScheduledSetting
from calibration.wizard.state import GroupProgress
from calibration.wizard.view import FeedbackTone, WizardAction, WizardPhase


@dataclass(frozen=True, slots=True, kw_only=True)
class JournalHeader:
    """What a calibration is, as its journal begins."""

    plan: CalibrationPlan
    mode: CalibrationMode
    """All settings, or three."""
    who: str
    temperature: float | None
    """K."""
    auto: bool
    """Whether points are taken by themselves."""
    rising: Mapping[str, bool]
    """Signs known beforehand, by channel."""
    any_side: Collection[str] = ()
    """Channels whose settings may be come to from either side in a check."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ReferenceCertificates:
    """What today's readings are held against."""

    former: Mapping[str, Certificate]
    """In force when the calibration was begun, by channel."""
    current: Mapping[str, Certificate]
    """In force by now."""
    nominal: Mapping[str, Certificate]
    """Of the factory, or as the instruments are mounted."""

    def former_or_nominal(self, channel: str) -> Certificate | None:
        """Return the certificate that was in force, else the nominal one."""
        return self.former.get(channel, self.nominal.get(channel))

    @property
    def factory_calibrations(self) -> Mapping[str, FactoryCalibration]:
        """Return the factory's figures of gyros and accelerometers."""
        own = {
            name: FactoryCalibration.from_certificate(certificate)
            for name, certificate in self.nominal.items()
            if name in factory_calibrations()
        }
        return {**factory_calibrations(), **own}


@dataclass(frozen=True, slots=True, kw_only=True)
class StepDraft:
    """A step that a station wants to be made, and what to say of it."""

    kind: str
    data: Mapping[str, Any] = field(default_factory=dict)
    message: str = ""
    tone: FeedbackTone = "taken"


@dataclass(frozen=True, slots=True, kw_only=True)
class ActionFeedback:
    """What a station says to an action that makes no step."""

    message: str
    tone: FeedbackTone = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class CalibrationOutcome:
    """What the work of a group comes to."""

    certificates: tuple[Certificate, ...] = ()
    """To be put in force."""
    uncalibrated: Mapping[str, str] = field(default_factory=dict)
    """Channels that cannot be certified, and why."""
    issues: tuple[str, ...] = ()
    """Sentences; without any the outcome is accepted by itself."""
    remarks: tuple[str, ...] = ()
    """What is worth knowing besides."""
    ready: bool = False
    """Whether it can be accepted at all."""
    calibration: Calibration | None = None
    """The curve, for instruments set by hand."""
    drift: Drift | None = None
    """Against the certificate that was in force."""
    check_result: CheckResult | None = None
    """Of a three-point check."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ProcedureView:
    """What a station shows; see `WizardView` for what each part means."""

    instrument: InstrumentPlan
    prompt: str
    spoken: str
    target: float | None = None
    direction: Direction = "single"
    reading: VoltageReading | None = None
    current_value: float | None = None
    amount: float | None = None
    amount_goal: float | None = None
    amount_unit: str = ""
    position: Position | None = None
    points: tuple[CalibrationPoint, ...] = ()
    remaining: tuple[ScheduledSetting, ...] = ()
    degree: int | None = None
    faults: tuple[InstrumentFault, ...] = ()
    warnings: tuple[str, ...] = ()


class CalibrationProcedure(ABC):
    """Looks after one group. Works, and what is shown of them, are handed in each time."""

    @abstractmethod
    def restart(self) -> None:
        """Begin to watch anew: a step was made."""

    @abstractmethod
    def feed(self, one: SampleSlice) -> None:
        """Take the samples of a tenth of a second."""

    @abstractmethod
    def phase(self, work: GroupProgress) -> WizardPhase:
        """Return which page it is."""

    @abstractmethod
    def automatic_step(self, work: GroupProgress) -> StepDraft | ActionFeedback | None:
        """Return the step that the volts ask for without anybody's word, or what is to be said."""

    @abstractmethod
    def available_actions(self, work: GroupProgress) -> frozenset[str]:
        """Return the kinds of actions that it answers to now."""

    @abstractmethod
    def act(self, work: GroupProgress, action: WizardAction) -> StepDraft | ActionFeedback:
        """Return what an action leads to; it is one of `available_actions`."""

    @abstractmethod
    def build_view(self, work: GroupProgress, outcome: CalibrationOutcome) -> ProcedureView:
        """Return what is to be shown."""

    @abstractmethod
    def outcome(
        self, work: GroupProgress, stamp: datetime, air: GroundAir | None
    ) -> CalibrationOutcome:
        """Return what the work comes to, certificates stamped so."""

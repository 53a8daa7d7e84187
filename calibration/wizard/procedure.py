"""What goes into the wizard and comes out, and what it asks for each kind of instrument.

A procedure looks after one group while it is at hand: it follows the volts, says what is to be
done, and drafts the steps. It keeps nothing that must survive: what was done stands in the
progress, which follows from the journal.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from typing import Any, Generic, Literal, TypeVar

import numpy as np

from calibration.certificate import Certificate
from calibration.drift import CheckResult, Drift
from calibration.inertial.accelerometers import Position
from calibration.inertial.straight_line import FactoryCalibration, factory_calibrations
from calibration.instrument_faults import InstrumentFault
from calibration.plan import CalibrationPlan, InstrumentPlan
from calibration.points import CalibrationPoint, Direction
from calibration.pressures import GroundAir
from calibration.quality import Calibration
from calibration.rest_detection import RestStatus
from calibration.settings import WIZARD
from calibration.voltage_monitor import VoltageReading
from calibration.wizard.state import CalibrationMode, GroupProgress, ScheduledSetting
from gsapp.quantities import Block, FloatArray

WizardActionKind = Literal[
    "take",
    "repeat",
    "delete",
    "add",
    "undo",
    "back",
    "next",
    "skip",
    "confirm_sign",
    "choose_degree",
    "accept",
    "abort",
    "open",
    "enter",
]
WizardPhase = Literal[
    "begin",
    "sign",
    "points",
    "fit",
    "gyro_still",
    "gyro_turn",
    "accel_position",
    "pressure_zero",
    "pressure_blow",
    "done",
    "aborted",
]
FeedbackTone = Literal["", "steady", "taken", "moved", "error"]
Progress = TypeVar("Progress", bound=GroupProgress)


@dataclass(frozen=True, slots=True, kw_only=True)
class WizardAction:
    """One thing that the crew does."""

    kind: WizardActionKind
    """``take`` a reading now; ``repeat`` a point (the last, or `index`); ``delete`` a point (the
    last, or `index`); ``add`` a setting (`value`); ``undo`` the last step; ``back`` to the
    instrument before; ``next``: go on without (begin at once, leave a setting or a turn out, leave
    the instrument for later); ``skip`` the instrument (`reason`): it is uncalibrated;
    ``confirm_sign`` (`yes`); ``choose_degree`` (`degree`, None for the evidence); ``accept``;
    ``abort``; ``open`` an instrument (`channel`); ``enter`` the air at the field (`pressure` in Pa,
    not reduced to sea level, and `temperature` in K)."""
    index: int | None = None
    value: float | None = None
    reason: str = ""
    yes: bool = True
    degree: int | None = None
    channel: str = ""
    pressure: float | None = None
    temperature: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ProcedureView:
    """What a procedure shows."""

    instrument: InstrumentPlan | None
    """At hand; of instruments that are calibrated together, the one concerned."""
    prompt: str
    """What to do now, one sentence."""
    spoken: str = ""
    """The same in few words; changes only when there is something new to say."""
    target: float | None = None
    """Setting asked for, in the unit of the instrument."""
    direction: Direction = "single"
    reading: VoltageReading | None = None
    """Volts of the instrument at hand."""
    current_value: float | None = None
    """What they stand for by the certificate in force (where there is none, by the nominal one),
    and once all points are taken by these; unit of the instrument."""
    amount: float | None = None
    amount_goal: float | None = None
    """Of what takes its time, the one big number: seconds of rest, degrees turned, pressure."""
    amount_unit: str = ""
    position: Position | None = None
    """In which the aircraft is to lie, for accelerometers."""
    points: tuple[CalibrationPoint, ...] = ()
    """Taken so far, in order."""
    remaining: tuple[ScheduledSetting, ...] = ()
    """Settings still to be taken, the next first."""
    degree: int | None = None
    """Chosen by hand; None where the evidence decides."""
    faults: tuple[InstrumentFault, ...] = ()
    """What is wrong with the instrument, as seen so far; their sentences stand in `problems`."""
    warnings: tuple[str, ...] = ()
    """What else is wrong now; part of `problems`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WizardView(ProcedureView):
    """The wizard as it is to be shown."""

    index: int
    count: int
    """Which one it is, from 0, and how many there are; gyros, accelerometers and pressures count as
    one each."""
    phase: WizardPhase
    """Which page it is."""
    mode: CalibrationMode = "full"
    """Whether certificates are made, or those in force checked."""
    calibration: Calibration | None = None
    """The curve, as soon as the points allow one."""
    drift: Drift | None = None
    """Of that curve against the certificate in force."""
    check_result: CheckResult | None = None
    """Of a three-point check."""
    problems: tuple[str, ...] = ()
    """What is wrong: faults, outliers, whatever keeps a fit from being accepted by itself."""
    remarks: tuple[str, ...] = ()
    """What is worth knowing: drift, how left and right compare."""
    accepted_checks: Mapping[str, CheckResult] = field(default_factory=dict)
    """Of the three-point checks made so far, by channel."""
    available_actions: frozenset[str] = frozenset()
    """Kinds of actions that are possible now."""
    progress: float = 0.0
    """Of the whole, 0 to 1."""
    accepted: tuple[str, ...] = ()
    """Channels that are done."""
    skipped: Mapping[str, str] = field(default_factory=dict)
    """Channels left uncalibrated, or unchecked, and why."""
    certificates: Mapping[str, Certificate] = field(default_factory=dict)
    """Made so far, by channel."""
    message: str = ""
    tone: FeedbackTone = ""
    """What to sound: ``steady``, ``taken``, ``moved``, ``error``; empty for nothing."""
    event_count: int = 0
    """Counts what happened, so that the same message or tone twice is told apart."""

    @property
    def residuals(self) -> tuple[float, ...]:
        """Return how far each point lies off its curve, or off the branch of the one checked.

        In the unit of the instrument; empty where there is no curve of these points yet.
        """
        if self.calibration is not None:
            off = self.calibration.fit.residuals
        else:
            off = self.check_result.off if self.check_result is not None else ()
        return off if len(off) == len(self.points) else ()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SampleSlice:
    """The samples of a tenth of a second."""

    start: float
    end: float
    """Flight time, s."""
    times: FloatArray
    """Shape (n,). s."""
    volts: Mapping[str, FloatArray]
    """Shape (n,). By instrument, V; NaN where missing."""
    excitation: FloatArray
    """Shape (n,). V; NaN where missing."""

    @property
    def present(self) -> bool:
        """Return whether any instrument gave any volts."""
        return any(bool(np.isfinite(samples).any()) for samples in self.volts.values())


class SampleSlicer:
    """Gathers blocks and gives whole slices."""

    def __init__(self, channels: Sequence[str]) -> None:
        self._channels = tuple(channels)
        self._times = np.empty(0)
        self._values = np.empty((0, len(self._channels) + 1))
        self._last = -np.inf

    def feed(self, block: Block) -> Iterator[SampleSlice]:
        if not len(block):
            return
        if block.times[0] < self._last - WIZARD.clock_restart:
            self._times, self._values = self._times[:0], self._values[:0]
            self._last = -np.inf
        new = block.times > self._last
        names = [*(f"{name}_volts" for name in self._channels), "excitation"]
        values = np.full((len(block), len(names)), np.nan)
        for index, name in enumerate(names):
            if name in block:
                values[:, index] = block[name]
        self._times = np.concatenate([self._times, block.times[new]])
        self._values = np.concatenate([self._values, values[new]])
        if not self._times.size:
            return
        self._last = float(self._times[-1])
        numbers = np.floor(self._times / WIZARD.slice_duration + 1e-9).astype(np.int64)
        whole = int(np.searchsorted(numbers, numbers[-1]))
        pieces = [
            (int(number), *np.searchsorted(numbers, (number, number + 1)))
            for number in np.unique(numbers[:whole])
        ]
        times, values = self._times, self._values
        self._times, self._values = times[whole:], values[whole:]
        for number, first, last in pieces:
            part = values[first:last]
            yield SampleSlice(
                start=number * WIZARD.slice_duration,
                end=(number + 1) * WIZARD.slice_duration,
                times=times[first:last],
                volts={name: part[:, index] for index, name in enumerate(self._channels)},
                excitation=part[:, -1],
            )


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


class CalibrationProcedure(ABC, Generic[Progress]):
    """Looks after one group. Its progress, and what is shown of it, are handed in each time."""

    @abstractmethod
    def restart(self) -> None:
        """Begin to watch anew: a step was made."""

    @abstractmethod
    def feed(self, one: SampleSlice) -> None:
        """Take the samples of a tenth of a second."""

    @abstractmethod
    def phase(self, work: Progress) -> WizardPhase:
        """Return which page it is."""

    @abstractmethod
    def automatic_step(self, work: Progress) -> StepDraft | ActionFeedback | None:
        """Return the step that the volts ask for without anybody's word, or what is to be said."""

    @abstractmethod
    def available_actions(self, work: Progress) -> frozenset[str]:
        """Return the kinds of actions that it answers to now."""

    @abstractmethod
    def act(self, work: Progress, action: WizardAction) -> StepDraft | ActionFeedback:
        """Return what an action leads to; it is one of `available_actions`."""

    @abstractmethod
    def build_view(self, work: Progress, outcome: CalibrationOutcome) -> ProcedureView:
        """Return what is to be shown."""

    @abstractmethod
    def outcome(self, work: Progress, stamp: datetime, air: GroundAir | None) -> CalibrationOutcome:
        """Return what the work comes to, certificates stamped so."""


class RestTimeoutMonitor:
    """Follows the reading of a watch for rest."""

    def __init__(self) -> None:
        self._waited = 0.0
        self._said_at = 0.0
        self._why = ""

    def restart(self) -> None:
        """Begin to wait anew."""
        self._waited = self._said_at = 0.0
        self._why = ""

    def feed(self, reading: RestStatus) -> None:
        if reading.state == "rested":
            self.restart()
            return
        self._waited += WIZARD.slice_duration
        if (
            self._waited >= WIZARD.rest_timeout
            and self._waited - self._said_at >= WIZARD.reason_interval
        ):
            self._said_at = self._waited
            self._why = reading.why

    @property
    def warnings(self) -> tuple[str, ...]:
        """Return what to say of it: nothing, or one sentence."""
        return (f"not steady: {self._why}",) if self._why else ()

"""What goes into the wizard and what comes out: actions, and a frozen view to draw and to speak."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from calibration.certificate import Certificate
from calibration.drift import CheckResult, Drift
from calibration.inertial import Position
from calibration.instrument_faults import InstrumentFault
from calibration.plan import InstrumentPlan
from calibration.points import CalibrationPoint, Direction
from calibration.quality import Calibration
from calibration.voltage_monitor import VoltageReading
from calibration.wizard.setting_schedule import CalibrationMode, ScheduledSetting

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
class WizardView:
    """The wizard as it is to be shown."""

    instrument: InstrumentPlan | None
    """At hand; of instruments that are calibrated together, the one concerned."""
    index: int
    count: int
    """Which one it is, from 0, and how many there are; gyros, accelerometers and pressures count as
    one each."""
    phase: WizardPhase
    """Which page it is."""
    prompt: str
    """What to do now, one sentence."""
    mode: CalibrationMode = "full"
    """Whether certificates are made, or those in force checked."""
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
    calibration: Calibration | None = None
    """The curve, as soon as the points allow one."""
    drift: Drift | None = None
    """Of that curve against the certificate in force."""
    degree: int | None = None
    """Chosen by hand; None where the evidence decides."""
    check_result: CheckResult | None = None
    """Of a three-point check."""
    faults: tuple[InstrumentFault, ...] = ()
    """What is wrong with the instrument, as seen so far; their sentences stand in `problems`."""
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

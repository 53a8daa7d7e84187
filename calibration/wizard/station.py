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
from calibration.comparing import CheckResult, Drift
from calibration.faults import InstrumentFault
from calibration.inertial import FactoryFigures, Position, factory_figures
from calibration.plan import CalibrationPlan, InstrumentPlan
from calibration.points import CalibrationPoint, Direction
from calibration.pressures import GroundAir
from calibration.quality import Calibration
from calibration.watching import WatchReading
from calibration.wizard.schedule import Mode, Slot
from calibration.wizard.slices import Slice
from calibration.wizard.state import Work
from calibration.wizard.view import Action, Phase, Tone


@dataclass(frozen=True, slots=True, kw_only=True)
class Header:
    """What a calibration is, as its journal begins.

    Attributes
    ----------
    plan : CalibrationPlan
        What is calibrated.
    mode : {"full", "check"}
        All settings, or three.
    who : str
        Takes the readings.
    temperature : float or None
        K.
    auto : bool
        Whether points are taken by themselves.
    rising : mapping of str to bool
        Signs known beforehand, by channel.
    any_side : collection of str
        Channels whose settings may be come to from either side in a check.
    """

    plan: CalibrationPlan
    mode: Mode
    who: str
    temperature: float | None
    auto: bool
    rising: Mapping[str, bool]
    any_side: Collection[str] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Reference:
    """What today's readings are held against.

    Attributes
    ----------
    former : mapping of str to Certificate
        In force when the calibration was begun, by channel.
    today : mapping of str to Certificate
        In force by now.
    nominal : mapping of str to Certificate
        Of the factory, or as the instruments are mounted.
    """

    former: Mapping[str, Certificate]
    today: Mapping[str, Certificate]
    nominal: Mapping[str, Certificate]

    def best(self, channel: str) -> Certificate | None:
        """Return the certificate that was in force, else the nominal one."""
        return self.former.get(channel, self.nominal.get(channel))

    @property
    def factory(self) -> Mapping[str, FactoryFigures]:
        """Return the factory's figures of gyros and accelerometers."""
        own = {
            name: FactoryFigures.of(certificate)
            for name, certificate in self.nominal.items()
            if name in factory_figures()
        }
        return {**factory_figures(), **own}


@dataclass(frozen=True, slots=True, kw_only=True)
class Draft:
    """A step that a station wants to be made, and what to say of it."""

    kind: str
    data: Mapping[str, Any] = field(default_factory=dict)
    message: str = ""
    tone: Tone = "taken"


@dataclass(frozen=True, slots=True, kw_only=True)
class Answer:
    """What a station says to an action that makes no step."""

    message: str
    tone: Tone = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """What the work of a group comes to.

    Attributes
    ----------
    certificates : tuple of Certificate
        To be put in force.
    uncalibrated : mapping of str to str
        Channels that cannot be certified, and why.
    doubts : tuple of str
        Sentences; without any the outcome is accepted by itself.
    remarks : tuple of str
        What is worth knowing besides.
    ready : bool
        Whether it can be accepted at all.
    calibration : Calibration or None
        The curve, for instruments set by hand.
    drift : Drift or None
        Against the certificate that was in force.
    check : CheckResult or None
        Of a three-point check.
    """

    certificates: tuple[Certificate, ...] = ()
    uncalibrated: Mapping[str, str] = field(default_factory=dict)
    doubts: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
    ready: bool = False
    calibration: Calibration | None = None
    drift: Drift | None = None
    check: CheckResult | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Showing:
    """What a station shows; see `WizardView` for what each part means."""

    instrument: InstrumentPlan
    prompt: str
    spoken: str
    target: float | None = None
    direction: Direction = "single"
    reading: WatchReading | None = None
    value_now: float | None = None
    amount: float | None = None
    amount_goal: float | None = None
    amount_unit: str = ""
    position: Position | None = None
    points: tuple[CalibrationPoint, ...] = ()
    remaining: tuple[Slot, ...] = ()
    degree: int | None = None
    faults: tuple[InstrumentFault, ...] = ()
    warnings: tuple[str, ...] = ()


class Station(ABC):
    """Looks after one group. Works, and what is shown of them, are handed in each time."""

    @abstractmethod
    def restart(self) -> None:
        """Begin to watch anew: a step was made."""

    @abstractmethod
    def feed(self, one: Slice) -> None:
        """Take the samples of a tenth of a second."""

    @abstractmethod
    def phase(self, work: Work) -> Phase:
        """Return which page it is."""

    @abstractmethod
    def by_itself(self, work: Work) -> Draft | Answer | None:
        """Return the step that the volts ask for without anybody's word, or what is to be said."""

    @abstractmethod
    def can(self, work: Work) -> frozenset[str]:
        """Return the kinds of actions that it answers to now."""

    @abstractmethod
    def act(self, work: Work, action: Action) -> Draft | Answer:
        """Return what an action leads to; it is one of `can`."""

    @abstractmethod
    def show(self, work: Work, outcome: Outcome) -> Showing:
        """Return what is to be shown."""

    @abstractmethod
    def outcome(self, work: Work, stamp: datetime, air: GroundAir | None) -> Outcome:
        """Return what the work comes to, certificates stamped so."""

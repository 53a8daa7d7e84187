"""What a calibration has come to: a frozen state, and what each step makes of it.

The state follows from the steps of the journal alone. That is what lets a wizard that was killed
go on at the same point, and what makes undo a matter of the state before.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any, Literal

from calibration.inertial.accelerometers import POSITIONS, Position, PositionReading
from calibration.inertial.gyros import Turn
from calibration.inertial.straight_line import SensorVerdict
from calibration.plan import CalibrationPlan, InstrumentPlan
from calibration.points import CalibrationError, CalibrationPoint, Direction
from calibration.pressures import GroundAir
from calibration.rest_detection import RestPeriod
from calibration.wizard.journal import JournalStep

CalibrationMode = Literal["full", "check"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ScheduledSetting:
    """One setting to be taken."""

    value: float
    """In the unit of the plan."""
    direction: Direction
    """From which side it is to be reached; ``single`` where that does not matter."""
    is_turning_point: bool = False
    """Whether the side changes here: the setting has to be passed first and come back to."""


def build_schedule(
    instrument: InstrumentPlan, mode: CalibrationMode, *, any_side: bool = False
) -> tuple[ScheduledSetting, ...]:
    """Return the settings of an instrument: all of them up and down, or the check's three.

    Parameters
    ----------
    any_side : bool
        Whether a check may come to a setting from either side: where the certificate tells how
        far the branches are apart, none has to be passed first.
    """
    if mode == "check" and any_side:
        return tuple(
            ScheduledSetting(value=value, direction="single") for value in instrument.check_settings
        )
    if mode == "check":
        return _leg(instrument.check_settings, "up")
    return _leg(instrument.settings, "up") + _leg(instrument.settings[::-1], "down")


def _leg(values: tuple[float, ...], direction: Direction) -> tuple[ScheduledSetting, ...]:
    return tuple(
        ScheduledSetting(value=value, direction=direction, is_turning_point=index == 0)
        for index, value in enumerate(values)
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordedPoint:
    """A point that was taken."""

    value: float
    """Setting, in the unit of the plan."""
    volts: float
    """Mean, V."""
    direction: Direction
    """The side from which it was in truth reached; ``single`` where that was not seen."""
    slot: int
    """Which setting of the schedule it fills."""
    excitation: float | None
    """Supply, V."""
    std: float
    uncertainty: float
    """Of single samples and of the mean, V."""

    @property
    def point(self) -> CalibrationPoint:
        """Return it as the fit takes it."""
        return CalibrationPoint(
            volts=self.volts, value=self.value, direction=self.direction, noise=self.std
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class AngleProgress:
    """How far an instrument that is set by hand has come."""

    slots: tuple[ScheduledSetting, ...]
    """The schedule and what was added to it."""
    rising: bool | None = None
    """Whether volts rise towards positive values; None until that is proven."""
    points: tuple[RecordedPoint, ...] = ()
    """In the order taken."""
    left_out: frozenset[int] = frozenset()
    """Settings that are not asked for any more."""
    degree: int | None = None
    """Chosen by hand; None leaves it to the evidence."""

    @property
    def open_slot_indices(self) -> tuple[int, ...]:
        """Return the settings that are still to be taken, by their place in `slots`."""
        done = self.left_out | {taken.slot for taken in self.points}
        return tuple(at for at in range(len(self.slots)) if at not in done)

    @property
    def remaining(self) -> tuple[ScheduledSetting, ...]:
        return tuple(self.slots[at] for at in self.open_slot_indices)

    @property
    def fraction_done(self) -> float:
        return 1.0 - len(self.open_slot_indices) / len(self.slots)

    def apply(self, step: JournalStep) -> AngleProgress:
        """Return the work that a step leads to."""
        data = step.data
        match step.kind:
            case "sign":
                return replace(self, rising=bool(data["rising"]))
            case "point":
                taken = RecordedPoint(**{name: data[name] for name in RecordedPoint.__slots__})
                return replace(self, points=(*self.points, taken))
            case "repeat" | "delete":
                index = int(data["index"])
                gone = {self.points[index].slot} if step.kind == "delete" else set()
                points = self.points[:index] + self.points[index + 1 :]
                return replace(self, points=points, left_out=self.left_out | gone)
            case "leave_out":
                return replace(self, left_out=self.left_out | {int(data["slot"])})
            case "add":
                slot = ScheduledSetting(value=float(data["value"]), direction="single")
                return replace(self, slots=(*self.slots, slot))
            case "degree":
                return replace(self, degree=data["degree"])
        raise KeyError(step.kind)


@dataclass(frozen=True, slots=True, kw_only=True)
class RequestedTurn:
    """A turn of the turntable: about the axis of a gyro, through an angle in deg."""

    channel: str
    angle: float


@dataclass(frozen=True, slots=True, kw_only=True)
class GyroProgress:
    """How far the gyros have come."""

    requested_turns: tuple[RequestedTurn, ...]
    rest: RestPeriod | None = None
    """The still period that gives the zeros."""
    turns: tuple[tuple[int, Turn], ...] = ()
    """Which of `requested_turns` each is, and what it gave."""
    left_out: frozenset[int] = frozenset()
    """Turns that are not asked for any more."""
    unresponsive: frozenset[str] = frozenset()
    """Gyros that did not answer to a turn."""

    @property
    def open_turn_indices(self) -> tuple[int, ...]:
        """Return the turns that are still to be made, by their place in `requested_turns`."""
        done = self.left_out | {slot for slot, _ in self.turns}
        return tuple(
            index
            for index, asked in enumerate(self.requested_turns)
            if index not in done and asked.channel not in self.unresponsive
        )

    @property
    def fraction_done(self) -> float:
        steps = len(self.requested_turns) + 1
        return (steps - len(self.open_turn_indices) - (self.rest is None)) / steps

    def apply(self, step: JournalStep) -> GyroProgress:
        """Return the work that a step leads to."""
        if step.kind == "still":
            return replace(self, rest=RestPeriod(**step.data["rest"]))
        if step.kind == "turn":
            turn = (int(step.data["slot"]), _turn_from_json(step.data["turn"]))
            return replace(self, turns=(*self.turns, turn))
        if step.kind == "leave_out":
            return replace(self, left_out=self.left_out | {int(step.data["slot"])})
        if step.kind == "silent":
            return replace(self, unresponsive=self.unresponsive | {str(step.data["gyro"])})
        index = int(step.data["index"])
        slot, _ = self.turns[index]
        gone = self.left_out | {slot} if step.kind == "delete" else self.left_out
        return replace(self, turns=self.turns[:index] + self.turns[index + 1 :], left_out=gone)


@dataclass(frozen=True, slots=True, kw_only=True)
class AccelerometerProgress:
    """How far the accelerometers have come: the positions that were read."""

    readings: tuple[PositionReading, ...] = ()

    @property
    def open_positions(self) -> tuple[Position, ...]:
        done = {reading.position for reading in self.readings}
        return tuple(position for position in POSITIONS if position not in done)

    @property
    def fraction_done(self) -> float:
        return 1.0 - len(self.open_positions) / len(POSITIONS)

    def apply(self, step: JournalStep) -> AccelerometerProgress:
        """Return the work that a step leads to."""
        if step.kind == "position":
            reading = PositionReading(
                position=step.data["position"], rest=RestPeriod(**step.data["rest"])
            )
            return replace(self, readings=(*self.readings, reading))
        index = int(step.data["index"])
        return replace(self, readings=self.readings[:index] + self.readings[index + 1 :])


@dataclass(frozen=True, slots=True, kw_only=True)
class PressureProgress:
    """How far the pressures have come."""

    zero: RestPeriod | None = None
    """With the pitot covered."""
    in_wind: bool = False
    """Whether the pressure moved meanwhile, as in wind."""
    blow_detected: bool = False
    """Whether a breath was seen."""
    left_out: bool = False
    """Whether none is asked for."""

    @property
    def fraction_done(self) -> float:
        return 0.5 * (self.zero is not None) + 0.5 * (self.blow_detected or self.left_out)

    def apply(self, step: JournalStep) -> PressureProgress:
        """Return the work that a step leads to."""
        if step.kind == "zero":
            # Journals from before that was looked at say nothing of it.
            lull = bool(step.data.get("lull", False))
            return replace(self, zero=RestPeriod(**step.data["rest"]), in_wind=lull)
        if step.kind == "blow":
            return replace(self, blow_detected=True)
        if step.kind == "leave_out":
            return replace(self, left_out=True)
        return PressureProgress()


def _turn_from_json(content: Mapping[str, Any]) -> Turn:
    return Turn(**{**content, "verdict": SensorVerdict(**content["verdict"])})


GroupProgress = AngleProgress | GyroProgress | AccelerometerProgress | PressureProgress


@dataclass(frozen=True, slots=True, kw_only=True)
class InstrumentGroup:
    """Instruments that are calibrated together: a surface alone, or all gyros at once."""

    key: str
    """Channel of the first."""
    instruments: tuple[InstrumentPlan, ...]
    """All of one kind."""

    @property
    def channels(self) -> tuple[str, ...]:
        return tuple(one.channel for one in self.instruments)

    @property
    def title(self) -> str:
        if len(self.instruments) == 1:
            return self.instruments[0].title
        return {"gyro": "Gyros", "accelerometer": "Accelerometers", "pressure": "Pressures"}[
            self.instruments[0].kind
        ]


def group_instruments(plan: CalibrationPlan) -> tuple[InstrumentGroup, ...]:
    """Return the groups of a plan, each where its first instrument stands."""
    groups: dict[str, list[InstrumentPlan]] = {}
    for one in plan.instruments:
        groups.setdefault(one.channel if one.is_angle_sensor else one.kind, []).append(one)
    return tuple(
        InstrumentGroup(key=members[0].channel, instruments=tuple(members))
        for members in groups.values()
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class WizardState:
    """How far a calibration has come."""

    groups: tuple[InstrumentGroup, ...]
    progress: Mapping[str, GroupProgress]
    begun: bool = False
    """Whether the first group was reached."""
    current_key: str = ""
    """The group at hand; empty where none is."""
    closing_steps: Mapping[str, JournalStep] = field(default_factory=dict)
    """Groups that are done with: the step that accepted or skipped each."""
    ground_air: GroundAir | None = None
    """At the field, as entered."""
    aborted: bool = False
    """Whether the calibration was broken off."""

    @classmethod
    def initial(
        cls,
        plan: CalibrationPlan,
        mode: CalibrationMode,
        rising: Mapping[str, bool] = MappingProxyType({}),
        any_side: Collection[str] = (),
    ) -> WizardState:
        """Return the state before anything was done."""
        groups = group_instruments(plan)
        work = {
            group.key: _initial_progress(group, mode, rising, any_side=group.key in any_side)
            for group in groups
        }
        return cls(groups=groups, progress=work)

    @property
    def group(self) -> InstrumentGroup | None:
        return next((group for group in self.groups if group.key == self.current_key), None)

    @property
    def done(self) -> bool:
        """Return whether nothing is left to do."""
        return self.begun and not self.current_key and not self.aborted

    @property
    def ended(self) -> bool:
        """Return whether it is over, one way or the other."""
        return self.done or self.aborted

    @property
    def accepted(self) -> tuple[str, ...]:
        """Return the channels that were certified, or checked."""
        return tuple(
            name
            for step in self.closing_steps.values()
            if step.kind == "accept"
            for name in step.data["certified"]
        )

    @property
    def skipped(self) -> dict[str, str]:
        found: dict[str, str] = {}
        for step in self.closing_steps.values():
            found.update(step.data["uncalibrated"])
        return found

    def find_group(self, channel: str) -> InstrumentGroup:
        """Return the group that a channel belongs to."""
        for group in self.groups:
            if channel in group.channels:
                return group
        names = ", ".join(name for group in self.groups for name in group.channels)
        raise CalibrationError(f"the plan has no instrument '{channel}'; it has {names}")

    def apply(self, step: JournalStep) -> WizardState:
        """Return the state that a step leads to."""
        key = step.channel
        match step.kind:
            case "begin":
                return replace(self, begun=True).advance_from("")
            case "accept" | "skip":
                closings = {name: one for name, one in self.closing_steps.items() if name != key}
                return replace(self, closing_steps={**closings, key: step}).advance_from(key)
            case "open":
                return replace(self, begun=True, current_key=key)
            case "air":
                return replace(self, ground_air=GroundAir(**step.data))
            case "abort":
                return replace(self, aborted=True, current_key="")
        return replace(self, progress={**self.progress, key: self.progress[key].apply(step)})

    def advance_from(self, key: str) -> WizardState:
        """Return the state with the next open group after `current_key` at hand."""
        keys = [group.key for group in self.groups]
        at = keys.index(key) if key in keys else -1
        order = keys[at + 1 :] + keys[: at + 1]
        following = next((name for name in order if name not in self.closing_steps), "")
        return replace(self, current_key=following)


def _initial_progress(
    group: InstrumentGroup, mode: CalibrationMode, rising: Mapping[str, bool], *, any_side: bool
) -> GroupProgress:
    first = group.instruments[0]
    if first.kind == "gyro":
        asked = tuple(
            RequestedTurn(channel=one.channel, angle=sense * one.turn)
            for one in group.instruments
            if one.turn is not None
            for sense in (1.0, -1.0)
        )
        return GyroProgress(requested_turns=asked)
    if first.kind == "accelerometer":
        return AccelerometerProgress()
    if first.kind == "pressure":
        return PressureProgress()
    slots = build_schedule(first, mode, any_side=any_side)
    return AngleProgress(slots=slots, rising=rising.get(first.channel))

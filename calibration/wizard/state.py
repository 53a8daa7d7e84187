"""What a calibration has come to: a frozen state, and what each step makes of it.

The state follows from the steps of the journal alone. That is what lets a wizard that was killed
go on at the same point, and what makes undo a matter of the state before.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from calibration.plan import CalibrationPlan, InstrumentPlan
from calibration.points import CalibrationError
from calibration.pressures import GroundAir
from calibration.wizard.angle_progress import AngleProgress
from calibration.wizard.journal import JournalStep
from calibration.wizard.sensor_progress import (
    AccelerometerProgress,
    GyroProgress,
    PressureProgress,
    RequestedTurn,
)
from calibration.wizard.setting_schedule import CalibrationMode, build_schedule

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
        """Return the ids of its channels."""
        return tuple(one.channel for one in self.instruments)

    @property
    def title(self) -> str:
        """Return what the crew calls it."""
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
        """Return the state before anything was done.

        Parameters
        ----------
        mode : {"full", "check"}
            All settings, or three.
        rising : mapping of str to bool
            Signs that are known beforehand, by channel.
        any_side : collection of str
            Channels whose settings may be come to from either side in a check.
        """
        groups = group_instruments(plan)
        work = {
            group.key: _initial_progress(group, mode, rising, any_side=group.key in any_side)
            for group in groups
        }
        return cls(groups=groups, progress=work)

    @property
    def group(self) -> InstrumentGroup | None:
        """Return the group at hand."""
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
        """Return the channels that were left uncalibrated, and why."""
        found: dict[str, str] = {}
        for step in self.closing_steps.values():
            found.update(step.data["uncalibrated"])
        return found

    def find_group(self, channel: str) -> InstrumentGroup:
        """Return the group that a channel belongs to.

        Raises
        ------
        CalibrationError
            If the plan leaves it out.
        """
        for group in self.groups:
            if channel in group.channels:
                return group
        names = ", ".join(name for group in self.groups for name in group.channels)
        raise CalibrationError(f"the plan has no instrument '{channel}'; it has {names}")

    def apply(self, step: JournalStep) -> WizardState:
        """Return the state that a step leads to."""
        effect = _EFFECTS.get(step.kind)
        if effect is not None:
            return effect(self, step)
        work = self.progress[step.channel].apply(step)
        return replace(self, progress={**self.progress, step.channel: work})

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


def _begin(state: WizardState, _step: JournalStep) -> WizardState:
    return replace(state, begun=True).advance_from("")


def _close(state: WizardState, step: JournalStep) -> WizardState:
    closings = {name: one for name, one in state.closing_steps.items() if name != step.channel}
    return replace(state, closing_steps={**closings, step.channel: step}).advance_from(step.channel)


def _open(state: WizardState, step: JournalStep) -> WizardState:
    return replace(state, begun=True, current_key=step.channel)


def _air(state: WizardState, step: JournalStep) -> WizardState:
    return replace(state, ground_air=GroundAir(**step.data))


def _abort(state: WizardState, _step: JournalStep) -> WizardState:
    return replace(state, aborted=True, current_key="")


_EFFECTS: Mapping[str, Callable[[WizardState, JournalStep], WizardState]] = {
    "begin": _begin,
    "accept": _close,
    "skip": _close,
    "open": _open,
    "air": _air,
    "abort": _abort,
}

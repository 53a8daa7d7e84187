"""What a calibration has come to: a frozen state, and what each step makes of it.

The state follows from the steps of the journal alone. That is what lets a wizard that was killed
go on at the same point, and what makes undo a matter of the state before.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from calibration.fit import CalibrationError, CalibrationPoint, Direction
from calibration.plan import CalibrationPlan, InstrumentPlan
from calibration.wizard.journal import Step
from calibration.wizard.schedule import Mode, Slot, schedule


@dataclass(frozen=True, slots=True, kw_only=True)
class Taken:
    """A point that was taken.

    Attributes
    ----------
    value : float
        Setting, in the unit of the plan.
    volts : float
        Mean, V.
    direction : {"up", "down", "single"}
        The side from which it was in truth reached; ``single`` where that was not seen.
    slot : int
        Which setting of the schedule it fills.
    excitation : float or None
        Supply, V.
    std, uncertainty : float
        Of single samples and of the mean, V.
    """

    value: float
    volts: float
    direction: Direction
    slot: int
    excitation: float | None
    std: float
    uncertainty: float

    @property
    def point(self) -> CalibrationPoint:
        """Return it as the fit takes it."""
        return CalibrationPoint(volts=self.volts, value=self.value, direction=self.direction)


@dataclass(frozen=True, slots=True, kw_only=True)
class HandWork:
    """How far an instrument that is set by hand has come.

    Attributes
    ----------
    slots : tuple of Slot
        The schedule and what was added to it.
    rising : bool or None
        Whether volts rise towards positive values; None until that is proven.
    points : tuple of Taken
        In the order taken.
    left_out : frozenset of int
        Settings that are not asked for any more.
    degree : int or None
        Chosen by hand; None leaves it to the evidence.
    """

    slots: tuple[Slot, ...]
    rising: bool | None = None
    points: tuple[Taken, ...] = ()
    left_out: frozenset[int] = frozenset()
    degree: int | None = None

    @property
    def open_slots(self) -> tuple[int, ...]:
        """Return the settings that are still to be taken, by their place in `slots`."""
        done = self.left_out | {taken.slot for taken in self.points}
        return tuple(at for at in range(len(self.slots)) if at not in done)

    @property
    def remaining(self) -> tuple[Slot, ...]:
        """Return the settings that are still to be taken, the next one first."""
        return tuple(self.slots[at] for at in self.open_slots)


@dataclass(frozen=True, slots=True, kw_only=True)
class State:
    """How far a calibration has come.

    Attributes
    ----------
    plan : CalibrationPlan
        What is calibrated.
    mode : {"full", "check"}
        All settings, or the three-point check.
    begun : bool
        Whether the first instrument was reached.
    channel : str
        The instrument at hand; empty where none is.
    work : mapping of str to HandWork
        By channel.
    accepted : mapping of str to Step
        Instruments that are done: the step that accepted each.
    skipped : mapping of str to str
        Instruments that are left uncalibrated, and why.
    aborted : bool
        Whether the calibration was broken off.
    """

    plan: CalibrationPlan
    mode: Mode
    begun: bool = False
    channel: str = ""
    work: Mapping[str, HandWork] = field(default_factory=dict)
    accepted: Mapping[str, Step] = field(default_factory=dict)
    skipped: Mapping[str, str] = field(default_factory=dict)
    aborted: bool = False

    @classmethod
    def beginning(cls, plan: CalibrationPlan, mode: Mode) -> State:
        """Return the state before anything was done."""
        work = {
            one.channel: HandWork(slots=schedule(one, mode))
            for one in plan.instruments
            if one.by_hand
        }
        return cls(plan=plan, mode=mode, work=work)

    @property
    def instrument(self) -> InstrumentPlan | None:
        """Return the instrument at hand."""
        return self.plan[self.channel] if self.channel else None

    @property
    def closed(self) -> frozenset[str]:
        """Return the channels that are done with."""
        return frozenset(self.accepted) | frozenset(self.skipped)

    @property
    def done(self) -> bool:
        """Return whether nothing is left to do."""
        return self.begun and not self.channel and not self.aborted

    def after(self, step: Step) -> State:
        """Return the state that a step leads to.

        Raises
        ------
        CalibrationError
            If there is no such step.
        """
        try:
            effect = _EFFECTS[step.kind]
        except KeyError:
            raise CalibrationError(
                f"a step '{step.kind}' is not known; the journal was written by a newer program"
            ) from None
        return effect(self, step)

    def _with_work(self, channel: str, work: HandWork) -> State:
        return replace(self, work={**self.work, channel: work})

    def _closing(self, channel: str) -> State:
        """Return the state with the next open instrument at hand."""
        channels = self.plan.channels
        at = channels.index(channel) if channel in channels else -1
        order = channels[at + 1 :] + channels[: at + 1]
        following = next((name for name in order if name not in self.closed), "")
        return replace(self, channel=following)


def _begin(state: State, _step: Step) -> State:
    return replace(state, begun=True)._closing("")


def _sign(state: State, step: Step) -> State:
    work = replace(state.work[step.channel], rising=bool(step.data["rising"]))
    return state._with_work(step.channel, work)


def _point(state: State, step: Step) -> State:
    work = state.work[step.channel]
    taken = Taken(**{name: step.data[name] for name in Taken.__slots__})
    return state._with_work(step.channel, replace(work, points=(*work.points, taken)))


def _repeat(state: State, step: Step) -> State:
    return _without(state, step, left_out=False)


def _delete(state: State, step: Step) -> State:
    return _without(state, step, left_out=True)


def _without(state: State, step: Step, *, left_out: bool) -> State:
    work = state.work[step.channel]
    index = int(step.data["index"])
    slot = work.points[index].slot
    points = work.points[:index] + work.points[index + 1 :]
    gone = work.left_out | {slot} if left_out else work.left_out
    return state._with_work(step.channel, replace(work, points=points, left_out=gone))


def _leave_out(state: State, step: Step) -> State:
    work = state.work[step.channel]
    gone = work.left_out | {int(step.data["slot"])}
    return state._with_work(step.channel, replace(work, left_out=gone))


def _add(state: State, step: Step) -> State:
    work = state.work[step.channel]
    slot = Slot(value=float(step.data["value"]), direction="single")
    return state._with_work(step.channel, replace(work, slots=(*work.slots, slot)))


def _degree(state: State, step: Step) -> State:
    degree: Any = step.data["degree"]
    return state._with_work(step.channel, replace(state.work[step.channel], degree=degree))


def _accept(state: State, step: Step) -> State:
    skipped = {name: why for name, why in state.skipped.items() if name != step.channel}
    accepted = {**state.accepted, step.channel: step}
    return replace(state, accepted=accepted, skipped=skipped)._closing(step.channel)


def _skip(state: State, step: Step) -> State:
    accepted = {name: one for name, one in state.accepted.items() if name != step.channel}
    skipped = {**state.skipped, step.channel: str(step.data["reason"])}
    return replace(state, accepted=accepted, skipped=skipped)._closing(step.channel)


def _open(state: State, step: Step) -> State:
    return replace(state, begun=True, channel=step.channel)


def _abort(state: State, _step: Step) -> State:
    return replace(state, aborted=True, channel="")


_EFFECTS: Mapping[str, Callable[[State, Step], State]] = {
    "begin": _begin,
    "sign": _sign,
    "point": _point,
    "repeat": _repeat,
    "delete": _delete,
    "leave_out": _leave_out,
    "add": _add,
    "degree": _degree,
    "accept": _accept,
    "skip": _skip,
    "open": _open,
    "abort": _abort,
}

"""How far an instrument that is set by hand has come, and what each step makes of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from calibration.points import CalibrationPoint, Direction
from calibration.wizard.journal import JournalStep
from calibration.wizard.setting_schedule import ScheduledSetting


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
        """Return the settings that are still to be taken, the next one first."""
        return tuple(self.slots[at] for at in self.open_slot_indices)

    @property
    def fraction_done(self) -> float:
        """Return how much of it is done, 0 to 1."""
        return 1.0 - len(self.open_slot_indices) / len(self.slots)

    def apply(self, step: JournalStep) -> AngleProgress:
        """Return the work that a step leads to."""
        return _EFFECTS[step.kind](self, step)


def _sign(work: AngleProgress, step: JournalStep) -> AngleProgress:
    return replace(work, rising=bool(step.data["rising"]))


def _point(work: AngleProgress, step: JournalStep) -> AngleProgress:
    taken = RecordedPoint(**{name: step.data[name] for name in RecordedPoint.__slots__})
    return replace(work, points=(*work.points, taken))


def _repeat(work: AngleProgress, step: JournalStep) -> AngleProgress:
    index = int(step.data["index"])
    return replace(work, points=work.points[:index] + work.points[index + 1 :])


def _delete(work: AngleProgress, step: JournalStep) -> AngleProgress:
    slot = work.points[int(step.data["index"])].slot
    return replace(_repeat(work, step), left_out=work.left_out | {slot})


def _leave_out(work: AngleProgress, step: JournalStep) -> AngleProgress:
    return replace(work, left_out=work.left_out | {int(step.data["slot"])})


def _add(work: AngleProgress, step: JournalStep) -> AngleProgress:
    slot = ScheduledSetting(value=float(step.data["value"]), direction="single")
    return replace(work, slots=(*work.slots, slot))


def _degree(work: AngleProgress, step: JournalStep) -> AngleProgress:
    return replace(work, degree=step.data["degree"])


_EFFECTS: Mapping[str, Callable[[AngleProgress, JournalStep], AngleProgress]] = {
    "sign": _sign,
    "point": _point,
    "repeat": _repeat,
    "delete": _delete,
    "leave_out": _leave_out,
    "add": _add,
    "degree": _degree,
}

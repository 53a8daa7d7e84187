"""How far gyros, accelerometers and pressures have come, and what each step makes of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from calibration.inertial import POSITIONS, Position, PositionReading, SensorVerdict, Turn
from calibration.rest_detection import RestPeriod
from calibration.wizard.journal import JournalStep


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
            at
            for at, asked in enumerate(self.requested_turns)
            if at not in done and asked.channel not in self.unresponsive
        )

    @property
    def fraction_done(self) -> float:
        """Return how much of it is done, 0 to 1."""
        steps = len(self.requested_turns) + 1
        return (steps - len(self.open_turn_indices) - (self.rest is None)) / steps

    def apply(self, step: JournalStep) -> GyroProgress:
        """Return the work that a step leads to."""
        if step.kind == "still":
            return replace(self, rest=_rest_from_json(step.data["rest"]))
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
        """Return the positions that are still to be taken."""
        done = {reading.position for reading in self.readings}
        return tuple(position for position in POSITIONS if position not in done)

    @property
    def fraction_done(self) -> float:
        """Return how much of it is done, 0 to 1."""
        return 1.0 - len(self.open_positions) / len(POSITIONS)

    def apply(self, step: JournalStep) -> AccelerometerProgress:
        """Return the work that a step leads to."""
        if step.kind == "position":
            reading = PositionReading(
                position=step.data["position"], rest=_rest_from_json(step.data["rest"])
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
        """Return how much of it is done, 0 to 1."""
        return 0.5 * (self.zero is not None) + 0.5 * (self.blow_detected or self.left_out)

    def apply(self, step: JournalStep) -> PressureProgress:
        """Return the work that a step leads to."""
        if step.kind == "zero":
            # Journals from before that was looked at say nothing of it.
            lull = bool(step.data.get("lull", False))
            return replace(self, zero=_rest_from_json(step.data["rest"]), in_wind=lull)
        if step.kind == "blow":
            return replace(self, blow_detected=True)
        if step.kind == "leave_out":
            return replace(self, left_out=True)
        return PressureProgress()


def _rest_from_json(content: Mapping[str, Any]) -> RestPeriod:
    return RestPeriod(**content)


def _turn_from_json(content: Mapping[str, Any]) -> Turn:
    return Turn(**{**content, "verdict": SensorVerdict(**content["verdict"])})

"""The pilot's hands: sticks, stick inputs as a human makes them, and the lag of the hand."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from gsapp.virtual.flight_plan import (
    INPUT_SHAPES,
    ControlSurface,
    PilotLimits,
    PlannedManeuver,
)
from gsapp.virtual.pilot_perception import AircraftState


@dataclass(frozen=True, slots=True, kw_only=True)
class StickPositions:
    """What the transmitter sends."""

    pitch: float = 0.0
    roll: float = 0.0
    yaw: float = 0.0
    """-1 to 1 with the trim levers added; pulled, right, right are positive."""
    throttle: float = 0.0  # 0 idle to 1 full.
    flap: float = 0.0  # 0 up to 1, full travel.
    high_rate: bool = True  # The rate switch.
    brake: float = 0.0  # 0 to 1; the nose wheel turns with `yaw`.
    engines: bool = False  # Whether the engines run.


class StickSource(Protocol):
    """Whoever moves the sticks: the pilot of this package, a joystick, a keyboard."""

    @property
    def phase(self) -> str:
        """Name of what is being done, for the crew."""
        ...

    @property
    def finished(self) -> bool:
        """Whether the flight is over."""
        ...

    def move(self, situation: AircraftState) -> StickPositions:
        """Return the sticks at this moment; called once for every sample."""
        ...


class StickInput:
    """One maneuver as this human will fly it this time.

    Each step misses its size and its length a little, the two halves differ, the other axis of
    the same stick is taken along, and the stick does not come back quite to where it was.
    """

    def __init__(
        self, maneuver: PlannedManeuver, human: PilotLimits, random: np.random.Generator
    ) -> None:
        self._edges: dict[ControlSurface, tuple[tuple[float, ...], tuple[float, ...]]] = {}
        self.duration = 0.0
        self.high_rate = maneuver.rate == "high"
        whole = 1.0 + human.size_error * float(random.standard_normal())
        for number, (surface, size) in enumerate(zip(maneuver.inputs, maneuver.stick, strict=True)):
            time = number * maneuver.stagger * _random_factor(human.timing_error, random)
            starts, values = [time], []
            for unit in INPUT_SHAPES[maneuver.shape]:
                values.append(unit * size * whole * _random_factor(human.size_error, random))
                time += maneuver.step * _random_factor(human.timing_error, random)
                starts.append(time)
            values.append(human.residual * float(random.standard_normal()))
            self._edges[surface] = (tuple(starts), tuple(values))
            self.duration = max(self.duration, time)
        # Pitch and roll share one stick: a push to the side is never quite straight.
        self._slant = 0.04 * float(random.standard_normal())

    def at(self, time: float) -> Mapping[ControlSurface, float]:
        """Return the stick of each axis, `time` seconds after the input began."""
        sticks: dict[ControlSurface, float] = {"de": 0.0, "da": 0.0, "dr": 0.0}
        for surface, (starts, values) in self._edges.items():
            index = sum(time >= start for start in starts) - 1
            if index >= 0:
                sticks[surface] = values[index]
        pitch, roll = sticks["de"], sticks["da"]
        sticks["de"] += self._slant * roll
        sticks["da"] -= self._slant * pitch
        return sticks


def _random_factor(error: float, random: np.random.Generator) -> float:
    return max(0.4, 1.0 + error * float(random.standard_normal()))


class StickMotionModel:
    """One axis of one stick: second-order lag of the arm, and a hand that is never quite still.

    Parameters
    ----------
    human : PilotLimits
        `hand` is the whole lag, `residual` the size of the unrest.
    dt : float
        Time between two moves, s.
    """

    def __init__(self, human: PilotLimits, random: np.random.Generator, dt: float) -> None:
        # Two equal lags in series: their delays add up to that of the hand.
        self._share = 1.0 - math.exp(-dt / (0.5 * human.hand))
        self._random = random
        self._drift_decay = math.exp(-dt / 1.2)
        self._drift_drive = 0.5 * human.residual * math.sqrt(1.0 - self._drift_decay**2)
        self._drift = 0.5 * human.residual * float(random.standard_normal())
        self._arm = 0.0
        self._stick = 0.0

    def move(self, wanted: float, *, resting: bool = False) -> float:
        """Return where the stick is after one more sample; a released stick does not tremble."""
        self._drift = self._drift_decay * self._drift + self._drift_drive * float(
            self._random.standard_normal()
        )
        target = min(max(wanted, -1.0), 1.0)
        self._arm += self._share * (target - self._arm)
        self._stick += self._share * (self._arm - self._stick)
        unrest = 0.0 if resting else self._drift
        return min(max(self._stick + unrest, -1.0), 1.0)

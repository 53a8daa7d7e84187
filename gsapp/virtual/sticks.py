"""The sticks: inputs as a human makes them, the lag of the hand, and sticks moved by keys.

A pressed key pushes its stick to the chosen share of full travel, a released one lets the spring
center it again, both at the pace of a quick hand; so a doublet flown with keys has the edges that
one flown with a thumb has. Trim levers and the throttle are moved in clicks and stay.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final, Literal, Protocol

import numpy as np

from gsapp.foundation import FlightError
from gsapp.foundation.name_suggestions import did_you_mean
from gsapp.virtual.flight_plan import INPUT_SHAPES, ControlSurface, PilotLimits, PlannedManeuver
from gsapp.virtual.pilot_perception import AircraftState
from gsapp.virtual.settings import VIRTUAL


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

    @property
    def finished(self) -> bool:
        """Whether the flight is over."""

    def move(self, situation: AircraftState) -> StickPositions:
        """Return the sticks at this moment; called once for every sample."""


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
        for index, (surface, size) in enumerate(zip(maneuver.inputs, maneuver.stick, strict=True)):
            time = index * maneuver.stagger * _random_factor(human.timing_error, random)
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

    `human.hand` is the whole lag, `human.residual` the size of the unrest; `dt` the time between
    two moves, s.
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


StickAxis = Literal["pitch", "roll", "yaw"]
STICK_AXES: Final[tuple[StickAxis, ...]] = ("pitch", "roll", "yaw")


@dataclass(frozen=True, slots=True, kw_only=True)
class KeyPositions:
    """Where the keys push."""

    pitch: float = 0.0
    roll: float = 0.0
    yaw: float = 0.0
    """-1 to 1 of the chosen size; pulled, right, right are positive; 0 lets go."""
    throttle: float | None = None  # 0 idle to 1 full; None leaves the lever where it is.


class KeyboardSticks:
    """The transmitter in the trainee's hands, moved every `dt` s."""

    def __init__(self, dt: float) -> None:
        self._dt = dt
        self._keys = KeyPositions()
        self._trim: dict[StickAxis, float] = dict.fromkeys(STICK_AXES, 0.0)
        self._pushed: dict[StickAxis, float] = dict.fromkeys(STICK_AXES, 0.0)
        self._throttle = self._lever = 0.0
        self.key_travel = VIRTUAL.key_travel
        self.high_rate = True

    def reset(self, sticks: StickPositions, trim: tuple[float, float, float]) -> None:
        """Take the sticks as they are handed over; centered, they stand at `trim`."""
        self._trim = dict(zip(STICK_AXES, trim, strict=True))
        held = (sticks.pitch, sticks.roll, sticks.yaw)
        self._pushed = {
            axis: now - center for axis, now, center in zip(STICK_AXES, held, trim, strict=True)
        }
        self._keys = KeyPositions()
        self._throttle = self._lever = sticks.throttle
        self.high_rate = sticks.high_rate

    def set_keys(self, keys: KeyPositions) -> None:
        """Take where the keys push from now on; what lies beyond full stick is full stick."""
        self._keys = replace(
            keys, **{axis: _limit_travel(getattr(keys, axis), -1.0) for axis in STICK_AXES}
        )
        if keys.throttle is not None:
            self._throttle = _limit_travel(keys.throttle, 0.0)

    def step_lever(self, axis: str, by: float) -> None:
        """Move a trim lever, or the throttle, by a share of its travel; it stays there.

        Raise FlightError if there is no such lever.
        """
        if axis == "throttle":
            self._throttle = _limit_travel(self._throttle + by, 0.0)
        elif axis in STICK_AXES:
            self._trim[axis] = _limit_travel(self._trim[axis] + by, -1.0)
        else:
            known = (*STICK_AXES, "throttle")
            hint = did_you_mean(axis, known, f"choose one of {', '.join(known)}")
            raise FlightError(f"'{axis}' has no trim lever; {hint}")

    def set_key_travel(self, share: float) -> None:
        """Choose how far a key pushes: a share of full stick.

        Raise FlightError if it is more than full stick, or next to nothing.
        """
        if not VIRTUAL.min_key_travel <= share <= 1.0:
            raise FlightError(
                f"a key cannot push by {share:g} of full stick; choose "
                f"{VIRTUAL.min_key_travel:g} to 1"
            )
        self.key_travel = share

    def move(self) -> StickPositions:
        """Return where the sticks are after one more sample."""
        step = VIRTUAL.stick_rate * self._dt
        for axis in STICK_AXES:
            wanted = self.key_travel * getattr(self._keys, axis)
            self._pushed[axis] = step_toward(self._pushed[axis], wanted, step)
        self._lever = step_toward(self._lever, self._throttle, VIRTUAL.throttle_rate * self._dt)
        pitch, roll, yaw = (
            _limit_travel(self._trim[axis] + self._pushed[axis], -1.0) for axis in STICK_AXES
        )
        return StickPositions(
            pitch=pitch,
            roll=roll,
            yaw=yaw,
            throttle=self._lever,
            high_rate=self.high_rate,
            engines=True,
        )


def step_toward(now: float, wanted: float, step: float) -> float:
    """Return `now` moved toward what is wanted by at most `step`."""
    return now + min(max(wanted - now, -step), step)


def _limit_travel(value: float, low: float) -> float:
    if not math.isfinite(value):
        raise FlightError(f"'{value}' is not a stick position; give a number from {low:g} to 1")
    return min(max(value, low), 1.0)

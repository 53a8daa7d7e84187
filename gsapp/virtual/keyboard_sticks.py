"""Sticks that are moved by keys: a key is pressed or not, a stick takes its time.

A pressed key pushes its stick to the chosen share of full travel, a released one lets the spring
center it again, both at the pace of a quick hand; so a doublet flown with keys has the edges that
one flown with a thumb has. Trim levers and the throttle are moved in clicks and stay.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final, Literal

from gsapp.foundation import FlightError
from gsapp.foundation.name_suggestions import did_you_mean
from gsapp.virtual.settings import VIRTUAL
from gsapp.virtual.stick_motion import StickPositions

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
    """The transmitter in the trainee's hands.

    Parameters
    ----------
    dt : float
        Time between two moves, s.
    """

    def __init__(self, dt: float) -> None:
        self._dt = dt
        self._keys = KeyPositions()
        self._trim: dict[StickAxis, float] = dict.fromkeys(STICK_AXES, 0.0)
        self._pushed: dict[StickAxis, float] = dict.fromkeys(STICK_AXES, 0.0)
        self._throttle = self._lever = 0.0
        self.key_travel = VIRTUAL.key_travel
        self.high_rate = True

    def begin(self, sticks: StickPositions, trim: tuple[float, float, float]) -> None:
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

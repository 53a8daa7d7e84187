"""How the aircraft lies, and what its gyros and accelerometers are exposed to meanwhile."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping

import numpy as np

from calibration.inertial.accelerometers import Position, specific_force
from gsapp.foundation import FlightError
from gsapp.quantities import FloatArray
from gsapp.virtual.bench.operator_motion import AttitudeMovement, TableRotation
from gsapp.virtual.bench.transducers import GYROS
from gsapp.virtual.settings import VIRTUAL

TURN_POSITIONS: Mapping[str, Position] = {"p": "x_down", "q": "y_up", "r": "z_down"}
"""How the aircraft lies on the table to turn about each axis."""

Direction = tuple[float, float, float]


class BenchAttitude:
    """The aircraft between the hands that lay and turn it, one movement after the other.

    Parameters
    ----------
    hands : numpy.random.Generator
        How exactly they do it.
    """

    def __init__(self, hands: np.random.Generator) -> None:
        self._hands = hands
        self._up = _up_direction("z_down")
        self._motions: deque[AttitudeMovement | TableRotation] = deque()

    @property
    def up_direction(self) -> Direction:
        """Return the direction that points up once all movements are done, in body axes."""
        for motion in reversed(self._motions):
            if isinstance(motion, AttitudeMovement):
                return motion.target
        return self._up

    @property
    def busy(self) -> bool:
        """Return whether it is being moved."""
        return bool(self._motions)

    def move_to_position(self, position: Position, now: float) -> float:
        """Have it laid in a position; return when it will be, s."""
        up = _up_direction(position)
        leaning = self._hands.normal(0.0, math.radians(VIRTUAL.positioning_std), 3)
        direction = np.array(up) + np.where(np.abs(up) > 0.5, 0.0, leaning)
        direction /= np.linalg.norm(direction)
        laying = AttitudeMovement(
            begin=self._free_at(now),
            seconds=VIRTUAL.laying_time,
            start=self.up_direction,
            target=(float(direction[0]), float(direction[1]), float(direction[2])),
        )
        self._motions.append(laying)
        return laying.end

    def rotate(self, channel: str, angle: float, seconds: float | None, now: float) -> float:
        """Have it turned about the axis of a gyro; return when it will be, s.

        Raises
        ------
        FlightError
            If it is no axis, or the turn takes no time.
        """
        if channel not in GYROS:
            raise FlightError(f"'{channel}' is not a turn axis; choose p, q or r")
        if seconds is not None and not seconds > 0.0:
            raise FlightError(f"a turn cannot take {seconds:g} s; give more than 0 s")
        axis = GYROS.index(channel)
        if abs(self.up_direction[axis]) < 0.9:
            self.move_to_position(TURN_POSITIONS[channel], now)
        marks = float(self._hands.normal(0.0, VIRTUAL.table_turn_std * math.sqrt(2.0)))
        turning = TableRotation(
            begin=self._free_at(now) + VIRTUAL.rest_before_turn,
            seconds=seconds or max(abs(angle) / VIRTUAL.table_turn_rate, VIRTUAL.min_turn_time),
            angle=angle + marks,
            axis=axis,
            ripple=float(self._hands.uniform(-0.2, 0.2)),
        )
        self._motions.append(turning)
        return turning.end

    def motion(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return what happens at successive samples.

        Parameters
        ----------
        times : ndarray, shape (n,)
            s, after those of the call before.

        Returns
        -------
        force : ndarray, shape (n, 3)
            Specific force ax, ay, an, g.
        rates : ndarray, shape (n, 3)
            p, q, r, deg/s.
        """
        up = np.tile(self._up, (times.size, 1))
        rates = np.zeros((times.size, 3))
        while self._motions and times.size:
            motion = self._motions[0]
            # From its beginning on; after its end it stands still at what it has reached.
            after = times >= motion.begin
            if isinstance(motion, AttitudeMovement):
                ups, spins = motion.motion(times)
                up[after], rates[after] = ups[after], rates[after] + spins[after]
            else:
                sense = math.copysign(1.0, self._up[motion.axis])
                turning = sense * motion.rates(times)[:, None] * np.array(self._up)
                rates += np.where(after[:, None], turning, 0.0)
            if motion.end > times[-1]:
                break
            self._motions.popleft()
            if isinstance(motion, AttitudeMovement):
                self._up = motion.target
        return up * np.array([1.0, 1.0, -1.0]), rates

    def _free_at(self, now: float) -> float:
        return self._motions[-1].end if self._motions else now


def _up_direction(position: Position) -> Direction:
    force = specific_force(position)
    return force["ax"], force["ay"], -force["an"]

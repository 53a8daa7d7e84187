"""Sensors that lie: what one shows cannot be, given what all others show.

A vane that sticks, a pitot tube that is blocked and a gyro that is dead still have noise, so their
samples look alive. But they do not move when the motion that the others tell of must move them: in
gusts, where a free vane always moves, and in every turn and input. Gusts cannot feign that, nor can
they feign an airspeed that goes its own way by several times what they do to the vanes.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.excitation.dangers.frames import FRAME, Frame
from gsapp.excitation.dangers.motion import COLUMNS, Motion, Places, told_twice, without_line
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import DEGREE

_STRETCH: Final = 24
"""Frames that are compared: long enough for a turn to begin, short enough to tell in time."""
_EVERY: Final = 2
"""Frames from one comparison to the next."""
_PER_FRAME: Final = 5
"""Samples of each frame: means, which the engines' shaking does not pass."""
_SETTLED: Final = 1.0
"""Seconds in the air before a stretch begins."""

_MUST_MOVE: Final = {"V": 0.4, "alpha": 0.7 * DEGREE, "beta": 0.7 * DEGREE}
"""Standard deviation made by rates and accelerations, at which a sensor must have moved too."""
_STUCK: Final = 0.15
"""Of what it must; moving less is none. Gusts have been seen to hide two thirds of a motion."""
_RATE_MUST_MOVE: Final = 5.0 * DEGREE
_RATE_STUCK: Final = 0.08
_RATE_STILL: Final = 1.0 * DEGREE
"""rad/s; a gyro that moves more than this is not dead."""
_EXPLAINED: Final = 0.3
"""Share of the squared misses that may be left when a gyro is not believed, if it is to blame."""
_GUST_SHARES: Final = (0.5, 0.4)
"""Gusts along the path seen as shares of those across: v and w, after the straight line."""
_CALM: Final = 0.1
"""Misses of the airspeed in calm air, m/s."""
_LIE: Final = 5.0
"""An airspeed that misses so many times what gusts explain is wrong; 3.4 has been seen in gusts."""
_LEAST_LIE: Final = 0.8
"""m/s."""
_TIMES: Final = 2
"""Successive comparisons that must agree."""

_WORDS: Final = {
    "alpha": "does not move with the motion: stuck",
    "beta": "does not move with the motion: stuck",
    "V": "does not change with the motion: pitot blocked",
    "p": "does not follow the motion: dead",
    "q": "does not follow the motion: dead",
    "r": "does not follow the motion: dead",
}
_AGAINST: Final = "goes against the motion: pitot blocked or leaking"


class KinematicRoom:
    """Compares the last seconds, again and again.

    Parameters
    ----------
    aircraft : Aircraft or None
        Knows where the instruments sit.
    rate : float
        Hz.
    """

    def __init__(self, aircraft: Aircraft | None, rate: float) -> None:
        self._places = Places.of(aircraft)
        self._rows = max(1, round(FRAME * rate)) // _PER_FRAME
        self._dt = FRAME / _PER_FRAME
        self.restart()

    def restart(self) -> None:
        """Forget everything."""
        self._samples = np.full((_STRETCH * _PER_FRAME, len(COLUMNS)), np.nan)
        self._count = 0
        self._seen: dict[str, int] = {}
        self._found: dict[str, str] = {}

    def judge(self, frame: Frame, doubted: frozenset[str]) -> dict[str, str]:
        """Return the sensors that lie, and how, in words.

        Parameters
        ----------
        frame : Frame
        doubted : frozenset of str
            Sensors of which others say so already; nothing is compared with those.
        """
        if frame.rows.fresh:
            self.restart()
        self._samples[:-_PER_FRAME] = self._samples[_PER_FRAME:]
        self._samples[-_PER_FRAME:] = self._means(frame)
        self._count += 1
        if round(frame.time / FRAME) % _EVERY:
            return self._found
        long_enough = frame.aloft > _STRETCH * FRAME + _SETTLED
        if not long_enough or doubted & set(COLUMNS) or not np.isfinite(self._samples).all():
            self._seen, self._found = {}, {}
            return self._found
        now = self._compared()
        self._seen = {name: self._seen.get(name, 0) + 1 for name in now}
        self._found = {name: why for name, why in now.items() if self._seen[name] >= _TIMES}
        return self._found

    def _means(self, frame: Frame) -> FloatArray:
        rows = [frame.rows[name][: self._rows * _PER_FRAME] for name in COLUMNS]
        parts: FloatArray = np.stack(rows, axis=1).reshape(_PER_FRAME, -1, len(COLUMNS))
        return np.asarray(parts.mean(axis=1), dtype=np.float64)

    def _compared(self) -> dict[str, str]:
        motion = told_twice(self._samples, self._dt, self._places)
        dead = self._dead_gyro(motion)
        if dead:
            return {dead: _WORDS[dead]}
        found = {}
        for name, least in _MUST_MOVE.items():
            made = _spread(motion.made[name])
            if made > least and _spread(motion.shown[name]) < _STUCK * made:
                found[name] = _WORDS[name]
        if not found and self._speed_lies(motion):
            found["V"] = _AGAINST
        return found

    @staticmethod
    def _dead_gyro(motion: Motion) -> str:
        """Return the gyro that stands still while all else says that its axis turns."""
        best, least = "", _EXPLAINED
        for axis, name in enumerate("pqr"):
            shown = _spread(without_line(motion.rates[:, axis]))
            if shown > _RATE_STILL:
                continue
            rate, left = motion.rate_made(axis)
            made = _spread(without_line(rate))
            if made > _RATE_MUST_MOVE and shown < _RATE_STUCK * made and left < least:
                best, least = name, left
        return best

    @staticmethod
    def _speed_lies(motion: Motion) -> bool:
        along, across, down = np.sqrt(np.mean(motion.miss**2, axis=0))
        gusts = max(_GUST_SHARES[0] * across, _GUST_SHARES[1] * down, _CALM)
        if along < max(_LIE * gusts, _LEAST_LIE):
            return False
        # A gyro that misleads would do the same.
        return all(motion.rate_made(axis)[1] > _EXPLAINED for axis in range(3))


def _spread(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values * values)))

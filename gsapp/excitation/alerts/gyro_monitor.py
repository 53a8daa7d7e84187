"""Gyros against each other and against the attitude.

Two that measure one rate agree but for noise, zero and delay, so what grows between the angles that
they make is the fault of one of them. Angles are compared over a few seconds: engines shake single
samples, and a roll is over in one.
"""

from __future__ import annotations

import itertools
import math
from typing import Final

import numpy as np

from gsapp.excitation.alerts.row_frames import ALERT_FRAME_DURATION
from gsapp.excitation.flight_rows import FlightRows
from gsapp.quantities import FloatArray
from gsapp.quantities.constants import DEGREE

GYRO_AXES: Final = ("p", "q", "r")
_SOURCES: Final = ("", ".2", ".3", "attitude")
_MEMORY: Final = 3.0
"""Seconds over which angles are compared: a leaky sum."""
_DECAY: Final = math.exp(-ALERT_FRAME_DURATION / _MEMORY)
_APART: Final = 10.0 * DEGREE
"""Angles that differ so much are not the same motion: three times what zeros, scales and delays of
usual gyros make of a turn."""
_TURNING: Final = 10.0 * DEGREE
"""rad/s; a gyro once outvoted is believed again when it shows such rates as the others do ..."""
_ALIKE: Final = (3.0 * DEGREE, 0.15)
"""... to so much, rad/s, and such a share ..."""
_AGREED: Final = 4
"""... in so many frames one after the other in which it turns."""
_STEEP: Final = 75.0 * DEGREE
"""Beyond this pitch attitude Euler angles tell no rates."""


class GyroMonitor:
    """Lets all that measures one rate vote."""

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Forget everything."""
        self._apart: dict[tuple[str, int, int], float] = {}
        self._before: tuple[FloatArray, FloatArray] | None = None
        self._lost: dict[str, str] = {}
        self._agreed: dict[str, int] = {}

    def evaluate(self, rows: FlightRows) -> dict[str, str]:
        """Return the gyros that are outvoted, and by what, in words."""
        if rows.starts_segment:
            self._apart, self._before = {}, None
        angles = np.array([_angle(rows[name]) for name in ("phi", "theta", "psi")])
        rates = np.array(
            [[_mean(rows[f"{axis}{source}"]) for source in _SOURCES[:3]] for axis in GYRO_AXES]
        )
        before, self._before = self._before, (angles, rates)
        if before is None:
            return self._lost
        # The attitude tells the rates between the middles of two frames, and so must the gyros.
        made = _rates_from_attitude(before[0], angles)
        between = np.column_stack((0.5 * (before[1] + rates), made))
        for axis, values in zip(GYRO_AXES, between.tolist(), strict=True):
            outvoted = _find_outvoted(axis, self._against(axis, values))
            for name, why in outvoted.items():
                self._lost.setdefault(name, why)
                self._agreed[name] = 0
            for k, source in enumerate(_SOURCES[:3]):
                if (name := f"{axis}{source}") in self._lost and name not in outvoted:
                    self._confirm(name, values, k)
        return dict(self._lost)

    def _confirm(self, name: str, values: list[float], own: int) -> None:
        """Believe a gyro again once it turns as the others do."""
        others = [value for k, value in enumerate(values) if k != own and value == value]
        if not others or max(abs(value) for value in others) < _TURNING:
            return
        alike = all(
            abs(values[own] - value) < _ALIKE[0] + _ALIKE[1] * abs(value) for value in others
        )
        self._agreed[name] = self._agreed[name] + 1 if alike else 0
        if self._agreed[name] >= _AGREED:
            del self._lost[name]

    def _against(self, axis: str, rates: list[float]) -> dict[int, list[int]]:
        """Return who contradicts whom about one axis, by the place among all sources."""
        there = [k for k, rate in enumerate(rates) if rate == rate]
        against: dict[int, list[int]] = {k: [] for k in there}
        for i, j in itertools.combinations(there, 2):
            key = (axis, i, j)
            apart = (
                _DECAY * self._apart.get(key, 0.0) + (rates[i] - rates[j]) * ALERT_FRAME_DURATION
            )
            self._apart[key] = apart
            if abs(apart) > _APART:
                against[i].append(j)
                against[j].append(i)
        return against


def _rates_from_attitude(before: FloatArray, angles: FloatArray) -> FloatArray:
    """Return the body rates that turn one attitude into the next, NaN where they do not tell."""
    change = (angles - before + math.pi) % (2.0 * math.pi) - math.pi
    phi, theta, _ = before + 0.5 * change
    if not abs(theta) < _STEEP:
        return np.full(3, np.nan)
    a, b, c = change / ALERT_FRAME_DURATION
    sp, cp, ct = math.sin(phi), math.cos(phi), math.cos(theta)
    return np.array([a - c * math.sin(theta), b * cp + c * sp * ct, c * cp * ct - b * sp])


def _find_outvoted(axis: str, against: dict[int, list[int]]) -> dict[str, str]:
    found = {}
    for k, others in against.items():
        voters = [other for other in against if other != k]
        if k == 3 or not others or len(others) < len(voters):
            continue
        names = [
            "the attitude" if other == 3 else "its second" if other == 1 else "its third"
            for other in others
            if other > 0
        ]
        if len(voters) == 1 and k > 0:
            continue  # of two the first, which all else is computed from, is doubted
        if not names:
            names = ["the first"]
        found[f"{axis}{_SOURCES[k]}"] = f"contradicts {' and '.join(names)}"
    return found


def _mean(values: FloatArray) -> float:
    known = values[np.isfinite(values)]
    return float(known.mean()) if known.size else math.nan


def _angle(values: FloatArray) -> float:
    """Return the mean of an angle about its first sample, rad."""
    known = values[np.isfinite(values)]
    if not known.size:
        return math.nan
    apart = (known - known[0] + math.pi) % (2.0 * math.pi) - math.pi
    return float(known[0] + apart.mean())

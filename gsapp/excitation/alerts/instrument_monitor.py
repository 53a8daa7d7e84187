"""Instruments that die or lie in flight, and what that means for the flight.

Three judges, each sure of itself: signs of life (`signs`), votes of what measures one rate
(`gyros`), and the motion that rates and accelerations make (`kinematic`). Plausibility of single
values is the affair of `gsapp.session.limits`.
"""

from __future__ import annotations

import itertools
import math
from typing import Final

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.excitation.alerts.alert import INSTRUMENT_TITLES, Alert, caution, warning
from gsapp.excitation.alerts.kinematic_monitor import KinematicMonitor
from gsapp.excitation.alerts.row_frames import FlightFrame
from gsapp.excitation.alerts.sensor_monitors import SensorActivityMonitor
from gsapp.excitation.flight_rows import FlightRows
from gsapp.excitation.settings import ALERTS
from gsapp.flight.maneuvers.airborne_detection import AirborneDetector
from gsapp.flight.maneuvers.settings import DETECTION
from gsapp.flight.maneuvers.signals import SIGNAL_COLUMNS, SIGNALS
from gsapp.quantities import FloatArray

# Gyros against each other and against the attitude.
# Two that measure one rate agree but for noise, zero and delay, so what grows between the angles
# that they make is the fault of one of them. Angles are compared over a few seconds: engines shake
# single samples, and a roll is over in one.

GYRO_AXES: Final = ("p", "q", "r")
_SOURCES: Final = ("", ".2", ".3", "attitude")


_DECAY: Final = math.exp(-ALERTS.frame_duration / ALERTS.gyro_memory)


class GyroMonitor:
    """Lets all that measures one rate vote."""

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
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
        if not others or max(abs(value) for value in others) < ALERTS.min_turn_rate:
            return
        alike = all(
            abs(values[own] - value)
            < ALERTS.gyro_tolerance[0] + ALERTS.gyro_tolerance[1] * abs(value)
            for value in others
        )
        self._agreed[name] = self._agreed[name] + 1 if alike else 0
        if self._agreed[name] >= ALERTS.gyro_agreement_frames:
            del self._lost[name]

    def _against(self, axis: str, rates: list[float]) -> dict[int, list[int]]:
        """Return who contradicts whom about one axis, by the place among all sources."""
        there = [k for k, rate in enumerate(rates) if rate == rate]
        against: dict[int, list[int]] = {k: [] for k in there}
        for i, j in itertools.combinations(there, 2):
            key = (axis, i, j)
            apart = (
                _DECAY * self._apart.get(key, 0.0) + (rates[i] - rates[j]) * ALERTS.frame_duration
            )
            self._apart[key] = apart
            if abs(apart) > ALERTS.max_gyro_difference:
                against[i].append(j)
                against[j].append(i)
        return against


def _rates_from_attitude(before: FloatArray, angles: FloatArray) -> FloatArray:
    """Return the body rates that turn one attitude into the next, NaN where they do not tell."""
    change = (angles - before + math.pi) % (2.0 * math.pi) - math.pi
    phi, theta, _ = before + 0.5 * change
    if not abs(theta) < ALERTS.max_pitch:
        return np.full(3, np.nan)
    a, b, c = change / ALERTS.frame_duration
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


_PER_JUDGMENT: Final = round(DETECTION.frame_duration / ALERTS.frame_duration)


class FlightPhaseMonitor:
    """Follows one flight."""

    def __init__(self, aircraft: Aircraft) -> None:
        self._aircraft = aircraft
        self.restart()

    def restart(self) -> None:
        self._watch = AirborneDetector(self._aircraft)
        self._means: list[FloatArray] = []
        self._altitudes: list[float] = []
        self._standing: list[float] = []
        self._field = np.nan
        self._flown = 0.0

    def evaluate(self, rows: FlightRows, distrusted: frozenset[str]) -> FlightFrame:
        """Return a frame with the state of the flight.

        Channels may be distrusted: an airspeed that fell to nothing is no landing.
        """
        means = _means(rows.values[:, : len(SIGNALS)])
        for name in distrusted & SIGNAL_COLUMNS.keys():
            means[SIGNAL_COLUMNS[name]] = np.nan
        self._means.append(means)
        if len(self._means) == _PER_JUDGMENT:
            began = float(rows.times[0]) - (_PER_JUDGMENT - 1) * ALERTS.frame_duration
            self._watch.add(began, _means(np.array(self._means)))
            self._means = []
        airborne = self._watch.airborne
        if airborne:
            self._flown += ALERTS.frame_duration
        height = self._height(rows, float(means[SIGNAL_COLUMNS["altitude"]]), airborne=airborne)
        return FlightFrame(
            rows=rows,
            time_since_takeoff=float(rows.times[-1]) - self._watch.since if airborne else -1.0,
            time_airborne=self._flown,
            height=height,
            near_ground=height < ALERTS.landing_height,
        )

    def _height(self, rows: FlightRows, altitude: float, *, airborne: bool) -> float:
        """Return the height above the field, m; NaN before it has stood anywhere."""
        measured = rows["height"]
        known = measured[np.isfinite(measured)]
        if known.size:
            return float(known.mean())
        if not airborne and altitude == altitude:
            self._standing = [*self._standing[1 - ALERTS.field_altitude_frames :], altitude]
            self._field = float(np.median(self._standing))
        self._altitudes = [*self._altitudes[1 - ALERTS.altitude_frames :], altitude]
        return float(np.median(self._altitudes)) - self._field


def _means(values: FloatArray) -> FloatArray:
    """Return the mean of each column, NaN where it has no sample."""
    known = values == values
    counts = known.sum(axis=0)
    sums = np.where(known, values, 0.0).sum(axis=0)
    return np.where(counts > 0, sums / np.maximum(counts, 1), np.nan)


NOSE_SENSORS: Final = ("alpha", "beta", "V")
_DERIVED: Final = ("V", "Vc", "qbar", "dynamic_pressure")
"""Channels that fall with the airspeed."""

_MEANING: Final = {
    "alpha": "no test point by alpha, and no lift or pitching moment from this flight",
    "beta": "no side force, rolling or yawing moment from this flight",
    "V": "keep the speed up by eye",
    "p": "no aileron inputs",
    "q": "no elevator inputs",
    "r": "no rudder inputs",
}


class InstrumentMonitor:
    """Judges the instruments, and with those believed the phase of the flight.

    The aircraft knows ranges, noise, and where the instruments sit; the usual one (the same, unless
    that is None) how fast it must be to fly.
    """

    def __init__(self, aircraft: Aircraft | None, usual: Aircraft, rate: float) -> None:
        self._signs = SensorActivityMonitor(aircraft)
        self._gyros = GyroMonitor()
        self._motion = KinematicMonitor(aircraft, rate)
        self._phase = FlightPhaseMonitor(usual)
        self.restart()

    def restart(self) -> None:
        for part in (self._signs, self._gyros, self._motion, self._phase):
            part.restart()
        self._since: dict[str, int] = {}

    def evaluate(self, rows: FlightRows) -> tuple[FlightFrame, frozenset[str], list[Alert]]:
        """Return the frame with the state of the flight, what is not believed, and what to tell."""
        doubts = self._signs.evaluate(rows)
        for name, why in self._gyros.evaluate(rows).items():
            doubts.setdefault(name, why)
        frame = self._phase.evaluate(rows, frozenset(doubts))
        for name, why in self._motion.evaluate(frame, frozenset(doubts)).items():
            doubts.setdefault(name, why)
        self._since = {name: self._since.get(name, 0) + 1 for name in doubts}
        told = {
            name: why for name, why in doubts.items() if self._since[name] >= ALERTS.confirm_frames
        }
        findings = (
            _instrument_conditions(told) if frame.time_since_takeoff >= ALERTS.settling_time else []
        )
        return frame, frozenset(doubts), findings


def _instrument_conditions(doubts: dict[str, str]) -> list[Alert]:
    found = []
    if all(name in doubts for name in NOSE_SENSORS):
        text = "Nose sensors lost: alpha, beta and airspeed; land"
        nose = ("alpha", "beta", *_DERIVED)
        found.append(warning("nose", text, "nose sensors lost: land", channels=nose))
        doubts = {name: why for name, why in doubts.items() if name not in NOSE_SENSORS}
    for name, why in doubts.items():
        base = name.partition(".")[0]
        second = name != base
        title = INSTRUMENT_TITLES[base] + (f" {name.partition('.')[2]}" if second else "")
        meaning = "the first is used" if second else _MEANING[base]
        key = {"alpha": "alpha", "beta": "beta", "V": "airspeed"}.get(name, f"gyro.{name}")
        lost = _DERIVED if name == "V" else (name,)
        found.append(caution(key, f"The {title} {why}: {meaning}", f"{title} lost", channels=lost))
    return found

"""Signs of life: what a sensor's own samples tell, without any other.

A sensor that lives is never still: its noise, the converter's counts and the engines' shaking move
it from row to row. One that has stopped repeats itself; an open wire reads what no instrument can
show; a loose one does so now and then; and some fall silent.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from gsapp.aircraft import Aircraft
from gsapp.excitation.alerts.settings import ALERTS
from gsapp.excitation.flight_rows import FlightRows
from gsapp.flight.maneuvers.dead_instruments import clipping_ranges

MONITORED_SENSORS: Final = ("alpha", "beta", "V", "p", "q", "r")
_AIRSPEED: Final = ("dynamic_pressure", "qbar", "Vc", "V")
"""Where the airspeed comes from, the rawest first."""


@dataclass(slots=True)
class _SensorHistory:
    """What is remembered of one sensor."""

    unrest: deque[float] = field(default_factory=lambda: deque(maxlen=ALERTS.still_frames))
    waiting: deque[float] = field(default_factory=lambda: deque(maxlen=2 * ALERTS.still_frames))
    least: float = np.inf
    known: int = 0
    seen: bool = False
    silent: int = 0
    still: int = 0
    open: int = 0
    out: bool = False
    episodes: deque[float] = field(default_factory=lambda: deque(maxlen=8))
    fallen: int = 0
    before: float = np.nan


class SensorActivityMonitor:
    """Watches the samples of each sensor for themselves."""

    def __init__(self, aircraft: Aircraft | None) -> None:
        self._ranges: dict[str, tuple[float, float]] = {}
        self._noise: dict[str, float] = {}
        if aircraft is not None:
            sensors = aircraft.sensors
            ranges = clipping_ranges(aircraft)
            self._ranges = {name: ranges[name] for name in MONITORED_SENSORS if name in ranges}
            self._ranges["V"] = sensors.air_data.range
            self._noise = {
                **{name: one.noise for name, one in sensors.by_channel.items()},
                "V": sensors.air_data.noise,
            }
        self.restart()

    def restart(self) -> None:
        self._lives = {name: _SensorHistory() for name in MONITORED_SENSORS}
        self._airspeed = "V"

    def evaluate(self, rows: FlightRows) -> dict[str, str]:
        """Return the sensors without signs of life, and what each does, in words."""
        time = float(rows.times[-1])
        anything = bool(np.isfinite(rows["an"]).any() or np.isfinite(rows["ax"]).any())
        found = {}
        for name, life in self._lives.items():
            values = rows[self._source(rows) if name == "V" else name]
            known = values[np.isfinite(values)]
            if known.size:
                life.seen, life.silent = True, 0
                why = self._of_samples(name, life, known, time)
            else:
                life.silent += 1 if anything or self._others(rows, name) else 0
                why = "is silent" if life.seen and life.silent >= ALERTS.silent_frames else ""
            if name == "V" and not why:
                why = _airspeed_collapse(life, rows)
            if why:
                found[name] = why
        return found

    def _source(self, rows: FlightRows) -> str:
        """Return where the airspeed comes from; it stays so even when that falls silent."""
        if self._airspeed == "V":
            self._airspeed = next(
                (name for name in _AIRSPEED if np.isfinite(rows[name]).any()), "V"
            )
        return self._airspeed

    @staticmethod
    def _others(rows: FlightRows, name: str) -> bool:
        return any(np.isfinite(rows[other]).any() for other in MONITORED_SENSORS if other != name)

    def _of_samples(self, name: str, life: _SensorHistory, known: np.ndarray, time: float) -> str:
        reason = self._range_reason(name, life, known, time)
        if reason:
            return reason
        steps = np.diff(known)
        unrest = float(np.sqrt(np.mean(steps * steps))) if steps.size else 0.0
        life.unrest.append(unrest)
        if len(life.unrest) < ALERTS.still_frames:
            return ""
        most = max(life.unrest)
        noise = self._noise_of(name)
        if life.known >= ALERTS.learning_frames:
            usual = min(life.least, np.sqrt(2.0) * noise) if noise > 0.0 else life.least
            if (
                most
                < (ALERTS.min_activity if noise > 0.0 else ALERTS.min_activity_unknown_noise)
                * usual
            ):
                return "stands still"
        elif most == 0.0:
            life.still += 1
            return "has never moved" if life.still >= ALERTS.learning_frames else ""
        if most > 0.0:
            # What may be the beginning of the end is not yet learned from.
            life.waiting.append(most)
            if len(life.waiting) == life.waiting.maxlen:
                life.known += 1
                life.least = min(life.least, life.waiting[0])
        return ""

    def _noise_of(self, name: str) -> float:
        if name == "V" and self._airspeed not in ("dynamic_pressure", "qbar"):
            return 0.0
        return self._noise.get(name, 0.0)

    def _range_reason(self, name: str, life: _SensorHistory, known: np.ndarray, time: float) -> str:
        limits = self._ranges.get(name)
        if limits is None or (name == "V" and self._airspeed not in ("dynamic_pressure", "qbar")):
            return ""
        low, high = limits
        slack = ALERTS.range_excess * (high - low)
        beyond = (known < low - slack) | (known > high + slack)
        life.open = life.open + 1 if beyond.all() else 0
        out = bool(beyond.any())
        if out and not life.out:
            life.episodes.append(time)
        life.out = out
        if life.open >= ALERTS.open_frames:
            return "reads like an open wire"
        recent = [when for when in life.episodes if time - when < ALERTS.episode_memory]
        if len(recent) > 1 and time - recent[-1] < ALERTS.episode_hold:
            return "drops in and out like a loose wire"
        return "jumps out of its range" if out else ""


def _airspeed_collapse(life: _SensorHistory, rows: FlightRows) -> str:
    speeds = rows["V"][np.isfinite(rows["V"])]
    now = float(speeds.mean()) if speeds.size else np.nan
    if life.before - now > ALERTS.max_speed_drop:
        life.fallen = ALERTS.speed_drop_frames
    life.before = now
    life.fallen = max(life.fallen - 1, 0)
    return "has collapsed" if life.fallen else ""

"""Sensors at the end of their range, and signs of life: what a sensor's own samples tell.

The pilot is told, once for each event, which sensor clipped and what to do about it. What was
limited before it came to its end, in the converter or by a stop, shows as flat tops: the same
highest value again and again, which noise does not allow.

A sensor that lives is never still: its noise, the converter's counts and the engines' shaking move
it from row to row. One that has stopped repeats itself; an open wire reads what no instrument can
show; a loose one does so now and then; and some fall silent.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from typing import Final

import numpy as np
import numpy.typing as npt

from gsapp.aircraft import Aircraft
from gsapp.excitation.alerts.alert import INSTRUMENT_TITLES, Alert, caution
from gsapp.excitation.alerts.row_frames import FlightFrame
from gsapp.excitation.flight_rows import FlightRows
from gsapp.excitation.settings import ALERTS
from gsapp.flight.maneuvers.dead_instruments import clipping_ranges, is_at_range_limit
from gsapp.quantities import BoolArray, FloatArray

IndexArray = npt.NDArray[np.int64]

_SENSORS: Final = ("alpha", "beta", "p", "q", "r", "ax", "ay", "an")


class ClippingMonitor:
    """Detects gyro saturation, and that of vanes and accelerometers.

    Without an aircraft file only flat tops of the signal tell.
    """

    def __init__(self, aircraft: Aircraft | None, rate: float) -> None:
        self._ranges = {} if aircraft is None else clipping_ranges(aircraft)
        self._flat_rows = max(4, round(ALERTS.flat_time * rate))
        self.restart()

    def restart(self) -> None:
        count = len(_SENSORS)
        self._tails = np.full((self._flat_rows, count), np.nan)
        # Of the latest frames, the oldest first; NaN, and runs of -1, where there were none.
        self._changes = np.full((ALERTS.clipping_memory, count), np.nan)
        self._lows = np.full((ALERTS.clipping_memory, count), np.nan)
        self._highs = np.full((ALERTS.clipping_memory, count), np.nan)
        self._runs = np.full((ALERTS.clipping_memory, count), -1)
        self._samples = np.full((ALERTS.clipping_memory, count), -1)

    def evaluate(self, frame: FlightFrame, doubted: frozenset[str]) -> list[Alert]:
        """Return which sensors stand at an end of their range in this frame.

        Not those of which something worse is known.
        """
        values = np.column_stack([frame.rows[name] for name in _SENSORS])
        flat = self._flat_tops(values)
        if not _flies(frame):
            return []
        found = []
        for index, name in enumerate(_SENSORS):
            clipped = (
                name in self._ranges
                and _longest_run(is_at_range_limit(values[:, index], self._ranges[name]))
                >= ALERTS.min_clipped_samples
            )
            if (clipped or flat[index]) and name not in doubted:
                found.append(_clipping_condition(name))
        return found

    def _flat_tops(self, values: FloatArray) -> BoolArray:
        """Return of each sensor whether its highest or lowest value of late is held."""
        whole = np.asarray(np.isfinite(values).all(axis=0))
        line = np.concatenate((self._tails, values))
        self._tails = np.where(whole, line[-self._flat_rows :], np.nan)
        if not whole.any():
            return whole
        # A sensor that comes anew has no tail: what is not there is not still, nor an end.
        steps = np.abs(np.diff(line, axis=0))
        known = np.maximum(np.isfinite(steps).sum(axis=0), 1)
        change = np.sqrt(np.nansum(steps * steps, axis=0) / known)
        low, high = np.fmin.reduce(line, axis=0), np.fmax.reduce(line, axis=0)
        full = np.isfinite(self._changes[0])
        usual = np.where(full, np.median(self._changes, axis=0), 0.0)
        with np.errstate(invalid="ignore"):
            still = np.concatenate(
                (steps < ALERTS.flat_share * usual, np.zeros((1, len(usual)), dtype=bool))
            )
            bent = np.abs(np.diff(line, 2, axis=0))[-len(values) :] > ALERTS.min_bend * usual
        lowest = np.fmin(low, np.fmin.reduce(self._lows, axis=0))
        highest = np.fmax(high, np.fmax.reduce(self._highs, axis=0))
        for kept, newest in (
            (self._changes, change),
            (self._lows, low),
            (self._highs, high),
            (self._runs, _longest_runs(still)),
            (self._samples, bent.sum(axis=0)),
        ):
            kept[:-1, whole] = kept[1:, whole]
            kept[-1, whole] = newest[whole]
        out: BoolArray = (
            whole & (usual > 0.0) & (0.5 * (highest - lowest) >= ALERTS.min_flat_distance * usual)
        )
        if not out.any():
            return out
        slack = ALERTS.flat_share * usual
        with np.errstate(invalid="ignore"):
            at_end = (line >= highest - slack) | (line <= lowest + slack)
        # A slow link repeats itself everywhere, not at the ends only.
        heard = (self._runs >= 0).sum(axis=0)
        places = ALERTS.clipping_memory - 1 - heard // 10
        usual_run = np.sort(self._runs, axis=0)[places, np.arange(len(usual))]
        held = _longest_runs(still & at_end)
        samples = np.maximum(np.where(self._samples >= 0, self._samples, 0).sum(axis=0), 1)
        rows_each = heard * len(values) / samples
        least = np.maximum(2 * usual_run + 1, ALERTS.min_clipped_samples * rows_each)
        out &= held >= np.maximum(self._flat_rows - 1, least)
        return out


def _flies(frame: FlightFrame) -> bool:
    return frame.airborne and not frame.near_ground


def _longest_run(true: BoolArray) -> int:
    return int(_longest_runs(true[:, np.newaxis])[0]) if true.any() else 0


def _longest_runs(true: BoolArray) -> IndexArray:
    place = np.arange(len(true))[:, np.newaxis]
    last_false = np.maximum.accumulate(np.where(true, -1, place), axis=0)
    return np.asarray((place - last_false).max(axis=0))


def _clipping_condition(name: str) -> Alert:
    title = INSTRUMENT_TITLES[name]
    text = f"{title[0].upper()}{title[1:]} saturated: use a smaller input"
    return caution(f"clip.{name}", text, f"{title} clips")


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

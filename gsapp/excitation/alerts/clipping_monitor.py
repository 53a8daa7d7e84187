"""Sensors at the end of their range: what is cut off cannot be estimated from.

The marks of `gsapp.session.limits` belong to a chart whose value stands at the end of a range; here
the pilot is told, once for each event, which sensor it was and what to do about it. What was
limited before it came to its end, in the converter or by a stop, shows as flat tops: the same
highest value again and again, which noise does not allow.
"""

from __future__ import annotations

from typing import Final

import numpy as np
import numpy.typing as npt

from gsapp.aircraft import Aircraft
from gsapp.excitation.alerts.alert import INSTRUMENT_TITLES, AlertCondition, AlertLevel
from gsapp.excitation.alerts.row_frames import FlightFrame
from gsapp.excitation.alerts.settings import ALERTS
from gsapp.flight.maneuvers.dead_instruments import clipping_ranges, is_at_range_limit
from gsapp.quantities import BoolArray, FloatArray

IndexArray = npt.NDArray[np.int64]

_SENSORS: Final = ("alpha", "beta", "p", "q", "r", "ax", "ay", "an")


class ClippingMonitor:
    """Watches alpha, beta, rates and accelerations.

    Parameters
    ----------
    aircraft : Aircraft or None
        Knows the ranges; without it only flat tops tell.
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

    def evaluate(self, frame: FlightFrame, doubted: frozenset[str]) -> list[AlertCondition]:
        """Return which sensors stand at an end of their range in this frame.

        Parameters
        ----------
        doubted : frozenset of str
            Sensors of which something worse is known.
        """
        values = np.column_stack([frame.rows[name] for name in _SENSORS])
        flat = self._flat_tops(values)
        if not _flies(frame):
            return []
        found = []
        for place, name in enumerate(_SENSORS):
            clipped = (
                name in self._ranges
                and _longest_run(is_at_range_limit(values[:, place], self._ranges[name]))
                >= ALERTS.min_clipped_samples
            )
            if (clipped or flat[place]) and name not in doubted:
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


def _clipping_condition(name: str) -> AlertCondition:
    title = INSTRUMENT_TITLES[name]
    return AlertCondition(
        key=f"clip.{name}",
        level=AlertLevel.CAUTION,
        text=f"{title[0].upper()}{title[1:]} saturated: use a smaller input",
        spoken_text=f"{title} clips",
    )

"""Rows to ticks: means of what the trim cue looks at, without channels that are not to be believed.

What a channel does within a tick is noise and vibration to the cue, but for one thing: a channel
that does not do even that for two seconds in the air is stuck.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from gsapp.excitation.flight_rows import FlightRows
from gsapp.excitation.settings import TRIM
from gsapp.quantities import BoolArray, FloatArray, channel

TICK_CHANNELS: Final = (
    "p", "q", "r", "ax", "ay", "an", "alpha", "beta", "V", "phi", "theta",
    "altitude", "climb_rate", "height", "north", "east", "latitude", "longitude",
)  # fmt: skip
"""Columns of a tick."""
TICK_INDEX: Final = {name: place for place, name in enumerate(TICK_CHANNELS)}

_LOWEST: Final = np.array([channel(name).limits[0] for name in TICK_CHANNELS])
_HIGHEST: Final = np.array([channel(name).limits[1] for name in TICK_CHANNELS])


_SPARES: Final = {name: (f"{name}.2", f"{name}.3") for name in ("p", "q", "r")}


class TickMeans:
    """Averages rows over ticks, without the channels that others found not to be trusted."""

    def __init__(self, tick: int, dt: float) -> None:
        self._tick = tick
        self._longest = round(TRIM.stuck_time / dt)
        self.invalid_channels: frozenset[str] = frozenset()
        self.restart()

    def restart(self) -> None:
        self._last = np.full(TRIM.fast_channels, np.nan)
        self._same = np.zeros(TRIM.fast_channels, dtype=np.int64)

    def average_rows(self, rows: FlightRows) -> tuple[FloatArray, list[tuple[str, ...]]]:
        """Return the means of whole ticks, shape (n, len(TICK_CHANNELS)), and which were stuck."""
        tick, count = self._tick, len(rows) // self._tick
        values = self._read(rows)[: count * tick]
        still = self._still(values[:, : TRIM.fast_channels], count)
        shaped = values.reshape(count, tick, len(TICK_CHANNELS))
        # Beyond the limits of its channel an instrument is at fault.
        there = (shaped >= _LOWEST) & (shaped <= _HIGHEST)
        present = there.sum(axis=1)
        filled = np.where(there, shaped, 0.0)
        total = filled[:, 0]
        for place in range(1, tick):
            total = total + filled[:, place]
        means = np.where(present > 0, total / np.maximum(present, 1), np.nan)
        for name in self.invalid_channels & TICK_INDEX.keys():
            if name not in _SPARES:
                means[:, TICK_INDEX[name]] = np.nan
        if not still.any():
            return means, [()] * count
        means[:, : TRIM.fast_channels][still] = np.nan
        return means, [
            tuple(TICK_CHANNELS[place] for place in np.flatnonzero(one)) for one in still
        ]

    def _read(self, rows: FlightRows) -> FloatArray:
        """Return what is seen; of a rate the first sensor to be trusted that has a sample."""
        values = rows.columns(TICK_CHANNELS)
        for name, spares in _SPARES.items():
            index = TICK_INDEX[name]
            if name in self.invalid_channels:
                values[:, index] = np.nan
            for spare in spares:
                gone = np.isnan(values[:, index])
                if spare not in self.invalid_channels and gone.any():
                    values[gone, index] = rows[spare][gone]
        return values

    def _still(self, values: FloatArray, count: int) -> BoolArray:
        """Return which channels were stuck at the end of each tick, shape (count, quick)."""
        before = np.concatenate((self._last[np.newaxis], values[:-1]))
        unchanged = values == before
        unchanged[:, TICK_INDEX["V"]] &= values[:, TICK_INDEX["V"]] > TRIM.min_flow_speed
        same = unchanged.reshape(count, self._tick, TRIM.fast_channels).all(axis=1)
        if count:
            self._last = values[-1]
        stuck = np.zeros((count, TRIM.fast_channels), dtype=np.bool_)
        for place in range(count):
            self._same = np.where(same[place], self._same + 1, 0)
            stuck[place] = self._same >= self._longest
        return stuck

"""Samples as they come in, joined to rows that every watch of this package reads.

A cue is worth little half a second late. So a row waits only for the quick channels, those of
motion and surfaces, and for none of them longer than `CUES.max_channel_wait`. What comes slowly
(position, height, batteries) is read `CUES.slow_channel_delay` late instead: every row then finds
its value there, however the link was cut into pieces.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import takewhile
from typing import Final

import numpy as np
import numpy.typing as npt

from gsapp.excitation.settings import CUES
from gsapp.flight.maneuvers.signals import SIGNAL_COLUMNS, SIGNALS, extract_signals
from gsapp.quantities import Block, FloatArray

FAST_CHANNELS: Final = (
    "de", "da", "dr",
    "elevator_left", "elevator_right", "aileron_left", "aileron_right", "rudder",
    "de_command", "da_command", "dr_command",
    "p", "q", "r", "ax", "ay", "an", "alpha", "beta", "V", "Vc", "qbar", "dynamic_pressure",
    "phi", "theta", "psi", "p.2", "q.2", "r.2", "p.3", "q.3", "r.3",
)  # fmt: skip
"""Channels that a row waits for."""

SLOW_CHANNELS: Final = (
    "altitude", "height", "climb_rate", "static_pressure", "temperature", "density",
    "latitude", "longitude", "north", "east", "ground_speed", "track",
    "throttle", "throttle_left", "throttle_right", "rpm_left", "rpm_right", "flap", "fuel", "mass",
    "battery", "battery_receiver", "rc_rssi", "stick_pitch", "stick_roll", "stick_yaw",
    "rate_switch",
)  # fmt: skip
"""Channels that are read `CUES.slow_channel_delay` late."""


_CHANNELS: Final = (*FAST_CHANNELS, *SLOW_CHANNELS)
_CHANNEL_INDEX: Final = {name: place for place, name in enumerate(_CHANNELS)}
_COLUMNS: Final = {
    **{name: len(SIGNALS) + place for name, place in _CHANNEL_INDEX.items()},
    **SIGNAL_COLUMNS,
}
_CHANNEL_COLUMNS: Final = {
    name: {len(SIGNALS) + place, _COLUMNS[name]} for name, place in _CHANNEL_INDEX.items()
}
"""All columns of a channel: as measured, and as a signal with its stand-ins."""
_NOT_YET: Final = -(2**62)
"""Number of a row before all others: no sample came so far."""

IndexArray = npt.NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FlightRows:
    """Successive rows of the grid, without a gap between them."""

    first_index: int
    """Number of the first row: its time is ``first / rate``."""
    times: FloatArray
    """Shape (n,). Flight time, s."""
    values: FloatArray
    """Shape (n, ...). SI; read by name: ``rows["q"]``. The signals that maneuver detection looks at
    (`SIGNALS`: surfaces, flow, rates, accelerations, ``V``, ``altitude``, ``throttle``, ``rpm``)
    come with their stand-ins, all others as measured. NaN where missing."""
    starts_segment: bool = False
    """Whether a new stretch begins: what was watched before does not lead up to these rows."""

    def __len__(self) -> int:
        return int(self.times.size)

    def __getitem__(self, name: str) -> FloatArray:
        return self.values[:, _COLUMNS[name]]

    def columns(self, names: Sequence[str]) -> FloatArray:
        """Return some channels, shape (n, n_names)."""
        return self.values[:, [_COLUMNS[name] for name in names]]

    def mask_channels(self, names: Collection[str]) -> FlightRows:
        """Return the rows with some channels read as missing."""
        gone = [place for name in names for place in _CHANNEL_COLUMNS.get(name, ())]
        if not gone:
            return self
        values = self.values.copy()
        values[:, gone] = np.nan
        return replace(self, values=values)

    def slice_rows(self, start: int, stop: int) -> FlightRows:
        """Return the rows from `start` to before `stop`, counted from the first of these."""
        return FlightRows(
            first_index=self.first_index + start,
            times=self.times[start:stop],
            values=self.values[start:stop],
            starts_segment=self.starts_segment and start == 0,
        )


class FlightRowStream:
    """Joins blocks of some channels to rows, which come out in whole ticks of `tick` rows."""

    def __init__(self, rate: float) -> None:
        self.rate = rate
        self.tick = max(1, round(CUES.tick * rate))
        self._patience = max(1, round(CUES.max_channel_wait * rate))
        self._lag = round(CUES.slow_channel_delay * rate)
        self._longest = round(CUES.max_filled_pause * rate)
        self._known: dict[tuple[str, ...], tuple[list[int], list[int]]] = {}
        self.restart()

    def restart(self) -> None:
        self._first = _NOT_YET  # number of the next row to give
        self._began = 0  # number of the first row with a sample
        self._fresh = True
        self._rows = np.full((4 * self._longest, len(_CHANNELS)), np.nan)
        self._reached = np.full(len(FAST_CHANNELS), _NOT_YET, dtype=np.int64)
        self._newest = _NOT_YET

    def feed(self, block: Block) -> Iterator[FlightRows]:
        columns, places = self._places_of(block.channels)
        if not len(block) or not columns:
            return
        index = np.rint(block.times * self.rate).astype(np.int64)
        values = block.values[:, columns]
        if self._newest > _NOT_YET and index[-1] - self._newest <= self._longest:
            self._put(index, values, places)  # as ever: no pause is that long
            return
        cuts = (np.flatnonzero(np.diff(index) > self._longest) + 1).tolist()
        for start, stop in zip([0, *cuts], [*cuts, index.size], strict=True):
            if self._newest > _NOT_YET and index[start] - self._newest > self._longest:
                yield from self.finish()
            self._put(index[start:stop], values[start:stop], places)

    def take_complete_rows(self) -> Iterator[FlightRows]:
        """Give the rows that are complete after a step."""
        if self._newest < self._began + self._patience:
            return  # who speaks is not known yet
        speaking = self._reached[self._reached >= self._newest - self._patience]
        limit = int(speaking.min()) if speaking.size else self._newest - self._patience
        whole = (limit + 1 - self._first) // self.tick
        if whole > 0:
            yield self._take(whole * self.tick)

    def finish(self) -> Iterator[FlightRows]:
        """Give what is left: nothing more comes, or not for long."""
        if self._newest >= self._first > _NOT_YET:
            yield self._take(self._newest + 1 - self._first)
        self.restart()

    def _put(self, index: IndexArray, values: FloatArray, places: list[int]) -> None:
        """Lay samples in their rows; those of rows that were given already are left out."""
        if self._first == _NOT_YET:
            self._began = int(index[0])
            self._first = self._began // self.tick * self.tick
        kept = self._first - self._lag  # number of the row at the top of the buffer
        rows = index - kept
        fresh = rows >= 0
        if not fresh.all():
            rows, values, index = rows[fresh], values[fresh], index[fresh]
        if not rows.size:
            return
        if rows[-1] >= len(self._rows):
            grown = np.full((2 * int(rows[-1]) + 1, len(_CHANNELS)), np.nan)
            grown[: len(self._rows)] = self._rows
            self._rows = grown
        self._rows[rows[:, np.newaxis], places] = values
        last = int(index[-1])
        self._newest = max(self._newest, last)
        quick = [place for place in places if place < len(FAST_CHANNELS)]
        self._reached[quick] = np.maximum(self._reached[quick], last)

    def _take(self, count: int) -> FlightRows:
        """Give the next rows, and forget what no later row needs."""
        lag, size = self._lag, len(FAST_CHANNELS)
        taken = self._rows[lag : lag + count].copy()
        taken[:, size:] = self._rows[:count, size:]
        first = self._first
        times = np.arange(first, first + count) / self.rate
        block = Block.unchecked(_CHANNELS, times, taken)
        rows = FlightRows(
            first_index=first,
            times=times,
            values=np.column_stack((extract_signals(block), taken)),
            starts_segment=self._fresh,
        )
        left = max(lag, self._newest + 1 - first - count + lag)
        self._rows[:left] = self._rows[count : count + left]
        self._rows[left : left + count] = np.nan
        self._first += count
        self._fresh = False
        return rows

    def _places_of(self, channels: tuple[str, ...]) -> tuple[list[int], list[int]]:
        """Return columns of a block with these channels, and their places in a row."""
        known = self._known.get(channels)
        if known is None:
            pairs = [
                (k, _CHANNEL_INDEX[name])
                for k, name in enumerate(channels)
                if name in _CHANNEL_INDEX
            ]
            known = [column for column, _ in pairs], [place for _, place in pairs]
            self._known[channels] = known
        return known


def concatenate_rows(parts: Sequence[FlightRows]) -> FlightRows:
    """Return successive rows as one."""
    if len(parts) == 1:
        return parts[0]
    return replace(
        parts[0],
        times=np.concatenate([one.times for one in parts]),
        values=np.concatenate([one.values for one in parts]),
    )


def rows_from_block(block: Block, rate: float) -> FlightRows:
    """Return a whole block, without a pause of more than 5 s, as rows."""
    stream = FlightRowStream(rate)
    before = list(stream.feed(block))
    (rows,) = (*before, *stream.finish())
    return rows


def mask_implausible(block: Block) -> Block:
    """Return samples without those that no instrument can mean: as good as missing."""
    wild = np.abs(block.values) > CUES.max_value
    if not wild.any():
        return block
    return Block.unchecked(block.channels, block.times, np.where(wild, np.nan, block.values))


class RecentRows:
    """Keeps the newest rows of one stretch of flight."""

    def __init__(self) -> None:
        self._parts: deque[FlightRows] = deque()

    def clear(self) -> None:
        self._parts.clear()

    def add(self, rows: FlightRows) -> None:
        """Take in the next rows; a fresh stretch leaves nothing of what came before."""
        if rows.starts_segment:
            self._parts.clear()
        self._parts.append(rows)
        oldest = rows.times[-1] - CUES.rows_retention
        while self._parts[0].times[-1] < oldest:
            self._parts.popleft()

    def segment(self, start: float, stop: float) -> FlightRows | None:
        """Return the rows from one flight time to another (s), as far as they are kept."""
        parts = [one for one in self._parts if one.times[-1] >= start and one.times[0] <= stop]
        if not parts:
            return None
        found = concatenate_rows(parts)
        inside = np.flatnonzero((found.times >= start) & (found.times <= stop))
        if not inside.size:
            return None
        return found.slice_rows(int(inside[0]), int(inside[-1]) + 1)

    def mean(self, channel: str, seconds: float) -> float | None:
        """Return the mean of a channel over the newest seconds, SI; None where it is missing."""
        if not self._parts:
            return None
        since = self._parts[-1].times[-1] - seconds
        newest = takewhile(lambda one: one.times[-1] > since, reversed(self._parts))
        values = np.concatenate([one[channel] for one in newest])
        values = values[np.isfinite(values)]
        return float(values.mean()) if values.size else None

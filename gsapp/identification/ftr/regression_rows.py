"""Rows of the regressions: joined from channels, cut into blocks, known effects taken out.

Channels of one sample may come in several blocks, one after the other. A row is complete when every
channel that speaks has passed it, or when the newest sample lies `FTR_ALGORITHM.max_row_delay`
ahead of it at the end of a step; so what comes out does not depend on how the samples were cut into
blocks.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from gsapp.dynamics.model import Model
from gsapp.dynamics.terms import COEFFICIENTS as ALL
from gsapp.identification.axes import AXIS_COEFFICIENTS
from gsapp.identification.coefficients import reconstruct_coefficients
from gsapp.identification.ftr.channels import CHANNEL_INDEX, FTR_CHANNELS, FTRAxis
from gsapp.identification.ftr.settings import FTR_ALGORITHM
from gsapp.identification.ftr.state_file import ArrayTable, strip_prefix
from gsapp.identification.maneuver import Maneuver
from gsapp.quantities import Block, BoolArray, FloatArray


@dataclass(slots=True, kw_only=True)
class EstimationWindow:
    """A stretch of flight that is listened to."""

    start: float
    stop: float | None = None
    """From the origin of the grid, s; `stop` is None while the end is not known."""
    overrun: bool = False
    """Whether samples beyond the end were taken in before it was known."""

    def blocks(self, rate: float, block: int) -> tuple[int, int]:
        """Return the number of the first block of the window, and of the one after the last.

        `rate`: samples a second.
        `block`: samples of a block.
        """
        first = (math.ceil(self.start * rate - 1e-6) - 1) // block
        if self.stop is None:
            return first, 2**62
        return first, -(-math.floor(self.stop * rate + 1e-6) // block)

    def masked(self, first: int, rows: RegressionRows, rate: float, block: int) -> RegressionRows:
        """Return rows of whole blocks, from a number on, with what lies outside not valid."""
        count, length = rows.valid.shape
        places = (first + np.arange(count))[:, np.newaxis] * block + np.arange(length)
        times = places / rate
        inside = times >= self.start - 1e-9
        if self.stop is not None:
            inside &= times <= self.stop + 1e-9
        return RegressionRows(valid=rows.valid & inside, columns=rows.columns, running=rows.running)

    def state(self) -> npt.NDArray[np.generic]:
        stop = np.nan if self.stop is None else self.stop
        return np.array([self.start, stop, float(self.overrun)])

    @classmethod
    def from_state(cls, numbers: npt.NDArray[np.generic]) -> EstimationWindow | None:
        if not numbers.size:
            return None
        start, stop, over = (float(x) for x in np.asarray(numbers, dtype=np.float64))
        return cls(start=start, stop=None if np.isnan(stop) else stop, overrun=bool(over))


class BlockBuffer:
    """Ring buffer of the latest blocks, by number, so that a window may begin in the past."""

    def __init__(self, axes: Sequence[FTRAxis], length: int) -> None:
        self._axes = axes
        self._blocks: deque[tuple[int, dict[FTRAxis, RegressionRows]]] = deque(maxlen=length)

    def clear(self) -> None:
        """Forget all blocks."""
        self._blocks.clear()

    def append(self, first: int, blocks: int, rows: Mapping[FTRAxis, RegressionRows]) -> None:
        """Add the rows of whole blocks, the first of them with number `first`."""
        for k in range(blocks):
            self._blocks.append((first + k, {axis: one.part(k) for axis, one in rows.items()}))

    @property
    def oldest_if_full(self) -> int | None:
        """Number of the oldest block if older ones were dropped."""
        return self._blocks[0][0] if len(self._blocks) == self._blocks.maxlen else None

    def between(self, first: int, end: int) -> tuple[int, dict[FTRAxis, RegressionRows]] | None:
        """Return the blocks with ``first <= number < end``, and the first of their numbers."""
        inside = [(number, rows) for number, rows in self._blocks if first <= number < end]
        return (inside[0][0], self._joined([rows for _, rows in inside])) if inside else None

    def _joined(
        self, parts: Sequence[Mapping[FTRAxis, RegressionRows]]
    ) -> dict[FTRAxis, RegressionRows]:
        return {axis: RegressionRows.joined([rows[axis] for rows in parts]) for axis in self._axes}

    def state(self) -> tuple[npt.NDArray[np.generic], dict[str, ArrayTable]]:
        numbers = np.array([number for number, _ in self._blocks], dtype=np.int64)
        if not self._blocks:
            return numbers, {}
        whole = self._joined([rows for _, rows in self._blocks])
        return numbers, {f"ring.{axis}": rows.state() for axis, rows in whole.items()}

    def restore(self, numbers: npt.NDArray[np.generic], table: ArrayTable) -> None:
        self.clear()
        if not numbers.size:
            return
        rows = {
            axis: RegressionRows.from_state(strip_prefix(f"ring.{axis}", table))
            for axis in self._axes
        }
        for k, number in enumerate(np.asarray(numbers, dtype=np.int64).tolist()):
            self._blocks.append((number, {axis: one.part(k) for axis, one in rows.items()}))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RegressionRows:
    """What one axis needs of some consecutive samples."""

    valid: BoolArray
    """Shape (n,). Samples that count."""
    columns: FloatArray
    """Shape (n, p + 1 + 3 + 3 + 2). qbar x for every regressor; the three static parts; qbar; the
    three spun parts; what makes qbar x of a rate (qbar c/2V or qbar b/2V); the first of qbar x as
    the vane shows it, not moved to the CG. Zero where not valid."""
    running: BoolArray
    """Shape (n, 3). Equations all of whose instruments spoke of late."""

    def part(self, place: int) -> RegressionRows:
        """Return one of the blocks that the rows are cut into."""
        one = slice(place, place + 1)
        return RegressionRows(
            valid=self.valid[one], columns=self.columns[one], running=self.running[one]
        )

    def first_blocks(self, count: int) -> RegressionRows:
        """Return the first of the blocks that the rows are cut into."""
        few = slice(0, max(count, 0))
        return RegressionRows(
            valid=self.valid[few], columns=self.columns[few], running=self.running[few]
        )

    @staticmethod
    def joined(parts: Sequence[RegressionRows]) -> RegressionRows:
        """Return rows one after the other."""
        return RegressionRows(
            valid=np.concatenate([part.valid for part in parts]),
            columns=np.concatenate([part.columns for part in parts]),
            running=np.concatenate([part.running for part in parts]),
        )

    def state(self) -> dict[str, npt.NDArray[np.generic]]:
        return {"valid": self.valid, "columns": self.columns, "running": self.running}

    @staticmethod
    def from_state(state: Mapping[str, npt.NDArray[np.generic]]) -> RegressionRows:
        return RegressionRows(
            valid=np.array(state["valid"], dtype=bool),
            columns=np.array(state["columns"], dtype=np.float64),
            running=np.array(state["running"], dtype=bool),
        )


def split_into_blocks(
    rows: RegressionRows, before: RegressionRows | None, blocks: int, N: int
) -> RegressionRows:
    """Return rows as blocks of N + 1, each headed by the last row of the block before."""

    def shaped(array: npt.NDArray[np.generic], head: npt.NDArray[np.generic] | None) -> object:
        body = array.reshape(blocks, N, *array.shape[1:])
        out = np.zeros((blocks, N + 1, *array.shape[1:]), dtype=array.dtype)
        out[:, 1:] = body
        out[1:, 0] = body[:-1, -1]
        if head is not None:
            out[0, 0] = head[0]
        return out

    return RegressionRows(
        valid=np.asarray(shaped(rows.valid, None if before is None else before.valid)),
        columns=np.asarray(shaped(rows.columns, None if before is None else before.columns)),
        running=np.asarray(shaped(rows.running, None if before is None else before.running)),
    )


_EXTRA_COLUMNS = 9
"""Columns of `RegressionRows` behind the regressors: static parts, qbar, spun parts, two more."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class KnownEffects:
    """Coefficients that do not come from the derivatives, sample by sample."""

    coefficients: FloatArray
    """Shape (n, 6). `gsapp.dynamics.terms.COEFFICIENTS`, at the samples of the grid from its origin
    on."""

    def subtract_from(self, axis: FTRAxis, rows: RegressionRows, first: int) -> RegressionRows:
        """Return rows, from a sample of the grid on, with the known part out of their targets."""
        index = first + np.arange(len(rows.valid))
        inside = (index >= 0) & (index < len(self.coefficients))
        columns = rows.columns.copy()
        static = columns.shape[1] - _EXTRA_COLUMNS
        qbar = columns[inside, static + 3]
        for place, name in enumerate(AXIS_COEFFICIENTS[axis]):
            known = self.coefficients[index[inside], ALL.index(name)]
            columns[inside, static + place] -= qbar * known
        return replace(rows, columns=columns)


def compute_known_effects(maneuver: Maneuver, model: Model | None) -> KnownEffects | None:
    """Return what a model's effects give over a maneuver; None where it has none.

    `model`: without effects on instruments and control paths.

    Raises `FlightError` if the coefficients of the maneuver cannot be had at all.
    """
    if model is None or not model.effects:
        return None
    plain = reconstruct_coefficients(maneuver)
    left = reconstruct_coefficients(maneuver, model=model, cutoff=plain.smoother.cutoff)
    return KnownEffects(coefficients=plain.values - left.values)


IndexArray = npt.NDArray[np.int64]
_NO_INDEX = -(2**62)
# Not waited for once there is the density that follows from it.
_OPTIONAL_TO_WAIT = ("temperature",)


class _ContiguousRows:
    """Rows without a long pause between them."""

    def __init__(self, first: int, block: int) -> None:
        self.first = first  # grid index of the first row kept; begins a block
        self.newest = first - 1
        self.rows = np.full((4 * block, len(FTR_CHANNELS)), np.nan)
        self.before = np.full((1, len(FTR_CHANNELS)), np.nan)

    def put(self, index: IndexArray, values: FloatArray, places: list[int]) -> None:
        """Lay samples in their rows; those that come too late are left out."""
        rows = index - self.first
        self._make_room(int(rows[-1]) + 1)
        if rows[0] < 0:
            fresh = rows >= 0
            rows, values = rows[fresh], values[fresh]
        if rows.size:
            self.rows[rows[:, np.newaxis], places] = values
            self.newest = max(self.newest, int(index[-1]))

    def take(self, count: int, ahead: int) -> FloatArray:
        """Return the first rows, with the one before them and some ahead; forget them."""
        self._make_room(count + ahead)
        taken = np.concatenate((self.before, self.rows[: count + ahead]))
        self.before = taken[count : count + 1].copy()
        left = max(0, self.newest - self.first + 1 - count)
        self.rows[:left] = self.rows[count : count + left]
        self.rows[left : left + count] = np.nan
        self.first += count
        return taken

    @property
    def left(self) -> FloatArray:
        return self.rows[: max(0, self.newest - self.first + 1)]

    def _make_room(self, count: int) -> None:
        if count > len(self.rows):
            grown = np.full((2 * count, self.rows.shape[1]), np.nan)
            grown[: len(self.rows)] = self.rows
            self.rows = grown


class RowAssembler:
    """Collects samples until blocks of N rows are complete.

    Block ``b`` holds the samples ``b N + 1 .. (b + 1) N`` of the grid ``k / rate``.

    Parameters
    ----------
    rate : float
        Of the grid, Hz.
    block : int
        N.
    ahead : int
        Rows beyond each block that come with it, for channels that are recorded late.
    """

    def __init__(self, rate: float, block: int, ahead: int = 0) -> None:
        self._rate, self._block, self._ahead = rate, block, ahead
        self._patience = max(1, round(FTR_ALGORITHM.max_row_delay * rate))
        self._longest = round(FTR_ALGORITHM.max_filled_gap * rate)
        self.restart()

    def restart(self) -> None:
        self._stretches: list[_ContiguousRows] = []
        self._began = _NO_INDEX  # grid index of the first sample of all
        self._reached = np.full(len(FTR_CHANNELS), _NO_INDEX, dtype=np.int64)
        self._columns: dict[tuple[str, ...], tuple[list[int], list[int]]] = {}

    def feed(self, block: Block) -> None:
        columns, places = self._places_of(block.channels)
        if not len(block) or not columns:
            return
        index = np.rint(block.times * self._rate).astype(np.int64)
        values = block.values[:, columns]
        self._reached[places] = np.maximum(self._reached[places], index[-1])
        if self._began == _NO_INDEX:
            self._began = int(index[0])
        cuts = (np.flatnonzero(np.diff(index) > self._longest) + 1).tolist()
        for start, stop in zip([0, *cuts], [*cuts, index.size], strict=True):
            stretch = self._stretch_for(int(index[start]))
            stretch.put(index[start:stop], values[start:stop], places)

    def take_complete_blocks(self) -> list[tuple[int, FloatArray]]:
        """Return the blocks that are complete after a step.

        Number of the first block, and rows of shape (1 + U N + ahead, len(FTR_CHANNELS)): one
        before, the blocks', and those ahead.
        """
        newest = int(self._reached.max())
        if newest < self._began + self._patience:
            return []
        found = [self._rest(one) for one in self._stretches[:-1]]
        del self._stretches[:-1]
        speaking = self._reached > _NO_INDEX
        if speaking[CHANNEL_INDEX["density"]]:
            speaking[[CHANNEL_INDEX[name] for name in _OPTIONAL_TO_WAIT]] = False
        slowest = int(self._reached[speaking].min()) if speaking.any() else newest
        limit = max(slowest, newest - self._patience)
        stretch = self._stretches[-1]
        blocks = (limit - self._ahead - stretch.first + 1) // self._block
        if blocks > 0:
            found.append(self._take(stretch, blocks))
        return [one for one in found if one is not None]

    def flush(self) -> list[tuple[int, FloatArray]]:
        """Return what is left as blocks, the last one filled up with missing rows."""
        found = [self._rest(one) for one in self._stretches]
        return [one for one in found if one is not None]

    def _rest(self, stretch: _ContiguousRows) -> tuple[int, FloatArray] | None:
        blocks = -(-len(stretch.left) // self._block)
        return self._take(stretch, blocks) if blocks else None

    def _take(self, stretch: _ContiguousRows, blocks: int) -> tuple[int, FloatArray]:
        number = (stretch.first - 1) // self._block
        return number, stretch.take(blocks * self._block, self._ahead)

    def _stretch_for(self, index: int) -> _ContiguousRows:
        for stretch in reversed(self._stretches):
            if index >= stretch.first:
                if index - stretch.newest <= self._longest:
                    return stretch
                break
        else:
            if self._stretches:
                return self._stretches[0]  # where it will be found too late
        head = (index - 1) // self._block * self._block + 1
        self._stretches.append(_ContiguousRows(head, self._block))
        return self._stretches[-1]

    def _places_of(self, channels: tuple[str, ...]) -> tuple[list[int], list[int]]:
        """Return columns of a block with these channels, and their places in a row."""
        known = self._columns.get(channels)
        if known is None:
            pairs = [
                (k, CHANNEL_INDEX[name]) for k, name in enumerate(channels) if name in CHANNEL_INDEX
            ]
            known = [column for column, _ in pairs], [place for _, place in pairs]
            self._columns[channels] = known
        return known

    # --- saved state ----------------------------------------------------------------------------

    def state(self) -> dict[str, npt.NDArray[np.generic]]:
        """Return the state for `restore`; call it after `take_complete_blocks`."""
        table: dict[str, npt.NDArray[np.generic]] = {
            "began": np.array(self._began),
            "reached": self._reached,
            "firsts": np.array([one.first for one in self._stretches], dtype=np.int64),
        }
        for k, one in enumerate(self._stretches):
            table[f"rows{k}"], table[f"before{k}"] = one.left, one.before
        return table

    def restore(self, state: Mapping[str, npt.NDArray[np.generic]]) -> None:
        self.restart()
        self._began = int(state["began"])
        self._reached = np.array(state["reached"], dtype=np.int64)
        for k, first in enumerate(np.asarray(state["firsts"], dtype=np.int64).tolist()):
            stretch = _ContiguousRows(first, self._block)
            rows = np.asarray(state[f"rows{k}"], dtype=np.float64)
            if len(rows):
                every = list(range(len(FTR_CHANNELS)))
                stretch.put(first + np.arange(len(rows)), rows, every)
            stretch.before = np.array(state[f"before{k}"], dtype=np.float64)
            self._stretches.append(stretch)

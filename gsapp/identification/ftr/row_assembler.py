"""Blocks of some channels, joined to rows of all channels in fixed blocks of the grid.

Channels of one sample may come in several blocks, one after the other. A row is complete when every
channel that speaks has passed it, or when the newest sample lies `FTR_ALGORITHM.max_row_delay`
ahead of it at the end of a step; so what comes out does not depend on how the samples were cut into
blocks.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from gsapp.identification.ftr.channels import CHANNEL_INDEX, FTR_CHANNELS
from gsapp.identification.ftr.settings import FTR_ALGORITHM
from gsapp.quantities import Block, FloatArray

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

        Returns
        -------
        list of (int, ndarray)
            Number of the first block, and rows of shape (1 + U N + ahead, len(NEEDED_CHANNELS)):
            one before, the blocks', and those ahead.
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

"""Blocks of some channels, joined to rows of all channels in fixed blocks of the grid.

Channels of one sample may come in several blocks, one after the other. A row is complete when
every channel that speaks has passed it, or when the newest sample lies `PATIENCE` ahead of it;
so what comes out does not depend on how the samples were cut into blocks.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from gsapp.identification.ftr.equations import NEEDED_CHANNELS
from gsapp.quantities import Block, FloatArray

PATIENCE = 1.0
"""Seconds that a row waits for a channel that is late or has fallen silent."""
LONGEST_FILL = 60.0
"""Seconds of a pause that are filled with missing rows; a longer one is jumped over."""

_NOT_YET = -(2**62)
# Not waited for once there is the density that follows from them.
_SPARED = ("static_pressure", "temperature")
_PLACE = {name: place for place, name in enumerate(NEEDED_CHANNELS)}


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
        self._patience = max(1, round(PATIENCE * rate))
        self._longest = round(LONGEST_FILL * rate)
        self.restart()

    def restart(self) -> None:
        """Forget all samples."""
        self._first = 0  # grid index of the first row kept
        self._began = _NOT_YET  # grid index of the first sample of all
        self._rows = np.full((4 * self._block, len(NEEDED_CHANNELS)), np.nan)
        self._reached = np.full(len(NEEDED_CHANNELS), _NOT_YET, dtype=np.int64)
        self._newest = _NOT_YET
        self._before = np.full((1, len(NEEDED_CHANNELS)), np.nan)
        self._columns: dict[tuple[str, ...], tuple[list[int], list[int]]] = {}

    def feed(self, block: Block) -> list[tuple[int, FloatArray]]:
        """Take in samples, and return the blocks that are complete now.

        Samples that come later than `PATIENCE` are left out.

        Returns
        -------
        list of (int, ndarray)
            Number of the first block, and rows of shape (1 + U N + ahead, len(NEEDED_CHANNELS)):
            one before, the blocks', and those ahead.
        """
        columns, places = self._places_of(block.channels)
        if not len(block) or not columns:
            return []
        index = np.rint(block.times * self._rate).astype(np.int64)
        values = block.values[:, columns]
        cuts = (np.flatnonzero(np.diff(index) > self._longest) + 1).tolist()
        found: list[tuple[int, FloatArray]] = []
        for start, stop in zip([0, *cuts], [*cuts, index.size], strict=True):
            if self._began == _NOT_YET:
                self._began = int(index[start])
                self._first = self._head(self._began)
            elif int(index[start]) - self._newest > self._longest:
                found += self.flush()
                self._before[:] = np.nan
                self._first = self._head(int(index[start]))
            self._put(index[start:stop], values[start:stop], places)
            found += self._complete()
        return found

    def flush(self) -> list[tuple[int, FloatArray]]:
        """Return what is left as blocks, the last one filled up with missing rows."""
        if self._began == _NOT_YET or self._newest < self._first:
            return []
        return self._take(-(-(self._newest - self._first + 1) // self._block))

    def _head(self, index: int) -> int:
        """Return the first index of the block that holds a sample."""
        return (index - 1) // self._block * self._block + 1

    def _places_of(self, channels: tuple[str, ...]) -> tuple[list[int], list[int]]:
        """Return columns of a block with these channels, and their places in a row."""
        known = self._columns.get(channels)
        if known is None:
            pairs = [(k, _PLACE[name]) for k, name in enumerate(channels) if name in _PLACE]
            known = [column for column, _ in pairs], [place for _, place in pairs]
            self._columns[channels] = known
        return known

    def _put(self, index: npt.NDArray[np.int64], values: FloatArray, places: list[int]) -> None:
        rows = index - self._first
        last = int(rows[-1])
        if last >= len(self._rows):
            size = -(-(2 * last + 2) // self._block) * self._block
            grown = np.full((size, self._rows.shape[1]), np.nan)
            grown[: len(self._rows)] = self._rows
            self._rows = grown
        fresh = rows >= 0
        if not fresh.all():
            rows, values = rows[fresh], values[fresh]
        if not rows.size:
            return
        self._rows[rows[:, np.newaxis], places] = values
        newest = int(index[-1])
        self._reached[places] = np.maximum(self._reached[places], newest)
        self._newest = max(self._newest, newest)

    def _complete(self) -> list[tuple[int, FloatArray]]:
        if self._newest < self._began + self._patience:
            return []
        speaking = self._reached > _NOT_YET
        if speaking[_PLACE["density"]]:
            speaking[[_PLACE[name] for name in _SPARED]] = False
        reached = int(self._reached[speaking].min()) if speaking.any() else self._newest
        limit = max(reached, self._newest - self._patience)
        return self._take((limit - self._ahead - self._first + 1) // self._block)

    def _take(self, blocks: int) -> list[tuple[int, FloatArray]]:
        if blocks <= 0:
            return []
        count = blocks * self._block
        need = count + self._ahead
        if need > len(self._rows):
            missing = np.full((need - len(self._rows), self._rows.shape[1]), np.nan)
            self._rows = np.concatenate((self._rows, missing))
        taken = np.concatenate((self._before, self._rows[:need]))
        self._before = taken[count : count + 1].copy()
        number = (self._first - 1) // self._block
        left = max(0, self._newest - self._first + 1 - count)
        self._rows[:left] = self._rows[count : count + left]
        self._rows[left : left + count] = np.nan
        self._first += count
        return [(number, taken)]

    # --- saved state ----------------------------------------------------------------------------

    def state(self) -> dict[str, npt.NDArray[np.generic]]:
        """Return all that is remembered, for `restore`."""
        left = max(0, self._newest - self._first + 1)
        return {
            "first": np.array(self._first),
            "began": np.array(self._began),
            "newest": np.array(self._newest),
            "reached": self._reached,
            "rows": self._rows[:left],
            "before": self._before,
        }

    def restore(self, state: Mapping[str, npt.NDArray[np.generic]]) -> None:
        """Go on from what `state` gave."""
        self.restart()
        self._first, self._began = int(state["first"]), int(state["began"])
        self._newest = int(state["newest"])
        self._reached = np.array(state["reached"], dtype=np.int64)
        self._before = np.array(state["before"], dtype=np.float64)
        rows = np.array(state["rows"], dtype=np.float64)
        size = max(4, -(-(2 * len(rows) + 2) // self._block)) * self._block
        self._rows = np.full((size, len(NEEDED_CHANNELS)), np.nan)
        self._rows[: len(rows)] = rows

"""What the regressions of one axis need of consecutive samples."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from gsapp.identification.ftr.channels import FTRAxis
from gsapp.identification.ftr.state_file import ArrayTable, strip_prefix
from gsapp.quantities import BoolArray, FloatArray


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

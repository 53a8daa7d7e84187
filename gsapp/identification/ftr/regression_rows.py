"""What the regressions of one axis need of consecutive samples."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from gsapp.quantities import BoolArray, FloatArray


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
        """Return the arrays by name."""
        return {"valid": self.valid, "columns": self.columns, "running": self.running}

    @staticmethod
    def from_state(state: Mapping[str, npt.NDArray[np.generic]]) -> RegressionRows:
        """Return what `state` was made from."""
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
